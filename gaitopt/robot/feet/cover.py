"""The smallest capsule found around a body's shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.feet.shape_points import Points

_INSIDE = 1.0 + 1e-9  # of a radius: rounding
_TINY = 1e-9  # m: rounding
_WIDER = 3.0  # times the least radius: where the side of a leg is nearly as flat as it is itself
_SIDEWAYS = 0.3  # of the unit: an axis nearer to the direction it faces has no such side


@dataclass(frozen=True)
class Cover:
    """A capsule: all within `radius` of the segment from `start` to `end`."""

    start: Array
    end: Array
    radius: float

    @property
    def volume(self) -> float:
        """Volume [m³]."""
        length = float(np.linalg.norm(self.end - self.start))
        return np.pi * self.radius**2 * (length + 4.0 / 3.0 * self.radius)

    def reach(self, direction: Array) -> float:
        """How far it reaches along a unit vector [m]."""
        return max(float(self.start @ direction), float(self.end @ direction)) + self.radius


def cover(points: Points, along: Array, facing: Array) -> Cover:
    """Return a capsule that contains all balls and reaches little to the side that it faces.

    Its axis is that of the smallest of the capsules along the principal axes of the points and
    along one direction more. It may then grow away from the side it faces, for a wider circle is
    flatter: only what reaches towards the other leg matters.

    Args:
        points: what is to be covered.
        along: a direction in which the body may be long, shape (3,); zero for none.
        facing: unit vector towards what must not be touched, shape (3,); zero for none.
    """
    spread = points.centres - points.centres.mean(axis=0)
    directions = list(np.linalg.eigh(spread.T @ spread)[1].T)
    if np.linalg.norm(along) > 0.0:
        directions.insert(0, along / np.linalg.norm(along))
    smallest = [(_cover_along(points, d, np.zeros(3)), d) for d in directions]
    found, direction = min(smallest, key=lambda pair: pair[0].volume)
    if np.linalg.norm(facing - (facing @ direction) * direction) < _SIDEWAYS:
        return found
    return min((found, _cover_along(points, direction, facing)), key=lambda c: c.reach(facing))


def _cover_along(points: Points, direction: Array, facing: Array) -> Cover:
    """The capsule around the narrowest cylinder of one direction, or around one that faces."""
    _, _, frame = np.linalg.svd(direction[None])
    across = points.centres @ frame[1:].T
    middle = smallest_circle(across)
    off = np.linalg.norm(across - middle, axis=1)
    radius = float((off + points.radii).max())
    if facing.any():
        radius = _WIDER * radius
        middle = farthest_centre(across, radius - points.radii, frame[1:] @ facing)
        off = np.linalg.norm(across - middle, axis=1)
    along = points.centres @ direction
    spare = np.sqrt(np.maximum((radius - points.radii) ** 2 - off**2, 0.0))
    low, high = float((along + spare).min()), float((along - spare).max())
    if low > high - _TINY:  # a ball does
        low = high = (low + high) / 2.0
    base = middle @ frame[1:]
    return Cover(base + low * direction, base + high * direction, radius)


def farthest_centre(points: Array, reach: Array, facing: Array) -> Array:
    """Return the point farthest against a direction that is within reach of all points, shape (2,).

    Points out of reach are taken into account one by one until none is left: the answer depends on
    two at most.

    Args:
        points: in a plane, shape (P, 2).
        reach: of each, shape (P,); there are points within reach of all.
        facing: direction, shape (2,).
    """
    chosen = [int(np.argmax(points @ facing - reach))]
    while True:
        centre = _farthest_of(points[chosen], reach[chosen], facing)
        missing = np.linalg.norm(points - centre, axis=1) - reach * _INSIDE
        worst = int(np.argmax(missing))
        if missing[worst] <= _TINY or worst in chosen:
            return centre
        chosen.append(worst)


def _farthest_of(points: Array, reach: Array, facing: Array) -> Array:
    """The same for a few points: straight behind one, or where the circles of two meet."""
    behind = points - reach[:, None] * facing / np.linalg.norm(facing)
    i, j = np.triu_indices(len(points), 1)
    apart = points[j] - points[i]
    square = np.maximum((apart**2).sum(axis=1), _TINY**2)
    share = (reach[i] ** 2 - reach[j] ** 2 + square) / (2.0 * square)
    height = np.sqrt(np.maximum(reach[i] ** 2 / square - share**2, 0.0))
    middle, turned = points[i] + share[:, None] * apart, apart[:, ::-1] * (-1.0, 1.0)
    meet = [middle + sign * height[:, None] * turned for sign in (1.0, -1.0)]
    candidates = np.concatenate([behind, *meet])
    off = np.linalg.norm(candidates[:, None] - points[None], axis=2) - reach * _INSIDE
    good = candidates[(off <= _TINY).all(axis=1)]
    return np.asarray(good[np.argmin(good @ facing)])


def smallest_circle(points: Array) -> Array:
    """Return the centre of the smallest circle around points of a plane (P, 2), shape (2,).

    The circle of two or three points grows with each round until none is left outside (Welzl, 1991,
    has the proof that two or three determine it).
    """
    chosen = points[:1]
    while True:
        centre, radius = _circle_around(chosen)
        off = np.linalg.norm(points - centre, axis=1)
        farthest = int(np.argmax(off))
        if off[farthest] <= radius * _INSIDE + _TINY:
            return centre
        grown = np.vstack([chosen, points[farthest]])
        chosen = min(
            (np.array(c) for n in (1, 2, 3) for c in combinations(grown, n) if _holds(c, grown)),
            key=lambda c: _circle_around(c)[1],
        )


def _holds(chosen: Sequence[Array], points: Array) -> bool:
    centre, radius = _circle_around(np.array(chosen))
    off = np.linalg.norm(points - centre, axis=1)
    return bool(off.max() <= radius * _INSIDE + _TINY)


def _circle_around(points: Array) -> tuple[Array, float]:
    """Centre and radius of the circle through one point, two opposite ones, or three."""
    a = points[0]
    if len(points) < 3:
        centre = points.mean(axis=0)
        return centre, float(np.linalg.norm(a - centre))
    sides = points[1:] - a
    if abs(np.linalg.det(sides)) < 1e-18:  # on one line: two of them do
        return a, -1.0
    centre = a + np.linalg.solve(2.0 * sides, (sides**2).sum(axis=1))
    return centre, float(np.linalg.norm(a - centre))
