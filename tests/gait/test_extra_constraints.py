"""What is off unless asked for: each constraint against the sentence it stands for."""

from functools import partial

import numpy as np
import pytest
from motions import kinematics
from numerics import relative_error
from reference_cases import biped, reference_task
from urdf_edits import edited_urdf, joint, set_limit
from walks import SWITCHED, UPRIGHT, rows_and_limits, walk

from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import FOOT_SPACING, GEOMETRY, set_geometry
from gaitopt.gait.problem import WalkProblem, constraint_blocks
from gaitopt.gait.step import completed
from gaitopt.mechanics.capsule_distance import leg_pairs
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.model.robot import Robot
from gaitopt.nlp import violations

KNEES = ("right_knee", "left_knee")


@pytest.fixture(scope="module")
def problem():
    return walk("upright").problem


@pytest.fixture(scope="module")
def step(problem):
    return problem.step(walk("upright").x)


@pytest.fixture(scope="module")
def rows(problem, step):
    return partial(rows_and_limits, problem, step.x)


def test_everything_is_off_unless_it_is_asked_for(robot):
    names = {f.name for f in constraint_blocks(robot, reference_task(), uniform_grid(3))}
    assert names.isdisjoint(SWITCHED)
    asked = {f.name for f in constraint_blocks(robot, reference_task(**UPRIGHT), uniform_grid(3))}
    assert asked - names == set(SWITCHED)
    wide = constraint_blocks(robot, reference_task(step_width=0.2), uniform_grid(3))
    assert {f.name for f in wide} == names  # a bound of a parameter, not a row


def test_each_margin_switches_its_own(robot):
    def names(**margins):
        return {
            f.name for f in constraint_blocks(robot, reference_task(**margins), uniform_grid(3))
        }

    off = names()
    for entry in ("roll", "pitch", "yaw"):
        assert names(**{f"trunk_{entry}": 0.3}) - off == {f"trunk {entry}"}
    assert names(torsional_friction=0.05) - off == {"torsion", "impulse torsion"}
    assert names(leg_gap=0.0) - off == {"leg gap"}
    assert names(swing_tilt=0.1) - off == {"swing tilt"}
    assert names(swing_height=0.1) - off == {"swing height"}
    assert names(landing_speed=0.1) - off == {"landing speed"}
    assert names(landing_impulse=0.1) - off == {"landing impulse"}


def test_nothing_is_computed_unless_it_is_asked_for(robot, monkeypatch):
    problem = WalkProblem(robot, reference_task())
    x = first_guess(problem)
    monkeypatch.setattr(ForwardKinematics, "placed", None)  # calling it is an error
    step, slope = problem.derivatives(x)
    assert step.read(quantities.TRUNK).shape == step.read(quantities.LEG_GAPS).shape == (31, 0)
    assert slope.jacobians[quantities.LEG_GAPS].shape == (31, 0, 43)
    assert slope.optional == {}


