"""The double-support posture, Eq. (26) and Fig. 2: q_start from the geometric quantities.

Two forms, with the same geometric quantities. The paper's solves the inverse kinematics; the
lifted one takes the joint angles as parameters too and reports how far pelvis and swing foot are
from where the quantities put them, which no trial point can fail to do. A boundary answers three
questions (posture, slope, curvature) as a pure function of its coordinates.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.errors import EvaluationError
from gaitopt.gait.placement import PELVIS_CHAIN, SWING_SOLE_CHAIN, drive, place
from gaitopt.mechanics.closure import loop_gap
from gaitopt.mechanics.legs import LegKinematics, chain_curvature
from gaitopt.mechanics.spatial import cross, skew
from gaitopt.nlp import Array
from gaitopt.robot.model import Robot

PELVIS_DRIVE = drive(PELVIS_CHAIN)
SOLE_DRIVE = drive(SWING_SOLE_CHAIN)


@dataclass(frozen=True)
class Posture:
    """Double support at the start of the step.

    Attributes:
        q_start: joint angles [rad], shape (12,).
        legs: from ankle centre to hip centre, in stance sole axes [m], shape (2, 3).
        pelvis, sole: placements of pelvis and swing sole that the quantities ask for, in the
            stance sole frame.
        pelvis_axes, sole_axes: world axes of the displacement chains, shape (k, 6).
        loops: lifted form only: where pelvis and swing sole ought to be, seen from where they are.
    """

    q_start: Array
    legs: Array
    pelvis: pin.SE3
    sole: pin.SE3
    pelvis_axes: Array
    sole_axes: Array
    loops: tuple[pin.SE3, ...] = ()

    @cached_property
    def twists(self) -> tuple[Array, Array]:
        """Twists of pelvis and swing sole per unit of each quantity, shape (6, 10) each."""
        return self.pelvis_axes.T @ PELVIS_DRIVE, self.sole_axes.T @ SOLE_DRIVE

    @cached_property
    def gaps(self) -> Array:
        """How far pelvis and swing sole are from where they ought to be, shape (0 or 2, 6)."""
        return np.array([loop_gap(loop) for loop in self.loops]).reshape(-1, 6)


@dataclass(frozen=True)
class PostureSlope:
    """Derivatives of a Posture with respect to the boundary's coordinates, B of them.

    The coordinates are the ten geometric quantities; in the lifted form the twelve joint angles
    come before them.

    Attributes:
        q_start: shape (12, B).
        legs: shape (2, 3, B).
        joint_axes: joint motion axes at q_start, shape (12, 6).
        gaps: shape (0 or 2, 6, B).
        loop_axes: lifted form only: axes of each loop's chain in its base.
    """

    q_start: Array
    legs: Array
    joint_axes: Array
    gaps: Array
    loop_axes: tuple[Array, ...] = ()


class Boundary(ABC):
    """Two feet on the ground and a pelvis, placed by the geometric quantities."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.kinematics = LegKinematics(robot)

    @abstractmethod
    def posture(self, geometry: Array, q_start: Array) -> Posture:
        """Return the posture for geometric quantities, shape (10,).

        Args:
            geometry: the quantities.
            q_start: joint angles (12,); empty unless they are parameters.

        Raises:
            EvaluationError: a quantity is not finite.
            UnreachableError: a leg cannot reach, or the feet or pelvis are misplaced.
        """

    @abstractmethod
    def slope(self, posture: Posture) -> PostureSlope:
        """Return the derivatives of a posture."""

    @abstractmethod
    def curvature(
        self,
        posture: Posture,
        slope: PostureSlope,
        q_weights: Array,
        leg_weights: Array,
        gap_weights: Array,
    ) -> Array:
        """Return the Hessian of weights . (q_start, legs, gaps), shape (B, B)."""

    def place(self, geometry: Array) -> tuple[tuple[pin.SE3, Array], tuple[pin.SE3, Array]]:
        """Return placement and displacement axes of pelvis and of swing sole."""
        if not np.all(np.isfinite(geometry)):
            raise EvaluationError("a geometric quantity is not finite")
        return place(PELVIS_CHAIN, geometry), place(SWING_SOLE_CHAIN, geometry)

    def leg_vectors(self, pelvis: pin.SE3, sole: pin.SE3) -> Array:
        """Return the vectors from ankle to hip centres, shape (2, 3)."""
        points = self._points(pelvis, sole)
        return np.asarray(points[:2] - [self.robot.legs.ankles[0], points[2]])

    def _points(self, pelvis: pin.SE3, sole: pin.SE3) -> Array:
        """Hips of both legs, then the swing ankle, in the world, shape (3, 3)."""
        hips = self.robot.legs.hips @ pelvis.rotation.T + pelvis.translation
        return np.vstack([hips, sole.act(self.robot.legs.ankles[1])])

    def leg_slopes(self, posture: Posture) -> Array:
        """Return the slopes of the legs in the geometric quantities, shape (2, 3, 10)."""
        pelvis_twists, sole_twists = posture.twists
        points = self._points(posture.pelvis, posture.sole)
        hips = [_point_slope(p, pelvis_twists) for p in points[:2]]
        ankle = _point_slope(points[2], sole_twists)
        return np.stack([hips[0], hips[1] - ankle])

    def _point_forces(self, posture: Posture, weights: Array) -> tuple[Array, Array]:
        """Six-forces on pelvis and sole that the leg weights (2, 3) are worth."""
        points = self._points(posture.pelvis, posture.sole)
        pelvis = np.concatenate([weights.sum(axis=0), cross(points[:2], weights).sum(axis=0)])
        return pelvis, np.concatenate([weights[1], cross(points[2], weights[1])])

    def target_curvature(
        self, posture: Posture, forces: tuple[Array, Array], leg_weights: Array
    ) -> Array:
        """Return the curvature in the geometric quantities of legs and of what forces pair with.

        Args:
            posture: the double support.
            forces: six-forces on pelvis and on swing sole.
            leg_weights: shape (2, 3).
        """
        on_pelvis, on_sole = self._point_forces(posture, leg_weights)
        H = PELVIS_DRIVE.T @ chain_curvature(posture.pelvis_axes, forces[0] + on_pelvis)
        H = H @ PELVIS_DRIVE
        sole = chain_curvature(posture.sole_axes, forces[1] - on_sole)
        H += SOLE_DRIVE.T @ sole @ SOLE_DRIVE
        return np.asarray(H + self._centripetal(posture, leg_weights))

    def _centripetal(self, posture: Posture, weights: Array) -> Array:
        """Second derivative of the leg vectors that a spatial acceleration does not carry.

        A body point accelerates by (spatial acceleration at p) + w x (l + w x p).
        """
        points = self._points(posture.pelvis, posture.sole)
        pelvis_twists, sole_twists = posture.twists
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
