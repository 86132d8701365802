"""`gaitopt export`: gaits, transitions and libraries for controllers, engines and learners."""

from __future__ import annotations

import csv
from os.path import isdir, realpath
from pathlib import Path

import typer

from gaitopt.atomic import write_atomically
from gaitopt.cli.command_options import ExportOptions
from gaitopt.cli.process import refuse_options
from gaitopt.cli.show import loaded, loaded_motion
from gaitopt.errors import InputError
from gaitopt.gait.transition import Transition
from gaitopt.motions.export import INDEX, export, export_library, export_transition, format_named

MJCF = "mjcf"
"""Format of the MuJoCo model of a gait; it needs MuJoCo, and is no form of motions alone."""


def run(asked: ExportOptions) -> None:
    """Write a gait, a transition, or every gait of a library, for other programs.

    Raises:
        InputError: the options contradict each other, or one is missing.
    """
    path, output, name = asked.gait, asked.output, asked.format
    if name == MJCF:
        _write_mjcf(asked)
        return
    form = None if name is None else format_named(name, MJCF)
    if form is None and output is None:
        raise InputError(
            "Missing option '--output': give a file, .csv, .json or .yaml; or name a --format"
        )
    if isdir(path):
        if form is None:
            raise InputError(f"'{path}' is a directory; name a --format for its gaits")
        if asked.both_legs:
            raise InputError("--both-legs goes without --format: motions have both")
        folder = output or path.with_name(f"{Path(realpath(path)).name}-{form.name}")
        index = export_library(
            path, folder, format=form.name, rate=asked.rate, strides=asked.strides,
            joints=asked.joints,
        )  # fmt: skip
        with index.open(newline="", encoding="utf-8") as stream:
            files = sum(bool(row["file"]) for row in csv.DictReader(stream))
        typer.echo(f"wrote {files} motions and {INDEX} in {folder}")
        return
    target = output
    if target is None:
        assert form is not None
        target = path.with_name(f"{path.stem}-{form.name}{form.suffix}")
    found = loaded_motion(path)
    if isinstance(found, Transition):
        written = _export_transition(found, target, asked)
    else:
        written = export(
            found, target, both_legs=asked.both_legs, format=name, rate=asked.rate,
            strides=asked.strides, joints=asked.joints,
        )  # fmt: skip
    typer.echo(f"wrote {written}")


def _export_transition(transition: Transition, target: Path, asked: ExportOptions) -> Path:
    """Write a transition as a motion."""
    if asked.format is None:
        raise InputError("a transition is written as a motion: name a --format, as --format mujoco")
    of_walks = {"--strides": asked.strides is not None, "--both-legs": asked.both_legs}
    refuse_options(of_walks, "with the gait of a walk, not with a transition")
    return export_transition(
        transition, target, format=asked.format, rate=asked.rate, joints=asked.joints
    )


def _write_mjcf(asked: ExportOptions) -> None:
    """Write the robot of a gait with its walk as keyframes."""
    path, rate, strides = asked.gait, asked.rate, asked.strides
    of_motions = {"--joints": asked.joints is not None, "--both-legs": asked.both_legs}
    refuse_options(of_motions, f"without --format {MJCF}")
    if isdir(path):
        raise InputError(f"'{path}' is a directory; --format {MJCF} writes one gait, a .npz")
    target = asked.output or path.with_name(f"{path.stem}-{MJCF}.xml")
    if target.suffix.lower() != ".xml":
        raise InputError(f"cannot write '{target}': files of format '{MJCF}' end in .xml")
    from gaitopt.simulate.mujoco_model import RATE, mjcf_text

    text = mjcf_text(
        loaded(path), RATE if rate is None else rate, 1.0 if strides is None else strides
    )
    typer.echo(f"wrote {write_atomically(target, text.encode())}")
