"""What is odd in a URDF: refused, noted as a problem of one link or joint, or told as a finding.

What leaves no robot, or makes every result wrong, is refused at once. What matters only where it is
(an arm without limits is an arm that is locked) is returned as data, to be weighed once the legs
are known: joints by leg detection, ranges by the importer, bodies by `refuse_unsound`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.escape import printable
from gaitopt.importers.physics import Tie, fault_of_tie, ties_to_masters
from gaitopt.importers.pinocchio_model import MOST_JOINTS, inertia_fault
from gaitopt.importers.report import Faults, Finding, How, fault_error, faults_of, listed
from gaitopt.importers.urdf_document import (
    FREE_TYPES,
    LIMITED_TYPES,
    Description,
    Joint,
    Link,
    check_spelling,
    check_tree,
    describe,
    limit_unit,
    name_problems,
)
from gaitopt.importers.urdf_model import Kind, Rotor, Shape, read_rotors, read_shapes, refuse_taken
from gaitopt.importers.xml_document import FileProblem, XmlTree, as_number
from gaitopt.nlp import Array

_FOLLOWING = ("revolute", "continuous", "prismatic")  # joints that <mimic> can lead
_SPRINGS = ("spring_stiffness", "spring_reference")  # of <dynamics>, as SDF has them
_PLACEHOLDER_LINKS = 4  # links of one inertia that may be a placeholder
_PLACEHOLDER_MASSES = 3  # different masses among them: parts of both legs come in pairs
_MOST_LINKS_SHARE = 0.6  # of all links that have a mass
_HEAVY_SHARE = 0.05  # of the robot's mass: lighter links may well be drawn as points
_INERTIA_MARGIN = 2.0  # of the largest that fits: shapes leave out motors and fairings
_LARGE_GYRATION = 0.1  # of the robot's size: links that turn like smaller bodies are not measured
_LEAST_INERTIA = 1e-5  # of mass times size squared of the robot: less inertia changes no walk
_MOST_NAMES = 6  # names in one sentence
_SAME_LIMIT = 1e-6  # rad: a soft limit this near to the hard one is the same

Measure = Callable[[Kind, Collection[str]], dict[str, float]]
"""Returns the diagonals of boxes about the shapes of a kind of some links [m]."""


@dataclass(frozen=True, eq=False)
class CheckedUrdf:
    """All that a URDF says.

    Attributes:
        robot: links and joints.
        rotors: of its motors.
        ties: of joints that follow others.
        shapes: that can be drawn or touched.
        problems: what is suspicious but did not stop reading, in the order of the file.
    """

    robot: Description
    rotors: tuple[Rotor, ...]
    ties: dict[str, Tie]
    shapes: tuple[Shape, ...]
    problems: tuple[FileProblem, ...]


def check_urdf(tree: XmlTree) -> CheckedUrdf:
    """Read a URDF.

    Raises:
        RobotError: naming the line, the link or joint, the value, and what is allowed.
    """
    check_tree(tree)
    count = sum(joint.get("type") != "fixed" for joint in tree.root.findall("joint"))
    if count > MOST_JOINTS:
        raise RobotError(
            f"the URDF has {count} joints that move; at most {MOST_JOINTS} can be read; make those "
            'that a walk does not need fixed (type="fixed")'
        )
    faults, problems = Faults(), []
    with faults.noted():
        problems = check_spelling(tree)
    spelt = {_place(fault) for fault in faults.found}
    try:
        robot = describe(tree)
        refuse_taken(robot)
        rotors, alone = read_rotors(tree, robot)
    except RobotError as error:
        # What is misspelt is missing, too: that is said once.
        new = [fault for fault in faults_of(error) if _place(fault) not in spelt]
        raise fault_error([*faults.found, *new]) from error
    faults.refuse()
    for link in robot.links.values():
        problems += _inertial_problems(link)
    for joint in robot.joints.values():
        problems += [*_joint_problems(joint), *_unread_problems(joint)]
    ties, told = _read_ties(robot)
    shapes, lost = read_shapes(tree)
    problems += [*told, *_massless(robot), *_placeholders(robot), *name_problems(tree)]
    problems += [*alone, *lost]
    problems.sort(key=lambda problem: problem.line)
    return CheckedUrdf(robot, rotors, ties, shapes, tuple(problems))


def _place(fault: str) -> str:
    """Return the line and the element that a fault names."""
    return ":".join(fault.split(":")[:2])


def locked_mimics(
    problems: Iterable[FileProblem], moving: Collection[str]
) -> tuple[FileProblem, ...]:
    """Return the problems of a robot with all joints that follow others and stand still in one.

    That a joint follows another is no problem where both move.
    """
    problems = tuple(p for p in problems if p.kind != "tied" or p.name not in moving)
    others = [p for p in problems if p.kind in ("mimic", "tied") and p.name not in moving]
    if not others:
        return problems
    subject = "one joint" if len(others) == 1 else f"{len(others)} joints"
    verbs = "mimics another; it is" if len(others) == 1 else "mimic others; they are"
    names = listed((p.name for p in others), None)
    text = f"{subject} outside the legs {verbs} locked, as every joint there is: {names}"
    told = replace(others[0], text=text)
    return tuple(told if p is others[0] else p for p in problems if p not in others[1:])


def _read_ties(robot: Description) -> tuple[dict[str, Tie], list[FileProblem]]:
    """Return the joints of a URDF that follow others, and every <mimic> as a problem.

    Its kind is "tied" where the joint can follow, which matters where the other does not move, and
    "mimic" where it cannot, which matters if the joint is to move.
    """
    joints = {name: joint for name, joint in robot.joints.items() if joint.kind in _FOLLOWING}
    ties, faults = dict[str, Tie](), dict[str, str]()
    for name, joint in robot.joints.items():
        if (mimic := joint.entry.element.find("mimic")) is None or joint.kind == "fixed":
            continue
        values = [
            as_number(mimic.get(attribute, default))
            for attribute, default in (("multiplier", "1"), ("offset", "0"))
        ]
        multiplier, offset = values
        tie = Tie(name, mimic.get("joint", ""), multiplier, offset)
        fault = fault_of_tie(tie, joints) if name in joints else f"its type is {joint.kind}"
        if fault:
            faults[name] = fault
        else:
            ties[name] = tie
    ties, circles = ties_to_masters(ties)
    problems = []
    for name, joint in robot.joints.items():
        if (mimic := joint.entry.element.find("mimic")) is None:
            continue
        if name in ties:
            problems.append(joint.entry.problem("tied", f"it {ties[name]}", mimic))
        elif fault := (faults | circles).get(name, ""):
            text = f"its <mimic> cannot be followed: {fault}, or remove <mimic> there"
            problems.append(joint.entry.problem("mimic", text, mimic))
    return ties, problems


def _joint_problems(joint: Joint) -> list[FileProblem]:
    """Return what matters about one joint only if it is part of a leg."""
    # Limits that readers of URDFs take differently are problems: an effort or velocity of zero is
    # no motor in one and one without limit in another, an empty range a lock or none.
    entry = joint.entry
    if joint.kind in FREE_TYPES:
        text = f"its type is {joint.kind}; only revolute joints are moved, the others are locked"
        return [entry.problem("free", text)]
    if joint.kind == "fixed":
        return []
    problems = []
    if entry.element.find("axis") is None:
        text = 'it has no <axis>: taken as 1 0 0, as the format has it; write <axis xyz="1 0 0"/>'
        problems.append(entry.problem("axis", text))
    return problems + (_limit_problems(joint) if joint.kind in LIMITED_TYPES else [])


def _limit_problems(joint: Joint) -> list[FileProblem]:
    entry, limits, limit = joint.entry, joint.limits, joint.entry.element.find("limit")
    if limit is None:
        text = 'it has no limits; add <limit effort="" velocity="" lower="" upper=""/> with values'
        return [entry.problem(kind, text) for kind in ("effort", "velocity", "range")]
    problems = []
    for name, value in (("effort", limits.effort), ("velocity", limits.velocity)):
        if math.isnan(value) or value in (0.0, math.inf):
            given = limit.get(name)
            found = "is not given" if given is None else f"is {given!r}; it must be above 0"
            text = f"the {name} limit {found}; give it [{limit_unit(joint.kind, name)}]"
            problems.append(entry.problem(name, text, limit))
    unit, (lower, upper) = limit_unit(joint.kind, "lower"), joint.range
    sides = (("lower", limits.lower), ("upper", limits.upper))
    missing = [side for side, value in sides if math.isnan(value)]
    if not lower < upper:
        text = f"the range is from {lower:g} to {upper:g} {unit}; lower must be below upper"
        if missing:
            text += f" (no {' and no '.join(missing)} limit is given: taken as 0)"
        problems.append(entry.problem("range", text, limit))
    elif missing:
        text = f"no {missing[0]} limit is given: taken as 0 {unit}, as the format has it"
        problems.append(entry.problem("range", text, limit))
    return problems


def _unread_problems(joint: Joint) -> list[FileProblem]:
    """Return what a joint says that changes nothing: soft limits upside down, springs."""
    entry, problems, soft = joint.entry, [], joint.limits.soft
    if joint.kind in LIMITED_TYPES and soft is not None and not soft[0] < soft[1]:
        text = (
            f"its safety_controller has soft limits from {soft[0]:g} to {soft[1]:g} "
            f"{limit_unit(joint.kind, 'lower')}; lower must be below upper: passed over"
        )
        problems.append(entry.problem("safety", text, entry.element.find("safety_controller")))
    dynamics = entry.element.find("dynamics")
    given = [] if dynamics is None else [name for name in _SPRINGS if name in dynamics.attrib]
    if dynamics is not None and given and as_number(dynamics.get(_SPRINGS[0], "0")) != 0.0:
        text = (
            f"its <dynamics> has {' and '.join(given)}, which a URDF does not know: passed over; "
            "springs count in MJCF files (stiffness, springref)"
        )
        problems.append(entry.problem("unknown", text, dynamics))
    return problems


def _inertial_problems(link: Link) -> list[FileProblem]:
    """Return a problem if no body can have the mass and the inertia of a link."""
    if link.inertial is None:
        return []
    fault = inertia_fault(link.inertial.mass, link.inertial.inertia)
    return [link.entry.problem("inertia", fault, link.inertial.element)] if fault else []


def _massless(robot: Description) -> list[FileProblem]:
    """Return the links that move although they, and all fixed to them, weigh nothing."""
    moved = {joint.child for joint in robot.joints.values() if joint.kind != "fixed"}
    problems = []
    for name, link in robot.links.items():
        if name != robot.root and name not in moved:
            continue
        if any(robot.links[part].mass > 0.0 for part in robot.rigid(name)):
            continue
        if name == robot.root and _inertial_problems(link):  # which says so
            continue
        moving = "a joint moves it, but it has no mass"
        if name == robot.root:
            moving = "it is the root link, and neither it nor a link fixed to it has a mass"
        problems.append(link.entry.problem("massless", f"{moving}; give it its mass"))
    return problems


def _placeholders(robot: Description) -> list[FileProblem]:
    """Return problems of inertias that many links share, and of heavy links with none."""
    # Bodies of one inertia have one mass, or it is a coincidence; several masses are a default.
    groups: dict[bytes, list[Link]] = {}
    heavy = 0
    for link in robot.links.values():
        if link.inertial is not None and link.mass > 0.0:
            groups.setdefault((link.inertial.inertia + 0.0).tobytes(), []).append(link)
            heavy += 1
    least = _HEAVY_SHARE * sum(link.mass for links in groups.values() for link in links)
    points = [p for p in groups.pop(np.zeros((3, 3)).tobytes(), []) if p.mass > least]
    problems = []
    for links in groups.values():
        first, names = links[0], listed((printable(link.name) for link in links[1:]), 3)
        masses = {link.mass for link in links}
        if len(links) < _PLACEHOLDER_LINKS or (
            len(masses) < _PLACEHOLDER_MASSES and len(links) <= _MOST_LINKS_SHARE * heavy
        ):
            continue
        among = f"their masses go from {min(masses):.4g} to {max(masses):.4g} kg"
        if len(masses) == 1:
            among = "these are most of all links"
        text = (
            f"its inertia, {', '.join(f'{value:.4g}' for value in np.diag(_tensor(first)))} kg·m², "
            f"is that of {names} too, though {among}: a placeholder? Give the links their inertias"
        )
        problems.append((first, text))
    if points:
        text = f"it has a mass of {points[0].mass:.4g} kg but no inertia"
        if others := listed((printable(link.name) for link in points[1:]), 3):
            text += f", nor have {others}"
        text += ": a point mass? Give the links their inertias"
        problems.append((points[0], text))
    return [
        link.entry.problem("placeholder", text, link.entry.element.find("inertial"))
        for link, text in problems
    ]


def _tensor(link: Link) -> Array:
    return np.zeros((3, 3)) if link.inertial is None else link.inertial.inertia


# Findings


def urdf_findings(
    robot: Description, rotors: Iterable[Rotor], measure: Measure
) -> tuple[Finding, ...]:
    """Return what was found in a URDF beside what its model shows."""
    return (*_rotors(rotors), *_soft_limits(robot), *_large_inertias(robot, measure))


def _rotors(rotors: Iterable[Rotor]) -> list[Finding]:
    groups: dict[Rotor, list[str]] = {}
    for rotor in rotors:
        groups.setdefault(replace(rotor, joint=""), []).append(rotor.joint)
    findings = []
    for one, joints in groups.items():
        own = one.unit if one.given and one.reduction == 1.0 else "kg·m²"
        seen = f"armature {one.armature:.4g} {one.unit}"
        text = f"{seen}: rotor inertia {one.inertia:.4g} {own} of the file"
        if not one.given:
            text += "; it gives no reduction, which is taken as 1"
        elif one.reduction != 1.0:
            text += f", times the reduction {one.reduction:g} squared"
        how: How = "found" if one.given else "warning"
        findings.append(Finding("armature", listed(joints, _MOST_NAMES, ""), text, how))
    return findings


def _soft_limits(robot: Description) -> list[Finding]:
    tighter = []
    for joint in robot.joints.values():
        low, high = joint.limits.soft or (math.inf, -math.inf)
        lower, upper = joint.range
        inside = low > lower + _SAME_LIMIT or high < upper - _SAME_LIMIT
        if joint.kind in LIMITED_TYPES and low < high and inside:
            unit = limit_unit(joint.kind, "lower")
            ends = f"'{joint.name}': {low:g} to {high:g} of {lower:g} to {upper:g} {unit}"
            tighter.append((joint.name, ends))
    if not tighter:
        return []
    text = (
        "safety_controller keeps them within narrower ranges, which are not imposed here "
        f"({tighter[0][1]}); give such a range to walk within it"
    )
    return [Finding("limits", listed((n for n, _ in tighter), _MOST_NAMES, ""), text, "warning")]


def _large_inertias(robot: Description, measure: Measure) -> list[Finding]:
    """Return the links whose inertia no mass within their shapes, or within the robot, can have."""
    # Masses within a box are at most half its diagonal d from its middle: a moment is at most m d²
    # / 4.
    size, mass = _size_of(robot), sum(link.mass for link in robot.links.values())
    gyration: dict[str, float] = {}
    for name, link in robot.links.items():
        if link.mass > 0.0:
            largest = max(float(np.linalg.eigvalsh(_tensor(link))[2]), 0.0)
            if largest > _LEAST_INERTIA * mass * size**2:
                gyration[name] = math.sqrt(largest / link.mass)

    def over(name: str, diagonal: float) -> float:
        return 0.0 if diagonal <= 0.0 else (gyration[name] / (diagonal / 2.0)) ** 2

    suspects = [
        n for n, radius in gyration.items() if size > 0.0 and radius > _LARGE_GYRATION * size
    ]
    touched = measure("collision", suspects) if suspects else {}
    unseen = [n for n in suspects if n not in touched or over(n, touched[n]) > _INERTIA_MARGIN]
    drawn = measure("visual", unseen) if unseen else {}
    measured = {
        name: max(touched.get(name, 0.0), drawn.get(name, 0.0))
        for name in suspects
        if name in touched or name in drawn
    }
    ratios = {name: over(name, diagonal) for name, diagonal in measured.items()}
    findings = []
    for name in sorted(ratios, key=lambda name: -ratios[name]):
        if ratios[name] > _INERTIA_MARGIN:
            text = (
                f"its inertia is {ratios[name]:.3g} times the largest that a body of "
                f"{robot.links[name].mass:.4g} kg within its shapes, {measured[name]:.3g} m "
                "across, can have; check its unit (kg·m²), and that it is taken about the centre "
                "of mass"
            )
            findings.append(Finding("inertia", name, text, "warning"))
    for name in unseen:
        if name not in measured and gyration[name] > size / 2.0:
            text = (
                f"its inertia is that of a body which reaches {gyration[name]:.3g} m from its "
                f"centre of mass, but the robot is {size:.3g} m across; check its unit (kg·m²)"
            )
            findings.append(Finding("inertia", name, text, "warning"))
    if len(findings) < 3:
        return findings
    first = findings[0]
    text = f"'{first.subject}': {first.text}; the same or the like holds for the others"
    names = listed((finding.subject for finding in findings), _MOST_NAMES, "")
    return [Finding(first.topic, names, text, first.how)]


def _size_of(robot: Description) -> float:
    """Return the diagonal of a box about all joints and centres of mass at angles of zero [m]."""
    places: list[Array] = []
    waiting = [(robot.root, np.zeros(3), np.eye(3))]
    while waiting:
        name, origin, rotation = waiting.pop()
        inertial = robot.links[name].inertial
        places.append(origin)
        if inertial is not None:
            places.append(origin + rotation @ inertial.pose.translation)
        waiting += [
            (j.child, origin + rotation @ j.pose.translation, rotation @ j.pose.rotation)
            for j in robot.below[name]
        ]
    return float(np.linalg.norm(np.ptp(np.array(places), axis=0)))
