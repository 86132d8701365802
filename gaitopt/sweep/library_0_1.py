"""Libraries of version 0.1, a manifest and a journal of events, as records of today."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from os.path import exists
from pathlib import Path
from typing import Any

from gaitopt.bounds import JOURNAL as JOURNAL_BYTES
from gaitopt.bounds import MANIFEST as MANIFEST_BYTES
from gaitopt.bounds import read_bounded
from gaitopt.errors import GaitFileError, InputError, reason_of
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.sweep.database import (
    DAMAGE,
    Record,
    damaged,
    grid_of,
    no_library,
    of_another_format,
    robot_source_of,
    robot_source_record,
)
from gaitopt.sweep.grid import TaskGrid

MANIFEST, JOURNAL = "manifest.json", "journal.jsonl"
_FORMAT = 2

_NEW: Record = {
    "explored": False, "walk": None, "cold_started": False, "due": None, "tried": [], "row": None,
    "file_digest": "", "refusal": None, "fault": "", "seconds": 0.0,
}  # fmt: skip
_WALK = {"slopes": "cost_gradient", "journey": "first_iterations"}  # names of entries then and now


def read_library_0_1(directory: Path) -> tuple[Record, dict[str, Any]] | None:
    """Return manifest and records of points by name, as `read_database`, None if there are none.

    Raises:
        GaitFileError: the manifest is damaged, or of a format that version 0.1 did not have.
        InputError: a line of the journal is not what a sweep wrote.
    """
    path = directory / MANIFEST
    if not exists(path):
        return None
    try:
        record = json.loads(read_bounded(path, MANIFEST_BYTES))
    except (OSError, ValueError, RecursionError) as error:
        raise no_library(directory, MANIFEST) from error
    if not isinstance(record, dict) or record.get("format") != _FORMAT:
        form = record.get("format") if isinstance(record, dict) else None
        raise of_another_format(path, form, _FORMAT)
    grid = grid_of(directory, record)
    robot = robot_source_of(directory, record)
    try:
        now = {
            **record,
            "first task": task_record(task_from_record(record["first task"])),
            "robot": robot_source_record(robot),
        }
    except (*DAMAGE, InputError, GaitFileError) as error:
        raise damaged(directory, "its task", error) from error
    records: dict[str, Any] = {}
    journal = directory / JOURNAL
    for number, entry in _lines(journal):
        try:
            _take(records, entry, grid)
        except DAMAGE as error:
            raise _line_damaged(number, journal) from error
    return dict(json.loads(json.dumps(now))), records


def _lines(path: Path) -> Iterator[tuple[int, Any]]:
    """Yield number and event of every line; a last one that was never completed is left out."""
    try:
        data = read_bounded(path, JOURNAL_BYTES) if exists(path) else b""
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read '{path}': {reason_of(error)}") from error
    lines = data.split(b"\n")[:-1]
    for number, line in enumerate(lines, start=1):
        try:
            yield number, json.loads(line)
        except (ValueError, RecursionError) as error:
            if number == len(lines):
                return
            raise _line_damaged(number, path) from error


def _line_damaged(number: int, path: Path) -> InputError:
    return InputError(
        f"line {number} of '{path}' is damaged; remove the line to compute its point again"
    )


def _take(records: dict[str, Any], entry: Mapping[str, Any], grid: TaskGrid) -> None:
    """Change records by one event."""

    def record(place: Any) -> Record:
        point = tuple(place)
        if point not in grid:
            raise ValueError("it is of a point that the sweep does not have")
        return records.setdefault(grid.name(point), {**_NEW, "tried": []})  # type: ignore[no-any-return]

    here = record(entry["point"])
    here["seconds"] += float(entry.get("seconds", 0.0))
    for place, other in entry.get("round", ()):
        record(place)["due"] = list(other)
    if "tried" in entry:
        here["due"] = None
        here["tried"] += [[list(other), float(cost)] for other, cost in entry["tried"]]
    if "footing" in entry:
        walk = entry["footing"]
        here["explored"] = True
        here["walk"] = walk and {_WALK.get(name, name): value for name, value in walk.items()}
    if entry.get("probed"):
        here["cold_started"] = True
    if "row" in entry:
        here["row"], here["file_digest"] = entry["row"], entry.get("digest", "")
    if "faulty" in entry:
        for known in records.values():
            known["fault"] = ""
        for place, fault in entry["faulty"]:
            record(place)["fault"] = fault
    if "refusal" in entry:
        here["refusal"] = entry["refusal"]
