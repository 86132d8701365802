"""The rectangle of the sole that may touch the ground, found from the foot's shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.feet.level import lowest_face, tilt
from gaitopt.robot.feet.shape import FootShape
from gaitopt.robot.feet.sole import Sole, tidy

_FLATNESS = 2e-3  # m: what lies less than this above the lowest point belongs to the sole
_SMALLEST = 5e-4  # m²: less is an edge or a stud, not a sole
_MOST = 0.8  # of the foot's length: a sole shorter than that is told
_LEAVES_OUT = 0.9  # of the flat part: what the rectangle must hold to be the only one shown
_NEARLY = 0.9  # of the length or the width of the flat part
_LEANS = 2e-3  # rad: a tilt worth a word
_CANDIDATES = 120  # edges tried at once
_ROUNDS = 12  # of refinement, each about the best edges of the last
_ADVICE = (
    "give the sole rectangle (--sole, or [sole] in the file for --choices) and the height of the "
    "ankle above it (sole_drop there)"
)


@dataclass(frozen=True)
class FoundSole:
    """A sole found from the shape of a foot.

    Attributes:
        placement: of the sole frame (x forward, y left, z up, origin on the sole below the ankle)
            in the frame of the last joint of the leg.
        sole: the rectangle in it.
        how: one sentence: where it came from, its size, what was left out.
        share: of the flat part under the foot that is in the rectangle.
        others: other rectangles that suit the flat part, by name, where the largest leaves out
            more than a tenth of it.
    """

    placement: pin.SE3
    sole: Sole
    how: str
    share: float = 1.0
    others: tuple[tuple[str, Sole], ...] = ()


def find_sole(shape: FootShape, upright: Array, ankle: Array) -> FoundSole:
    """Find the largest rectangle in the flat part under a foot.

    The flat part is the convex hull of all points less than 2 mm above the lowest one; toes and
    heels that curve up are not part of it. The rectangle has its edges along x and y.

    Args:
        shape: of the foot.
        upright: columns forward, left and up of the standing foot in the frame of its joint,
            shape (3, 3).
        ankle: centre of the ankle in that frame [m], shape (3,).

    Raises:
        RobotError: the flat part is smaller than 5 cm²: an edge, a stud or a ball.
    """
    rotation = np.array(upright, dtype=float)
    points = shape.points @ rotation
    below = points[:, 2] - shape.radii
    height = float(below.min())
    flat = points[below < height + _FLATNESS, :2]
    toe, heel, left, right = largest_rectangle(flat)
    if (toe - heel) * (left - right) < _SMALLEST:
        raise RobotError(
            f"no sole was found under the foot: the part within {_FLATNESS * 1e3:g} mm of its "
            f"lowest point holds a rectangle of {(toe - heel) * 1e3:.1f} x "
            f"{(left - right) * 1e3:.1f} mm only, less than {_SMALLEST * 1e4:g} cm² "
            f"({shape.how}); {_ADVICE}{_leaning(shape, points)}"
        )
    x, y, z = (float(v) for v in np.asarray(ankle, dtype=float) @ rotation)

    def seen(edges: tuple[float, float, float, float]) -> Sole:
        toe, heel, left, right = edges
        return Sole(*(tidy(v) for v in (toe - x, heel - x, left - y, right - y)))

    sole = seen((toe, heel, left, right))
    share = (toe - heel) * (left - right) / float(ConvexHull(flat).volume)
    origin = rotation @ np.array([x, y, tidy(height)])
    how = (
        f"{(toe - heel) * 1e3:.1f} x {(left - right) * 1e3:.1f} mm, {(z - height) * 1e3:.1f} mm "
        f"below the ankle, from {shape.how}"
    )
    whole = float(np.ptp(points[:, 0]))
    if toe - heel < _MOST * whole:
        how += (
            f"; the foot is {whole * 1e3:.0f} mm long, rounded or raised at its ends: give a "
            "larger rectangle (sole) if they carry"
        )
    if left - right > toe - heel:
        how += "; wider than long: see whether the mesh lies turned, or give the rectangle (sole)"
    others = _other_rectangles(flat) if share < _LEAVES_OUT else {}
    candidates = tuple((name, seen(edges)) for name, edges in others.items())
    return FoundSole(pin.SE3(rotation, origin), sole, how, share, candidates)


def _other_rectangles(flat: Array) -> dict[str, tuple[float, float, float, float]]:
    """Return rectangles that suit a flat part that is none, toe, heel, left and right by name."""
    (high_x, high_y), (low_x, low_y) = flat.max(axis=0), flat.min(axis=0)
    long, wide = high_x - low_x, high_y - low_y
    return {
        f"{_NEARLY:.0%} of its length": largest_rectangle(flat, (_NEARLY * long, 0.0)),
        f"{_NEARLY:.0%} of its width": largest_rectangle(flat, (0.0, _NEARLY * wide)),
        "all of it, with corners in the air": (
            float(high_x), float(low_x), float(high_y), float(low_y)
        ),
    }  # fmt: skip


def _leaning(shape: FootShape, points: Array) -> str:
    """Say by how much the foot's lower face leans, if it does, and what helps."""
    down = np.array([0.0, 0.0, -1.0])
    face = lowest_face(points, shape.radii, down)
    if face is None or tilt(face, down) < _LEANS:
        return ""
    angle = np.degrees(tilt(face, down))
    return (
        f"; or, as its lower face is tilted by {angle:.2f} degrees, say which "
        "direction of the root link is up (up = [X, Y, Z]) or give a posture with flat feet "
        "([posture]), both in the file for --choices"
    )


