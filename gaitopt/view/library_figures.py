"""The figure of a gait library: cost and peak torques over the swept quantity."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.constraint import declared_margins
from gaitopt.gait.constraints import Margins
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.parameters import GEOMETRY
from gaitopt.nlp import Array
from gaitopt.sweep.table import Row, columns
from gaitopt.view.branches import branch_cuts
from gaitopt.view.figure_style import label_axes, name_on_figure, new_figure, styled
from gaitopt.view.figures import rendered

PEAK = "peak_torque."
PAPER = (TorqueCost().words, TorqueCost().unit)
MOST = 8  # lines that are told apart in a legend

_GAP = "a gap in the lines: the gaits on its two sides are different kinds of optima"
_UNITS = {quantity.name: quantity.unit for quantity in GEOMETRY} | {
    "speed": "m/s",
    "penalty_weight": "N²·s/m",
    **{name: one.unit or "-" for name, one in declared_margins(Margins).items()},
}


def write_library_figure(
    rows: list[Row], axes: list[str], path: Path, cost: tuple[str, str] = PAPER
) -> Path:
    """Draw lines over the first quantity, one for each combination of the others.

    The motors are those of the line with the least cost. A line is interrupted where its gaits
    change from one family of optima to another.

    Args:
        rows: of the library's index.
        axes: names of the swept quantities.
        path: of the figure; its suffix chooses the form.
        cost: words and unit of the cost.

    Returns:
        The path written.

    Raises:
        InputError: there is no gait to draw, or the file cannot be written.
    """
    rows = [row for row in rows if row.get("cost") is not None]
    kind = path.suffix.removeprefix(".").lower()
    if not rows:
        raise InputError("there is no gait to draw; give other conditions")
    if kind not in ("png", "svg", "pdf"):
        raise InputError(f"'{path}' is no figure; give a name that ends in .png, .svg or .pdf")
    with styled():
        figure = _figure(rows, axes, cost)
    return write_atomically(path, rendered(figure, kind))


def _figure(rows: list[Row], axes: list[str], cost: tuple[str, str] = PAPER) -> Figure:
    figure = new_figure(9.5, 3.8)
    left, right = figure.subplots(1, 2)
    lines = _lines(rows, axes)
    motors = [name for name in columns(rows) if name.startswith(PEAK)]
    cuts = {others: branch_cuts(_table(line, motors)) for others, line in lines.items()}
    for others, line in lines.items():
        _draw(left, line, (axes[0], "cost"), others, cuts[others])
    best = min(lines, key=lambda others: _table(lines[others], ["cost"]).min())
    for name in motors:
        label = name_on_figure(name.removeprefix(PEAK).replace("_", " "))
        _draw(right, lines[best], (axes[0], name), label, cuts[best])
    swept = f"{axes[0]} [{_UNITS[axes[0]]}]" if axes[0] in _UNITS else axes[0]
    words, unit = cost
    label_axes(left, swept, f"cost [{unit}]", words[:1].upper() + words[1:])
    label_axes(right, swept, "peak torque [N·m]", f"Motors of a leg{best and ', '}{best}")
    for panel in (left, right) if 1 < len(lines) <= MOST else (right,):
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    if any(cuts.values()):
        figure.supxlabel(_GAP, fontsize=8.0)
    return figure


def _lines(rows: list[Row], axes: list[str]) -> dict[str, list[Row]]:
    """Return the rows of each line, in the order of the first quantity."""
    first, *more = axes
    lines: dict[str, list[Row]] = {}
    for row in sorted(rows, key=lambda row: [float(str(row[name])) for name in (*more, first)]):
        others = ", ".join(f"{name} {row[name]:g}" for name in more)
        lines.setdefault(others, []).append(row)
    return lines


def _table(line: list[Row], names: list[str]) -> Array:
    """Return columns of a line as numbers (rows, names), NaN where there is none."""
    cells = [[row.get(name) for name in names] for row in line]
    return np.array([[np.nan if c in (None, "") else float(str(c)) for c in row] for row in cells])


def _draw(axes: Axes, line: list[Row], names: tuple[str, str], label: str, cuts: list[int]) -> None:
    """Draw a line, interrupted before the rows `cuts`."""
    points = np.insert(_table(line, list(names)), cuts, np.nan, axis=0)
    axes.plot(*points.T, marker=".", label=label or None)
