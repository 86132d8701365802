"""The benchmarks do not rot: they can be imported, and the smallest of them runs."""

import importlib
import json
import runpy
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "benchmarks"
MODULES = sorted(path.stem for path in FOLDER.glob("*.py"))


@pytest.fixture(autouse=True)
def _benchmarks_on_path(monkeypatch):
    known = set(sys.modules)
    monkeypatch.syspath_prepend(str(FOLDER))
    yield
    for name in set(sys.modules) - known:
        if name in MODULES:  # their names are too common to stay
            del sys.modules[name]


@pytest.mark.parametrize("name", MODULES)
def test_imports_and_says_what_it_is(name):
    assert importlib.import_module(name).__doc__


def test_evaluation_runs(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["evaluation.py", "--quick"])
    runpy.run_path(str(FOLDER / "evaluation.py"), run_name="__main__")
    lines = json.loads(capsys.readouterr().out)["data"]
    assert [line["samples"] for line in lines] == [11, 31]
    assert all(time["min"] > 0.0 for line in lines for time in line["seconds"].values())


def test_random_bipeds_differ_and_repeat(monkeypatch):
    random_case = importlib.import_module("random_bipeds").random_case
    assert random_case(3) == random_case(3)
    assert random_case(3)[0] != random_case(4)[0]


def test_report_follows_from_the_results():
    report = importlib.import_module("report")
    assert report.TARGET.read_text(encoding="utf-8") == report.text()
