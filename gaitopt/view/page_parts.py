"""What pages are made of: their text, which a notebook shows in a frame, and their tables."""

from __future__ import annotations

import html

from gaitopt.dataclass import dataclass
from gaitopt.escape import html_text

_HEIGHT = 640  # pixels of a frame
_SHORT = 24  # characters; a longer text may be broken
_SHORT_NUMBER = 12  # characters of a number with its unit, which stay together


class Page(str):
    """The text of a page; a notebook shows the page."""

    __slots__ = ()

    def __repr__(self) -> str:
        """Return its size: the whole of it is megabytes long."""
        return f"<Page of {len(self.encode()) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        """Return it in a frame, so that page and notebook have their own styles and names."""
        return (
            f'<iframe srcdoc="{html.escape(self)}" style="width: 100%; height: {_HEIGHT}px; '
            'border: 0" allowfullscreen></iframe>'
        )


@dataclass(frozen=True)
class Section:
    """One table.

    Attributes:
        title: of the table.
        columns: their headers, ">" before those that hold numbers.
        rows: texts.
        how: for each row the `how` of its finding; empty if all are facts.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    how: tuple[str, ...] = ()


def table_text(section: Section) -> str:
    """Return a section as a heading and a table of a page."""
    classes = [' class="number"' if name.startswith(">") else "" for name in section.columns]
    heads = "".join(
        f"<th{kind}>{_lines(name.removeprefix('>'))}</th>"
        for kind, name in zip(classes, section.columns, strict=True)
    )
    how = section.how or ("",) * len(section.rows)
    rows = "".join(
        f'<tr class="{sure}">{_cells(row, classes)}</tr>'
        for row, sure in zip(section.rows, how, strict=True)
    )
    head = f"<tr>{heads}</tr>" if any(section.columns) else ""
    table = f'<div class="table"><table>{head}{rows}</table></div>'
    return f"<h2>{html_text(section.title)}</h2>{table}"


def _cells(row: tuple[str, ...], classes: list[str]) -> str:
    return "".join(
        f"<td{_kind(cell, kind)}>{_lines(cell)}</td>"
        for kind, cell in zip(classes, row, strict=True)
    )


def _kind(cell: str, kind: str) -> str:
    if kind:
        return ' class="number short"' if len(cell) < _SHORT_NUMBER else kind
    return ' class="short"' if len(cell) < _SHORT else ""


def _lines(text: str) -> str:
    return "<br>".join(map(html_text, text.splitlines()))
