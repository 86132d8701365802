"""docs/reproduction.md: the words of `reproduction_page.toml` with the numbers of a run."""

from __future__ import annotations

import json
import sys
from importlib import resources
from math import isfinite
from pathlib import Path
from string import Template

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.study.reproduce.gradients import CAP, DIFFERENCES, EXACT, NEAR, SOLVER, Comparison
from gaitopt.study.reproduce.printed import PrintedSpeed, printed
from gaitopt.study.reproduce.record import record
from gaitopt.study.reproduce.results import Reproduction
from gaitopt.view.figures import rendered
from gaitopt.view.reproduction_claims import claims_table, printed_impulse
from gaitopt.view.reproduction_figures import REPRODUCTION_FIGURES, reproduction_figure
from gaitopt.view.reproduction_tables import (
    alternatives_table,
    environment,
    errors_table,
    gradient_table,
    joint_table,
    posture_table,
    printed_table,
    singular_table,
    unknowns_table,
)

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PAGE_NAME = "reproduction.md"
RECORD_NAME = "reproduction.json"
IMAGES = "images/reproduction"


def write_reproduction(result: Reproduction, directory: str | Path) -> list[Path]:
    """Write page, figures and numbers of a reproduction to a directory, made if need be.

    Returns:
        The files written, the page first.

    Raises:
        InputError: the directory cannot be written.
        RobotError: the biped cannot be drawn.
    """
    folder = Path(directory)
    try:
        (folder / IMAGES).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the directory '{folder}': {error.strerror}") from error
    page = write_atomically(folder / PAGE_NAME, page_text(result).encode())
    numbers = json.dumps(record(result), indent=2) + "\n"
    written = [page, write_atomically(folder / RECORD_NAME, numbers.encode())]
    for name in REPRODUCTION_FIGURES:
        figure = rendered(reproduction_figure(result, name), "png")
        written.append(write_atomically(folder / IMAGES / f"{name}.png", figure))
    return written


def page_text(result: Reproduction) -> str:
    """Return the page."""
    text = (resources.files("gaitopt.view") / "reproduction_page.toml").read_text("utf-8")
    return Template(tomllib.loads(text)["page"]).substitute(_tables(result), **_numbers(result))


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
        "minutes": f"{result.seconds / 60.0:.1f}",
        "cpu_minutes": f"{result.cpu_seconds / 60.0:.1f}",
        "images": IMAGES,
        "euler": f"{100.0 * (result.euler_cost / result.reference.cost - 1.0):+.1f}",
        "liftoff": f"{100.0 * float(np.max(-result.sinking)):.0f}",
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
        "least_ratio": f"{min(ends):.0f}",
        "least_near": f"{min(nears):.0f}" if nears else "none",
        "converged": str(sum(run.converged for run in others)),
        "runs": str(len(others)),
        "missed": str(sum(_missed(result, c) for c in result.comparisons)),
        "speeds": str(len(rows)),
        "near": str(sum(gap <= NEAR for gap in gaps)),
        "gap": f"{100.0 * max(gaps):.2g}",
        "printed_gap": f"{100.0 * max(_excess(row) for row in rows):.0f}",
        "evaluations_per_iteration": _average(
            [row.analytical.evaluations_per_iteration for row in rows]
        ),
        "evaluations_per_iteration_fd": _average(
            [row.differences.evaluations_per_iteration for row in rows]
        ),
    }


def _missed(result: Reproduction, comparison: Comparison) -> bool:
    """Whether the run from the first guess ended dearer than the best walk known."""
    cold = comparison.run(EXACT).cost
    return cold > result.curve[comparison.speed].cost * (1.0 + 1e-4)


def _excess(row: PrintedSpeed) -> float:
    return row.differences.cost / row.analytical.cost - 1.0


def _per_evaluation(row: PrintedSpeed) -> float:
    return row.differences.seconds / row.differences.evaluations


def _average(values: list[float]) -> str:
    return f"{np.mean(values):.1f}"
