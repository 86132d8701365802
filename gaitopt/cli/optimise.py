"""`gaitopt optimise`: from a request to a gait on paper and on disk, or to the fastest walk."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from gaitopt.bounds import fixed, rounded
from gaitopt.cli.command_options import OptimiseOptions
from gaitopt.cli.config import Settings
from gaitopt.cli.process import (
    ExitCode,
    StopRequest,
    print_advice,
    print_error,
    refuse_options,
    stop_on_interrupt,
)
from gaitopt.cli.request import Request, make_request, make_task
from gaitopt.cli.results import (
    CHOICES,
    GAIT,
    TASK,
    URDF,
    keep_files,
    require_writable,
    save_elsewhere,
    write_results,
)
from gaitopt.design.certificate import WorstRow
from gaitopt.design.design import design
from gaitopt.design.options import COUNT, DesignOptions
from gaitopt.design.phase_times import best_times, searched_times
from gaitopt.design.pipeline import Design
from gaitopt.design.process import can_be_copied, processors, small_matrices
from gaitopt.design.starts import SecondStart, many_starts
from gaitopt.design.walkability import weak_points
from gaitopt.errors import (
    GaitoptError,
    InputError,
    NoGaitFoundError,
    StoppedError,
    UnreachableError,
    missing_package,
)
from gaitopt.gait.presets import ROBUST
from gaitopt.gait.problem import MakeProgress
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.mechanics.capsule_distance import narrowed_gaps
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Status
from gaitopt.view.drawing_worker import DrawingWorker, mesh_files, spare_cores

if TYPE_CHECKING:
    from rich.console import Console

    from gaitopt.sweep.speed_search import Fastest

_ADVICE = (
    "; the solver stopped before an optimum was proven: try other starts (--starts {}), or another "
    "--speed or --duration"
)
_MOST = 8  # constraints at their limits that are told


def run(given: Settings, options: OptimiseOptions) -> None:
    """Design a gait, show it, write it; leave with the exit code it deserves.

    Raises:
        GaitoptError: bad input, or no gait found.
        typer.Exit: the gait is not certified, or Ctrl-C ended the search for it.
    """
    output, figures, quiet = options.output, options.figures, options.quiet
    if output is not None:
        require_writable(output)
        keep_files(output, (GAIT, URDF, CHOICES, TASK), (options.config, *given.values()))
    else:
        alone = {"--figures": figures, "--no-page": not options.page}
        refuse_options(alone, "with --output DIR")
    with closing(DrawingWorker()) as worker:
        request = make_request(given, options.config, on_robot=partial(_get_ready, worker, options))
        try:
            with small_matrices(), _second_start(request, options) as second:
                if not quiet:
                    from gaitopt.cli.report import print_doubts  # loads Rich: not for nothing

                    print_doubts(_screen(stderr=True), request)
                if options.fastest:
                    request, found = _fastest_walk(request, quiet)
                else:
                    found = _search(request, quiet, second)
        except (KeyboardInterrupt, StoppedError) as error:
            print_error("interrupted before there was a result; nothing was written")
            raise typer.Exit(ExitCode.INTERRUPTED) from error
        except (NoGaitFoundError, UnreachableError) as error:
            from gaitopt.cli.suggestions import Asked, suggestion_lines

            print_error(str(error))
            print_advice(suggestion_lines(error.diagnosis, request, Asked(given, options)))
            raise typer.Exit(error.exit_code) from error
        written: list[Path] = []
        try:  # first the files: whoever reads the tables may close the pipe
            if output is not None:
                results = write_results(
                    found.gait, request, output, page=options.page, figures=figures, worker=worker
                )
                written = _all_written(results, found.gait, output)
        finally:
            if not quiet:
                from gaitopt.cli.report import print_gait

                print_gait(_screen(), found.gait)
        if not quiet and (fragile := fragile_lines(found.gait)):
            _warn("fragile", fragile[0])
            for line in fragile[1:]:
                _screen(stderr=True).print(f"  {line}")
        if output is not None and not quiet:
            names = ", ".join(path.name for path in written)
            _screen().print(f"wrote to {output}: {names}")
    code = exit_code(found)
    if code is not ExitCode.OK:
        if not found.certificate.certified:
            advice = "" if found.certificate.optimal else _ADVICE.format(2 * request.starts)
            _warn("warning", f"{found.certificate.verdict}{advice}")
        raise typer.Exit(code)


def _screen(*, stderr: bool = False) -> Console:
    """Return a console; only who writes there waits for Rich."""
    from gaitopt.cli.display import screen

    return screen(stderr=stderr)


def _warn(word: str, text: str) -> None:
    from gaitopt.cli.display import warn

    warn(_screen(stderr=True), word, text)


def _get_ready(worker: DrawingWorker, options: OptimiseOptions, robot: Robot) -> None:
    """Get ready to draw what takes long: figures, or meshes."""
    if options.output is not None and options.figures:
        worker.get_ready(figures=True)
    elif options.output is not None and options.page:
        worker.get_ready(meshes=mesh_files(robot.urdf, robot.choices.package_dirs))


def fragile_lines(gait: Gait) -> list[str]:
    """Return what in a gait is beyond what walks in simulation, with the options; or nothing."""
    weak = [point for point in weak_points(gait) if point.weak]
    if not weak:
        return []
    # a foot that turns about an edge seldom keeps all of its margins
    all_of_them = "" if gait.turning or gait.lands_on_line else f"--preset {ROBUST} sets all; "
    return [
        "under feedback it may fall or cost more",
        *map(str, weak),
        f"{all_of_them}gaitopt simulate walks it",
    ]


def exit_code(found: Design) -> ExitCode:
    """Return the exit code of a gait: unrefined, being optimal at the samples is enough.

    A search that Ctrl-C ended says so, however good the gait it left.
    """
    if found.solution.status is Status.INTERRUPTED:
        return ExitCode.INTERRUPTED
    return ExitCode.OK if found.proven else ExitCode.NOT_CERTIFIED


def _all_written(results: Iterator[Path], gait: Gait, output: Path) -> list[Path]:
    """Return what was written; where something ends it, say what is there.

    Raises:
        typer.Exit: Ctrl-C was pressed.
        InputError: something cannot be written; the gait is kept, if it can be anywhere.
    """
    written: list[Path] = []
    try:
        written.extend(results)
    except KeyboardInterrupt as error:
        print_error(f"interrupted while the results were written; {_there(written, output)}")
        raise typer.Exit(ExitCode.INTERRUPTED) from error
    except (GaitoptError, OSError, ModuleNotFoundError) as error:
        reason = missing_package(error) or str(error)
        if written:
            raise InputError(f"{reason}; {_there(written, output)}") from error
        kept = save_elsewhere(gait)
        where = "and could be kept nowhere else" if kept is None else f"it is kept in '{kept}'"
        raise InputError(f"{reason}; the gait was found all the same, {where}") from error
    return written


def _there(written: list[Path], output: Path) -> str:
    return f"in '{output}' there is: {', '.join(p.name for p in written) or 'nothing yet'}"


@contextmanager
def _second_start(request: Request, asked: OptimiseOptions) -> Iterator[SecondStart | None]:
    """Begin the second start beside all that follows, where there is one and a core for it.

    A plugin is run in one process only: it may count, or write, what it is asked for.
    """
    robot, task, options = request.robot, request.task, request.options
    alone = asked.fastest or searched_times(task, options) or "plugin" in request.settings
    one_by_one = request.starts > 1 and _workers(request) == 1
    if alone or not one_by_one or not can_be_copied() or spare_cores() < 1.0:
        yield None
        return
    sigma, seed = request.noise
    try:
        second = SecondStart(robot, task, options, seed=seed, sigma=sigma, start=request.start)
    except OSError:  # no pipe to be had: it is made after the first, as where no core is free
        yield None
        return
    with closing(second):
        yield second


def _workers(request: Request) -> int:
    return max(1, min(request.starts // 2, processors()))


def _designed(
    request: Request, progress: MakeProgress | None, stop: StopRequest, second: SecondStart | None
) -> tuple[Design, tuple[str, ...]]:
    """Design from one start, or from several with a report; at the best times, if so asked."""
    if searched_times(request.task, request.options):
        said: list[str] = []

        def one(task: Task, start: Array | None, options: DesignOptions) -> Design:
            # the search of times has made both starts already
            found_before = start is not None and request.starts == COUNT
            starts = 1 if found_before else request.starts
            again = replace(request, task=task, start=start, options=options, starts=starts)
            found, told = _of_task(again, progress, stop, None)
            said.extend(told)
            return found

        choice = best_times(request.robot, request.task, request.options, one, request.start, stop)
        return choice.design, (*said, choice.sentence)
    return _of_task(request, progress, stop, second)


def _of_task(
    request: Request, progress: MakeProgress | None, stop: StopRequest, second: SecondStart | None
) -> tuple[Design, tuple[str, ...]]:
    """Design for the task as it is."""
    robot, task, options = request.robot, request.task, request.options
    if request.starts == 1:
        found = design(robot, task, options, start=request.start, on_progress=progress, stop=stop)
        return found, ()

    sigma, seed = request.noise
    report = many_starts(
        robot, task, options, count=request.starts, seed=seed, sigma=sigma,
        workers=_workers(request), start=request.start, second=second,
        on_progress=progress, stop=stop,
    )  # fmt: skip
    first, *optima = report.sentences
    return report.design, (f"{first}; costs at the samples, before refinement:", *optima)


def _search(request: Request, quiet: bool, second: SecondStart | None) -> Design:
    """Search with a report on the screen.

    Raises:
        GaitoptError: no gait was found.
        StoppedError: Ctrl-C was pressed before there was a walk.
    """
    if quiet:
        with stop_on_interrupt() as stop:
            found, _ = _designed(request, None, stop, second)
    else:
        from gaitopt.cli.display import ProgressDisplay

        errors = _screen(stderr=True)
        with (
            stop_on_interrupt(announce=not errors.is_terminal) as stop,  # else its table says so
            ProgressDisplay(errors, stop, quiet) as progress,
        ):
            found, said = _designed(request, progress, stop, second)
            progress.finish(found.solution, request.task.cost_unit)
        margins = request.task.margins
        narrowed = narrowed_gaps(request.robot, margins.leg_gap, margins.arm_gap)
        for sentence in (*said, *narrowed):
            errors.print(sentence)
    if found.solution.status is Status.INTERRUPTED:
        _warn(
            "interrupted",
            "this is the best gait so far; it walks, but the search for a better one was not "
            "finished",
        )
    return found


def _fastest_walk(request: Request, quiet: bool) -> tuple[Request, Design]:
    """Search the fastest walk; return it with the request that would lead to it.

    Raises:
        InputError: first guesses were asked for, which this search makes itself.
        NoGaitFoundError: there is no walk at the speed to begin with.
        StoppedError: Ctrl-C was pressed before there was a walk.
    """
    from gaitopt.sweep.speed_search import fastest

    if "starts" in request.settings or request.start is not None:
        raise InputError(
            "--fastest starts each walk from a slower one; leave out --start, --starts, --seed and "
            "--sigma, here and in the configuration file"
        )

    def task_at(speed: float) -> Task:
        return make_task({**request.settings, "speed": speed}, request.robot)

    def tell(speed: float, found: Design | None) -> None:
        unit = request.task.cost_unit
        result = "no walk" if found is None else f"J = {fixed(found.solution.cost, 1)} {unit}"
        if not quiet:
            _screen(stderr=True).print(f"{fixed(speed, 3)} m/s: {result}")

    with stop_on_interrupt() as stop:
        best = fastest(
            request.robot, task_at, request.task.speed, request.options, on_try=tell, stop=stop
        )
    found = best.design
    if best.interrupted:
        found = replace(found, solution=replace(found.solution, status=Status.INTERRUPTED))
        _warn(
            "interrupted",
            f"{best.speed:g} m/s is the fastest walk so far; the search for a faster one was not "
            "finished",
        )
    if not quiet:
        for line in limit_lines(best):
            _screen(stderr=True).print(line)
    settings = {**request.settings, "speed": best.speed}
    return replace(request, task=task_at(best.speed), settings=settings), found


def limit_lines(best: Fastest) -> list[str]:
    """Return what ended the search, and a line for each constraint at its limit."""
    rows = [row for row in best.design.certificate.constraints if row.sentence in best.binding]
    lines = [f"no walk was found at {fixed(best.refused, 3)} m/s"] if isfinite(best.refused) else []
    lines += [f"at their limits at {fixed(best.speed, 3)} m/s:"] if rows else []
    lines += [f"- {_at_limit(row)}" for row in rows[:_MOST]]
    return lines + ([f"- and {len(rows) - _MOST} more"] if len(rows) > _MOST else [])


def _at_limit(row: WorstRow) -> str:
    when = "" if row.time is None else f" at {fixed(row.time, 3)} s"
    return f"{row.row}{when}: {rounded(row.value)} {row.unit}, limit {rounded(row.limit)}"
