"""Exact second derivatives of the impact, from the closed forms of a serial chain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.curvature import (
    TorqueCurvature,
    WeightedDynamics,
    velocity_curvature,
    velocity_rate_slope,
)
from gaitopt.mechanics.impact import BASE, NV, ImpactSlope, ImpactState
from gaitopt.mechanics.linear import solve
from gaitopt.mechanics.spatial import moved
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot


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
