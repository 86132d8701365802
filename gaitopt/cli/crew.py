"""Who does the work of `gaitopt sweep`."""

from __future__ import annotations

import math
import os

from rich.console import Console

from gaitopt.bounds import WORKERS, at_most
from gaitopt.cli.config import Settings
from gaitopt.errors import InputError
from gaitopt.sweep.executor import Alone, Crew
from gaitopt.sweep.grid import Axis


def make_crew(given: Settings, axes: list[Axis], errors: Console, quiet: bool) -> Crew:
    """Return the crew of a sweep; no more local workers than points or processors.

    Args:
        given: options of the command line.
        axes: of the sweep.
        errors: where to say that workers are being started.
        quiet: whether not to.

    Raises:
        InputError: fewer than one worker, two kinds of crew, or no scheduler where one is said.
        MissingExtraError: Dask distributed is not installed.
    """
    workers, scheduler = given.get("workers"), given.get("scheduler")
    if workers is not None and scheduler is not None:
        raise InputError("--workers and --scheduler exclude each other; give one of them")
    if workers is None and scheduler is None:
        return Alone()
    from gaitopt.sweep.executor import LaterCrew, joined_crew

    if workers is None:
        return joined_crew(str(scheduler))
    at_most(int(str(workers)), WORKERS, "workers")
    wanted, points = int(str(workers)), math.prod(len(axis.values) for axis in axes)
    count = min(wanted, points, processors())

    def tell() -> None:
        few = "" if count == wanted else f", not {wanted}: {_few(points)}"
        if not quiet:
            errors.print(f"starting workers: {count}{few}", soft_wrap=True)

    return LaterCrew(count, tell)


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _few(points: int) -> str:
    if points < processors():
        return f"more are idle with {points} point{'s' * (points != 1)}"
    return "this machine has no more processors; --scheduler joins others"
