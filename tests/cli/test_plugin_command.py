"""Constraints and costs of one's own on the command line and in configuration files."""

import json
import pickle
import re
import shutil

import pytest
from places import SWING_HEIGHT

from gaitopt.cli.config import read_config
from gaitopt.cli.request import make_request
from gaitopt.errors import InputError
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.plugin import extension_record, load_plugin

SUM = """
from dataclasses import dataclass

import numpy as np
from gaitopt import RunningCost, SquaredNorm, TorqueCost, WeightedSum
from gaitopt.gait import quantities


@dataclass(frozen=True)
class Calm(RunningCost):
    name, unit, words = "calm", "rad²/(m·s)", "squared joint rates per metre"
    reads = (quantities.RATES,)
    weight: float = 2.0

    def integrand(self, robot):
        return SquaredNorm(np.full(len(robot.joint_names), self.weight))


cost = WeightedSum(((TorqueCost(), 1.0), (Calm(), 10.0)))
"""
LIMIT = """
from dataclasses import dataclass

import numpy as np
from gaitopt import ComplexStep, Constraint, Entries, margin
from gaitopt.gait import quantities


@dataclass(frozen=True)
class Roll(Constraint):
    name, unit, words = "roll", "rad", "roll of a joint"
    reads = (quantities.ANGLES,)
    least_roll: float = margin(3.0, "Roll.", unit="rad", above=0.0)

    def block(self, context):
        first = Entries(slice(0, 1), len(context.robot.joint_names))
        return self.over_step(context, first, ("roll",), upper=self.least_roll)


constraints = (Roll(),)
"""
GROUND = """
from dataclasses import dataclass

import numpy as np
from gaitopt import Profile, Terrain


@dataclass(frozen=True)
class Plain(Profile):
    length: float = 0.3

    def height(self, x):
        return np.zeros(x.shape), np.zeros(x.shape), np.zeros(x.shape)


@dataclass(frozen=True)
class Plains(Terrain):
    name, shaped, lift = "plains", True, 0.01

    def words(self, step):
        return "over plains"

    def profile(self, sole, step, nosing):
        return Plain()


terrain = Plains()
"""
QUICK = ("--starts", "1", "--no-figures", "--quiet")


@pytest.fixture(scope="module")
def designed(tmp_path_factory, cli):
    """A gait with a limit of its own, far below what the swing foot does without."""
    directory = tmp_path_factory.mktemp("own")
    shutil.copy(SWING_HEIGHT, directory / "mine.py")
    limit = ("--plugin", str(directory / "mine.py"), "--low-swing", "5cm")
    found = cli("optimise", *limit, *QUICK, "--output", str(directory / "out"))
    assert found.exit_code == 0, found.output
    return directory


def test_the_gait_keeps_the_limit_at_every_instant(designed):
    summary = json.loads((designed / "out" / "summary.json").read_text())
    assert summary["contact"]["highest_swing_toe_mm"] == pytest.approx(50.0, abs=1e-3)
    assert summary["certificate"]["certified"]


def test_check_asks_for_the_plugin_and_certifies_with_it(designed, cli):
    gait = str(designed / "out" / "gait.npz")
    without = cli("check", gait)
    assert without.exit_code == 2
    assert "constraint 'low swing', which is not gaitopt's own" in without.stderr
    assert "--plugin mine.py" in without.stderr
    assert "altered" not in without.output
    given = cli("check", gait, "--plugin", str(designed / "mine.py"))
    assert given.exit_code == 0
    assert "constraint 'low swing' of the plugin mine.py, low_swing 0.05" in given.stdout


def test_a_changed_plugin_is_told(designed, cli, tmp_path):
    other = tmp_path / "mine.py"
    other.write_text((designed / "mine.py").read_text() + "\n# another file\n")
    found = cli("check", str(designed / "out" / "gait.npz"), "--plugin", str(other))
    assert found.exit_code == 0  # it is the same constraint
    assert "the plugin mine.py has changed since the design: its sha256 was" in found.stdout


