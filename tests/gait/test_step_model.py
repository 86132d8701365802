"""One step of the walk: what it must be physically, and its derivatives."""

import numpy as np
import pytest
from motions import kinematics
from numerics import check_differences, jacobian_difference, relative_error, steps
from reference_cases import biped
from walks import walk

from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.parameters import GEOMETRY_NAMES
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step_model import StepModel, cycle, cycle_derivatives

CHECKED = ("guess", "one posture", "everything free", "infeasible 43", "upright, everything free")
TURNING = (
    "upright, toe off, everything free",
    "upright, lifted, toe off, seven joints, waist, arms",
    "upright, heel strike, toe off, everything free",
    "upright, lifted, heel strike, five joints, soft",
)
at_walks = pytest.mark.parametrize("name", CHECKED)
LEFT_TO_RIGHT = np.array([1.0, -1.0, 1.0])
# Quantities that change sign when left and right are exchanged.
MIRRORED = ("pelvis_lateral", "foot_spacing", "pelvis_yaw", "pelvis_roll", "foot_yaw")


@pytest.mark.parametrize("name", [*CHECKED, "lifted, everything free", *TURNING])
def test_every_quantity_has_its_slope(name):
    problem, x = walk(name).problem, walk(name).x
    scale = problem.variables.scale
    slopes = cycle_derivatives(problem.models, x)[1][0].jacobians

    def everything(point):
        step = cycle(problem.models, point)[0]
        return np.concatenate([step.read(what).ravel() for what in quantities.ALL])

    found = [jacobian_difference(everything, x, scale, h) for h in steps(1e-5)]
    start = 0
    for what in quantities.ALL:
        exact = slopes[what].reshape(-1, x.size)
        rows = slice(start, start + len(exact))
        read = {one for b in problem.blocks for one in b.reads}
        read |= {quantities.ACCELERATIONS, quantities.SOLE_TWIST}
        if what not in read:
            assert exact.size == 0
            continue
        check_differences(exact * scale, [d[rows] for d in found])
        start = rows.stop
    assert start == len(found[0])


@at_walks
def test_motion_has_its_slope(name):
    problem, x = walk(name).problem, walk(name).x
    slope = cycle_derivatives(problem.models, x)[1][0].motion  # (N, 36, P)
    scale = problem.variables.scale
    for part in range(3):
        found = [
            jacobian_difference(
                lambda p, k=part: cycle(problem.models, p)[0].motion[k], x, scale, h
            )
            for h in steps(1e-5)
        ]
        check_differences(slope[:, 12 * part : 12 * part + 12] * scale, found)


@at_walks
def test_the_step_is_periodic(robot, name):
    """Eqs. (26) and (27): the next step is the mirror image, starting as this one did."""
    step = walk(name).problem.step(walk(name).x)
    E, start, end = robot.mirror, 0, walk(name).problem.grid.nodes - 1
    np.testing.assert_allclose(step.motion[0, start], E @ step.motion[0, end], atol=1e-12)
    np.testing.assert_allclose(step.motion[0, start], step.posture.q_start, atol=1e-12)
    assert relative_error(step.motion[1, end], step.rate_before) < 1e-11
    assert relative_error(step.motion[1, start], E @ step.impact.rate_after) < 1e-11


@at_walks
def test_both_feet_are_flat_at_both_ends(robot, name):
    walked = walk(name)
    step, last = walked.problem.step(walked.x), walked.problem.grid.nodes - 1
    for instant in (0, last):
        np.testing.assert_allclose(step.support.corners[instant, :, 2], 0.0, atol=1e-11)
    middle = step.support.corners.mean(axis=1)
    # Forward by two step lengths if both feet point ahead.
    if step.geometry[GEOMETRY_NAMES.index("foot_yaw")] == 0.0:
        travelled = middle[last] - middle[0]
        np.testing.assert_allclose(travelled, [2.0 * step.step_length, 0.0, 0.0], atol=1e-11)


@at_walks
def test_rates_are_the_slope_of_the_angles(name):
    """d/dt q = dq and d/dt dq = ddq; Simpson is exact on cubics between knots."""
    problem, x = walk(name).problem, walk(name).x
    fine = WalkProblem(problem.robot, problem.task, uniform_grid(241))
    step = fine.step(x)
    h = step.duration / 240.0
    for order in (0, 1):
        value, rate = step.motion[order], step.motion[order + 1]
        gained = h / 3.0 * (rate[:-2:2] + 4.0 * rate[1:-1:2] + rate[2::2])
        assert relative_error(gained, value[2::2] - value[:-2:2]) < 1e-9


