"""Why there is no gait is printed line by line under the error."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
import typer

from gaitopt.cli.process import errors_reported
from gaitopt.errors import NoGaitFoundError


def test_a_diagnosis_is_printed_under_the_error(capsys: pytest.CaptureFixture[str]) -> None:
    diagnosis = SimpleNamespace(sentences=("the knees are weak", "20 N·m more would do"))
    with pytest.raises(typer.Exit) as left, errors_reported():
        raise NoGaitFoundError("no gait", None, diagnosis)
    assert left.value.exit_code == 3
    assert capsys.readouterr().err.splitlines() == [
        "error: no gait",
        "- the knees are weak",
        "- 20 N·m more would do",
    ]


def test_without_a_diagnosis_the_error_stands_alone(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit), errors_reported():
        raise NoGaitFoundError("no gait")
    assert capsys.readouterr().err == "error: no gait\n"
