"""MJCF files that include others, made one document that knows where everything came from."""

from __future__ import annotations

from pathlib import Path
from xml.etree.ElementTree import Element

from gaitopt.errors import RobotError
from gaitopt.robot.files.text_file import read_text
from gaitopt.robot.files.xml_lines import XmlTree, parse_xml, where

_DEEPEST = 10  # levels of included files; more is a circle


def whole_mjcf(tree: XmlTree, base: Path | None) -> XmlTree:
    """Return a document with the included files merged, one section of each kind.

    Args:
        tree: of the main file.
        base: directory of the main file, None for text.

    Raises:
        RobotError: an included file cannot be read, or includes itself.
    """
    whole = tree.copy()
    root = whole.root
    _include(whole, root, base, 0)
    for section in list(root):
        first = root.find(section.tag)
        if first is not None and first is not section:
            first.extend(list(section))
            first.attrib.update(section.attrib)
            root.remove(section)
    return whole


def _include(whole: XmlTree, parent: Element, base: Path | None, depth: int) -> None:
    """Put the contents of included files in the place of every `include` below an element."""
    for index, element in reversed(list(enumerate(parent))):
        if element.tag != "include":
            _include(whole, element, base, depth)
            continue
        included = _included(whole, element, base, depth)
        whole.lines.update(included.lines)
        whole.files.update(included.files)
        parent.remove(element)
        for offset, entry in enumerate(included.root):
            parent.insert(index + offset, entry)


def _included(whole: XmlTree, element: Element, base: Path | None, depth: int) -> XmlTree:
    """Return the document that an `include` names, whole itself."""
    name = element.get("file", "")
    if depth == _DEEPEST or base is None:
        why = "it is read as text" if base is None else "too many levels"
        at = where(whole.line(element), whole.file(element))
        raise RobotError(f"{at}: cannot include '{name}': {why}; give one whole file")
    text = read_text(base / name, "included file")
    found = parse_xml(text, f"the included file '{name}'")
    found.files.update(dict.fromkeys(found.lines, name))
    _include(found, found.root, base, depth + 1)
    return found
