"""Single support, Eqs. (1)-(13): torques, ground wrench, swing foot, and their derivatives.

The torques are those of the motors: of the rigid bodies, and what damping, friction and springs of
the joints take; weight that is carried from outside is needed of neither motors nor ground.

One `pin.Data` serves all instants, and its results are live views that are copied out after each:
faster than a Data per instant, whose 0.4 MB each leave the processor's caches (measured: a third at
31 instants, two fifths at 301).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.bodies import BodyInertias, body_inertias
from gaitopt.mechanics.carried import Carried
from gaitopt.mechanics.curvature import TorqueCurvature, WeightedDynamics, torque_curvature
from gaitopt.mechanics.feet import corner_positions, corner_slopes
from gaitopt.mechanics.kept import kept
from gaitopt.mechanics.passive import PassiveTorque, passive_torque
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

_EACH = np.arange(12)


@dataclass(frozen=True)
class SupportState:
    """Single support at N instants, world frame = stance sole frame.

    Attributes:
        effort: ground wrench on the stance foot (force, moment about the sole origin; 6) then
            torques (12) [N, N.m], shape (N, 18): [R0; Gamma] of Eq. (1).
        corners: corners of the swing sole [m], shape (N, 4, 3).
    """

    effort: Array
    corners: Array


@dataclass(frozen=True)
class SupportSlope:
    """Derivatives of a SupportState, and the kinematics they came with.

    Attributes:
        effort: with respect to (q, dq, ddq) side by side, shape (N, 18, 36).
        corners: with respect to q, shape (N, 4, 3, 12).
        axes: joint motion axes in the world, shape (N, 12, 6).
        motion: q, dq, ddq it was taken at, shape (N, 12) each.
        bodies: of the robot, for the curvature.
        gravity: spatial acceleration of gravity, shape (6,).
        passive: what the joints do by themselves; None if they do nothing.
        carried: weight that is carried from outside; None if there is none.
    """

    effort: Array
    corners: Array
    axes: Array
    motion: tuple[Array, Array, Array]
    bodies: BodyInertias
    gravity: Array
    passive: PassiveTorque | None = None
    carried: Carried | None = None

    def curvature(self, weights: Array, then: WeightedDynamics | None = None) -> TorqueCurvature:
        """Return the second derivatives of sum(weights * effort), weights (N, 18).

        Args:
            weights: of the effort.
            then: further instants to follow the N; cheaper than on their own.
        """
        base = np.broadcast_to(-self.gravity, (len(weights), 6))
        at = WeightedDynamics(self.axes, *self.motion, base, weights)
        if then is not None:
            at = at.followed_by(then)
        found = torque_curvature(self.bodies.in_world(at.posture), at)
        own = slice(len(weights))
        if self.carried is not None:
            found.qq[own] -= self.carried.curvature(self.motion[0], weights)
        if self.passive is not None:
            found.qq[own, _EACH, _EACH] += weights[:, 6:] * self.passive.by_angle_twice
            found.vv[own, _EACH, _EACH] += weights[:, 6:] * self.passive.by_rate_twice
        return found


class SingleSupport:
    """Evaluates Eq. (1) at a fixed number of instants."""

    def __init__(self, robot: Robot, count: int) -> None:
        self.robot = robot
        self.count = count
        model = robot.model
        self._data = model.createData()
        self._q = np.tile(pin.neutral(model), (count, 1))
        self._v = np.zeros((count, model.nv))
        self._a = np.zeros((count, model.nv))
        frame = model.frames[robot.swing_frame]
        points = robot.sole.corners @ frame.placement.rotation.T + frame.placement.translation
        self._corners_in_last = points
        self._bodies = kept(robot, body_inertias)
        self._joints = robot.physics.passive
        self._bind_views(frame.parentJoint)

    def _bind_views(self, last: int) -> None:
        """Bind Pinocchio's results once: these arrays follow the Data they belong to."""
        data = self._data
        self._effort = data.tau
        self._slopes = [getattr(data, name)[:, 6:] for name in ("dtau_dq", "dtau_dv", "M")]
        self._axes = data.J[:, 6:].T
        self._rotation = data.oMi[last].rotation
        self._origin = data.oMi[last].translation

    @property
    def _carried(self) -> Carried | None:
        """Weight that is carried from outside."""
        return None if self.robot.physics.carried is None else kept(self.robot, Carried)

    def _load(self, q: Array, dq: Array, ddq: Array) -> None:
        self._q[:, 7:], self._v[:, 6:], self._a[:, 6:] = q, dq, ddq

    def state(self, q: Array, dq: Array, ddq: Array) -> SupportState:
        """Return wrench, torques and swing foot at the motion q, dq, ddq, shape (N, 12) each."""
        self._load(q, dq, ddq)
        model, data = self.robot.model, self._data
        effort = np.empty((self.count, 18))
        rotation, origin = np.empty((self.count, 3, 3)), np.empty((self.count, 3))
        for k, motion in enumerate(zip(self._q, self._v, self._a, strict=True)):
            pin.rnea(model, data, *motion)
            pin.updateGlobalPlacements(model, data)
            effort[k], rotation[k], origin[k] = self._effort, self._rotation, self._origin
        if (carried := self._carried) is not None:
            effort -= carried.effort(q)
        if self._joints is not None:
            effort[:, 6:] += passive_torque(self._joints, q, dq).value
        return SupportState(effort, corner_positions(rotation, origin, self._corners_in_last))

    def slope(self, q: Array, dq: Array, ddq: Array) -> tuple[SupportState, SupportSlope]:
        """Return the state and its exact derivatives at the motion q, dq, ddq, (N, 12) each."""
        self._load(q, dq, ddq)
        model, data = self.robot.model, self._data
        by_position, by_rate, by_acceleration = self._slopes
        effort, slopes = np.empty((self.count, 18)), np.empty((self.count, 18, 36))
        rotation, origin = np.empty((self.count, 3, 3)), np.empty((self.count, 3))
        axes = np.empty((self.count, 12, 6))
        of_q, of_dq, of_ddq = np.split(slopes, 3, axis=2)
        for k, motion in enumerate(zip(self._q, self._v, self._a, strict=True)):
            pin.computeRNEADerivatives(model, data, *motion)
            effort[k], rotation[k], origin[k] = self._effort, self._rotation, self._origin
            of_q[k], of_dq[k], of_ddq[k] = by_position, by_rate, by_acceleration
            axes[k] = self._axes
        if (carried := self._carried) is not None:
            unneeded, unneeded_slope = carried.slope(q)
            effort -= unneeded
            of_q -= unneeded_slope
        passive = None if self._joints is None else passive_torque(self._joints, q, dq)
        if passive is not None:
            effort[:, 6:] += passive.value
            of_q[:, 6 + _EACH, _EACH] += passive.by_angle
            of_dq[:, 6 + _EACH, _EACH] += passive.by_rate
        corners = corner_positions(rotation, origin, self._corners_in_last)
        slope = SupportSlope(
            effort=slopes,
            corners=corner_slopes(axes, corners),
            axes=axes,
            motion=(q, dq, ddq),
            bodies=self._bodies,
            gravity=model.gravity.vector,
            passive=passive,
            carried=carried,
        )
        return SupportState(effort, corners), slope
