"""`gaitopt optimise --starts`: several first guesses, one report, the best walk."""

from __future__ import annotations

import inspect
import json
import os
import signal
from pathlib import Path

from places import DOCS
from typer.testing import CliRunner

from gaitopt.cli import optimise as optimise_command
from gaitopt.cli.app import app
from gaitopt.cli.config import SCHEMA
from gaitopt.cli.request import make_request
from gaitopt.design.starts import many_starts
from gaitopt.gait.gait_file import load_gait

QUICK = ["--no-refine", "--no-figures", "--no-page", "--solver", "sqp"]


def test_several_starts_report_their_optima(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["optimise", "--starts", "2", "--output", str(tmp_path), *QUICK]
    )
    assert result.exit_code == 0
    assert "2 of 2 starts led to a walk" in result.output
    assert "optimum 1 of cost 3239.0" in result.output
    assert "optimum 2 of cost 3351.2" in result.output
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert "3239.0" in json.dumps(summary)


def test_the_noise_is_that_of_many_starts() -> None:
    usual = inspect.signature(many_starts).parameters["sigma"].default
    request = make_request({"robot": "biped13", "starts": 3}, None)
    assert request.noise == (usual, 0)
    assert SCHEMA["solver"]["sigma"].default == usual
    said = (DOCS / "cli.md").read_text(encoding="utf-8")
    assert f"of standard deviation {usual:g} rad" in said


def test_ctrl_c_writes_the_best_start_so_far(tmp_path: Path, monkeypatch) -> None:
    search = optimise_command.many_starts

    def interrupted(*args, **options):
        def press(_) -> None:
            os.kill(os.getpid(), signal.SIGINT)

        return search(*args, **{**options, "workers": 1, "on_outcome": press})

    monkeypatch.setattr(optimise_command, "many_starts", interrupted)
    result = CliRunner().invoke(
        app, ["optimise", "--starts", "9", "--output", str(tmp_path), *QUICK]
    )
    assert result.exit_code == 130
    assert "1 of 1 starts led to a walk; 9 were asked for" in result.output
    assert "interrupted: this is the best gait so far" in result.output
    assert load_gait(tmp_path / "gait.npz").cost > 3000.0


def test_no_start_is_none() -> None:
    result = CliRunner().invoke(app, ["optimise", "--starts", "0"])
    assert result.exit_code == 2
    assert "0 starts are too few" in result.output
