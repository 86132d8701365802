"""Legs and moving arms as capsules: what keeps them from running into each other and the trunk.

A capsule is all that is within a radius of a line segment. One covers everything of a body that
the URDF shows: its collision shapes or, if it has none, its visual ones; a body without any is a
capsule between its joints. They are found once per robot.

Of arms, and of what they may run into (pelvis, waist, thighs, loads), several capsules may cover a
body, for one around a torso would reach far into arms that hang beside it: its shapes are cut where
that makes the capsules smaller, and put together where it does not.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from functools import lru_cache
from itertools import combinations

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source
from gaitopt.model.import_options import CapsuleRow
from gaitopt.model.joint_tree import FIRST
from gaitopt.model.kinematic_tree import points_on_lines, pose_model
from gaitopt.model.robot import Robot
from gaitopt.model.sole_detection import Points, box_points, placed_shapes
from gaitopt.nlp import Array

DEFAULT_RADIUS = 0.05
"""Radius of a body whose shape is unknown, of the thirteen-link biped [m]."""
SHORT = 1e-3
"""A body without shapes between joints this near is part of its neighbours; likewise [m]."""

_OF_SPACING = 0.42  # of the distance between the hips: the largest radius of such capsules
_INSIDE = 1.0 + 1e-9  # of a radius: rounding
_TINY = 1e-9  # m: rounding
_WIDER = 3.0  # times the least radius: where the side of a leg is nearly as flat as it is itself
_SIDEWAYS = 0.3  # of the unit: an axis nearer to the direction it faces has no such side


@dataclass(frozen=True)
class Capsule:
    """One body of a leg.

    Attributes:
        body: its number in the robot's `JointTree`, 0 for the stance foot.
        name: of its first link.
        start, end: of the segment in the frame of the body's joint [m], shape (3,).
        radius: [m].
        source: "collision", "visual" or "joints".
    """

    body: int
    name: str
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    source: str

    @property
    def ends(self) -> Array:
        """Both ends of the segment [m], shape (2, 3)."""
        return np.array([self.start, self.end])

    @property
    def row(self) -> CapsuleRow:
        """It as `ImportOptions` keeps it."""
        return (self.body, self.name, *self.start, *self.end, self.radius, self.source)

    @classmethod
    def of_row(cls, row: CapsuleRow) -> Capsule:
        """Return that of a row."""
        return cls(row[0], row[1], row[2:5], row[5:8], row[8], row[9])


@dataclass(frozen=True)
class _CapsuleKey:
    """A robot, equal to all others of the same shape, whatever their limits and masses."""

    shape: tuple[object, ...]
    robot: Robot = field(compare=False)

    @classmethod
    def of(cls, robot: Robot) -> _CapsuleKey:
        choices, soles = robot.choices, (robot.stance_sole, robot.swing_sole)
        # Of joints and links on the bodies that carry them, which proportions change.
        placed = [*robot.model.jointPlacements, *(f.placement for f in robot.model.frames)]
        places = tuple(np.array([place.homogeneous for place in placed]).ravel().tolist())
        shape = (
            robot.urdf, choices.package_dirs, soles, robot.sole, robot.tree.names, places,
            choices.payloads,
        )  # fmt: skip
        return cls(shape, robot)


def leg_capsules(robot: Robot) -> tuple[Capsule, ...]:
    """Return the capsules of both legs' bodies, in the order of the chain.

    Bodies of no size (two joints in one point, nothing drawn) have none. The result is kept.

    Raises:
        RobotError: a mesh file of a leg is there but cannot be read.
    """
    if robot.choices.capsules is not None:
        return tuple(map(Capsule.of_row, robot.choices.capsules))
    return _capsules(_CapsuleKey.of(robot))


def capsule_rows(capsules: Iterable[Capsule]) -> tuple[CapsuleRow, ...]:
    """Return capsules as `ImportOptions` keeps them: no mesh is needed to find them again."""
    return tuple(capsule.row for capsule in capsules)


@lru_cache(maxsize=16)
def _capsules(key: _CapsuleKey) -> tuple[Capsule, ...]:
    robot = key.robot
    source = read_source(robot.urdf, robot.choices.package_dirs)
    bars, towards = _bars(robot), _towards_other_leg(robot)
    found: dict[int, Capsule] = {}

    def add(body: int, shape: BoundingCapsule, origin: str) -> None:
        found[body] = shape.of(body, link_of(robot, body), origin)

    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        missing = [body for body in bars if body not in found]
        for body, parts in shapes_by_body(robot, source, kind, missing).items():
            points, (start, end) = Points.together(parts), bars[body]
            add(body, bounding_capsule(points, end - start, towards[body]), kind.name.lower())
    for body, (start, end) in bars.items():
        if body not in found and np.linalg.norm(end - start) > SHORT * robot.scales.length:
            add(body, BoundingCapsule(start, end, bar_radius(robot)), "joints")
    return tuple(found[body] for body in sorted(found))


def bar_radius(robot: Robot) -> float:
    """Return the radius of the capsules of bodies without shapes [m].

    As usual, but with a sixth of the hips' distance between two of them side by side: the hips of
    NAO are 0.1 m apart.
    """
    return min(DEFAULT_RADIUS * robot.scales.length, _OF_SPACING * abs(robot.legs.spacing))


def _bars(robot: Robot) -> dict[int, Array]:
    """Ends of each leg body in its own frame: its two joints; heel and toe of a foot, (2, 3)."""
    model, tree, sole = robot.model, robot.tree, robot.sole
    posed = pose_model(model, pin.neutral(model))
    bars = {}
    for body, name in ((0, robot.stance_sole), (tree.swing_foot, robot.swing_sole)):
        frame, middle = model.frames[model.getFrameId(name)].placement, (sole.left + sole.right) / 2
        bars[body] = np.array(
            [frame.act(np.array([x, middle, 0.0])) for x in (sole.heel, sole.toe)]
        )
    # From the hip downwards in both legs, so that their capsules mirror each other.
    for rows in (range(tree.stance)[::-1], range(tree.stance, tree.swing_foot)):
        ids = [FIRST + row for row in rows]
        origins = np.array([posed.placements[j].translation for j in ids])
        points = points_on_lines(origins, posed.axes[ids], [0, *range(len(ids) - 1)])
        places = dict(zip(rows, points, strict=True))
        for body in range(min(rows) + 1, max(rows) + 1):
            own = posed.placements[body + 1]
            bars[body] = np.array([own.actInv(places[body - 1]), own.actInv(places[body])])
    return bars


def _towards_other_leg(robot: Robot) -> dict[int, Array]:
    """The direction towards the other leg in the frame of each body, legs straight, shape (3,)."""
    model, tree = robot.model, robot.tree
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    left = robot.legs.side * data.oMf[robot.pelvis_frame].rotation[:, 1]
    return {
        body: data.oMi[body + 1].rotation.T @ (left if body < tree.pelvis else -left)
        for body in range(tree.swing_foot + 1)
    }


def link_of(robot: Robot, body: int) -> str:
    """Return the link that a body's joint carries in the URDF, if it has a name of its own."""
    links = [f.name for f in robot.model.frames if f.parentJoint == body + 1]
    heavy = [n for n in links if n not in (robot.stance_sole, robot.swing_sole)]
    return heavy[0] if heavy else str(robot.model.names[body + 1])


