"""XML with the line of every element, so that a message can say where to look."""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gaitopt.errors import RobotError


@dataclass(frozen=True, eq=False)
class XmlTree:
    """An XML document.

    Attributes:
        root: its outermost element.
        lines: line on which each element starts, counted from 1.
    """

    root: Element
    lines: dict[Element, int]

    def line(self, element: Element) -> int:
        """Return the line on which an element starts, 0 if it is not of this document."""
        return self.lines.get(element, 0)


def parse_xml(text: str) -> XmlTree:
    """Parse XML; prefixes of names are kept as written and need no declaration.

    Args:
        text: of the document.

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
            f"the file is not well-formed XML: line {error.lineno}, column {error.offset + 1}: "
            f"{expat.ErrorString(error.code)}; correct that line"
        ) from None
    return XmlTree(builder.close(), lines)
