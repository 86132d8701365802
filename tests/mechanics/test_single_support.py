import numpy as np
import pinocchio as pin
import pytest
from motions import full_configuration, kinematics, moving, random_motion
from numerics import check_jacobian, relative_error

from gaitopt.mechanics.forward_kinematics import ForwardKinematics, pseudo_inertias
from gaitopt.mechanics.single_support import SingleSupport
from gaitopt.mechanics.spatial import world_inertias

COUNT = 3
G = 9.81
BLOCKS = ("q", "dq", "ddq")


@pytest.fixture
def motion(robot, rng):
    return random_motion(robot, rng, COUNT)


@pytest.fixture
def support(robot):
    return SingleSupport(robot, COUNT)


def test_ground_force_is_mass_times_acceleration_minus_gravity(robot, support, motion):
    force = support.state(*motion).effort[:, :3]
    for k, (q, dq, ddq) in enumerate(zip(*motion, strict=True)):
        at = kinematics(robot, q, moving(dq), moving(ddq))
        expected = robot.mass * (at.com_acceleration - robot.model.gravity.linear)
        assert relative_error(force[k], expected) < 1e-11


def test_ground_moment_changes_the_angular_momentum(robot, support, motion):
    effort = support.state(*motion).effort
    for k, (q, dq, ddq) in enumerate(zip(*motion, strict=True)):
        at = kinematics(robot, q)
        pin.computeCentroidalMomentumTimeVariation(
            robot.model, at.data, full_configuration(robot, q), moving(dq), moving(ddq)
        )
        # About the sole origin: that about the centre of mass plus the force's lever there.
        expected = at.data.dhg.angular + np.cross(at.com, effort[k, :3])
        assert relative_error(effort[k, 3:6], expected) < 1e-10


def test_motor_power_is_the_change_of_energy(robot, support, motion):
    """d(kinetic + potential)/dt = Gamma . dq, with the energies differenced along the motion."""
    effort = support.state(*motion).effort
    for k, (q, dq, ddq) in enumerate(zip(*motion, strict=True)):

        def energy(t, q=q, dq=dq, ddq=ddq):
            angles, rates = q + t * dq + t**2 / 2.0 * ddq, dq + t * ddq
            at = kinematics(robot, angles, moving(rates))
            full = full_configuration(robot, angles)
            kinetic = pin.computeKineticEnergy(robot.model, at.data, full, moving(rates))
            return kinetic + pin.computePotentialEnergy(robot.model, at.data, full)

        h = 1e-4
        rate = (8.0 * (energy(h) - energy(-h)) - energy(2.0 * h) + energy(-2.0 * h)) / (12.0 * h)
        assert relative_error(effort[k, 6:] @ dq, rate) < 1e-8


def test_standing_still_the_centre_of_pressure_is_below_the_centre_of_mass(robot, support, motion):
    q, zero = motion[0], np.zeros((COUNT, 12))
    wrench = support.state(q, zero, zero).effort[:, :6]
    centres = np.array([kinematics(robot, angles).com for angles in q])
    weight = robot.mass * G
    np.testing.assert_allclose(wrench[:, :3], np.tile([0, 0, weight], (COUNT, 1)), atol=1e-9)
    assert relative_error(-wrench[:, 4] / weight, centres[:, 0]) < 1e-12
    assert relative_error(wrench[:, 3] / weight, centres[:, 1]) < 1e-12


def test_corners_are_those_of_the_swing_sole(robot, support, motion):
    corners = support.state(*motion).corners
    for k, q in enumerate(motion[0]):
        sole = kinematics(robot, q).frame(robot.swing_frame)
        expected = [sole.act(c) for c in robot.sole.corners]
        assert relative_error(corners[k], expected) < 1e-13


@pytest.mark.parametrize("block", range(3), ids=BLOCKS)
def test_slope_of_wrench_and_torques(support, motion, block):
    slope = support.derivatives(*motion)[1].effort[:, :, 12 * block : 12 * block + 12]

    def effort(value):
        parts = list(motion)
        parts[block] = motion[block] + value
        return support.state(*parts).effort

    # Every instant moves by the same twelve amounts: instants do not see each other.
    check_jacobian(effort, slope, np.zeros(12), step=1e-4)


def test_slope_of_the_corners(support, motion):
    slope = support.derivatives(*motion)[1].corners
    q, dq, ddq = motion
    check_jacobian(lambda d: support.state(q + d, dq, ddq).corners, slope, np.zeros(12), step=1e-3)


def test_slope_carries_the_kinematics_of_its_motion(robot, support, motion):
    slope = support.derivatives(*motion)[1]
    for k, q in enumerate(motion[0]):
        assert relative_error(slope.axes[k], kinematics(robot, q).axes) < 1e-13
    np.testing.assert_array_equal(slope.gravity, [0.0, 0.0, -G, 0.0, 0.0, 0.0])


def test_bodies_are_where_the_posture_puts_them(robot, motion):
    placed = ForwardKinematics(robot.model).placed(motion[0])
    inertias = world_inertias(pseudo_inertias(robot.model), placed.frames)[:, 1:]
    for k, q in enumerate(motion[0]):
        at = kinematics(robot, q)
        expected = [at.data.oMi[j].act(robot.model.inertias[j]).matrix() for j in range(2, 14)]
        assert relative_error(inertias[k], expected) < 1e-13


def test_state_and_slope_tell_the_same(support, motion):
    state, (with_slope, _) = support.state(*motion), support.derivatives(*motion)
    assert relative_error(with_slope.effort, state.effort) < 1e-13
    assert relative_error(with_slope.corners, state.corners) < 1e-13


def test_results_do_not_change_when_the_object_is_used_again(robot, support, motion, rng):
    state, (again, slope) = support.state(*motion), support.derivatives(*motion)
    kept = [a.copy() for a in (state.effort, state.corners, again.effort, slope.effort)]
    other = random_motion(robot, rng, COUNT)
    support.state(*other)
    support.derivatives(*other)
    for before, after in zip(
        kept, (state.effort, state.corners, again.effort, slope.effort), strict=True
    ):
        np.testing.assert_array_equal(after, before)
    np.testing.assert_array_equal(support.state(*motion).effort, state.effort)


def test_the_robot_is_not_changed(robot, support, motion):
    before = robot.model.copy()
    support.derivatives(*motion)
    assert robot.model == before
