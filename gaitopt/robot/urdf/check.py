"""What the loaders below accept silently, or refuse without saying why.

What leaves no robot, or makes every result wrong, is refused at once. What matters only where it is
(an arm without limits is an arm that is locked) is returned as data, to be weighed once the legs
are known: joints by `find_legs`, ranges by `read_robot`, bodies by `refuse_unsound`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.inertial import check_inertial, inertia_fault
from gaitopt.robot.urdf.joints import check_joint
from gaitopt.robot.urdf.tree import check_tree
from gaitopt.robot.urdf.values import Entry, UrdfProblem


def check_urdf(tree: XmlTree) -> tuple[UrdfProblem, ...]:
    """Check a URDF before any loader sees it.

    Args:
        tree: of the URDF.

    Returns:
        What is suspicious but does not stop reading, in the order of the file.

    Raises:
        RobotError: naming the line, the link or joint, the value, and what is allowed.
    """
    check_tree(tree)
    links = [Entry(tree, element) for element in tree.root.findall("link")]
    joints = [Entry(tree, element) for element in tree.root.findall("joint")]
    problems: list[UrdfProblem] = []
    for link in links:
        inertial = link.element.find("inertial")
        if inertial is not None:
            problems += check_inertial(link, inertial)
    for joint in joints:
        problems += check_joint(joint)
    problems += _massless(links, joints)
    return tuple(sorted(problems, key=lambda problem: problem.line))


def refuse_unsound(model: pin.Model, problems: Iterable[UrdfProblem]) -> None:
    """Refuse a robot with a body whose mass and inertia no body can have.

    Args:
        model: a free-flyer and the joints of the legs; all other joints are locked.
        problems: that were found in its file.

    Raises:
        RobotError: naming the link if one is at fault, else the body.
    """
    problems = tuple(problems)
    for joint in range(1, model.njoints):
        inertia = model.inertias[joint]
        fault = inertia_fault(float(inertia.mass), np.array(inertia.inertia))
        if fault:
            raise RobotError(_body_fault(model, joint, fault, problems))


def _body_fault(model: pin.Model, joint: int, fault: str, problems: tuple[UrdfProblem, ...]) -> str:
    """Return the message: of the link that is at fault if one is known, else of the whole body."""
    links = {frame.name for frame in model.frames if frame.parentJoint == joint}
    for problem in problems:
        if problem.kind == "inertia" and problem.name in links:
            return str(problem)
    body = "the trunk" if joint == 1 else f"the body moved by joint '{model.names[joint]}'"
    return f"{body}: {fault}"


def _massless(links: list[Entry], joints: list[Entry]) -> list[UrdfProblem]:
    """Return the links that a joint moves although they, and all fixed to them, weigh nothing."""
    heavy = {link.name for link in links if _mass(link) > 0.0}
    fixed: dict[str, list[str]] = {}
    moved = set()
    for joint in joints:
        parent, child = (_linked(joint, role) for role in ("parent", "child"))
        if joint.element.get("type") == "fixed":
            fixed.setdefault(parent, []).append(child)
        else:
            moved.add(child)
    return [
        link.problem("massless", "a joint moves it, but it has no mass; give it its mass")
        for link in links
        if link.name in moved and not heavy & _carried(link.name, fixed)
    ]


def _carried(link: str, fixed: dict[str, list[str]]) -> set[str]:
    """Return the link and all that is fixed to it."""
    found, waiting = {link}, [link]
    while waiting:
        below = fixed.get(waiting.pop(), [])
        found.update(below)
        waiting += below
    return found


def _linked(joint: Entry, role: str) -> str:
    element = joint.element.find(role)
    return "" if element is None else element.get("link", "")


def _mass(link: Entry) -> float:
    mass = link.element.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))
