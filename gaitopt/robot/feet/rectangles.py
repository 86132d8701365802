"""The part of both soles that is a rectangle and its own mirror image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.feet.found import FoundSole
from gaitopt.robot.feet.sole import Sole, tidy

_DIFFERENT = 2e-3  # m: soles that differ by more from side to side deserve a word


@dataclass(frozen=True)
class Rectangle:
    """The right sole at the reference posture in the pelvis frame [m].

    Attributes:
        toe, heel, left, right: edges along x and y.
        height: of its plane.
        how: where it came from, in words.
        doubts: what deserves a look, in words.
        share: of the flat part under the foot that it holds.
        others: other rectangles, by name.
    """

    toe: float
    heel: float
    left: float
    right: float
    height: float
    how: str
    doubts: tuple[str, ...] = ()
    share: float = 1.0
    others: tuple[tuple[str, Rectangle], ...] = ()

    def seen_from(self, origin: Array) -> tuple[Sole, tuple[str, ...]]:
        """Return the sole in a frame with its origin there, as wide to the left as to the right.

        Args:
            origin: of the right sole frame in the pelvis frame [m], shape (3,).

        Returns:
            The sole, and a warning if that took something away.
        """
        x, y = float(origin[0]), float(origin[1])
        half = min(self.left - y, y - self.right)
        lost = (self.left - self.right) - 2.0 * half
        words = (
            f"{lost * 1e3:.1f} mm of the soles' width are not used: the sole frames are not in "
            "the middle of the soles",
        )
        if half <= 0.0:
            raise RobotError(
                "the sole frames lie beside the soles; leave them out, or correct them"
            )
        sole = Sole(*(tidy(v) for v in (self.toe - x, self.heel - x, half, -half)))
        return sole, words if lost > _DIFFERENT else ()


def common_rectangle(
    found: tuple[FoundSole | None, FoundSole | None], places: tuple[pin.SE3, pin.SE3]
) -> Rectangle | None:
    """Return the part of the right sole whose mirror image is part of the left one.

    Args:
        found: the soles in the frames of the last joints of the right and of the left leg.
        places: of those joints in the pelvis frame.

    Raises:
        RobotError: the soles have nothing in common.
    """
    seen = [
        (sole, place, side)
        for side, (sole, place) in enumerate(zip(found, places, strict=True))
        if sole is not None
    ]
    if not seen:
        return None
    boxes = [_box(sole.sole, sole, place, side) for sole, place, side in seen]
    gap = max(abs(a - b) for a, b in zip(boxes[0], boxes[-1], strict=True))
    doubts = []
    if gap > _DIFFERENT:
        doubts.append(
            f"the soles of the two feet differ by {gap * 1e3:.1f} mm; the common part counts"
        )
    if max(box[0] - box[1] for box in boxes) < max(box[2] - box[3] for box in boxes):
        doubts.append(
            "the feet are wider than they are long: their shapes may be turned, or the heading "
            "wrong; give the sole rectangle (--sole), or --forward"
        )
    toe, heel, left, right, height = _common(boxes)
    if toe <= heel or left <= right:
        raise RobotError(
            "the soles of the two feet, mirrored onto each other, have nothing in common; "
            "give the sole rectangle (--sole) and sole_drop in the file for --choices"
        )
    how, share = seen[0][0].how, min(sole.share for sole, _, _ in seen)
    others = []
    for name in dict.fromkeys(name for sole, _, _ in seen for name, _ in sole.others):
        edges = _common(
            [
                _box(dict(sole.others).get(name, sole.sole), sole, place, side)
                for sole, place, side in seen
            ]
        )
        if edges[0] > edges[1] and edges[2] > edges[3]:
            others.append((name, Rectangle(*edges, how)))
    return Rectangle(toe, heel, left, right, height, how, tuple(doubts), share, tuple(others))


_Box = tuple[float, float, float, float, float]


def _common(boxes: list[_Box]) -> _Box:
    """Edges of the part that two boxes have in common, and their mean height."""
    (toe, heel, left, right, height), other = boxes[0], boxes[-1]
    return (
        min(toe, other[0]),
        max(heel, other[1]),
        min(left, other[2]),
        max(right, other[3]),
        (height + other[4]) / 2.0,
    )


def _box(sole: Sole, found: FoundSole, place: pin.SE3, side: int) -> _Box:
    """Edges toe, heel, left, right and the height, of the left foot mirrored to the right."""
    frame = place * found.placement
    corners = np.array([frame.act(corner) for corner in sole.corners])
    if side == 1:
        corners[:, 1] *= -1.0
    (x, y, z), (low_x, low_y, _) = corners.max(axis=0), corners.min(axis=0)
    return float(x), float(low_x), float(y), float(low_y), float((z + corners[:, 2].min()) / 2.0)
