"""Linear motors of loops: every output tells forces in N, speeds in m/s, travels in m."""

import csv
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest
from looped_bipeds import parallel_ankles
from places import EXAMPLES

from gaitopt.design.requirements import own_motor_loops
from gaitopt.design.summary import summarise
from gaitopt.gait.constraint import ConstraintContext
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.motor_space import LoopMotors
from gaitopt.gait.result import Gait, robot_of
from gaitopt.gait.task import Margins
from gaitopt.sweep.table import motor_columns, unit_of
from gaitopt.units import motion_words
from gaitopt.view.comparison_figures import torque_speed_figure
from gaitopt.view.page import curves, page_text

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

MOTOR = "inner motor"
WIDTH = 80  # columns, which every table fits


@dataclass(frozen=True)
class Walk:
    """A walk whose inner motors slide and outer motors turn, and what the commands say of it.

    Attributes:
        folder: what `optimise` wrote, with the tables of `requirements`.
        report, requirements: what they print.
        gait: the walk.
    """

    folder: Path
    report: str
    requirements: str
    gait: Gait


@pytest.fixture(scope="module")
def walk(quick, cli, tmp_path_factory):
    folder = tmp_path_factory.mktemp("linear")
    text = parallel_ankles(sliding=("inner",), torque=100.0, narrow=True)
    (folder / "biped.xml").write_text(text, "utf-8")
    limits = ("--limit", "*_inner_motor.speed=60cm/s", "--limit", "*_inner_motor.armature=0.1")
    words = ("--urdf", folder / "biped.xml", "--speed", "0.8", "--duration", "0.4", *limits)
    report = quick(*words, "-o", folder)
    asked = ("requirements", folder / "gait.npz", "--motors", EXAMPLES / "motors.toml")
    for suffix in ("csv", "toml"):
        said = cli(*asked, "-o", folder / f"needs.{suffix}")
        assert said.exit_code == 0, said.stderr
    return Walk(folder, report.stdout, said.stdout, load_gait(folder / "gait.npz"))


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("*_inner_motor=0.2kg", None),
        ("*_inner_motor=200g", None),
        ("*_inner_motor=0.2", None),
        ("*_outer_motor=0.2kg", "given in kg, but joint '.*_outer_motor' turns; give kg·m²"),
        ("*_inner_motor=3 g·cm²", "given in kg·m², but joint '.*_inner_motor' slides; give kg, or"),
        ("*_inner_motor=2000kg", "armature is 2000 kg; it must be from 0 to 1000 kg$"),
        ("*_inner_motor=2lb", "give a number in kg·m², .*; for a joint that slides: kg, g"),
    ],
)
def test_units_of_armature_are_those_of_the_joint(given, said, cli, tmp_path):
    text = parallel_ankles(sliding=("inner",), torque=100.0, narrow=True)
    (tmp_path / "biped.xml").write_text(text, "utf-8")
    result = cli("inspect", "--urdf", tmp_path / "biped.xml", "--armature", given)
    words = " ".join((result.stderr if said else result.stdout).split())
    assert result.exit_code == (2 if said else 0)
    assert re.search(said or "armature 0.2 kg ", words), words


def between(text, begin, end):
    assert text.count(begin) == 1
    return text.split(begin)[1].split(end)[0]


def spreadsheet(walk):
    with (walk.folder / "needs.csv").open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["motor"] == MOTOR]
    return [[column for column, cell in row.items() if cell] for row in rows]


def summary(walk):
    known = json.loads((walk.folder / "summary.json").read_text("utf-8"))
    return [
        one for table in ("linkages", "motors") for one in known[table] if one["joint"] == MOTOR
    ]


def motions(walk):
    panels = [panel for tab in curves(walk.gait)["tabs"] for panel in tab["panels"]]
    return [panel["unit"] for panel in panels if panel["title"] == MOTOR]


def labels(walk):
    context = ConstraintContext(robot_of(walk.gait), uniform_grid(3), Margins(), 1.0, 0.4)
    return [label for label in LoopMotors().block(context).labels if "inner_motor" in label]


def axes(walk):
    panels = torque_speed_figure({"walk": own_motor_loops(walk.gait)}).axes
    mine = next(panel for panel in panels if panel.get_title(loc="left") == MOTOR)
    return mine.get_xlabel(), mine.get_ylabel()


def columns(walk):
    names = motor_columns(summarise(walk.gait)["motors"])
    return [(name, unit_of(name)) for name in names if name.endswith(".inner_motor")]


def findings(walk):
    return [f.text for f in robot_of(walk.gait).findings if f.subject == "*_inner_motor"]


OUTPUTS = {
    "report": (lambda walk: between(walk.report, "Linear motors", "\n\n"), "m/s"),
    "page": (lambda walk: between(page_text(walk.gait), "Linear motors", "</table>"), "m/s"),
    "curves": (motions, "N over m/s"),
    "summary": (summary, "peak_force_N"),
    "library": (columns, "m/s"),
    "requirements": (lambda walk: between(walk.requirements, "Linear motors", "Before"), "m/s"),
    "spreadsheet": (spreadsheet, "peak_speed [m/s]"),
    "record": (
        lambda walk: tomllib.loads((walk.folder / "needs.toml").read_text("utf-8"))["motors"][
            MOTOR
        ],
        "speed_at_peak_force",
    ),
    "figure": (axes, "force [N]"),
    "findings": (findings, "0.6 m/s"),
    "limits": (labels, "travel of motor"),
}
"""What each output says of the motor that slides, and a piece of it."""


@pytest.mark.parametrize("output", OUTPUTS)
def test_what_slides_is_not_told_as_if_it_turned(walk, output):
    told, piece = OUTPUTS[output]
    text = str(told(walk))
    assert piece in text
    assert not re.search(r"N·m|Nm|rad|rpm|torque|angle|kg·m²", text)


def test_tables_fit_and_motors_that_turn_stay_as_they_are(walk):
    for text, last in ((walk.report, "Proof"), (walk.requirements, "wrote")):
        lines = text.split(last)[0].splitlines()
        assert max(map(len, lines)) <= WIDTH
        assert any(line.startswith("outer motor") for line in lines)
    outer = next(m for m in summarise(walk.gait)["motors"] if m["joint"] == "outer motor")
    assert outer["torque_limit_Nm"] == 100.0
    assert MOTOR not in walk.requirements.split("Before the gear")[1]


def test_units_follow_from_those_of_what_turns():
    pairs = {
        "N·m·s/rad": "N·s/m",
        "rad/s2": "m/s2",
        "kg·m²": "kg",
        "peak_torque_Nm": "peak_force_N",
        "peak_speed_rad_per_s": "peak_speed_m_per_s",
        "peak_power_W": "peak_power_W",
    }
    for turning, sliding in pairs.items():
        assert motion_words(turning, slides=True) == sliding
        assert motion_words(turning, slides=False) == turning
