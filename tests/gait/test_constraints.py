"""Every constraint against the sentence it stands for, computed anew from the step."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numerics import relative_error
from reference_cases import biped
from walks import UPRIGHT, rows_and_limits, walk

from gaitopt.gait import quantities
from gaitopt.gait.constraint import ConstraintContext
from gaitopt.gait.constraints import CentreOfPressure, Margins
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem, constraint_blocks
from gaitopt.model.sole import Sole

NAME = "guess"


@pytest.fixture(scope="module")
def problem():
    return walk(NAME).problem


@pytest.fixture(scope="module")
def step(problem):
    return problem.step(walk(NAME).x)


@pytest.fixture(scope="module")
def rows(problem, step):
    return partial(rows_and_limits, problem, step.x)


def test_torque(rows, step):
    value, lower, upper = rows("torque")
    assert relative_error(value, step.support.effort[:, 6:]) < 1e-13
    assert (lower == -150.0).all()
    assert (upper == 150.0).all()


def test_speed(rows, step):
    value, lower, upper = rows("speed")
    assert relative_error(value, step.motion[1]) < 1e-13
    assert (lower == -10.0).all()
    assert (upper == 10.0).all()


def test_range(robot, rows, step):
    value, lower, upper = rows("range")
    assert relative_error(value, step.motion[0]) < 1e-13
    np.testing.assert_array_equal(lower, np.tile(robot.limits.lower, (31, 1)))
    np.testing.assert_array_equal(upper, np.tile(robot.limits.upper, (31, 1)))


def test_load(rows, step):
    value, lower, upper = rows("load")
    assert relative_error(value[:, 0], step.support.effort[:, 2]) < 1e-13
    assert (lower == 25.0).all()
    assert np.isinf(upper).all()


def test_friction(rows, step):
    value, lower, _ = rows("friction")
    fx, fy, fz = step.support.effort[:, :3].T
    np.testing.assert_allclose(value[:, 0], 0.7 * fz - np.hypot(fx, fy), atol=0.05)
    assert (lower == 0.0).all()


def test_impulse(rows, step):
    Ix, Iy, Iz = step.impact.impulse[:3]
    assert rows("impulse")[0] == pytest.approx(Iz)
    assert rows("impulse friction")[0] == pytest.approx(0.7 * Iz - np.hypot(Ix, Iy), abs=1e-4)
    assert rows("impulse")[1] == rows("impulse friction")[1] == 0.0


def test_liftoff(robot, rows, step):
    twist = step.impact.sole_twist
    expected = (twist[:3] + np.cross(twist[3:], robot.sole.corners))[:, 2]
    value, lower, upper = rows("lift-off")
    assert relative_error(value[0], expected) < 1e-12
    assert (lower == 0.0).all()
    assert np.isinf(upper).all()


def test_clearance(rows, step):
    value, lower, _ = rows("clearance")
    inner = slice(1, -1)
    assert relative_error(value, step.support.corners[inner, :, 2]) < 1e-13
    s = np.linspace(0.0, 1.0, 31)[inner]
    assert relative_error(lower, np.tile(0.03 * np.sin(np.pi * s)[:, None] ** 2, 4)) < 1e-13


def test_lateral(rows, step):
    value, lower, _ = rows("lateral")
    assert relative_error(value, step.support.corners[:, :, 1]) < 1e-13
    np.testing.assert_allclose(lower, 0.068 + 0.01)


def test_knees(robot, rows, step):
    value, lower, _ = rows("knee")
    assert relative_error(value, step.motion[0][:, list(robot.legs.knees)]) < 1e-13
    np.testing.assert_allclose(lower, 0.1)


def test_leg_length(rows, step):
    value, _, upper = rows("leg length")
    assert relative_error(value[:, 0], np.linalg.norm(step.posture.legs, axis=1)) < 1e-13
    np.testing.assert_allclose(upper, 0.9995 * 0.6)


def test_walking_speed(rows, step):
    value, lower, upper = rows("walking speed")
    assert value == pytest.approx(1.0 * 0.4 - step.step_length)
    assert lower == upper == 0.0


active_rows = st.tuples(st.floats(-0.3, 0.1), st.floats(-0.15, 0.15))


@given(active_rows, st.floats(50.0, 2000.0))
@settings(deadline=None, derandomize=True, max_examples=100)
def test_edge_moments_hold_where_the_centre_of_pressure_is_inside(point, load):
    robot = biped()
    context = ConstraintContext(robot, uniform_grid(3), Margins(), 1.0, 0.4)
    constraint = CentreOfPressure().block(context)
    x, y = point
    wrench = np.array([[3.0, -7.0, load, y * load, -x * load, 0.4]])
    value = constraint.function.value(wrench)[0]
    # Moment about an edge: load times distance to it, front, rear, left, right.
    margin = 0.005
    distance = [-margin - x, x + 0.214 - margin, 0.068 - margin - y, y + 0.068 - margin]
    np.testing.assert_allclose(value, load * np.array(distance), atol=1e-9 * load)


def test_centre_of_pressure_of_the_step(rows, step):
    value, lower, _ = rows("cop")
    wrench = step.support.effort[:, :6]
    x, y = -wrench[:, 4] / wrench[:, 2], wrench[:, 3] / wrench[:, 2]
    assert relative_error(value[:, 0] / wrench[:, 2], -0.005 - x) < 1e-11
    assert relative_error(value[:, 2] / wrench[:, 2], 0.063 - y) < 1e-11
    assert (lower == 0.0).all()


def test_impulsive_centre_of_pressure(rows, step):
    value, lower, _ = rows("impulse cop")
    I = step.impact.impulse  # noqa: E741
    expected = [-0.005 * I[2] + I[4], 0.209 * I[2] - I[4], 0.063 * I[2] - I[3], 0.063 * I[2] + I[3]]
    assert relative_error(value[0], expected) < 1e-12
    assert (lower == 0.0).all()


def limits(name: str, robot=None, **margins):
    """Lower and upper limits of a constraint with other margins."""
    task = replace(preset_task(), margins=Margins(**margins))
    found = constraint_blocks(robot or biped(), task, uniform_grid(31))
    constraint = next(f for f in found if f.name == name)
    return constraint.lower, constraint.upper, constraint


def test_given_limits_replace_the_robots():
    assert (limits("torque", torque_limit=33.0)[1] == 33.0).all()
    assert (limits("torque", torque_limit=33.0)[0] == -33.0).all()
    assert (limits("speed", speed_limit=4.5)[1] == 4.5).all()


def test_margins_move_the_limits():
    assert (limits("load", minimum_load=60.0)[0] == 60.0).all()
    assert limits("clearance", clearance=0.05)[0].max() == pytest.approx(0.05)
    np.testing.assert_allclose(limits("lateral", lateral_gap=0.03)[0], 0.098)
    np.testing.assert_allclose(limits("knee", knee_flexion=0.25)[0], 0.25)
    np.testing.assert_allclose(limits("leg length", leg_extension=0.9)[1], 0.54)
    assert (limits("lift-off", liftoff_speed=-0.02)[0] == -0.02).all()
    assert limits("friction", friction=0.35)[2].function.friction == 0.35
    assert limits("impulse friction", friction=0.35)[2].function.friction == 0.35
    wide = limits("cop", cop_margin=0.02)[2].function.value(np.array([[0.0, 0, 1, 0, 0, 0]]))
    np.testing.assert_allclose(wide, [[-0.02, 0.194, 0.048, 0.048]])


def test_the_swing_foot_stays_on_its_own_side():
    """On the left foot the swing foot is on the right: the same gap, the other way."""
    left = biped("left")
    _, _, constraint = limits("lateral", robot=left)
    outside = np.tile([0.0, -0.16, 0.0], 4)[None]
    assert (constraint.function.value(outside) > constraint.lower[:1]).all()
    assert (constraint.function.value(-outside) < constraint.lower[:1]).all()


def test_the_edge_beside_the_swing_foot_counts():
    """A sole that reaches 5 cm to its left and 7 cm to its right."""
    sole = Sole(toe=0.0, heel=-0.214, left=0.05, right=-0.07)
    for side, edge in (("right", 0.05), ("left", 0.07)):
        lower = limits("lateral", robot=replace(biped(side), sole=sole))[0]
        np.testing.assert_allclose(lower, edge + 0.01)


def test_rounding_the_tips_of_the_cones_costs_next_to_nothing():
    upright = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    force, impulse = (
        limits(n)[2].function.value(upright) for n in ("friction", "impulse friction")
    )
    assert 0.7 - force == pytest.approx(0.05)  # N
    assert 0.7 - impulse == pytest.approx(1e-9**0.5)  # N.s


def test_switches_and_speed_choose_the_constraints():
    def names(**changes):
        return {
            f.name for f in constraint_blocks(biped(), preset_task(**changes), uniform_grid(31))
        }

    everything = names(joint_range=True, impulse_cop=True)
    assert everything - names(joint_range=False) == {"range"}
    assert everything - names(impulse_cop=False) == {"impulse cop"}
    assert everything - names(speed_as="penalty") == {"walking speed"}


def test_every_constraint_cites_its_equation_and_names_its_rows(problem):
    for constraint in problem.blocks:
        assert any(c.isdigit() for c in constraint.equation)
        assert len(constraint.labels) == constraint.lower.shape[1] == constraint.scale.size
        assert len(set(constraint.labels)) == len(constraint.labels)
        assert (constraint.scale > 0.0).all()
        assert constraint.unit


def test_every_quantity_is_constrained_somewhere(robot, problem):
    """A quantity that nothing reads is computed for nobody, and no test sees its derivatives.

    Accelerations are there for constraints of one's own; the peak belongs to a cost, `PeakTorque`,
    which brings its own constraint; `ADVANCE` is read in strides (test_stride.py).
    """
    task = preset_task(boundary="lifted", toe_off=0.7, **UPRIGHT)
    everything = constraint_blocks(robot, task, task.grid)
    both = preset_task(double_support=0.05, touch_down="impact")
    everything += constraint_blocks(robot, both, both.grid)
    everything += walk("upright, lifted, seven joints, waist, arms").problem.blocks
    known = set(quantities.ALL) - {quantities.ACCELERATIONS, quantities.PEAK, quantities.ADVANCE}
    assert {one for b in everything for one in b.reads} == known
    optional = {quantities.GAPS, quantities.TRUNK, *quantities.BODY_GAPS, quantities.FOOT_TURN}
    optional |= {quantities.FRONT_WRENCH, quantities.REAR_IMPULSE}
    assert {one for b in problem.blocks for one in b.reads} == known - optional


def test_added_instants_are_constrained_too(robot):
    grid = uniform_grid(31).with_instants(np.array([0.123]))
    problem = WalkProblem(robot, preset_task(), grid)
    sizes = {f.name: len(f.instants) for f in problem.blocks}
    assert sizes["torque"] == sizes["cop"] == 32
    assert sizes["clearance"] == 30
    assert problem.blocks[0].times[-1] == 0.123


MANY = {
    "torque_limit": 80.0, "friction": 0.5, "torsional_friction": 0.02, "swing_tilt": 0.3,
    "swing_height": 0.2, "landing_speed": 0.3, "landing_impulse": 1.0, "liftoff_speed": -0.1,
    "trunk_yaw": 0.2, "leg_gap": 0.01, "leg_extension": 0.95, "impulse_cop": True,
}  # fmt: skip
SHAPES = (
    {},
    {"double_support": 0.05},
    {"toe_off": 0.7, "heel_strike": 0.2},
    {"stairs": 0.1},
    {"stride": True},
    {"turn_rate": 0.3},
)


def same_rows(one, other):
    """Check that two blocks hold the same rows, to the last digit."""
    for name in ("name", "labels", "contacts", "reads", "ends"):
        assert getattr(one, name) == getattr(other, name)
    assert repr(one.function) == repr(other.function)
    for name in ("lower", "upper", "scale", "instants", "times"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("shape", SHAPES)
def test_rows_on_another_grid_are_those_made_anew(robot, shape):
    before = WalkProblem(robot, preset_task("standard", **MANY, **shape))
    grid = before.grid.with_instants(np.array([0.0123, 0.35, 0.777]))
    moved, anew = before.with_grid(grid), WalkProblem(robot, before.task, grid)
    assert len(moved.blocks) == len(anew.blocks) > 15
    for one, other in zip(moved.blocks, anew.blocks, strict=True):
        same_rows(one, other)
    np.testing.assert_array_equal(moved.rows.lower, anew.rows.lower)
    np.testing.assert_array_equal(moved.variables.scale, anew.variables.scale)


@pytest.mark.parametrize("shape", SHAPES)
def test_rows_beside_a_neighbour_are_those_made_anew(robot, shape):
    """One that is told apart by its pace alone lends its rows; `paced` says which it may not."""
    before = WalkProblem(robot, preset_task("standard", **MANY, **shape))
    paces = [{"speed": 0.83}, {"duration": 0.47}, {"speed": 0.7, "duration": 0.5}]
    turns = [] if "stairs" in shape else [{"turn_rate": 0.3}]
    for changes in (*paces, *turns, {"friction": 0.4}):
        task = before.task.with_changes(**changes)
        beside, anew = WalkProblem(robot, task, neighbour=before), WalkProblem(robot, task)
        for one, other in zip(beside.blocks, anew.blocks, strict=True):
            same_rows(one, other)
