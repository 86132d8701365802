"""The commands. Each says what it takes; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from gaitopt.cli.options import CONTEXT, Group, Panels, command
from gaitopt.cli.process import handle_termination, survive_closed_pipes
from gaitopt.settings import Setting, entry

Settings = dict[str, Any]
"""Values that were given of the configuration's settings, by name."""

ASKED, METHOD, RESULTS = "What is asked", "Method", "Results"
DESIGN = "Design"
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
    handle_termination()
    app(prog_name="gaitopt")


def _print_version(wanted: bool) -> None:
    if wanted:
        from gaitopt.version import __version__

        typer.echo(f"gaitopt {__version__}")
        raise typer.Exit


_VERSION = typer.Option(
    "--version", help="Show the version and exit.", callback=_print_version, is_eager=True
)


@app.callback()
def options_before_a_command(version: Annotated[bool, _VERSION] = False) -> None:
    """Take the options that stand before a command."""
    del version  # its callback has done the work


_CONFIG = "TOML file with any of these options; the command line wins."
_PLUGIN = "Python file with its own constraints, cost or terrain; it is run."
_QUIET = "Print nothing but errors."


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


@dataclass(frozen=True)
class OptimiseOptions:
    """Of `gaitopt optimise`, beside all settings."""

    fastest: bool = entry(False, "Search the fastest walk, from this speed up.", panel=ASKED)
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path | None = entry(
        None,
        "Directory for gait, page and tables.",
        metavar="DIR",
        short="-o",
        panel=RESULTS,
    )
    page: bool = entry(True, "Write the walking robot.", panel=RESULTS)
    figures: bool = entry(
        False,
        "Write the figures of the gait; its page has the curves, gaitopt plot draws them later.",
        panel=RESULTS,
        negatable=True,
    )
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@command(app, _all_settings, "optimize")
def optimise(options: OptimiseOptions, settings: Settings) -> None:
    """Design the gait that walks at a given speed for the least effort."""
    from gaitopt.cli import optimise as work

    work.run(
        settings, config=options.config, output=options.output, fastest=options.fastest,
        page=options.page, figures=options.figures, quiet=options.quiet,
    )  # fmt: skip


@dataclass(frozen=True)
class SweepOptions:
    """Of `gaitopt sweep`, beside the settings."""

    output: Path = entry(
        ..., "Gait library; one that exists goes on.", metavar="DIR", short="-o", panel="Sweep"
    )
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@command(app, _sweep_settings)
def sweep(options: SweepOptions, settings: Settings) -> None:
    """Design gaits over speeds and other quantities, each from its neighbour."""
    from gaitopt.cli import sweep as work

    work.run(settings, options.output, options.config, options.quiet)


@dataclass(frozen=True)
class CompareOptions:
    """Of `gaitopt compare`, beside the settings."""

    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path | None = entry(
        None,
        "Directory for comparison.json and convergence.png.",
        metavar="DIR",
        short="-o",
        panel=RESULTS,
    )
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


@command(app, _compare_settings)
def compare(options: CompareOptions, settings: Settings) -> None:
    """Solve one walk by several solvers from the same start."""
    from gaitopt.cli import compare as work

    work.run(settings, options.config, options.output, options.quiet)


@dataclass(frozen=True)
class LibraryOptions:
    """Of `gaitopt library`."""

    directory: tuple[Path, ...] = entry(
        ..., "A gait library, made by gaitopt sweep, or two to compare.", argument=True,
        metavar="DIR",
    )  # fmt: skip
    where: tuple[str, ...] = entry(
        (), 'Only gaits of which this is true, as "speed>0.8".', metavar="TEST"
    )
    columns: str | None = entry(
        None, "What to show of the index beside what was swept, as cost,friction_used; 'list' "
        "tells what there is.", metavar="NAMES",
    )  # fmt: skip
    plot: Path | None = entry(
        None, "Draw cost and peak torques over what was swept: .png, .svg or .pdf."
    )
    at: tuple[str, ...] = entry(
        (), "Design the gait between the stored ones, as speed=0.83.", metavar="NAME=VALUE"
    )
    plugin: Path | None = entry(None, _PLUGIN)
    output: Path | None = entry(None, "Gait file to write the gait of --at to.", short="-o")


@command(app)
def library(options: LibraryOptions) -> None:
    """List a gait library, draw it, or design a gait between its gaits; compare two."""
    from gaitopt.cli import library as work

    if options.at:
        work.run_at(options.directory, list(options.at), options.output, options.plugin)
    else:
        work.run_list(options.directory, list(options.where), options.columns, options.plot)


