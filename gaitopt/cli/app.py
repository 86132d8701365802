"""The commands. Each says what it takes; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitopt.cli import sweep_options as many
from gaitopt.cli.options import CONTEXT, Panels, command
from gaitopt.cli.paths import named_directory
from gaitopt.cli.process import handle_termination, survive_closed_pipes
from gaitopt.settings import Setting

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings=CONTEXT,
    help="Optimal walking gaits for bipeds: how does this robot walk at this speed for the least "
    "effort, and what must its motors deliver?",
    epilog="Exit codes: 0 done (and certified), 1 a gait that is not certified, 2 bad usage or "
    "input, 3 no gait found, 130 interrupted.",
)

Settings = dict[str, object]
"""Values that were given, by name."""

PANELS = {
    "task": "What is asked", "cost": "What is asked", "plugin": "What is asked",
    "geometry": "What is asked", "margins": "Limits", "robot": "Robot", "solver": "Method",
}  # fmt: skip
"""Headings of the help over the options of each section."""


def run() -> None:
    """Run the command line in a process of its own."""
    survive_closed_pipes()
    handle_termination()
    app(prog_name="gaitopt")


def _option(names: str, help_text: str, metavar: str | None = None, **how: Any) -> Any:
    """Return a typer option; `names` as typer takes them, separated by spaces."""
    return typer.Option(*names.split(), help=help_text, metavar=metavar, show_default=False, **how)


def _result(names: str, help_text: str, metavar: str | None = None, **how: Any) -> Any:
    return _option(names, help_text, metavar, rich_help_panel="Results", **how)


def _print_version(wanted: bool) -> None:
    if wanted:
        from gaitopt.version import __version__

        typer.echo(f"gaitopt {__version__}")
        raise typer.Exit


GaitFile = Annotated[Path, typer.Argument(metavar="GAIT", help="A gait file, .npz.")]
Plugin = Annotated[
    Path | None,
    _option("--plugin", "Python file with its own constraints or cost; it is run.", "FILE"),
]
Quiet = Annotated[bool, _result("--quiet -q", "Print nothing but errors.")]


@app.callback()
def options_before_a_command(
    version: Annotated[
        bool,
        _option("--version", "Show the version and exit.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
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
    from gaitopt.cli.sweep_options import NOT_OURS, SWEEP

    return {"Sweep": SWEEP, **_without(_all_settings(words), NOT_OURS)}


def _compare_settings(words: Sequence[str]) -> Panels:
    from gaitopt.cli.config import COMPARISON

    others = ("solver", "starts", "refine", "approach", "differences")
    panels = _without(_all_settings(words), others)
    return {**panels, PANELS["solver"]: [*COMPARISON, *panels[PANELS["solver"]]]}


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
def optimise(
    settings: Settings,
    fastest: Annotated[
        bool,
        _option(
            "--fastest",
            "Search the fastest walk, from this speed up.",
            rich_help_panel=PANELS["task"],
        ),
    ] = False,
    config: Annotated[
        Path | None,
        _option(
            "--config",
            "TOML file with any of these options; the command line wins.",
            "FILE",
            rich_help_panel=PANELS["solver"],
        ),
    ] = None,
    output: Annotated[
        Path | None,
        _result(
            "--output -o",
            "Directory for gait, page, figures and tables.",
            "DIR",
            parser=named_directory,
        ),
    ] = None,
    page: Annotated[bool, _result("--page/--no-page", "Write the walking robot.")] = True,
    figures: Annotated[bool, _result("--figures/--no-figures", "Write the figures.")] = True,
    quiet: Quiet = False,
) -> None:
    """Design the gait that walks at a given speed for the least effort."""
    from gaitopt.cli import optimise as work

    work.run(
        settings, config=config, output=output, fastest=fastest, page=page, figures=figures,
        quiet=quiet,
    )  # fmt: skip


@command(app, _sweep_settings)
def sweep(
    settings: Settings, output: many.Directory, config: many.Config = None, quiet: Quiet = False
) -> None:
    """Design gaits over speeds and other quantities, each from its neighbour."""
    from gaitopt.cli import sweep as work

    work.run(settings, output, config, quiet)


@command(app, _compare_settings)
def compare(
    settings: Settings,
    config: many.Config = None,
    output: Annotated[
        Path | None,
        _result(
            "--output -o",
            "Directory for comparison.json and convergence.png.",
            "DIR",
            parser=named_directory,
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Solve one walk by several solvers from the same start."""
    from gaitopt.cli import compare as work

    work.run(settings, config, output, quiet)


