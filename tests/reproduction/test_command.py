"""`python -m reproduction`, and the command of the package that leads to it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT
from typer.testing import CliRunner

import gaitopt
from gaitopt.cli.app import app
from gaitopt.importers.text_files import parse_toml
from reproduction.__main__ import main
from reproduction.figures import REPRODUCTION_FIGURES
from reproduction.page import PARTS


def test_a_directory_that_cannot_be_made_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert main(["--output", str(tmp_path / "file" / "docs")]) == 2
    assert "is a file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "table3,fig2"], "there is no part 'fig2'; parts are table3, fig3"),
        (["--only", ","], "no part is given"),
        (["--output", ""], "the name is empty"),
    ],
)
def test_what_cannot_be_used_is_refused(arguments, said, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_every_figure_belongs_to_a_part():
    figures = [figure for part in PARTS.values() for figure in part.figures]
    assert sorted(figures) == sorted(REPRODUCTION_FIGURES)
    assert all(part.figures or part.tables for part in PARTS.values())


def test_chosen_parts_are_printed_and_drawn(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("reproduction.__main__.part_text", lambda result, name: f"<{name}>")
    monkeypatch.setattr(
        "reproduction.__main__.write_figures",
        lambda result, directory, names: [directory / f"{name}.png" for name in names],
    )
    assert main(["--only", "fig7, table3,fig7", "--output", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert out.split() == ["<fig7>", "<table3>", "wrote", str(tmp_path / "cost.png")]


def test_ctrl_c_has_its_exit_code(monkeypatch, tmp_path, capsys):
    def stopped(result, name):
        raise KeyboardInterrupt

    monkeypatch.setattr("reproduction.__main__.part_text", stopped)
    assert main(["--only", "fig7", "--output", str(tmp_path)]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_the_wheel_does_not_hold_it():
    project = parse_toml((ROOT / "pyproject.toml").read_text("utf-8"), "pyproject.toml")
    assert project["tool"]["setuptools"]["packages"]["find"]["include"] == ["gaitopt*"]


def test_the_module_runs():
    done = subprocess.run(
        [sys.executable, "-m", "reproduction", "--help"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0
    assert all(name in done.stdout for name in PARTS)


def test_the_command_of_the_package_runs_it(tmp_path):
    (tmp_path / "file").write_text("")
    done = CliRunner().invoke(
        app, ["reproduce", "--only", "table3", "--output", str(tmp_path / "file" / "docs")]
    )
    assert done.exit_code == 2


def test_the_command_of_the_package_says_where_it_is_if_it_is_not_there(tmp_path):
    shutil.copytree(Path(gaitopt.__file__).parent, tmp_path / "gaitopt")
    done = subprocess.run(
        [sys.executable, "-c", "from gaitopt.cli.app import run; run()", "reproduce", "-o", "x"],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "get the sources of gaitopt and run `python -m reproduction`" in done.stderr
