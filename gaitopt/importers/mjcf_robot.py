"""A robot as MuJoCo compiles it from an MJCF file: plain numbers, nothing left to interpret."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from gaitopt.bounds import ARMATURE
from gaitopt.dataclass import dataclass
from gaitopt.importers.ties import Tie
from gaitopt.units import motion_words

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""Scalar part first, as in MuJoCo; of unit length."""

NO_TURN: Quaternion = (1.0, 0.0, 0.0, 0.0)
GEOM_KINDS = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
"""Of shapes."""
ORIGIN: Vector = (0.0, 0.0, 0.0)

_LARGEST_COORDINATE = 1e10  # m: beyond it MuJoCo calls a state bad, and squares soon have no value
_WRONG_PLACE = (
    "the place or size of one of its geoms or sites is not finite, or beyond "
    f"{_LARGEST_COORDINATE:g}; correct it"
)


@dataclass(frozen=True)
class Pose:
    """Place of a frame in another.

    Attributes:
        pos: of its origin [m].
        quat: how it is turned.
    """

    pos: Vector = ORIGIN
    quat: Quaternion = NO_TURN


@dataclass(frozen=True)
class CompiledJoint:
    """A joint of a body, all motors, transmissions and passive elements that act on it in one.

    Attributes:
        name: of the joint.
        kind: "hinge", "slide" or "ball".
        pos: of its anchor in the frame of the body [m].
        axis: in that frame, of unit length; of no meaning for a ball.
        ref: coordinate in the posture that the file draws [rad or m].
        lower, upper: range of the coordinate [rad or m], infinite where there is none.
        armature: inertia of rotor and gear seen from the joint [kg·m² or kg].
        damping, friction, stiffness, rest: see `physics.PassiveJoint`.
        least, most: force of all motors together [N·m or N], infinite where there is no limit.
    """

    name: str
    kind: str
    pos: Vector = ORIGIN
    axis: Vector = (0.0, 0.0, 1.0)
    ref: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf
    armature: float = 0.0
    damping: tuple[float, ...] = ()
    friction: float = 0.0
    stiffness: tuple[float, ...] = ()
    rest: float = 0.0
    least: float = -math.inf
    most: float = math.inf


@dataclass(frozen=True)
class CompiledGeom:
    """A shape of a body.

    Attributes:
        name: of the geom, or empty.
        kind: "sphere", "capsule", "ellipsoid", "cylinder", "box" or "mesh".
        size: as MuJoCo has it: radii and half lengths [m]; of no meaning for a mesh.
        place: in the frame of the body; of a mesh: of the frame in which its file is written.
        mesh: name of the mesh, or empty.
        rgba: colour and opacity, 0 to 1.
        touches: whether it can touch anything.
        drawn: whether MuJoCo shows it unless it is told otherwise.
    """

    name: str
    kind: str
    size: Vector
    place: Pose
    mesh: str
    rgba: tuple[float, float, float, float]
    touches: bool
    drawn: bool


@dataclass(frozen=True)
class CompiledMesh:
    """A mesh that geoms show.

    Attributes:
        name: of the mesh.
        file: as the robot's file names it, from the directory of that file; or empty.
        scale: of the numbers in the file along its axes.
        ref: pose in the scaled file that counts as the mesh's own frame.
        vertices, triangles: corners [m], three numbers each, and three indices each, of a mesh
            that no file holds.
    """

    name: str
    file: str
    scale: Vector = (1.0, 1.0, 1.0)
    ref: Pose = Pose()
    vertices: tuple[float, ...] = ()
    triangles: tuple[int, ...] = ()


@dataclass(frozen=True)
class CompiledSite:
    """A named frame of a body.

    Attributes:
        name: in the file.
        place: in the frame of its body.
    """

    name: str
    place: Pose


@dataclass(frozen=True)
class CompiledBody:
    """A body; one without joints is fixed to its parent.

    Attributes:
        name: of the body.
        parent: place of its parent in `CompiledRobot.bodies`; -1 for the root, which floats.
        place: in the frame of the parent, every joint at its `ref`.
        mass: [kg].
        centre: pose of the principal axes of inertia in the frame of the body.
        moments: about them [kg·m²].
        gravcomp: part of the weight that is carried from outside.
        joints: in the order in which they turn; none for the root.
        geoms: its shapes.
        sites: its named frames.
    """

    name: str
    parent: int
    place: Pose
    mass: float
    centre: Pose
    moments: Vector
    gravcomp: float = 0.0
    joints: tuple[CompiledJoint, ...] = ()
    geoms: tuple[CompiledGeom, ...] = ()
    sites: tuple[CompiledSite, ...] = ()


@dataclass(frozen=True)
class CompiledLoop:
    """Two sites that an equality holds together, so that a loop of bodies is closed.

    Attributes:
        kind: "connect", which holds their points together, or "weld", which holds their axes too.
        site1, site2: names of the sites.
    """

    kind: str
    site1: str
    site2: str


