"""Sweeps small enough for tests."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gaitopt.design.options import DesignOptions
from gaitopt.gait.task import Task, preset_task
from gaitopt.solvers import solver_by_name
from gaitopt.sweep.executor import Alone, Crew, Job, Outcome
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.library import digest

SPEEDS = Axis("speed", (0.95, 1.0, 1.05, 1.1))
QUICK = DesignOptions(solver=solver_by_name("sqp"), refine=False, diagnose=False)


def quick_task(**changes: object) -> Task:
    """A walk with few samples."""
    return preset_task(**{"speed": 1.0, "samples": 15, **changes})


def forget_digests(directory: Path) -> None:
    """Make a journal that does not vouch for any file."""
    _rewrite(directory, lambda entry: {k: v for k, v in entry.items() if k != "digest"})


def vouch(directory: Path) -> None:
    """Make a journal that vouches for the gait files as they are."""

    def vouched(entry: dict[str, Any]) -> dict[str, Any]:
        if "row" not in entry:
            return entry
        return {**entry, "digest": digest(directory / entry["row"]["file"])}

    _rewrite(directory, vouched)


def _rewrite(directory: Path, change: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    journal = directory / "journal.jsonl"
    entries = [change(json.loads(line)) for line in journal.read_text().splitlines()]
    journal.write_text("".join(json.dumps(entry) + "\n" for entry in entries))


class Counting(Crew):
    """This process, with a list of what was done; ends the work after some jobs."""

    def __init__(self, most: int = 10**9) -> None:
        self._crew, self._most = Alone(), most
        self.room = self._crew.room
        self.done: list[Job] = []

    def submit(self, job: Job) -> None:
        if len(self.done) >= self._most:
            raise KeyboardInterrupt
        self.done.append(job)
        self._crew.submit(job)

    def next(self) -> Outcome:
        return self._crew.next()

    def close(self) -> None:
        self._crew.close()
