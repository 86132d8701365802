"""The commands; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Annotated

import typer

from gaitopt.cli import command_options as own
from gaitopt.cli.command_options import ASKED, METHOD
from gaitopt.cli.options import CONTEXT, NO_VALUE, Group, Panels, command
from gaitopt.cli.process import (
    exit_code_kept,
    forget_odd_widths,
    handle_termination,
    survive_closed_pipes,
)
from gaitopt.settings import Setting

PANELS = {
    "task": ASKED, "cost": ASKED, "plugin": ASKED, "geometry": ASKED, "margins": "Limits",
    "robot": "Robot", "solver": METHOD,
}  # fmt: skip
"""Headings of the help over the options of each section."""

app = typer.Typer(
    cls=Group,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings=CONTEXT,
    help="Optimal walking gaits for bipeds: how does this robot walk at this speed for the least "
    "effort, and what must its motors deliver?",
    epilog="Exit codes: 0 done (and certified), 1 a gait that is not certified or a robot that "
    "fell, 2 bad usage or input, 3 no gait found, 130 interrupted.",
)


def run() -> None:
    """Run the command line in a process of its own."""
    survive_closed_pipes()
    forget_odd_widths()
    handle_termination()
    with exit_code_kept():
        app(prog_name="gaitopt")


def _print_version(wanted: bool) -> None:
    if wanted:
        from gaitopt.version import __version__

        typer.echo(f"gaitopt {__version__}\nkernels: {_kernels()}")
        raise typer.Exit


def _kernels() -> str:
    from gaitopt.mechanics.compiled import BUILT, WANTED

    if BUILT:
        return "compiled" if WANTED else "compiled, but GAITOPT_COMPILED=0 leaves them aside"
    return (
        "not compiled, so that a walk takes a third longer; install gaitopt again where there is a "
        "C++ compiler"
    )


_VERSION = typer.Option(
    "--version",
    help="Show the version and exit.",
    metavar=NO_VALUE,
    callback=_print_version,
    is_eager=True,
)


@app.callback()
def options_before_a_command(version: Annotated[bool, _VERSION] = False) -> None:
    """Take the options that stand before a command."""
    del version  # its callback has done the work


def _settings(
    words: Sequence[str],
    section: str = "",
    names: Sequence[str] = (),
    without: Sequence[str] = (),
) -> dict[str, list[Setting]]:
    """Return settings of the configuration by heading; plugins that are named bring their own.

    Args:
        words: given to the command.
        section, names: whose alone, and which alone of these; of all if empty.
        without: names of others.
    """
    from gaitopt.cli.config import sections

    panels: dict[str, list[Setting]] = {}
    for name, settings in sections(() if section else words).items():
        if section in ("", name):
            panels.setdefault(PANELS[name], []).extend(
                one for one in settings.values() if one.name in (names or settings)
                and one.name not in without
            )  # fmt: skip
    return panels


def _sweep_settings(words: Sequence[str]) -> Panels:
    from gaitopt.cli.config import NOT_OURS, SWEEP

    return {"Sweep": SWEEP, **_settings(words, without=NOT_OURS)}


def _compare_settings(words: Sequence[str]) -> Panels:
    from gaitopt.cli.config import COMPARISON

    others = ("solver", "starts", "refine", "approach", "toe_begin", "phase_times", "differences")
    panels = _settings(words, without=others)
    return {**panels, METHOD: [*COMPARISON, *panels[METHOD]]}


_robot_settings = partial(_settings, section="robot")
_biped_settings = partial(_settings, section="robot", names=("spec", "set"))
_codesign_settings = partial(_settings, without=("start", "seed", "sigma", "speed"))

command(app, "optimise", own.OptimiseOptions, _settings, aliases=("optimize",))
command(app, "sweep", own.SweepOptions, _sweep_settings)
command(app, "compare", own.CompareOptions, _compare_settings)
command(app, "library", own.LibraryOptions)
command(app, "requirements", own.RequirementsOptions, work="motors:run_requirements")
command(app, "sensitivity", own.SensitivityOptions)
command(app, "size", own.SizeOptions, work="motors:run_size")
command(app, "codesign", own.CodesignOptions, _codesign_settings)
command(app, "inspect", own.InspectOptions, _robot_settings, work="robots:inspect")
command(app, "robots", own.RobotsOptions, work="robots:list_robots")
command(app, "urdf", own.UrdfOptions, _biped_settings, work="robots:write_biped")
command(app, "check", own.CheckOptions, work="show:run_check")
command(app, "simulate", own.SimulateOptions)
command(app, "play", own.PlayOptions, work="show:run_play")
command(app, "live", own.LiveOptions, _settings, work="live:run_live")
command(app, "plot", own.PlotOptions, work="show:run_plot")
command(app, "export", own.ExportOptions)
command(app, "transition", own.TransitionOptions)
command(app, "reproduce", own.ReproduceOptions)