def test_another_plugin_with_a_constraint_of_that_name_is_told(designed, cli, tmp_path):
    other = tmp_path / "mine.py"
    other.write_text((designed / "mine.py").read_text().replace("low_swing", "other_swing"))
    found = cli("check", str(designed / "out" / "gait.npz"), "--plugin", str(other))
    assert found.exit_code == 2
    assert "takes other_swing, and no low_swing, which is recorded" in found.stderr
    assert "give that file: --plugin mine.py" in found.stderr
    assert "__init__" not in found.stderr


def test_the_task_that_is_written_asks_for_the_same(designed):
    task = designed / "out" / "task.toml"
    request = make_request({}, task)
    assert request.task.margin("low_swing") == 0.05
    assert (designed / "out" / request.settings["plugin"]).resolve() == designed / "mine.py"


def test_the_help_shows_its_options(cli):
    shown = cli("optimise", "--plugin", str(SWING_HEIGHT), "--help-all")
    assert "--low-swing" in shown.stdout
    assert "--low-swing" not in cli("optimise", "--help-all").stdout


def test_a_configuration_names_plugin_and_values(tmp_path):
    path = tmp_path / "task.toml"
    path.write_text(f'[plugin]\nplugin = "{SWING_HEIGHT}"\n[margins]\nlow_swing = "45 mm"\n')
    assert read_config(path)["low_swing"] == pytest.approx(0.045)
    assert make_request({}, path).task.margin("low_swing") == pytest.approx(0.045)
    assert make_request({"low_swing": 0.07}, path).task.margin("low_swing") == 0.07
    path.write_text("[margins]\nlow_swing = 0.045\n")
    assert read_config(path, SWING_HEIGHT)["low_swing"] == 0.045
    with pytest.raises(InputError, match=r"unknown entry in \[margins\] 'low_swing'"):
        read_config(path)


def test_weights_of_joints_come_from_options_and_files(tmp_path, cli):
    path = tmp_path / "task.toml"
    path.write_text('[cost]\ncost = "torque"\nweights = { "*_knee" = 2.0 }\n')
    assert make_request({}, path).task.cost == TorqueCost({"*_knee": 2.0})
    found = make_request({"weights": {"*_hip_*": 0.5}}, path).task.cost
    assert found == TorqueCost({"*_hip_*": 0.5})
    refused = cli("optimise", "--weights", "wheel=2", *QUICK)
    assert refused.exit_code == 2
    assert "the cost weighs 'wheel', but no joint is called so" in refused.stderr
    refused = cli("optimise", "--cost", "effort", *QUICK)
    assert "there is no cost 'effort'; there are torque" in refused.stderr


def test_a_plugin_offers_a_sum_of_costs(tmp_path, cli):
    """Its gait, its task.toml and the processes of a sweep know the terms, too."""
    plugin, out = tmp_path / "mine.py", tmp_path / "out"
    plugin.write_text(SUM)
    found = cli("optimise", "--plugin", plugin, *QUICK, "--output", out)
    assert found.exit_code == 0, found.stderr
    cost, again = load_plugin(plugin).cost, make_request({}, out / "task.toml").task.cost
    assert extension_record(again) == extension_record(cost)
    assert cli("check", out / "gait.npz", "--plugin", plugin).exit_code == 0
    without = cli("check", out / "gait.npz")
    assert "has the cost 'calm', which is not gaitopt's own" in without.stderr
    assert pickle.loads(pickle.dumps(cost)) == cost


def test_fields_of_the_terms_of_a_sum_are_options(tmp_path, cli):
    plugin, out = tmp_path / "mine.py", tmp_path / "out"
    declared = 'weight: float = entry(2.0, "Weight of the squared rates.", "s")'
    plugin.write_text(
        "from gaitopt.settings import entry\n"
        + SUM.replace("weight: float = 2.0", declared).replace("weight", "calmness")
    )
    asked = ("--calmness", "3", "--weights", "*_knee=2")
    found = cli("optimise", "--plugin", plugin, *asked, *QUICK, "--output", out)
    assert found.exit_code == 0, found.stderr
    again = make_request({}, out / "task.toml").task.cost
    (torque, _), (calm, share) = again.terms
    assert (calm.calmness, share) == (3.0, 10.0)
    assert torque == TorqueCost({"*_knee": 2.0})
    assert load_plugin(plugin).cost.terms[1][0].calmness == 2.0
    assert "--calmness" in cli("optimise", "--plugin", plugin, "--help-all").stdout


