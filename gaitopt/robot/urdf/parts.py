"""The parts of a URDF that a loader is given: what moves, or what is seen and touched.

Motion needs no geometry, so a missing mesh, an unknown shape or a broken material cannot stop a
robot from being read; and geometry is read link by link, with every mesh path made absolute.
"""

from __future__ import annotations

import copy
from collections.abc import Collection
from xml.etree.ElementTree import Element, SubElement, tostring

from gaitopt.robot.files.meshes import MeshPaths, MeshProblem
from gaitopt.robot.urdf.continuous import make_revolute
from gaitopt.robot.urdf.joints import FREE, LIMITED, usable_limit

GEOMETRY = ("visual", "collision")


def motion_part(root: Element) -> str:
    """Return a URDF of the links and joints alone.

    A limit that is not given or not finite is 0 (see `check_joint`), a continuous joint a revolute
    one (see `without_end`). A massless root that only
    carries the robot on a floating joint is left out.

    Args:
        root: of a URDF that was checked.
    """
    root = copy.deepcopy(root)
    for element in list(root):
        if element.tag not in ("link", "joint"):
            root.remove(element)
    for link in root.findall("link"):
        for element in list(link):
            if element.tag != "inertial":
                link.remove(element)
    for joint in root.findall("joint"):
        make_revolute(joint)
        _complete_limit(joint)
    _drop_world(root)
    return tostring(root, encoding="unicode")


def geometry_part(root: Element, kind: str, paths: MeshPaths, links: Collection[str] | None) -> str:
    """Return the URDF with the usable geometry of one kind only, mesh paths made absolute.

    Args:
        root: of a URDF that was checked.
        kind: "visual" or "collision".
        paths: where meshes are.
        links: whose geometry is wanted; None for all.
    """
    root = copy.deepcopy(root)
    root.set("version", "1.2")  # capsules are dropped from URDFs of older versions
    for link in root.findall("link"):
        for element in [e for tag in GEOMETRY for e in link.findall(tag)]:
            wanted = element.tag == kind and (links is None or link.get("name") in links)
            if not wanted or not _locate_mesh(element, paths):
                link.remove(element)
    for joint in root.findall("joint"):
        _complete_limit(joint)
        for limit in joint.findall("limit"):
            limit.attrib.update(lower="0", upper="0")  # an empty range would stop the loader
    _drop_world(root)
    return tostring(root, encoding="unicode")


def mesh_problems(root: Element, paths: MeshPaths) -> list[MeshProblem]:
    """Return the meshes that cannot be used, in the order of the file."""
    problems = []
    for link in root.findall("link"):
        for element in [e for e in link if e.tag in GEOMETRY]:
            mesh = element.find("geometry/mesh")
            file = "" if mesh is None else mesh.get("filename", "")
            reason = "" if mesh is None else paths.problem(file)
            if reason:
                problems.append(MeshProblem(link.get("name", ""), element.tag, file, reason))
    return problems


def _locate_mesh(element: Element, paths: MeshPaths) -> bool:
    """Make the path of a mesh absolute; return whether the geometry can be used."""
    mesh = element.find("geometry/mesh")
    if mesh is None:
        return element.find("geometry") is not None
    file = mesh.get("filename", "")
    if paths.problem(file):
        return False
    mesh.set("filename", str(paths.find(file)))
    return True


def _complete_limit(joint: Element) -> None:
    if joint.get("type") not in LIMITED:
        return
    limit = joint.find("limit")
    if limit is None:
        limit = SubElement(joint, "limit")
    for name in ("effort", "velocity", "lower", "upper"):
        if usable_limit(joint, name) == 0.0:
            limit.set(name, "0")


def _drop_world(root: Element) -> None:
    """Leave out a bare root link whose one joint is floating: the free-flyer does its work."""
    children = {_end(joint, "child") for joint in root.findall("joint")}
    for link in root.findall("link"):
        if link.get("name", "") in children or link.find("inertial") is not None:
            continue
        below = [j for j in root.findall("joint") if _end(j, "parent") == link.get("name")]
        if len(below) == 1 and below[0].get("type") in FREE[:1]:
            root.remove(link)
            root.remove(below[0])


def _end(joint: Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")
