"""What is odd in a URDF: in its joints, masses and inertias; and what a person should know."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace

import numpy as np

from gaitopt.importers.physics import PassiveJoint
from gaitopt.importers.report import Finding
from gaitopt.importers.urdf_document import FREE, LIMITED, Description, Joint, Link, limit_unit
from gaitopt.importers.urdf_geometry import Kind
from gaitopt.importers.urdf_model import inertia_fault
from gaitopt.importers.urdf_transmissions import Rotor
from gaitopt.importers.xml_document import UrdfProblem, as_number, printable
from gaitopt.nlp import Array

_SPRINGS = ("spring_stiffness", "spring_reference")  # of <dynamics>, as SDF has them
_FEWEST = 4  # links of one inertia
_MASSES = 3  # different masses among them: parts that are alike in both legs come in pairs
_MOST = 0.6  # of all links that have a mass
_HEAVY = 0.05  # of the robot's mass: lighter links may well be drawn as points
_MARGIN = 2.0  # of the largest inertia that fits: shapes leave out motors, and drawings fairings
_LOOKED_AT = 0.1  # of the robot's size: links that turn like smaller bodies are not measured
_COUNTS = 1e-5  # of mass times size squared of the robot: less inertia changes no walk
_SHOWN = 6  # names in one sentence
_SAME_END = 1e-6  # rad: a soft limit this near to the hard one is the same

Measure = Callable[[Kind, Collection[str]], dict[str, float]]
"""Returns the diagonals of boxes about the shapes of a kind of some links [m]."""


def joint_problems(joint: Joint) -> list[UrdfProblem]:
    """Return what matters about one joint only if it is part of a leg.

    Limits that readers of URDFs take differently are problems. An effort or a velocity of zero, or
    none, is no motor in one and a motor without limit in another: it is taken as no limit. A range
    that is empty or not given is a joint that is locked in one and turns freely in another: it is
    refused in a leg.
    """
    if joint.kind in FREE:
        text = f"its type is {joint.kind}; only revolute joints are moved, the others are locked"
        return [joint.entry.problem("free", text)]
    if joint.kind == "fixed":
        return []
    problems = _mimic_problems(joint) + _axis_problems(joint)
    if joint.kind in LIMITED:
        problems += _limit_problems(joint)
    return problems


def _mimic_problems(joint: Joint) -> list[UrdfProblem]:
    mimic = joint.entry.element.find("mimic")
    if mimic is None:
        return []
    text = (
        f"it mimics joint '{mimic.get('joint')}', which is not supported in a leg: every leg joint "
        "has its own motor; remove <mimic> there"
    )
    return [joint.entry.problem("mimic", text, mimic)]


def unread_problems(joint: Joint) -> list[UrdfProblem]:
    """Return what a joint says that changes nothing: soft limits upside down, springs."""
    entry, problems = joint.entry, []
    soft = joint.limits.soft
    if joint.kind in LIMITED and soft is not None and not soft[0] < soft[1]:
        text = (
            f"its safety_controller has soft limits from {soft[0]:g} to {soft[1]:g} "
            f"{limit_unit(joint.kind, 'lower')}; lower must be below upper: passed over"
        )
        problems.append(entry.problem("safety", text, entry.element.find("safety_controller")))
    dynamics = entry.element.find("dynamics")
    given = [] if dynamics is None else [n for n in _SPRINGS if n in dynamics.attrib]
    if given and as_number(dynamics.get(_SPRINGS[0], "0")) != 0.0:  # type: ignore[union-attr]
        text = (
            f"its <dynamics> has {' and '.join(given)}, which a URDF does not know: passed over; "
            "springs count in MJCF files (stiffness, springref)"
        )
        problems.append(entry.problem("unknown", text, dynamics))
    return problems


def _axis_problems(joint: Joint) -> list[UrdfProblem]:
    if joint.entry.element.find("axis") is not None:
        return []
    text = 'it has no <axis>: taken as 1 0 0, as the format has it; write <axis xyz="1 0 0"/>'
    return [joint.entry.problem("axis", text)]


def locked_mimics(
    problems: Iterable[UrdfProblem], legs: Collection[str]
) -> tuple[UrdfProblem, ...]:
    """Return the problems of a robot with all joints that mimic others, not the legs', in one.

    Args:
        problems: that were found in its file.
        legs: names of the joints of its legs.
    """
    problems = tuple(problems)
    others = [p for p in problems if p.kind == "mimic" and p.name not in legs]
    if not others:
        return problems
    names = ", ".join(f"'{p.name}'" for p in others)
    subject = "one joint" if len(others) == 1 else f"{len(others)} joints"
    verbs = "mimics another; it is" if len(others) == 1 else "mimic others; they are"
    text = f"{subject} outside the legs {verbs} locked, as every joint there is: {names}"
    told = replace(others[0], text=text)
    return tuple(told if p is others[0] else p for p in problems if p not in others[1:])


def _limit_problems(joint: Joint) -> list[UrdfProblem]:
    entry, limits, limit = joint.entry, joint.limits, joint.entry.element.find("limit")
    if limit is None:
        text = 'it has no limits; add <limit effort="" velocity="" lower="" upper=""/> with values'
        return [entry.problem(kind, text) for kind in ("effort", "velocity", "range")]
    problems = []
    for name, value in (("effort", limits.effort), ("velocity", limits.velocity)):
        if math.isnan(value) or value in (0.0, math.inf):
            unit = limit_unit(joint.kind, name)
            given = limit.get(name)
            found = "is not given" if given is None else f"is {given!r}; it must be above 0"
            text = f"the {name} limit {found}; give it [{unit}]"
            problems.append(entry.problem(name, text, limit))
    return problems + _range_problems(joint)


def _range_problems(joint: Joint) -> list[UrdfProblem]:
    limit = joint.entry.element.find("limit")
    unit = limit_unit(joint.kind, "lower")
    lower, upper = joint.range
    if not lower < upper:
        text = f"the range is from {lower:g} to {upper:g} {unit}; lower must be below upper"
        return [joint.entry.problem("range", text, limit)]
    sides = (("lower", joint.limits.lower), ("upper", joint.limits.upper))
    missing = [side for side, value in sides if math.isnan(value)]
    text = f"no {missing and missing[0]} limit is given: taken as 0 {unit}, as the format has it"
    return [joint.entry.problem("range", text, limit)] if missing else []


def inertial_problems(link: Link) -> list[UrdfProblem]:
    """Return a problem if no body can have the mass and the inertia of a link."""
    if link.inertial is None:
        return []
    fault = inertia_fault(link.inertial.mass, link.inertial.inertia)
    return [link.entry.problem("inertia", fault, link.inertial.element)] if fault else []


def placeholder_problems(robot: Description) -> list[UrdfProblem]:
    """Return a problem for each inertia that many links share, and one for heavy links with none.

    Bodies of one inertia have one mass, or it is a coincidence; several masses are a program's
    default, and so is one inertia of most links.
    """
    heavy = [link for link in robot.links.values() if link.inertial is not None and link.mass > 0.0]
    groups: dict[bytes, list[Link]] = {}
    for link in heavy:
        assert link.inertial is not None  # as of all that are heavy
        groups.setdefault((link.inertial.inertia + 0.0).tobytes(), []).append(link)
    none = groups.pop(np.zeros((3, 3)).tobytes(), [])
    found = [
        _placeholder(links)
        for links in groups.values()
        if len(links) >= _FEWEST
        and (len({link.mass for link in links}) >= _MASSES or len(links) > _MOST * len(heavy))
    ]
    least = _HEAVY * sum(link.mass for link in heavy)
    return found + _points([link for link in none if link.mass > least])


def _points(links: list[Link]) -> list[UrdfProblem]:
    if not links:
        return []
    first = links[0]
    assert first.inertial is not None  # as of all that have a mass
    names = ", ".join(f"'{printable(link.name)}'" for link in links[1:4])
    text = f"it has a mass of {first.mass:.4g} kg but no inertia" + (
        f", nor have {names}{f' and {len(links) - 4} more' if len(links) > 4 else ''}"
        if names
        else ""
    )
    text += ": a point mass? Give the links their inertias"
    return [first.entry.problem("placeholder", text, first.inertial.element)]


def _placeholder(links: list[Link]) -> UrdfProblem:
    first = links[0]
    assert first.inertial is not None  # as of all in a group
    moments = np.diag(first.inertial.inertia)
    names = ", ".join(f"'{printable(link.name)}'" for link in links[1:4])
    more = f" and {len(links) - 4} more" if len(links) > 4 else ""
    light, heavy = (kind(link.mass for link in links) for kind in (min, max))
    masses = f"their masses go from {light:.4g} to {heavy:.4g} kg"
    if light == heavy:
        masses = "these are most of all links"
    text = (
        f"its inertia, {', '.join(f'{value:.4g}' for value in moments)} kg·m², is that of {names}"
        f"{more} too, though {masses}: a placeholder? "
        "Give the links their inertias"
    )
    return first.entry.problem("placeholder", text, first.inertial.element)


def radius_of_gyration(link: Link) -> float:
    """Return the largest about an axis through the centre of mass [m], 0 without mass."""
    if link.inertial is None or link.mass <= 0.0:
        return 0.0
    largest = float(np.linalg.eigvalsh(link.inertial.inertia)[2])
    return float(np.sqrt(max(largest, 0.0) / link.mass))


def oversized(robot: Description, diagonals: Mapping[str, float]) -> list[tuple[Link, float]]:
    """Return links whose inertia no mass within their shapes can have.

    Masses within a box are at most half its diagonal from its middle, so that the moment about
    their centre is at most mass times diagonal squared by four.

    Args:
        robot: links and joints.
        diagonals: of a box about the shapes of each link [m]; links without shapes are left out.

    Returns:
        The links, each with its inertia over the largest that fits.
    """
    found = []
    for name, diagonal in diagonals.items():
        if diagonal <= 0.0:
            continue
        ratio = (radius_of_gyration(robot.links[name]) / (diagonal / 2.0)) ** 2
        if ratio > _MARGIN:
            found.append((robot.links[name], ratio))
    return found


def size_of(robot: Description) -> float:
    """Return the diagonal of a box about all joints and centres of mass at angles of zero [m]."""
    places: list[Array] = []
    waiting = [(robot.root, np.zeros(3), np.eye(3))]
    below = robot.below
    while waiting:
        name, origin, rotation = waiting.pop()
        inertial = robot.links[name].inertial
        places.append(origin)
        if inertial is not None:
            places.append(origin + rotation @ np.array(inertial.pose.xyz))
        waiting += [
            (j.child, origin + rotation @ np.array(j.pose.xyz), rotation @ j.pose.rotation)
            for j in below[name]
        ]
    spread = np.ptp(np.array(places), axis=0)
    return float(np.linalg.norm(spread))


def passive_joints(robot: Description) -> dict[str, PassiveJoint]:
    """Return damping and friction of the joints that have any.

    Args:
        robot: links and joints.
    """
    return {
        name: PassiveJoint((joint.damping,) if joint.damping else (), joint.friction)
        for name, joint in robot.joints.items()
        if joint.damping or joint.friction
    }


def urdf_findings(
    robot: Description,
    rotors: Iterable[Rotor],
    measure: Measure,
) -> tuple[Finding, ...]:
    """Return what was found in a URDF beside what its model shows.

    Args:
        robot: links and joints.
        rotors: of its motors.
        measure: returns the diagonals of boxes about the shapes of a kind of some links [m].
    """
    return (*_rotors(rotors), *_soft_limits(robot), *_large_inertias(robot, measure))


def _rotors(rotors: Iterable[Rotor]) -> list[Finding]:
    groups: dict[tuple[float, float, bool], list[str]] = {}
    for rotor in rotors:
        groups.setdefault((rotor.inertia, rotor.reduction, rotor.given), []).append(rotor.joint)
    findings = []
    for (inertia, reduction, given), joints in groups.items():
        armature = inertia * reduction**2
        text = f"armature {armature:.4g} kg·m²: rotor inertia {inertia:.4g} kg·m² of the file"
        if given:
            text += f", times the reduction {reduction:g} squared" if reduction != 1.0 else ""
        else:
            text += "; it gives no reduction, which is taken as 1"
        findings.append(Finding("armature", _names(joints), text, "found" if given else "warning"))
    return findings


def _soft_limits(robot: Description) -> list[Finding]:
    tighter = [joint for joint in robot.joints.values() if _is_tighter(joint)]
    if not tighter:
        return []
    first = tighter[0]
    assert first.limits.soft is not None  # as of all that are tighter
    low, high = first.limits.soft
    lower, upper = first.range
    unit = limit_unit(first.kind, "lower")
    text = (
        "safety_controller keeps them within narrower ranges, which are not imposed here "
        f"('{first.name}': {low:g} to {high:g} of {lower:g} to {upper:g} {unit}); "
        "give such a range to walk within it"
    )
    return [Finding("limits", _names([joint.name for joint in tighter]), text, "warning")]


def _is_tighter(joint: Joint) -> bool:
    if joint.kind not in LIMITED or joint.limits.soft is None:
        return False
    low, high = joint.limits.soft
    lower, upper = joint.range
    return low < high and (low > lower + _SAME_END or high < upper - _SAME_END)


def _large_inertias(robot: Description, measure: Measure) -> list[Finding]:
    size, mass = size_of(robot), sum(link.mass for link in robot.links.values())
    turning = {
        name: radius_of_gyration(link)
        for name, link in robot.links.items()
        if link.mass * radius_of_gyration(link) ** 2 > _COUNTS * mass * size**2
    }
    suspects = [n for n, radius in turning.items() if size > 0.0 and radius > _LOOKED_AT * size]
    touched = measure("collision", suspects) if suspects else {}
    doubtful = {link.name for link, _ in oversized(robot, touched)}
    unseen = [name for name in suspects if name in doubtful or name not in touched]
    drawn = measure("visual", unseen) if unseen else {}
    measured = {
        name: max(touched.get(name, 0.0), drawn.get(name, 0.0))
        for name in suspects
        if name in doubtful or name in drawn
    }
    findings = []
    for link, ratio in sorted(oversized(robot, measured), key=lambda pair: -pair[1]):
        text = (
            f"its inertia is {ratio:.3g} times the largest that a body of {link.mass:.4g} kg "
            f"within its shapes, {measured[link.name]:.3g} m across, can have; check its unit "
            "(kg·m²), and that it is taken about the centre of mass"
        )
        findings.append(Finding("inertia", link.name, text, "warning"))
    for name in unseen:
        if name not in measured and turning[name] > size / 2.0:
            text = (
                f"its inertia is that of a body which reaches {turning[name]:.3g} m from its "
                f"centre of mass, but the robot is {size:.3g} m across; check its unit (kg·m²)"
            )
            findings.append(Finding("inertia", name, text, "warning"))
    return _few(findings)


def _few(findings: list[Finding]) -> list[Finding]:
    """Return the findings, of many only the first, which then speaks for all."""
    if len(findings) < 3:
        return findings
    first = findings[0]
    names = _names([finding.subject for finding in findings])
    text = f"'{first.subject}': {first.text}; the same or the like holds for the others"
    return [Finding(first.topic, names, text, first.how)]


def _names(names: list[str]) -> str:
    shown = ", ".join(names[:_SHOWN])
    return shown + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
