"""The benchmarks do not rot: they can be imported, and the smallest of them runs."""

import importlib
import json
import runpy
import sys

import numpy as np
import pytest
from places import ROOT

FOLDER = ROOT / "benchmarks"
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


def test_the_papers_evaluation_is_the_same_program():
    common, paper = (importlib.import_module(name) for name in ("common", "paper_evaluation"))
    problem = common.walk(samples=11)
    slow = paper.PaperProblem(problem)
    for seed, sigma in enumerate((0.0, 0.1, 0.3)):
        x = common.start(problem, sigma, seed)
        ours, theirs = problem.values(x), slow.values(x)
        assert theirs.cost == pytest.approx(ours.cost, rel=1e-11)
        np.testing.assert_allclose(theirs.rows, ours.rows, rtol=1e-11, atol=1e-11)


def test_random_bipeds_differ_and_repeat(monkeypatch):
    random_case = importlib.import_module("random_bipeds").random_case
    assert random_case(3) == random_case(3)
    assert random_case(3)[0] != random_case(4)[0]


def test_report_follows_from_the_results():
    report = importlib.import_module("report")
    assert report.TARGET.read_text(encoding="utf-8") == report.text()


def test_insights_follow_from_the_results():
    insights = importlib.import_module("insights")
    rows = json.loads((insights.RESULTS / "insights.json").read_text(encoding="utf-8"))["data"]
    assert insights.PAGE.read_text(encoding="utf-8") == insights.text(rows)
    assert set(insights.VARIANTS) == {one.name for one in insights.QUESTIONS}
    told = {(row["robot"], row["question"], row["variant"]) for row in rows}
    for robot in insights.ROBOTS:
        for name, variants in insights.VARIANTS.items():
            assert {(robot, name, label) for label in variants} <= told
