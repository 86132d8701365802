"""Tables on the terminal: their form, figures with units, shares of limits."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

BAR = 6
"""Characters of a full bar."""
_AT_LIMIT, _NEAR_LIMIT = 0.999, 0.8
ABSENT = "-"
ZERO = 1e-6  # of any unit: the tolerance of the certificate on a scaled limit


def new_table(title: str, *columns: str) -> Table:
    """Return an empty table; a column's name is its header, with ">" before it if it holds numbers.

    A header may have a second line, for the unit.
    """
    table = Table(
        title=title, title_justify="left", title_style="bold", header_style="dim",
        box=SIMPLE_HEAD, pad_edge=False, show_edge=False, expand=True, padding=(0, 1, 0, 0),
    )  # fmt: skip
    for name in columns:
        table.add_column(
            Text(name.removeprefix(">")),
            justify="right" if name.startswith(">") else "left",
            overflow="fold",
        )
    return table


def number(value: float | None, unit: str, digits: int = 3) -> str:
    """Return a number with significant digits and unit, or a dash."""
    if value is None:
        return ABSENT
    return f"{value:.{digits}g} {unit}".rstrip()


def fixed(value: float | None, decimals: int) -> str:
    """Return a number with a fixed number of decimals, or a dash."""
    return ABSENT if value is None else f"{value:.{decimals}f}"


def rounded(value: float) -> str:
    """Return a number with four digits; one that is zero but for the solver's tolerance as 0."""
    return "0" if abs(value) < ZERO else f"{value:.4g}"


def bar(used: float | None, limit: float | None, length: int = BAR) -> Text:
    """Return the share of a limit as a bar, a percentage, and the limit.

    Args:
        used: share of the limit.
        limit: in the unit of the column.
        length: characters of a full bar; 0 where there is no room for one.
    """
    if used is None or limit is None:
        return Text("no limit", style="dim")
    full = min(length, round(length * used))
    text = Text("━" * full, style=shade(used))
    text.append("─" * (length - full), style="dim")
    text.append(f"{' ' if length else ''}{100.0 * used:3.0f} %", style=shade(used))
    text.append(f" of {limit:g}", style="dim")
    return text


def share(used: float | None, limit: float | None) -> Text:
    """Return a quantity with its limit: 0.31 of 0.7."""
    if used is None:
        return Text(ABSENT)
    if limit is None:
        return Text(f"{used:.3f}")
    return Text(f"{used:.3f} of {limit:g}", style=shade(used / limit))


def shade(used: float) -> str:
    """Return the colour of a share of a limit."""
    if used >= _AT_LIMIT:
        return "bold red"
    return "yellow" if used >= _NEAR_LIMIT else "green"
