"""A robot as MuJoCo compiles it from an MJCF file: plain numbers, nothing left to interpret.

And as text, exactly: the normal form, which gait files keep. It is an MJCF file itself, which
MuJoCo reads, but without classes and includes, every inertia, gear and unit worked out, every
number with all its digits. So the robot of a gait can be read without MuJoCo, without the files it
was made from, and by later versions of MuJoCo, whatever these make of old files.
docs/decisions/mjcf.md says more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from operator import attrgetter
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial

from gaitopt.bounds import ARMATURE, SIZE
from gaitopt.dataclass import dataclass
from gaitopt.importers.physics import Tie, fault_of_tie, ties_to_masters
from gaitopt.units import motion_words

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""Scalar part first, as in MuJoCo; of unit length."""

NO_TURN: Quaternion = (1.0, 0.0, 0.0, 0.0)
GEOM_KINDS = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
"""Of shapes."""
ORIGIN: Vector = (0.0, 0.0, 0.0)

NOT_FINITE = "not all of its numbers are finite; correct them"


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
            return "body", body.name, NOT_FINITE
        shapes = [[*geom.rgba, *(() if geom.mesh else geom.size)] for geom in body.geoms]
        places = (*(geom.place for geom in body.geoms), *(site.place for site in body.sites))
        shapes += [[*place.pos, *place.quat] for place in places]
        if not all(np.isfinite(numbers).all() for numbers in shapes):
            what = "the place or size of one of its geoms or sites is not finite; correct it"
            return "body", body.name, what
        for joint in body.joints:
            fault = _joint_fault(joint)
            if fault:
                return "joint", joint.name, fault
    if not np.isfinite(robot.gravity).all():
        return "option", "", "its gravity is not finite; give three numbers [m/s²]"
    return "", "", ""


def _joint_fault(joint: CompiledJoint) -> str:
    numbers = [*joint.pos, *joint.axis, joint.ref, joint.armature, joint.friction, joint.rest]
    numbers += [*joint.damping, *joint.stiffness]
    if not np.isfinite(numbers).all() or any(map(math.isnan, (joint.least, joint.most))):
        return NOT_FINITE
    if not joint.lower < joint.upper or math.inf in (joint.lower, -joint.upper):
        unit = motion_words("rad", slides=joint.kind == "slide")
        return (
            f"the range is from {joint.lower:g} to {joint.upper:g} {unit}; lower must be below "
            "upper; correct it"
        )
    if min(joint.armature, joint.friction, *joint.damping[:1], *joint.stiffness[:1]) < 0.0:
        return "its armature, damping, frictionloss and stiffness may not be below 0; correct them"
    given = {
        "damping": joint.damping, "frictionloss": (joint.friction,), "stiffness": joint.stiffness,
        "springref": (joint.rest,), "ref": (joint.ref,),
    }  # fmt: skip
    for name, values in given.items():
        if (largest := max(map(abs, values), default=0.0)) >= SIZE:
            return f"its {name} is {largest:g}; it must be below {SIZE:g}; correct it"
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


MARK, VERSION = "gaitopt_normal_form", "1"
"""Name and value of the <text> in <custom> that says that a document is in normal form."""

_ROUNDING = 1e-6  # of lengths of directions, and of moments of inertia
_SHOWN, _HIDDEN = "2", "3"  # groups of geoms that MuJoCo shows and does not show


class NotNormalError(ValueError):
    """A document is not in normal form."""


class _Attribute(NamedTuple):
    """How a field of a compiled record, or of a `Pose` in it, is written as an attribute."""

    name: str
    field: str
    write: Callable[[Any], str]
    read: Callable[[str], Any]
    optional: bool = False  # left out where it is empty or 0


def _words(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(n)) for n in numbers)


def _numbers(text: str) -> tuple[float, ...]:
    values = tuple(float(word) for word in text.split())
    if not all(map(math.isfinite, values)):
        raise NotNormalError(text)
    return values


def _number(text: str) -> float:
    (value,) = _numbers(text)
    return value


def _pose(name: str, pos: str = "pos", quat: str = "quat") -> tuple[_Attribute, _Attribute]:
    return (
        _Attribute(pos, f"{name}.pos", _words, lambda text: vector(_numbers(text))),
        _Attribute(quat, f"{name}.quat", _words, lambda text: quaternion(_numbers(text))),
    )


def _vector(name: str, field: str) -> _Attribute:
    return _Attribute(name, field, _words, lambda text: vector(_numbers(text)))


