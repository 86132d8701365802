"""The knee of a leg: the joint that changes the distance between hip and ankle most."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import Array

_ONE_SIDED = 0.15  # of the range: how far its middle must be from straight


@dataclass(frozen=True)
class Knee:
    """The joint that bends a leg.

    Attributes:
        row: its place among the leg's joints.
        straight: angle at which the leg is longest [rad].
        reach: distance between hip and ankle there, the other joints as they are [m].
        side: direction in which a larger angle takes the ankle from the straight leg, shape (3,).
    """

    row: int
    straight: float
    reach: float
    side: Array

    def range_side(self, lower: float, upper: float) -> float:
        """Return +1 or -1 for the side to which the knee's range lies, 0 if it does not tell.

        Args:
            lower, upper: of its range [rad].
        """
        if not (np.isfinite(lower) and np.isfinite(upper)):
            return 0.0
        middle = (lower + upper) / 2.0 - self.straight
        return float(np.sign(middle)) if abs(middle) > _ONE_SIDED * (upper - lower) else 0.0


def find_knee(points: Array, axes: Array, hip: Array, ankle: Array, angles: Array) -> Knee:
    """Find the knee among the joint lines of a leg; all in one frame.

    About one revolute joint the squared distance is c0 + c1 cos q + c2 sin q, q from the posture
    of the lines.

    Args:
        points, axes: of the lines, shape (n, 3) each; a larger angle turns the ankle about +axis
            as seen from the hip.
        hip, ankle: centres of both [m], shape (3,).
        angles: of the joints in that posture [rad], shape (n,).
    """
    best, most = Knee(0, 0.0, 0.0, np.zeros(3)), -1.0
    for row, (point, axis) in enumerate(zip(points, axes, strict=True)):
        to_hip, to_ankle = hip - point, ankle - point
        along = (to_ankle @ axis) * axis
        level = to_ankle - along
        across = np.cross(axis, level)
        c0 = float(to_hip @ to_hip + to_ankle @ to_ankle - 2.0 * to_hip @ along)
        c1, c2 = -2.0 * float(to_hip @ level), -2.0 * float(to_hip @ across)
        swing, turn = float(np.hypot(c1, c2)), float(np.arctan2(c2, c1))
        if swing > most:
            side = np.cos(turn) * across - np.sin(turn) * level
            best = Knee(row, float(angles[row]) + turn, float(np.sqrt(c0 + swing)), side)
            most = swing
    return best
