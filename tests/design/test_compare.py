import json

import numpy as np
import pytest

from gaitopt.design.design import compare_solvers, run_record
from gaitopt.errors import InputError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Status
from gaitopt.solvers import solver_by_name

TASK = preset_task(samples=15)


@pytest.fixture(scope="module")
def runs(robot):
    return compare_solvers(robot, TASK, ["sqp", solver_by_name("slsqp", max_iterations=60)])


def test_every_solver_begins_at_the_same_point_and_is_judged_alike(robot, runs):
    problem = WalkProblem(robot, TASK)
    at_start = problem.values(first_guess(problem))
    assert [run.solver for run in runs] == ["sqp", "slsqp"]
    for run in runs:
        assert run.history[0].cost == pytest.approx(at_start.cost, rel=1e-12)
        assert {record.solver for record in run.history} == {run.solver}
        assert run.cost == pytest.approx(problem.values(run.x).cost, rel=1e-12)
    assert runs[0].status is Status.OPTIMAL
    assert runs[0].optimality < 1e-6 < runs[1].optimality  # the second was not given the time
    assert runs[0].history[-1].optimality < 1e-6


def test_a_comparison_can_be_read_by_machines(runs):
    first, record = json.loads(json.dumps([*map(run_record, runs)], allow_nan=False))
    assert first["solver"] == "sqp"
    assert record["solver"] == "slsqp"
    assert record["history"][0]["radius"] is None  # it has none
    assert len(record["history"]) == len(runs[1].history)


def test_a_comparison_can_be_stopped(robot):
    (run,) = compare_solvers(robot, TASK, ["sqp", "slsqp"], stop=lambda: True)
    assert run.status is Status.INTERRUPTED


def test_what_cannot_be_compared_is_refused(robot):
    with pytest.raises(InputError, match="no solver is named"):
        compare_solvers(robot, TASK, [])
    with pytest.raises(InputError, match="there is no solver 'snopt'"):
        compare_solvers(robot, TASK, ["snopt"])
    with pytest.raises(InputError, match="the first guess has shape"):
        compare_solvers(robot, TASK, ["sqp"], start=np.zeros(3))
