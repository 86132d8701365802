"""The impact that swaps the legs, Eqs. (14)-(20), and its exact derivatives, Eqs. (58)-(62).

The landing sole stops at once, flat on the ground; the old stance foot is free to leave:

    [ D  -J' ] [ V+ ]   [ D V- ]
    [ J   0  ] [ I  ] = [  0   ]

with V = (twist of the old stance sole, joint rates), J the Jacobian of the landing sole in its own
frame (D12' of Eq. 24 at the sole) and I the impulse of the ground on the landing foot, upward
positive (-I13 of the paper).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.bodies import BodyInertias
from gaitopt.mechanics.curvature import torque_curvature, velocity_curvature, velocity_rate_slope
from gaitopt.mechanics.spatial import motion_cross
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

_BASE = 6
_NV = 18


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
        return self.velocity[:_BASE]

    @property
    def rate_after(self) -> Array:
        """Joint rates after the impact [rad/s], shape (12,)."""
        return self.velocity[_BASE:]


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
        valid: whether the ground only pushes: both vertical impulses are upward.
    """

    velocity: Array
    impulse_landing: Array
    impulse_rear: Array

    @property
    def valid(self) -> bool:
        """Whether both vertical impulses are upward."""
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
        self._bodies = BodyInertias(robot.model)
        self._views = [self._bodies.placement_views(self._data)]
        self._q = pin.neutral(robot.model)
        self._forces = pin.StdVec_Force()
        self._forces.extend([pin.Force.Zero()] * robot.model.njoints)

    def _configuration(self, posture: Array) -> Array:
        self._q[_BASE + 1 :] = posture
        return self._q

    def _matrices(self, posture: Array) -> tuple[Array, Array]:
        """Inertia matrix D (18, 18) and landing Jacobian J (6, 18) at a posture."""
        q = self._configuration(posture)
        D = pin.crba(self._weightless, self._data, q).copy()
        J = pin.computeFrameJacobian(self._weightless, self._data, q, self._frame, pin.LOCAL)
        return D, J

    def _kkt(self, D: Array, J: Array) -> Array:
        K = np.zeros((_NV + _BASE, _NV + _BASE))
        K[:_NV, :_NV] = D
        K[:_NV, _NV:] = -J.T
        K[_NV:, :_NV] = J
        return K

    def state(self, posture: Array, rate_before: Array) -> ImpactState:
        """Return the state after the impact, Eqs. (19)-(20).

        Args:
            posture: joint angles at the impact [rad], shape (12,).
            rate_before: joint rates before it [rad/s], shape (12,); the stance foot is at rest.
        """
        D, J = self._matrices(posture)
        rhs = np.concatenate([D[:, _BASE:] @ rate_before, np.zeros(_BASE)])
        y = np.linalg.solve(self._kkt(D, J), rhs)
        return ImpactState(y[:_NV], y[_NV:])

    def slope(self, posture: Array, rate_before: Array) -> tuple[ImpactState, ImpactSlope]:
        """Return the state and its exact derivatives, Eqs. (58)-(62)."""
        D, J = self._matrices(posture)
        K = self._kkt(D, J)
        rhs = np.concatenate([D[:, _BASE:] @ rate_before, np.zeros(_BASE)])
        y = np.linalg.solve(K, rhs)
        state = ImpactState(y[:_NV], y[_NV:])
        sides = np.zeros((_NV + _BASE, 24))
        sides[:_NV, :12], sides[_NV:, :12] = self._residual_slopes(posture, rate_before, state)
        sides[:, :12] *= -1.0
        sides[:_NV, 12:] = D[:, _BASE:]
        slopes = np.linalg.solve(K, sides)
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
        jump[_BASE:] -= rate_before
        self._forces[self._last] = self._to_last.act(pin.Force(state.impulse))
        pin.computeRNEADerivatives(
            self._weightless, self._data, q, np.zeros(_NV), jump, self._forces
        )
        momentum = self._data.dtau_dq[:, _BASE:].copy()
        pin.computeForwardKinematicsDerivatives(
            self._weightless, self._data, q, state.velocity, np.zeros(_NV)
        )
        landing, _ = pin.getFrameVelocityDerivatives(
            self._weightless, self._data, self._frame, pin.LOCAL
        )
        return momentum, landing[:, _BASE:]

    def curvature(
        self,
        posture: Array,
        rate_before: Array,
        state: ImpactState,
        slope: ImpactSlope,
        weights: Array,
    ) -> Array:
        """Return the Hessian of weights . (V+, I) in (posture, rate_before), shape (24, 24).

        With F(y, z) = 0 the equations of the impact and K' l = -weights, the Hessian is that of
        l . F along (dz, dy/dz dz).

        Args:
            posture, rate_before, state, slope: the impact and its derivatives.
            weights: shape (24,).
        """
        adjoint = -np.linalg.solve(slope.kkt.T, weights)
        qq, qy = self._residual_curvature(posture, rate_before, state, adjoint)
        # z = (posture, rate before); the jump V+ - V- sees minus the rate before.
        mixed = np.zeros((12, 24))
        mixed[:, 12:] = -qy[:, _NV + _BASE :]
        mixed += qy[:, : _NV + _BASE] @ np.hstack([slope.posture, slope.rate])
        H = np.zeros((24, 24))
        H[:12, :12] = qq
        H[:12] += mixed
        H[:, :12] += mixed.T
        return H

    def _residual_curvature(
        self, posture: Array, rate_before: Array, state: ImpactState, adjoint: Array
    ) -> tuple[Array, Array]:
        """Second derivatives of l . F: in the posture (12, 12), and in the posture and (V+, I).

        The last twelve of the second's 36 columns repeat those of the inertial term alone, which
        the rates before the impact enter with a minus sign.
        """
        q = self._configuration(posture)
        J = pin.computeJointJacobians(self._weightless, self._data, q)
        axes = np.asarray(J[:, _BASE:].T).copy()
        inertias = self._bodies.in_world(self._views)
        momentum, landing = adjoint[:_NV], adjoint[_NV:]
        jump = state.velocity[_BASE:] - rate_before
        inertial = torque_curvature(
            axes[None], inertias, np.zeros((1, 12)), jump[None],
            state.sole_twist, momentum[None, _BASE:], momentum[None, :_BASE],
        )  # fmt: skip
        foot = self._data.oMi[self._last] * self._to_last
        impulse = foot.act(pin.Force(state.impulse)).vector
        push = foot.act(pin.Force(landing)).vector
        qq = inertial.qq[0] + velocity_curvature(axes, state.rate_after, state.sole_twist, push)
        qq -= velocity_curvature(axes, momentum[_BASE:], momentum[:_BASE], impulse)
        joint_rates, base_rates = velocity_rate_slope(axes, push)
        qy = np.zeros((12, _NV + _BASE + 12))
        qy[:, :_BASE] = inertial.base[0] + base_rates
        qy[:, _BASE:_NV] = inertial.qa[0] + joint_rates
        qy[:, _NV : _NV + _BASE] = -self._frame_velocity_slopes(axes, momentum, foot)
        qy[:, _NV + _BASE :] = inertial.qa[0]
        return qq, qy

    def _frame_velocity_slopes(self, axes: Array, velocity: Array, foot: pin.SE3) -> Array:
        """Derivative in q of the landing sole's own-frame velocity, shape (12, 6)."""
        before = velocity[:_BASE] + np.cumsum(axes * velocity[_BASE:, None], axis=0)
        swept = (motion_cross(before) @ axes[:, :, None])[..., 0]
        return swept @ foot.toActionMatrixInverse().T

    def locked(self, posture: Array, rate_before: Array) -> LockedImpact:
        """Return the outcome in which both feet stay on the ground (section 2.4.1, case two)."""
        D, J = self._matrices(posture)
        both = np.vstack([np.eye(_BASE, _NV), J])
        K = np.block([[D, -both.T], [both, np.zeros((12, 12))]])
        rhs = np.concatenate([D[:, _BASE:] @ rate_before, np.zeros(12)])
        y = np.linalg.solve(K, rhs)
        velocity = y[:_NV].copy()
        velocity[:_BASE] = 0.0
        return LockedImpact(velocity, y[_NV + _BASE :], y[_NV : _NV + _BASE])
