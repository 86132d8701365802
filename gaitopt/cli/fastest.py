"""`gaitopt optimise --fastest`: the fastest walk, and what stops a faster one."""

from __future__ import annotations

from dataclasses import replace
from math import isfinite

from rich.console import Console

from gaitopt.bounds import rounded
from gaitopt.cli.display import warn
from gaitopt.cli.process import stop_on_interrupt
from gaitopt.cli.request import Request, make_task
from gaitopt.design.certificate import WorstRow
from gaitopt.design.pipeline import Design
from gaitopt.errors import InputError
from gaitopt.gait.task import Task
from gaitopt.nlp import Status
from gaitopt.sweep.speed_search import Fastest, fastest

_MOST = 8  # constraints at their limits that are told


def fastest_walk(request: Request, console: Console, quiet: bool) -> tuple[Request, Design]:
    """Search the fastest walk; return it with the request that would lead to it.

    Where Ctrl-C ended the search, the design says so by its solution's status.

    Raises:
        InputError: first guesses were asked for, which this search makes itself.
        NoGaitFoundError: there is no walk at the speed to begin with.
        StoppedError: Ctrl-C was pressed before there was a walk.
    """
    if "starts" in request.settings or request.start is not None:
        raise InputError(
            "--fastest starts each walk from a slower one; leave out --start, --starts, --seed and "
            "--sigma, here and in the configuration file"
        )

    def task_at(speed: float) -> Task:
        return make_task({**request.settings, "speed": speed}, request.robot)

    def tell(speed: float, found: Design | None) -> None:
        unit = request.task.cost_unit
        result = "no walk" if found is None else f"J = {found.solution.cost:.1f} {unit}"
        if not quiet:
            console.print(f"{speed:.3f} m/s: {result}")

    with stop_on_interrupt() as stop:
        best = fastest(
            request.robot, task_at, request.task.speed, request.options, on_try=tell, stop=stop
        )
    found = best.design
    if best.interrupted:
        found = replace(found, solution=replace(found.solution, status=Status.INTERRUPTED))
        warn(
            console,
            "interrupted",
            f"{best.speed:g} m/s is the fastest walk so far; the search for a faster one was not "
            "finished",
        )
    if not quiet:
        for line in limit_lines(best):
            console.print(line, soft_wrap=True)
    settings = {**request.settings, "speed": best.speed}
    return replace(request, task=task_at(best.speed), settings=settings), found


def limit_lines(best: Fastest) -> list[str]:
    """Return what ended the search, and a line for each constraint at its limit."""
    rows = [row for row in best.design.certificate.constraints if row.sentence in best.binding]
    lines = [f"no walk was found at {best.refused:.3f} m/s"] if isfinite(best.refused) else []
    lines += [f"at their limits at {best.speed:.3f} m/s:"] if rows else []
    lines += [f"- {_at_limit(row)}" for row in rows[:_MOST]]
    return lines + ([f"- and {len(rows) - _MOST} more"] if len(rows) > _MOST else [])


def _at_limit(row: WorstRow) -> str:
    when = "" if row.time is None else f" at {row.time:.3f} s"
    return f"{row.row}{when}: {rounded(row.value)} {row.unit}, limit {rounded(row.limit)}"
