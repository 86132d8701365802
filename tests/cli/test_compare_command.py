"""`gaitopt compare`: several solvers on one walk."""

from __future__ import annotations

import json
import os
import signal

import numpy as np
import pytest

from gaitopt.cli import compare as command
from gaitopt.cli.config import SCHEMA
from gaitopt.nlp import Solution, Status
from gaitopt.solvers import SOLVERS

COARSE = ("--samples", "9", "--postures", "1")


def test_a_table_a_record_and_a_figure(cli, tmp_path):
    result = cli("compare", "--solvers", "sqp,slsqp", *COARSE, "-o", tmp_path / "compared")
    assert result.exit_code == 0, result.stderr
    rows = {line.split()[0]: line.split() for line in result.stdout.splitlines() if line.strip()}
    record = json.loads((tmp_path / "compared" / "comparison.json").read_text())
    runs = {one["solver"]: one for one in record["solvers"]}
    assert set(runs) == {"sqp", "slsqp"} <= set(rows)
    for name, one in runs.items():
        assert rows[name][1:3] == [one["status"], f"{one['cost']:.6g}"]
        assert len(one["history"]) > one["iterations"] > 3
    assert 1000.0 < runs["sqp"]["cost"] <= runs["slsqp"]["cost"] * (1.0 + 1e-6)
    assert runs["sqp"]["optimality"] <= 1e-6
    assert runs["sqp"]["history"][-1]["optimality"] <= 1e-6
    assert (tmp_path / "compared" / "convergence.png").read_bytes().startswith(b"\x89PNG")
    assert max(map(len, result.stdout.splitlines()[:-1])) <= 80
    assert "round 2 (slsqp)" in result.stderr


def test_options_go_to_the_solvers_that_have_them(cli):
    result = cli("compare", "--solvers", "sqp,slsqp", *COARSE, "--max-iterations", "2", "-q")
    assert (result.exit_code, result.stdout) == (3, "")  # no walk in two iterations
    made = command._solver("sqp", {"qp_solver": "quadprog", "tolerance": 1e-7})
    assert (made.qp_solver, made.tolerance) == ("quadprog", 1e-7)
    assert command._solver("slsqp", {"qp_solver": "quadprog"}).name == "slsqp"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--solvers", "sqp,sqp"), "give each solver once, as in --solvers sqp,slsqp,ipopt"),
        (("--solvers", ","), "give each solver once"),
        (("--solvers", "sqp,magic"), "no solver 'magic'; choose one of default"),
        (("--solver", "sqp"), "No such option"),
        (("--tolerance", "-1"), "tolerance is -1"),
    ],
)
def test_what_cannot_be_compared_is_refused(cli, tmp_path, words, said):
    result = cli("compare", *words, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert said in result.stderr
    assert not (tmp_path / "out").exists()


def test_ctrl_c_shows_what_was_done(cli, monkeypatch):
    compare = command.compare_solvers

    def interrupted(*args, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return compare(*args, **options)

    monkeypatch.setattr(command, "compare_solvers", interrupted)
    result = cli("compare", "--solvers", "sqp,slsqp", *COARSE)
    assert result.exit_code == 130
    assert "interrupted: 1 of 2 solvers were tried" in result.stderr


def test_a_solver_that_failed_has_no_numbers():
    none = np.zeros(1)
    failed = Solution(
        none, np.nan, none, none, Status.NUMERICAL, np.nan, np.nan, 0, 1, 0, 0.1, "slsqp"
    )
    table = command.table_of_solvers([failed], "N²·m·s")
    assert [next(iter(column.cells)) for column in table.columns[3:5]] == ["-", "-"]


def test_the_names_of_all_solvers_are_allowed():
    assert SCHEMA["solver"]["solver"].names == tuple(SOLVERS)