@dataclass(frozen=True)
class RequirementsOptions:
    """Of `gaitopt requirements`."""

    gait: tuple[Path, ...] = entry(
        ..., "Gait files, .npz, or gait libraries.", argument=True, metavar="GAIT|LIBRARY"
    )
    against: tuple[Path, ...] = entry(
        (), "Gait or library of another design, to compare.", metavar="GAIT|LIBRARY"
    )
    motors: Path | None = entry(
        None, "Motors and gears of the joints, TOML; the table tells the shares of their limits."
    )
    output: Path | None = entry(
        None, "File to write the table to: .csv, .toml or .xlsx.", short="-o"
    )
    figure: Path | None = entry(None, "File to draw torque over speed into: .png, .svg or .pdf.")


@command(app)
def requirements(options: RequirementsOptions) -> None:
    """Say what each motor must deliver over a set of gaits, and in which of them."""
    from gaitopt.cli import requirements as work

    work.run(options.gait, options.against, options.output, options.figure, options.motors)


@dataclass(frozen=True)
class SensitivityOptions:
    """Of `gaitopt sensitivity`."""

    gait: Path = entry(..., "A gait file, .npz.", argument=True, metavar="GAIT")
    plugin: Path | None = entry(None, _PLUGIN)
    most: int | None = entry(None, "How many lines to show; by default 20.", metavar="N")
    output: Path | None = entry(None, "Write all of them: .csv.", short="-o", metavar="FILE")


@command(app)
def sensitivity(options: SensitivityOptions) -> None:
    """Say what a centimetre, a kilogram or a limit more would do to the cost of a gait."""
    from gaitopt.cli import sensitivity as work

    work.run(options.gait, options.plugin, options.most, options.output)


@dataclass(frozen=True)
class SizeOptions:
    """Of `gaitopt size`."""

    gait: tuple[Path, ...] = entry(
        ..., "Gait files, .npz, or gait libraries.", argument=True, metavar="GAIT|LIBRARY"
    )
    catalogue: Path = entry(..., "Motors and gears to choose from, TOML.")
    output: Path = entry(
        ..., "Directory for motors.toml and the gaits designed again.", metavar="DIR", short="-o"
    )
    aim: str = entry("mass", "What is to be least.", choices=("mass", "loss"), metavar="WHAT")
    reserve: float | None = entry(
        None, "Of torque, heat and voltage, over what the gaits ask; by default 1.1.",
        metavar="FACTOR",
    )  # fmt: skip


@command(app)
def size(options: SizeOptions) -> None:
    """Choose motors from a catalogue and gear ratios that serve a set of gaits."""
    from gaitopt.cli import size as work

    work.run(options.gait, options.catalogue, options.aim, options.reserve, options.output)


@dataclass(frozen=True)
class CodesignOptions:
    """Of `gaitopt codesign`, beside the settings."""

    output: Path = entry(
        ..., "Directory for robot, walks and report; trials that are there go on.", metavar="DIR",
        short="-o", panel=DESIGN,
    )  # fmt: skip
    vary: tuple[str, ...] = entry(
        (), "What to choose: shin=25cm:35cm, motors.knee.ratio=6:12; a third number: the start.",
        metavar="NAME=LOWER:UPPER", panel=DESIGN,
    )  # fmt: skip
    keep_leg: bool = entry(False, "Thigh and shin together stay as long as they are.", panel=DESIGN)
    speeds: str | None = entry(
        None, "Speeds of the walks it is for, FIRST:LAST:STEP or a list.", metavar="M/S",
        panel=DESIGN,
    )  # fmt: skip
    walk: tuple[str, ...] = entry(
        (), "A further walk, as 'speed=0.6 slope=10% payload=5kg@torso weight=2'.",
        metavar="NAME=VALUE...", panel=DESIGN,
    )  # fmt: skip
    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    quiet: bool = entry(False, _QUIET, short="-q", panel=RESULTS)


def _codesign_settings(words: Sequence[str]) -> Panels:
    return _without(_all_settings(words), ("start", "seed", "sigma", "speed"))


@command(app, _codesign_settings)
def codesign(options: CodesignOptions, settings: Settings) -> None:
    """Choose lengths, masses and gear ratios of a robot together, for a weighted set of walks."""
    from gaitopt.cli import codesign as work

    work.run(
        settings, config=options.config, directory=options.output, vary=options.vary,
        keep_leg=options.keep_leg, speeds=options.speeds, walks=options.walk, quiet=options.quiet,
    )  # fmt: skip


