"""The legs as capsules: what keeps them from running into each other.

A capsule is all that is within a radius of a line segment. One covers everything of a body that
the URDF shows: its collision shapes or, if it has none, its visual ones; a body without any is a
capsule between its joints. They are found once per robot.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.choices import CapsuleRow
from gaitopt.robot.feet.cover import Cover, cover
from gaitopt.robot.feet.shape_points import Points, placed_shapes
from gaitopt.robot.feet.sole import Sole
from gaitopt.robot.files.source import Source, read_source
from gaitopt.robot.legs.joint_points import points_on_lines
from gaitopt.robot.legs.placed import place
from gaitopt.robot.model import Robot

DEFAULT_RADIUS = 0.05  # m: of a body whose shape is unknown
PELVIS = 6  # its place among the bodies
LEGS = (*range(PELVIS), *range(PELVIS + 1, 13))  # bodies of the stance leg, then of the swing leg
_SHORT = 1e-3  # m: a body without shapes between joints this near is part of its neighbours


@dataclass(frozen=True)
class Capsule:
    """One body of a leg.

    Attributes:
        body: place in the chain, 0 (stance foot) to 12 (swing foot).
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
class _Question:
    """A robot, equal to all others of the same shape, whatever their limits."""

    urdf: str
    package_dirs: tuple[str, ...]
    soles: tuple[str, str]
    sole: Sole
    robot: Robot = field(compare=False)


def leg_capsules(robot: Robot) -> tuple[Capsule, ...]:
    """Return the capsules of both legs' bodies, in the order of the chain.

    Bodies of no size (two joints in one point, nothing drawn) have none. The result is kept.

    Raises:
        RobotError: a mesh file of a leg is there but cannot be read.
    """
    if robot.choices.capsules is not None:
        return tuple(
            Capsule(row[0], row[1], row[2:5], row[5:8], row[8], row[9])
            for row in robot.choices.capsules
        )
    soles = (robot.stance_sole, robot.swing_sole)
    return _capsules(_Question(robot.urdf, robot.choices.package_dirs, soles, robot.sole, robot))


def capsule_rows(robot: Robot) -> tuple[CapsuleRow, ...]:
    """Return the capsules as `Choices` keeps them, so that no mesh is needed to find them again."""
    return tuple(
        (c.body, c.name, *c.start, *c.end, c.radius, c.source) for c in leg_capsules(robot)
    )


@lru_cache(maxsize=16)
def _capsules(question: _Question) -> tuple[Capsule, ...]:
    robot = question.robot
    source = read_source(robot.urdf, robot.choices.package_dirs)
    found: dict[int, Capsule] = {}
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        missing = [body for body in LEGS if body not in found]
        for body, points in _points_by_body(robot, source, kind, missing).items():
            along = np.diff(_joints(robot, body), axis=0)[0]
            shape = cover(points, along, _facing(robot, body))
            found[body] = _capsule(robot, body, shape, kind.name.lower())
    for body in LEGS:
        start, end = _joints(robot, body)
        if body not in found and np.linalg.norm(end - start) > _SHORT:
            found[body] = _capsule(robot, body, Cover(start, end, DEFAULT_RADIUS), "joints")
    return tuple(found[body] for body in sorted(found))


def _capsule(robot: Robot, body: int, shape: Cover, source: str) -> Capsule:
    start, end = ((float(p[0]), float(p[1]), float(p[2])) for p in (shape.start, shape.end))
    return Capsule(body, _name(robot, body), start, end, shape.radius, source)


def _joints(robot: Robot, body: int) -> Array:
    """Ends of a body in its own frame: its two joints; heel and toe of a foot, shape (2, 3)."""
    model = robot.model
    if body in (0, 12):
        sole = robot.sole
        name = robot.stance_sole if body == 0 else robot.swing_sole
        frame = model.frames[model.getFrameId(name)].placement
        middle = (sole.left + sole.right) / 2.0
        ends = ((x, middle, 0.0) for x in (sole.heel, sole.toe))
        return np.array([frame.act(np.array(p)) for p in ends])
    placed = place(model, pin.neutral(model))
    own = placed.places[body + 1]
    # From the hip downwards in both legs, so that their capsules mirror each other.
    rows = list(range(2, 8))[::-1] if body < PELVIS else list(range(8, 14))
    origins = np.array([placed.places[row].translation for row in rows])
    points = points_on_lines(origins, placed.lines[1][rows], [0, *range(5)])
    return np.array([own.actInv(points[rows.index(row)]) for row in (body + 1, body + 2)])


def _facing(robot: Robot, body: int) -> Array:
    """The direction towards the other leg in the frame of a body, legs straight, shape (3,)."""
    model = robot.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    left = data.oMf[robot.pelvis_frame].rotation[:, 1]
    towards = robot.legs.side * (left if body < PELVIS else -left)
    return np.asarray(data.oMi[body + 1].rotation.T @ towards)


def _name(robot: Robot, body: int) -> str:
    """The link that the body's joint carries in the URDF, if it has a name of its own."""
    links = [f.name for f in robot.model.frames if f.parentJoint == body + 1]
    heavy = [n for n in links if n not in (robot.stance_sole, robot.swing_sole)]
    return heavy[0] if heavy else str(robot.model.names[body + 1])


def _points_by_body(
    robot: Robot, source: Source, kind: pin.GeometryType, bodies: list[int]
) -> dict[int, Points]:
    """Points of the shapes of one kind in the frames of the bodies; missing meshes have none."""
    frames = {str(f.name): f for f in robot.model.frames if f.parentJoint - 1 in bodies}
    links = {name: frame.placement for name, frame in frames.items()}
    found: dict[int, list[Points]] = {}
    for shape in placed_shapes(source, kind, links, around=True):
        found.setdefault(frames[shape.link].parentJoint - 1, []).append(shape.points)
    return {body: Points.together(parts) for body, parts in found.items()}
