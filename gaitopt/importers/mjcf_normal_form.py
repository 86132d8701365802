"""A compiled robot as text, and back, exactly: what gait files keep of an MJCF file.

The text is an MJCF file itself, which MuJoCo reads, but one in which nothing is left to interpret:
no classes, no includes, every inertia, gear and unit worked out, every number with all its digits.
So the robot of a gait can be read without MuJoCo, without the files it was made from, and by later
versions of MuJoCo, whatever these make of old files. docs/decisions/mjcf.md says more.

An MJCF file, or the normal form of one, as a compiled robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from gaitopt.importers.meshes import MeshPaths
from gaitopt.importers.mjcf_compile import compile_mjcf, whole_mjcf
from gaitopt.importers.mjcf_extract import extract
from gaitopt.importers.mjcf_robot import (
    KINDS,
    NO_TURN,
    CompiledBody,
    CompiledGeom,
    CompiledJoint,
    CompiledMesh,
    CompiledRobot,
    CompiledSite,
    Pose,
    fault_of,
    quaternion,
    vector,
)
from gaitopt.importers.report import Finding
from gaitopt.importers.xml_document import UrdfProblem, XmlTree

MARK, VERSION = "gaitopt_normal_form", "1"
"""Name and value of the <text> in <custom> that says that a document is in normal form."""

_ROUNDING = 1e-6
_FREE_JOINT = "root"
_SHOWN, _HIDDEN = "2", "3"  # groups of geoms that MuJoCo shows and does not show
_POSE = {"pos", "quat"}
_KNOWN: Mapping[str, set[str]] = {
    "mujoco": {"model"},
    "custom": set(),
    "text": {"name", "data"},
    "compiler": {"angle", "autolimits", "inertiafromgeom"},
    "option": {"gravity"},
    "asset": set(),
    "mesh": {"name", "file", "scale", "refpos", "refquat", "vertex", "face"},
    "worldbody": set(),
    "body": {"name", "gravcomp", *_POSE},
    "freejoint": {"name"},
    "inertial": {"mass", "diaginertia", *_POSE},
    "joint": {
        "name", "type", "pos", "axis", "ref", "limited", "range", "armature", "damping",
        "frictionloss", "stiffness", "springref", "actuatorfrclimited", "actuatorfrcrange",
    },
    "geom": {
        "name", "type", "size", "mesh", "rgba", "contype", "conaffinity", "group", *_POSE,
    },
    "site": {"name", *_POSE},
    "keyframe": set(),
    "key": {"name", "qpos"},
}  # fmt: skip


class NotNormalError(ValueError):
    """A document is not in normal form."""


def normal_text(robot: CompiledRobot) -> str:
    """Write a robot in normal form."""
    root = Element("mujoco", model=robot.name)
    SubElement(SubElement(root, "custom"), "text", name=MARK, data=VERSION)
    SubElement(root, "compiler", angle="radian", autolimits="false", inertiafromgeom="false")
    SubElement(root, "option", gravity=_words(robot.gravity))
    if robot.meshes:
        asset = SubElement(root, "asset")
        for mesh in robot.meshes:
            _write_mesh(asset, mesh)
    written: list[Element] = []
    world = SubElement(root, "worldbody")
    for body in robot.bodies:
        parent = world if body.parent < 0 else written[body.parent]
        written.append(_write_body(parent, body))
    if robot.keyframes:
        keyframe = SubElement(root, "keyframe")
        for name, angles in robot.keyframes:
            SubElement(keyframe, "key", name=name, qpos=_words(_qpos(robot, dict(angles))))
    indent(root, " ")
    return tostring(root, encoding="unicode")


def is_normal(root: Element) -> bool:
    """Return whether a document says that it is in normal form."""
    return any(
        text.get("name") == MARK and text.get("data") == VERSION
        for text in root.findall("custom/text")
    )


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
        robot = CompiledRobot(
            name=root.get("model", ""),
            gravity=vector(_numbers(_only(root, "option"), "gravity")),
            bodies=tuple(bodies),
            meshes=tuple(_read_mesh(mesh) for mesh in root.findall("asset/mesh")),
        )
        keys = root.findall("keyframe/key")
        frames = tuple((key.attrib["name"], _angles(robot, key)) for key in keys)
    except (KeyError, ValueError, TypeError) as error:
        raise NotNormalError(str(error)) from None
    _check_whole(robot)
    return replace(robot, keyframes=frames)


def _check_whole(robot: CompiledRobot) -> None:
    """Refuse what a change by hand may have left: then MuJoCo shall say what is wrong."""
    joints = [joint.name for joint in robot.joints]
    bodies = [body.name for body in robot.bodies]
    meshes = {"", *(mesh.name for mesh in robot.meshes)}
    turns = [p.quat for b in robot.bodies for p in (b.place, b.centre, *(g.place for g in b.geoms))]
    axes = [joint.axis for joint in robot.joints]
    lengths = [math.hypot(*direction) for direction in (*turns, *axes)]
    if (
        any(fault_of(robot))
        or len(joints) > len(set(joints))
        or len(bodies) > len(set(bodies))
        or any(
            geom.mesh not in meshes or geom.kind not in KINDS
            for b in robot.bodies
            for geom in b.geoms
        )
        or any(abs(length - 1.0) > _ROUNDING for length in lengths)
        or any(not _possible(body) for body in robot.bodies)
    ):
        raise NotNormalError("it was changed")


def _possible(body: CompiledBody) -> bool:
    """Whether a body can have the mass and the moments that it has, which may all be zero."""
    a, b, c = sorted(body.moments)
    return body.mass >= 0.0 and a >= 0.0 and c <= (a + b) * (1.0 + _ROUNDING)


def _write_mesh(asset: Element, mesh: CompiledMesh) -> None:
    element = SubElement(asset, "mesh", name=mesh.name)
    if mesh.file:
        element.set("file", mesh.file)
        element.set("scale", _words(mesh.scale))
        element.set("refpos", _words(mesh.ref.pos))
        element.set("refquat", _words(mesh.ref.quat))
    else:
        element.set("vertex", _words(mesh.vertices))
        element.set("face", " ".join(map(str, mesh.triangles)))


def _read_mesh(element: Element) -> CompiledMesh:
    name = element.attrib["name"]
    if "file" not in element.attrib:
        faces = tuple(int(word) for word in element.attrib["face"].split())
        return CompiledMesh(name, "", vertices=_numbers(element, "vertex"), triangles=faces)
    ref = Pose(vector(_numbers(element, "refpos")), quaternion(_numbers(element, "refquat")))
    scale = vector(_numbers(element, "scale"))
    return CompiledMesh(name, element.attrib["file"], scale, ref)


def _write_body(parent: Element, body: CompiledBody) -> Element:
    element = SubElement(parent, "body", name=body.name)
    _write_pose(element, body.place)
    element.set("gravcomp", repr(body.gravcomp))
    if body.parent < 0:
        SubElement(element, "freejoint", name=_FREE_JOINT)
    inertial = SubElement(element, "inertial", mass=repr(body.mass))
    _write_pose(inertial, body.centre)
    inertial.set("diaginertia", _words(body.moments))
    for joint in body.joints:
        _write_joint(element, joint)
    for geom in body.geoms:
        _write_geom(element, geom)
    for site in body.sites:
        _write_pose(SubElement(element, "site", name=site.name), site.place)
    return element


def _read_body(element: Element, parent: int, bodies: list[CompiledBody]) -> None:
    inertial = _only(element, "inertial")
    if (element.find("freejoint") is not None) != (parent < 0):
        raise NotNormalError("freejoint")
    index = len(bodies)
    bodies.append(
        CompiledBody(
            name=element.attrib["name"],
            parent=parent,
            place=_read_pose(element),
            mass=_number(inertial, "mass"),
            centre=_read_pose(inertial),
            moments=vector(_numbers(inertial, "diaginertia")),
            gravcomp=_number(element, "gravcomp"),
            joints=tuple(_read_joint(joint) for joint in element.findall("joint")),
            geoms=tuple(_read_geom(geom) for geom in element.findall("geom")),
            sites=tuple(
                CompiledSite(site.attrib["name"], _read_pose(site))
                for site in element.findall("site")
            ),
        )
    )
    for below in element.findall("body"):
        _read_body(below, index, bodies)


def _write_joint(body: Element, joint: CompiledJoint) -> None:
    element = SubElement(body, "joint", name=joint.name, type=joint.kind, pos=_words(joint.pos))
    element.set("armature", repr(joint.armature))
    if joint.kind == "ball":
        return
    element.set("axis", _words(joint.axis))
    element.set("ref", repr(joint.ref))
    _write_range(element, "limited", "range", (joint.lower, joint.upper))
    _write_range(element, "actuatorfrclimited", "actuatorfrcrange", (joint.least, joint.most))
    element.set("frictionloss", repr(joint.friction))
    if joint.damping:
        element.set("damping", _words(joint.damping))
    if joint.stiffness:
        element.set("stiffness", _words(joint.stiffness))
        element.set("springref", repr(joint.rest))


def _read_joint(element: Element) -> CompiledJoint:
    name, kind = element.attrib["name"], element.attrib["type"]
    pos, armature = vector(_numbers(element, "pos")), _number(element, "armature")
    if kind == "ball":
        return CompiledJoint(name, kind, pos, armature=armature)
    if kind not in ("hinge", "slide"):
        raise NotNormalError(kind)
    lower, upper = _read_range(element, "limited", "range")
    least, most = _read_range(element, "actuatorfrclimited", "actuatorfrcrange")
    return CompiledJoint(
        name=name,
        kind=kind,
        pos=pos,
        axis=vector(_numbers(element, "axis")),
        ref=_number(element, "ref"),
        lower=lower,
        upper=upper,
        armature=armature,
        damping=_numbers(element, "damping") if "damping" in element.attrib else (),
        friction=_number(element, "frictionloss"),
        stiffness=_numbers(element, "stiffness") if "stiffness" in element.attrib else (),
        rest=_number(element, "springref") if "springref" in element.attrib else 0.0,
        least=least,
        most=most,
    )


def _write_range(element: Element, flag: str, name: str, ends: tuple[float, float]) -> None:
    limited = not all(map(math.isinf, ends))
    element.set(flag, "true" if limited else "false")
    if limited:
        element.set(name, _words(ends))


def _read_range(element: Element, flag: str, name: str) -> tuple[float, float]:
    if element.attrib[flag] == "false":
        return -math.inf, math.inf
    lower, upper = (float(word) for word in element.attrib[name].split())
    if math.isnan(lower + upper):
        raise NotNormalError(name)
    return lower, upper


def _write_geom(body: Element, geom: CompiledGeom) -> None:
    element = SubElement(body, "geom", type=geom.kind)
    if geom.name:
        element.set("name", geom.name)
    if geom.mesh:
        element.set("mesh", geom.mesh)
    else:
        element.set("size", _words(geom.size))
    _write_pose(element, geom.place)
    element.set("rgba", _words(geom.rgba))
    mask = "1" if geom.touches else "0"
    element.attrib.update(contype=mask, conaffinity=mask, group=_SHOWN if geom.drawn else _HIDDEN)


def _read_geom(element: Element) -> CompiledGeom:
    r, g, b, a = _numbers(element, "rgba")
    mesh = element.get("mesh", "")
    return CompiledGeom(
        name=element.get("name", ""),
        kind=element.attrib["type"],
        size=(0.0, 0.0, 0.0) if mesh else vector(_numbers(element, "size")),
        place=_read_pose(element),
        mesh=mesh,
        rgba=(r, g, b, a),
        touches=element.attrib["contype"] == "1",
        drawn=element.attrib["group"] == _SHOWN,
    )


def _write_pose(element: Element, pose: Pose) -> None:
    element.set("pos", _words(pose.pos))
    element.set("quat", _words(pose.quat))


def _read_pose(element: Element) -> Pose:
    return Pose(vector(_numbers(element, "pos")), quaternion(_numbers(element, "quat")))


def _qpos(robot: CompiledRobot, angles: Mapping[str, float]) -> list[float]:
    """Return all coordinates of a posture, as MuJoCo orders them."""
    root = robot.bodies[0].place
    qpos = [*root.pos, *root.quat]
    for joint in robot.joints:
        qpos += NO_TURN if joint.kind == "ball" else (angles[joint.name],)
    return qpos


def _angles(robot: CompiledRobot, key: Element) -> tuple[tuple[str, float], ...]:
    numbers, angles, at = _numbers(key, "qpos"), [], 7
    for joint in robot.joints:
        if joint.kind == "ball":
            at += 4
            continue
        angles.append((joint.name, numbers[at]))
        at += 1
    if at != len(numbers):
        raise NotNormalError("qpos")
    return tuple(angles)


def _only(root: Element, tag: str) -> Element:
    (element,) = root.findall(tag)
    return element


def _words(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(n)) for n in numbers)


def _numbers(element: Element, name: str) -> tuple[float, ...]:
    values = tuple(float(word) for word in element.attrib[name].split())
    if not all(map(math.isfinite, values)):
        raise NotNormalError(name)
    return values


def _number(element: Element, name: str) -> float:
    (value,) = _numbers(element, name)
    return value


@dataclass(frozen=True, eq=False)
class Mjcf:
    """What was read.

    Attributes:
        text: the robot in normal form.
        robot: in numbers.
        tree: of the document, included files merged.
        problems: what is suspicious, but did not stop reading.
        findings: what a person should know about how it was read.
    """

    text: str
    robot: CompiledRobot
    tree: XmlTree
    problems: tuple[UrdfProblem, ...] = ()
    findings: tuple[Finding, ...] = ()


def read_mjcf(text: str, path: Path | None, tree: XmlTree, paths: MeshPaths) -> Mjcf:
    """Read an MJCF document: MuJoCo says what it means, unless it is in normal form already.

    Args:
        text: of the file.
        path: of the file, None for text alone, which may include nothing.
        tree: of the text.
        paths: where meshes are.

    Raises:
        RobotError: MuJoCo refuses the document, a mass depends on a mesh that is missing, or what
            it describes is no robot.
        MissingExtraError: MuJoCo is not installed.
    """
    if is_normal(tree.root):
        try:
            return Mjcf(text, read_normal(tree.root), tree)
        except NotNormalError:
            pass  # changed by hand; it is still MJCF
    whole = whole_mjcf(tree, None if path is None else path.parent)
    found = extract(compile_mjcf(text, path, whole, paths), whole)
    return Mjcf(normal_text(found.robot), found.robot, whole, found.problems, found.findings)
