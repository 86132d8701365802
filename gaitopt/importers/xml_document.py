"""XML with the line of every element, and the values in it, so that messages say where to look."""

from __future__ import annotations

import copy
import math
import re
from dataclasses import field
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gaitopt.bounds import SIZE
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.escape import printable

_LATE_DECLARATION = re.compile(r"\A\s+<\?xml\s.*?\?>", re.DOTALL)
_COMMENT = re.compile(r"<!--(.*?)-->", re.DOTALL)
_BLANKS = " \t\r\n"  # of XML; a no-break space, say, is none
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_NUMBER_WORDS = {1: "one", 3: "three", 4: "four"}
_INFINITE = re.compile(r"([+-]?)inf(inity)?", re.ASCII | re.IGNORECASE)


@dataclass(frozen=True, eq=False)
class XmlTree:
    """An XML document.

    Attributes:
        root: its outermost element.
        lines: line on which each element starts, counted from 1.
        files: name of the file that an element was included from; others are of the main one.
    """

    root: Element
    lines: dict[Element, int]
    files: dict[Element, str] = field(default_factory=dict)

    def line(self, element: Element) -> int:
        """Return the line on which an element starts, 0 if it is not of this document."""
        return self.lines.get(element, 0)

    def file(self, element: Element) -> str:
        """Return the name of the file that an element was included from, or an empty string."""
        return self.files.get(element, "")

    def copy(self) -> XmlTree:
        """Return a document of new elements that stand where the old ones do."""
        root = copy.deepcopy(self.root)
        pairs = list(zip(self.root.iter(), root.iter(), strict=True))
        lines = {new: self.lines[old] for old, new in pairs if old in self.lines}
        return XmlTree(root, lines, {new: self.files[o] for o, new in pairs if o in self.files})


def where(line: int, file: str = "") -> str:
    """Return a place in words, as "line 3 of 'legs.xml'"; the main file needs no name."""
    return f"line {line} of '{file}'" if file else f"line {line}"


def parse_xml(text: str, name: str = "the file") -> XmlTree:
    """Parse XML; prefixes of names are kept as written and need no declaration.

    What is not well-formed but is read by all readers of robots is read: blanks before the
    declaration, and dashes in comments.

    Raises:
        RobotError: the text is not well-formed, with line and column.
    """
    try:
        return _parse(text)
    except expat.ExpatError as error:
        # As many lines, the declaration first and no dashes in comments.
        mended = _LATE_DECLARATION.sub(lambda found: "\n" * found[0].count("\n"), text)
        mended = _COMMENT.sub(lambda found: f"<!--{found[1].replace('-', ' ')}-->", mended)
        try:
            return _parse(mended)
        except expat.ExpatError:
            raise RobotError(
                f"{name} is not well-formed XML: line {error.lineno}, column {error.offset + 1}: "
                f"{expat.ErrorString(error.code)}; correct that line"
            ) from None


def _parse(text: str) -> XmlTree:
    builder, parser = TreeBuilder(), expat.ParserCreate()
    lines: dict[Element, int] = {}

    def start(tag: str, attributes: dict[str, str]) -> None:
        lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.Parse(text, True)
    return XmlTree(builder.close(), lines)