_NAME = _Attribute("name", "name", str, str)
_BODY = (_NAME, *_pose("place"), _Attribute("gravcomp", "gravcomp", repr, _number))
_INERTIAL = (
    _Attribute("mass", "mass", repr, _number),
    *_pose("centre"),
    _vector("diaginertia", "moments"),
)
_BALL = (
    _NAME,
    _Attribute("type", "kind", str, str),
    _vector("pos", "pos"),
    _Attribute("armature", "armature", repr, _number),
    _Attribute("frictionloss", "friction", repr, _number, True),
    _Attribute("damping", "damping", _words, _numbers, True),
    _Attribute("stiffness", "stiffness", _words, _numbers, True),
)
_JOINT = (
    *_BALL,
    _vector("axis", "axis"),
    _Attribute("ref", "ref", repr, _number),
    _Attribute("springref", "rest", repr, _number, True),
)
_RANGES = (
    ("limited", "range", "lower", "upper"),
    ("actuatorfrclimited", "actuatorfrcrange", "least", "most"),
)
_GEOM = (
    _Attribute("type", "kind", str, str),
    _Attribute("name", "name", str, str, True),
    _Attribute("mesh", "mesh", str, str, True),
    *_pose("place"),
    _Attribute("rgba", "rgba", _words, _numbers),
)
_SIZE = (_vector("size", "size"),)
_SITE = (_NAME, *_pose("place"))
_TIE = (
    _Attribute("joint1", "joint", str, str),
    _Attribute("joint2", "master", str, str),
    _Attribute("polycoef", "coefficients", _words, _numbers),
)
_LOOP = (_Attribute("site1", "site1", str, str), _Attribute("site2", "site2", str, str))
_LOOPS = ("connect", "weld")
_LEAST_TIE, _MOST_TIE = 2, 5  # coefficients
_MESH_FILE = (
    _NAME,
    _Attribute("file", "file", str, str),
    _vector("scale", "scale"),
    *_pose("ref", "refpos", "refquat"),
)
_MESH = (
    _NAME,
    _Attribute("vertex", "vertices", _words, _numbers),
    _Attribute("face", "triangles", lambda faces: " ".join(map(str, faces)),
               lambda text: tuple(map(int, text.split()))),
)  # fmt: skip


def _known(*attributes: _Attribute) -> set[str]:
    return {attribute.name for attribute in attributes}


_KNOWN: Mapping[str, set[str]] = {
    "mujoco": {"model"},
    "custom": set(),
    "text": {"name", "data"},
    "compiler": {"angle", "autolimits", "inertiafromgeom"},
    "option": {"gravity"},
    "asset": set(),
    "mesh": _known(*_MESH_FILE, *_MESH),
    "worldbody": set(),
    "body": _known(*_BODY),
    "freejoint": {"name"},
    "inertial": _known(*_INERTIAL),
    "joint": _known(*_JOINT, *_TIE) | {name for flag, ends, *_ in _RANGES for name in (flag, ends)},
    "geom": _known(*_GEOM, *_SIZE) | {"contype", "conaffinity", "group"},
    "site": _known(*_SITE),
    "equality": set(),
    **{tag: _known(*_LOOP) for tag in _LOOPS},
    "actuator": set(),
    "motor": {"joint"},
    "keyframe": set(),
    "key": {"name", "qpos"},
}


def _write(parent: Element, tag: str, record: Any, attributes: Iterable[_Attribute]) -> Element:
    """Append an element with the fields of a record."""
    element = SubElement(parent, tag)
    for attribute in attributes:
        value = attrgetter(attribute.field)(record)
        if value or not attribute.optional:
            element.set(attribute.name, attribute.write(value))
    return element


def _read(element: Element, attributes: Iterable[_Attribute]) -> dict[str, Any]:
    """Return the fields of a record."""
    found: dict[str, Any] = {}
    for attribute in attributes:
        if attribute.optional and attribute.name not in element.attrib:
            continue
        value = attribute.read(element.attrib[attribute.name])
        field, _, part = attribute.field.partition(".")
        found[field] = replace(found.get(field, Pose()), **{part: value}) if part else value
    return found