@dataclass(frozen=True)
class CompiledRobot:
    """One robot.

    Attributes:
        name: of the model.
        gravity: in the world of the file [m/s²].
        bodies: parents before children, depth first; the first is the root.
        meshes: that geoms show.
        keyframes: name and joint coordinates [rad or m] by joint name, balls left out.
        ties: of joints that follow others, each sound, as MuJoCo's `polycoef` has them: in how far
            both are from their `ref`.
        loops: of bodies that are closed.
        motors: names of the joints in these loops that actuators turn.
    """

    name: str
    gravity: Vector
    bodies: tuple[CompiledBody, ...]
    meshes: tuple[CompiledMesh, ...] = ()
    keyframes: tuple[tuple[str, tuple[tuple[str, float], ...]], ...] = ()
    ties: tuple[Tie, ...] = ()
    loops: tuple[CompiledLoop, ...] = ()
    motors: tuple[str, ...] = ()

    @property
    def joints(self) -> tuple[CompiledJoint, ...]:
        """All joints, in the order of the bodies."""
        return tuple(joint for body in self.bodies for joint in body.joints)

    @property
    def drawn_posture(self) -> dict[str, float]:
        """Joint coordinates of the posture that the file draws, where they are not 0."""
        return {joint.name: joint.ref for joint in self.joints if joint.ref}

    @property
    def followers(self) -> dict[str, Tie]:
        """Joints that follow others, in their coordinates."""
        ref, found = {joint.name: joint.ref for joint in self.joints}, dict[str, Tie]()
        for tie in self.ties:
            own, its = ref[tie.joint], ref[tie.master]
            if tie.bend:
                shifted = Polynomial(tie.coefficients)(Polynomial([-its, 1.0])) + own
                found[tie.joint] = Tie.of(tie.joint, tie.master, shifted.coef)
            else:
                offset = own + tie.offset - tie.multiplier * its
                found[tie.joint] = replace(tie, offset=offset)
        return found


def fault_of(robot: CompiledRobot) -> tuple[str, str, str]:
    """Return what cannot be in a robot: kind and name of the element, and words; empty if sound.

    MuJoCo lets numbers pass that are none or without end.
    """
    for body in robot.bodies:
        numbers = [*body.place.pos, *body.place.quat, body.mass, *body.moments, body.gravcomp]
        numbers += [*body.centre.pos, *body.centre.quat]
        if not np.isfinite(numbers).all():
            return "body", body.name, "not all of its numbers are finite; correct them"
        if max(map(abs, (*body.place.pos, *body.centre.pos))) >= _LARGEST_COORDINATE:
            return (
                "body",
                body.name,
                f"its place or centre of mass is {_LARGEST_COORDINATE:g} m away or more; "
                "correct it",
            )
        items: tuple[CompiledGeom | CompiledSite, ...] = (*body.geoms, *body.sites)
        if not all(_sound(item) for item in items):
            return "body", body.name, _WRONG_PLACE
        for joint in body.joints:
            fault = _joint_fault(joint)
            if fault:
                return "joint", joint.name, fault
    if not np.isfinite(robot.gravity).all():
        return "option", "", "its gravity is not finite; give three numbers [m/s²]"
    return "", "", ""


def _sound(item: CompiledGeom | CompiledSite) -> bool:
    """Whether all numbers of a shape or frame are numbers of a place and a size."""
    numbers = [*item.place.pos, *item.place.quat]
    if isinstance(item, CompiledGeom):
        numbers += [*item.rgba, *(() if item.mesh else item.size)]
    return bool((np.abs(numbers) < _LARGEST_COORDINATE).all())


def _joint_fault(joint: CompiledJoint) -> str:
    numbers = [*joint.pos, *joint.axis, joint.ref, joint.armature, joint.friction, joint.rest]
    numbers += [*joint.damping, *joint.stiffness]
    if not np.isfinite(numbers).all() or any(map(math.isnan, (joint.least, joint.most))):
        return "not all of its numbers are finite; correct them"
    if max(map(abs, joint.pos)) >= _LARGEST_COORDINATE:
        return f"its anchor is {_LARGEST_COORDINATE:g} m away or more; correct it"
    if not joint.lower < joint.upper or math.inf in (joint.lower, -joint.upper):
        unit = motion_words("rad", slides=joint.kind == "slide")
        return (
            f"the range is from {joint.lower:g} to {joint.upper:g} {unit}; lower must be below "
            "upper; correct it"
        )
    if min(joint.armature, joint.friction, *joint.damping[:1], *joint.stiffness[:1]) < 0.0:
        return "its armature, damping, frictionloss and stiffness may not be below 0; correct them"
    if joint.armature > ARMATURE:
        unit = motion_words("kg·m²", slides=joint.kind == "slide")
        return f"its armature is {joint.armature:g} {unit}; at most {ARMATURE:g} {unit}; correct it"
    return ""


def vector(numbers: Iterable[float]) -> Vector:
    """Return three numbers as plain floats."""
    x, y, z = (float(n) for n in numbers)
    return x, y, z


def quaternion(numbers: Iterable[float]) -> Quaternion:
    """Return four numbers, the scalar part first, as plain floats."""
    w, x, y, z = (float(n) for n in numbers)
    return w, x, y, z


def pose(pos: Iterable[float], quat: Iterable[float]) -> Pose:
    """Return the pose of three and four numbers."""
    return Pose(vector(pos), quaternion(quat))


def se3(pose: Pose) -> pin.SE3:
    """Return a pose as a placement."""
    w, x, y, z = pose.quat
    turn = pin.Quaternion(w, x, y, z)
    turn.normalize()
    return pin.SE3(turn.toRotationMatrix(), np.array(pose.pos))


def pose_of(placement: pin.SE3) -> Pose:
    """Return a placement as a pose."""
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    return Pose(vector(placement.translation), quaternion((w, x, y, z)))
