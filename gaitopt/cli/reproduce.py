"""`gaitopt reproduce`: run the paper's reproduction, which only a source checkout holds."""

from __future__ import annotations

import importlib
import sys
from os.path import isfile
from pathlib import Path

import typer

import gaitopt
from gaitopt.cli.command_options import ReproduceOptions
from gaitopt.errors import InputError

FOLDER = "reproduction"


def run(asked: ReproduceOptions) -> None:
    """Run `python -m reproduction` of the checkout from which gaitopt is imported.

    Raises:
        InputError: gaitopt is installed without its sources.
        typer.Exit: with the exit code of the reproduction.
    """
    sources = Path(gaitopt.__file__).parents[1]
    if not isfile(sources / FOLDER / "__main__.py"):
        raise InputError(
            f"the reproduction of the paper is not installed with gaitopt ('{sources}' has no "
            f"'{FOLDER}'); get the sources of gaitopt and run `python -m {FOLDER}` in them"
        )
    sys.path.insert(0, str(sources))
    command = importlib.import_module(f"{FOLDER}.__main__")
    arguments = ["--output", str(asked.output), *(["--quiet"] if asked.quiet else [])]
    if code := command.main([*arguments, *([] if asked.only is None else ["--only", asked.only])]):
        raise typer.Exit(code)
