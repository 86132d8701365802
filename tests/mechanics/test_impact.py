import numpy as np
import pinocchio as pin
import pytest
from motions import bent_posture, full_configuration, kinematics, moving
from numerics import check_jacobian, relative_error

from gaitopt.mechanics.impact import Impact
from gaitopt.mechanics.inverse_dynamics_hessian import DynamicsHessian

SEEDS = range(4)


@pytest.fixture(params=SEEDS)
def before(robot, request):
    """Posture and rates before an impact."""
    rng = np.random.default_rng(request.param)
    return bent_posture(robot, rng), rng.normal(0.0, 2.0, 12)


@pytest.fixture(scope="module")
def impact(robot):
    return Impact(robot)


def kinetic_energy(robot, posture, velocity):
    full = full_configuration(robot, posture)
    return pin.computeKineticEnergy(robot.model, robot.model.createData(), full, velocity)


def momentum(robot, posture, velocity):
    """Linear momentum, and angular about the stance sole's origin, in the world."""
    data = robot.model.createData()
    h = pin.computeCentroidalMomentum(
        robot.model, data, full_configuration(robot, posture), velocity
    )
    return np.concatenate([h.linear, h.angular + np.cross(data.com[0], h.linear)])


def sole_twist(robot, posture, velocity):
    at = kinematics(robot, posture, velocity)
    return pin.getFrameVelocity(robot.model, at.data, robot.swing_frame, pin.LOCAL).vector


def in_world(robot, posture, impulse):
    return kinematics(robot, posture).frame(robot.swing_frame).act(pin.Force(impulse)).vector


def test_the_landing_foot_stops(robot, impact, before):
    after = impact.state(*before).velocity
    moved = np.abs(sole_twist(robot, before[0], moving(before[1]))).max()
    assert moved > 0.1
    assert np.abs(sole_twist(robot, before[0], after)).max() < 1e-11 * moved


def test_kinetic_energy_is_lost(robot, impact, before):
    lost = kinetic_energy(robot, before[0], moving(before[1])) - kinetic_energy(
        robot, before[0], impact.state(*before).velocity
    )
    assert lost > 0.1
    # Of a plastic impact: half the impulse times the velocity that it stops.
    impulse = impact.state(*before).impulse
    stopped = sole_twist(robot, before[0], moving(before[1]))
    assert relative_error(lost, -impulse @ stopped / 2.0) < 1e-10


def test_momentum_changes_by_the_impulse(robot, impact, before):
    posture, rate = before
    state = impact.state(posture, rate)
    jump = momentum(robot, posture, state.velocity) - momentum(robot, posture, moving(rate))
    assert relative_error(jump, in_world(robot, posture, state.impulse)) < 1e-11


def test_a_foot_that_lands_at_rest_takes_no_impulse(robot, impact, before):
    posture, rate = before
    J = kinematics(robot, posture).axes.T
    at_rest = rate - np.linalg.pinv(J) @ (J @ rate)
    assert np.abs(at_rest).max() > 0.1
    state = impact.state(posture, at_rest)
    np.testing.assert_allclose(state.rate_after, at_rest, atol=1e-10)
    assert np.abs(state.impulse).max() < 1e-9 * np.abs(impact.state(posture, rate).impulse).max()


def test_a_foot_that_comes_down_is_pushed_up(robot, impact, rng):
    posture = bent_posture(robot, rng)
    # Rates that lower the swing sole at 0.5 m/s without turning it or moving it sideways.
    at = kinematics(robot, posture)
    J = pin.getFrameJacobian(robot.model, at.data, robot.swing_frame, pin.LOCAL_WORLD_ALIGNED)[
        :, 6:
    ]
    rate = np.linalg.pinv(J) @ [0.0, 0.0, -0.5, 0.0, 0.0, 0.0]
    impulse = impact.state(posture, rate).impulse
    assert in_world(robot, posture, impulse)[2] > 1.0


