"""Sweeps small enough for tests."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.design.options import DesignOptions
from gaitopt.gait.presets import preset_task
from gaitopt.gait.task import Task
from gaitopt.solvers import solver_by_name
from gaitopt.sweep import scheduler
from gaitopt.sweep.database import digest, record_digest
from gaitopt.sweep.executor import Job, JobOutcome, run_job
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.library import Library

SPEEDS = Axis("speed", (0.95, 1.0, 1.05, 1.1))
QUICK = DesignOptions(solver=solver_by_name("sqp"), refine=False, diagnose=False)


def quick_task(**changes: object) -> Task:
    """A walk with few samples."""
    return preset_task(**{"speed": 1.0, "samples": 15, **changes})


def forget_digests(directory: Path) -> None:
    """Make a library that does not vouch for any file."""
    rewrite(directory, lambda name, record: record.update(file_digest=""))


def vouch(directory: Path) -> None:
    """Make a library that vouches for the gait files as they are."""

    def vouched(name: str, record: dict[str, Any]) -> None:
        if record["row"] is not None:
            record["file_digest"] = digest((directory / record["row"]["file"]).read_bytes())

    rewrite(directory, vouched)


def rewrite(directory: Path, change: Callable[[str, dict[str, Any]], object]) -> None:
    """Change the records of points, each valid afterwards."""
    with closing(sqlite3.connect(directory / "library.sqlite")) as connection, connection:
        for name, text in connection.execute("SELECT name, record FROM points").fetchall():
            record = json.loads(text)
            change(name, record)
            text = json.dumps(record)
            connection.execute(
                "UPDATE points SET record = ?, digest = ? WHERE name = ?",
                (text, record_digest(name, text), name),
            )


def seconds(directory: Path) -> dict[str, float]:
    """Return for how long each point was worked on."""
    with closing(sqlite3.connect(directory / "library.sqlite")) as connection:
        found = connection.execute("SELECT name, record FROM points").fetchall()
    return {name: json.loads(record)["seconds"] for name, record in found}


class Counting:
    """Lists the jobs that this process does; ends the work after some. A context manager."""

    def __init__(self, most: int = 10**9) -> None:
        self._most = most
        self.done: list[Job] = []

    def __enter__(self) -> Counting:
        scheduler.run_job = self.run
        return self

    def __exit__(self, *_: object) -> None:
        scheduler.run_job = run_job

    def run(self, job: Job) -> JobOutcome:
        if len(self.done) >= self._most:
            raise KeyboardInterrupt
        self.done.append(job)
        return run_job(job)


def damage(record, chance):
    """Put another value in place of one somewhere in a record, or leave out an entry."""
    place = record
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return
        key = chance.choice(keys)
        inner = place[key]
        if isinstance(inner, dict | list) and inner and chance.random() < 0.7:
            place = inner
            continue
        if chance.random() < 0.3:
            del place[key]
        else:
            place[key] = chance.choice([None, 3, -1, "text", [], {}, [[1]], 1e300, True])
        return


def costs(library: Library) -> dict[object, object]:
    """The cost of each gait of a library, by its speed."""
    return {row["speed"]: row["cost"] for row in library.rows}


def gaits(directory: Path) -> dict[str, dict[str, object]]:
    """What the gait files of a library hold, to the bit, but for the time that was spent."""
    found: dict[str, dict[str, object]] = {}
    for path in directory.glob("gaits/*.npz"):
        with np.load(path) as content:
            own = {name: content[name].tobytes() for name in content.files if name != "digest"}
            meta = json.loads(str(content["meta"]))
        del meta["solver"]["seconds"]
        found[path.name] = {**own, "meta": meta}
    return found


def run(*words: object) -> Any:
    """What the command line answers; what it does not catch is raised."""
    return CliRunner().invoke(app, [str(word) for word in words], catch_exceptions=False)
