"""docs/arms-on-stairs.md: its commands run as they stand, and lead where it says."""

import json
import re
import shlex

import numpy as np
import pytest
from places import ROOT
from typer.testing import CliRunner

from gaitopt import load_gait
from gaitopt.cli.app import app

TEXT = (ROOT / "docs" / "arms-on-stairs.md").read_text("utf-8")
COMMANDS = re.findall(r"```bash\ngaitopt (.*)\n```", TEXT)


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """The folder in which all commands were run, one after the other, and what they said."""
    folder, told = tmp_path_factory.mktemp("stairs"), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in COMMANDS:
            words = shlex.split(command)
            run = CliRunner().invoke(app, words, catch_exceptions=False)
            assert run.exit_code == 0, (command, run.stderr)
            told[words[0]] = run.stdout
    return folder, told


def test_it_goes_from_the_file_to_the_motion():
    known = [command.split()[0] for command in COMMANDS]
    assert known == ["inspect", "optimise", "check", "requirements", "export"]


def test_the_walk_is_certified_with_arms_stairs_and_load(said):
    folder, told = said
    assert "certified" in told["check"]
    gait = load_gait(folder / "up" / "gait.npz")
    assert gait.fact("certificate", "certified") is True
    assert gait.number("task", "stairs") == 0.17
    pictured = json.loads((ROOT / "docs" / "images" / "stairs.json").read_text())
    assert pictured["cost_N2ms"] == pytest.approx(gait.cost, rel=1e-5)
    assert sum("shoulder_pitch" in name for name in gait.joint_names) == 2
    bare = 33.34  # kg, docs/robots.md
    assert gait.number("mass") == pytest.approx(bare + 5.0, abs=0.01)
    assert "shoulder pitch" in told["requirements"]
    assert (folder / "needs.csv").read_text("utf-8").count("\n") > 7


def test_the_python_of_the_page_shows_the_rise(said, capsys, monkeypatch):
    monkeypatch.chdir(said[0])
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.S)
    exec(compile(code, "page", "exec"), {})
    shape, rise = re.fullmatch(r"\((\d+, \d+)\) ([\d.]+)\n", capsys.readouterr().out).groups()
    assert shape == "1400, 29"
    assert float(rise) == pytest.approx(40 * 0.17, abs=0.05)
    with np.load("climb.npz") as motion:
        assert motion["foot_contact"].shape == (1400, 2)
