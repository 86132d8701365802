"""Single support, Eqs. (1)-(13): torques, ground wrench, swing foot, and their derivatives.

One `pin.Data` per instant lives as long as the object, and its results are live views, so a sweep
costs the calls to Pinocchio and a few stacks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.mechanics.bodies import BodyInertias
from gaitopt.mechanics.curvature import TorqueCurvature, torque_curvature
from gaitopt.mechanics.feet import corner_positions, corner_slopes
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot


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
    """

    effort: Array
    corners: Array
    axes: Array
    motion: tuple[Array, Array, Array]
    bodies: BodyInertias
    gravity: Array

    def curvature(self, weights: Array) -> TorqueCurvature:
        """Return the second derivatives of sum(weights * effort), weights (N, 18)."""
        q, dq, ddq = self.motion
        return torque_curvature(
            self.axes,
            self.bodies.in_world(q),
            dq,
            ddq,
            -self.gravity,
            weights[:, 6:],
            weights[:, :6],
        )


class SingleSupport:
    """Evaluates Eq. (1) at a fixed number of instants."""

    def __init__(self, robot: Robot, count: int) -> None:
        self.robot = robot
        self.count = count
        model = robot.model
        self._data = [model.createData() for _ in range(count)]
        self._q = np.tile(pin.neutral(model), (count, 1))
        self._v = np.zeros((count, model.nv))
        self._a = np.zeros((count, model.nv))
        frame = model.frames[robot.swing_frame]
        self._last = frame.parentJoint
        points = robot.sole.corners @ frame.placement.rotation.T + frame.placement.translation
        self._corners_in_last = points
        self._bodies = BodyInertias(model)
        self._bind_views()

    def _bind_views(self) -> None:
        """Bind Pinocchio's results once: these arrays follow the Data they belong to."""
        self._effort = [d.tau for d in self._data]
        names = ("dtau_dq", "dtau_dv", "M")
        self._slopes = [[getattr(d, name)[:, 6:] for d in self._data] for name in names]
        self._axes = [d.J.T for d in self._data]
        self._rotation = [d.oMi[self._last].rotation for d in self._data]
        self._origin = [d.oMi[self._last].translation for d in self._data]

    def _load(self, q: Array, dq: Array, ddq: Array) -> None:
        self._q[:, 7:], self._v[:, 6:], self._a[:, 6:] = q, dq, ddq

    def _swing_corners(self) -> Array:
        rotation, origin = np.stack(self._rotation), np.stack(self._origin)
        return corner_positions(rotation, origin, self._corners_in_last)

    def state(self, q: Array, dq: Array, ddq: Array) -> SupportState:
        """Return wrench, torques and swing foot at the motion q, dq, ddq, shape (N, 12) each."""
        self._load(q, dq, ddq)
        model = self.robot.model
        for data, qk, vk, ak in zip(self._data, self._q, self._v, self._a, strict=True):
            pin.rnea(model, data, qk, vk, ak)
            pin.updateGlobalPlacements(model, data)
        return SupportState(np.stack(self._effort), self._swing_corners())

    def slope(self, q: Array, dq: Array, ddq: Array) -> tuple[SupportState, SupportSlope]:
        """Return the state and its exact derivatives at the motion q, dq, ddq, (N, 12) each."""
        self._load(q, dq, ddq)
        model = self.robot.model
        for data, qk, vk, ak in zip(self._data, self._q, self._v, self._a, strict=True):
            pin.computeRNEADerivatives(model, data, qk, vk, ak)
        axes = np.stack(self._axes)[:, 6:]
        corners = self._swing_corners()
        effort = np.empty((self.count, 18, 36))
        for column, views in zip((0, 12, 24), self._slopes, strict=True):
            np.stack(views, out=effort[:, :, column : column + 12])
        state = SupportState(np.stack(self._effort), corners)
        slope = SupportSlope(
            effort=effort,
            corners=corner_slopes(axes, corners),
            axes=axes,
            motion=(q, dq, ddq),
            bodies=self._bodies,
            gravity=model.gravity.vector,
        )
        return state, slope
