"""Texts from files made fit to be shown: what would steer a terminal or a page is escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping

_MARK = re.compile(r"@[A-Z]+@")


def printable(text: str) -> str:
    """Return a text with what cannot be seen on a screen in the notation of Python."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def printable_lines(text: str) -> str:
    """Return a text of several lines, each of them printable."""
    return text if text.isprintable() else "\n".join(map(printable, text.split("\n")))


def html_text(text: object) -> str:
    """Return a text for a page: printable, and with no meaning in HTML."""
    return html.escape(printable(str(text)))


def filled_template(template: str, parts: Mapping[str, str]) -> str:
    """Return a template with its marks, @NAME@, replaced once: those in the parts stay."""
    return _MARK.sub(lambda mark: parts.get(mark[0], mark[0]), template)