@dataclass(frozen=True)
class FileProblem:
    """Something suspicious in a URDF that does not stop reading.

    Attributes:
        kind: "inertia" (no body can have it), "massless" (a joint moves links without mass),
            "effort", "velocity", "range" (limit not given, infinite, zero or empty), "torque"
            (motors that cannot turn a joint to both sides), "tied" (follows another joint), "mimic"
            (should, but cannot), "axis" (not given), "safety" (soft limits upside down), "free"
            (floating, planar, or in a closed loop of a URDF), "loop" (in one of an MJCF file),
            "held" (tied to the world), "shape" (cannot be drawn or touched), "name",
            "unknown" (not read), "placeholder" (of inertias) or "rotor".
        name: of the link ("inertia", "massless", "shape") or of the joint (all others).
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
class NamedElement:
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
            return f"{tag} of joint '{printable(self.element.attrib['joint'])}'"
        return f"<{tag}>" if name is None else f"{tag} '{printable(name)}'"

    def problem(self, kind: str, text: str, child: Element | None = None) -> FileProblem:
        """Return a problem of this link or joint, at the line of `child` if that is given."""
        at = self.element if child is None else child
        line, file = self.tree.line(at), self.tree.file(at)
        return FileProblem(kind, self.name, f"{self.title}: {text}", line, file)

    def refusal(self, text: str, child: Element | None = None) -> RobotError:
        """Return the error that says the same, to be raised."""
        return RobotError(str(self.problem("", text, child)))

    def number(self, child: Element | None, attribute: str, name: str, unit: str) -> float:
        """Return the number in an attribute of a child element.

        Raises:
            RobotError: the attribute is absent, or not a finite number, or one too large.
        """
        text = None if child is None else child.get(attribute)
        if text is None:
            raise self.refusal(f"no {name} is given; add it [{unit}]", child)
        value = as_number(text)
        if not abs(value) < SIZE:
            raise self.refusal(
                f"{name} is '{printable(text)}'; it must be a finite number{_below(value)} [{unit}]"
                f"{'' if math.isfinite(value) else number_hint(text)}; correct it",
                child,
            )
        return value

    def numbers(
        self, child: Element | None, attribute: str, name: str, count: int, default: str = ""
    ) -> tuple[float, ...]:
        """Return the numbers in an attribute, those of `default` if it is absent.

        Raises:
            RobotError: there are more or fewer, or one is not finite or too large.
        """
        text = default if child is None else child.get(attribute, default)
        values = as_numbers(text)
        if len(values) != count or not all(abs(value) < SIZE for value in values):
            bound = _below(*values)
            hint = "" if bound and all(map(math.isfinite, values)) else number_hint(text)
            raise self.refusal(
                f"{name} is '{printable(text)}'; it must be {_NUMBER_WORDS[count]} finite numbers"
                f"{bound}{hint}; correct it",
                child,
            )
        return values

    def vector(
        self, child: Element | None, attribute: str, name: str, default: str = "0 0 0"
    ) -> tuple[float, float, float]:
        """Return the three finite numbers in an attribute, those of `default` if it is absent.

        Raises:
            RobotError: they are not three finite numbers.
        """
        x, y, z = self.numbers(child, attribute, name, 3, default)
        return x, y, z


def _below(*values: float) -> str:
    """Return the bound of numbers, where finite ones are beyond it."""
    return f" below {SIZE:g}" if any(SIZE <= abs(value) < math.inf for value in values) else ""


def as_number(text: str) -> float:
    """Return the number a text holds, NaN if it holds none.

    Decimal digits, a point and an exponent count, with blanks about them, and `inf`: not what else
    Python's `float` takes (4_0, digits of other scripts) or C's does (0x10), for no two readers of
    robots agree about those.
    """
    text = text.strip(_BLANKS)
    if _NUMBER.fullmatch(text):
        return float(text)
    infinite = _INFINITE.fullmatch(text)
    return float(f"{infinite[1]}inf") if infinite else math.nan


def as_numbers(text: str) -> tuple[float, ...]:
    """Return the numbers of a text with blanks between them, NaN for what is none."""
    words = re.split(f"[{_BLANKS}]+", text.strip(_BLANKS))
    return tuple(map(as_number, words)) if words != [""] else ()


EXPAND = "expand the xacro macros first: xacro robot.urdf.xacro > robot.urdf"
"""What to do about a file that is not a robot's yet."""


def is_macro(text: str) -> bool:
    """Return whether a text is one that xacro replaces, as "$(find talos)/foot.stl"."""
    return "${" in text or "$(" in text


def number_hint(text: str) -> str:
    """Return how numbers are written, for a text that looks like some, else an empty string."""
    if is_macro(text):
        return f" ({EXPAND})"
    digits = any(c.isdigit() for c in text)
    return " in digits 0 to 9, as -1.5e-3, with blanks between numbers" if digits else ""
