"""The double-support posture, Eq. (26) and Fig. 2: q_start from the geometric quantities.

The paper's form: inverse kinematics from p_G. A boundary answers three questions (posture, slope,
curvature) as a pure function of the geometric quantities, so another form can take its place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import EvaluationError, UnreachableError
from gaitopt.gait.parameters import FOOT_SPACING, PELVIS_FORWARD, PELVIS_HEIGHT, STEP_LENGTH
from gaitopt.gait.placement import PELVIS_CHAIN, SWING_SOLE_CHAIN, drive, place
from gaitopt.mechanics.legs import LegKinematics, chain_curvature, closure_forces, closure_slope
from gaitopt.mechanics.spatial import cross, skew
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

_PELVIS_DRIVE = drive(PELVIS_CHAIN)
_SOLE_DRIVE = drive(SWING_SOLE_CHAIN)


@dataclass(frozen=True)
class Posture:
    """Double support at the start of the step.

    Attributes:
        q_start: joint angles [rad], shape (12,).
        legs: from ankle centre to hip centre, in stance sole axes [m], shape (2, 3).
        pelvis, sole: placements of pelvis and swing sole in the stance sole frame.
        pelvis_axes, sole_axes: world axes of the displacement chains, shape (k, 6).
    """

    q_start: Array
    legs: Array
    pelvis: pin.SE3
    sole: pin.SE3
    pelvis_axes: Array
    sole_axes: Array


@dataclass(frozen=True)
class PostureSlope:
    """Derivatives of a Posture with respect to the geometric quantities.

    Attributes:
        q_start: shape (12, 10).
        legs: shape (2, 3, 10).
        joint_axes: joint motion axes at q_start, shape (12, 6).
    """

    q_start: Array
    legs: Array
    joint_axes: Array


class Boundary:
    """The paper's boundary: two feet and a pelvis placed by the geometric quantities."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._kinematics = LegKinematics(robot)

    def posture(self, geometry: Array) -> Posture:
        """Return the posture for geometric quantities, shape (10,).

        Raises:
            UnreachableError: a leg cannot reach, or the feet or pelvis are misplaced.
        """
        if not np.all(np.isfinite(geometry)):
            raise EvaluationError("a geometric quantity is not finite")
        pelvis, pelvis_axes = place(PELVIS_CHAIN, geometry)
        sole, sole_axes = place(SWING_SOLE_CHAIN, geometry)
        try:
            q_start = self._kinematics.solve(pelvis, sole)
        except UnreachableError as error:
            raise UnreachableError(
                f"{error} (pelvis height {geometry[PELVIS_HEIGHT]:.4f} m, "
                f"pelvis {geometry[PELVIS_FORWARD]:+.4f} m forward of the stance toes, "
                f"step length {geometry[STEP_LENGTH]:.4f} m, "
                f"foot spacing {geometry[FOOT_SPACING]:.4f} m)"
            ) from error
        hips = self.robot.legs.hips @ pelvis.rotation.T + pelvis.translation
        ankles = np.stack([self.robot.legs.ankles[0], sole.act(self.robot.legs.ankles[1])])
        return Posture(q_start, hips - ankles, pelvis, sole, pelvis_axes, sole_axes)

    def slope(self, posture: Posture) -> PostureSlope:
        """Return the derivatives of a posture."""
        axes = self._kinematics.axes(posture.q_start)
        pelvis_twists = posture.pelvis_axes.T @ _PELVIS_DRIVE
        sole_twists = posture.sole_axes.T @ _SOLE_DRIVE
        return PostureSlope(
            closure_slope(axes, pelvis_twists, sole_twists),
            self._leg_slopes(posture, pelvis_twists, sole_twists),
            axes,
        )

    def curvature(
        self, posture: Posture, slope: PostureSlope, q_weights: Array, leg_weights: Array
    ) -> Array:
        """Return the Hessian of q_weights . q_start + sum(leg_weights * legs), shape (10, 10).

        Along straight lines in the geometric quantities both sides of each closure accelerate:
        S q'' + (curvature of the leg) = (curvature of the displacement chain).
        """
        forces = closure_forces(slope.joint_axes, q_weights)
        on_pelvis = forces[0] + self._point_forces(posture, leg_weights)[0]
        targets = _PELVIS_DRIVE.T @ chain_curvature(posture.pelvis_axes, on_pelvis) @ _PELVIS_DRIVE
        on_sole = forces[1] - self._point_forces(posture, leg_weights)[1]
        targets += _SOLE_DRIVE.T @ chain_curvature(posture.sole_axes, on_sole) @ _SOLE_DRIVE
        own = chain_curvature(slope.joint_axes, forces[1])
        own[:6, :6] += chain_curvature(slope.joint_axes[:6], forces[0])
        H = targets - slope.q_start.T @ own @ slope.q_start
        return H + self._centripetal(posture, leg_weights)

    def _points(self, posture: Posture) -> Array:
        """Hips of both legs, then the swing ankle, in the world, shape (3, 3)."""
        hips = self.robot.legs.hips @ posture.pelvis.rotation.T + posture.pelvis.translation
        return np.vstack([hips, posture.sole.act(self.robot.legs.ankles[1])])

    def _leg_slopes(self, posture: Posture, pelvis_twists: Array, sole_twists: Array) -> Array:
        points = self._points(posture)
        hips = [_point_slope(p, pelvis_twists) for p in points[:2]]
        ankle = _point_slope(points[2], sole_twists)
        return np.stack([hips[0], hips[1] - ankle])

    def _point_forces(self, posture: Posture, weights: Array) -> tuple[Array, Array]:
        """Six-forces on pelvis and sole that the leg weights (2, 3) are worth."""
        points = self._points(posture)
        pelvis = np.concatenate([weights.sum(axis=0), cross(points[:2], weights).sum(axis=0)])
        return pelvis, np.concatenate([weights[1], cross(points[2], weights[1])])

    def _centripetal(self, posture: Posture, weights: Array) -> Array:
        """Second derivative of the leg vectors that a spatial acceleration does not carry.

        A body point accelerates by (spatial acceleration at p) + w x (l + w x p).
        """
        points = self._points(posture)
        pelvis_twists = posture.pelvis_axes.T @ _PELVIS_DRIVE
        sole_twists = posture.sole_axes.T @ _SOLE_DRIVE
        return (
            _centripetal(points[0], pelvis_twists, weights[0])
            + _centripetal(points[1], pelvis_twists, weights[1])
            - _centripetal(points[2], sole_twists, weights[1])
        )


def _point_slope(point: Array, twists: Array) -> Array:
    """Velocity of a body point per unit of each twist (6, p), shape (3, p)."""
    return np.asarray(twists[:3] - skew(point) @ twists[3:])


def _centripetal(point: Array, twists: Array, weight: Array) -> Array:
    moved = _point_slope(point, twists)
    turned = -skew(weight) @ moved  # weight . (w x m) = w . (m x weight)
    matrix = twists[3:].T @ turned
    return (matrix + matrix.T) / 2.0
