"""What docs/extending.md shows is run as it stands there."""

import re
import shlex
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.cli.request import make_request
from gaitopt.gait.plugin import load_plugin

TEXT = (Path(__file__).parents[1] / "docs" / "extending.md").read_text()
BLOCKS = re.findall(r"```(python|console|toml)\n(.*?)```", TEXT, re.S)
QUICK = ("--starts", "1", "--no-page", "--no-figures", "--quiet")


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
    assert [kind for kind, _ in BLOCKS] == [
        "python", "python", "console", "toml", "python", "python", "toml",
    ]  # fmt: skip


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
    verdict, passed, rows = capsys.readouterr().out.splitlines()
    assert (verdict, passed) == ("certified", "True")
    assert rows.startswith("slice(")


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
    assert make_request({}, Path("steady.toml")).task.margin("ankle_roll") == pytest.approx(
        0.0873, 1e-3
    )
    Path("weighed.toml").write_text(weighed)
    assert make_request({}, Path("weighed.toml")).task.cost.weights["*_knee"] == 2.0


def test_plugins(folder):
    calm = make_request({"plugin": folder / "calm.py"}, None)
    assert calm.task.cost == load_plugin(folder / "calm.py").cost
    assert calm.task.cost.unit == "rad²/(m·s)"
    back = make_request({"plugin": folder / "calm.py", "cost": "torque"}, None)
    assert back.task.cost.unit == "N²·m·s"
