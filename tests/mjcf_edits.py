"""Small edits of an MJCF document, to make robots that are wrong in one known way."""

from collections.abc import Callable
from xml.etree import ElementTree as ET

Edit = Callable[[ET.Element], None]


def edited(text: str, edit: Edit) -> str:
    """The text, every element on a line of its own, after an edit of its root."""
    root = ET.fromstring(text)
    edit(root)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def at(path: str, /, **values: str | None) -> Edit:
    """An edit that sets attributes of the first element of a path; None removes one."""

    def edit(root: ET.Element) -> None:
        element = root.find(path)
        for key, value in values.items():
            element.attrib.pop(key, None)
            if value is not None:
                element.set(key, value)

    return edit


def added(path: str, *texts: str | bytes) -> Edit:
    """An edit that adds elements to the first element of a path."""
    return lambda root: root.find(path).extend(ET.fromstring(text) for text in texts)


def together(*edits: Edit) -> Edit:
    def edit(root: ET.Element) -> None:
        for each in edits:
            each(root)

    return edit
