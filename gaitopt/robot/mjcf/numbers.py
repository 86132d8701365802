"""Whether the numbers of an MJCF file are numbers, as many as they must be, and possible.

Pinocchio takes what it can read of an attribute and leaves the rest of the memory as it was.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry, as_number

_ANGLE = "rad or degrees, as <compiler> says"
_WORDS = {1: "one", 2: "two", 3: "three", 4: "four", 6: "six"}


@dataclass(frozen=True)
class _Rule:
    """What the numbers of an attribute must be.

    Attributes:
        most: how many there may be; 0 for any number.
        least: how many there must be; 0 for as many as there may be.
        unit: of them, empty if it is none or depends.
        positive: none may be below zero.
        ordered: the second may not be below the first.
        direction: so many of them, from the first, may not all be zero.
        plane: the second three may not be along the first.
        example: of a direction.
    """

    most: int
    unit: str = ""
    least: int = 0
    positive: bool = False
    ordered: bool = False
    direction: int = 0
    plane: bool = False
    example: str = ""

    def fault(self, text: str) -> str:
        """Return what is wrong with the text of an attribute and what is allowed, or nothing."""
        values = [as_number(word) for word in text.split()]
        unit = f" [{self.unit}]" if self.unit else ""
        few = len(values) < max(self.least or self.most, 1)
        if few or (self.most and len(values) > self.most) or not all(map(math.isfinite, values)):
            return f"is '{text}'; it must be {self._count()}{unit}; correct it"
        if self.positive and min(values) < 0.0:
            return f"is '{text}'; it must not be below 0{unit}; correct it"
        if self.ordered and values[0] > values[1]:
            return f"is '{text}'; the second must not be below the first{unit}; correct it"
        if self.direction and not any(values[: self.direction]):
            return f"is {text}; it needs a direction, as {self.example}; correct it"
        if self.plane and not np.cross(values[:3], values[3:]).any():
            return f"is {text}; it needs two directions, as {self.example}; correct it"
        return ""

    def _count(self) -> str:
        if self.most == 1:
            return "a finite number"
        if not self.most:
            return "finite numbers"
        span = f"{_WORDS[self.least]} to " if self.least else ""
        return f"{span}{_WORDS[self.most]} finite numbers"


_PLACE = {
    "pos": _Rule(3, "m"),
    "quat": _Rule(4, direction=4, example="1 0 0 0"),
    "axisangle": _Rule(4, direction=3, example="0 0 1 0.5"),
    "euler": _Rule(3, _ANGLE),
    "xyaxes": _Rule(6, direction=3, plane=True, example="1 0 0 0 1 0"),
    "zaxis": _Rule(3, direction=3, example="0 0 1"),
}
_SHAPE = {**_PLACE, "size": _Rule(3, "m", least=1, positive=True), "fromto": _Rule(6, "m")}
_LOSS = _Rule(3, least=1, positive=True)
_FORCE = _Rule(2, "N·m or N", ordered=True)
_ACTUATOR = {
    "gear": _Rule(6, least=1),
    "ctrlrange": _Rule(2, ordered=True),
    "forcerange": _FORCE,
}
ACTUATORS = (
    "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion",
    "general", "dcmotor",
)  # fmt: skip
"""Tags of what moves joints."""
_RULES: Mapping[str, Mapping[str, _Rule]] = {
    "body": _PLACE,
    "inertial": {
        **_PLACE,
        "mass": _Rule(1, "kg"),
        "diaginertia": _Rule(3, "kg·m²"),
        "fullinertia": _Rule(6, "kg·m²"),
    },
    "joint": {
        "pos": _Rule(3, "m"),
        "axis": _Rule(3, direction=3, example="0 1 0"),
        "range": _Rule(2, _ANGLE),
        "ref": _Rule(1, _ANGLE),
        "springref": _Rule(1, _ANGLE),
        "armature": _Rule(1, "kg·m² or kg", positive=True),
        "damping": _LOSS,
        "frictionloss": _LOSS,
        "stiffness": _Rule(3, least=1),
        "actuatorfrcrange": _FORCE,
    },
    "geom": {
        **_SHAPE,
        "mass": _Rule(1, "kg", positive=True),
        "density": _Rule(1, "kg/m³", positive=True),
    },
    "site": _SHAPE,
    "camera": _PLACE,
    "mesh": {
        "scale": _Rule(3),
        "refpos": _Rule(3, "m"),
        "refquat": _Rule(4, direction=4, example="1 0 0 0"),
    },
    "compiler": {
        "boundmass": _Rule(1, "kg", positive=True),
        "boundinertia": _Rule(1, "kg·m²", positive=True),
        "settotalmass": _Rule(1, "kg"),
    },
    **dict.fromkeys(ACTUATORS, _ACTUATOR),
}


def check_numbers(tree: XmlTree, robot: Element) -> None:
    """Check the numbers of the robot, of the default classes and of what else is read.

    Args:
        tree: of a whole document.
        robot: its body that moves.

    Raises:
        RobotError: naming the line, the element, what stands there and what is allowed.
    """
    for element in tree.root.findall("compiler"):
        _check(Entry(tree, element), element)
    for section in ("default", "asset", "actuator"):
        for outer in tree.root.findall(section):
            for owner, element in _owned(outer):
                _check(Entry(tree, owner), element)
    for owner, element in _owned(robot):
        _check(Entry(tree, owner), element)


def _owned(outer: Element) -> Iterator[tuple[Element, Element]]:
    """Yield the elements of a section or body, each with the one that messages name.

    That is itself, but the body of what is found by that.
    """
    if outer.tag == "body":
        yield outer, outer
    for element in outer:
        if element.tag == outer.tag:
            yield from _owned(element)
        elif outer.tag == "body" and element.tag != "joint":
            yield outer, element
        else:
            yield element, element


def _check(owner: Entry, element: Element) -> None:
    for attribute, rule in _RULES.get(element.tag, {}).items():
        text = element.get(attribute)
        fault = "" if text is None else rule.fault(text)
        if fault:
            its = "its" if element is owner.element else f"the {element.tag}'s"
            raise owner.refusal(f"{its} {attribute} {fault}", element)
