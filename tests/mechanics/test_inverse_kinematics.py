import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import bent_posture, kinematics, moving
from numerics import check_jacobian, relative_error
from reference_cases import biped

from gaitopt.errors import UnreachableError
from gaitopt.mechanics.inverse_kinematics import (
    LegKinematics,
    chain_hessian,
    closure_forces,
    closure_jacobian,
    closure_matrix,
)

SWING = np.array([0.0, 0.16, 0.0])


@pytest.fixture(scope="module")
def legs(robot):
    return LegKinematics(robot)


def pelvis_at(*translation: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(translation))


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.integers(0, 10**6))
def test_inverse_kinematics_undoes_forward_kinematics(seed):
    robot = biped()
    legs = LegKinematics(robot)
    q = bent_posture(robot, np.random.default_rng(seed))
    np.testing.assert_allclose(legs.solve(*legs.placements(q)), q, atol=1e-11)


@settings(deadline=None, derandomize=True, max_examples=60)
@given(st.integers(0, 10**6))
def test_postures_no_walk_has_are_reached_or_refused(seed):
    """Trunk and foot anywhere within 1 rad: never a wrong posture, never a knee bent backwards."""
    robot = biped()
    legs = LegKinematics(robot)
    wild = np.random.default_rng(seed).uniform(-0.7, 0.7, 12)
    wild[list(robot.legs.knees)] = np.abs(wild[list(robot.legs.knees)]) + 0.2
    wanted = legs.placements(wild)
    try:
        q = legs.solve(*wanted)
    except UnreachableError:
        return
    assert q[list(robot.legs.knees)].min() >= 0.0
    for found, target in zip(legs.placements(q), wanted, strict=True):
        np.testing.assert_allclose(found.homogeneous, target.homogeneous, atol=1e-10)


def test_placements_are_pinocchios(robot, legs, rng):
    q = bent_posture(robot, rng)
    at = kinematics(robot, q)
    pelvis, sole = legs.placements(q)
    assert relative_error(pelvis.homogeneous, at.frame(robot.pelvis_frame).homogeneous) < 1e-14
    assert relative_error(sole.homogeneous, at.frame(robot.swing_frame).homogeneous) < 1e-14


def test_axes_are_pinocchios(robot, legs, rng):
    q = bent_posture(robot, rng)
    assert relative_error(legs.axes(q), kinematics(robot, q).axes) < 1e-14


def test_the_same_targets_give_the_same_bits_whatever_came_before(robot, legs, rng):
    q, other = bent_posture(robot, rng), bent_posture(robot, rng)
    targets = legs.placements(q)
    first = legs.solve(*targets)
    legs.solve(*legs.placements(other))
    np.testing.assert_array_equal(legs.solve(*targets), first)


def test_a_distance_beyond_the_leg_names_the_leg_and_the_way_out(robot, legs):
    # The straight leg ends 0.705 m above the ground; the ankle is 0.137 m behind the toes.
    high = pelvis_at(-0.137, 0.08, 0.75)
    with pytest.raises(
        UnreachableError,
        match=r"the stance leg is too short: hip and ankle are 0\.64\d+ m apart, the straight leg "
        r"measures 0\.6000 m; lower the pelvis by at least 0\.04\d+ m or shorten the step",
    ):
        legs.solve(high, pin.SE3(np.eye(3), SWING))


def test_the_swing_leg_is_named_when_it_is_the_one(legs):
    with pytest.raises(UnreachableError, match="the swing leg is too short"):
        legs.solve(pelvis_at(-0.137, 0.08, 0.63), pin.SE3(np.eye(3), SWING - [0.7, 0.0, 0.0]))


def test_a_placement_that_is_not_a_number_is_refused(legs):
    with pytest.raises(UnreachableError, match="found no posture"):
        legs.solve(pelvis_at(-0.137, np.nan, 0.63), pin.SE3(np.eye(3), SWING))


def test_knees_bend_forwards(robot, legs):
    q = legs.solve(pelvis_at(-0.137, 0.08, 0.6), pin.SE3(np.eye(3), SWING))
    assert (q[list(robot.legs.knees)] > 0.3).all()


def targets(pelvis: pin.SE3, sole: pin.SE3, z: np.ndarray) -> tuple[pin.SE3, pin.SE3]:
    """Pelvis and sole displaced by world twists z[:6] and z[6:]."""
    return pin.exp6(pin.Motion(z[:6])) * pelvis, pin.exp6(pin.Motion(z[6:])) * sole


@pytest.mark.parametrize("seed", range(3))
def test_slope(robot, legs, seed):
    q = bent_posture(robot, np.random.default_rng(seed))
    placed = legs.placements(q)
    twists = np.eye(12)
    slope = closure_jacobian(legs.axes(q), twists[:6], twists[6:])
    check_jacobian(lambda z: legs.solve(*targets(*placed, z)), slope, np.zeros(12), step=1e-4)


def test_closure_matrix_gives_the_twists_of_both_targets(robot, legs, rng):
    q, rate = bent_posture(robot, rng), rng.normal(size=12)
    at = kinematics(robot, q, moving(rate))
    frames = robot.pelvis_frame, robot.swing_frame
    expected = [pin.getFrameVelocity(robot.model, at.data, f, pin.WORLD).vector for f in frames]
    assert relative_error(closure_matrix(legs.axes(q)) @ rate, np.concatenate(expected)) < 1e-13


def test_closure_forces_do_the_work_of_the_weights(robot, legs, rng):
    axes, weights = legs.axes(bent_posture(robot, rng)), rng.normal(size=12)
    twists = rng.normal(size=(12, 5))
    forces = closure_forces(axes, weights).ravel()
    work = weights @ closure_jacobian(axes, twists[:6], twists[6:])
    assert relative_error(forces @ twists, work) < 1e-11


def test_curvature_is_the_acceleration_at_constant_rates(robot, legs, rng):
    q, rate, force = bent_posture(robot, rng), rng.normal(size=12), rng.normal(size=6)
    at = kinematics(robot, q, moving(rate))
    acceleration = pin.getFrameAcceleration(robot.model, at.data, robot.swing_frame, pin.WORLD)
    U = chain_hessian(legs.axes(q), force)
    assert relative_error(rate @ U @ rate, force @ acceleration.vector) < 1e-12
    np.testing.assert_allclose(U, U.T, atol=1e-15)
