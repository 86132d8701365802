"""The commands. Each says what it takes; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

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

Settings = dict[str, Any]
"""Values that were given of the configuration's settings, by name."""

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


@command(app, _all_settings, "optimize")
def optimise(options: OptimiseOptions, settings: Settings) -> None:
    """Design the gait that walks at a given speed for the least effort."""
    from gaitopt.cli import optimise as work

    work.run(settings, options)


@command(app, _sweep_settings)
def sweep(options: SweepOptions, settings: Settings) -> None:
    """Design gaits over speeds and other quantities, each from its neighbour."""
    from gaitopt.cli import sweep as work

    work.run(settings, options)


@command(app, _compare_settings)
def compare(options: CompareOptions, settings: Settings) -> None:
    """Solve one walk by several solvers from the same start."""
    from gaitopt.cli import compare as work

    work.run(settings, options)


@command(app)
def library(options: LibraryOptions) -> None:
    """List a gait library, draw it, or design a gait between its gaits; compare two."""
    from gaitopt.cli import library as work

    work.run(options)


@command(app)
def requirements(options: RequirementsOptions) -> None:
    """Say what each motor must deliver over a set of gaits, and in which of them."""
    from gaitopt.cli import requirements as work

    work.run(options)


@command(app)
def sensitivity(options: SensitivityOptions) -> None:
    """Say what a centimetre, a kilogram or a limit more would do to the cost of a gait."""
    from gaitopt.cli import sensitivity as work

    work.run(options)


@command(app)
def size(options: SizeOptions) -> None:
    """Choose motors from a catalogue and gear ratios that serve a set of gaits."""
    from gaitopt.cli import size as work

    work.run(options)


def _codesign_settings(words: Sequence[str]) -> Panels:
    return _without(_all_settings(words), ("start", "seed", "sigma", "speed"))


@command(app, _codesign_settings)
def codesign(options: CodesignOptions, settings: Settings) -> None:
    """Choose lengths, masses and gear ratios of a robot together, for a weighted set of walks."""
    from gaitopt.cli import codesign as work

    work.run(settings, options)


@command(app, _robot_settings)
def inspect(options: InspectOptions, settings: Settings) -> None:
    """Say what gaitopt understood of a robot, what it guessed, and what is wrong with the file."""
    from gaitopt.cli import robots as work

    work.inspect(settings, options)


@command(app)
def robots() -> None:
    """List the robots that can be asked for by name."""
    from gaitopt.cli import robots as work

    work.list_robots()


@command(app, _biped_settings)
def urdf(options: UrdfOptions, settings: Settings) -> None:
    """Write the URDF of a biped (by default of the thirteen-link one)."""
    from gaitopt.cli import robots as work

    work.write_biped(settings, options)


@command(app)
def check(options: CheckOptions) -> None:
    """Compute a gait or a transition again, from its parameters alone, and certify it."""
    from gaitopt.cli import check as work

    work.run(options)


@command(app)
def simulate(options: SimulateOptions) -> None:
    """Walk a gait in MuJoCo under feedback, and let MuJoCo check its numbers."""
    from gaitopt.cli import simulate as work

    work.run(options)


@command(app)
def play(options: PlayOptions) -> None:
    """Watch a gait or a transition in the browser."""
    from gaitopt.cli import show as watch

    watch.run_play(options)


@command(app, _all_settings)
def live(options: LiveOptions, settings: Settings) -> None:
    """Serve a page whose sliders are answered with the walk of their settings, at once."""
    from gaitopt.cli import live as work

    work.run_live(settings, options)


@command(app)
def plot(options: PlotOptions) -> None:
    """Draw the figures of a gait or a transition."""
    from gaitopt.cli import show as watch

    watch.run_plot(options)


@command(app)
def export(options: ExportOptions) -> None:
    """Write a gait, a transition, or a library for controllers, engines and learners."""
    from gaitopt.cli import export as work

    work.run(options)


@command(app)
def transition(options: TransitionOptions) -> None:
    """Design the steps from standing to a walk, back, or from one walk to another."""
    from gaitopt.cli import transition as work

    work.run(options)


@command(app)
def reproduce(options: ReproduceOptions) -> None:
    """Compute the paper's section 6 again, as `python -m reproduction` in the sources."""
    from gaitopt.cli import reproduce as work

    work.run(options)
