"""The impact that swaps the legs, Eqs. (14)-(20), and its exact derivatives, Eqs. (58)-(62).

The landing sole stops at once, flat on the ground; the old stance foot is free to leave:

    [ D  -J' ] [ V+ ]   [ D V- ]
    [ J   0  ] [ I  ] = [  0   ]

with V = (twist of the old stance sole, joint rates), J the Jacobian of the landing sole in its own
frame (D12' of Eq. 24 at the sole) and I the impulse of the ground on the landing foot, upward
positive (-I13 of the paper).

Exact second derivatives of the impact, from the closed forms of a serial chain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.inverse_dynamics_hessian import (
    TorqueCurvature,
    WeightedDynamics,
    velocity_curvature,
    velocity_rate_slope,
)
from gaitopt.mechanics.spatial import moved, solve
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

BASE = 6
NV = 18


@dataclass(frozen=True)
class ImpactState:
    """The robot just after the impact.

    Attributes:
        velocity: V+: linear and angular velocity of the old stance sole in its frame
            [m/s, rad/s], then the joint rates [rad/s], shape (18,).
        impulse: of the ground on the landing foot, force then moment, in the landing sole frame
            [N.s, N.m.s], shape (6,).
    """

    velocity: Array
    impulse: Array

    @property
    def sole_twist(self) -> Array:
        """Twist of the old stance sole in its own frame, shape (6,)."""
        return self.velocity[:BASE]

    @property
    def rate_after(self) -> Array:
        """Joint rates after the impact [rad/s], shape (12,)."""
        return self.velocity[BASE:]


@dataclass(frozen=True)
class ImpactSlope:
    """Derivatives of (V+, I), shape (24, 12) each.

    Attributes:
        posture: with respect to the joint angles at the impact.
        rate: with respect to the joint rates before the impact.
        kkt: the matrix of the linear system, shape (24, 24).
    """

    posture: Array
    rate: Array
    kkt: Array


@dataclass(frozen=True)
class LockedImpact:
    """The other outcome of section 2.4.1: both feet stay on the ground.

    Attributes:
        velocity: V+, shape (18,); the first six entries are zero.
        impulse_landing, impulse_rear: ground on foot, each in its sole frame, shape (6,).
    """

    velocity: Array
    impulse_landing: Array
    impulse_rear: Array

    @property
    def valid(self) -> bool:
        """Whether the ground only pushes: both vertical impulses are upward."""
        return bool(self.impulse_landing[2] >= 0.0 and self.impulse_rear[2] >= 0.0)


class Impact:
    """Evaluates the impact of one robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._model = robot.model
        self._weightless = robot.model.copy()
        self._weightless.gravity = pin.Motion.Zero()
        self._data = self._weightless.createData()
        self._frame = robot.swing_frame
        foot = robot.model.frames[self._frame]
        self._last = foot.parentJoint
        self._to_last = foot.placement
        self._q = pin.neutral(robot.model)
        self._forces = pin.StdVec_Force()
        self._forces.extend([pin.Force.Zero()] * robot.model.njoints)

    def _configuration(self, posture: Array) -> Array:
        self._q[BASE + 1 :] = posture
        q: Array = self._q
        return q

    def _matrices(self, posture: Array) -> tuple[Array, Array]:
        """Inertia matrix D (18, 18) and landing Jacobian J (6, 18) at a posture."""
        q = self._configuration(posture)
        D = np.array(pin.crba(self._weightless, self._data, q))
        J = pin.computeFrameJacobian(self._weightless, self._data, q, self._frame, pin.LOCAL)
        return D, J

    def _kkt(self, D: Array, J: Array) -> Array:
        K = np.zeros((NV + BASE, NV + BASE))
        K[:NV, :NV] = D
        K[:NV, NV:] = -J.T
        K[NV:, :NV] = J
        return K

    def state(self, posture: Array, rate_before: Array) -> ImpactState:
        """Return the state after the impact, Eqs. (19)-(20).

        Args:
            posture: joint angles at the impact [rad], shape (12,).
            rate_before: joint rates before it [rad/s], shape (12,); the stance foot is at rest.
        """
        D, J = self._matrices(posture)
        rhs = np.concatenate([D[:, BASE:] @ rate_before, np.zeros(BASE)])
        y = solve(self._kkt(D, J), rhs)
        return ImpactState(y[:NV], y[NV:])

    def slope(self, posture: Array, rate_before: Array) -> tuple[ImpactState, ImpactSlope]:
        """Return the state and its exact derivatives, Eqs. (58)-(62)."""
        D, J = self._matrices(posture)
        K = self._kkt(D, J)
        rhs = np.concatenate([D[:, BASE:] @ rate_before, np.zeros(BASE)])
        y = solve(K, rhs)
        state = ImpactState(y[:NV], y[NV:])
        sides = np.zeros((NV + BASE, 24))
        sides[:NV, :12], sides[NV:, :12] = self._residual_slopes(posture, rate_before, state)
        sides[:, :12] *= -1.0
        sides[:NV, 12:] = D[:, BASE:]
        slopes = solve(K, sides)
        return state, ImpactSlope(slopes[:, :12], slopes[:, 12:], K)

    def _residual_slopes(
        self, posture: Array, rate_before: Array, state: ImpactState
    ) -> tuple[Array, Array]:
        """Derivatives of D (V+ - V-) - J' I and of J V+ with respect to the posture alone.

        The first is an inverse dynamics without gravity and velocity whose acceleration is the
        jump of velocity and whose external force is the impulse (Eq. 59 without forming dD).
        """
        q = self._configuration(posture)
        jump = state.velocity.copy()
        jump[BASE:] -= rate_before
        self._forces[self._last] = self._to_last.act(pin.Force(state.impulse))
        pin.computeRNEADerivatives(
            self._weightless, self._data, q, np.zeros(NV), jump, self._forces
        )
        momentum = self._data.dtau_dq[:, BASE:].copy()
        pin.computeForwardKinematicsDerivatives(
            self._weightless, self._data, q, state.velocity, np.zeros(NV)
        )
        landing, _ = pin.getFrameVelocityDerivatives(
            self._weightless, self._data, self._frame, pin.LOCAL
        )
        return momentum, landing[:, BASE:]

    def locked(self, posture: Array, rate_before: Array) -> LockedImpact:
        """Return the outcome in which both feet stay on the ground (section 2.4.1, case two)."""
        D, J = self._matrices(posture)
        both = np.vstack([np.eye(BASE, NV), J])
        K = np.block([[D, -both.T], [both, np.zeros((12, 12))]])
        rhs = np.concatenate([D[:, BASE:] @ rate_before, np.zeros(12)])
        y = solve(K, rhs)
        velocity = y[:NV].copy()
        velocity[:BASE] = 0.0
        return LockedImpact(velocity, y[NV + BASE :], y[NV : NV + BASE])


