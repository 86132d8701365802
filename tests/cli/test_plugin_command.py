"""Constraints and costs of one's own on the command line and in configuration files."""

import json
import pickle
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
QUICK = ("--starts", "1", "--no-page", "--no-figures", "--quiet")


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
