"""`gaitopt sweep`: from a request to a gait library."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from gaitopt.cli.config import SCHEMA, Settings
from gaitopt.cli.crew import make_crew
from gaitopt.cli.display import screen
from gaitopt.cli.paths import require_writable
from gaitopt.cli.process import ExitCode, print_error
from gaitopt.cli.report import inspect_command, print_findings
from gaitopt.cli.request import Request, biped_spec, make_request, make_task
from gaitopt.cli.sweep_options import SWEEP
from gaitopt.cli.sweep_progress import SweepDisplay
from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.settings import named_values
from gaitopt.sweep.grid import Axis, Index, parse_axis, with_values
from gaitopt.sweep.library import FAULTS, Library, open_library
from gaitopt.sweep.scheduler import sweep
from gaitopt.sweep.table import CERTIFIED, INFEASIBLE
from gaitopt.tolerances import OPTIMALITY

NAMED = 8  # files that are named, of those that were made anew, or could not be


def run(given: Settings, directory: Path, config: Path | None, quiet: bool) -> None:
    """Sweep; leave with the exit code the worst point deserves.

    Args:
        given: options of the command line.
        directory: of the gait library.
        config: configuration file, if any.
        quiet: whether to print errors only.

    Raises:
        GaitoptError: bad input, or the directory cannot be written.
        typer.Exit: interrupted, or not every gait is certified.
    """
    axes = _axes(given)
    require_writable(directory)
    request = _request(given, axes, config)
    begin = _begin(given, axes)
    errors = screen(stderr=True)
    if not quiet:
        print_findings(errors, request.robot.findings, inspect_command(request.settings))
    crew = make_crew(given, axes, errors, quiet)
    try:
        with SweepDisplay(errors, quiet) as display:
            library = sweep(
                request.robot, request.task, axes, directory, request.options,
                spec=biped_spec(request.settings), seed=begin,
                task_at=lambda values: _task_at(request, values), crew=crew,
                on_advance=display,
            )  # fmt: skip
    except KeyboardInterrupt as error:
        kept = _kept(directory)
        print_error(f"interrupted; {kept} in '{directory}', and the same command goes on")
        raise typer.Exit(ExitCode.INTERRUPTED) from error
    out = screen()
    if not quiet:
        if not display.jobs and not library.faults:
            out.print(f"all {len(library.rows)} were there; nothing was computed")
        found = library.state.faulty
        _tell_files("made anew", library, (p for p in found if p not in library.faults), out)
        _tell_files("could not be made anew", library, library.faults, out)
    _conclude(library, out, quiet, request.options.refine)


def _axes(given: Settings) -> list[Axis]:
    axes = []
    if (speeds := given.get("speeds")) is not None:
        axes.append(parse_axis("speed", str(speeds)))
    grids: Any = given.get("grid", [])
    for text in grids:
        name, sign, values = str(text).partition("=")
        if not sign:
            raise InputError(f"--grid {text}: give NAME=RANGE, as duration=0.3:0.6:0.05")
        axes.append(parse_axis(name.strip(), values))
    for name, count in Counter(axis.name for axis in axes).items():
        if count > 1:
            raise InputError(
                f"{name} is swept over twice; give its values once"
                + (", by --speeds or by --grid" if name == "speed" else "")
            )
    if not axes:
        raise InputError("nothing to sweep over; give --speeds 0.4:1.3:0.05, or --grid NAME=RANGE")
    return axes


def _begin(given: Settings, axes: list[Axis]) -> dict[str, float]:
    """Return where to begin, inside the ranges."""
    values = named_values(given.get("begin"), "--begin")
    for axis in axes:
        first, last = axis.values[0], axis.values[-1]
        if axis.name in values and not first <= values[axis.name] <= last:
            raise InputError(
                f"--begin {axis.name}={values[axis.name]:g} is outside the sweep; {axis.name} "
                f"goes from {first:g} to {last:g}"
            )
    return values


def _request(given: Settings, axes: list[Axis], config: Path | None) -> Request:
    """Return the request at the first point; every point has its own task."""
    settings = {name: v for name, v in given.items() if name not in {one.name for one in SWEEP}}
    for axis in axes:
        if axis.name in settings:
            raise InputError(
                f"{axis.name} is swept over; leave out --{axis.name.replace('_', '-')}"
            )
        if axis.name in (*SCHEMA["task"], *SCHEMA["margins"]):
            settings[axis.name] = axis.values[0]
    return make_request(settings, config)


def _task_at(request: Request, values: dict[str, float]) -> Task:
    """Return the task of a point; what the preset derives from its values follows them."""
    plain = {k: v for k, v in values.items() if k in (*SCHEMA["task"], *SCHEMA["margins"])}
    task = make_task({**request.settings, **plain}, request.robot)
    return with_values(task, [(k, v) for k, v in values.items() if k not in plain])


def _tell_files(what: str, library: Library, points: Iterable[Index], out: Console) -> None:
    """Tell what became of gait files, each with what was wrong with it when the sweep began."""
    wrong = {**library.faults, **library.state.faulty}
    told = [f"{library.state.rows[p]['file']} ({wrong[p]})" for p in points]
    if told:
        more = f"; and {len(told) - NAMED} more" if len(told) > NAMED else ""
        out.print(f"{what}: {'; '.join(told[:NAMED])}{more}", soft_wrap=True)


def _kept(directory: Path) -> str:
    try:
        library = open_library(directory)
    except InputError:
        return "nothing is kept"
    state, lost = library.state, len(library.faults)
    walks = sum(footing is not None for footing in state.footings.values())
    return f"{len(state.rows) - lost} gaits and {walks} walks to make gaits of are kept"


def _conclude(library: Library, out: Console, quiet: bool, refined: bool) -> None:
    rows = library.rows
    certified = sum(row["status"] == CERTIFIED for row in rows)
    refused = [row for row in rows if row["status"] == INFEASIBLE]
    if not quiet:
        out.print(
            f"{certified} of {len(rows)} gaits certified; {library.state.seconds:.0f} s of "
            f"processor; in {library.directory}: gaits/, index.csv",
            soft_wrap=True,
        )  # fmt: skip
        for point, refusal in library.state.refusals.items():
            out.print(f"no gait at {library.points.name(point)}:")
            for sentence in refusal["sentences"]:
                out.print(f"- {sentence}", soft_wrap=True)
    if refused:
        raise typer.Exit(ExitCode.NO_GAIT)
    optimal = sum(
        float(str(row["kkt"])) <= OPTIMALITY for row in rows if row["status"] not in FAULTS
    )
    if (certified if refined else optimal) < len(rows):
        raise typer.Exit(ExitCode.NOT_CERTIFIED)
