"""Both feet flat on the ground: the swing leg follows the stance leg."""

import numpy as np
import pinocchio as pin
import pytest
from numerics import check_derivative, relative_error
from synthetic_bipeds import synthetic

from gaitopt.errors import InputError, UnreachableError
from gaitopt.gait.double_support import SWING_SOLE_CHAIN, drive, place
from gaitopt.gait.parameters import FOOT_SPACING, FOOT_YAW, STEP_LENGTH
from gaitopt.mechanics.closed_chain import FREE, Brackets, ClosedChain, ClosedMotion
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.spatial import cross_motion

COUNT, LOCAL, PLACED = 3, 18, 10


@pytest.fixture(scope="module")
def chain(robot):
    return ClosedChain(robot)


@pytest.fixture(scope="module")
def at(robot):
    """(u, du, ddu) at three instants and the quantities of the swing sole, one after another."""
    rng, legs = np.random.default_rng(0), robot.legs
    quantities = np.zeros(PLACED)
    quantities[[STEP_LENGTH, FOOT_SPACING, FOOT_YAW]] = 0.3, legs.stance_width, 0.1
    kinematics = LegKinematics(robot)
    pelvis, _ = kinematics.flat_feet(0.3, legs.stance_width)
    pelvis.translation = pelvis.translation + np.array([0.0, 0.01, -0.03])
    q = kinematics.solve(pelvis, place(SWING_SOLE_CHAIN, quantities)[0])
    size = np.repeat([0.02, 1.0, 5.0], 6)
    free = rng.normal(size=(COUNT, LOCAL)) * size
    free[:, :6] += q[FREE]
    return np.concatenate([free.ravel(), quantities])


def motion_of(chain, at):
    """The closed chain at (u, du, ddu) of the instants and the quantities."""
    free = at[: COUNT * LOCAL].reshape(COUNT, 3, 6).swapaxes(0, 1)
    sole, targets = place(SWING_SOLE_CHAIN, at[COUNT * LOCAL :])
    motion, axes = chain.motion(free, sole)
    return ClosedMotion(motion, axes, targets, drive(SWING_SOLE_CHAIN)), sole


def columns(instant):
    """Where what an instant depends on stands."""
    own = np.arange(LOCAL * instant, LOCAL * (instant + 1))
    return np.concatenate([own, np.arange(COUNT * LOCAL, COUNT * LOCAL + PLACED)])


def test_the_swing_sole_stays_at_rest_on_its_footprint(robot, chain, at):
    closed, sole = motion_of(chain, at)
    model, data = robot.model, robot.model.createData()
    for q, dq, ddq in closed.motion.swapaxes(0, 1):
        full, v, a = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        full[7:], v[6:], a[6:] = q, dq, ddq
        pin.forwardKinematics(model, data, full, v, a)
        where = pin.updateFramePlacement(model, data, robot.swing_frame)
        assert np.abs(pin.log6(sole.inverse() * where).vector).max() < 1e-12
        rate = pin.getFrameVelocity(model, data, robot.swing_frame).vector
        moved = pin.getFrameAcceleration(model, data, robot.swing_frame).vector
        assert np.abs(rate).max() < 1e-12 * np.abs(dq).max() * 10.0
        assert np.abs(moved).max() < 1e-11 * np.abs(ddq).max()
        assert np.abs(dq[6:]).max() > 0.1
        assert np.abs(ddq[6:]).max() > 1.0


@pytest.mark.parametrize("instant", range(COUNT))
def test_slope(chain, at, instant):
    own = columns(instant)
    d = np.random.default_rng(instant).normal(size=own.size)

    def value(amount):
        moved = at.copy()
        moved[own] += amount[0] * d
        return motion_of(chain, moved)[0].motion[:, instant].ravel()

    exact = motion_of(chain, at)[0].jacobian[instant] @ d
    check_derivative(value, exact, np.zeros(1), np.ones(1), step=1e-4, tolerance=1e-6)


@pytest.mark.parametrize("order", ["angles", "rates", "accelerations"])
def test_curvature(chain, at, order):
    w = np.zeros((COUNT, 3, 12))
    w[:, ["angles", "rates", "accelerations"].index(order)] = np.random.default_rng(5).normal(
        size=(COUNT, 12)
    )
    w = w.reshape(COUNT, -1)
    H = motion_of(chain, at)[0].hessian(w)
    assert relative_error(H, H.swapaxes(1, 2)) < 1e-12
    for instant in range(COUNT):
        own = columns(instant)
        d = np.random.default_rng(instant).normal(size=own.size)

        def slope(amount, own=own, d=d, instant=instant):
            moved = at.copy()
            moved[own] += amount[0] * d
            return w[instant] @ motion_of(chain, moved)[0].jacobian[instant]

        exact = H[instant] @ d
        check_derivative(slope, exact, np.zeros(1), np.ones(1), step=1e-4, tolerance=1e-6)


def test_nested_brackets_are_those_of_the_sorted_axes(rng):
    m, rates = 5, rng.normal(size=(2, 5))
    axes, force = rng.normal(size=(2, m, 6)), rng.normal(size=(2, 6))

    def entry(*numbers):
        """Of the first axes in their order and the last one, which must be beyond them."""
        *outer, last = numbers
        if max(outer) >= last:
            return 0.0
        bracket = axes[1, last]
        for number in sorted(outer, reverse=True):
            bracket = cross_motion(axes[1, number], bracket)
        return force[1] @ bracket

    two, three, four = (np.zeros((m,) * k) for k in (2, 3, 4))
    for table in (two, three, four):
        for numbers in np.ndindex(table.shape):
            table[numbers] = entry(*numbers)
    found, r = Brackets(axes, force), rates[1]
    np.testing.assert_allclose(found.pairs[1], two, atol=1e-12)
    np.testing.assert_allclose(found.ended(rates)[1], three @ r, atol=1e-12)
    np.testing.assert_allclose(found.begun(rates)[1], np.einsum("kij,i->kj", three, r), atol=1e-12)
    summed = np.einsum("klij,i,j->kl", four, r, r)
    np.testing.assert_allclose(found.ended_twice(rates)[1], summed, atol=1e-12)


def test_a_robot_whose_swing_leg_does_not_follow_is_refused():
    with pytest.raises(InputError, match="leave out --double-support"):
        ClosedChain(synthetic("seven, waist and arms"))


def test_a_footprint_out_of_reach_is_told(chain, at):
    far = at.copy()
    far[COUNT * LOCAL + STEP_LENGTH] = 1.3
    with pytest.raises(UnreachableError):
        motion_of(chain, far)
