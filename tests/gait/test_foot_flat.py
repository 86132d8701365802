"""Walks whose foot, landed on its heel, comes to lie flat by a second impact inside the step."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import check_jacobian, relative_error
from tied_bipeds import tied

from gaitopt.contact import HeelLine, Phase, PhaseEnd, Schedule
from gaitopt.design.audit import audit
from gaitopt.design.certificate import ask_referee
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.sensitivity import sensitivities
from gaitopt.design.summary import summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.grid import proof_grid
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.impact import FlatImpact
from gaitopt.motions.export import cubic_pieces, stride_record, stride_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.tolerances import REFEREE

IMPACT = {"heel_strike": 0.2, "foot_flat": "impact", "duration": 0.5}


def point(robot, **changes):
    problem = WalkProblem(robot, preset_task(**IMPACT, **changes))
    return problem, perturbed(problem, first_guess(problem), 0.02, 3)


@pytest.fixture(scope="module")
def both(robot):
    """A guess that lands on its heel and leaves from its toe, disturbed."""
    return point(robot, toe_off=0.65)


@pytest.fixture(scope="module")
def gait(both):
    return gait_at(*both, {})


@pytest.fixture(scope="module")
def found(robot):
    return design(robot, preset_task(**IMPACT), DesignOptions(diagnose=False))


def flat_of(problem, x):
    flat = problem.step(x).flat
    model, q = problem.robot.model, pin.neutral(problem.robot.model)
    q[7:] = flat.posture
    return flat, model, q


def test_the_impact_is_pinocchios_and_takes_energy(both):
    flat, model, q = flat_of(*both)
    step = both[0].step(both[1])
    twist = step.landed.hinge.twist
    before = np.concatenate([flat.rate * twist, step.coefficients[-5]])
    J = np.eye(6, model.nv)  # the stance sole is the base
    after = pin.impulseDynamics(model, model.createData(), q, before, J, 0.0, 0.0)
    assert after[:6] == pytest.approx(0.0, abs=1e-12)
    assert relative_error(step.coefficients[-4], after[6:]) < 1e-10
    M = pin.crba(model, model.createData(), q)
    lost = (before @ M @ before - after @ M @ after) / 2.0
    assert lost > 0.05  # J
    assert -flat.impulse @ (flat.rate * twist) / 2.0 == pytest.approx(lost, rel=1e-10)


def test_derivatives_of_the_impact_are_exact(robot):
    impact = FlatImpact(robot, HeelLine(0.01).hinge(robot.sole))
    rng = np.random.default_rng(0)
    u, weights = np.append(rng.normal(0.0, 0.3, 12), -2.3), rng.normal(size=18)

    def values(u):
        at = impact.at(u[:-1], u[-1])
        return np.concatenate([at.jump, at.impulse])

    def gradient(u):
        return weights @ impact.at(u[:-1], u[-1]).along

    at = impact.at(u[:-1], u[-1])
    check_jacobian(values, at.along, u)
    check_jacobian(gradient, impact.hessian(at, weights[:12], weights[12:]), u)


def test_the_foot_meets_the_ground_with_its_rate_and_stays(both):
    problem, x = both
    step, flat = problem.step(x), problem.step(x).flat
    at = np.isclose(problem.grid.instants, 0.2, rtol=0.0, atol=1e-9)
    angle, rate, _ = step.foot_motion[:, at, 0]
    assert angle == pytest.approx(0.0, abs=1e-12)
    assert rate == pytest.approx([flat.rate, 0.0])
    assert flat.rate < -1.0
    before, after = step.motion[1, at]
    assert after - before == pytest.approx(flat.jump)
    assert np.abs(flat.jump).max() > 0.1
    q = step.motion[0, at]
    assert q[0] == pytest.approx(q[1], abs=1e-9)


def test_the_ground_pushes_within_its_limits_by_ordinary_rows(both):
    names = [block.name for block in both[0].blocks]
    for name in ("rear impulse", "rear impulse friction", "rear impulse cop"):
        (block,) = (b for b in both[0].blocks if b.name == name)
        assert all(label.startswith("foot as it lies flat, ") for label in block.labels)
    assert "foot lift" in names  # of the toe; after the landing the foot does not come to rest
    assert "foot lift" not in [block.name for block in point(both[0].robot)[0].blocks]


def test_it_is_certified_and_costs_less_than_a_foot_that_comes_to_rest(robot, found):
    assert found.certificate.verdict == "certified"
    step, margins = found.problem.step(found.solution.x), found.problem.task.margins
    (impulse,) = step.read(quantities.REAR_IMPULSE)
    assert impulse[2] > 1.0
    assert np.hypot(*impulse[:2]) <= margins.friction * impulse[2] * (1.0 + 1e-5)
    x, y = -impulse[4] / impulse[2], impulse[3] / impulse[2]
    sole = robot.sole
    room = min(sole.toe - x, x - sole.heel, sole.left - y, y - sole.right)
    assert room > margins.cop_margin - 1e-4
    gently = preset_task(**{**IMPACT, "foot_flat": "gentle"}, samples=21)
    other = design(robot, gently, DesignOptions(refine=False, diagnose=False))
    assert found.solution.cost < 0.9 * other.solution.cost
    assert audit(found.gait).passed
    assert second_engine(found.gait, instants=31).largest < 1e-9


def test_the_motors_give_what_both_impacts_take(found):
    """Over a step of a cyclic walk on level ground the mechanical energy is the same again."""
    problem = found.problem.with_grid(proof_grid(found.problem.breaks))
    step = problem.step(found.solution.x)
    power = (step.read(quantities.TORQUE) * step.motion[1]).sum(axis=1)
    on_line = step.read(quantities.WRENCH) @ step.landed.hinge.twist
    power += on_line * step.foot_motion[1, :, 0]  # of the ground, whose push has a lever of a strip
    given = step.duration * problem.grid.weights @ power
    flat, model, q = flat_of(problem, found.solution.x)
    taken = -0.5 * flat.impulse @ (flat.rate * step.landed.hinge.twist)
    q[7:] = step.q_end
    M = pin.crba(model, model.createData(), q)
    twist = np.zeros(6) if step.turn is None else step.turn.twist
    before, after = np.concatenate([twist, step.rate_before]), step.impact.velocity
    taken += 0.5 * (before @ M @ before - after @ M @ after)
    assert taken > 0.5  # J
    assert given == pytest.approx(taken, rel=1e-6)


def test_the_referee_sees_another_impulse_and_another_jump(both):
    problem = both[0].with_grid(proof_grid(both[0].breaks))
    step = problem.step(both[1])
    ask = problem.robot, problem.grid, problem.schedule
    assert ask_referee(ask[0], step, *ask[1:]).worst < REFEREE
    flat = replace(step.flat, impulse=1.01 * step.flat.impulse)
    assert ask_referee(ask[0], replace(step, flat=flat), *ask[1:]).impulse > 1e-4
    coefficients = step.coefficients.copy()
    coefficients[-4] *= 1.01
    other = replace(step, coefficients=coefficients)
    assert ask_referee(ask[0], other, *ask[1:]).impulse > 1e-4


def test_a_second_engine_signs_both_impacts_of_every_step(gait):
    signed = second_engine(gait, instants=101)
    assert 0.0 < signed.largest < 1e-9
    other = second_engine(replace(gait, rear_impulse=1.01 * gait.rear_impulse), instants=5)
    assert other.impulse > 1e-4
    other = second_engine(replace(gait, flat_rates=1.01 * gait.flat_rates), instants=5)
    assert other.largest > 1e-4


def test_a_stride_of_two_is_the_same_walk(robot):
    one, x = point(robot)
    two = WalkProblem(robot, preset_task(**IMPACT, stride=True))
    own = two.layout.pack([x, x])
    assert two.values(own).cost == pytest.approx(one.values(x).cost, rel=1e-9)
    signed = second_engine(gait_at(two, own, {}), instants=11)
    assert signed.largest < 1e-9


@pytest.mark.parametrize("changes", [{}, {"toe_off": 0.65}, {"stride": True}])
def test_the_file_keeps_the_impact(robot, tmp_path, changes):
    problem, x = point(robot, **changes)
    gait = gait_at(problem, x, {})
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    assert again.phases == gait.phases
    for one, other in zip(again.steps, gait.steps, strict=True):
        assert one.rear_impulse == pytest.approx(other.rear_impulse)
        assert one.flat_rates == pytest.approx(other.flat_rates)
    t = np.linspace(0.0, 2.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-9
    with np.load(path) as content:
        kept = {key: content[key] for key in content.files if not key.endswith("rear_impulse_0")}
    np.savez(path, **kept)
    with pytest.raises(GaitFileError):
        load_gait(path)


def test_trajectory_jumps_there_and_nowhere_else_inside(gait):
    trajectory, at = gait.trajectory, gait.flat_from
    moving = trajectory.body.moving
    before, after = trajectory.at([at], before=True), trajectory.at([at])
    assert after.configuration == pytest.approx(before.configuration, abs=1e-9)
    jump = (after.dq - before.dq)[0, moving]
    assert jump == pytest.approx(gait.flat_rates[1] - gait.flat_rates[0], abs=1e-9)
    assert np.abs(jump).max() > 0.1
    begun = gait.turns_at
    before, after = trajectory.at([begun], before=True), trajectory.at([begun])
    assert after.dq == pytest.approx(before.dq, abs=1e-8)


def test_summary_and_export_speak_of_it(gait, both):
    impulse = both[0].step(both[1]).flat.impulse
    told = summarise(gait)["impact"]["foot_flat"]
    assert told["vertical_impulse_Ns"] == pytest.approx(impulse[2])
    told = stride_record(gait, stride_samples(gait))["landed_foot_turn"]["impulse_at_the_end"]
    assert list(told.values()) == pytest.approx(impulse.tolist())
    pieces = cubic_pieces(gait)
    spans = np.diff(gait.knots)[:, None]
    ends = pieces[..., 1] + spans * (2.0 * pieces[..., 2] + spans * 3.0 * pieces[..., 3])
    assert ends[0] == pytest.approx(gait.flat_rates[0])
    assert pieces[1, :, 1] == pytest.approx(gait.flat_rates[1])


def test_a_gait_whose_impact_does_not_fit_is_refused(gait):
    with pytest.raises(InputError, match="flat_rates must be two rows"):
        replace(gait, rear_impulse=np.zeros(0))


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"foot_flat": "impact"}, "give heel_strike"),
        ({"heel_strike": 0.2, "foot_flat": "hard"}, "choose gentle or impact"),
    ],
)
def test_what_cannot_be_is_refused(changes, match):
    with pytest.raises(InputError, match=match):
        preset_task(**changes)


def test_joints_that_follow_others_are_refused_with_advice():
    robot = tied("elbows and shanks")
    task = preset_task("humanoid", robot, **IMPACT)
    with pytest.raises(InputError, match="--foot-flat gentle"):
        WalkProblem(robot, task)


def test_what_robots_numbers_are_worth_is_not_told(found):
    with pytest.raises(InputError, match="--foot-flat"):
        sensitivities(found.problem, found.solution.x, found.certificate.multipliers)


def test_only_a_foot_that_turns_comes_to_lie_flat_so():
    flat = Schedule().first.contact
    with pytest.raises(InputError, match="where it turns about a line"):
        Schedule((Phase(flat, 0.3, PhaseEnd.FOOT_FLAT), Phase(flat)))