@dataclass(frozen=True)
class InspectOptions:
    """Of `gaitopt inspect`, beside those of robots."""

    html: Path | None = entry(
        None, "Write a page with the robot standing and these tables.", panel=RESULTS
    )
    write_choices: Path | None = entry(
        None, "Write what was found or guessed, to edit; then --choices FILE.", panel=RESULTS
    )


@command(app, _robot_settings)
def inspect(options: InspectOptions, settings: Settings) -> None:
    """Say what gaitopt understood of a robot, what it guessed, and what is wrong with the file."""
    from gaitopt.cli import robots as work

    work.inspect(settings, options.html, options.write_choices)


@command(app)
def robots() -> None:
    """List the robots that can be asked for by name."""
    from gaitopt.cli import robots as work

    work.list_robots()


@dataclass(frozen=True)
class UrdfOptions:
    """Of `gaitopt urdf`, beside those of bipeds."""

    output: Path | None = entry(
        None, "File to write the URDF to; by default the terminal.", short="-o", panel=RESULTS
    )
    write_spec: Path | None = entry(
        None, "File to write the parameter table to instead, to edit.", panel=RESULTS
    )


@command(app, _biped_settings)
def urdf(options: UrdfOptions, settings: Settings) -> None:
    """Write the URDF of a biped (by default of the thirteen-link one)."""
    from gaitopt.cli import robots as work

    work.write_biped(settings, options.output, options.write_spec)


_GAIT = "The file of a gait or a transition, .npz."


@dataclass(frozen=True)
class CheckOptions:
    """Of `gaitopt check`."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    plugin: Path | None = entry(None, _PLUGIN)


@command(app)
def check(options: CheckOptions) -> None:
    """Compute a gait or a transition again, from its parameters alone, and certify it."""
    from gaitopt.cli import check as work

    work.run(options.gait, options.plugin)


@dataclass(frozen=True)
class SimulateOptions:
    """Of `gaitopt simulate`."""

    gait: Path = entry(..., "A gait file, .npz.", argument=True, metavar="GAIT")
    steps: int = entry(20, "How many steps to walk.")
    controller: str = entry(
        "whole-body", "Feedback that keeps it on its feet: whole-body or joint-pd.", metavar="NAME"
    )
    friction: float = entry(0.8, "Coefficient of friction of the simulated ground.", metavar="MU")
    thorough: bool = entry(
        False, "Try pushes, masses, ground, friction, delay, rotors, noise and starts."
    )
    output: Path | None = entry(
        None, "Directory to write summary.json to.", short="-o", metavar="DIR"
    )
    page: Path | None = entry(
        None, "Page to write: the walk beside the designed one, with the pushes of --thorough.",
        metavar="FILE",
    )  # fmt: skip
    video: Path | None = entry(
        None, "The same as a film, .mp4, .webm or .gif; needs ffmpeg.", metavar="FILE"
    )
    quiet: bool = entry(False, _QUIET, short="-q")


@command(app)
def simulate(options: SimulateOptions) -> None:
    """Walk a gait in MuJoCo under feedback, and let MuJoCo check its numbers."""
    from gaitopt.cli import simulate as work

    work.run(
        options.gait, options.steps, options.controller, options.friction, options.thorough,
        options.output, options.page, options.video, options.quiet,
    )  # fmt: skip


@dataclass(frozen=True)
class PlayOptions:
    """Of `gaitopt play`."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    html: Path | None = entry(None, "Write a page instead, complete in one file.")
    steps: int | None = entry(None, "How many steps to show.")
    package_dir: tuple[Path, ...] = entry((), "Directory with the packages of the meshes.")
    host: str | None = entry(
        None, "Address to listen on; by default 127.0.0.1: this machine alone.", metavar="ADDRESS"
    )
    port: int | None = entry(None, "Port to listen on; by default a free one from 7000 on.")


@command(app)
def play(options: PlayOptions) -> None:
    """Watch a gait or a transition in the browser."""
    from gaitopt.cli import show as watch

    watch.run_play(
        options.gait, options.html, options.steps, tuple(map(str, options.package_dir)),
        options.host, options.port,
    )  # fmt: skip


@dataclass(frozen=True)
class LiveOptions:
    """Of `gaitopt live`, beside all settings."""

    config: Path | None = entry(None, _CONFIG, panel=METHOD)
    output: Path = entry(
        Path("live"), "Directory for walks that are kept.", metavar="DIR", short="-o", panel=RESULTS
    )
    host: str | None = entry(
        None, "Address to listen on; by default 127.0.0.1: this machine alone.",
        metavar="ADDRESS", panel=RESULTS,
    )  # fmt: skip
    port: int | None = entry(
        None, "Port to listen on; by default a free one from 7000 on.", panel=RESULTS
    )
    stay: bool = entry(False, "Go on when the page is closed.", panel=RESULTS)


