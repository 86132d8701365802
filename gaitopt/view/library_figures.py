"""The figure of a gait library: cost and peak torques over the swept quantity."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.study.index import Row, columns
from gaitopt.view.figure_style import label_axes, new_figure, styled
from gaitopt.view.figures import rendered

PEAK = "peak_torque."


def write_library_figure(rows: list[Row], axes: list[str], path: Path) -> Path:
    """Draw lines over the first quantity, one for each combination of the others.

    Args:
        rows: of the library's index.
        axes: names of the swept quantities.
        path: of the figure; its suffix chooses the form.

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
        figure = _figure(rows, axes)
    return write_atomically(path, rendered(figure, kind))


def _figure(rows: list[Row], axes: list[str]) -> Figure:
    figure = new_figure(8.0, 3.6)
    left, right = figure.subplots(1, 2)
    lines = _lines(rows, axes)
    for others, line in lines.items():
        _draw(left, line, axes[0], "cost", others)
    label_axes(left, axes[0], "cost (N²·m·s)", "Squared torque per metre")
    best = min(lines.values(), key=lambda line: min(float(str(r["cost"])) for r in line))
    for name in (n for n in columns(rows) if n.startswith(PEAK)):
        _draw(right, best, axes[0], name, name.removeprefix(PEAK).replace("_", " "))
    label_axes(right, axes[0], "peak torque (N·m)", "Motors of a leg")
    right.legend()
    if 1 < len(lines) <= 8:
        left.legend()
    return figure


def _lines(rows: list[Row], axes: list[str]) -> dict[str, list[Row]]:
    lines: dict[str, list[Row]] = {}
    for row in rows:
        others = ", ".join(f"{name} {row[name]:g}" for name in axes[1:])
        lines.setdefault(others, []).append(row)
    return lines


def _draw(axes: Axes, line: list[Row], x: str, y: str, label: str) -> None:
    kept = sorted((float(str(r[x])), float(str(r[y]))) for r in line if r.get(y) is not None)
    axes.plot([a for a, _ in kept], [b for _, b in kept], marker=".", label=label or None)
