"""`gaitopt compare`: one walk by several solvers from the same start, judged alike."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import typer
from rich.table import Table
from rich.text import Text

from gaitopt.atomic import make_directory
from gaitopt.cli.command_options import CompareOptions
from gaitopt.cli.config import Settings
from gaitopt.cli.display import ABSENT, WIDTH, ProgressDisplay, new_table, screen, warn
from gaitopt.cli.process import ExitCode, stop_on_interrupt
from gaitopt.cli.report import print_doubts
from gaitopt.cli.request import SOLVER_OPTIONS, make_request
from gaitopt.cli.results import require_writable, write_record
from gaitopt.design.design import COMPARED, compare_solvers, run_record
from gaitopt.design.process import small_matrices
from gaitopt.errors import InputError
from gaitopt.nlp import Solution, Status
from gaitopt.solvers import SOLVERS, Solver, solver_by_name
from gaitopt.solvers.ipopt import Ipopt
from gaitopt.tolerances import FEASIBLE

RECORD, FIGURE = "comparison.json", "convergence.png"


def run(given: Settings, asked: CompareOptions) -> None:
    """Compare solvers; print a table, write the figure and the record.

    Raises:
        typer.Exit: Ctrl-C was pressed, or no solver found a walk.
    """
    output, quiet = asked.output, asked.quiet
    if output is not None:
        require_writable(output)
    request = make_request({k: v for k, v in given.items() if k != "solvers"}, asked.config)
    solvers = [_solver(name, request.settings) for name in _names(given.get("solvers"))]
    errors, out = screen(stderr=True), screen()
    if not quiet:
        print_doubts(errors, request)
    with (
        small_matrices(),
        stop_on_interrupt(announce=not errors.is_terminal) as stop,
        ProgressDisplay(errors, stop, quiet) as progress,
    ):
        runs = compare_solvers(
            request.robot, request.task, solvers, start=request.start, on_progress=progress,
            stop=stop,
        )  # fmt: skip
    if output is not None:
        _write(runs, output)
    if not quiet:
        out.print(table_of_solvers(runs, request.task.cost_unit), width=min(out.width, WIDTH))
        if output is not None:
            out.print(f"wrote to {output}: {RECORD}, {FIGURE}")
    if stop.asked:
        warn(errors, "interrupted", f"{len(runs)} of {len(solvers)} solvers were tried")
        raise typer.Exit(ExitCode.INTERRUPTED)
    if not any(_walks(one) for one in runs):
        raise typer.Exit(ExitCode.NO_GAIT)


def _names(text: str | None) -> list[str]:
    """Return the solvers named; by default the usual ones that are installed."""
    if text is None:
        return [n for n in COMPARED if n != Ipopt.name or find_spec("cyipopt") is not None]
    names = [name.strip() for name in text.split(",") if name.strip()]
    if not names or len(set(names)) < len(names):
        raise InputError(
            f"--solvers {text}: give each solver once, as in --solvers {','.join(COMPARED)}; there "
            f"are {', '.join(SOLVERS)}"
        )
    return names


def _solver(name: str, settings: Settings) -> Solver:
    """Return a solver with those of the options given that it has."""
    own = getattr(SOLVERS.get(name), "__dataclass_fields__", {})
    return solver_by_name(
        name, **{k: settings[k] for k in SOLVER_OPTIONS if k in settings and k in own}
    )


def _walks(one: Solution) -> bool:
    return one.violation <= FEASIBLE


def table_of_solvers(runs: Sequence[Solution], unit: str) -> Table:
    """Return the table of the runs; `unit` is that of the cost."""
    table = new_table(
        "Solvers at the samples, from the same start", "solver", "ended", f">cost\n{unit}",
        ">optimality\nscaled", ">violation\nscaled", ">iterations", ">evalu-\nations", ">s",
    )  # fmt: skip
    best = min((one.cost for one in runs if _walks(one)), default=np.nan)
    for one in runs:
        optimal = one.status is Status.OPTIMAL
        table.add_row(
            one.solver,
            Text(one.status.name.lower().replace("_", " "), style="green" if optimal else "yellow"),
            Text(_finite(one.cost, ".6g"), style="bold" if one.cost == best else ""),
            _finite(one.optimality, ".0e"),
            _finite(one.violation, ".0e"),
            str(one.iterations),
            str(one.evaluations),
            f"{one.seconds:.2f}",
        )
    return table


def _finite(value: float, form: str) -> str:
    return f"{value:{form}}" if np.isfinite(value) else ABSENT


def _write(runs: Sequence[Solution], output: Path) -> None:
    from gaitopt.view.comparison_figures import convergence_figure
    from gaitopt.view.figure_style import write_figure

    make_directory(output)
    write_record({"solvers": [run_record(one) for one in runs]}, output / RECORD)
    write_figure(output / FIGURE, lambda: convergence_figure(runs))
