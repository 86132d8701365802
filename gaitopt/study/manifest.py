"""What a gait library is a library of; a sweep of anything else must not be mixed in."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gaitopt.atomic import is_leftover, write_atomically
from gaitopt.bounds import MANIFEST, read_bounded
from gaitopt.design.options import DesignOptions
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.task import Task
from gaitopt.gait.task_record import task_record
from gaitopt.robot.choices_file import choices_from_record, choices_record
from gaitopt.robot.generated.presets import biped13
from gaitopt.robot.generated.spec_table import merged
from gaitopt.study.axes import Axis
from gaitopt.study.difference import difference
from gaitopt.study.grid_points import GridPoints, Index
from gaitopt.study.setting import RobotSource
from gaitopt.version import __version__

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
