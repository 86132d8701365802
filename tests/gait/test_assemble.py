import json

import numpy as np
import pytest
from numerics import relative_error
from scipy.interpolate import CubicSpline
from walks import walk

from gaitopt.gait.assemble import gait_at, limits_record, robot_record
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record


@pytest.fixture(scope="module")
def walked():
    return walk("added instants")


@pytest.fixture(scope="module")
def gait(walked):
    return gait_at(walked.problem, walked.x, {"status": "as a test", "cost": None})


def test_only_quadrature_nodes_are_samples(gait, walked):
    assert walked.problem.grid.count == 33
    np.testing.assert_allclose(gait.time, np.linspace(0.0, 0.4, 31), atol=1e-15)
    assert len(gait.torque) == len(gait.swing_sole) == len(gait.cop) == 31


def test_arrays_are_those_of_the_step(gait, walked):
    step = walked.problem.step(walked.x)
    assert relative_error(np.stack([gait.q, gait.dq, gait.ddq]), step.motion[:, :31]) < 1e-14
    assert relative_error(gait.torque, step.support.effort[:31, 6:]) < 1e-14
    assert relative_error(gait.ground_wrench, step.support.effort[:31, :6]) < 1e-14
    assert relative_error(gait.swing_sole, step.support.corners[:31]) < 1e-14
    assert relative_error(gait.impulse, step.impact.impulse) < 1e-14
    assert relative_error(gait.rate_after, step.impact.rate_after) < 1e-14
    assert relative_error(gait.rate_before, step.rate_before) < 1e-14


def test_the_next_step_starts_where_the_mirror_says(gait):
    np.testing.assert_allclose(gait.mirror @ gait.q[-1], gait.q[0], atol=1e-12)
    assert relative_error(gait.mirror @ gait.rate_after, gait.dq[0]) < 1e-11
    assert relative_error(gait.dq[-1], gait.rate_before) < 1e-11


def test_feet_turned_out_do_not_shorten_the_step():
    turned = walk("everything free")
    gait = gait_at(turned.problem, turned.x, {})
    step = turned.problem.step(turned.x)
    assert gait.step_length == pytest.approx(step.step_length, rel=1e-12)
    assert gait.speed == pytest.approx(step.step_length / step.duration, rel=1e-12)


def test_knots_are_enough_to_rebuild_the_motion(gait, walked):
    at_knots = CubicSpline(gait.time, gait.q)(gait.knots)
    spline = CubicSpline(gait.knots, at_knots, bc_type=((1, gait.dq[0]), (1, gait.dq[-1])))
    assert relative_error(spline(gait.time), gait.q) < 1e-3
    # The intermediate postures are parameters; there the file says the same.
    knots = walked.x[walked.problem.layout.knots].reshape(-1, 12)
    rebuilt = CubicSpline(
        gait.knots,
        np.vstack([gait.q[0], knots, gait.q[-1]]),
        bc_type=((1, gait.dq[0]), (1, gait.dq[-1])),
    )
    assert relative_error(rebuilt(gait.time), gait.q) < 1e-12


def test_centre_of_pressure_carries_the_load_without_tipping(gait):
    """About it the ground's moment has no horizontal part."""
    force, moment = gait.ground_wrench[:, :3], gait.ground_wrench[:, 3:]
    lever = np.column_stack([gait.cop, np.zeros(31)])
    tipping = (moment - np.cross(lever, force))[:, :2]
    assert np.abs(tipping).max() < 1e-10 * np.abs(moment).max()
    assert np.abs(gait.cop).max() > 0.01


def test_names_and_frames_come_from_the_robot(gait, robot):
    assert gait.joint_names == robot.joint_names
    assert (gait.stance_sole, gait.swing_sole_frame) == ("right_sole", "left_sole")
    assert gait.urdf == robot.urdf
    assert gait.parameter_names[-1] == "pelvis_yaw"


def test_the_record_tells_where_it_came_from(gait, walked):
    problem = walked.problem
    assert gait.meta["status"] == "as a test"
    assert task_from_record(gait.meta["task"]) == problem.task
    assert gait.meta["mass"] == pytest.approx(56.87)
    assert gait.meta["duration"] == 0.4
    assert gait.meta["step_length"] == problem.step(walked.x).step_length
    np.testing.assert_allclose(gait.meta["instants"], [0.11, 0.777])
    assert gait.meta["sole"]["heel"] == -0.214


def test_what_is_given_wins(gait, walked):
    assert gait.meta["cost"] is None
    plain = gait_at(walked.problem, walked.x, {})
    assert plain.meta["cost"] == pytest.approx(walked.problem.values(walked.x).cost)


def test_limits_that_do_not_exist_are_none(robot):
    problem = WalkProblem(robot, preset_task(torque_limit=44.0))
    record = limits_record(problem)
    assert record["torque"] == [44.0] * 12
    assert record["speed"] == [10.0] * 12
    assert record["lower"] == list(robot.limits.lower)
    from dataclasses import replace

    endless = replace(robot, limits=replace(robot.limits, upper=np.full(12, np.inf)))
    assert limits_record(WalkProblem(endless, preset_task()))["upper"] == [None] * 12
    json.dumps(robot_record(robot), allow_nan=False)
