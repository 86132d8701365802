import numpy as np
import pytest
from motions import bent_posture, kinematics
from numerics import relative_error
from reference_cases import biped

from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.double_support import InverseKinematicsSupport, JointAngleSupport
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import GEOMETRY
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Start
from gaitopt.solvers.sqp import SQP

GEOMETRY_POINT = np.array([0.6, 0.07, -0.3, 0.1, 0.15, 0.4, 0.05, -0.04, 0.06, 0.4])


@pytest.fixture(scope="module")
def boundary(robot):
    return JointAngleSupport(robot)


def test_gaps_vanish_where_the_inverse_kinematics_closes(robot, boundary):
    q = InverseKinematicsSupport(robot).posture(GEOMETRY_POINT, np.zeros(0)).q_start
    closed = boundary.posture(GEOMETRY_POINT, q)
    opened = boundary.posture(GEOMETRY_POINT, q + 1e-3)
    assert np.abs(closed.gaps).max() < 1e-11
    assert np.abs(opened.gaps).max() > 1e-4


def test_loops_lead_from_where_bodies_are_to_where_they_ought_to_be(robot, boundary, rng):
    q = bent_posture(robot, rng)
    posture, at = boundary.posture(GEOMETRY_POINT, q), kinematics(robot, q)
    for frame, loop, target in zip(
        (robot.pelvis_frame, robot.swing_frame),
        posture.loops,
        (posture.pelvis, posture.sole),
        strict=True,
    ):
        assert relative_error((at.frame(frame) * loop).homogeneous, target.homogeneous) < 1e-13


def test_a_leg_out_of_reach_is_a_gap_and_not_an_error(robot, boundary, rng):
    high = GEOMETRY_POINT + np.eye(len(GEOMETRY))[0]
    gaps = boundary.posture(high, bent_posture(robot, rng)).gaps
    assert np.isfinite(gaps).all()
    assert np.abs(gaps[0, :3]).max() > 0.1


def test_what_is_no_number_is_refused(boundary):
    with pytest.raises(EvaluationError, match="geometric quantity"):
        boundary.posture(GEOMETRY_POINT * np.nan, np.zeros(12))


def test_both_forms_see_the_same_step(robot):
    closed, lifted = (
        WalkProblem(robot, preset_task(boundary=form)) for form in ("closed", "lifted")
    )
    a, b = closed.step(first_guess(closed)), lifted.step(first_guess(lifted))
    for what in quantities.ALL:
        if a.read(what).size:
            assert relative_error(a.read(what), b.read(what)) < 1e-12
    assert lifted.layout.size == closed.layout.size + 12
    assert lifted.layout.names[36:48] == tuple(f"{j}_at_start" for j in robot.joint_names)


def test_both_forms_have_the_same_optimum(robot):
    found = []
    for form in ("closed", "lifted"):
        problem = WalkProblem(robot, preset_task(boundary=form, speed=0.8, samples=15))
        found.append(SQP().solve(problem, Start(first_guess(problem))))
    assert found[0].status.name == found[1].status.name == "OPTIMAL"
    assert relative_error(found[0].cost, found[1].cost) < 1e-8


def test_rows_of_the_loops_are_named(robot):
    problem = WalkProblem(robot, preset_task(boundary="lifted"))
    rows = problem.rows_of("closure")
    assert problem.describe(rows.start) == "pelvis closure along x"
    assert problem.describe(rows.stop - 1) == "swing sole closure about z"


def test_a_loop_turned_by_half_a_turn_is_no_walk():
    """Its gap, a sine, vanishes as if it closed."""
    problem = WalkProblem(biped(), preset_task(boundary="lifted"))
    x = first_guess(problem)
    problem.step(x)
    quantity = problem.layout.index("pelvis_yaw")
    x[quantity] += np.pi
    with pytest.raises(EvaluationError, match="turned by more than a right angle"):
        problem.step(x)