def shapes_by_body(
    robot: Robot, source: Source, kind: pin.GeometryType, bodies: list[int]
) -> dict[int, list[Points]]:
    """Return the shapes of one kind in the frames of the bodies; missing meshes have none."""
    frames = {str(f.name): f for f in robot.model.frames if f.parentJoint - 1 in bodies}
    links = {name: frame.placement for name, frame in frames.items()}
    found: dict[int, list[Points]] = {}
    for shape in placed_shapes(source, kind, links, around=True):
        found.setdefault(frames[shape.link].parentJoint - 1, []).append(shape.points)
    return found


@dataclass(frozen=True)
class BoundingCapsule:
    """All within `radius` of the segment from `start` to `end`."""

    start: Array
    end: Array
    radius: float

    @property
    def volume(self) -> float:
        """Volume [m³]."""
        length = float(np.linalg.norm(self.end - self.start))
        return np.pi * self.radius**2 * (length + 4.0 / 3.0 * self.radius)

    def of(self, body: int, name: str, source: str) -> Capsule:
        """Return it as a capsule of a body, with a name and what it covers."""
        (x, y, z), (u, v, w) = self.start.tolist(), self.end.tolist()
        return Capsule(body, name, (x, y, z), (u, v, w), self.radius, source)

    def reach(self, direction: Array) -> float:
        """How far it reaches along a unit vector (3,) [m]."""
        return max(float(self.start @ direction), float(self.end @ direction)) + self.radius