def largest_rectangle(
    points: Array, least: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float, float, float]:
    """Return the largest rectangle along the axes in the convex hull of points in a plane.

    Args:
        points: shape (n, 2).
        least: extent along x and y that it must have [m].

    Returns:
        Largest x, smallest x, largest y, smallest y; of no area if the hull has none.
    """
    points = np.unique(np.round(points, 12), axis=0)
    low, high = points.min(axis=0), points.max(axis=0)
    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # fewer than three points, or all on one line
        return float(low[0]), float(low[0]), float(low[1]), float(low[1])
    edges = np.unique(np.concatenate([hull[:, 0], np.linspace(low[0], high[0], _CANDIDATES)]))
    starts, ends, step = edges, edges, (high[0] - low[0]) / (_CANDIDATES - 1)
    best = _best_strip(hull, starts, ends, least)
    for _ in range(_ROUNDS):
        starts, ends = (
            np.clip(x + np.linspace(-step, step, 21), low[0], high[0]) for x in best[1:3]
        )
        best = max(best, _best_strip(hull, starts, ends, least), key=lambda b: b[0])
        step /= 8.0
    _, heel, toe, right, left = best
    return toe, heel, left, right


def _best_strip(
    hull: Array, starts: Array, ends: Array, least: tuple[float, float]
) -> tuple[float, float, float, float, float]:
    """Return area, smallest x, largest x, smallest y, largest y of the best pair of edges."""
    (low_a, high_a), (low_b, high_b) = (_sides(hull, x) for x in (starts, ends))
    low = np.maximum(low_a[:, None], low_b[None, :])
    high = np.minimum(high_a[:, None], high_b[None, :])
    long, wide = ends[None, :] - starts[:, None], high - low
    fits = (long > 0.0) & (wide > 0.0) & (long >= least[0]) & (wide >= least[1])
    area = np.where(fits, long * wide, 0.0)
    i, j = np.unravel_index(int(area.argmax()), area.shape)
    if area[i, j] == 0.0:
        x, y = float(starts[0]), float(low_a[0])
        return 0.0, x, x, y, y
    return float(area[i, j]), float(starts[i]), float(ends[j]), float(low[i, j]), float(high[i, j])


def _sides(hull: Array, x: Array) -> tuple[Array, Array]:
    """Return the smallest and the largest y of a convex polygon at each x inside it."""
    a, b = hull, np.roll(hull, -1, axis=0)
    first, last = np.where((a[:, :1] <= b[:, :1]), a, b), np.where((a[:, :1] <= b[:, :1]), b, a)
    span = last[:, 0] - first[:, 0]
    share = (x[:, None] - first[:, 0]) / np.where(span > 0.0, span, 1.0)
    y = first[:, 1] + share * (last[:, 1] - first[:, 1])
    crossed = (x[:, None] >= first[:, 0]) & (x[:, None] <= last[:, 0]) & (span > 0.0)
    return (
        np.where(crossed, y, np.inf).min(axis=1),
        np.where(crossed, y, -np.inf).max(axis=1),
    )
