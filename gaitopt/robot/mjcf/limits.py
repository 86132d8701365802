"""The limits of the joints of MJCF: which ranges count, and those that actuators give."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from xml.etree.ElementTree import Element

from gaitopt.robot.mjcf.defaults import Defaults, with_class
from gaitopt.robot.urdf.values import as_number

_BY_CONTROL = ("motor",)  # actuators whose control is their force


def limits_itself(root: Element) -> bool:
    """Return whether a range counts that is given without saying so (`autolimits`)."""
    return all(c.get("autolimits") != "false" for c in root.findall("compiler"))


def range_in_force(values: Mapping[str, str], name: str, automatic: bool) -> str:
    """Return a range as it is written, empty if it is absent or does not count.

    As in MuJoCo, the attribute `limited` (`ctrllimited` and so on) decides; where that is not
    given, a range counts unless it is 0 0.

    Args:
        values: attributes of a joint or an actuator, with those of its class.
        name: of the attribute that holds the range.
        automatic: see `limits_itself`.
    """
    text = values.get(name, "")
    limited = values.get(f"{name.removesuffix('range')}limited", "auto")
    if limited == "auto":
        counts = automatic and any(as_number(word) != 0.0 for word in text.split())
        return text if counts else ""
    return text if limited == "true" else ""


def with_limits(root: Element) -> Element:
    """Return a copy whose joints say themselves which limits they have.

    Pinocchio reads every range, also one that does not count, and none of an actuator.

    The torque limit at the joint is the force range of an actuator times the gear; for a motor also
    its control range times the gear. The narrowest counts.
    """
    root = copy.deepcopy(root)
    defaults, automatic = Defaults.of(root), limits_itself(root)
    limits = _actuator_limits(root, defaults, automatic)
    for joint, childclass in with_class(root, "joint"):
        values = defaults.complete(joint, childclass)
        _write(joint, "range", range_in_force(values, "range", automatic))
        torque = range_in_force(values, "actuatorfrcrange", automatic)
        both = (_half_range(torque), limits.get(joint.get("name", ""), 0.0))
        found = [value for value in both if value > 0.0]
        if found:
            torque = f"{-min(found)!r} {min(found)!r}"
        _write(joint, "actuatorfrcrange", torque)
    for joint in [e for default in root.findall("default") for e in default.iter("joint")]:
        for name in ("range", "actuatorfrcrange"):
            _write(joint, name, "")
    return root


def _write(joint: Element, name: str, text: str) -> None:
    """Give a joint a range that counts; none if the text is empty."""
    limited = f"{name.removesuffix('range')}limited"
    for attribute in (name, limited):
        joint.attrib.pop(attribute, None)
    if text:
        joint.attrib.update({name: text, limited: "true"})


def _actuator_limits(root: Element, defaults: Defaults, automatic: bool) -> dict[str, float]:
    limits: dict[str, float] = {}
    for actuator in [e for section in root.findall("actuator") for e in section]:
        values = defaults.complete(actuator)
        ranges = ["forcerange", *(["ctrlrange"] if actuator.tag in _BY_CONTROL else [])]
        gear = abs(as_number((values.get("gear") or "1").split()[0]))
        found = [gear * _half_range(range_in_force(values, name, automatic)) for name in ranges]
        found = [value for value in found if value > 0.0]
        joint = values.get("joint", "")
        if joint and found:
            limits[joint] = min([*found, *([limits[joint]] if joint in limits else [])])
    return limits


def _half_range(text: str) -> float:
    """Return the smaller of the two sides of a range about zero; 0 if there is no such range."""
    sides = [as_number(word) for word in text.split()]
    return min(-sides[0], sides[1]) if len(sides) == 2 and sides[0] < 0.0 < sides[1] else 0.0
