"""The commands. Each says what it takes; the work is done elsewhere and imported when needed."""

from __future__ import annotations

from collections.abc import Iterable

import typer

from gaitopt.cli import options as opt
from gaitopt.cli import robot_options as rob
from gaitopt.cli import sweep_options as many
from gaitopt.cli.failures import failures_reported
from gaitopt.cli.help_defaults import CommandWithDefaults
from gaitopt.cli.interrupt import take_signals
from gaitopt.cli.streams import outlive_readers

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
    """Run the command line in a process of its own."""
    outlive_readers()
    take_signals()
    app(prog_name="gaitopt")


@app.callback()
def options_before_a_command(version: opt.Version = False) -> None:
    """Take the options that stand before a command."""
    del version  # its callback has done the work


@app.command()
@failures_reported()
def urdf(
    spec: rob.SpecFile = None, output: opt.UrdfOutput = None, write_spec: opt.NewSpec = None
) -> None:
    """Write the URDF of a biped (by default of the thirteen-link one)."""
    from gaitopt.cli import robot_files

    robot_files.run(spec, output, write_spec)


def optimise(
    ctx: typer.Context,
    speed: opt.Speed = None,
    fastest: opt.Fastest = False,
    duration: opt.Duration = None,
    preset: opt.Preset = None,
    speed_as: opt.SpeedAs = None,
    penalty_weight: opt.PenaltyWeight = None,
    boundary: opt.Boundary = None,
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
    trunk_roll: opt.TrunkRoll = None,
    trunk_pitch: opt.TrunkPitch = None,
    trunk_yaw: opt.TrunkYaw = None,
    torsional_friction: opt.TorsionalFriction = None,
    step_width: opt.StepWidth = None,
    leg_gap: opt.LegGap = None,
    swing_tilt: opt.SwingTilt = None,
    robot: rob.RobotName = None,
    urdf: rob.UrdfFile = None,
    spec: rob.SpecFile = None,
    choices: rob.ChoicesFile = None,
    package_dir: rob.PackageDir = None,
    forward: rob.Forward = None,
    posture: rob.Posture = None,
    srdf: rob.SrdfFile = None,
    sole: rob.SoleEdges = None,
    stance_sole: rob.StanceSole = None,
    swing_sole: rob.SwingSole = None,
    without: rob.Without = None,
    armature: rob.Armature = None,
    solver: opt.Solver = None,
    qp_solver: opt.QpSolver = None,
    tolerance: opt.Tolerance = None,
    max_iterations: opt.MaxIterations = None,
    differences: opt.Differences = None,
    approach: opt.Approach = None,
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

    given = _given(ctx, [name for section in SCHEMA.values() for name in section])
    work.run(
        given, config=config, output=output, fastest=fastest, page=page, figures=figures,
        quiet=quiet,
    )  # fmt: skip


def _given(ctx: typer.Context, names: Iterable[str]) -> dict[str, object]:
    """Return the options that were given; a repeatable one that is absent is an empty list."""
    return {name: ctx.params[name] for name in names if ctx.params[name] not in (None, [], ())}


for _name, _hidden in (("optimise", False), ("optimize", True)):
    app.command(_name, cls=CommandWithDefaults, hidden=_hidden)(failures_reported()(optimise))
app.command("sweep", cls=CommandWithDefaults)(failures_reported()(many.sweep_command(optimise)))


@app.command()
@failures_reported()
def library(
    directory: many.LibraryDirectory,
    where: many.Where = None,
    columns: many.Columns = None,
    plot: many.Plot = None,
    at: many.At = None,
    output: many.GaitOutput = None,
) -> None:
    """List a gait library, draw it, or design a gait between its gaits."""
    from gaitopt.cli import library as work

    if at:
        work.run_at(directory, at, output)
    else:
        work.run_list(directory, where or [], columns, plot)


@app.command()
@failures_reported()
def inspect(
    ctx: typer.Context,
    robot: rob.RobotName = None,
    urdf: rob.UrdfFile = None,
    spec: rob.SpecFile = None,
    choices: rob.ChoicesFile = None,
    package_dir: rob.PackageDir = None,
    forward: rob.Forward = None,
    posture: rob.Posture = None,
    srdf: rob.SrdfFile = None,
    sole: rob.SoleEdges = None,
    stance_sole: rob.StanceSole = None,
    swing_sole: rob.SwingSole = None,
    without: rob.Without = None,
    armature: rob.Armature = None,
    html: rob.RobotPage = None,
    write_choices: rob.NewChoices = None,
) -> None:
    """Say what gaitopt understood of a robot, what it guessed, and what is wrong with the file."""
    from gaitopt.cli import inspection as work
    from gaitopt.cli.config import SCHEMA

    work.run(_given(ctx, SCHEMA["robot"]), html, write_choices)


@app.command()
@failures_reported()
def robots() -> None:
    """List the robots that can be asked for by name."""
    from gaitopt.cli import robot_list

    robot_list.run()


@app.command()
@failures_reported()
def check(gait: opt.GaitFile) -> None:
    """Compute a gait file again, from its parameters alone, and certify it."""
    from gaitopt.cli import check as work

    work.run(gait)


@app.command()
@failures_reported()
def play(
    gait: opt.GaitFile,
    html: opt.Html = None,
    steps: opt.Steps = None,
    package_dir: opt.MeshDir = None,
    host: opt.Host = None,
    port: opt.Port = None,
) -> None:
    """Watch a gait in the browser."""
    from gaitopt.cli import watch

    watch.run_play(gait, html, steps, tuple(map(str, package_dir or ())), host, port)


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


@app.command()
@failures_reported()
def reproduce(
    output: opt.ReproductionDirectory, only: opt.ReproductionParts = None, quiet: opt.Quiet = False
) -> None:
    """Compute the paper's section 6 again, as `python -m reproduction` in the sources."""
    from gaitopt.cli import reproduce as work

    work.run(output, only, quiet)