@dataclass(frozen=True)
class WeightedImpact:
    """An impact and a weighted sum of its result, ready for the second derivatives.

    With F(y, z) = 0 the equations of the impact, y = (V+, I), z = (posture, rate before), and
    K' l = -weights, the Hessian is that of l . F along (dz, dy/dz dz).

    Attributes:
        dynamics: D (V+ - V-) as the inverse dynamics of one instant at rest, weighted by l.
        state, slope: the impact and its derivatives.
        foot: placement of the landing sole.
        adjoint: l, shape (24,).
    """

    dynamics: WeightedDynamics
    state: ImpactState
    slope: ImpactSlope
    foot: pin.SE3
    adjoint: Array

    def hessian(self, inertial: TorqueCurvature) -> Array:
        """Return the Hessian in (posture, rate before), shape (24, 24).

        Args:
            inertial: second derivatives of `dynamics`.
        """
        qq, by_result = self._landing()
        qq += inertial.qq[0]
        by_result[:, :BASE] += inertial.base[0]
        by_result[:, BASE:NV] += inertial.qa[0]
        mixed = by_result @ np.hstack([self.slope.posture, self.slope.rate])
        mixed[:, 12:] -= inertial.qa[0]  # the jump V+ - V- sees minus the rate before
        H = np.zeros((24, 24))
        H[:12, :12] = qq
        H[:12] += mixed
        H[:, :12] += mixed.T
        return H

    def _landing(self) -> tuple[Array, Array]:
        """Second derivatives of l . (-J' I, J V+).

        Returns:
            In the posture twice (12, 12); in the posture and (V+, I) (12, 24).
        """
        axes, state = self.dynamics.axes[0], self.state
        momentum, landing = self.adjoint[:NV], self.adjoint[NV:]
        impulse = self.foot.act(pin.Force(state.impulse)).vector
        push = self.foot.act(pin.Force(landing)).vector
        qq = velocity_curvature(axes, state.rate_after, state.sole_twist, push)
        qq -= velocity_curvature(axes, momentum[BASE:], momentum[:BASE], impulse)
        by_result = np.empty((12, NV + BASE))
        by_result[:, BASE:NV], by_result[:, :BASE] = velocity_rate_slope(axes, push)
        by_result[:, NV:] = -_landing_slopes(axes, momentum, self.foot)
        return qq, by_result


class ImpactCurvature:
    """Second derivatives of any weighted sum of the robot's state after the impact."""

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model
        self._data = robot.model.createData()
        foot = robot.model.frames[robot.swing_frame]
        self._last, self._to_last = foot.parentJoint, foot.placement
        self._q = pin.neutral(robot.model)

    def weighted(
        self,
        posture: Array,
        rate_before: Array,
        state: ImpactState,
        slope: ImpactSlope,
        weights: Array,
    ) -> WeightedImpact:
        """Return weights . (V+, I) but for the curvature of the dynamics, had with that of a step.

        Args:
            posture, rate_before, state, slope: the impact and its derivatives.
            weights: shape (24,).
        """
        adjoint = -solve(slope.kkt.T, weights)
        self._q[BASE + 1 :] = posture
        J = pin.computeJointJacobians(self._model, self._data, self._q)
        dynamics = WeightedDynamics(
            axes=J[:, BASE:].T.copy()[None],
            posture=posture[None],
            rate=np.zeros((1, 12)),
            acceleration=(state.rate_after - rate_before)[None],
            base_acceleration=state.sole_twist[None],
            weights=adjoint[None, :NV],
        )
        foot = self._data.oMi[self._last] * self._to_last
        return WeightedImpact(dynamics, state, slope, foot, adjoint)


def _landing_slopes(axes: Array, velocity: Array, foot: pin.SE3) -> Array:
    """Derivative in q of the landing sole's velocity in its own frame, shape (12, 6).

    Args:
        axes: S_j, shape (12, 6).
        velocity: twist of the base, then joint rates, shape (18,).
        foot: placement of the landing sole.
    """
    before = velocity[:BASE] + np.cumsum(axes * velocity[BASE:, None], axis=0)
    return np.asarray(moved(before, axes) @ foot.toActionMatrixInverse().T)