def test_pinocchio_computes_the_same(robot, impact, before):
    posture, rate = before
    model, data = robot.model, robot.model.createData()
    frame = model.frames[robot.swing_frame]
    contacts = pin.StdVec_RigidConstraintModel()
    contacts.append(
        pin.RigidConstraintModel(
            pin.ContactType.CONTACT_6D, model, frame.parentJoint, frame.placement, pin.LOCAL
        )
    )
    datas = pin.StdVec_RigidConstraintData()
    datas.append(contacts[0].createData())
    pin.initConstraintDynamics(model, data, contacts, datas)
    full = full_configuration(robot, posture)
    after = pin.impulseDynamics(model, data, full, moving(rate), contacts, datas, 0.0)
    state = impact.state(posture, rate)
    assert relative_error(state.velocity, after) < 1e-9
    assert relative_error(state.impulse, datas[0].contact_force.vector) < 1e-9


def test_slope_in_the_posture(impact, before):
    posture, rate = before

    def result(q):
        state = impact.state(q, rate)
        return np.concatenate([state.velocity, state.impulse])

    check_jacobian(result, impact.derivatives(posture, rate)[1].posture, posture, step=1e-4)


def test_slope_in_the_rates(impact, before):
    posture, rate = before

    def result(dq):
        state = impact.state(posture, dq)
        return np.concatenate([state.velocity, state.impulse])

    check_jacobian(result, impact.derivatives(posture, rate)[1].rate, rate, step=1e-3)


@pytest.mark.parametrize("part", ["velocity", "impulse", "both"])
def test_curvature(robot, impact, before, part, rng):
    weights = rng.normal(size=24)
    weights[18:] *= part != "velocity"
    weights[:18] *= part != "impulse"
    state, slope = impact.derivatives(*before)
    weighted = Impact(robot).weighted(*before, state, slope, weights)
    H = weighted.hessian(DynamicsHessian(robot).of(weighted.dynamics))

    def gradient(z):
        slope = impact.derivatives(z[:12], z[12:])[1]
        return weights @ np.hstack([slope.posture, slope.rate])

    check_jacobian(gradient, H, np.concatenate(before), step=1e-4)


def test_slope_carries_the_state(impact, before):
    state, (with_slope, _) = impact.state(*before), impact.derivatives(*before)
    assert relative_error(with_slope.velocity, state.velocity) < 1e-14
    assert relative_error(with_slope.impulse, state.impulse) < 1e-14
    np.testing.assert_array_equal(
        np.concatenate([state.sole_twist, state.rate_after]), state.velocity
    )


def test_both_feet_stay_in_the_other_outcome(robot, impact, before):
    posture, rate = before
    locked = impact.locked(posture, rate)
    np.testing.assert_array_equal(locked.velocity[:6], np.zeros(6))
    stopped = np.abs(sole_twist(robot, posture, moving(rate))).max()
    assert np.abs(sole_twist(robot, posture, locked.velocity)).max() < 1e-11 * stopped
    assert np.abs(locked.velocity).max() > 0.01  # the body between the feet still moves


def test_momentum_changes_by_both_impulses(robot, impact, before):
    posture, rate = before
    locked = impact.locked(posture, rate)
    jump = momentum(robot, posture, locked.velocity) - momentum(robot, posture, moving(rate))
    given = in_world(robot, posture, locked.impulse_landing) + locked.impulse_rear
    assert relative_error(jump, given) < 1e-9


def test_holding_both_feet_costs_more_energy(robot, impact, before):
    posture, rate = before
    free = kinetic_energy(robot, posture, impact.state(posture, rate).velocity)
    assert kinetic_energy(robot, posture, impact.locked(posture, rate).velocity) < free


def test_both_feet_stay_only_if_the_ground_pushes(robot, impact):
    seen = set()
    for seed in range(30):
        rng = np.random.default_rng(seed)
        locked = impact.locked(bent_posture(robot, rng), rng.normal(0.0, 2.0, 12))
        pushes = locked.impulse_landing[2] >= 0.0 and locked.impulse_rear[2] >= 0.0
        assert locked.valid == pushes
        seen.add(locked.valid)
    assert seen == {True, False}


def test_the_robot_keeps_its_weight(robot, impact, before):
    model = robot.model.copy()
    impact.derivatives(*before)
    assert robot.model == model
    assert robot.model.gravity.linear[2] == -9.81
