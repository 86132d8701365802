"""`gaitopt sensitivity`: what small changes of robot and task do to the cost of a gait."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, fields

from rich.table import Table

from gaitopt.atomic import write_atomically
from gaitopt.cli.command_options import SensitivityOptions
from gaitopt.cli.display import ABSENT, NARROW, new_table, screen, warn
from gaitopt.cli.report import print_findings_of
from gaitopt.cli.results import require_files
from gaitopt.design.audit import problem_of
from gaitopt.design.certificate import certify
from gaitopt.design.sensitivity import Sensitivity, SensitivityReport, sensitivities
from gaitopt.errors import EvaluationError, GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.result import Gait
from gaitopt.sweep.table import csv_bytes

_READABLE = {"m": (100.0, "cm"), "rad": (math.degrees(1.0), "°"), "s": (1000.0, "ms"),
             "of itself": (100.0, "%"), "kg·m²": (1e4, "kg·cm²")}  # fmt: skip
_NONE = 5e-6  # share of the cost that is shown as 0.00 %


def run(asked: SensitivityOptions) -> None:
    """Print the sensitivities of a gait, and write all of them.

    Raises:
        InputError: fewer than one line, or an output that is no table.
    """
    most, output = asked.most, asked.output
    if most < 1:
        raise InputError(f"--most is {most}; show at least 1 line")
    require_files((output, "--output"))
    if output is not None and output.suffix.lower() != ".csv":
        raise InputError(f"'{output}' is no table; give a name that ends in .csv")
    known = () if asked.plugin is None else load_plugin(asked.plugin).extensions
    loaded = load_gait(asked.gait)
    report = report_of(loaded, known)
    out = screen()
    print_findings_of(loaded)
    width = min(out.width, NARROW)
    shown = report.found[:most]
    out.print(sensitivity_table(shown, report), width=width)
    hidden = len(report.found) - len(shown)
    if hidden:
        out.print(f"{hidden} more change it less; --most shows them, --output writes all")
    for text in report.doubts:
        warn(out, "note", text)
    if output is not None:
        header = [one.name for one in fields(Sensitivity)]
        table = csv_bytes([header, *(astuple(one) for one in report.found)])
        written = write_atomically(output, table)
        out.print(f"wrote {written}")


def report_of(gait: Gait, known: Sequence[object] = ()) -> SensitivityReport:
    """Return the sensitivities of a gait.

    Args:
        known: constraints and costs of a plugin.

    Raises:
        GaitFileError: its walk cannot be made again, or is not optimal.
    """
    problem = problem_of(gait, known)  # type: ignore[arg-type]
    try:
        certificate = certify(problem, gait.parameters)
        if not certificate.optimal:
            raise GaitFileError(
                "the gait is not optimal, so that its cost has no derivatives; design it again, "
                "without --no-refine and with more --starts or --max-iterations"
            )
        return sensitivities(problem, gait.parameters, certificate.multipliers)
    except EvaluationError as error:
        raise GaitFileError(f"the gait's parameters do not make a walk: {error}") from error


def sensitivity_table(shown: Sequence[Sensitivity], report: SensitivityReport) -> Table:
    """Return the table of what changes the cost most."""
    title = f"What changes the cost of {report.cost:.6g} {report.unit} most"
    table = new_table(title, "change", ">of", ">cost\n%", ">or speed, at\nequal cost, m/s")
    for one in shown:
        share = 0.0 if abs(one.share) < _NONE else 100.0 * one.share
        scale, unit = _READABLE.get(one.unit, (1.0, one.unit))
        step = f"{scale * one.step:+.3g} {unit}".strip()
        speed = ABSENT if math.isnan(one.speed) else f"{one.speed:+.4f}"
        table.add_row(one.name, step, f"{share:+.2f}", speed)
    return table
