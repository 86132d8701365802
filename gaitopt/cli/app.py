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
def options_before_a_command(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
        ),
    ] = False,
) -> None:
    """Take the options that stand before a command."""
    del version  # its callback has done the work


@app.command()
@failures_reported()
def urdf(
    spec: opt.SpecFile = None, output: opt.UrdfOutput = None, write_spec: opt.NewSpec = None
) -> None:
    """Write the URDF of a biped (by default of the thirteen-link one)."""
    from gaitopt.cli import robot_files

    robot_files.run(spec, output, write_spec)


def optimise(
    ctx: typer.Context,
    speed: opt.Speed = None,
    duration: opt.Duration = None,
    preset: opt.Preset = None,
    speed_as: opt.SpeedAs = None,
    penalty_weight: opt.PenaltyWeight = None,
    free: opt.Free = None,
    fix: opt.Fix = None,
    postures: opt.Postures = None,
    samples: opt.Samples = None,
    quadrature: opt.Quadrature = None,
    torque_limit: opt.TorqueLimit = None,
    speed_limit: opt.SpeedLimit = None,
    friction: opt.Friction = None,
    minimum_load: opt.MinimumLoad = None,
    cop_margin: opt.CopMargin = None,
    clearance: opt.Clearance = None,
    lateral_gap: opt.LateralGap = None,
    knee_flexion: opt.KneeFlexion = None,
    leg_extension: opt.LegExtension = None,
    liftoff_speed: opt.LiftoffSpeed = None,
    joint_range: opt.JointRange = None,
    impulse_cop: opt.ImpulseCop = None,
    spec: opt.SpecFile = None,
    urdf: opt.UrdfFile = None,
    stance_sole: opt.StanceSole = None,
    swing_sole: opt.SwingSole = None,
    solver: opt.Solver = None,
    qp_solver: opt.QpSolver = None,
    tolerance: opt.Tolerance = None,
    max_iterations: opt.MaxIterations = None,
    differences: opt.Differences = None,
    refine: opt.Refine = None,
    start: opt.Start = None,
    starts: opt.Starts = None,
    seed: opt.Seed = None,
    sigma: opt.Sigma = None,
    config: opt.Config = None,
    output: opt.OutputDirectory = None,
    page: opt.Page = True,
    figures: opt.Figures = True,
    quiet: opt.Quiet = False,
) -> None:
    """Design the gait that walks at a given speed for the least effort."""
    from gaitopt.cli import optimise as work
    from gaitopt.cli.config import SCHEMA

    names = [name for section in SCHEMA.values() for name in section]
    # a repeatable option that is absent is an empty list
    given = {name: ctx.params[name] for name in names if ctx.params[name] not in (None, [], ())}
    work.run(given, config=config, output=output, page=page, figures=figures, quiet=quiet)


for _name, _hidden in (("optimise", False), ("optimize", True)):
    app.command(_name, cls=CommandWithDefaults, hidden=_hidden)(failures_reported()(optimise))


@app.command()
@failures_reported()
def check(gait: opt.GaitFile) -> None:
    """Compute a gait file again, from its parameters alone, and certify it."""
    from gaitopt.cli import check as work

    work.run(gait)


@app.command()
@failures_reported()
def play(gait: opt.GaitFile, html: opt.Html = None, steps: opt.Steps = None) -> None:
    """Watch a gait in the browser."""
    from gaitopt.cli import watch

    watch.run_play(gait, html, steps)


@app.command()
@failures_reported()
def plot(
    gait: opt.GaitFile, output: opt.FigureDirectory = None, formats: opt.Formats = None
) -> None:
    """Draw the figures of a gait."""
    from gaitopt.cli import watch

    watch.run_plot(gait, output, formats)


@app.command()
@failures_reported()
def export(gait: opt.GaitFile, output: opt.ExportFile, both_legs: opt.BothLegs = False) -> None:
    """Write a gait for a spreadsheet or a controller: .csv, .json or .yaml."""
    from gaitopt.cli import watch

    watch.run_export(gait, output, both_legs)
