"""`gaitopt urdf`: the robot as files."""

from __future__ import annotations

from pathlib import Path

import typer

from gaitopt.atomic import write_atomically
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.spec_file import read_spec, write_spec
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.model.robot import Robot


def run(spec_file: Path | None, output: Path | None, new_spec: Path | None) -> None:
    """Write the URDF of a specification, or the specification itself.

    Raises:
        GaitoptError: the specification is not that of a biped, or a file cannot be written.
    """
    spec = biped13() if spec_file is None else read_spec(spec_file)
    if new_spec is not None:
        write_spec(spec, new_spec)
        typer.echo(f"wrote {new_spec}; edit it, then: gaitopt urdf --spec {new_spec}")
    text = urdf_text(spec)
    Robot.from_urdf(text)  # refuse what could not be used afterwards
    if output is not None:
        typer.echo(f"wrote {write_atomically(output, text.encode())}")
    elif new_spec is None:
        typer.echo(text, nl=False)
