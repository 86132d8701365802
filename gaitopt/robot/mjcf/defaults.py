"""The default classes of MJCF, and the torque limits that actuators give to joints."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry, as_number

_MAIN = "main"
_WITH_CLASS = ("worldbody", "actuator", "equality")
_BY_CONTROL = ("motor",)  # actuators whose control is their force


@dataclass(frozen=True)
class Defaults:
    """Attributes that elements have without saying so.

    Attributes:
        classes: by class name, by tag: attributes, with those of the enclosing classes.
    """

    classes: Mapping[str, Mapping[str, Mapping[str, str]]]

    @classmethod
    def of(cls, root: Element) -> Defaults:
        """Read the default classes of an MJCF document."""
        classes: dict[str, dict[str, dict[str, str]]] = {_MAIN: {}}
        for element in root.findall("default"):
            _read_class(element, element.get("class", _MAIN), classes[_MAIN], classes)
        return cls(classes)

    def complete(
        self, element: Element, childclass: str | None = None, tag: str = ""
    ) -> dict[str, str]:
        """Return the attributes of an element, its own and those of its class.

        Args:
            element: of the document.
            childclass: the class that holds where it stands.
            tag: under which its class has them, if not its own.
        """
        name = element.get("class") or childclass or _MAIN
        return {**self.classes[name].get(tag or element.tag, {}), **element.attrib}


def with_class(root: Element, tag: str) -> Iterator[tuple[Element, str | None]]:
    """Yield every joint (or what the tag says) of the bodies, with the class that holds there."""
    for world in root.findall("worldbody"):
        yield from _below(world, tag, None)


def check_classes(tree: XmlTree) -> None:
    """Refuse classes that no `default` defines: Pinocchio would pass over them.

    Raises:
        RobotError: naming the line, the element and the class.
    """
    known = Defaults.of(tree.root).classes
    sections = [e for tag in _WITH_CLASS for e in tree.root.findall(tag)]
    for element in [e for section in sections for e in section.iter()]:
        for attribute in ("class", "childclass"):
            name = element.get(attribute)
            if name is not None and name not in known:
                raise Entry(tree, element).refusal(
                    f"its class '{name}' is not defined; define it in <default>, or correct its "
                    "name"
                )


def with_torques(root: Element) -> Element:
    """Return a copy whose joints have the torque limits of their actuators.

    Pinocchio does not read those.

    The limit at the joint is the force range times the gear; for a motor also its control range
    times the gear. The narrowest counts.
    """
    root = copy.deepcopy(root)
    defaults = Defaults.of(root)
    limits = _actuator_limits(root, defaults)
    for joint, childclass in with_class(root, "joint"):
        own = _half_range(defaults.complete(joint, childclass).get("actuatorfrcrange", ""))
        found = [v for v in (own, limits.get(joint.get("name", ""), 0.0)) if v > 0.0]
        if found:
            joint.set("actuatorfrcrange", f"{-min(found)!r} {min(found)!r}")
    return root


def _actuator_limits(root: Element, defaults: Defaults) -> dict[str, float]:
    limits: dict[str, float] = {}
    for actuator in [e for section in root.findall("actuator") for e in section]:
        values = defaults.complete(actuator)
        ranges = ["forcerange", *(["ctrlrange"] if actuator.tag in _BY_CONTROL else [])]
        gear = abs(as_number((values.get("gear") or "1").split()[0]))
        found = [gear * _half_range(values.get(name, "")) for name in ranges]
        found = [value for value in found if value > 0.0]
        joint = values.get("joint", "")
        if joint and found:
            limits[joint] = min([*found, *([limits[joint]] if joint in limits else [])])
    return limits


def _half_range(text: str) -> float:
    """Return the smaller of the two sides of a range about zero; 0 if there is no such range."""
    sides = [as_number(word) for word in text.split()]
    return min(-sides[0], sides[1]) if len(sides) == 2 and sides[0] < 0.0 < sides[1] else 0.0


def _read_class(
    element: Element,
    name: str,
    inherited: Mapping[str, Mapping[str, str]],
    classes: dict[str, dict[str, dict[str, str]]],
) -> None:
    own = {tag: dict(attributes) for tag, attributes in inherited.items()}
    for entry in element:
        if entry.tag != "default":
            own[entry.tag] = {**own.get(entry.tag, {}), **entry.attrib}
    classes[name] = own
    for inner in element.findall("default"):
        _read_class(inner, inner.get("class", ""), own, classes)


def _below(body: Element, tag: str, childclass: str | None) -> Iterator[tuple[Element, str | None]]:
    inside = body.get("childclass") or childclass
    for element in body.findall(tag):
        yield element, inside
    for below in body.findall("body"):
        yield from _below(below, tag, inside)
