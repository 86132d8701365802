"""`gaitopt export`: gaits, transitions and libraries for controllers, engines and learners."""

from __future__ import annotations

import csv
from pathlib import Path

import typer

from gaitopt.atomic import write_atomically
from gaitopt.cli.show import loaded, loaded_motion
from gaitopt.errors import InputError
from gaitopt.gait.transition import Transition
from gaitopt.motions.export import INDEX, export, export_library, export_transition
from gaitopt.motions.formats import format_named

MJCF = "mjcf"
"""Format of the MuJoCo model of a gait; it needs MuJoCo, and is no form of motions alone."""


def run(
    path: Path,
    output: Path | None,
    *,
    name: str | None,
    rate: float | None,
    strides: float | None,
    joints: str | None,
    both_legs: bool,
) -> None:
    """Write a gait, a transition, or every gait of a library, for other programs.

    Args:
        path: of the file, or the library's directory.
        output: file, or directory for a library; by default next to what is exported, with the
            name of the format.
        name: of the format.
        rate, strides, joints, both_legs: as in `gaitopt.export`.

    Raises:
        GaitoptError: the gait cannot be read, what is asked cannot be had, or not be written.
        InputError: the options contradict each other, or one is missing.
    """
    if name == MJCF:
        _write_mjcf(path, output, rate, strides, joints, both_legs)
        return
    form = None if name is None else format_named(name)
    if form is None and output is None:
        raise InputError(
            "Missing option '--output': give a file, .csv, .json or .yaml; or name a --format"
        )
    if path.is_dir():
        if form is None:
            raise InputError(f"'{path}' is a directory; name a --format for its gaits")
        if both_legs:
            raise InputError("--both-legs goes without --format: motions have both")
        folder = output or path.with_name(f"{path.resolve().name}-{form.name}")
        index = export_library(
            path, folder, format=form.name, rate=rate, strides=strides, joints=joints
        )
        with index.open(newline="", encoding="utf-8") as stream:
            files = sum(bool(row["file"]) for row in csv.DictReader(stream))
        typer.echo(f"wrote {files} motions and {INDEX} in {folder}")
        return
    target = output
    if target is None:
        assert form is not None
        target = path.with_name(f"{path.stem}-{form.name}{form.suffix}")
    if target.exists() and path.exists() and target.samefile(path):
        raise InputError(f"'{target}' is the gait itself; give another file to write")
    found = loaded_motion(path)
    if isinstance(found, Transition):
        written = _export_transition(found, target, name, rate, strides, joints, both_legs)
    else:
        written = export(
            found, target, both_legs=both_legs, format=name, rate=rate, strides=strides,
            joints=joints,
        )  # fmt: skip
    typer.echo(f"wrote {written}")


def _export_transition(
    transition: Transition,
    target: Path,
    name: str | None,
    rate: float | None,
    strides: float | None,
    joints: str | None,
    both_legs: bool,
) -> Path:
    """Write a transition as a motion."""
    if name is None:
        raise InputError("a transition is written as a motion: name a --format, as --format mujoco")
    for given, option in ((strides is not None, "--strides"), (both_legs, "--both-legs")):
        if given:
            raise InputError(f"{option} is for walks, and this is a transition; leave it out")
    return export_transition(transition, target, format=name, rate=rate, joints=joints)


def _write_mjcf(
    path: Path,
    output: Path | None,
    rate: float | None,
    strides: float | None,
    joints: str | None,
    both_legs: bool,
) -> None:
    """Write the robot of a gait with its walk as keyframes."""
    for given, option in ((joints is not None, "--joints"), (both_legs, "--both-legs")):
        if given:
            raise InputError(f"{option} does not go with --format {MJCF}; leave it out")
    if path.is_dir():
        raise InputError(f"'{path}' is a directory; --format {MJCF} writes one gait, a .npz")
    target = output or path.with_name(f"{path.stem}-{MJCF}.xml")
    if target.suffix.lower() != ".xml":
        raise InputError(f"cannot write '{target}': files of format '{MJCF}' end in .xml")
    from gaitopt.simulate.mujoco_model import RATE, mjcf_text

    text = mjcf_text(
        loaded(path), RATE if rate is None else rate, 1.0 if strides is None else strides
    )
    typer.echo(f"wrote {write_atomically(target, text.encode())}")
