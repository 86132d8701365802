"""MJCF, the format of MuJoCo: made whole, and put so that Pinocchio reads all of it.

Pinocchio reads MJCF, but passes in silence over what it does not know. So included files are
merged (in `mjcf_include`), actuators hand their torque limits to the joints, bodies with several
joints become chains, meshes get absolute paths, and what would still be lost or changed is refused.
"""

from __future__ import annotations

import copy
from collections.abc import Collection, Iterator
from pathlib import PurePosixPath
from xml.etree.ElementTree import Element, SubElement, tostring

from gaitopt.errors import RobotError
from gaitopt.robot.files.meshes import MeshPaths, MeshProblem
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.mjcf.defaults import check_classes, with_torques
from gaitopt.robot.urdf.values import Entry, as_number

_UNREAD = ("attach", "composite", "flexcomp", "frame", "replicate")
_MOTION = ("compiler", "default", "keyframe", "option", "worldbody")


def check_mjcf(tree: XmlTree) -> None:
    """Refuse what Pinocchio would leave out or change in silence.

    Raises:
        RobotError: naming the line, in which of the included files, and the body.
    """
    worlds = tree.root.findall("worldbody")
    bodies = [body for world in worlds for body in world.findall("body")]
    for element in [e for world in worlds for e in world.iter()]:
        if element.tag in _UNREAD:
            raise Entry(tree, element).refusal(
                "this is not supported; open the file in MuJoCo and save it, which writes it out "
                "in plain bodies"
            )
    moving = [body for body in bodies if _moves(body)]
    if not moving:
        raise RobotError("the MJCF file has no body that moves; it describes no robot")
    if len(moving) > 1:
        names = ", ".join(f"'{body.get('name')}'" for body in moving)
        raise Entry(tree, moving[1]).refusal(
            f"several bodies move in the world: {names}; leave only the robot in it"
        )
    check_classes(tree)
    for body in moving[0].iter("body"):
        _check_body(Entry(tree, body), _mass_from_geoms(tree.root))
    for joint in moving[0].iter("joint"):
        _check_joint(Entry(tree, joint))


def motion_mjcf(root: Element) -> str:
    """Return the MJCF of the one robot, ready for Pinocchio, without geometry it does not need."""
    root = with_torques(root)
    for body in root.iter("body"):
        if body.find("inertial") is not None and not _mass_from_geoms(root):
            for geom in body.findall("geom"):
                body.remove(geom)
    for section in list(root):
        if section.tag not in _MOTION:
            root.remove(section)
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


def _moves(body: Element) -> bool:
    return any(e.tag in ("joint", "freejoint") for b in body.iter("body") for e in b)


def _mass_from_geoms(root: Element) -> bool:
    return any(c.get("inertiafromgeom") == "true" for c in root.findall("compiler"))


def _check_body(body: Entry, from_geoms: bool) -> None:
    inertial = None if from_geoms else body.element.find("inertial")
    if inertial is None:
        if any("mesh" in geom.attrib for geom in body.element.findall("geom")):
            raise body.refusal("its mass would come from a mesh; give it an <inertial>")
        return
    mass = body.number(inertial, "mass", "mass", "kg")
    moments = [as_number(word) for word in inertial.get("diaginertia", "0").split()]
    if mass < 0.0 or not min(moments) >= 0.0:
        raise body.refusal(
            f"its mass is {mass:g} kg and its principal moments are {moments} kg·m²; none may be "
            "below 0; correct them",
            inertial,
        )


def _check_joint(joint: Entry) -> None:
    axis = joint.vector(joint.element, "axis", "its axis", "0 0 1")
    if not any(axis):
        raise joint.refusal("its axis is 0 0 0; it needs a direction, as 0 1 0; correct it")


def _for_loader(root: Element) -> str:
    """Write a document in which nothing but the robot hangs on the world, joint by joint."""
    for world in root.findall("worldbody"):
        for element in list(world):
            if element.tag != "body" or not _moves(element):
                world.remove(element)
    for number, body in enumerate(list(root.iter("body"))):
        body.set("name", body.get("name") or f"body_{number}")
    for body in list(root.iter("body")):
        _one_joint_per_body(body)
    for joint in root.iter("joint"):
        _zero_where_drawn(joint)
    return tostring(root, encoding="unicode")


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
