"""The figure of several solvers on one walk: how far each iterate is from an optimum."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.design.compare import SolverRun
from gaitopt.nlp import Array
from gaitopt.tolerances import OPTIMALITY
from gaitopt.view.figure_style import LIMIT, kind_of, label_axes, new_figure, styled
from gaitopt.view.figures import rendered

_LEAST = 1e-10  # what is smaller is drawn there


def write_convergence_figure(runs: Sequence[SolverRun], path: Path) -> Path:
    """Draw optimality and violation of every iterate of every solver.

    Args:
        runs: of `compare_solvers`.
        path: of the figure, which ends in .png, .svg or .pdf.

    Raises:
        InputError: the file cannot be written.
    """
    kind = kind_of(path)
    with styled():
        figure = _figure(runs)
    return write_atomically(path, rendered(figure, kind))


def _figure(runs: Sequence[SolverRun]) -> Figure:
    figure = new_figure(9.5, 3.8)
    optimality, violation = figure.subplots(1, 2, sharey=True)
    for run in runs:
        seconds = np.array([one.seconds for one in run.history])
        _draw(optimality, seconds, [one.optimality for one in run.history], run.solver)
        _draw(violation, seconds, [one.violation for one in run.history], run.solver)
    label_axes(optimality, "time [s]", "scaled", "Gradient of the Lagrangian, complementarity")
    label_axes(violation, "time [s]", "", "Largest violation of a limit")
    optimality.axhline(OPTIMALITY, color=LIMIT, linestyle="--", linewidth=1.0)
    violation.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _draw(panel: Axes, seconds: Array, values: Sequence[float], name: str) -> None:
    panel.set_xscale("symlog", linthresh=1.0)
    panel.set_yscale("log")
    panel.plot(seconds, np.maximum(values, _LEAST), marker=".", markersize=3.0, label=name)