@command(app)
def library(
    directory: many.LibraryDirectories,
    where: many.Where = None,
    columns: many.Columns = None,
    plot: many.Plot = None,
    at: many.At = None,
    plugin: Plugin = None,
    output: many.GaitOutput = None,
) -> None:
    """List a gait library, draw it, or design a gait between its gaits; compare two."""
    from gaitopt.cli import library as work

    if at:
        work.run_at(directory, at, output, plugin)
    else:
        work.run_list(directory, where or [], columns, plot)


@command(app, _robot_settings)
def inspect(
    settings: Settings,
    html: Annotated[
        Path | None,
        _result("--html", "Write a page with the robot standing and these tables.", "FILE"),
    ] = None,
    write_choices: Annotated[
        Path | None,
        _result(
            "--write-choices",
            "Write what was found or guessed, to edit; then --choices FILE.",
            "FILE",
        ),
    ] = None,
) -> None:
    """Say what gaitopt understood of a robot, what it guessed, and what is wrong with the file."""
    from gaitopt.cli import robots as work

    work.inspect(settings, html, write_choices)


@command(app)
def robots() -> None:
    """List the robots that can be asked for by name."""
    from gaitopt.cli import robots as work

    work.list_robots()


@command(app, _biped_settings)
def urdf(
    settings: Settings,
    output: Annotated[
        Path | None,
        _option("--output -o", "Where to write it; by default to the terminal.", "FILE"),
    ] = None,
    write_spec: Annotated[
        Path | None, _option("--write-spec", "Write the parameter table instead, to edit.", "FILE")
    ] = None,
) -> None:
    """Write the URDF of a biped (by default of the thirteen-link one)."""
    from gaitopt.cli import robots as work

    work.write_biped(settings, output, write_spec)


@command(app)
def check(
    gait: GaitFile,
    plugin: Plugin = None,
) -> None:
    """Compute a gait file again, from its parameters alone, and certify it."""
    from gaitopt.cli import report as work

    work.check(gait, plugin)


@command(app)
def play(
    gait: GaitFile,
    html: Annotated[
        Path | None, _option("--html", "Write a page instead, complete in one file.", "FILE")
    ] = None,
    steps: Annotated[int | None, _option("--steps", "How many steps to show.", "N")] = None,
    package_dir: Annotated[
        list[Path] | None,
        _option("--package-dir", "Directory with the packages of the meshes; repeatable.", "DIR"),
    ] = None,
    host: Annotated[
        str | None,
        _option(
            "--host", "Address to listen on; by default 127.0.0.1: this machine alone.", "ADDRESS"
        ),
    ] = None,
    port: Annotated[
        int | None,
        _option("--port", "Port to listen on; by default a free one from 7000 on.", "N"),
    ] = None,
) -> None:
    """Watch a gait in the browser."""
    from gaitopt.cli import watch

    watch.run_play(gait, html, steps, tuple(map(str, package_dir or ())), host, port)


@command(app)
def plot(
    gait: GaitFile,
    output: Annotated[
        Path | None,
        _option(
            "--output -o",
            "Where to; by default 'figures' next to the gait.",
            "DIR",
            parser=named_directory,
        ),
    ] = None,
    formats: Annotated[
        list[str] | None, _option("--format", "png (default), svg or pdf; repeatable.", "KIND")
    ] = None,
) -> None:
    """Draw the figures of a gait."""
    from gaitopt.cli import watch

    watch.run_plot(gait, output, formats)


@command(app)
def export(
    gait: GaitFile,
    output: Annotated[Path, _option("--output -o", "File; its suffix chooses the form.", "FILE")],
    both_legs: Annotated[
        bool, _option("--both-legs", "Add the mirror image of the step: a whole stride.")
    ] = False,
) -> None:
    """Write a gait for a spreadsheet or a controller: .csv, .json or .yaml."""
    from gaitopt.cli import watch

    watch.run_export(gait, output, both_legs)


@command(app)
def reproduce(
    output: Annotated[
        Path,
        _option(
            "--output -o", "For reproduction.md, figures, numbers.", "DIR", parser=named_directory
        ),
    ],
    only: Annotated[
        str | None, _option("--only", "Only some tables and figures, as table3,fig7.", "PARTS")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Compute the paper's section 6 again, as `python -m reproduction` in the sources."""
    from gaitopt.cli import reproduce as work

    work.run(output, only, quiet)
