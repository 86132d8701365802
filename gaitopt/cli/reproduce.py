"""`gaitopt reproduce`: run the paper's reproduction, which only a source checkout holds."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import typer

import gaitopt
from gaitopt.errors import InputError

FOLDER = "reproduction"


def run(output: Path, only: str | None, quiet: bool) -> None:
    """Run `python -m reproduction` of the checkout from which gaitopt is imported.

    Args:
        output: directory to write.
        only: parts, as "table3,fig7"; None for everything.
        quiet: whether to print errors only.

    Raises:
        InputError: gaitopt is installed without its sources.
        typer.Exit: with the exit code of the reproduction.
    """
    sources = Path(gaitopt.__file__).parents[1]
    if not (sources / FOLDER / "__main__.py").is_file():
        raise InputError(
            f"the reproduction of the paper is not installed with gaitopt ('{sources}' has no "
            f"'{FOLDER}'); get the sources of gaitopt and run `python -m {FOLDER}` in them"
        )
    sys.path.insert(0, str(sources))
    command = importlib.import_module(f"{FOLDER}.__main__")
    arguments = ["--output", str(output), *(["--quiet"] if quiet else [])]
    if code := command.main([*arguments, *([] if only is None else ["--only", only])]):
        raise typer.Exit(code)