def test_of_two_plugins_neither_is_dropped(cli):
    refused = cli("optimise", "--plugin", SWING_HEIGHT, f"--plugin={SWING_HEIGHT}")
    assert refused.exit_code == 2
    assert "--plugin is given twice" in refused.stderr


def test_a_plugin_may_not_take_the_name_of_an_option(tmp_path, cli):
    path = tmp_path / "mine.py"
    path.write_text(SWING_HEIGHT.read_text().replace("low_swing:", "speed:"))
    refused = cli("optimise", "--plugin", str(path))
    assert refused.exit_code == 2
    assert "has a field 'speed', which is the name of an option of gaitopt" in refused.stderr


LATE = "ComplexStep(lambda v: v[:, :1] if len(v) <= 2 else v[0, 99])"
FIRST, ROWS = (
    "first = Entries(slice(0, 1), len(context.robot.joint_names))",
    "upper=self.least_roll",
)
BROKEN = [
    (LIMIT, ROWS, "upper=float('nan')", "are -inf to nan rad; give numbers"),
    (LIMIT, ROWS, "lower=1.0, upper=0.0", "limits of 'roll' .* are 1.0 to 0.0 rad"),
    (LIMIT, ROWS, "lower=np.inf, upper=np.inf", "are inf to inf rad; give numbers"),
    (LIMIT, ROWS, "upper=1e300", "are -inf to 1e.300 rad; give numbers"),
    (
        LIMIT,
        "def block",
        "asked = lambda *_: np.ones(2)\n\n    def block",
        "whether it is asked for",
    ),
    (LIMIT, ROWS, "upper='x'", "the limits of the constraint 'roll' are no numbers"),
    (LIMIT, ROWS, f"{ROWS}, scale='x'", r"the scale of the constraint 'roll' is \['x'\]"),
    (LIMIT, '("roll",)', '"r"', "give a tuple of texts for the rows"),
    (LIMIT, '("roll",)', "(5,)", "give a tuple of texts for the rows"),
    (LIMIT, FIRST, "first = None", "constraint 'roll' has None for its function"),
    (
        LIMIT,
        FIRST,
        f"first = {LATE}",
        r"IndexError: .*\(line \d+ of mine.py\); correct it",
    ),
    (
        LIMIT,
        FIRST,
        "first = ComplexStep(lambda v: np.sqrt(v[:, :1] - 99))",
        "no finite value at the",
    ),
    (LIMIT, FIRST, "first = ComplexStep(lambda v: v.fill(0.0))", "is read-only"),
    (LIMIT, "reads =", "margins = ('nope',)\n    reads =", "no attribute 'nope'"),
    (LIMIT, "least_roll", "quiet", "field 'quiet', which is the name of an option"),
    (LIMIT, "least_roll", "help", "field 'help', which is the name of an option"),
    (
        LIMIT,
        "constraints =",
        "raise SystemExit(0)\nconstraints =",
        "cannot be imported: SystemExit",
    ),
    (LIMIT, "reads =", "change = 0\n    reads =", "change of Roll is 0; it must be above 0"),
    (LIMIT, "reads =", "change = float('nan')\n    reads =", "change of Roll is nan"),
    (LIMIT, "reads =", "change = 'x'\n    reads =", "change of Roll is 'x'"),
    (
        LIMIT,
        "reads =",
        "margins = 'friction'\n    reads =",
        "margins of Roll is 'friction'; give a",
    ),
    (LIMIT, "reads =", "equation = 5\n    reads =", "the equation of Roll is 5; give a text"),
    (LIMIT, '"roll", "rad"', '"", "rad"', "the name of Roll is ''; give a text"),
    (LIMIT, '"roll", "rad"', '"a\\nb", "rad"', "the name of Roll is .*; give a text of one line"),
    (LIMIT, '"roll", "rad"', '"roll", None', "the unit of Roll is None; give a text"),
    (LIMIT, ROWS, f"{ROWS}, instants=np.array([-1])", r"'roll' are \[-1\]; give indices from 0 to"),
    (LIMIT, ROWS, f"{ROWS}, instants=np.array([3, 3])", r"'roll' are \[3, 3\]; give indices"),
    (SUM, '"calm", "rad', '7, "rad', "the name of Calm is 7; give a text"),
    (SUM, '"rad²/(m·s)"', "None", "the unit of Calm is None; give a text"),
    (GROUND, '"plains", True', '"plains", False', "is no plane; write shaped = True"),
    (GROUND, '"plains", True', "7, True", "the name of Plains is 7; give a text"),
    (GROUND, 'return "over plains"', "return 7", "the words of the terrain 'plains' are 7"),
    (SUM, "return SquaredNorm(", "return (", "cost 'calm' has array.* for its function"),
    (
        SUM.replace("import R", "import ComplexStep, R"),
        "SquaredNorm(np",
        "ComplexStep(lambda v: np.sqrt(v[:, :1])) or (np",
        "cost '1 torque . 10 calm' has no finite value at the first guess",
    ),
    (GROUND, "0.01", "float('nan')", "the lift of the terrain 'plains' is nan; give metres"),
    (GROUND, "0.01", "10**400", "the lift of the terrain 'plains' is more than 1e15; give metres"),
    (GROUND, '"over plains"', '"over\\nplains"', "give a text of one line"),
    (
        GROUND,
        "def words",
        "incline = 'x'\n\n    def words",
        "has incline of its own; leave that",
    ),
    (GROUND, "def words", "easier = lambda _: [7]\n\n    def words", "returns no tuple of terr"),
    (GROUND, "def words", "easier = lambda _: 7\n\n    def words", "returns no tuple of terrains"),
    (
        GROUND,
        "def height",
        "outline = lambda *_: 7\n\n    def height",
        r"array\(7\); return points",
    ),
    (GROUND, "def height", "outline = None\n\n    def height", "terrain 'plains': TypeError"),
    (GROUND, "def words", "rise = 'x'\n\n    def words", "the rise of the .* is 'x'; give metres"),
    (GROUND, "return np.zeros(x.shape),", "return 0j * x,", "give an array of real numbers"),
    (GROUND, "return np.zeros(x.shape),", "return 0 * x.T,", "each of its shape"),
    (GROUND, "return Plain()", "return 7", "is 7; give an instance of a Profile"),
    (GROUND, "return Plain()", "1 / 0", r"terrain 'plains': ZeroDivisionError.*\(line \d+ of mine"),
    (GROUND, "0.3", "'far'", "has the length 'far'; give metres"),
    (GROUND, "return np.zeros(x.shape),", "return", "no tuple of the height and two derivatives"),
]


