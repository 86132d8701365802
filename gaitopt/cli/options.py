"""The options of the commands: name, type and help. Their defaults stand in the method's own types.

Names are those of the configuration file (`gaitopt.cli.config`).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from gaitopt.cli.units import M_PER_S, NM, RAD, RAD_PER_S, M, N, S, Units, reader, sine
from gaitopt.cli.writable import named_directory

_TASK, _LIMITS = "What is asked", "Limits"
_METHOD, _RESULT = "Method", "Results"


def option(names: str, help_text: str, panel: str, metavar: str | None = None) -> object:
    """Return a typer option; `names` as typer takes them, separated by spaces."""
    return typer.Option(
        *names.split(), help=help_text, rich_help_panel=panel, metavar=metavar, show_default=False
    )


def quantity(
    names: str,
    help_text: str,
    panel: str,
    unit: Units,
    read: Callable[[object], float] | None = None,
) -> object:
    """Return the typer option of a number with a unit, which may stand behind it."""
    return typer.Option(
        *names.split(), help=help_text, rich_help_panel=panel, metavar=next(iter(unit)).upper(),
        show_default=False, parser=read or reader(unit),
    )  # fmt: skip


def output_directory(help_text: str, panel: str | None = None) -> object:
    """Return the typer option of a directory to write to."""
    return typer.Option(
        "--output", "-o", help=help_text, rich_help_panel=panel, metavar="DIR", show_default=False,
        parser=named_directory,
    )  # fmt: skip


def _print_version(wanted: bool) -> None:
    if wanted:
        from gaitopt.version import __version__

        typer.echo(f"gaitopt {__version__}")
        raise typer.Exit


Version = Annotated[
    bool,
    typer.Option(
        "--version", callback=_print_version, is_eager=True, help="Show the version and exit."
    ),
]

Speed = Annotated[float | None, quantity("--speed", "Walking speed.", _TASK, M_PER_S)]
Fastest = Annotated[
    bool,
    option("--fastest", "Search the fastest walk, from this speed up.", _TASK),
]
Duration = Annotated[float | None, quantity("--duration", "Duration of a step.", _TASK, S)]
Preset = Annotated[
    str | None,
    option(
        "--preset",
        "'standard'; 'paper': its constraints only; 'humanoid': sized by the robot, for --urdf "
        "and --robot.",
        _TASK,
        "NAME",
    ),
]
SpeedAs = Annotated[
    str | None,
    option("--speed-as", "Speed as a 'constraint' or a 'penalty'.", _TASK, "KIND"),
]
PenaltyWeight = Annotated[
    float | None, option("--penalty-weight", "Weight of that penalty.", _TASK, "COST/M²")
]
Boundary = Annotated[
    str | None,
    option("--boundary", "Double support by inverse kinematics, 'closed', or 'lifted'.", _TASK,
            "FORM"),
]  # fmt: skip
Free = Annotated[
    list[str] | None,
    option("--free", "Let the optimiser choose a geometric quantity; repeatable.", _TASK, "NAME"),
]
Fix = Annotated[
    list[str] | None,
    option("--fix", "Hold a geometric quantity at a value; repeatable.", _TASK, "NAME=VALUE"),
]
Postures = Annotated[
    int | None, option("--postures", "Intermediate postures of the splines.", _TASK, "N")
]
Samples = Annotated[int | None, option("--samples", "Instants of the step.", _TASK, "N")]
Quadrature = Annotated[
    str | None,
    option("--quadrature", "Rule for the cost, 'simpson' or 'euler'.", _TASK, "RULE"),
]

TorqueLimit = Annotated[
    float | None,
    quantity("--torque-limit", "Of every joint, in place of the robot's.", _LIMITS, NM),
]
SpeedLimit = Annotated[
    float | None,
    quantity("--speed-limit", "Of every joint, in place of the robot's.", _LIMITS, RAD_PER_S),
]
Friction = Annotated[float | None, option("--friction", "Coefficient.", _LIMITS, "MU")]
MinimumLoad = Annotated[
    float | None, quantity("--minimum-load", "Least vertical ground force.", _LIMITS, N)
]
CopMargin = Annotated[
    float | None,
    quantity("--cop-margin", "Centre of pressure to the edge of the sole.", _LIMITS, M),
]
Clearance = Annotated[
    float | None, quantity("--clearance", "Height of the swing foot at mid-step.", _LIMITS, M)
]
LateralGap = Annotated[
    float | None, quantity("--lateral-gap", "Between swing and stance sole.", _LIMITS, M)
]
KneeFlexion = Annotated[
    float | None, quantity("--knee-flexion", "Least bend of the knees.", _LIMITS, RAD)
]
LegExtension = Annotated[
    float | None,
    option("--leg-extension", "Longest leg over the straight one.", _LIMITS, "RATIO"),
]
LiftoffSpeed = Annotated[
    float | None,
    quantity("--liftoff-speed", "Least speed of the rear foot as it leaves.", _LIMITS, M_PER_S),
]
JointRange = Annotated[
    bool | None, option("--joint-range/--no-joint-range", "Impose joint ranges.", _LIMITS)
]
ImpulseCop = Annotated[
    bool | None,
    option("--impulse-cop/--no-impulse-cop", "Landing foot must not tip.", _LIMITS),
]

TrunkRoll = Annotated[
    float | None,
    quantity("--trunk-roll", "Largest sideways lean of the trunk.", _LIMITS, RAD),
]
TrunkPitch = Annotated[
    float | None, quantity("--trunk-pitch", "Largest lean forward or back.", _LIMITS, RAD)
]
TrunkYaw = Annotated[
    float | None, quantity("--trunk-yaw", "Largest turn of the trunk.", _LIMITS, RAD)
]
TorsionalFriction = Annotated[
    float | None,
    quantity("--torsional-friction", "Turning moment over load a foot bears.", _LIMITS, M),
]
StepWidth = Annotated[
    float | None,
    quantity("--step-width", "Largest distance of the feet sideways.", _LIMITS, M),
]
LegGap = Annotated[
    float | None,
    quantity("--leg-gap", "Least distance between the legs' bodies.", _LIMITS, M),
]
SwingTilt = Annotated[
    float | None, quantity("--swing-tilt", "Largest tilt of the swing foot.", _LIMITS, RAD, sine)
]

Solver = Annotated[str | None, option("--solver", "Which solver.", _METHOD, "NAME")]
QpSolver = Annotated[
    str | None, option("--qp-solver", "Quadratic solver of the SQP.", _METHOD, "NAME")
]
Tolerance = Annotated[
    float | None, option("--tolerance", "Of the optimality conditions.", _METHOD, "X")
]
MaxIterations = Annotated[
    int | None, option("--max-iterations", "Of one run of the solver.", _METHOD, "N")
]
Differences = Annotated[
    str | None,
    option(
        "--differences",
        "Finite differences for 'none', 'constraints' or 'all' derivatives.",
        _METHOD,
        "WHICH",
    ),
]
Approach = Annotated[
    str | None,
    option(
        "--approach",
        "'relaxed': first with a lift-off that may fail a little; 'direct'; or 'automatic'.",
        _METHOD,
        "HOW",
    ),
]
Refine = Annotated[
    bool | None,
    option("--refine/--no-refine", "Keep the limits between the instants too.", _METHOD),
]
Start = Annotated[
    Path | None, option("--start", "Gait whose parameters are the first guess.", _METHOD, "GAIT")
]
Starts = Annotated[
    int | None,
    option("--starts", "First guesses to try; 1 with --start or --seed.", _METHOD, "N"),
]
Seed = Annotated[
    int | None, option("--seed", "Disturb the first guess; number of the noise.", _METHOD, "N")
]
Sigma = Annotated[
    float | None, quantity("--sigma", "Standard deviation of that noise.", _METHOD, RAD)
]
Config = Annotated[
    Path | None,
    option("--config", "TOML file with any of these options; the command line wins.", _METHOD,
            "FILE"),
]  # fmt: skip

OutputDirectory = Annotated[
    Path | None, output_directory("Directory for gait, page, figures and tables.", _RESULT)
]
Page = Annotated[bool, option("--page/--no-page", "Write the walking robot.", _RESULT)]
Figures = Annotated[bool, option("--figures/--no-figures", "Write the figures.", _RESULT)]
Quiet = Annotated[bool, option("--quiet -q", "Print nothing but errors.", _RESULT)]

GaitFile = Annotated[Path, typer.Argument(metavar="GAIT", help="A gait file, .npz.")]


def _plain(names: str, help_text: str, metavar: str | None = None) -> object:
    """Return a typer option of a command that has few."""
    return typer.Option(*names.split(), help=help_text, metavar=metavar, show_default=False)


UrdfOutput = Annotated[
    Path | None, _plain("--output -o", "Where to write it; by default to the terminal.", "FILE")
]
NewSpec = Annotated[
    Path | None, _plain("--write-spec", "Write the parameter table instead, to edit.", "FILE")
]
Html = Annotated[
    Path | None, _plain("--html", "Write a page instead, complete in one file.", "FILE")
]
Steps = Annotated[int | None, _plain("--steps", "How many steps to show.", "N")]
Host = Annotated[
    str | None,
    _plain("--host", "Address to listen on; by default 127.0.0.1: this machine alone.", "ADDRESS"),
]
Port = Annotated[
    int | None, _plain("--port", "Port to listen on; by default a free one from 7000 on.", "N")
]
MeshDir = Annotated[
    list[Path] | None,
    _plain("--package-dir", "Directory with the packages of the meshes; repeatable.", "DIR"),
]
FigureDirectory = Annotated[
    Path | None, output_directory("Where to; by default 'figures' next to the gait.")
]
Formats = Annotated[
    list[str] | None, _plain("--format", "png (default), svg or pdf; repeatable.", "KIND")
]
ExportFile = Annotated[Path, _plain("--output -o", "File; its suffix chooses the form.", "FILE")]
BothLegs = Annotated[
    bool, _plain("--both-legs", "Add the mirror image of the step: a whole stride.")
]
ReproductionDirectory = Annotated[Path, output_directory("For reproduction.md, figures, numbers.")]
ReproductionParts = Annotated[
    str | None,
    typer.Option("--only", help="Only some tables and figures, as table3,fig7.", metavar="PARTS"),
]
