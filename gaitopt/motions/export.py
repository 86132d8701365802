"""Write a gait, or every gait of a library, in a form that other programs read."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path

from gaitopt.atomic import make_directory, write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition
from gaitopt.motions.formats import MotionFormat, format_named
from gaitopt.motions.motion import motion
from gaitopt.motions.stride import export_step
from gaitopt.sweep.grid import Index
from gaitopt.sweep.library import Library, open_library
from gaitopt.sweep.table import Row

INDEX = "index.csv"
"""Table of the motions of a library."""

_SAME_SPEED = 1e-6  # m/s: gaits of a library of Bezier curves differ by more


def export(
    gait: Gait,
    path: str | Path,
    *,
    both_legs: bool = False,
    format: str | None = None,  # noqa: A002  # as on the command line
    rate: float | None = None,
    strides: float | None = None,
    joints: str | Sequence[str] | None = None,
) -> Path:
    """Write a gait for a controller, an engine or a learner, atomically.

    Args:
        gait: what to write.
        path: file; without a format its suffix chooses the form: .csv, .json, .yaml or .yml with
            the samples of the gait file.
        both_legs: whether those are of a whole stride, not of one step; only without a format.
        format: name of a form of motions, a key of `formats.FORMATS`.
        rate: samples a second [Hz]; by default that of the format.
        strides: number of strides of two steps, 1 by default; halves are steps.
        joints: order of the joints: "gait", "mujoco", "isaac", "g1", or names; by default that of
            the format.

    Returns:
        The path written.

    Raises:
        InputError: the form is unknown, what is asked does not go with it, or the path cannot be
            written.
        RobotError: the gait holds no robot, and its URDF is not one.
    """
    asked = {"rate": rate, "strides": strides, "joints": joints}
    given = [name for name, value in asked.items() if value is not None]
    if format is None:
        if given:
            raise InputError(
                f"{' and '.join(given)}: only motions of a named format take that; name one, as "
                "format 'mujoco'"
            )
        return export_step(gait, path, both_legs=both_legs)
    form = form_for(path, format)
    if both_legs:
        raise InputError(
            f"both legs are in every motion; leave that out with format '{format}', or ask for "
            "strides"
        )
    return write_atomically(path, _content(gait, form, rate, strides, joints))


def form_for(path: str | Path, format: str) -> MotionFormat:  # noqa: A002
    """Return the form of motions of a name, for a file.

    Raises:
        InputError: there is none, or the name of the file ends otherwise.
    """
    form = format_named(format)
    if Path(path).suffix.lower() != form.suffix:
        raise InputError(f"cannot write '{path}': files of format '{format}' end in {form.suffix}")
    return form


def export_transition(
    transition: Transition,
    path: str | Path,
    *,
    format: str,  # noqa: A002
    rate: float | None = None,
    joints: str | Sequence[str] | None = None,
) -> Path:
    """Write a transition as a motion, with what it leads from and to, atomically.

    A stride of the walk before, or half a second of rest; the steps; the same after them.

    Args:
        transition: what to write.
        path: file.
        format, rate, joints: as in `export`.

    Returns:
        The path written.

    Raises:
        InputError: as in `export`, or the form has no samples.
    """
    form = form_for(path, format)
    return write_atomically(path, _content(transition, form, rate, None, joints))


def export_library(
    library: Library | str | Path,
    directory: str | Path,
    *,
    format: str,  # noqa: A002
    rate: float | None = None,
    strides: float | None = None,
    joints: str | Sequence[str] | None = None,
) -> Path:
    """Write every gait of a library in one form, and a table of what is where.

    Points without a gait, or whose file cannot be used, are lines without a file.

    Args:
        library: of gaits, or its directory.
        directory: where to write; made if it does not exist.
        format, rate, strides, joints: as in `export`.

    Returns:
        The path of the table: file, the quantities swept, speed [m/s], step duration [s], step
        length [m], cost, status.

    Raises:
        GaitFileError: it is no gait library.
        InputError: as in `export`, or the library has no gait.
    """
    form = format_named(format)
    folder = Path(directory)
    found = library if isinstance(library, Library) else open_library(library)
    if folder.resolve() == found.directory.resolve():
        raise InputError(f"'{folder}' is the library itself; give another directory")
    axes = [axis.name for axis in found.grid.axes]
    there = {
        point: found.gait(point)
        for point, state in sorted(found.states.items())
        if state.row is not None and point not in found.faults
    }
    if not there:
        raise InputError(f"the library '{found.directory}' has no gait that can be exported")
    names = _file_names(form, {point: gait.speed for point, gait in there.items()}, found)
    make_directory(folder)
    rows = []
    for point, row in zip(sorted(found.states), found.rows, strict=True):
        line: Row = {"file": None, **{axis: row.get(axis) for axis in axes}}
        if point in there:
            gait = there[point]
            content = _content(gait, form, rate, strides, joints)
            line["file"] = write_atomically(folder / names[point], content).name
            line |= {"speed": gait.speed, "duration": gait.duration}
            line |= {"lateral_speed": gait.lateral_speed, "turn_rate": gait.turn_rate}
            line |= {"step_length": gait.step_length, "cost": gait.cost}
        rows.append({**line, "status": row.get("status")})
    return write_atomically(folder / INDEX, _index_text(rows, axes))


def _content(
    gait: Gait | Transition,
    form: MotionFormat,
    rate: float | None,
    strides: float | None,
    joints: str | Sequence[str] | None,
) -> bytes:
    if not form.sampled and (rate is not None or strides is not None):
        raise InputError(
            f"format '{form.name}' has curves, not samples; leave rate and strides out"
        )
    return form.content(
        motion(
            gait,
            form.rate if rate is None else rate,
            1.0 if strides is None else strides,
            form.joints if joints is None else joints,
        )
    )


def _file_names(
    form: MotionFormat, speeds: Mapping[Index, float], library: Library
) -> dict[Index, str]:
    """Return names of files by point; learners on Bezier libraries want them numbered by speed."""
    if form.name != "bezier":
        return {point: f"{library.grid.name(point)}{form.suffix}" for point in speeds}
    order = sorted(speeds, key=lambda point: speeds[point])
    for one, other in pairwise(order):
        if speeds[other] - speeds[one] < _SAME_SPEED:
            raise InputError(
                f"{library.grid.name(one)} and {library.grid.name(other)} walk at the same speed; "
                "a library of Bezier curves has one gait a velocity: sweep the speed alone"
            )
    return {point: f"v_{k + 1}_1{form.suffix}" for k, point in enumerate(order)}


def _index_text(rows: list[Row], axes: list[str]) -> bytes:
    known = ["speed", "lateral_speed", "turn_rate", "duration", "step_length", "cost", "status"]
    columns = dict.fromkeys(["file", *axes, *known])
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    for row in rows:
        writer.writerow(["" if row.get(c) is None else row[c] for c in columns])
    return buffer.getvalue().encode()