COUPLINGS = [
    ("None", "None cannot be the couplings of Roll; write them as"),
    ("['friction']", r"\['friction'\] cannot be the couplings"),
    ("{'friction': 'load'}", "{'friction': 'load'} cannot be among the couplings"),
    ("{'friction': ('load', float('nan'))}", "cannot be among the couplings"),
    ("{'friction': ('load', 0)}", "cannot be among the couplings"),
    ("{'friction': ('load', 'x')}", "cannot be among the couplings"),
    (
        "{'friction': ('lod', 1.0)}",
        "name the constraint 'lod', which is none; did you mean 'load'. write them as coupl",
    ),
    (
        "{'frition': ('load', 1.0)}",
        "name the margin 'frition', which is none; did you mean 'friction'. write them as coupl",
    ),
    ("{5: ('load', 1.0)}", "name the margin 5, which is none; write them as couplings"),
]


@pytest.mark.parametrize(("couplings", "message"), COUPLINGS)
def test_couplings_that_cannot_be_are_refused_before_any_work(couplings, message, tmp_path, cli):
    path = tmp_path / "mine.py"
    path.write_text(LIMIT.replace("reads =", f"couplings = {couplings}\n    reads ="))
    found = cli("optimise", "--plugin", path, *QUICK, "--no-refine", "--max-iterations", "1")
    assert found.exit_code == 2
    assert re.search(message, found.stderr), found.stderr
    assert 'couplings = {"friction": ("load", 1.0)}' in found.stderr


