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
from gaitopt.importers.report import Faults, fault_error, faults_of
from gaitopt.importers.urdf_document import (
    Description,
    check_spelling,
    check_tree,
    describe,
    name_problems,
)
from gaitopt.importers.urdf_geometry import read_shapes
from gaitopt.importers.urdf_model import inertia_fault, refuse_taken
from gaitopt.importers.urdf_report import (
    inertial_problems,
    joint_problems,
    placeholder_problems,
    unread_problems,
)
from gaitopt.importers.urdf_transmissions import read_rotors
from gaitopt.importers.xml_document import UrdfProblem, XmlTree

_MOST = 1e9  # kg, m, kg·m²: a thousand times what the largest machines come to, in mm and g
_IDLE = 1e-12  # of the largest inertia that a joint moves: what rounding leaves of none
MOST_JOINTS = 300
"""Joints that move: Pinocchio's workspaces grow with their cube, 0.2 GB a piece for so many."""


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
    _check_count(tree)
    faults, problems = Faults(), []
    with faults.noted():
        problems = check_spelling(tree)
    spelt = {_place(fault) for fault in faults.found}
    try:
        robot = describe(tree)
        refuse_taken(robot)
        rotors = read_rotors(tree, robot)[1]
    except RobotError as error:
        # What is misspelt is missing, too: that is said once.
        new = [fault for fault in faults_of(error) if _place(fault) not in spelt]
        raise fault_error([*faults.found, *new]) from error
    faults.refuse()
    for link in robot.links.values():
        problems += inertial_problems(link)
    for joint in robot.joints.values():
        problems += [*joint_problems(joint), *unread_problems(joint)]
    problems += _massless(robot)
    problems += placeholder_problems(robot)
    problems += name_problems(tree)
    problems += rotors
    problems += read_shapes(tree).problems
    return tuple(sorted(problems, key=lambda problem: problem.line))


def _place(fault: str) -> str:
    """Return the line and the element that a fault names."""
    return ":".join(fault.split(":")[:2])


def _check_count(tree: XmlTree) -> None:
    count = sum(joint.get("type") != "fixed" for joint in tree.root.findall("joint"))
    if count > MOST_JOINTS:
        raise RobotError(
            f"the URDF has {count} joints that move; at most {MOST_JOINTS} can be read; make those "
            'that a walk does not need fixed (type="fixed")'
        )


def refuse_unsound(model: pin.Model, problems: Iterable[UrdfProblem]) -> None:
    """Refuse a robot with a body that cannot be, or a joint that moves no mass.

    Args:
        model: a free-flyer and the joints of the legs; all other joints are locked.
        problems: that were found in its file.

    Raises:
        RobotError: naming the link if one is at fault, else the body or the joint.
    """
    problems, faults = tuple(problems), []
    for joint in range(1, model.njoints):
        inertia = model.inertias[joint]
        largest = float(max(inertia.mass, np.abs(inertia.inertia).max(), *np.abs(inertia.lever)))
        if not largest < _MOST:
            faults.append(
                f"{_body(model, joint)}: its mass is {inertia.mass:.4g} kg, its largest moment "
                f"{np.abs(inertia.inertia).max():.4g} kg·m²; numbers from {_MOST:g} on describe no "
                "robot; correct the masses (kg), inertias (kg·m²) and lengths (m) of the file"
            )
        elif fault := inertia_fault(float(inertia.mass), np.array(inertia.inertia)):
            faults += _body_faults(model, joint, fault, problems)
    if faults:
        raise fault_error(faults)
    _refuse_idle(model)


def _refuse_idle(model: pin.Model) -> None:
    """Refuse a joint that moves no mass: no torque is right for it, and nothing can be solved.

    Seen with all joints bent by different angles, lest a mass just happen to lie on an axis.
    """
    q = np.array(pin.neutral(model))
    q[7:] = 0.2 + 0.1 * np.arange(model.nq - 7)
    moved = np.diag(pin.crba(model, model.createData(), q))[6:]
    idle = [str(model.names[2 + int(row)]) for row in np.flatnonzero(moved <= _IDLE * moved.max())]
    if idle:
        raise RobotError(
            f"joint '{idle[0]}' moves no mass: neither the link it moves nor any beyond has one "
            f"away from its axis{_also(idle[1:])}; give the links of the legs their <inertial>: "
            "mass (kg), centre of mass (m) and inertia (kg·m²), or the joint its armature (kg·m²)"
        )


def _also(names: list[str]) -> str:
    more = f", and so on for {len(names) - 2} more" if len(names) > 2 else ""
    return f" (the same holds for {', '.join(names[:2])}{more})" if names else ""


def _body_faults(
    model: pin.Model, joint: int, fault: str, problems: tuple[UrdfProblem, ...]
) -> list[str]:
    """Return the messages: of the links at fault if any are known, else of the whole body."""
    links = {frame.name for frame in model.frames if frame.parentJoint == joint}
    known = [str(p) for p in problems if p.kind == "inertia" and p.name in links]
    return known or [f"{_body(model, joint)}: {fault}"]


def _body(model: pin.Model, joint: int) -> str:
    return "the trunk" if joint == 1 else f"the body moved by joint '{model.names[joint]}'"


def _massless(robot: Description) -> list[UrdfProblem]:
    """Return the links that move although they, and all fixed to them, weigh nothing."""
    moved = {joint.child for joint in robot.joints.values() if joint.kind != "fixed"}
    problems = []
    for name, link in robot.links.items():
        if name != robot.root and name not in moved:
            continue
        if any(robot.links[part].mass > 0.0 for part in robot.rigid(name)):
            continue
        if name == robot.root and inertial_problems(link):  # which says so
            continue
        moving = "a joint moves it, but it has no mass"
        if name == robot.root:
            moving = "it is the root link, and neither it nor a link fixed to it has a mass"
        problems.append(link.entry.problem("massless", f"{moving}; give it its mass"))
    return problems
