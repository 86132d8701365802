"""Whether the joints of a URDF can move, and say how far, how fast and how strongly."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import replace

from gaitopt.robot.urdf.description import FREE, LIMITED, Joint, limit_unit
from gaitopt.robot.urdf.values import UrdfProblem, as_number

_SPRINGS = ("spring_stiffness", "spring_reference")  # of <dynamics>, as SDF has them


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
    lower, upper = range_of(joint)
    if not lower < upper:
        text = f"the range is from {lower:g} to {upper:g} {unit}; lower must be below upper"
        return [joint.entry.problem("range", text, limit)]
    sides = (("lower", joint.limits.lower), ("upper", joint.limits.upper))
    missing = [side for side, value in sides if math.isnan(value)]
    text = f"no {missing and missing[0]} limit is given: taken as 0 {unit}, as the format has it"
    return [joint.entry.problem("range", text, limit)] if missing else []


def range_of(joint: Joint) -> tuple[float, float]:
    """Return the range of a joint [rad, m]; a side not given is at 0, as the format has it.

    A continuous joint has none, whatever its limit says.
    """
    if joint.kind == "continuous":
        return -math.inf, math.inf
    lower, upper = joint.limits.lower, joint.limits.upper
    return 0.0 if math.isnan(lower) else lower, 0.0 if math.isnan(upper) else upper


def strength_of(joint: Joint) -> tuple[float, float]:
    """Return the limits of torque and rate; infinite where none is given."""
    values = joint.limits.effort, joint.limits.velocity
    effort, velocity = (math.inf if math.isnan(value) else value for value in values)
    return effort, velocity