def bounding_capsule(points: Points, along: Array, facing: Array) -> BoundingCapsule:
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
    smallest = [(_capsule_along(points, d, np.zeros(3)), d) for d in directions]
    found, direction = min(smallest, key=lambda pair: pair[0].volume)
    if np.linalg.norm(facing - (facing @ direction) * direction) < _SIDEWAYS:
        return found
    return min((found, _capsule_along(points, direction, facing)), key=lambda c: c.reach(facing))


def _capsule_along(points: Points, direction: Array, facing: Array) -> BoundingCapsule:
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
    return BoundingCapsule(base + low * direction, base + high * direction, radius)


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
    has the proof that two or three determine it). Points are complex numbers: of the few that a
    circle goes through, Python's are ten times faster than arrays.
    """
    plane = points @ (1.0, 1.0j)
    chosen: tuple[complex, ...] = (complex(plane[0]),)
    while True:
        centre, radius = _circle_around(chosen)
        off = np.abs(plane - centre)
        farthest = int(np.argmax(off))
        if off[farthest] <= radius * _INSIDE + _TINY:
            return np.array([centre.real, centre.imag])
        grown = (*chosen, complex(plane[farthest]))
        # What is outside of a circle lies on the next one.
        others = [c for n in (1, 2) for c in combinations(chosen, n)]
        chosen = min(
            (c for o in others if _holds(c := (*o, grown[-1]), grown)),
            key=lambda c: _circle_around(c)[1],
        )


def _holds(chosen: tuple[complex, ...], points: Iterable[complex]) -> bool:
    centre, radius = _circle_around(chosen)
    return max(abs(point - centre) for point in points) <= radius * _INSIDE + _TINY


def _circle_around(points: tuple[complex, ...]) -> tuple[complex, float]:
    """Centre and radius of the circle through one point, two opposite ones, or three."""
    a = points[0]
    if len(points) < 3:
        centre = sum(points) / len(points)
        return centre, abs(a - centre)
    u, v = points[1] - a, points[2] - a
    area = (u.conjugate() * v).imag
    if abs(area) < 1e-18:  # on one line: two of them do
        return a, -1.0
    centre = a + 0.5j * (u * abs(v) ** 2 - v * abs(u) ** 2) / area
    return centre, abs(a - centre)


_OF_TRUNK, _OF_LIMB = 6, 2  # capsules of a body at most
_THICKER = 1.2  # times the radius of both halves: one capsule is too thick to take their place
_THIN = 0.14  # of the leg's length: the radius of a capsule that is good enough
_ANYWHERE = np.zeros(3)


def arm_bodies(robot: Robot) -> dict[int, int]:
    """Return the bodies of moving arms, and of each the one at which its arm begins.

    Arms are what moves beside the legs and has a mirror image that is another body.
    """
    tree = robot.tree
    paired = {
        name: int(np.abs(row).argmax()) != k
        for k, (name, row) in enumerate(zip(robot.joint_names, robot.mirror, strict=True))
    }
    found: dict[int, int] = {}
    for joint in range(tree.swing_foot, tree.size):
        on = tree.parents[joint] + 1  # the body on which it sits
        if on in found:
            found[joint + 1] = found[on]
        elif paired.get(tree.names[joint], False):
            found[joint + 1] = joint + 1
    return found


def arm_capsules(robot: Robot) -> tuple[Capsule, ...]:
    """Return the capsules of moving arms and of what they may run into, in the order of the bodies.

    None where no arm moves. The result is kept.

    Raises:
        RobotError: a mesh file of such a body is there but cannot be read.
    """
    if robot.choices.arm_capsules is not None:
        return tuple(map(Capsule.of_row, robot.choices.arm_capsules))
    return _arm_capsules(_CapsuleKey.of(robot)) if arm_bodies(robot) else ()


@lru_cache(maxsize=16)
def _arm_capsules(key: _CapsuleKey) -> tuple[Capsule, ...]:
    robot, tree = key.robot, key.robot.tree
    source, images = read_source(robot.urdf, robot.choices.package_dirs), _Images(robot)
    stance_knee, swing_knee = robot.legs.knees
    bodies = [
        *range(stance_knee + 1, swing_knee + 1),  # thighs, pelvis
        *range(tree.swing_foot + 1, tree.size + 1),
    ]
    thin = _THIN * robot.legs.reach
    found: dict[int, list[Capsule]] = {}
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        missing = [body for body in bodies if body not in found]
        shapes = shapes_by_body(robot, source, kind, missing)
        for body, parts in shapes.items():
            if (other := images.of(body)) < body and other in found:
                continue
            both = parts + [images.points(p, body) for p in shapes.get(other, []) if other != body]
            most = _OF_TRUNK if other == body else _OF_LIMB
            around = _covered(both, thin, most)
            found[body] = _named(body, link_of(robot, body), around, kind.name.lower())
            if other != body:
                around = [images.capsule(capsule, other) for capsule in around]
                found[other] = _named(other, link_of(robot, other), around, kind.name.lower())
    for body in bodies:
        if body not in found:
            found[body] = _named(body, link_of(robot, body), list(_own_bars(robot, body)), "joints")
    for payload in robot.choices.payloads:
        frame = robot.model.frames[robot.model.getFrameId(payload.link)]
        body = int(frame.parentJoint) - 1
        if body in found and payload.place is not None and any(payload.box):
            place = frame.placement * pin.SE3(np.eye(3), np.array(payload.place))
            box = box_points(np.array(payload.box) / 2.0).placed(place)
            found[body] += _named(body, "the load", _covered([box], thin, _OF_TRUNK), "load")
    return tuple(capsule for body in sorted(found) for capsule in found[body])


class _Images:
    """Bodies and what belongs to them as a mirror between the legs shows them."""

    def __init__(self, robot: Robot) -> None:
        self._tree, self._mirror = robot.tree, np.abs(robot.coupling.mirror).argmax(axis=1)
        data = robot.model.createData()
        pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
        middle = data.oMf[robot.pelvis_frame]
        self._places = [middle.actInv(place) for place in data.oMi[1:]]

    def of(self, body: int) -> int:
        """Return the body on the other side, or the body itself if it is in the middle."""
        if body <= self._tree.swing_foot:
            return self._tree.swing_foot - body
        return int(self._mirror[body - 1]) + 1

    def points(self, points: Points, body: int) -> Points:
        """Return balls of the other side's body as the image of `body` has them."""
        return Points(self._seen(points.centres, body), points.radii)

    def capsule(self, capsule: BoundingCapsule, body: int) -> BoundingCapsule:
        """Return a capsule of the other side's body as the image of `body` has it."""
        start, end = self._seen(np.stack([capsule.start, capsule.end]), body)
        return BoundingCapsule(start, end, capsule.radius)

    def _seen(self, points: Array, body: int) -> Array:
        there, here = self._places[self.of(body)], self._places[body]
        image = (points @ there.rotation.T + there.translation) * [1.0, -1.0, 1.0]
        return np.asarray((image - here.translation) @ here.rotation)


