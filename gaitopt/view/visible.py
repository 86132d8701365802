"""Texts from files, made fit to be shown: what would steer a terminal or a page becomes visible."""

from __future__ import annotations

import html
import re
import unicodedata
from collections.abc import Mapping

_MARK = re.compile(r"@[A-Z]+@")
_HIDDEN = ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")  # control, format, surrogates, line breaks


def visible(text: str) -> str:
    """Return a text with control characters, invisible ones and line breaks as escapes."""
    if text.isprintable():
        return text
    return "".join(c if unicodedata.category(c) not in _HIDDEN else _escape(c) for c in text)


def visible_lines(text: str) -> str:
    """Return a text of several lines, each of them visible."""
    return text if text.isprintable() else "\n".join(map(visible, text.split("\n")))


def on_page(text: object) -> str:
    """Return a text for a page: visible, and with no meaning in HTML."""
    return html.escape(visible(str(text)))


def filled(template: str, parts: Mapping[str, str]) -> str:
    """Return a template with its marks, @NAME@, replaced once: those in the parts stay."""
    return _MARK.sub(lambda mark: parts.get(mark[0], mark[0]), template)


def _escape(character: str) -> str:
    return character.encode("unicode_escape", "backslashreplace").decode("ascii")