def normal_text(robot: CompiledRobot) -> str:
    """Write a robot in normal form."""
    root = Element("mujoco", model=robot.name)
    SubElement(SubElement(root, "custom"), "text", name=MARK, data=VERSION)
    SubElement(root, "compiler", angle="radian", autolimits="false", inertiafromgeom="false")
    SubElement(root, "option", gravity=_words(robot.gravity))
    if robot.meshes:
        asset = SubElement(root, "asset")
        for mesh in robot.meshes:
            _write(asset, "mesh", mesh, _MESH_FILE if mesh.file else _MESH)
    written: list[Element] = []
    world = SubElement(root, "worldbody")
    for body in robot.bodies:
        parent = world if body.parent < 0 else written[body.parent]
        written.append(_write_body(parent, body))
    if robot.ties or robot.loops:
        equality = SubElement(root, "equality")
        for tie in robot.ties:
            _write(equality, "joint", tie, _TIE)
        for loop in robot.loops:
            _write(equality, loop.kind, loop, _LOOP)
    if robot.motors:  # without gear or range: those of the joint are complete
        actuator = SubElement(root, "actuator")
        for name in robot.motors:
            SubElement(actuator, "motor", joint=name)
    if robot.keyframes:
        keyframe = SubElement(root, "keyframe")
        for name, angles in robot.keyframes:
            SubElement(keyframe, "key", name=name, qpos=_words(_qpos(robot, dict(angles))))
    indent(root, " ")
    return tostring(root, encoding="unicode")


def is_normal(root: Element) -> bool:
    """Return whether a document says that it is in normal form."""
    marks = ((text.get("name"), text.get("data")) for text in root.findall("custom/text"))
    return (MARK, VERSION) in marks


def read_normal(root: Element) -> CompiledRobot:
    """Return the robot of a document in normal form.

    Raises:
        NotNormalError: it is not, though it may be MJCF.
    """
    try:
        for element in root.iter():
            if not set(element.attrib) <= _KNOWN[element.tag]:
                raise NotNormalError(element.tag)
        bodies: list[CompiledBody] = []
        (top,) = _only(root, "worldbody").findall("body")
        _read_body(top, -1, bodies)
        meshes = root.findall("asset/mesh")
        robot = CompiledRobot(
            name=root.get("model", ""),
            gravity=vector(_numbers(_only(root, "option").attrib["gravity"])),
            bodies=tuple(bodies),
            meshes=tuple(
                CompiledMesh(
                    **{"file": "", **_read(m, _MESH_FILE if "file" in m.attrib else _MESH)}
                )
                for m in meshes
            ),
        )
        ties = [_read(tie, _TIE) for tie in root.findall("equality/joint")]
        if not all(_LEAST_TIE <= len(tie["coefficients"]) <= _MOST_TIE for tie in ties):
            raise NotNormalError("polycoef")
        loops = tuple(
            CompiledLoop(element.tag, **_read(element, _LOOP))
            for element in root.findall("equality/*")
            if element.tag in _LOOPS
        )
        motors = tuple(motor.attrib["joint"] for motor in root.findall("actuator/motor"))
        keys = root.findall("keyframe/key")
        frames = tuple((key.attrib["name"], _angles(robot, key)) for key in keys)
    except (KeyError, ValueError, TypeError) as error:
        raise NotNormalError(str(error)) from None
    follow = tuple(Tie.of(**tie) for tie in ties)
    robot = replace(robot, keyframes=frames, ties=follow, loops=loops, motors=motors)
    _check_whole(robot)
    return robot


def _check_whole(robot: CompiledRobot) -> None:
    """Refuse what a change by hand may have left: then MuJoCo shall say what is wrong."""
    geoms = [geom for body in robot.bodies for geom in body.geoms]
    named = ([joint.name for joint in robot.joints], [body.name for body in robot.bodies])
    meshes = {"", *(mesh.name for mesh in robot.meshes)}
    sites = [site.name for body in robot.bodies for site in body.sites]
    ends = {site for loop in robot.loops for site in (loop.site1, loop.site2)}
    turns = [p.quat for b in robot.bodies for p in (b.place, b.centre, *(g.place for g in b.geoms))]
    lengths = [math.hypot(*n) for n in (*turns, *(joint.axis for joint in robot.joints))]
    if (
        any(fault_of(robot))
        or any(len(names) > len(set(names)) for names in named)
        or not {*robot.motors} <= {*named[0]}
        or any(sites.count(name) != 1 for name in ends)
        or any(geom.mesh not in meshes or geom.kind not in GEOM_KINDS for geom in geoms)
        or any(abs(length - 1.0) > _ROUNDING for length in lengths)
        or any(not _possible(body) for body in robot.bodies)
        or not _ties_hold(robot)
    ):
        raise NotNormalError("it was changed")


