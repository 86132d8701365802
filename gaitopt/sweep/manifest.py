"""What a gait library is a library of, and in what two sweeps differ."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gaitopt.atomic import is_leftover, write_atomically
from gaitopt.bounds import MANIFEST, read_bounded
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.parameters import merged
from gaitopt.design.options import DesignOptions
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.task import Task
from gaitopt.gait.task_record import task_record
from gaitopt.model.import_options import choices_from_record, choices_record
from gaitopt.sweep.grid import Axis, GridPoints, Index
from gaitopt.sweep.scenario import RobotSource
from gaitopt.version import __version__

Entry = tuple[str, ...]
Found = tuple[Entry, Any, Any]

_PARTS = {
    ("first task", "margins"): "limit",
    ("first task", "geometry"): "",
    ("first task",): "",
    ("options", "solver options", "travel"): "solver option",
    ("options", "solver options", "certify"): "second solver's option",
    ("options", "solver options"): "solver option",
    ("options",): "option",
}
"""What to call the entries below each part of a record; the longest that fits counts."""


def difference(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    """Return the first thing in which two records of sweeps differ, the robot first, or None.

    Robots are the same if their URDF and what was chosen about it are: the specification from which
    a URDF was made counts only where a sweep changes it.

    Args:
        there, asked: as of `manifest_record`.
    """
    return _robot(there, asked) or _points(there, asked) or _rest(there, asked)


def _robot(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    a, b = there["robot"], asked["robot"]
    names = _name(a["urdf"]), _name(b["urdf"])
    same = a["urdf"] == b["urdf"]
    if names[0] != names[1]:
        return f"it is of the robot '{names[0]}', asked for is '{names[1]}'"
    varied = any("." in axis and axis.split(".")[0] in (a["spec"] or ()) for axis in there["axes"])
    if not same or varied:
        found = first_difference(a["spec"], b["spec"])
        if found is not None and a["spec"] and b["spec"]:
            return f"of its robot '{names[0]}', {_compared(*found)}"
        if not same or found is not None:
            return f"it is of another robot named '{names[0]}': their URDF or tables differ"
    found = first_difference(a["choices"], b["choices"])
    return None if found is None else f"of what was chosen about its robot, {_compared(*found)}"


def _points(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    if [*there["axes"]] != [*asked["axes"]]:
        return f"it is over {', '.join(there['axes'])}, asked for is {', '.join(asked['axes'])}"
    found = first_difference(there["axes"], asked["axes"])
    if found is not None:
        (name, *_), old, new = found
        return f"its values of {name} are {_short(old)}, asked for are {_short(new)}"
    if there["seeds"] != asked["seeds"]:
        return "it began at other points than is asked for"
    return None


def _rest(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    parts = ("first task", "options")
    found = first_difference({p: there[p] for p in parts}, {p: asked[p] for p in parts})
    if found is None:
        return None
    path, old, new = found
    whole = max((p for p in _PARTS if path[: len(p)] == p), key=len)
    return f"its {_compared((_PARTS[whole], *path[len(whole) :]), old, new)}"


def first_difference(there: Any, asked: Any) -> Found | None:
    """Return the first entry in which two records differ: its path and both values."""
    if isinstance(there, Mapping) and isinstance(asked, Mapping):
        for key in dict.fromkeys([*asked, *there]):
            found = first_difference(there.get(key), asked.get(key))
            if found is not None:
                path, old, new = found
                return (key, *path), old, new
        return None
    return None if there == asked else ((), there, asked)


def _compared(path: Entry, old: object, new: object) -> str:
    name = " ".join(filter(None, path))
    return f"{name} is {_short(old)}, asked for is {_short(new)}"


def _name(urdf: str) -> str:
    found = re.search(r"<(?:robot|mujoco)\b[^>]*?\b(?:name|model)\s*=\s*[\"']([^\"']*)", urdf)
    return found[1] if found else "without a name"


def _short(value: object) -> str:
    text = "none" if value is None else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."


NAME, FORMAT = "manifest.json", 2

Record = dict[str, Any]
_DAMAGE = (KeyError, TypeError, ValueError, AttributeError, IndexError)


def manifest_record(
    points: GridPoints, robot: RobotSource, tasks: Mapping[Index, Task], options: DesignOptions
) -> Record:
    """Return what decides the gaits of a sweep, JSON-able: grid, robot, options, first task.

    The other tasks follow from the first and the axes. What a caller's own `task_at` makes of the
    axes beyond that is not seen.
    """
    solver = options.solver
    record = {
        "format": FORMAT,
        "gaitopt": __version__,
        "axes": {axis.name: list(axis.values) for axis in points.axes},
        "seeds": [list(seed) for seed in points.seeds],
        "first task": task_record(tasks[points.order[0]]),
        "robot": {
            "digest": robot.digest(),
            "choices": choices_record(robot.choices),
            "spec": None if robot.spec is None else asdict(robot.spec),
            "urdf": robot.urdf,
        },
        "options": {
            "solver": solver.name,
            "solver options": asdict(solver),  # type: ignore[call-overload]
            "refine": options.refine,
            "differences": options.differences,
            "approach": options.approach,
        },
    }
    return dict(json.loads(json.dumps(record)))


def claim(directory: Path, record: Record) -> None:
    """Make a directory the library of a record, or see that it is already.

    Raises:
        InputError: it cannot be written, or holds something else.
    """
    path = directory / NAME
    if path.exists():
        there = read_manifest(directory)
        try:
            found = difference(there, record)
        except _DAMAGE as error:
            raise _damaged(directory, "some of its entries", error) from error
        if found is not None:
            raise InputError(
                f"'{directory}' holds another sweep: {found}; give another directory, or ask for "
                "the same again"
            )
        return
    try:
        directory.mkdir(parents=True, exist_ok=True)
        others = sorted(e.name for e in directory.iterdir() if not is_leftover(e))
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise InputError(f"cannot make the directory '{directory}': {reason}") from error
    if others:
        raise InputError(
            f"'{directory}' holds '{others[0]}' but no sweep; give an empty or a new directory"
        )
    write_atomically(path, (json.dumps(record, indent=1) + "\n").encode())


def read_manifest(directory: Path) -> Record:
    """Return the record of a library.

    Raises:
        GaitFileError: the directory is no gait library, or of a newer format.
    """
    path = directory / NAME
    try:
        record = json.loads(read_bounded(path, MANIFEST))
    except (OSError, ValueError, RecursionError) as error:
        raise GaitFileError(
            f"'{directory}' is no gait library: it has no readable {NAME}; give a directory that "
            "gaitopt sweep has written"
        ) from error
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise GaitFileError(
            f"'{path}' is of another format than {FORMAT}, which this gaitopt reads; make the "
            "library again, in another directory"
        )
    return record


def points_of(directory: Path, record: Record) -> GridPoints:
    """Return the grid of a record.

    Args:
        directory: where it was read, for messages.
        record: as of `read_manifest`.

    Raises:
        GaitFileError: the record does not tell it.
    """
    try:
        axes = tuple(Axis(name, tuple(values)) for name, values in record["axes"].items())
        points = GridPoints(axes, tuple(tuple(seed) for seed in record["seeds"]))
        for seed in points.seeds:
            points.values(seed)
    except (*_DAMAGE, InputError) as error:
        raise _damaged(directory, "its axes and seeds", error) from error
    return points


def _damaged(directory: Path, what: str, error: Exception) -> GaitFileError:
    reason = str(error) if isinstance(error, InputError) else "they are not there, or of no use"
    return GaitFileError(
        f"'{directory / NAME}' is damaged in {what}: {reason}; make the library again, in another "
        "directory"
    )


def robot_of(record: Record) -> RobotSource:
    """Return the robot of a record, without the changes of a point.

    Raises:
        GaitFileError: the record does not tell it.
        InputError: what it tells is no robot.
    """
    try:
        robot = record["robot"]
        urdf, choices, spec = str(robot["urdf"]), robot["choices"], robot["spec"]
        return RobotSource(
            urdf,
            choices_from_record(choices),
            None if spec is None else merged(biped13(), spec),
        )
    except _DAMAGE as error:
        raise GaitFileError(
            "the manifest of the library is damaged in its robot; make the library again, in "
            "another directory"
        ) from error
