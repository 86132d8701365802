"""`gaitopt sweep`: from a request to a gait library."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from gaitopt.actuators.motors import read_motors
from gaitopt.bounds import WORKERS, at_most
from gaitopt.cli.command_options import SweepOptions
from gaitopt.cli.config import SCHEMA, SWEEP, Settings, read_config
from gaitopt.cli.display import screen
from gaitopt.cli.library import library_table
from gaitopt.cli.process import ExitCode, print_error
from gaitopt.cli.report import print_doubts
from gaitopt.cli.request import Request, biped_spec, make_request, make_task
from gaitopt.cli.results import require_writable
from gaitopt.design.process import processors, small_matrices
from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.mechanics.capsule_distance import narrowed_gaps
from gaitopt.settings import named_values
from gaitopt.sweep.executor import joined_scheduler, local_workers
from gaitopt.sweep.grid import Axis, Index, parse_axis, read_named, with_values
from gaitopt.sweep.library import FAULTS, Library, open_library
from gaitopt.sweep.scheduler import SweepProgress, sweep
from gaitopt.sweep.table import CERTIFIED, INFEASIBLE
from gaitopt.tolerances import OPTIMALITY

NAMED = 8  # files that are named, of those that were made anew, or could not be
ROWS = 60  # of the table at the end; `gaitopt library` shows all
PERIOD = 10.0  # s between two plain lines of progress
FINISHING = 3  # times the work of exploring a point


def run(given: Settings, asked: SweepOptions) -> None:
    """Sweep; leave with the exit code the worst point deserves.

    Raises:
        typer.Exit: interrupted, or not every gait is certified.
    """
    directory, config, quiet = asked.output, asked.config, asked.quiet
    if config is not None:
        of_file = read_config(config, given.get("plugin"))
        given = {one.name: of_file[one.name] for one in SWEEP if one.name in of_file} | given
    axes = _axes(given)
    require_writable(directory)
    request = _request(given, axes, config)
    begin, table = _begin(given, axes), request.settings.get("motors")
    swept = any(axis.of_motors for axis in axes)
    motors = read_motors(table) if swept and table is not None else None
    errors = screen(stderr=True)
    if not quiet:
        print_doubts(errors, request)
    executor = make_executor(given, axes, errors, quiet)
    try:
        with small_matrices(), executor or nullcontext(), SweepDisplay(errors, quiet) as display:
            library = sweep(
                request.robot, request.task, axes, directory, request.options,
                spec=biped_spec(request.settings), motors=motors, seed=begin,
                task_at=lambda values: _task_at(request, values), executor=executor,
                on_progress=display,
            )  # fmt: skip
    except KeyboardInterrupt as error:
        kept = _kept(directory)
        print_error(f"interrupted; {kept} in '{directory}', and the same command goes on")
        raise typer.Exit(ExitCode.INTERRUPTED) from error
    out = screen()
    if not quiet:
        if not display.jobs and not library.faults:
            out.print(f"all {len(library.rows)} were there; nothing was computed")
        anew = [p for p, s in library.states.items() if s.fault and p not in library.faults]
        _print_remade("made anew", library, anew, out)
        _print_remade("could not be made anew", library, library.faults, out)
        _print_narrowed_gaps(library, request, out)
    _conclude(library, out, quiet, request.options.refine)


def make_executor(
    given: Settings, axes: list[Axis], errors: Console, quiet: bool
) -> Executor | None:
    """Return who does the work: no more local workers than points or processors; None: nobody else.

    Raises:
        InputError: fewer than one worker, both workers and a scheduler, or no scheduler where one
            is said.
        MissingExtraError: Dask distributed is not installed, for a scheduler.
    """
    workers, scheduler = given.get("workers"), given.get("scheduler")
    if workers is not None and scheduler is not None:
        raise InputError("--workers and --scheduler exclude each other; give one of them")
    if scheduler is not None:
        return joined_scheduler(str(scheduler))
    if workers is None:
        return None
    at_most(int(str(workers)), WORKERS, "workers")
    wanted, points = int(str(workers)), math.prod(len(axis.values) for axis in axes)
    count = min(wanted, points, processors())

    def on_start() -> None:
        few = "this machine has no more processors; --scheduler joins others"
        if points < processors():
            few = f"more are idle with {points} point{'s' * (points != 1)}"
        few = "" if count == wanted else f", not {wanted}: {few}"
        if not quiet:
            errors.print(f"starting workers: {count}{few}")

    return local_workers(count, on_start)


class SweepDisplay:
    """Shows how far a sweep is; a context manager, and what `sweep` takes as `on_progress`.

    On a terminal a bar with the time left, elsewhere now and then a line.

    Attributes:
        jobs: done so far.
    """

    def __init__(self, console: Console, quiet: bool) -> None:
        self._console, self._quiet = console, quiet
        self._bar: Progress | None = None
        self._printed = time.monotonic()
        self.jobs = 0

    def __enter__(self) -> SweepDisplay:
        if self._console.is_terminal and not self._quiet:
            self._bar = Progress(
                TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[said]}"),
                TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
                console=self._console,
            )  # fmt: skip
            self._bar.add_task("exploring", total=None, said="")
        return self  # it starts with the first outcome: workers are started without its thread

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def __call__(self, progress: SweepProgress) -> None:
        """Show it."""
        self.jobs += 1
        done = progress.gaits + progress.refused
        said = f"{done} of {progress.points} done, {progress.explored} explored"
        if progress.refused:
            said += f", {progress.refused} without a gait"
        if self._bar is not None:
            self._bar.start()
            self._bar.update(
                self._bar.task_ids[0],
                description=progress.stage,
                total=(1 + FINISHING) * progress.points,
                completed=progress.explored + FINISHING * done,
                said=said,
            )
        elif not self._quiet and time.monotonic() - self._printed >= PERIOD:
            self._printed = time.monotonic()
            self._console.print(f"{progress.stage}: {said}")


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
    values = named_values(given.get("begin"), "--begin", read_named)
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
    return make_request(settings, config, [axis.name for axis in axes])


def _task_at(request: Request, values: dict[str, float]) -> Task:
    """Return the task of a point; what the preset derives from its values follows them."""
    plain = {k: v for k, v in values.items() if k in (*SCHEMA["task"], *SCHEMA["margins"])}
    task = make_task({**request.settings, **plain}, request.robot)
    return with_values(task, [(k, v) for k, v in values.items() if k not in plain])


def _print_remade(what: str, library: Library, points: Iterable[Index], out: Console) -> None:
    """Tell what became of gaits, each with what was wrong with it when the sweep began."""
    told = [
        f"gaits/{library.grid.name(point)}.npz "
        f"({library.states[point].fault or library.faults[point]})"
        for point in points
    ]
    if told:
        more = f"; and {len(told) - NAMED} more" if len(told) > NAMED else ""
        out.print(f"{what}: {'; '.join(told[:NAMED])}{more}")


def _print_narrowed_gaps(library: Library, request: Request, out: Console) -> None:
    """Tell which gaps between bodies are narrower than asked for; said once where they vary."""
    margins = request.task.margins
    gaps = {"leg_gap": margins.leg_gap, "arm_gap": margins.arm_gap}
    for axis in library.grid.axes:
        if axis.name in gaps:
            gaps[axis.name] = axis.values[-1]
    for sentence in narrowed_gaps(request.robot, **gaps):
        out.print(sentence)


def _kept(directory: Path) -> str:
    try:
        library = open_library(directory)
    except InputError:
        return "nothing is kept"
    states, lost = library.states.values(), len(library.faults)
    gaits = sum(state.row is not None for state in states)
    walks = sum(state.walk is not None for state in states)
    counts = (gaits - lost, "gait"), (walks, "walk")
    told = (f"{count} {what}{'s' * (count != 1)}" for count, what in counts)
    return f"{' and '.join(told)} to make gaits of are kept"


def _conclude(library: Library, out: Console, quiet: bool, refined: bool) -> None:
    rows = library.rows
    certified = sum(row["status"] == CERTIFIED for row in rows)
    refused = [row for row in rows if row["status"] == INFEASIBLE]
    if not quiet:
        out.print(library_table(library, rows[:ROWS], None, out.width))
        if len(rows) > ROWS:
            out.print(f"and {len(rows) - ROWS} more: gaitopt library {library.directory}")
        out.print(
            f"{certified} of {len(rows)} gaits certified; {library.seconds:.0f} s of processor; in "
            f"{library.directory}: gaits/, index.csv")  # fmt: skip
        for point, state in sorted(library.states.items()):
            if state.refusal is not None:
                out.print(f"no gait at {library.grid.name(point)}:")
                for sentence in state.refusal["sentences"]:
                    out.print(f"- {sentence}")
    if refused:
        raise typer.Exit(ExitCode.NO_GAIT)
    optimal = sum(
        float(str(row["kkt"])) <= OPTIMALITY for row in rows if row["status"] not in FAULTS
    )
    if (certified if refined else optimal) < len(rows):
        raise typer.Exit(ExitCode.NOT_CERTIFIED)
