"""Attitude of the trunk: roll, pitch and yaw of the pelvis frame against the vertical.

On level ground that is in the stance sole frame; on a slope the vertical is not its z axis.

It is one of the quantities of the posture that are computed only if a constraint reads them.

Tait-Bryan angles in the order of the double support's geometric quantities: yaw about the vertical,
then pitch about the turned y axis, then roll about the trunk's own x axis. With the world angular
velocity w of the pelvis

    roll'  = (cos yaw w_x + sin yaw w_y) / cos pitch
    pitch' = -sin yaw w_x + cos yaw w_y
    yaw'   = w_z + tan pitch (cos yaw w_x + sin yaw w_y)

(Siciliano et al., Robotics, 2009, section 3.6, solved for the rates).
"""

from __future__ import annotations

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.mechanics.forward_kinematics import (
    Placements,
    PostureQuantity,
    PostureQuantityDerivatives,
)
from gaitopt.mechanics.spatial import symmetric, upright
from gaitopt.model.robot import Robot
from gaitopt.model.sole import LEVEL
from gaitopt.nlp import Array

ROLL, PITCH, YAW = range(3)
_LEAST_COSINE = 1e-9  # of the pitch: roll and yaw are one and the same where it is 90 degrees


@dataclass(frozen=True)
class TrunkDerivatives(PostureQuantityDerivatives):
    """Derivatives of roll, pitch and yaw.

    Attributes:
        value: the angles [rad], shape (N, 3).
        jacobian: with respect to q, shape (N, 3, n).
        rate_jacobian: how the rates (roll', pitch', yaw') change with pitch and with yaw at a given
            velocity of each joint, shape (N, 2, 3, n).
    """

    value: Array
    jacobian: Array
    rate_jacobian: Array

    def hessian(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * angles), weights (N, 3), shape (N, n, n).

        Between the stance foot and the pelvis, turning joint k leaves the axes of the joints
        j <= k where they are, so there only pitch and yaw change the rates.
        """
        weighted = (weights[:, None, None, :] @ self.rate_jacobian)[:, :, 0]
        return symmetric(weighted.swapaxes(1, 2) @ self.jacobian[:, PITCH:])


class Trunk(PostureQuantity):
    """Roll, pitch and yaw of a robot's pelvis frame [rad]."""

    def __init__(self, robot: Robot) -> None:
        frame = robot.model.frames[robot.pelvis_frame]
        self._body = robot.tree.pelvis
        self._below = robot.tree.path(self._body)
        self._turn = np.array(frame.placement.rotation)
        self._upright = None if robot.down == LEVEL else upright(np.array(robot.down))

    def value(self, placed: Placements) -> Array:
        """Return roll, pitch, yaw [rad], shape (N, 3)."""
        R = placed.rotation[:, self._body] @ self._turn
        if self._upright is not None:
            R = self._upright @ R
        roll = np.arctan2(R[:, 2, 1], R[:, 2, 2])
        pitch = np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0))
        yaw = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        return np.stack([roll, pitch, yaw], axis=1)

    def derivatives(self, placed: Placements, axes: Array) -> TrunkDerivatives:
        """Return the derivatives of the angles."""
        value = self.value(placed)
        _, pitch, yaw = value.T
        w = np.where(self._below, axes[:, :, 3:].swapaxes(1, 2), 0.0)
        if self._upright is not None:
            w = self._upright @ w
        c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
        ahead, aside = c * w[:, 0] + s * w[:, 1], c * w[:, 1] - s * w[:, 0]  # turned with the yaw
        cosine = np.maximum(np.cos(pitch), _LEAST_COSINE)[:, None]
        sine, zero = np.sin(pitch)[:, None], np.zeros_like(aside)
        rates = np.stack([ahead / cosine, aside, w[:, 2] + sine / cosine * ahead], axis=1)
        by_pitch = np.stack([sine / cosine**2 * ahead, zero, ahead / cosine**2], axis=1)
        by_yaw = np.stack([aside / cosine, -ahead, sine / cosine * aside], axis=1)
        return TrunkDerivatives(value, rates, np.stack([by_pitch, by_yaw], axis=1))


def slope_rates(angles: Array) -> Array:
    """Return how roll, pitch and yaw change per radian of slope of the ground, shape (N, 3).

    On ground that rises ahead the trunk, fixed to it, leans back: it turns about -y.

    Args:
        angles: roll, pitch and yaw [rad], shape (N, 3).
    """
    _, pitch, yaw = angles.T
    ahead = -np.sin(yaw)
    return np.stack([ahead / np.cos(pitch), -np.cos(yaw), np.tan(pitch) * ahead], axis=1)
