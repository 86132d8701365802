"""What docs/extending.md shows is run as it stands there."""

import math
import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from places import DOCS
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.cli.request import make_request
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import ground_of
from gaitopt.model.sole import Sole
from gaitopt.view.figures import step_figure

TEXT = (DOCS / "extending.md").read_text()
BLOCKS = re.findall(r"```(python|console|toml)\n(.*?)```", TEXT, re.S)
QUICK = ("--starts", "1", "--no-figures", "--quiet")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A directory with the files that the text shows."""
    directory = tmp_path_factory.mktemp("extending")
    for kind, text in BLOCKS:
        named = re.match(r"# (\w+\.py)\n", text)
        if kind == "python" and named:
            (directory / named[1]).write_text(text)
    return directory


def test_the_text_shows_what_it_says():
    kinds = "python python console toml python python toml python python python"
    assert [kind for kind, _ in BLOCKS] == kinds.split()


def test_python(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    own = {path.stem for path in folder.glob("*.py")}
    try:
        for kind, text in BLOCKS:
            if kind == "python" and not re.match(r"# \w+\.py\n", text):
                exec(compile(text, "extending.md", "exec"), {"__name__": "shown"})
    finally:
        for name in own:
            sys.modules.pop(name, None)
    verdict, passed, rows, turned = capsys.readouterr().out.splitlines()
    assert (verdict, passed) == ("certified", "True")
    assert rows.startswith("slice(")
    assert turned == "certified ball line"


def test_commands(folder, monkeypatch):
    monkeypatch.chdir(folder)
    (text,) = (text for kind, text in BLOCKS if kind == "console")
    for line in text.splitlines():
        program, *words = shlex.split(line.removeprefix("$ "))
        assert program == "gaitopt"
        found = CliRunner().invoke(app, [*words, *(QUICK if words[0] == "optimise" else ())])
        assert found.exit_code == 0, found.output


def test_configurations(folder, monkeypatch):
    monkeypatch.chdir(folder)
    steady, weighed = (text for kind, text in BLOCKS if kind == "toml")
    Path("steady.toml").write_text(steady)
    rolled = make_request({}, Path("steady.toml")).task.margin("ankle_roll")
    assert rolled == pytest.approx(math.radians(2.0))
    Path("weighed.toml").write_text(weighed)
    assert make_request({}, Path("weighed.toml")).task.cost.weights["*_knee"] == 2.0


def test_plugins(folder):
    calm = make_request({"plugin": folder / "calm.py"}, None)
    assert calm.task.cost == load_plugin(folder / "calm.py").cost
    assert calm.task.cost.unit == "rad²/(m·s)"
    back = make_request({"plugin": folder / "calm.py", "cost": "torque"}, None)
    assert back.task.cost.unit == "N²·m·s"


def test_a_ground(folder, tmp_path):
    """Hurdles that the usual clearance does not pass, from the command line, checked and drawn."""
    file = folder / "hurdles.py"
    asked = ("--plugin", str(file), "--hurdle", "8cm", "--speed", "0.6", "--duration", "0.6")
    made = CliRunner().invoke(app, ["optimise", *asked, *QUICK, "--output", str(tmp_path)])
    assert made.exit_code == 0, made.output
    gait = load_gait(tmp_path / "gait.npz")
    assert gait.fact("certificate", "certified") is True
    assert make_request({}, tmp_path / "task.toml").task.ground.hurdle == 0.08

    without = CliRunner().invoke(app, ["check", str(tmp_path / "gait.npz")])
    assert without.exit_code == 2
    assert "the terrain 'hurdles', which is not gaitopt's own" in without.stderr
    given = CliRunner().invoke(app, ["check", str(tmp_path / "gait.npz"), "--plugin", str(file)])
    assert given.exit_code == 0, given.output
    assert "at 0.6 m/s over hurdles of 80 mm" in " ".join(given.stdout.split())
    assert "terrain 'hurdles' of the plugin hurdles.py, hurdle 0.08" in given.stdout

    ground = ground_of(gait)  # of the file alone
    assert ground.outline[:, 1].max() == pytest.approx(0.08, rel=5e-3)
    samples = gait.trajectory.at(np.linspace(0.01, 0.99, 99) * gait.duration)
    corners = load_plugin(file).terrain.profile(make_sole(gait), gait.step_length, None)
    points = samples.sole[:, 1, :3, :3] @ make_sole(gait).corners.T + samples.sole[:, 1, :3, 3:]
    above = points[:, 2] - corners.height(points[:, 0])[0] * 0.08 / 0.06
    assert above.min() > -1e-6
    assert points[:, 2].max() > 0.08
    side = step_figure(gait).axes[0]
    drawn = side.collections[0].get_paths()[0].vertices
    assert drawn[:, 1].max() == pytest.approx(0.08, rel=5e-3)


def test_a_ground_with_a_wrong_derivative_is_refused(folder, robot):
    hurdles = load_plugin(folder / "hurdles.py").terrain

    class Wrong(type(hurdles.profile(robot.sole, 0.36, None))):
        def height(self, x):
            value, first, second = super().height(x)
            return value, 1.01 * first, second

    class Broken(type(hurdles)):
        def profile(self, sole, step, nosing):
            return Wrong(**vars(super().profile(sole, step, nosing)))

    task = preset_task(speed=0.6, duration=0.6, terrain=Broken())
    with pytest.raises(InputError, match="the terrain 'hurdles' has a first derivative that"):
        WalkProblem(robot, task)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"toe_off": 0.7}, "on hurdles the foot stands flat; give toe_off or hurdles, not both"),
        ({"slope": 0.1}, "a walk has one ground"),
        ({"speed_as": "penalty"}, "on hurdles the ground repeats with the steps"),
        ({"terrain": "hurdles"}, "terrain is 'hurdles'; give one, as"),
    ],
)
def test_what_a_ground_does_not_go_with_is_told(folder, changes, reason):
    hurdles = load_plugin(folder / "hurdles.py").terrain
    with pytest.raises(InputError, match=reason):
        preset_task(**{"terrain": hurdles, **changes})


def make_sole(gait):
    return Sole(**gait.fact("sole"))
