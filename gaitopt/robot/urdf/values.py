"""Reading the values of a URDF: where they stand, whether they are numbers, what is odd."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from gaitopt.errors import RobotError
from gaitopt.robot.files.xml_lines import XmlTree, where


@dataclass(frozen=True)
class UrdfProblem:
    """Something suspicious in a URDF that does not stop reading.

    Attributes:
        kind: "inertia" (no body can have it), "massless" (a joint moves links without mass),
            "effort", "velocity", "range" (limit not given, infinite, zero or empty), "mimic" or
            "free" (floating, planar, or in a closed loop).
        name: of the link ("inertia", "massless") or of the joint (all others).
        text: one sentence: the value, what is allowed, what to do.
        line: in the file, counted from 1.
        file: name of the file that the robot's own includes, else empty.
    """

    kind: str
    name: str
    text: str
    line: int
    file: str = ""

    def __str__(self) -> str:
        """Return the sentence with its place before it."""
        return f"{where(self.line, self.file)}: {self.text}"


@dataclass(frozen=True, eq=False)
class Entry:
    """An element of a URDF or an MJCF file that messages speak of, mostly a link or a joint.

    Attributes:
        tree: the document.
        element: of it.
    """

    tree: XmlTree
    element: Element

    @property
    def name(self) -> str:
        """Its name."""
        return self.element.get("name", "")

    @property
    def title(self) -> str:
        """Its tag and name, as "joint 'left_knee'", or what it has in place of a name."""
        tag, name = self.element.tag, self.element.get("name")
        if name is None and "joint" in self.element.attrib:
            return f"{tag} of joint '{self.element.attrib['joint']}'"
        return f"<{tag}>" if name is None else f"{tag} '{name}'"

    def problem(self, kind: str, text: str, child: Element | None = None) -> UrdfProblem:
        """Return a problem of this link or joint, at the line of `child` if that is given."""
        at = self.element if child is None else child
        line, file = self.tree.line(at), self.tree.file(at)
        return UrdfProblem(kind, self.name, f"{self.title}: {text}", line, file)

    def refusal(self, text: str, child: Element | None = None) -> RobotError:
        """Return the error that says the same, to be raised."""
        return RobotError(str(self.problem("", text, child)))

    def number(self, child: Element | None, attribute: str, name: str, unit: str) -> float:
        """Return the finite number in an attribute of a child element.

        Args:
            child: the element, None if it is absent.
            attribute: that holds the number.
            name, unit: of the quantity, for messages.

        Raises:
            RobotError: the attribute is absent or not a finite number.
        """
        text = None if child is None else child.get(attribute)
        if text is None:
            raise self.refusal(f"no {name} is given; add it [{unit}]", child)
        value = as_number(text)
        if not math.isfinite(value):
            raise self.refusal(
                f"{name} is '{text}'; it must be a finite number [{unit}]; correct it", child
            )
        return value

    def vector(
        self, child: Element | None, attribute: str, name: str, default: str = "0 0 0"
    ) -> tuple[float, ...]:
        """Return the three finite numbers in an attribute, `default` if it is absent.

        Raises:
            RobotError: they are not three finite numbers.
        """
        text = default if child is None else child.get(attribute, default)
        values = tuple(as_number(word) for word in text.split())
        if len(values) != 3 or not all(math.isfinite(value) for value in values):
            raise self.refusal(
                f"{name} is '{text}'; it must be three finite numbers; correct it", child
            )
        return values


def as_number(text: str) -> float:
    """Return the number a text holds, NaN if it holds none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
