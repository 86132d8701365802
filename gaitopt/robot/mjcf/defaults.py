"""The default classes of MJCF: attributes that elements have without saying so."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from gaitopt.robot.files.xml_lines import XmlTree
from gaitopt.robot.urdf.values import Entry

MAIN = "main"
"""Name of the outermost class, which need not be written."""
_WITH_CLASS = ("worldbody", "actuator", "equality")


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
        classes: dict[str, dict[str, dict[str, str]]] = {MAIN: {}}
        for element in root.findall("default"):
            _read_class(element, element.get("class", MAIN), classes[MAIN], classes)
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
        name = element.get("class") or childclass or MAIN
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
