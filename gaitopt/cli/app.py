"""The commands; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated

import typer

from gaitopt.cli.command_options import (
    ASKED,
    METHOD,
    CheckOptions,
    CodesignOptions,
    CompareOptions,
    ExportOptions,
    InspectOptions,
    LibraryOptions,
    LiveOptions,
    OptimiseOptions,
    PlayOptions,
    PlotOptions,
    ReproduceOptions,
    RequirementsOptions,
    RobotsOptions,
    SensitivityOptions,
    SimulateOptions,
    SizeOptions,
    SweepOptions,
    TransitionOptions,
    UrdfOptions,
)
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

        typer.echo(f"gaitopt {__version__}")
        raise typer.Exit


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


def _all_settings(words: Sequence[str]) -> Panels:
    """Return all settings of the configuration; plugins that are named bring their own."""
    from gaitopt.cli.config import sections

    return _panels(sections(words))


def _robot_settings(_: Sequence[str]) -> Panels:
    from gaitopt.cli.config import SCHEMA

    return _panels({"robot": SCHEMA["robot"]})


def _biped_settings(_: Sequence[str]) -> Panels:
    from gaitopt.cli.config import SCHEMA

    return {PANELS["robot"]: [SCHEMA["robot"][name] for name in ("spec", "set")]}


def _sweep_settings(words: Sequence[str]) -> Panels:
    from gaitopt.cli.config import NOT_OURS, SWEEP

    return {"Sweep": SWEEP, **_without(_all_settings(words), NOT_OURS)}


def _compare_settings(words: Sequence[str]) -> Panels:
    from gaitopt.cli.config import COMPARISON

    others = ("solver", "starts", "refine", "approach", "toe_begin", "phase_times", "differences")
    panels = _without(_all_settings(words), others)
    return {**panels, METHOD: [*COMPARISON, *panels[METHOD]]}


def _codesign_settings(words: Sequence[str]) -> Panels:
    return _without(_all_settings(words), ("start", "seed", "sigma", "speed"))


def _without(panels: Panels, names: Sequence[str]) -> dict[str, list[Setting]]:
    return {
        heading: [one for one in panel if one.name not in names]
        for heading, panel in panels.items()
    }


def _panels(sections: Mapping[str, Mapping[str, Setting]]) -> Panels:
    panels: dict[str, list[Setting]] = {}
    for name, settings in sections.items():
        panels.setdefault(PANELS[name], []).extend(settings.values())
    return panels


command(app, "optimise", OptimiseOptions, _all_settings, aliases=("optimize",))
command(app, "sweep", SweepOptions, _sweep_settings)
command(app, "compare", CompareOptions, _compare_settings)
command(app, "library", LibraryOptions)
command(app, "requirements", RequirementsOptions)
command(app, "sensitivity", SensitivityOptions)
command(app, "size", SizeOptions)
command(app, "codesign", CodesignOptions, _codesign_settings)
command(app, "inspect", InspectOptions, _robot_settings, work="robots:inspect")
command(app, "robots", RobotsOptions, work="robots:list_robots")
command(app, "urdf", UrdfOptions, _biped_settings, work="robots:write_biped")
command(app, "check", CheckOptions)
command(app, "simulate", SimulateOptions)
command(app, "play", PlayOptions, work="show:run_play")
command(app, "live", LiveOptions, _all_settings, work="live:run_live")
command(app, "plot", PlotOptions, work="show:run_plot")
command(app, "export", ExportOptions)
command(app, "transition", TransitionOptions)
command(app, "reproduce", ReproduceOptions)
