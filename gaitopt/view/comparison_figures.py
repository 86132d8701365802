"""Figures that compare: libraries over the swept quantity, solvers on one walk, gaits by motor.

That of a motor shows torque over speed: the loop that it runs through in a stride of each gait.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.actuators.motors import JointMotor, MotorTable
from gaitopt.design.requirements import MotorLoop
from gaitopt.errors import InputError
from gaitopt.gait.costs import TorqueCost
from gaitopt.nlp import Array, Solution
from gaitopt.sweep.table import Row, columns, unit_of
from gaitopt.tolerances import OPTIMALITY
from gaitopt.units import RPM, motion_words
from gaitopt.view.figure_style import (
    GREY,
    LIMIT,
    label_axes,
    name_on_figure,
    new_figure,
)

_HALF = 0.5  # of its range: a larger jump of a motor between neighbours may be a change of family
_STEEPER = 3.0  # times the motor's other steps: less may be a steep curve
_LARGE = 0.25  # of the largest torque: motors that vary less do not decide

PAPER = (TorqueCost().words, TorqueCost().unit)
PEAK = "peak_torque."
MOST = 8  # lines, or gaits, that are told apart in a legend

_GAP = "a gap in the lines: the gaits on its two sides are different kinds of optima"
_LEAST = 1e-10  # what is smaller is drawn there
_STYLES = ("-", "--")  # of the first and of the second library


def library_figure(
    libraries: Mapping[str, list[Row]], axes: list[str], cost: tuple[str, str] = PAPER
) -> Figure:
    """Draw lines over the first quantity, one for each combination of the others.

    The motors are those of the line with the least cost. A line is interrupted where its gaits
    change from one family of optima to another. The lines of a second library are dashed.

    Args:
        libraries: rows of one or two, by a name for the legend.
        cost: words and unit of the cost.

    Raises:
        InputError: there is no gait to draw.
    """
    known = [[row for row in rows if row.get("cost") is not None] for rows in libraries.values()]
    if not all(known):
        raise InputError("there is no gait to draw; give other conditions")
    figure = new_figure(9.5, 3.8)
    left, right = figure.subplots(1, 2)
    drawn = [
        _draw_library((left, right), rows, axes, name, style)
        for name, rows, style in zip(libraries, known, _STYLES, strict=False)
    ]
    counts, best, cut = zip(*drawn, strict=True)
    swept = f"{axes[0]} [{unit}]" if (unit := unit_of(axes[0])) else axes[0]
    whose = f"Motors of a leg{best[0] and ', '}{best[0]}"
    for name in list(libraries)[1:]:
        whose += f"; dashed: {name_on_figure(name)}"
    words, unit = cost
    label_axes(left, swept, f"cost [{unit}]", words[:1].upper() + words[1:])
    label_axes(right, swept, "peak torque [N·m]", whose)
    for panel in (left, right) if 1 < sum(counts) <= MOST else (right,):
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    if any(cut):
        figure.supxlabel(_GAP, fontsize=8.0)
    return figure


def _draw_library(
    panels: tuple[Axes, Axes], rows: list[Row], axes: list[str], name: str, style: str
) -> tuple[int, str, bool]:
    """Return how many lines it has, the one with the least cost, and whether one is interrupted."""
    left, right = panels
    for panel in panels:
        panel.set_prop_cycle(None)  # the same colours for both libraries
    lines = _lines(rows, axes)
    motors = [column for column in columns(rows) if column.startswith(PEAK)]
    cuts = {others: branch_cuts(_table(line, motors)) for others, line in lines.items()}
    for others, line in lines.items():
        label = ", ".join(filter(None, (name_on_figure(name), others)))
        _draw_line(left, line, (axes[0], "cost"), label, cuts[others], style)
    best = min(lines, key=lambda others: _table(lines[others], ["cost"]).min())
    for motor in motors:
        label = name_on_figure(motor.removeprefix(PEAK).replace("_", " "))
        label = label if style == _STYLES[0] else ""
        _draw_line(right, lines[best], (axes[0], motor), label, cuts[best], style)
    return len(lines), best, any(cuts.values())


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


def _draw_line(
    axes: Axes, line: list[Row], names: tuple[str, str], label: str, cuts: list[int], style: str
) -> None:
    """Draw a line, interrupted before the rows `cuts`."""
    points = np.insert(_table(line, list(names)), cuts, np.nan, axis=0)
    axes.plot(*points.T, style, marker=".", label=label or None)


def branch_cuts(torques: Array) -> list[int]:
    """Return the rows before which a family of optima ends.

    One does where the peak torque of a motor jumps by more than half of its range, and by far more
    than between any other neighbours; a few gaits far apart cannot tell, and are left together.

    Args:
        torques: peaks of the motors of neighbouring gaits [N·m], shape (gaits, motors); a motor
            with a NaN is passed over.
    """
    known = torques[:, np.isfinite(torques).all(axis=0)]
    if known.shape[0] < 3 or known.shape[1] == 0:
        return []
    spread = np.ptp(known, axis=0)
    steps = np.abs(np.diff(known, axis=0))
    jumps = steps > _HALF * spread
    others = np.where(jumps, 0.0, steps).max(axis=0)
    decides = spread > _LARGE * np.abs(known).max()
    found = jumps & (steps > _STEEPER * others) & (others > 0.0) & decides
    return [int(row) + 1 for row in np.flatnonzero(found.any(axis=1))]


def convergence_figure(runs: Sequence[Solution]) -> Figure:
    """Draw optimality and violation of every iterate of every solver."""
    figure = new_figure(9.5, 3.8)
    optimality, violation = figure.subplots(1, 2, sharey=True)
    for run in runs:
        seconds = np.array([one.seconds for one in run.history])
        _draw_errors(optimality, seconds, [one.optimality for one in run.history], run.solver)
        _draw_errors(violation, seconds, [one.violation for one in run.history], run.solver)
    label_axes(optimality, "time [s]", "scaled", "Gradient of the Lagrangian, complementarity")
    label_axes(violation, "time [s]", "", "Largest violation of a limit")
    optimality.axhline(OPTIMALITY, color=LIMIT, linestyle="--", linewidth=1.0)
    violation.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _draw_errors(panel: Axes, seconds: Array, values: Sequence[float], name: str) -> None:
    panel.set_xscale("symlog", linthresh=1.0)
    panel.set_yscale("log")
    panel.plot(seconds, np.maximum(values, _LEAST), marker=".", markersize=3.0, label=name)


_COLUMNS = 3
_WIDTH, _HEIGHT = 3.2, 2.6  # inch, of a panel
_AT_ONCE = 1e-9  # of a stride: two instants so close are one, before and after a jump
_LINE = 201  # points of a line of the envelope


def torque_speed_figure(
    loops: Mapping[str, Sequence[MotorLoop]], table: MotorTable | None = None
) -> Figure:
    """Draw the loops of every motor, a panel each, a line for each gait.

    Args:
        loops: of the motors, by label of the gait; the same motors in each.
        table: motors whose envelopes are drawn around the loops.
    """
    first = next(iter(loops.values()))
    motors = [one.motor for one in first]
    columns = min(_COLUMNS, len(motors))
    rows = -(-len(motors) // columns)
    figure = new_figure(_WIDTH * columns, _HEIGHT * rows + 0.3)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, (motor, panel) in enumerate(zip(motors, panels, strict=False)):
        slides = first[k].slides
        unit, size = ("m/s", 1.0) if slides else ("rpm", RPM)
        for label, of in loops.items():
            _draw_loop(panel, of[k], size, name_on_figure(label))
        drive = None if table is None else first[k].drive(table)
        if drive is not None:
            _draw_envelope(panel, drive.at_joint())
        _draw_limits(panel, first[k], size)
        panel.axhline(0.0, color=GREY, linewidth=0.6)
        panel.axvline(0.0, color=GREY, linewidth=0.6)
        torque = motion_words("torque [N·m]", slides=slides)
        label_axes(panel, f"speed [{unit}]", torque, name_on_figure(motor))
    for panel in panels[len(motors) :]:
        panel.set_axis_off()
    if 1 < len(loops) <= MOST or (table is not None and len(loops) <= MOST):
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_loop(panel: Axes, loop: MotorLoop, size: float, label: str) -> None:
    """Draw torque over speed, dotted where an impact, or a change of contact, makes them jump."""
    curve = np.stack([loop.rate / size, loop.torque])
    after = np.append(np.flatnonzero(np.diff(loop.time) <= _AT_ONCE * loop.time[-1]) + 1, 0)
    (line,) = panel.plot(*np.insert(curve, after[:-1], np.nan, axis=1), linewidth=1.1, label=label)
    apart = np.full((2, after.size), np.nan)
    jumps = np.stack([curve[:, after - 1], curve[:, after], apart], axis=2)  # the last closes it
    panel.plot(*jumps.reshape(2, -1), color=line.get_color(), linestyle=":", linewidth=0.9)


def _draw_limits(panel: Axes, loop: MotorLoop, size: float) -> None:
    """Draw the limits of a motor's torque and speed, that in units of a size [rad/s; m/s]."""
    for sign in (-1.0, 1.0):
        if loop.torque_limit is not None:
            panel.axhline(sign * loop.torque_limit, color=LIMIT, linewidth=1.0)
        if loop.speed_limit is not None:
            panel.axvline(sign * loop.speed_limit / size, color=LIMIT, linewidth=1.0)


def _draw_envelope(panel: Axes, motor: JointMotor) -> None:
    """Draw peak torque and voltage line in all quadrants, and the continuous torque."""
    drives = np.linspace(0.0, motor.no_load_speed, _LINE)
    brakes = np.full(_LINE, motor.peak_torque)
    speed = np.concatenate([-drives[::-1], drives]) / RPM
    torque = np.concatenate([brakes, motor.torque_at(drives)])
    panel.plot(speed, torque, color=LIMIT, linewidth=1.0, label="envelope of the motor")
    panel.plot(-speed, -torque, color=LIMIT, linewidth=1.0)
    for sign in (-1.0, 1.0):
        panel.axhline(sign * motor.continuous_torque, color=LIMIT, linestyle=":", linewidth=1.0)
