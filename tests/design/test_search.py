from dataclasses import replace

import numpy as np
import pytest
from liftoff_limits import watched_liftoff_limits

from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import RELAXED_LIFTOFF, attempt
from gaitopt.errors import InputError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Status, worst_violation
from gaitopt.solvers.sqp import SQP

QUICK = DesignOptions(refine=False, diagnose=False)


@pytest.fixture(scope="module")
def problem(robot):
    return WalkProblem(robot, preset_task(samples=15, speed=0.8))


def walked(problem, approach):
    options = replace(QUICK, approach=approach)
    return attempt(problem, Search(options), first_guess(problem))


def test_both_approaches_end_with_the_exact_lift_off(problem):
    """Not at the same walk: the problem has several optima."""
    direct, relaxed = walked(problem, "direct"), walked(problem, "relaxed")
    assert direct.status is relaxed.status is Status.OPTIMAL
    assert max(direct.violation, relaxed.violation) < 1e-8
    rows = problem.rows_of("lift-off")
    assert problem.values(relaxed.x).rows[rows].min() > -1e-8 > RELAXED_LIFTOFF


def test_the_work_of_both_stages_counts(problem):
    direct, relaxed = walked(problem, "direct"), walked(problem, "relaxed")
    assert relaxed.evaluations > direct.evaluations / 2
    assert len(relaxed.history) >= relaxed.iterations


@pytest.mark.parametrize(("boundary", "stages"), [("closed", 1), ("lifted", 2)])
def test_automatic_is_relaxed_for_the_lifted_form_only(robot, boundary, stages, monkeypatch):
    limits = watched_liftoff_limits(monkeypatch, SQP)
    task = preset_task(samples=15, speed=0.8, boundary=boundary)
    walked(WalkProblem(robot, task), "automatic")
    assert limits == [RELAXED_LIFTOFF, 0.0][-stages:]


@pytest.mark.parametrize(("least", "stages"), [(1.0, 1), (0.5, 2)])
def test_limits_that_contradict_each_other_with_slack_are_not_tried_without_it(
    robot, least, stages, monkeypatch
):
    """A point of least violation is one of the walk without slack, if that violates no more."""
    lifted = WalkProblem(robot, preset_task(samples=15, speed=0.8, boundary="lifted"))
    asked = []

    def failed(self, nlp, start, *_):
        asked.append(nlp)
        nothing = np.zeros(nlp.rows.lower.size), np.zeros(start.x.size)
        worst = least * worst_violation(nlp, nlp.values(start.x))[0]
        return Solution(
            start.x, 1.0, *nothing, Status.INFEASIBLE, worst, 1.0, 3, 4, 2, 0.5, self.name
        )

    monkeypatch.setattr(SQP, "solve", failed)
    solution = walked(lifted, "automatic")
    assert solution.status is Status.INFEASIBLE
    assert len(asked) == stages
    assert solution.hessians == 2 * stages


def test_a_lift_off_that_is_already_relaxed_is_approached_directly(robot):
    easy = WalkProblem(robot, preset_task(samples=15, speed=0.8, liftoff_speed=-0.05))
    assert walked(easy, "relaxed").cost == walked(easy, "direct").cost


def test_unknown_approaches_are_refused():
    with pytest.raises(InputError, match="approach 'sideways' is unknown; choose automatic"):
        DesignOptions(approach="sideways")