@command(app, _all_settings)
def live(options: LiveOptions, settings: Settings) -> None:
    """Serve a page whose sliders are answered with the walk of their settings, at once."""
    from gaitopt.cli import live as work

    work.run_live(
        settings, options.config, options.output, options.host, options.port, options.stay
    )


@dataclass(frozen=True)
class PlotOptions:
    """Of `gaitopt plot`."""

    gait: Path = entry(..., _GAIT, argument=True, metavar="GAIT")
    output: Path | None = entry(
        None,
        "Directory for the figures; by default 'figures' next to the gait.",
        metavar="DIR",
        short="-o",
    )
    format: tuple[str, ...] = entry(
        (), "Form of the figures: png (default), svg or pdf.", metavar="KIND"
    )


@command(app)
def plot(options: PlotOptions) -> None:
    """Draw the figures of a gait or a transition."""
    from gaitopt.cli import show as watch

    watch.run_plot(options.gait, options.output, list(options.format))


@dataclass(frozen=True)
class ExportOptions:
    """Of `gaitopt export`."""

    gait: Path = entry(
        ..., "The file of a gait or a transition, or a gait library, all of which is written.",
        argument=True, metavar="GAIT",
    )  # fmt: skip
    format: str | None = entry(
        None,
        "Form: motion, mujoco, pinocchio, csv, g1-csv, bezier, json; mjcf: robot and walk.",
        metavar="NAME",
    )
    rate: float | None = entry(None, "Samples a second; each format has its default.", "Hz")
    strides: float | None = entry(None, "Strides of two steps; by default 1.", metavar="N")
    joints: str | None = entry(
        None,
        "Order of the joints: gait, mujoco, isaac, g1, or their names joined by commas.",
        metavar="ORDER",
    )
    output: Path | None = entry(
        None, "File, or directory for a library; without --format the suffix chooses the form: "
        ".csv, .json, .yaml.", short="-o",
    )  # fmt: skip
    both_legs: bool = entry(
        False, "Without --format: add the mirror image of the step: a whole stride."
    )


@command(app)
def export(options: ExportOptions) -> None:
    """Write a gait, a transition, or a library for controllers, engines and learners."""
    from gaitopt.cli import export as work

    work.run(
        options.gait, options.output, name=options.format, rate=options.rate,
        strides=options.strides, joints=options.joints, both_legs=options.both_legs,
    )  # fmt: skip


@dataclass(frozen=True)
class TransitionOptions:
    """Of `gaitopt transition`."""

    begin: str = entry(
        ..., "What it leads from: a gait file, or 'standing'.", argument=True, metavar="FROM"
    )
    finish: str = entry(
        ..., "What it leads to: a gait file, or 'standing'.", argument=True, metavar="TO"
    )
    output: Path = entry(
        ..., "File to write, .npz: for gaitopt check, play, plot and export.", short="-o"
    )
    steps: int = entry(3, "Number of steps between.", metavar="N")
    duration: str | None = entry(
        None, "Duration of each step, as 0.4 or 0.3,0.4; by default it is searched.", metavar="S"
    )
    shift: float = entry(
        0.0,
        "From standing: time in which the weight moves over one foot while both stand; "
        "searched with the duration of the first step.",
        "s",
    )
    stretch: float = entry(
        0.96, "Of the legs of a robot that stands: distance of hip and ankle over their length.",
        metavar="RATIO",
    )  # fmt: skip


@command(app)
def transition(options: TransitionOptions) -> None:
    """Design the steps from standing to a walk, back, or from one walk to another."""
    from gaitopt.cli import transition as work

    work.run(
        options.begin, options.finish, options.output, steps=options.steps,
        duration=options.duration, shift=options.shift, stretch=options.stretch,
    )  # fmt: skip


@dataclass(frozen=True)
class ReproduceOptions:
    """Of `gaitopt reproduce`."""

    output: Path = entry(
        ..., "Directory for reproduction.md, figures and numbers.", metavar="DIR", short="-o"
    )
    only: str | None = entry(None, "Only some tables and figures, as table3,fig7.", metavar="PARTS")
    quiet: bool = entry(False, _QUIET, short="-q")


@command(app)
def reproduce(options: ReproduceOptions) -> None:
    """Compute the paper's section 6 again, as `python -m reproduction` in the sources."""
    from gaitopt.cli import reproduce as work

    work.run(options.output, options.only, options.quiet)