def test_they_change_no_other_row(robot, problem, step):
    """Up to rounding: torques come with their derivatives from another routine than without."""
    plain = WalkProblem(robot, reference_task(), problem.grid)
    at = plain.values(step.x)
    for constraint in plain.blocks:
        here = problem.values(step.x).rows[problem.rows_of(constraint.name)]
        there = at.rows[plain.rows_of(constraint.name)]
        np.testing.assert_allclose(here, there, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize(("entry", "limit"), [("roll", 0.1), ("pitch", 0.12), ("yaw", 0.09)])
def test_trunk(robot, rows, step, entry, limit):
    value, lower, upper = rows(f"trunk {entry}")
    at = [kinematics(robot, q).frame(robot.pelvis_frame).rotation for q in step.motion[0]]
    R = np.array(at)
    # upright trunk turned by yaw about z, pitch about y, roll about x
    expected = {
        "roll": np.arctan2(R[:, 2, 1], R[:, 2, 2]),
        "pitch": -np.arcsin(R[:, 2, 0]),
        "yaw": np.arctan2(R[:, 1, 0], R[:, 0, 0]),
    }[entry]
    assert relative_error(value[:, 0], expected) < 1e-12
    assert (lower == -limit).all()
    assert (upper == limit).all()


def test_the_trunk_starts_as_the_geometric_quantities_say():
    """Its yaw is seen from the direction of travel, which feet turned out share evenly."""
    walked = walk("upright, everything free")
    step = walked.problem.step(walked.x)
    named = dict(zip((q.name for q in GEOMETRY), step.geometry, strict=True))
    roll, pitch, yaw = step.read(quantities.TRUNK)[0]
    assert (roll, pitch) == pytest.approx((named["pelvis_roll"], named["trunk_pitch"]))
    assert abs(named["foot_yaw"]) > 0.05
    assert yaw == pytest.approx(named["pelvis_yaw"] - named["foot_yaw"] / 2.0)


def test_the_trunk_ends_as_the_mirror_of_how_it_starts():
    walked = walk("upright, everything free")
    trunk = walked.problem.step(walked.x).read(quantities.TRUNK)
    last = walked.problem.grid.nodes - 1
    assert relative_error(trunk[last], trunk[0] * (-1.0, 1.0, -1.0)) < 1e-9


def turning_moment(force, moment):
    pressure = np.array([-moment[1] / force[2], moment[0] / force[2], 0.0])
    return (moment - np.cross(pressure, force))[2]


def test_torsion(rows, step):
    value, lower, _ = rows("torsion")
    for row, wrench in zip(value, step.support.effort[:, :6], strict=True):
        turning, most = turning_moment(wrench[:3], wrench[3:]), 0.04 * wrench[2]
        np.testing.assert_allclose(row, [most - turning, most + turning], rtol=1e-4, atol=1e-3)
    assert (lower == 0.0).all()


def test_impulse_torsion(rows, step):
    value, lower, _ = rows("impulse torsion")
    I = step.impact.impulse  # noqa: E741
    turning, most = turning_moment(I[:3], I[3:]), 0.04 * I[2]
    np.testing.assert_allclose(value[0], [most - turning, most + turning], rtol=1e-4)
    assert (lower == 0.0).all()


def test_leg_gap(robot, problem, rows, step):
    """A pair of shins by hand: nearest points of two bars, sought on a fine grid."""
    value, lower, _ = rows("leg gap")
    names = leg_pairs(robot).names
    constraint = next(f for f in problem.blocks if f.name == "leg gap")
    assert constraint.labels == tuple(f"gap between {name}" for name in names)
    assert (lower == 0.012).all()
    index = names.index("right_shin and left_shin")
    pair, share = leg_pairs(robot).kept[index], np.linspace(0.0, 1.0, 400)[:, None]
    for q, found in zip(step.motion[0][::6], value[::6, index], strict=True):
        at = kinematics(robot, q).data.oMi
        bars = [
            (1.0 - share) * at[c.body + 1].act(c.ends[0]) + share * at[c.body + 1].act(c.ends[1])
            for c in pair
        ]
        apart = np.linalg.norm(bars[0][:, None] - bars[1][None], axis=2).min()
        assert found == pytest.approx(apart - pair[0].radius - pair[1].radius, abs=1e-5)


def test_swing_tilt(robot, problem, rows, step):
    """Sines of the angles between the sole's edges and the ground or the way ahead."""
    value, lower, upper = rows("swing tilt")
    np.testing.assert_allclose(upper[:, :3], 0.15)
    np.testing.assert_allclose(lower[:, :3], -0.15)
    assert np.isinf(upper[:, 3:]).all()
    np.testing.assert_array_equal(lower[:, 3:], 0.0)
    for q, found in zip(step.motion[0], value, strict=True):
        R = kinematics(robot, q).frame(robot.swing_frame).rotation
        np.testing.assert_allclose(
            found, [R[2, 1], -R[2, 0], R[1, 0], R[0, 0], R[1, 1]], atol=1e-12
        )


def test_swing_height(rows, step):
    value, lower, upper = rows("swing height")
    assert relative_error(value, step.support.corners[:, :, 2]) < 1e-13
    assert (upper == 0.05).all()
    assert np.isinf(lower).all()


def test_landing_speed(problem, rows, step):
    """Heights of the corners above a profile that ends with a thousandth more than was asked."""
    value, lower, upper = rows("landing speed")
    instants = problem.grid.instants
    inside = (instants > 0.0) & (instants < 1.0)
    assert relative_error(value, step.support.corners[inside, :, 2]) < 1e-13
    late, duration = instants[inside], problem.task.duration
    np.testing.assert_allclose(lower[:, 0], 0.2002 * duration * (1.0 - late) * late**12)
    assert np.isinf(upper).all()


def test_landing_impulse(robot, rows, step):
    value, lower, upper = rows("landing impulse")
    assert relative_error(value, step.read(quantities.IMPULSE)[:, 2:3]) < 1e-13
    assert upper == pytest.approx(0.15 * robot.multibody.mass.sum())
    assert np.isinf(lower).all()


def spacing_bounds(side="right", **changes):
    layout = WalkProblem(biped(side), reference_task(**changes)).layout
    quantity = layout.geometry[FOOT_SPACING]
    return quantity.lower, quantity.upper


def test_step_width_bounds_the_foot_spacing():
    assert spacing_bounds() == (-np.inf, np.inf)
    assert spacing_bounds(step_width=0.17) == (-np.inf, 0.17)
    assert spacing_bounds("left", step_width=0.17) == (-0.17, np.inf)
    narrower = set_geometry(GEOMETRY, {"foot_spacing": {"lower": 0.1, "upper": 0.15}})
    assert spacing_bounds(step_width=0.17, geometry=narrower) == (0.1, 0.15)
    fixed = set_geometry(GEOMETRY, {"foot_spacing": {"free": False, "value": 0.16}})
    assert spacing_bounds(step_width=0.17, geometry=fixed) == (-np.inf, np.inf)


def test_the_first_guess_keeps_the_step_width(robot):
    problem = WalkProblem(robot, reference_task(step_width=0.15))
    x = first_guess(problem)
    assert x[problem.layout.index("foot_spacing")] == 0.15


def knees_bend_the_other_way(root):
    for name in KNEES:
        axis = joint(root, name).find("axis")
        axis.set("xyz", "0 -1 0")
        set_limit(name, lower=-2.6, upper=0.0)(root)


def test_knees_that_bend_to_negative_angles_are_the_same_knees(robot):
    """The same robot with another sign of the knees: every row and the cost stay as they are."""
    other = Robot.from_urdf(edited_urdf(knees_bend_the_other_way))
    assert (other.legs.flexion == -1.0).all()
    problem = WalkProblem(robot, reference_task(knee_flexion=0.21))
    there = WalkProblem(other, problem.task)
    x, sign = walk("guess").x, np.ones(12)
    sign[list(robot.legs.knees)] = -1.0
    y = np.concatenate([x[:36] * np.tile(sign, 3), x[36:]])
    knee = problem.rows_of("knee")
    assert relative_error(there.values(y).rows[knee], problem.values(x).rows[knee]) < 1e-12
    np.testing.assert_allclose(there.rows.lower[knee], 0.21)
    assert there.values(y).cost == pytest.approx(problem.values(x).cost)
    assert relative_error(first_guess(there)[:12] * sign, first_guess(problem)[:12]) < 1e-9


@pytest.mark.parametrize(
    "turn", [np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, 1.0, -1.0]), np.diag([-1.0, -1.0, 1.0])]
)
def test_a_sole_turned_by_half_a_turn_is_not_level(turn):
    """About each axis: the sines of its tilt vanish as if it were level."""
    problem = WalkProblem(biped(), reference_task(swing_tilt=0.3))
    constraint = next(f for f in problem.blocks if f.name == "swing tilt")
    corners = problem.robot.sole.corners
    level, turned = (
        constraint.function.value((corners @ R.T).reshape(1, 12)) for R in (np.eye(3), turn)
    )
    assert violations(constraint.lower[:1], constraint.upper[:1], level).max() == 0.0
    np.testing.assert_allclose(turned[0, :3], 0.0, atol=1e-12)
    assert violations(constraint.lower[:1], constraint.upper[:1], turned).max() == pytest.approx(
        1.0
    )


def test_a_trunk_upside_down_is_no_walk():
    values = {quantities.TRUNK: np.array([[np.pi, 0.0, np.pi]])}  # pitched by half a turn
    with pytest.raises(EvaluationError, match="upside down"):
        completed(values, np.zeros(10), 1)
