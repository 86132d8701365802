"""Whether the joints of a URDF can move, and say how far, how fast and how strongly."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import replace
from xml.etree.ElementTree import Element

from gaitopt.robot.urdf.values import Entry, UrdfProblem, as_number

LIMITED = ("revolute", "prismatic")
FREE = ("floating", "planar")
_UNITS = {"revolute": ("rad", "N.m", "rad/s"), "prismatic": ("m", "N", "m/s")}


def check_joint(joint: Entry) -> list[UrdfProblem]:
    """Check the placement, the axis and the limits of one joint.

    Returns:
        What matters only if the joint is part of a leg.

    Raises:
        RobotError: the placement or the axis is not finite, the axis has no direction, or a limit
            is no number or below zero (no loader would take the file).
    """
    kind = joint.element.get("type", "")
    for part in ("xyz", "rpy"):
        joint.vector(joint.element.find("origin"), part, f"the {part} of its origin")
    if kind == "fixed":
        return []
    if kind in FREE:
        text = f"its type is {kind}; only revolute joints are moved, the others are locked"
        return [joint.problem("free", text)]
    _check_axis(joint)
    problems = _mimic_problems(joint)
    if kind in LIMITED:
        problems += _limit_problems(joint, kind)
    return problems


def usable_limit(joint: Element, name: str) -> float:
    """Return an attribute of a joint's `limit`, 0 if it is not given or not finite."""
    limit = joint.find("limit")
    value = 0.0 if limit is None else as_number(limit.get(name, "0"))
    return value if math.isfinite(value) else 0.0


def _check_axis(joint: Entry) -> None:
    axis = joint.element.find("axis")
    values = joint.vector(axis, "xyz", "its axis", "1 0 0" if axis is None else "")
    if not any(values):
        raise joint.refusal("its axis is 0 0 0; it needs a direction, as 0 1 0; correct it", axis)


def _mimic_problems(joint: Entry) -> list[UrdfProblem]:
    mimic = joint.element.find("mimic")
    if mimic is None:
        return []
    text = (
        f"it mimics joint '{mimic.get('joint')}', which is not supported in a leg: every leg joint "
        "has its own motor; remove <mimic> there"
    )
    return [joint.problem("mimic", text, mimic)]


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


def _limit_problems(joint: Entry, kind: str) -> list[UrdfProblem]:
    limit = joint.element.find("limit")
    if limit is None:
        text = 'it has no limits; add <limit effort="" velocity="" lower="" upper=""/> with values'
        return [joint.problem(kind, text) for kind in ("effort", "velocity", "range")]
    length, force, speed = _UNITS[kind]
    problems = []
    for name, unit in (("effort", force), ("velocity", speed)):
        value = as_number(limit.get(name, "0"))
        text = f"the {name} limit is {limit.get(name)!r}; it must be above 0; give it [{unit}]"
        if math.isnan(value) or value < 0.0:
            raise joint.refusal(text, limit)
        if value in (0.0, math.inf):
            problems.append(joint.problem(name, text, limit))
    lower, upper = (as_number(limit.get(side, "0")) for side in ("lower", "upper"))
    text = f"the range is from {lower:g} to {upper:g} {length}; lower must be below upper"
    for side, value in (("lower", lower), ("upper", upper)):
        if math.isnan(value):
            wrong = f"{limit.get(side)!r}, which is no number; give it [{length}]"
            raise joint.refusal(f"the {side} limit is {wrong}", limit)
    if math.isnan(lower + upper):
        raise joint.refusal(text, limit)
    if not lower < upper:
        problems.append(joint.problem("range", text, limit))
    return problems