@at_walks
def test_quantities_are_read_from_the_parts_they_belong_to(name):
    step = walk(name).problem.step(walk(name).x)
    np.testing.assert_array_equal(step.read(quantities.TORQUE), step.support.effort[:, 6:])
    np.testing.assert_array_equal(step.read(quantities.WRENCH), step.support.effort[:, :6])
    np.testing.assert_array_equal(step.read(quantities.CORNERS)[:, 3:6], step.support.corners[:, 1])
    np.testing.assert_array_equal(step.read(quantities.ANGLES), step.motion[0])
    np.testing.assert_array_equal(step.read(quantities.RATES), step.motion[1])
    np.testing.assert_array_equal(step.read(quantities.IMPULSE)[0], step.impact.impulse)
    np.testing.assert_array_equal(step.read(quantities.SOLE_TWIST)[0], step.impact.sole_twist)
    np.testing.assert_array_equal(step.read(quantities.LEGS), step.posture.legs)
    np.testing.assert_array_equal(step.read(quantities.TRAVEL), [[step.step_length, step.duration]])


@at_walks
def test_legs_are_measured_on_the_posture(robot, name):
    step = walk(name).problem.step(walk(name).x)
    at, legs = kinematics(robot, step.posture.q_start), robot.legs
    hips = [at.frame(robot.pelvis_frame).act(h) for h in legs.hips]
    ankles = [legs.ankles[0], at.frame(robot.swing_frame).act(legs.ankles[1])]
    assert relative_error(step.read(quantities.LEGS), np.array(hips) - ankles) < 1e-10


def mirrored_parameters(problem: WalkProblem, other: WalkProblem, x: np.ndarray) -> np.ndarray:
    """The same walk on the other foot, seen in a mirror."""
    robot, left = problem.robot, other.robot
    order = [robot.joint_names.index(n) for n in left.joint_names]
    to_left = robot.mirror[order]
    layout = problem.layout
    geometry = layout.geometry_of(x)
    geometry[[GEOMETRY_NAMES.index(n) for n in MIRRORED]] *= -1.0
    knots = x[layout.knots].reshape(-1, 12) @ to_left.T
    return other.layout.pack(knots, to_left @ x[layout.rates], np.zeros(12), geometry)


@at_walks
def test_the_mirrored_robot_walks_the_mirrored_step(robot, name):
    problem, x = walk(name).problem, walk(name).x
    left = biped("left")
    other = WalkProblem(left, problem.task, problem.grid)
    order = [robot.joint_names.index(n) for n in left.joint_names]
    to_left = robot.mirror[order]
    step = problem.step(x)
    there = other.step(mirrored_parameters(problem, other, x))
    for what in (quantities.TORQUE, quantities.ANGLES, quantities.RATES):
        assert relative_error(there.read(what), step.read(what) @ to_left.T) < 1e-9
    wrench, mirrored = step.read(quantities.WRENCH), there.read(quantities.WRENCH)
    assert relative_error(mirrored[:, :3], wrench[:, :3] * LEFT_TO_RIGHT) < 1e-9
    assert relative_error(mirrored[:, 3:], -wrench[:, 3:] * LEFT_TO_RIGHT) < 1e-9
    assert relative_error(there.impact.impulse[:3], step.impact.impulse[:3] * LEFT_TO_RIGHT) < 1e-9
    swapped = step.support.corners[:, [1, 0, 3, 2]] * LEFT_TO_RIGHT
    assert relative_error(there.support.corners, swapped) < 1e-9
    assert relative_error(other.cost.value(there), problem.cost.value(step)) < 1e-9


def test_the_slope_carries_the_step():
    problem, x = walk("guess").problem, walk("guess").x
    model = StepModel(problem.robot, problem.layout, problem.grid)
    (step,), ((with_slope,), _) = cycle((model,), x), cycle_derivatives((model,), x)
    assert relative_error(with_slope.motion, step.motion) < 1e-13
    assert relative_error(with_slope.support.effort, step.support.effort) < 1e-12
    assert relative_error(with_slope.impact.velocity, step.impact.velocity) < 1e-12


@pytest.mark.parametrize(
    ("name", "quantity", "value"),
    [
        ("everything free", "duration", 0.0),
        ("everything free", "duration", -0.4),
    ],
)
def test_a_step_that_is_none_is_refused(name, quantity, value):
    problem, x = walk(name).problem, walk(name).x.copy()
    x[problem.layout.index(quantity)] = value
    with pytest.raises(EvaluationError, match="is not a step"):
        cycle(problem.models, x)[0]
    with pytest.raises(EvaluationError, match="is not a step"):
        cycle_derivatives(problem.models, x)