@pytest.mark.parametrize(("force", "rows"), [("load", "[0]"), ("front load", "None")])
def test_couplings_without_a_force_for_each_row_do_no_harm(force, rows, tmp_path, cli):
    """The walk cannot be, so that what would make one is searched, the friction among it."""
    path = tmp_path / "mine.py"
    text = LIMIT.replace("reads =", f"couplings = {{'friction': ({force!r}, 1.0)}}\n    reads =")
    if rows != "None":
        text = text.replace(ROWS, f"{ROWS}, instants=np.array({rows})")
    path.write_text(text)
    cannot = ("--samples", "9", "--torque-limit", "20", "--friction", "0.3")
    found = cli("optimise", "--plugin", path, *QUICK, *cannot)
    assert found.exit_code == 3, found.stderr
    assert "no feasible gait was found" in found.stderr


@pytest.mark.parametrize(("text", "sound", "broken", "message"), BROKEN)
def test_a_broken_plugin_is_told_without_a_traceback(text, sound, broken, message, tmp_path, cli):
    path = tmp_path / "mine.py"
    path.write_text(text.replace(sound, broken))
    found = cli("optimise", "--plugin", path, *QUICK, "--no-refine", "--output", tmp_path / "out")
    assert found.exit_code == 2, found.output
    assert re.search(message, found.stderr), found.stderr
    assert not (tmp_path / "out" / "gait.npz").exists()


@pytest.mark.parametrize("text", [LIMIT, GROUND])
def test_what_was_broken_there_walks_when_it_is_sound(text, tmp_path, cli):
    path = tmp_path / "mine.py"
    path.write_text(text)
    assert cli("optimise", "--plugin", path, *QUICK, "--no-refine").exit_code == 0


def test_a_cost_of_ones_own_may_have_the_name_of_a_built_in_one(tmp_path, cli):
    plugin, out = tmp_path / "mine.py", tmp_path / "out"
    sole = SUM.partition("cost = Weighted")[0] + "cost = Calm()"
    plugin.write_text(sole.replace('"calm"', '"torque"'))
    assert cli("optimise", "--plugin", plugin, *QUICK, "--output", out).exit_code == 0
    without = cli("check", out / "gait.npz")
    assert "has the cost 'torque', which is not gaitopt's own" in without.stderr
    assert cli("check", out / "gait.npz", "--plugin", plugin).exit_code == 0


def test_a_library_is_swept_and_read_with_its_plugin(tmp_path, cli):
    """Workers import the plugin themselves; what lies between the gaits needs it again."""
    own = ("--plugin", SWING_HEIGHT, "--low-swing", "0.05")
    where = tmp_path / "library"
    many = ("--speeds", "0.98,1.0", "--workers", "1", "--no-refine", "--quiet")
    assert cli("sweep", *many, *own, "--output", where).exit_code == 0
    unknown = cli("sweep", "--grid", "own.high_swing=0.05,0.06", *own[:2], "--output", where)
    assert unknown.exit_code == 2
    assert "there is no margin 'high_swing'" in unknown.stderr
    between = ("library", where, "--at", "speed=0.99")
    without = cli(*between)
    assert without.exit_code == 2
    assert "give that file: --plugin swing_height.py" in without.stderr
    found = cli(*between, "--plugin", SWING_HEIGHT)
    assert found.exit_code in (0, 1), found.stderr  # designed, certified or not
    assert "between speed" in found.stdout
