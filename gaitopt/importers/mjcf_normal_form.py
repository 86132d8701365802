"""A compiled robot as text, and back, exactly: what gait files keep of an MJCF file.

The text is an MJCF file itself, which MuJoCo reads, but one in which nothing is left to interpret:
no classes, no includes, every inertia, gear and unit worked out, every number with all its digits.
So the robot of a gait can be read without MuJoCo, without the files it was made from, and by later
versions of MuJoCo, whatever these make of old files. docs/decisions/mjcf.md says more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from operator import attrgetter
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from gaitopt.importers.mjcf_robot import (
    GEOM_KINDS,
    NO_TURN,
    CompiledBody,
    CompiledGeom,
    CompiledJoint,
    CompiledLoop,
    CompiledMesh,
    CompiledRobot,
    CompiledSite,
    Pose,
    fault_of,
    quaternion,
    vector,
)
from gaitopt.importers.ties import Tie, fault_of_tie, resolved

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
_COEFFICIENTS = (2, 5)
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
        ties = tuple(_read_tie(tie) for tie in root.findall("equality/joint"))
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
    robot = replace(robot, keyframes=frames, ties=ties, loops=loops, motors=motors)
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
        or not _sound(robot)
    ):
        raise NotNormalError("it was changed")


def _possible(body: CompiledBody) -> bool:
    """Whether a body can have the mass and the moments that it has, which may all be zero."""
    a, b, c = sorted(body.moments)
    return body.mass >= 0.0 and a >= 0.0 and c <= (a + b) * (1.0 + _ROUNDING)


def _sound(robot: CompiledRobot) -> bool:
    """Whether every tie is one that `mjcf_extract` lets pass."""
    hinges = [joint.name for joint in robot.joints if joint.kind == "hinge"]
    ties = {tie.joint: tie for tie in robot.ties}
    alone = len(ties) == len(robot.ties) and {*ties} <= {*hinges}
    return alone and not (any(fault_of_tie(t, hinges) for t in ties.values()) or resolved(ties)[1])


def _read_tie(element: Element) -> Tie:
    found = _read(element, _TIE)
    if not _COEFFICIENTS[0] <= len(found["coefficients"]) <= _COEFFICIENTS[1]:
        raise NotNormalError("polycoef")
    return Tie.of(**found)


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
