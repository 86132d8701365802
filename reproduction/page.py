"""docs/reproduction.md: the words of `page.toml` with the numbers of a run."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import resources
from math import isfinite
from pathlib import Path
from string import Template

import numpy as np

from gaitopt.atomic import make_directory, write_atomically
from gaitopt.importers.text_files import parse_toml
from gaitopt.nlp import Array
from gaitopt.view.figure_style import rendered
from reproduction.consequences import EULER_SAMPLES, SINK
from reproduction.figures import REPRODUCTION_FIGURES, reproduction_figure
from reproduction.gradients import CAP, DIFFERENCES, EXACT, NEAR, SOLVER, Comparison
from reproduction.paper import PrintedSpeed, printed
from reproduction.results import Reproduction, record
from reproduction.tables import (
    alternatives_table,
    claims_table,
    environment,
    errors_table,
    gradient_table,
    joint_table,
    posture_table,
    printed_impulse,
    printed_table,
    singular_table,
    unknowns_table,
)

PAGE_NAME = "reproduction.md"
STOPPED_EARLY = 0.3  # printed runs dearer than this look so
RECORD_NAME = "reproduction.json"
IMAGES = "images/reproduction"


@dataclass(frozen=True)
class Part:
    """A table or figure of the paper, or a chapter of the page.

    Attributes:
        title: what it shows.
        tables: each returns a table of Markdown.
        figures: names of `REPRODUCTION_FIGURES`.
    """

    title: str
    tables: tuple[Callable[[Reproduction], str], ...] = ()
    figures: tuple[str, ...] = ()


PARTS = {
    "table3": Part(
        "optimal costs, iterations and times with exact derivatives and with differences",
        (errors_table, gradient_table, lambda _result: printed_table()),
    ),
    "fig3": Part("convergence at 1.0 m/s", figures=("convergence",)),
    "fig4": Part("one step at 1.0 m/s", figures=("step",)),
    "fig5": Part("force of the ground at 1.0 m/s", figures=("ground_force",)),
    "fig6": Part(
        "centre of pressure with one and two intermediate postures", (posture_table,), ("cop",)
    ),
    "fig7": Part("optimal cost against speed", (errors_table,), ("cost",)),
    "fig8": Part("cost of the joint torques by group", (joint_table,), ("joint_costs",)),
    "fig9": Part("three steps at 1.0 m/s", figures=("walk",)),
    "identification": Part(
        "the values that the paper leaves open",
        (unknowns_table, singular_table, alternatives_table),
        ("errors",),
    ),
    "claims": Part("what the paper says of its gaits and was not fitted", (claims_table,)),
}
"""What `--only` selects, by name."""


def part_text(result: Reproduction, name: str) -> str:
    """Return the title and the tables of one of `PARTS`, as Markdown."""
    part = PARTS[name]
    return "\n\n".join([f"## {name}: {part.title}", *(table(result) for table in part.tables)])


def write_reproduction(result: Reproduction, directory: str | Path) -> list[Path]:
    """Write page, figures and numbers of a reproduction to a directory, made if need be.

    Returns:
        The files written, the page first.

    Raises:
        InputError: the directory cannot be written.
        NoGaitFoundError: at a speed of Table 3 no walk was found.
        RobotError: the biped cannot be drawn.
    """
    folder = make_directory(Path(directory))
    page = write_atomically(folder / PAGE_NAME, page_text(result).encode())
    numbers = json.dumps(record(result), indent=2) + "\n"
    written = [page, write_atomically(folder / RECORD_NAME, numbers.encode())]
    return written + write_figures(result, folder, REPRODUCTION_FIGURES)


def write_figures(result: Reproduction, directory: str | Path, names: Iterable[str]) -> list[Path]:
    """Write some of `REPRODUCTION_FIGURES` as PNG; return the files.

    Raises:
        InputError: the directory cannot be written.
        NoGaitFoundError: at a speed of Table 3 no walk was found.
        RobotError: the biped cannot be drawn.
    """
    chosen = list(names)
    folder = make_directory(Path(directory) / IMAGES) if chosen else Path(directory)
    return [
        write_atomically(folder / f"{name}.png", rendered(reproduction_figure(result, name), "png"))
        for name in chosen
    ]


def page_text(result: Reproduction) -> str:
    """Return the page."""
    text = (resources.files("reproduction") / "page.toml").read_text("utf-8")
    page = parse_toml(text, "page.toml")["page"]
    return Template(page).substitute(_tables(result) | _numbers(result) | _open_questions(result))


def _tables(result: Reproduction) -> dict[str, str]:
    return {
        "unknowns": unknowns_table(result),
        "errors_table": errors_table(result),
        "singular_table": singular_table(result),
        "alternatives_table": alternatives_table(result),
        "claims_table": claims_table(result),
        "gradient_table": gradient_table(result),
        "printed_table": printed_table(),
        "posture_table": posture_table(result),
        "joint_table": joint_table(result),
    }


def _numbers(result: Reproduction) -> dict[str, str]:
    rows = printed().table3
    errors = np.abs(result.errors)
    ends = [c.ratio(DIFFERENCES) for c in result.comparisons]
    nears = [r for r in (c.near_ratio(DIFFERENCES) for c in result.comparisons) if isfinite(r)]
    others = [run for c in result.comparisons for run in c.runs[1:]]
    gaps = [c.run(DIFFERENCES).cost / c.run(EXACT).cost - 1.0 for c in result.comparisons]
    return {
        "environment": environment(),
        "minutes": f"{result.seconds[0] / 60.0:.1f}",
        "cpu_minutes": f"{result.seconds[1] / 60.0:.1f}",
        "images": IMAGES,
        "quickest": f"{min(_per_evaluation(row) for row in rows):.2f}",
        "slowest": f"{max(_per_evaluation(row) for row in rows):.2f}",
        "parameters": str(result.reference.problem.layout.size),
        "worst": f"{100.0 * errors.max():.2f}",
        "rms": f"{100.0 * result.sensitivity.spread:.2f}",
        "least": f"{min(printed().speeds, key=lambda v: result.curve[v].cost):g}",
        "printed_least": f"{min(rows, key=lambda row: row.analytical.cost).speed:g}",
        "printed_impulse": f"{printed_impulse(result):.2f}",
        "tolerance": f"{SOLVER.tolerance:.0e}",
        "cap": f"{CAP:.0f}",
        "most_iterations": str(SOLVER.max_iterations),
        "printed_force": f"{printed().mean_vertical_force:.2f}",
        "dearest": " and ".join(
            f"{row.differences.cost:.2f}" for row in rows if _excess(row) > STOPPED_EARLY
        ),
        "least_ratio": f"{min(ends):.0f}",
        "least_near": f"{min(nears):.0f}" if nears else "none",
        "converged": str(sum(run.converged for run in others)),
        "runs": str(len(others)),
        "missed": str(sum(_missed(result, c) for c in result.comparisons)),
        "speeds": str(len(rows)),
        "near": str(sum(gap <= NEAR for gap in gaps)),
        "gap": f"{100.0 * max(gaps):.2g}",
        "printed_gap": f"{100.0 * max(_excess(row) for row in rows):.0f}",
        "impulses": _range(result),
    }


def _open_questions(result: Reproduction) -> dict[str, str]:
    """Return the numbers of the last table of the page."""
    other, rows = result.consequences, printed().table3
    per_iteration = [
        [run.evaluations_per_iteration for run in runs]
        for runs in ([r.analytical for r in rows], [r.differences for r in rows])
    ]
    return {
        "euler": f"{100.0 * other.euler:+.1f}",
        "left_hand": str(EULER_SAMPLES - 1),
        "liftoff": _at_most(-other.sinking),
        "sink": f"{SINK:g}",
        "yaw": _at_most(-other.yaw),
        "penalty": _at_most(-other.penalty),
        "penalty_miss": f"{np.abs(other.penalty_speed).max():.3f}",
        "penalty_weight": f"{other.penalty_weight:.0e}",
        "torque": f"{other.torque:.0f}",
        "evaluations_per_iteration": f"{np.mean(per_iteration[0]):.1f}",
        "evaluations_per_iteration_fd": f"{np.mean(per_iteration[1]):.1f}",
        "fewest_evaluations": f"{np.min(per_iteration):.1f}",
        "evaluations_exact": _evaluations(result, EXACT),
        "evaluations_fd": _evaluations(result, DIFFERENCES),
        "printed_parameters": str(printed().parameters),
        "printed_mass": f"{printed().mass:.2f}",
        "mass": f"{result.reference.problem.robot.mass:.2f}",
        "text_iterations": str(printed().text_iterations),
        "table_iterations": str(_reference_row().differences.iterations),
    }


def _reference_row() -> PrintedSpeed:
    return next(row for row in printed().table3 if row.speed == printed().speed)


def _range(result: Reproduction) -> str:
    impulses = [other.impulse for other in result.alternatives if isfinite(other.impulse)]
    if not impulses:
        return "none"
    return f"{min(impulses):.2f} to {max(impulses):.2f} N·s"


def _at_most(changes: Array) -> str:
    """Return the largest of relative changes, in per cent."""
    return f"{100.0 * float(changes.max()):.1f}"


def _evaluations(result: Reproduction, gradient: str) -> str:
    runs = [comparison.run(gradient) for comparison in result.comparisons]
    return f"{sum(r.evaluations for r in runs) / sum(r.iterations for r in runs):.1f}"


def _missed(result: Reproduction, comparison: Comparison) -> bool:
    """Whether the run from the first guess ended dearer than the best walk known."""
    cold = comparison.run(EXACT).cost
    return cold > result.curve[comparison.speed].cost * (1.0 + 1e-4)


def _excess(row: PrintedSpeed) -> float:
    return row.differences.cost / row.analytical.cost - 1.0


def _per_evaluation(row: PrintedSpeed) -> float:
    return row.differences.seconds / row.differences.evaluations
