"""`gaitopt optimise --starts`: several first guesses, one report, the best walk."""

from __future__ import annotations

import json
from pathlib import Path

from typer.testing import CliRunner

from gaitopt.cli.app import app

QUICK = ["--no-refine", "--no-figures", "--no-page", "--solver", "sqp"]


def test_several_starts_report_their_optima(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["optimise", "--starts", "2", "--output", str(tmp_path), *QUICK]
    )
    assert result.exit_code == 0
    assert "2 of 2 starts led to a walk" in result.output
    assert "optimum 1 of cost 3346.3" in result.output
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert "3346.31" in json.dumps(summary)


def test_no_start_is_none() -> None:
    result = CliRunner().invoke(app, ["optimise", "--starts", "0"])
    assert result.exit_code == 2
    assert "0 starts are too few" in result.output
