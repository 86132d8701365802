"""Exact second derivatives of the impact, from the closed forms of a serial chain."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.bodies import body_inertias
from gaitopt.mechanics.curvature import torque_curvature, velocity_curvature, velocity_rate_slope
from gaitopt.mechanics.impact import BASE, NV, ImpactSlope, ImpactState
from gaitopt.mechanics.kept import kept
from gaitopt.mechanics.spatial import moved
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot


class ImpactCurvature:
    """Second derivatives of any weighted sum of the robot's state after the impact.

    With F(y, z) = 0 the equations of the impact, y = (V+, I), z = (posture, rate before), and
    K' l = -weights, the Hessian is that of l . F along (dz, dy/dz dz).
    """

    def __init__(self, robot: Robot) -> None:
        self._model = robot.model
        self._data = robot.model.createData()
        self._bodies = kept(robot, body_inertias)
        foot = robot.model.frames[robot.swing_frame]
        self._last, self._to_last = foot.parentJoint, foot.placement
        self._q = pin.neutral(robot.model)

    def hessian(
        self,
        posture: Array,
        rate_before: Array,
        state: ImpactState,
        slope: ImpactSlope,
        weights: Array,
    ) -> Array:
        """Return the Hessian of weights . (V+, I) in (posture, rate before), shape (24, 24).

        Args:
            posture, rate_before, state, slope: the impact and its derivatives.
            weights: shape (24,).
        """
        adjoint = np.asarray(-np.linalg.solve(slope.kkt.T, weights), dtype=np.float64)
        qq, by_result, by_jump = self._residual(posture, rate_before, state, adjoint)
        mixed = by_result @ np.hstack([slope.posture, slope.rate])
        mixed[:, 12:] -= by_jump  # the jump V+ - V- sees minus the rate before
        H = np.zeros((24, 24))
        H[:12, :12] = qq
        H[:12] += mixed
        H[:, :12] += mixed.T
        return H

    def _residual(
        self, posture: Array, rate_before: Array, state: ImpactState, adjoint: Array
    ) -> tuple[Array, Array, Array]:
        """Second derivatives of l . F with F = (D (V+ - V-) - J' I, J V+).

        Returns:
            In the posture twice (12, 12); in the posture and (V+, I) (12, 24); in the posture and
            the jump of the joint rates (12, 12).
        """
        self._q[BASE + 1 :] = posture
        J = pin.computeJointJacobians(self._model, self._data, self._q)
        axes = np.asarray(J[:, BASE:].T).copy()
        foot = self._data.oMi[self._last] * self._to_last
        momentum, landing = adjoint[:NV], adjoint[NV:]
        impulse = foot.act(pin.Force(state.impulse)).vector
        push = foot.act(pin.Force(landing)).vector

        inertial = torque_curvature(
            axes=axes[None],
            inertias=self._bodies.in_world(posture[None]),
            rate=np.zeros((1, 12)),
            acceleration=(state.rate_after - rate_before)[None],
            base_acceleration=state.sole_twist,
            weights=momentum[None, BASE:],
            base_weights=momentum[None, :BASE],
        )
        qq = inertial.qq[0] + velocity_curvature(axes, state.rate_after, state.sole_twist, push)
        qq -= velocity_curvature(axes, momentum[BASE:], momentum[:BASE], impulse)
        joint_rates, base_rates = velocity_rate_slope(axes, push)
        by_result = np.zeros((12, NV + BASE))
        by_result[:, :BASE] = inertial.base[0] + base_rates
        by_result[:, BASE:NV] = inertial.qa[0] + joint_rates
        by_result[:, NV:] = -_landing_slopes(axes, momentum, foot)
        return qq, by_result, inertial.qa[0]


def _landing_slopes(axes: Array, velocity: Array, foot: pin.SE3) -> Array:
    """Derivative in q of the landing sole's velocity in its own frame, shape (12, 6).

    Args:
        axes: S_j, shape (12, 6).
        velocity: twist of the base, then joint rates, shape (18,).
        foot: placement of the landing sole.
    """
    before = velocity[:BASE] + np.cumsum(axes * velocity[BASE:, None], axis=0)
    return np.asarray(moved(before, axes) @ foot.toActionMatrixInverse().T)