def _possible(body: CompiledBody) -> bool:
    """Whether a body can have the mass and the moments that it has, which may all be zero."""
    a, b, c = sorted(body.moments)
    return body.mass >= 0.0 and a >= 0.0 and c <= (a + b) * (1.0 + _ROUNDING)


def _ties_hold(robot: CompiledRobot) -> bool:
    """Whether every tie is one that `mjcf_extract` lets pass."""
    hinges = [joint.name for joint in robot.joints if joint.kind == "hinge"]
    ties = {tie.joint: tie for tie in robot.ties}
    alone = len(ties) == len(robot.ties) and {*ties} <= {*hinges}
    return alone and not (
        any(fault_of_tie(t, hinges) for t in ties.values()) or ties_to_masters(ties)[1]
    )


def _write_body(parent: Element, body: CompiledBody) -> Element:
    element = _write(parent, "body", body, _BODY)
    if body.parent < 0:
        SubElement(element, "freejoint", name="root")
    _write(element, "inertial", body, _INERTIAL)
    for joint in body.joints:
        written = _write(element, "joint", joint, _BALL if joint.kind == "ball" else _JOINT)
        for flag, name, *ends in _RANGES if joint.kind != "ball" else ():
            values = [getattr(joint, end) for end in ends]
            limited = not all(map(math.isinf, values))
            written.set(flag, "true" if limited else "false")
            if limited:
                written.set(name, _words(values))
    for geom in body.geoms:
        written = _write(element, "geom", geom, _GEOM if geom.mesh else (*_GEOM, *_SIZE))
        mask, group = "1" if geom.touches else "0", _SHOWN if geom.drawn else _HIDDEN
        written.attrib.update(contype=mask, conaffinity=mask, group=group)
    for site in body.sites:
        _write(element, "site", site, _SITE)
    return element


def _read_body(element: Element, parent: int, bodies: list[CompiledBody]) -> None:
    if (element.find("freejoint") is not None) != (parent < 0):
        raise NotNormalError("freejoint")
    index = len(bodies)
    bodies.append(
        CompiledBody(
            parent=parent,
            **_read(element, _BODY),
            **_read(_only(element, "inertial"), _INERTIAL),
            joints=tuple(_read_joint(joint) for joint in element.findall("joint")),
            geoms=tuple(_read_geom(geom) for geom in element.findall("geom")),
            sites=tuple(CompiledSite(**_read(site, _SITE)) for site in element.findall("site")),
        )
    )
    for below in element.findall("body"):
        _read_body(below, index, bodies)


def _read_joint(element: Element) -> CompiledJoint:
    kind = element.attrib["type"]
    if kind == "ball":
        return CompiledJoint(**_read(element, _BALL))
    if kind not in ("hinge", "slide"):
        raise NotNormalError(kind)
    ranges: dict[str, Any] = {}
    for flag, name, *ends in _RANGES:
        if element.attrib[flag] != "false":
            lower, upper = (float(word) for word in element.attrib[name].split())
            if math.isnan(lower + upper):
                raise NotNormalError(name)
            ranges |= dict(zip(ends, (lower, upper), strict=True))
    return CompiledJoint(**_read(element, _JOINT), **ranges)


def _read_geom(element: Element) -> CompiledGeom:
    found = _read(element, _GEOM if "mesh" in element.attrib else (*_GEOM, *_SIZE))
    if len(found["rgba"]) != 4:
        raise NotNormalError("rgba")
    touches, drawn = element.attrib["contype"] == "1", element.attrib["group"] == _SHOWN
    defaults = {"name": "", "mesh": "", "size": (0.0, 0.0, 0.0)}
    return CompiledGeom(**{**defaults, **found}, touches=touches, drawn=drawn)


def _qpos(robot: CompiledRobot, angles: Mapping[str, float]) -> list[float]:
    """Return all coordinates of a posture, as MuJoCo orders them."""
    root = robot.bodies[0].place
    qpos = [*root.pos, *root.quat]
    for joint in robot.joints:
        qpos += NO_TURN if joint.kind == "ball" else (angles[joint.name],)
    return qpos


def _angles(robot: CompiledRobot, key: Element) -> tuple[tuple[str, float], ...]:
    numbers, angles, at = _numbers(key.attrib["qpos"]), [], 7
    for joint in robot.joints:
        if joint.kind != "ball":
            angles.append((joint.name, numbers[at]))
        at += 4 if joint.kind == "ball" else 1
    if at != len(numbers):
        raise NotNormalError("qpos")
    return tuple(angles)


def _only(root: Element, tag: str) -> Element:
    (element,) = root.findall(tag)
    return element
