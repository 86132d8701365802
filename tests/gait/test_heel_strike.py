"""Walks whose swing foot lands on its heel and rolls flat, with an impact or at zero speed."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from walk_checks import FORCE_MIRROR, check_base_moves_as_its_twist_says
from walks import walk

from gaitopt.contact import AFTER
from gaitopt.design.certificate import ask_referee, certify
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.summary import summarise
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.foot_turn import FootTurn
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.grid import proof_grid
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.simulate.second_engine import second_engine
from gaitopt.tolerances import MOMENTUM, REFEREE

NAMES = (
    "upright, heel strike, toe off, everything free",
    "upright, lifted, heel strike, five joints, soft",
)


@pytest.fixture(scope="module", params=NAMES)
def found(request):
    return walk(request.param)


@pytest.fixture(scope="module")
def both(robot):
    """A guess that lands on its heel and leaves from its toe, disturbed."""
    problem = WalkProblem(robot, preset_task(heel_strike=0.2, toe_off=0.65, duration=0.5))
    return problem, perturbed(problem, first_guess(problem), 0.02, 3)


@pytest.fixture(scope="module")
def gait(both):
    return gait_at(*both, {})


def test_angle_starts_as_the_impact_leaves_it_and_ends_flat_at_rest():
    turn = FootTurn(0.0, np.array([0.0, 0.1, 0.2, 0.2 + AFTER, 0.7]), 0.2, landed=True)
    angle, rate, acceleration = (turn.basis.at(0.5) @ turn.coefficients @ [0.3, 0.1, -2.5]).T
    assert [angle[0], angle[1], rate[0]] == pytest.approx([0.3, 0.1, -2.5])
    assert angle[2:] == pytest.approx(0.0, abs=1e-12)
    assert rate[2:] == pytest.approx(0.0, abs=1e-12)
    assert acceleration[2] > 1.0  # until then; it jumps
    assert acceleration[3:].tolist() == [0.0, 0.0]


def test_foot_keeps_its_heel_and_rolls_flat(gait, robot):
    times = np.linspace(0.0, 0.2, 9) * gait.duration
    at = gait.trajectory.at(times)
    corners = np.einsum("nij,kj->nki", at.sole[:, 0, :3, :3], robot.sole.corners)
    corners += at.sole[:, 0, None, :3, 3]
    assert corners[:, 2:, 2] == pytest.approx(0.0, abs=1e-12)
    assert (corners[:-1, :2, 2] > 0.0).all()
    assert corners[-1, :2, 2] == pytest.approx(0.0, abs=1e-12)
    assert corners[:, 2:, :2] == pytest.approx(np.tile(corners[-1, 2:, :2], (9, 1, 1)))


def test_rate_after_the_landing_is_that_of_the_impact(both):
    step = both[0].step(both[1])
    landed, state = step.landed, step.impact
    J = _landing_jacobian(both[0].robot, step.q_end)
    kept = J @ state.velocity
    assert kept == pytest.approx(landed.rate * landed.hinge.twist, abs=1e-9)
    assert step.foot_motion[1, 0, 0] == pytest.approx(landed.rate)
    assert abs(landed.rate) > 0.1
    # the ground gives no moment about the line
    assert landed.hinge.twist @ state.impulse == pytest.approx(0.0, abs=1e-9)
    assert np.abs(state.impulse).max() > 1.0
    # which lies on the ground under the heel
    moment = step.impulse[4] + landed.hinge.point[0] * step.impulse[2]
    assert moment == pytest.approx(0.0, abs=1e-9)


def _landing_jacobian(robot, posture):
    model, q = robot.model, pin.neutral(robot.model)
    q[7:] = posture
    data = model.createData()
    return pin.computeFrameJacobian(model, data, q, robot.swing_frame, pin.LOCAL)


def test_impact_on_a_line_is_pinocchios(both):
    step, robot = both[0].step(both[1]), both[0].robot
    model, q = robot.model, pin.neutral(robot.model)
    q[7:] = step.q_end
    twist = step.landed.hinge.twist
    across = np.linalg.svd(twist[None])[2][1:]
    before = np.concatenate([step.turn.twist, step.rate_before])
    J = across @ _landing_jacobian(robot, step.q_end)
    after = pin.impulseDynamics(model, model.createData(), q, before, J, 0.0, 0.0)
    assert relative_error(step.impact.velocity, after) < 1e-9
    M = pin.crba(model, model.createData(), q)
    lost = (before @ M @ before - after @ M @ after) / 2.0
    assert lost > 0.1
    stopped = _landing_jacobian(robot, step.q_end) @ before
    assert -step.impact.impulse @ stopped / 2.0 == pytest.approx(lost, rel=1e-9)


def test_both_feet_staying_on_their_lines_only_turn_about_them(both):
    problem, x = both
    step = problem.step(x)
    locked = problem.model.impact.locked(step.q_end, step.rate_before, step.turn, step.landed)
    for twist, hinge in (
        (locked.velocity[:6], step.turn.hinge),
        (_landing_jacobian(problem.robot, step.q_end) @ locked.velocity, step.landed.hinge),
    ):
        about = twist @ hinge.twist / (hinge.twist @ hinge.twist)
        assert abs(about) > 1e-3
        assert twist == pytest.approx(about * hinge.twist, abs=1e-9)
    in_sole = step.landed.place.actInv(pin.Force(locked.impulse_landing)).vector
    assert step.landed.hinge.twist @ in_sole == pytest.approx(0.0, abs=1e-8)


def test_the_referee_agrees(found):
    problem = found.problem.with_grid(proof_grid(found.problem.breaks))
    step = problem.step(found.x)
    verdict = ask_referee(problem.robot, step, problem.grid, problem.schedule)
    # in the lifted form the next step starts there only where the closure holds
    assert 0.0 < max(verdict.torque, verdict.wrench, verdict.impulse, verdict.rate) < REFEREE
    assert verdict.rate_after < REFEREE
    if not found.problem.layout.lifted:
        assert 0.0 < verdict.momentum < MOMENTUM


def test_the_referee_sees_a_foot_that_turns_at_another_rate(both):
    problem = both[0].with_grid(proof_grid(both[0].breaks))
    step = problem.step(both[1])
    step.foot_motion[1, 0, 0] *= 1.01
    verdict = ask_referee(problem.robot, step, problem.grid, problem.schedule)
    assert verdict.rate > REFEREE


def test_trajectory_is_the_step_and_the_next_one_its_mirror_image(both, gait):
    problem, x = both
    step, T = problem.step(x), gait.duration
    trajectory = gait.trajectory
    assert [phase.contact for phase in gait.phases] == ["heel line", "flat", "toe line"]
    times = problem.grid.instants * T
    ends = times > 0.0
    for phase in gait.phases[1:]:
        ends &= ~((times > phase.begin) & (times < phase.begin + 1e-9))
    at = trajectory.at(times, before=ends)
    moving = problem.robot.multibody.moving
    assert relative_error(at.torque[:, moving], step.read(quantities.TORQUE)) < 1e-9
    wrench = [
        pin.SE3(place).act(pin.Force(own)).vector
        for place, own in zip(at.sole[:, 0], at.wrench[:, 0], strict=True)
    ]
    assert relative_error(np.array(wrench), step.read(quantities.WRENCH)) < 1e-9
    times = T * np.array([0.03, 0.13, 0.5, 0.71, 0.97])
    first, second = trajectory.at(times), trajectory.at(times + T)
    assert relative_error(second.torque[:, moving], first.torque[:, moving] @ gait.mirror.T) < 1e-8
    assert relative_error(second.wrench[:, 1], first.wrench[:, 0] * FORCE_MIRROR) < 1e-8
    ends, begins = trajectory.at([T], before=True), trajectory.at([T])
    assert begins.sole == pytest.approx(ends.sole, abs=1e-9)
    assert gait.step_length == pytest.approx(step.step_length, abs=1e-12)


def test_base_moves_as_its_twist_says(gait):
    times = gait.duration * np.array([0.05, 0.15, 0.3, 1.07, 1.5])
    check_base_moves_as_its_twist_says(gait.trajectory, times)


def test_a_second_engine_signs_every_phase_and_the_impact(gait):
    signed = second_engine(gait, instants=101)
    assert 0.0 < signed.largest < 1e-9
    other = second_engine(replace(gait, impulse=1.01 * gait.impulse), instants=5)
    assert other.impulse > 1e-3


@pytest.mark.parametrize("changes", [{"heel_strike": 0.2}, {"heel_strike": 0.2, "toe_off": 0.65}])
def test_the_file_keeps_all_phases(robot, tmp_path, changes):
    problem = WalkProblem(robot, preset_task(duration=0.5, **changes))
    gait = gait_at(problem, first_guess(problem), {})
    again = load_gait(save_gait(gait, tmp_path / "gait.npz"))
    assert again.phases == gait.phases
    assert again.landing_angle == pytest.approx(0.15)
    t = np.linspace(0.0, 2.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-10
    contact = summarise(again)["contact"]
    assert contact["flat_from_s"] == pytest.approx(0.1)
    assert contact["landing_angle_rad"] == pytest.approx(0.15)


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"heel_strike": 0.0}, "heel_strike is 0.0"),
        ({"heel_strike": 0.7}, "from 0.05 to 0.5"),
        ({"heel_strike": "soon"}, "heel_strike"),
        ({"heel_strip": 0.0}, "heel_strip"),
        ({"heel_strike": 0.4, "toe_off": 0.42}, "let it stand flat"),
        ({"heel_strike": 0.2, "stairs": 0.1}, "heel_strike or stairs"),
    ],
)
def test_heel_strike_that_cannot_be_is_refused(changes, match):
    with pytest.raises(InputError, match=match):
        preset_task(**changes)


def test_impulse_of_a_line_is_asked_for_nothing_that_always_holds(both):
    (block,) = (b for b in both[0].blocks if b.name == "impulse cop")
    assert np.isneginf(block.lower[0, :2]).all()
    assert block.lower[0, 2:].tolist() == [0.0, 0.0]


def test_a_landing_at_zero_speed_has_no_impact(robot):
    task = preset_task(soft_landing=True)
    problem = WalkProblem(robot, task)
    names = {block.name for block in problem.blocks}
    assert names.isdisjoint({"impulse", "impulse friction", "impulse cop", "lift-off"})
    found = design(robot, task, DesignOptions(refine=False, diagnose=False))
    step = found.problem.step(found.solution.x)
    assert np.abs(step.impulse).max() < 1e-6
    assert step.impact.rate_after == pytest.approx(step.rate_before, abs=1e-6)
    assert found.certificate.optimal
    impact = summarise(found.gait)["impact"]
    assert impact["at_zero_speed"]
    assert impact["friction_used"] is None
    assert impact["cop_to_edge_mm"] is None


def test_a_heel_strike_whose_impulse_vanishes_lands_at_zero_speed_and_saves_cost(robot):
    flat = preset_task(duration=0.5, samples=21)
    options = DesignOptions(diagnose=False)
    best = design(robot, flat, options)
    found = design(robot, flat.with_changes(heel_strike=0.2), options)
    assert found.problem.task.margins.soft_landing  # where an impact law has no regular optimum
    assert found.certificate.verdict == "certified"
    assert found.solution.cost < 0.95 * best.solution.cost
    step = found.problem.step(found.solution.x)
    assert 0.1 < step.landed.angle < 0.5
    assert step.landed.rate < -1.0
    again = certify(found.problem, found.solution.x)
    assert again.both_feet_stay == found.certificate.both_feet_stay
