"""Multipliers: the linear map of a step against the nonlinear walk, its parts against others."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import relative_error
from sample_gait import sample_gait
from scipy.linalg import expm

from gaitopt.simulate.stability import BANDWIDTH, INTERVALS, _Walk, stability


@pytest.fixture(scope="module")
def gait():
    return sample_gait()


@pytest.fixture(scope="module")
def walk(gait):
    return _Walk(gait)


@pytest.fixture(scope="module")
def orbit(gait):
    return stability(gait)


def test_the_fixed_sole_needs_the_torques_of_the_gait(gait, walk):
    """And its wrench is that on the ground."""
    times = np.linspace(0.0, gait.duration, 2 * INTERVALS + 1)
    samples = gait.trajectory.at(times, before=times > 0.0)
    assert relative_error(walk.torque, samples.torque[:, walk.robot.body.moving]) < 1e-11
    row = 70
    wrench = walk.dynamics(walk.q[row], walk.dq[row])[2] @ np.append(walk.ddq[row], 1.0)
    R = walk.place.rotation
    on_foot = samples.wrench[row, 0]
    assert relative_error(wrench, np.concatenate([R @ on_foot[:3], R @ on_foot[3:]])) < 1e-11


def test_linear_dynamics_are_those_of_pinocchio(walk):
    """A against differences of Pinocchio's inverse dynamics, the base moved by the fixed sole."""
    body, row, k = walk.robot.body, 101, 50
    model = body.model
    data = model.createData()
    frame = model.getFrameId(body.sole_names[0])

    def torque(*motion):
        q, dq, ddq = (np.empty(walk.n) for _ in range(3))
        for values, given in zip((q, dq, ddq), motion, strict=True):
            values[body.moving] = given
        at = np.concatenate([pin.neutral(model)[:7], q])
        pin.framesForwardKinematics(model, data, at)
        at[:7] = pin.SE3ToXYZQUAT(walk.place * data.oMf[frame].inverse())
        J = pin.computeFrameJacobian(model, data, at, frame, pin.LOCAL)
        v = np.concatenate([np.linalg.solve(J[:, :6], -J[:, 6:] @ dq), dq])
        pin.forwardKinematics(model, data, at, v, np.zeros(model.nv))
        drift = pin.getFrameAcceleration(model, data, frame, pin.LOCAL).vector
        a = np.concatenate([np.linalg.solve(J[:, :6], -J[:, 6:] @ ddq - drift), ddq])
        effort = pin.rnea(model, data, at, v, a)
        found = effort[6:] - J[:, 6:].T @ np.linalg.solve(J[:, :6].T, effort[:6])
        return found[body.moving]

    q, dq, ddq = walk.q[row], walk.dq[row], walk.ddq[row]
    assert relative_error(torque(q, dq, ddq), walk.torque[row]) < 1e-11
    change = walk._differences(lambda q, dq: torque(q, dq, ddq), q, dq)
    n = walk.n
    assert relative_error(walk.A[k][n:], -walk.B[k][n:] @ change) < 1e-6


def test_the_walk_contracts_as_the_map_says(orbit):
    """Within a hundredth, for feedbacks whose multipliers differ by far."""
    for feedback in (orbit.joint_pd, orbit.lqr):
        assert feedback.measured == pytest.approx(feedback.predicted, rel=0.01)
        assert feedback.predicted == pytest.approx(feedback.multiplier, rel=0.2)
    assert orbit.lqr.region > 3.0 * orbit.joint_pd.region


def test_a_map_that_does_not_know_the_landing_is_wrong(walk):
    """Without the jump by the landing time the prediction is off by far."""
    gains = walk.lqr()
    Phi = np.eye(2 * walk.n)
    for k in range(INTERVALS):
        Phi = expm((walk.A[k] - walk.B[k] @ gains[k]) * walk.h) @ Phi
    late = np.eye(2 * walk.n) + np.outer(
        np.concatenate([walk.dq[-1], walk.ddq[-1]]), walk.landing_row(walk.middle)
    )
    blind = walk.jump @ np.linalg.inv(late) @ Phi
    x = 1e-5 * np.random.default_rng(2).normal(size=2 * walk.n)
    found = walk.walked(x, gains) - walk.walked(np.zeros_like(x), gains)
    assert relative_error(walk.jump @ Phi @ x, found) < 0.02
    assert relative_error(blind @ x, found) > 0.3


def test_joint_feedback_is_scaled_by_the_joints(walk):
    gains = walk.joint_pd()
    D = walk.dynamics(walk.q[0], walk.dq[0])[0]
    assert np.diag(gains[:, : walk.n]) == pytest.approx(BANDWIDTH**2 * np.diag(D))
    assert relative_error(gains[:, walk.n :], 2.0 / BANDWIDTH * gains[:, : walk.n]) < 1e-14


def test_the_landing_moves_as_the_height_does(walk):
    """Lower a leg, and it lands sooner: heights of a corner along the disturbed motion."""
    row, x = walk.landing_row(walk.corners[0]), np.zeros(2 * walk.n)
    x[: walk.n] = 1e-6 * np.random.default_rng(1).normal(size=walk.n)
    low = [walk.height(walk.q[-1] + s * x[: walk.n], walk.corners[0]) for s in (-0.5, 0.5)]
    h = 1e-6
    falls = [walk.height(walk.q[-1] + s * h * walk.dq[-1], walk.corners[0]) for s in (-0.5, 0.5)]
    expected = -(low[1] - low[0]) / ((falls[1] - falls[0]) / h)
    assert row @ x == pytest.approx(expected, rel=1e-5)


def test_growth_is_that_of_the_pendulum(gait, orbit):
    height = np.log(orbit.growth) / gait.duration
    assert 9.81 / height**2 == pytest.approx(0.8, abs=0.2)  # of the centre of mass [m]
