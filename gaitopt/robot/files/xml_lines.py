"""XML with the line of every element, so that a message can say where to look."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gaitopt.errors import RobotError


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

    Args:
        text: of the document.
        name: of the file, for messages.

    Raises:
        RobotError: the text is not well-formed, with line and column.
    """
    builder, parser = TreeBuilder(), expat.ParserCreate()
    lines: dict[Element, int] = {}

    def start(tag: str, attributes: dict[str, str]) -> None:
        lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise RobotError(
            f"{name} is not well-formed XML: line {error.lineno}, column {error.offset + 1}: "
            f"{expat.ErrorString(error.code)}; correct that line"
        ) from None
    return XmlTree(builder.close(), lines)