def _named(body: int, name: str, shapes: list[BoundingCapsule], origin: str) -> list[Capsule]:
    """Return capsules with names; those of one body are numbered if there are several."""
    several = len(shapes) > 1
    return [
        shape.of(body, f"{name} ({k + 1})" if several else name, origin)
        for k, shape in enumerate(shapes)
    ]


def _own_bars(robot: Robot, body: int) -> Iterator[BoundingCapsule]:
    """Yield bars from a body's joint to those that it carries."""
    tree, model = robot.tree, robot.model
    for joint, parent in enumerate(tree.parents):
        end = model.jointPlacements[FIRST + joint].translation
        if parent + 1 == body and np.linalg.norm(end) > SHORT * robot.scales.length:
            yield BoundingCapsule(np.zeros(3), end.copy(), bar_radius(robot))


Piece = tuple[Points, BoundingCapsule]


def _covered(parts: list[Points], thin: float, most: int) -> list[BoundingCapsule]:
    """Return few small capsules that cover shapes, which are cut if theirs are not thin."""
    pieces = [piece for part in parts for piece in _cut(_around(part), thin)]
    joined: dict[frozenset[int], Piece] = {}  # by the numbers of both
    numbers = list(range(len(pieces)))
    while len(numbers) > 1:
        best = (True, np.inf, 0, 0)
        for i, j in combinations(numbers, 2):
            one, other, pair = pieces[i], pieces[j], frozenset((i, j))
            if pair not in joined:
                joined[pair] = _around(Points.joined([one[0], other[0]]))
            both = joined[pair][1]
            thicker = both.radius > max(thin, _THICKER * _thickest((one, other)))
            best = min(best, (thicker, both.volume - one[1].volume - other[1].volume, i, j))
        thicker, grown, i, j = best
        if (thicker or grown > 0.0) and len(numbers) <= most:
            break
        pieces.append(joined[frozenset((i, j))])
        numbers = [*(k for k in numbers if k not in (i, j)), len(pieces) - 1]
    return [pieces[k][1] for k in numbers]


