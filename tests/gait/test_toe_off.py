"""Walks whose stance foot turns about its toe before the impact."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from walk_checks import FORCE_MIRROR, check_base_moves_as_its_twist_says
from walks import walk

from gaitopt.contact import AFTER
from gaitopt.design.summary import summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.foot_turn import FootTurn
from gaitopt.gait.gait_file import PHASES, load_gait, save_gait
from gaitopt.gait.grid import proof_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem

NAMES = ("upright, toe off, everything free", "upright, lifted, toe off, seven joints, waist, arms")


@pytest.fixture(scope="module", params=NAMES)
def found(request):
    return walk(request.param)


@pytest.fixture(scope="module")
def gait(robot):
    problem = WalkProblem(robot, preset_task(toe_off=0.65, duration=0.5))
    return gait_at(problem, first_guess(problem), {})


def sides(times, change):
    """Which instants are those before a change."""
    return (times > 0.0) & ~((times > change) & (times < change + 1e-9))


def test_angle_leaves_the_ground_smoothly_and_meets_its_parameters():
    turn = FootTurn(0.6, np.array([0.0, 0.3, 0.6, 0.6 + AFTER, 0.8, 1.0]))
    angle, rate, acceleration = (turn.basis.at(0.5) @ turn.coefficients @ [0.3, 0.1, 2.5]).T
    assert angle[:4] == pytest.approx(0.0, abs=1e-10)
    assert rate[:4] == pytest.approx(0.0, abs=1e-9)
    assert acceleration[:3].tolist() == [0.0] * 3
    assert acceleration[3] != pytest.approx(0.0, abs=0.1)  # it jumps
    assert [angle[4], angle[5], rate[5]] == pytest.approx([0.1, 0.3, 2.5])


def test_foot_that_turns_lifts_its_heel_and_keeps_its_toe(found):
    step, robot = found.problem.step(found.x), found.problem.robot
    trajectory = gait_at(found.problem, found.x, {}).trajectory
    at = trajectory.at(np.linspace(0.7, 0.95, 6) * step.duration)
    corners = np.einsum("nij,kj->nki", at.sole[:, 0, :3, :3], robot.sole.corners)
    corners += at.sole[:, 0, None, :3, 3]
    assert corners[:, :2, 2] == pytest.approx(0.0, abs=1e-12)
    assert (np.diff(corners[:, 2:, 2], axis=0) > 0.0).all()
    assert step.read(quantities.FOOT_TURN)[-1, 0] == step.x[found.problem.layout.turn][0]


def test_trajectory_is_the_step(found):
    step, body = found.problem.step(found.x), found.problem.robot.multibody
    trajectory = gait_at(found.problem, found.x, {}).trajectory
    times = found.problem.grid.instants * step.duration
    at = trajectory.at(times, before=sides(times, 0.65 * step.duration))
    assert [len(phase.knots) >= 2 for phase in trajectory.phases] == [True, True]
    motion = np.stack([at.q, at.dq, at.ddq])[:, :, body.moving]
    assert relative_error(motion, step.motion) < 1e-9
    assert relative_error(at.torque[:, body.moving], step.read(quantities.TORQUE)) < 1e-9
    first = np.linalg.inv(at.sole[0, 0])
    wrench = [
        pin.SE3(first @ place).act(pin.Force(own)).vector
        for place, own in zip(at.sole[:, 0], at.wrench[:, 0], strict=True)
    ]
    assert relative_error(np.array(wrench), step.read(quantities.WRENCH)) < 1e-9
    corners = np.einsum("nij,kj->nki", first @ at.sole[:, 1], _homogeneous(body.sole_corners[1]))
    assert relative_error(corners[:, :, :3], step.support.corners) < 1e-10


def _homogeneous(points):
    return np.hstack([points, np.ones((len(points), 1))])


def test_base_moves_as_its_twist_says(found):
    trajectory = gait_at(found.problem, found.x, {}).trajectory
    shares = np.array([0.1, 0.68, 0.77, 0.93, 1.68, 1.95])  # in either foot's turn
    check_base_moves_as_its_twist_says(trajectory, trajectory.step_duration * shares)


def test_next_step_is_the_mirror_image_and_lands_flat():
    found = walk(NAMES[0])  # in the lifted form only where the closure holds
    trajectory = gait_at(found.problem, found.x, {}).trajectory
    robot, T = found.problem.robot, trajectory.step_duration
    times = T * np.array([0.13, 0.5, 0.71, 0.97])
    first, second = trajectory.at(times), trajectory.at(times + T)
    moving = robot.multibody.moving
    assert relative_error(second.torque[:, moving], first.torque[:, moving] @ robot.mirror.T) < 1e-8
    assert relative_error(second.wrench[:, 1], first.wrench[:, 0] * FORCE_MIRROR) < 1e-8
    landed = trajectory.at([T], before=True).sole[0, 1]
    assert landed[2, :3] == pytest.approx([0.0, 0.0, 1.0], abs=1e-8)
    assert landed[2, 3] == pytest.approx(0.0, abs=1e-8)


def test_the_file_keeps_both_phases(gait, tmp_path):
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    assert (again.turns_at, again.foot_angle) == (gait.turns_at, pytest.approx(0.15))
    assert again.step_length == pytest.approx(0.5, abs=1e-12)
    t = np.linspace(0.0, 2.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-11
    with np.load(path) as content:
        second = [one.name for part in PHASES[1:3] for one in part]
        assert {name[-2:] for name in second} == {"_1"}
        assert content.files[-1 - len(second) : -1] == second
        k0, k1, c0, c1 = (content[f"{n}_{k}"] for n in ("knots", "coefficients") for k in (0, 1))
        # as docs/gait-file.md joins them
        assert np.r_[k0, k0[-1] + k1[1:]] == pytest.approx(gait.knots, rel=1e-14)
        joined = np.r_[c0[:-2], c1[1:-2], c0[-2:-1], c1[-1:]]
        assert relative_error(joined, gait.coefficients) < 1e-12
        assert content["foot_hinge_1"].shape == (6,)
        assert '"toe line"' in str(content["schedule"])


@pytest.mark.parametrize("name", ["foot_hinge_1", "coefficients_1", "foot_knots_1"])
def test_a_file_without_a_part_of_the_turn_is_refused(gait, tmp_path, name):
    path = save_gait(gait, tmp_path / "gait.npz")
    with np.load(path) as content:
        kept = {key: content[key] for key in content.files if key != name}
    np.savez(path, **kept)
    with pytest.raises(GaitFileError, match=name):
        load_gait(path)


@pytest.mark.parametrize(
    "change",
    [
        {"foot_knots": np.zeros(0)},
        {"foot_hinge": np.zeros(3)},
        {"foot_knots": np.array([0.2, 0.3, 0.4])},
        {"foot_knots": np.array([0.325, 0.2, 0.5])},
    ],
)
def test_a_turn_that_does_not_fit_the_step_is_refused(gait, change):
    with pytest.raises(InputError, match="foot"):
        replace(gait, **change)


@pytest.mark.parametrize(
    ("name", "value"),
    [("toe_off", 0.0), ("toe_off", 0.99), ("toe_off", "late"), ("toe_strip", 0.0)],
)
def test_toe_off_that_cannot_be_is_refused(name, value):
    with pytest.raises(InputError, match=name):
        preset_task(**{name: value})


def test_splines_have_a_knot_where_the_foot_begins_to_turn(robot):
    problem = WalkProblem(robot, preset_task(toe_off=0.65, postures=3))
    assert 0.65 in problem.model.basis.knots
    assert problem.model.basis.knots.size == 5
    assert set(problem.breaks) == {*problem.model.basis.knots, *problem.model.foot_turn.knots}


def test_margins_of_the_centre_of_pressure_are_told_of_the_flat_foot(gait):
    assert gait.flat.sum() == np.sum(gait.time <= 0.65 * 0.5)
    assert 0 < gait.flat.sum() < len(gait.time)
    contact = summarise(gait)["contact"]
    front = gait.number("sole", "toe") - gait.cop[gait.flat, 0].max()
    assert contact["cop_to_edge_mm"]["front"] == pytest.approx(1e3 * front)
    assert contact["foot_turns_from_s"] == gait.turns_at == pytest.approx(0.325)
    assert contact["foot_angle_rad"] == pytest.approx(0.15)


def test_motors_and_the_strip_do_the_work_that_the_impact_takes():
    """On level ground nothing else does: the strip by the moment of the ground about the line."""
    found = walk(NAMES[0])
    problem = found.problem.with_grid(proof_grid(found.problem.breaks))
    step, model = problem.step(found.x), problem.robot.model
    weights = step.duration * problem.grid.weights
    work = weights @ (step.read(quantities.TORQUE) * step.motion[1]).sum(axis=1)
    wrench, (_, turn, _) = step.read(quantities.WRENCH), step.foot_motion[:, :, 0]
    strip = weights @ (wrench @ step.turn.hinge.twist * turn)
    assert abs(strip) > 1.0  # J; of this guess, whose pressure is far from the line
    data, q = model.createData(), pin.neutral(model)
    q[7:] = step.q_end
    M = pin.crba(model, data, q)
    before = np.concatenate([step.turn.twist, step.rate_before])
    after = step.impact.velocity
    lost = (before @ M @ before - after @ M @ after) / 2.0
    assert lost > 1.0  # J
    assert work + strip == pytest.approx(lost, rel=1e-9)
