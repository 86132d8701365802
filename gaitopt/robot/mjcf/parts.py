"""MJCF, the format of MuJoCo: made whole, and put so that Pinocchio reads all of it.

Pinocchio reads MJCF, but passes in silence over what it does not know. So included files are
merged (in `include`), joints say themselves which limits they have (in `limits`), bodies with
several joints become chains, and meshes get absolute paths; what would still be lost or changed is
refused before (in `check`).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Collection, Iterator
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element, SubElement, tostring

from gaitopt.robot.files.meshes import MeshPaths, MeshProblem
from gaitopt.robot.mjcf.check import moves
from gaitopt.robot.mjcf.defaults import MAIN
from gaitopt.robot.mjcf.inertial import mass_from_geoms
from gaitopt.robot.mjcf.limits import with_limits
from gaitopt.robot.urdf.values import as_number

_FIRST = ("compiler", "default", "asset")
_MOTION = ("compiler", "default", "option", "worldbody")


def motion_mjcf(root: Element) -> str:
    """Return the MJCF of the one robot, ready for Pinocchio, without geometry it does not need."""
    root = with_limits(root)
    for body in root.iter("body"):
        if body.find("inertial") is not None and not mass_from_geoms(root):
            for geom in body.findall("geom"):
                body.remove(geom)
    for section in list(root):
        if section.tag not in _MOTION:
            root.remove(section)
    for inertial in root.iter("inertial"):
        if not {"diaginertia", "fullinertia"} & set(inertial.attrib):
            inertial.set("diaginertia", "0 0 0")  # of a point mass, for which Pinocchio takes 1 1 1
    for element in root.iter():
        element.attrib.pop("material", None)
    return _for_loader(root)


def geometry_mjcf(root: Element, paths: MeshPaths, bodies: Collection[str] | None) -> str:
    """Return the MJCF with usable geometry only, mesh paths made absolute.

    Args:
        root: a whole document.
        paths: where meshes are.
        bodies: whose geometry is wanted; None for all.
    """
    root = copy.deepcopy(root)
    usable = {}
    for mesh, file in list(_meshes(root)):
        if not paths.problem(file):
            usable[_mesh_name(mesh)] = str(paths.find(file))
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            wanted = bodies is None or body.get("name") in bodies
            if not wanted or geom.get("mesh", "") not in {"", *usable}:
                body.remove(geom)
    for asset in root.findall("asset"):
        for element in list(asset):
            name = _mesh_name(element)
            if element.tag == "mesh" and name in usable:
                element.attrib.update(name=name, file=usable[name])
            elif element.tag == "material":
                element.attrib.pop("texture", None)
            else:
                asset.remove(element)
    for compiler in root.findall("compiler"):
        for name in ("meshdir", "assetdir"):
            compiler.attrib.pop(name, None)
    return _for_loader(root)


def mjcf_mesh_problems(root: Element, paths: MeshPaths) -> list[MeshProblem]:
    """Return the meshes that cannot be used, once for every geometry that shows one."""
    files = {_mesh_name(mesh): (mesh.get("file", ""), file) for mesh, file in _meshes(root)}
    problems = []
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            written, file = files.get(geom.get("mesh", ""), ("", ""))
            reason = paths.problem(file) if file else ""
            if reason:
                # Visual or collision is a matter of classes and masks in this format.
                problems.append(MeshProblem(body.get("name", ""), "geometry", written, reason))
    return problems


def _meshes(root: Element) -> Iterator[tuple[Element, str]]:
    """Yield the mesh assets with their paths from the directory of the file."""
    directory = PurePosixPath()
    for compiler in root.findall("compiler"):
        directory = PurePosixPath(compiler.get("meshdir", compiler.get("assetdir", ".")))
    for mesh in root.findall("asset/mesh"):
        if "file" in mesh.attrib:
            yield mesh, str(directory / mesh.attrib["file"])


def _mesh_name(mesh: Element) -> str:
    return mesh.get("name") or PurePosixPath(mesh.get("file", "")).stem


def _for_loader(root: Element) -> str:
    """Write a document in which nothing but the robot hangs on the world, joint by joint.

    Pinocchio reads from the top: what it must know of all bodies goes before them. Of keyframes
    nothing is wanted.
    """
    for keyframe in root.findall("keyframe"):
        root.remove(keyframe)
    _name_main(root)
    root[:] = sorted(root, key=lambda s: _FIRST.index(s.tag) if s.tag in _FIRST else len(_FIRST))
    for world in root.findall("worldbody"):
        for element in list(world):
            if element.tag != "body" or not moves(element):
                world.remove(element)
    for number, body in enumerate(list(root.iter("body"))):
        body.set("name", body.get("name") or f"body_{number}")
    for body in list(root.iter("body")):
        _one_joint_per_body(body)
    for joint in root.iter("joint"):
        _zero_where_drawn(joint)
    for element in root.iter():
        _unit_axis(element)
    return tostring(root, encoding="unicode")


def _name_main(root: Element) -> None:
    """Give the outermost class the name by which bodies may call it."""
    if root.find("default") is None:
        root.append(Element("default"))
    for default in root.findall("default"):
        default.set("class", default.get("class", MAIN))


def _one_joint_per_body(body: Element) -> None:
    """Make a chain of a body with several joints: MuJoCo turns them one after the other."""
    joints = body.findall("joint")
    if len(joints) < 2:
        return
    contents = [element for element in body if element not in joints[:1]]
    for element in contents:
        body.remove(element)
    name = body.attrib["name"]
    body.set("name", f"{name}_1")
    inside = body
    for number, joint in enumerate(joints[1:], start=2):
        contents.remove(joint)
        last = number == len(joints)
        inside = SubElement(inside, "body", name=name if last else f"{name}_{number}")
        inside.append(joint)
    inside.extend(contents)


def _zero_where_drawn(joint: Element) -> None:
    """Count a joint's angle from the posture of the file, which `ref` calls by another number."""
    shift = as_number(joint.attrib.pop("ref", "0"))
    if shift and "range" in joint.attrib:
        ends = (as_number(word) - shift for word in joint.attrib["range"].split())
        joint.set("range", " ".join(repr(end) for end in ends))


def _unit_axis(element: Element) -> None:
    """Give the axis of an `axisangle` the length that Pinocchio takes for granted."""
    if "axisangle" in element.attrib:
        x, y, z, angle = (as_number(word) for word in element.attrib["axisangle"].split())
        size = math.hypot(x, y, z)
        element.set("axisangle", f"{x / size!r} {y / size!r} {z / size!r} {angle!r}")