def _around(points: Points) -> Piece:
    """Return the corners of a shape, and a capsule around them."""
    corners = Points.together([points])
    return corners, bounding_capsule(corners, _ANYWHERE, _ANYWHERE)


def _cut(piece: Piece, thin: float, depth: int = 2) -> list[Piece]:
    """Return a shape in pieces, halved across one of its two longest directions while that pays."""
    points, around = piece
    if depth == 0 or around.radius < thin or len(points.centres) < 4:
        return [piece]
    spread = points.centres - points.centres.mean(axis=0)
    directions = np.linalg.eigh(spread.T @ spread)[1].T[1:]
    halves = [tuple(map(_around, both)) for d in directions if (both := _halves(points, d))]
    if not halves:
        return [piece]
    best = min(halves, key=_thickest)
    if _thickest(best) > around.radius / _THICKER:
        return [piece]
    return [smaller for half in best for smaller in _cut(half, thin, depth - 1)]


def _thickest(pieces: Iterable[Piece]) -> float:
    return max(capsule.radius for _, capsule in pieces)


def _halves(points: Points, direction: Array) -> tuple[Points, Points] | None:
    """Return both halves of the hull of some balls, of equal width; None if it is flat."""
    from scipy.spatial import ConvexHull, QhullError  # slow to import, and seldom needed

    height = points.centres @ direction
    height = height - (height.min() + height.max()) / 2.0
    try:
        corners = ConvexHull(points.centres).simplices
    except QhullError:
        return None
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    edges = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0.0]
    low, high = edges.T
    share = height[low] / (height[low] - height[high])
    on_cut = Points(
        (1.0 - share)[:, None] * points.centres[low] + share[:, None] * points.centres[high],
        (1.0 - share) * points.radii[low] + share * points.radii[high],
    )
    sides = [Points(points.centres[side], points.radii[side]) for side in (height <= 0, height > 0)]
    below, above = (Points.joined([side, on_cut]) for side in sides)
    return below, above
