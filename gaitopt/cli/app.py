"""The commands. Each says what it takes; the work is done elsewhere and imported when needed."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from gaitopt.cli import options as opt
from gaitopt.cli.failures import failures_reported
from gaitopt.cli.help_defaults import CommandWithDefaults

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
    help="Optimal walking gaits for bipeds: how does this robot walk at this speed for the least "
    "effort, and what must its motors deliver?",
    epilog="Exit codes: 0 done (and certified), 1 a gait that is not certified, 2 bad usage or "
    "input, 3 no gait found, 130 interrupted.",
)


def run() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        # a terminal that cannot show "N·m" shows "N?m"
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    app(prog_name="gaitopt")


def _print_version(wanted: bool) -> None:
    if wanted:
        from gaitopt.version import __version__

        typer.echo(f"gaitopt {__version__}")
        raise typer.Exit


@app.callback()
def gaitopt(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Version.")
    ] = False,
) -> None:
    """Take the options that stand before a command."""


@app.command()
@failures_reported()
def urdf(spec: opt.SpecFile = None, output: opt.UrdfOutput = None, write_spec: opt.NewSpec = None):  # type: ignore[no-untyped-def] # noqa: ANN201
    """Write the URDF of a biped, or a parameter table to start from."""
