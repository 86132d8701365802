"""The options of the commands: name, type and help. Their defaults stand in the method's own types.

Names are those of the configuration file (`gaitopt.cli.config`).
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

_TASK, _LIMITS, _ROBOT = "What is asked", "Limits", "Robot"
_METHOD, _RESULT = "Method", "Results"


def _option(names: str, help_text: str, panel: str, metavar: str | None = None) -> object:
    """Return a typer option; `names` as typer takes them, separated by spaces."""
    return typer.Option(
        *names.split(), help=help_text, rich_help_panel=panel, metavar=metavar, show_default=False
    )


Speed = Annotated[float | None, _option("--speed", "Walking speed.", _TASK, "M/S")]
Duration = Annotated[float | None, _option("--duration", "Duration of a step.", _TASK, "S")]
Preset = Annotated[
    str | None,
    _option("--preset", "'standard', or 'paper': its constraints only.", _TASK, "NAME"),
]
SpeedAs = Annotated[
    str | None,
    _option("--speed-as", "Speed as a 'constraint' or a 'penalty'.", _TASK, "KIND"),
]
PenaltyWeight = Annotated[
    float | None, _option("--penalty-weight", "Weight of that penalty.", _TASK, "COST/M²")
]
Free = Annotated[
    list[str] | None,
    _option("--free", "Let the optimiser choose a geometric quantity; repeatable.", _TASK, "NAME"),
]
Fix = Annotated[
    list[str] | None,
    _option("--fix", "Hold a geometric quantity at a value; repeatable.", _TASK, "NAME=VALUE"),
]
Postures = Annotated[
    int | None, _option("--postures", "Intermediate postures of the splines.", _TASK, "N")
]
Samples = Annotated[int | None, _option("--samples", "Instants of the step.", _TASK, "N")]
Quadrature = Annotated[
    str | None,
    _option("--quadrature", "Rule for the cost, 'simpson' or 'euler'.", _TASK, "RULE"),
]

TorqueLimit = Annotated[
    float | None,
    _option("--torque-limit", "Of every joint, in place of the robot's.", _LIMITS, "N·M"),
]
SpeedLimit = Annotated[
    float | None,
    _option("--speed-limit", "Of every joint, in place of the robot's.", _LIMITS, "RAD/S"),
]
Friction = Annotated[float | None, _option("--friction", "Coefficient.", _LIMITS, "MU")]
MinimumLoad = Annotated[
    float | None, _option("--minimum-load", "Least vertical ground force.", _LIMITS, "N")
]
CopMargin = Annotated[
    float | None,
    _option("--cop-margin", "Centre of pressure to the edge of the sole.", _LIMITS, "M"),
]
Clearance = Annotated[
    float | None, _option("--clearance", "Height of the swing foot at mid-step.", _LIMITS, "M")
]
LateralGap = Annotated[
    float | None, _option("--lateral-gap", "Between swing and stance sole.", _LIMITS, "M")
]
KneeFlexion = Annotated[
    float | None, _option("--knee-flexion", "Least bend of the knees.", _LIMITS, "RAD")
]
LegExtension = Annotated[
    float | None,
    _option("--leg-extension", "Longest leg over the straight one.", _LIMITS, "RATIO"),
]
LiftoffSpeed = Annotated[
    float | None,
    _option("--liftoff-speed", "Least speed of the rear foot as it leaves.", _LIMITS, "M/S"),
]
JointRange = Annotated[
    bool | None, _option("--joint-range/--no-joint-range", "Impose joint ranges.", _LIMITS)
]
ImpulseCop = Annotated[
    bool | None,
    _option("--impulse-cop/--no-impulse-cop", "Landing foot must not tip.", _LIMITS),
]

SpecFile = Annotated[
    Path | None,
    _option("--spec", "Parameter table of a biped, TOML.", _ROBOT, "FILE"),
]
UrdfFile = Annotated[Path | None, _option("--urdf", "URDF of any biped.", _ROBOT, "FILE")]
StanceSole = Annotated[
    str | None, _option("--stance-sole", "Frame of the standing sole.", _ROBOT, "FRAME")
]
SwingSole = Annotated[
    str | None, _option("--swing-sole", "Frame of the other sole.", _ROBOT, "FRAME")
]

Solver = Annotated[str | None, _option("--solver", "Which solver.", _METHOD, "NAME")]
QpSolver = Annotated[
    str | None, _option("--qp-solver", "Quadratic solver of the SQP.", _METHOD, "NAME")
]
Tolerance = Annotated[
    float | None, _option("--tolerance", "Of the optimality conditions.", _METHOD, "X")
]
MaxIterations = Annotated[
    int | None, _option("--max-iterations", "Of one run of the solver.", _METHOD, "N")
]
Differences = Annotated[
    str | None,
    _option(
        "--differences",
        "Finite differences for 'none', 'constraints' or 'all' derivatives.",
        _METHOD,
        "WHICH",
    ),
]
Refine = Annotated[
    bool | None,
    _option("--refine/--no-refine", "Keep the limits between the instants too.", _METHOD),
]
Start = Annotated[
    Path | None, _option("--start", "Gait whose parameters are the first guess.", _METHOD, "GAIT")
]
Starts = Annotated[
    int | None,
    _option("--starts", "First guesses to try; the best walk is kept.", _METHOD, "N"),
]
Seed = Annotated[
    int | None, _option("--seed", "Disturb the first guess; number of the noise.", _METHOD, "N")
]
Sigma = Annotated[
    float | None, _option("--sigma", "Standard deviation of that noise.", _METHOD, "RAD")
]
Config = Annotated[
    Path | None,
    _option("--config", "TOML file with any of these options; the command line wins.", _METHOD,
            "FILE"),
]  # fmt: skip

OutputDirectory = Annotated[
    Path | None,
    _option("--output -o", "Directory for gait, page, figures and tables.", _RESULT, "DIR"),
]
Page = Annotated[bool, _option("--page/--no-page", "Write the walking robot.", _RESULT)]
Figures = Annotated[bool, _option("--figures/--no-figures", "Write the figures.", _RESULT)]
Quiet = Annotated[bool, _option("--quiet -q", "Print nothing but errors.", _RESULT)]

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
FigureDirectory = Annotated[
    Path | None,
    _plain("--output -o", "Where to; by default 'figures' next to the gait.", "DIR"),
]
Formats = Annotated[
    list[str] | None, _plain("--format", "png (default), svg or pdf; repeatable.", "KIND")
]
ExportFile = Annotated[Path, _plain("--output -o", "File; its suffix chooses the form.", "FILE")]
BothLegs = Annotated[
    bool, _plain("--both-legs", "Add the mirror image of the step: a whole stride.")
]
