"""The legs as capsules: what keeps them from running into each other.

A capsule is all that is within a radius of a line segment. One covers everything of a body that
the URDF shows: its collision shapes or, if it has none, its visual ones; a body without any is a
capsule between its joints. They are found once per robot.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field
from functools import lru_cache
from itertools import combinations

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source
from gaitopt.model.feet.foot_shape import Points, placed_shapes
from gaitopt.model.import_options import CapsuleRow, Payload
from gaitopt.model.joint_tree import FIRST
from gaitopt.model.legs.kinematic_tree import points_on_lines, pose_model
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
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


@dataclass(frozen=True)
class CapsuleKey:
    """A robot, equal to all others of the same shape, whatever their limits and masses.

    Attributes:
        urdf: text of its description.
        package_dirs: where its meshes are.
        soles, sole: names of the sole frames, and their rectangle.
        joints: names of those that move.
        places: of joints and links on the bodies that carry them, which proportions change.
        payloads: what it carries.
        robot: itself, which is not compared.
    """

    urdf: str
    package_dirs: tuple[str, ...]
    soles: tuple[str, str]
    sole: Sole
    joints: tuple[str, ...]
    places: tuple[float, ...]
    payloads: tuple[Payload, ...]
    robot: Robot = field(compare=False)

    @classmethod
    def of(cls, robot: Robot) -> CapsuleKey:
        """Return that of a robot."""
        choices, soles = robot.choices, (robot.stance_sole, robot.swing_sole)
        placed = [*robot.model.jointPlacements, *(f.placement for f in robot.model.frames)]
        places = tuple(np.array([place.homogeneous for place in placed]).ravel().tolist())
        return cls(
            robot.urdf, choices.package_dirs, soles, robot.sole, robot.tree.names, places,
            choices.payloads, robot,
        )  # fmt: skip


def leg_capsules(robot: Robot) -> tuple[Capsule, ...]:
    """Return the capsules of both legs' bodies, in the order of the chain.

    Bodies of no size (two joints in one point, nothing drawn) have none. The result is kept.

    Raises:
        RobotError: a mesh file of a leg is there but cannot be read.
    """
    if robot.choices.capsules is not None:
        return capsules_of_rows(robot.choices.capsules)
    return _capsules(CapsuleKey.of(robot))


def capsule_rows(robot: Robot) -> tuple[CapsuleRow, ...]:
    """Return the capsules as `ImportOptions` keeps them: no mesh is needed to find them again."""
    return rows_of_capsules(leg_capsules(robot))


def rows_of_capsules(capsules: Iterable[Capsule]) -> tuple[CapsuleRow, ...]:
    """Return capsules as rows of plain values."""
    return tuple((c.body, c.name, *c.start, *c.end, c.radius, c.source) for c in capsules)


def capsules_of_rows(rows: Iterable[CapsuleRow]) -> tuple[Capsule, ...]:
    """Return capsules from such rows."""
    return tuple(Capsule(row[0], row[1], row[2:5], row[5:8], row[8], row[9]) for row in rows)


@lru_cache(maxsize=16)
def _capsules(key: CapsuleKey) -> tuple[Capsule, ...]:
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
        # What is outside of a circle lies on the next one.
        others = [c for n in (1, 2) for c in combinations(chosen, n)]
        chosen = min(
            (c for o in others if _holds(c := np.array((*o, points[farthest])), grown)),
            key=lambda c: _circle_around(c)[1],
        )


def _holds(chosen: Array, points: Array) -> bool:
    centre, radius = _circle_around(chosen)
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
