"""The knee of a leg: the joint that changes the distance between hip and ankle most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitopt.nlp import Array

_BENDS = 0.1  # of what any joint of the leg changes: what a knee changes at least
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


def find_knee(
    points: Array,
    axes: Array,
    hip: Array,
    ankle: Array,
    angles: Array,
    beyond: Sequence[int] | None = None,
) -> Knee:
    """Find the knee among the joint lines of a leg; all in one frame.

    About one revolute joint the squared distance is c0 + c1 cos q + c2 sin q, q from the posture
    of the lines.

    Args:
        points, axes: of the lines, shape (n, 3) each; a larger angle turns the ankle about +axis
            as seen from the hip.
        hip, ankle: centres of both [m], shape (3,).
        angles: of the joints in that posture [rad], shape (n,).
        beyond: rows of the joints beyond the hip, of which the knee is one unless they hardly
            change the distance; None for all. Where the axes of a hip do not meet, one of its
            joints may well change the distance more than the knee does.
    """
    swings = [_swing(p, a, hip, ankle) for p, a in zip(points, axes, strict=True)]
    sizes = np.array([abs(c) for _, c in swings])
    row = int(sizes.argmax())
    if beyond is not None:
        nearer = max(beyond, key=lambda k: float(sizes[k]))
        row = nearer if sizes[nearer] > _BENDS * sizes[row] else row
    c0, c = swings[row]
    turn = float(np.angle(c))
    level = ankle - points[row]
    level = level - (level @ axes[row]) * axes[row]
    side = np.cos(turn) * np.cross(axes[row], level) - np.sin(turn) * level
    return Knee(row, float(angles[row]) + turn, float(np.sqrt(c0 + abs(c))), side)


def _swing(point: Array, axis: Array, hip: Array, ankle: Array) -> tuple[float, complex]:
    """Return c0 and c1 + i c2 of the squared distance between hip and ankle about a line [m²]."""
    to_hip, to_ankle = hip - point, ankle - point
    along = (to_ankle @ axis) * axis
    level = to_ankle - along
    c0 = float(to_hip @ to_hip + to_ankle @ to_ankle - 2.0 * to_hip @ along)
    return c0, complex(-2.0 * to_hip @ level, -2.0 * to_hip @ np.cross(axis, level))
