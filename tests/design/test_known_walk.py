"""A gait as a start: an optimum is gone on from at its own instants, any other lends parameters."""

from dataclasses import replace

import numpy as np
import pytest

from gaitopt.design import diagnosis as diagnosing
from gaitopt.design.design import compare_solvers, design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.phase_times import best_times
from gaitopt.design.pipeline import gone_on
from gaitopt.errors import InputError
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers import solver_by_name

DIRECT = DesignOptions(solver=solver_by_name("sqp"))


def recorded(gait, **meta):
    return replace(gait, meta={**gait.meta, **meta})


def test_an_optimum_is_left_as_it_is(robot, refined_design):
    """Between the samples its limits are active, so at the samples alone it is no optimum."""
    gait, task = refined_design.gait, refined_design.problem.task
    again = design(robot, task, DIRECT, start=gait)
    assert again.solution.iterations <= 1
    assert again.certificate.certified
    np.testing.assert_array_equal(again.problem.grid.instants, refined_design.problem.grid.instants)
    np.testing.assert_allclose(again.gait.parameters, gait.parameters, rtol=0.0, atol=1e-9)
    sampled = design(robot, task, replace(DIRECT, refine=False), start=gait.parameters)
    assert sampled.solution.iterations > 1
    assert sampled.gait.cost < gait.cost * (1.0 - 1e-6)


def test_a_relaxed_beginning_is_not_made_from_an_optimum(robot, refined_design):
    gait, task = refined_design.gait, refined_design.problem.task
    again = design(robot, task, replace(DIRECT, approach="relaxed"), start=gait)
    assert again.solution.iterations <= 1


@pytest.mark.parametrize("change", [{"speed": 1.01}, {"samples": 21}, {"torque_limit": 60.0}])
def test_of_another_walk_only_the_parameters_count(robot, refined_design, change):
    problem = WalkProblem(robot, preset_task(**{"speed": 1.0, **change}))
    same, multipliers = gone_on(problem, refined_design.gait)
    assert same is problem
    assert multipliers is None


def test_the_parameters_of_a_gait_start_other_searches_too(robot, refined_design):
    gait, task = refined_design.gait, refined_design.problem.task
    solvers = [solver_by_name("sqp", max_iterations=1)]
    (run,) = compare_solvers(robot, task, solvers, start=gait)
    (same,) = compare_solvers(robot, task, solvers, start=gait.parameters)
    assert run.cost == same.cost
    starts = []

    def designed(task, start, options):
        starts.append(start)
        raise InputError("enough")

    with pytest.raises(InputError, match="enough"):
        best_times(robot, replace(task, toe_off=0.9), DIRECT, designed, gait, lambda: True)
    for start in starts:
        np.testing.assert_array_equal(start[: gait.parameters.size], gait.parameters)


@pytest.mark.parametrize("instants", [["early"], [0.5, 1.5], [[0.5]], 3.0, [float("-1e9")]])
def test_instants_that_are_none_are_refused(robot, refined_design, instants):
    problem = WalkProblem(robot, refined_design.problem.task)
    with pytest.raises(InputError, match="the gait's 'instants' are not numbers"):
        gone_on(problem, recorded(refined_design.gait, instants=instants))


def test_what_is_suggested_was_gone_on_from(robot, refined_design, monkeypatch):
    """The way to a walk may depend on rounding; what starts from the walk itself must not."""
    task, x = refined_design.problem.task, refined_design.gait.parameters
    asked = []

    def proven(problem, x, search, multipliers=None):
        asked.append((problem, x, multipliers))
        return refined_design

    monkeypatch.setattr(diagnosing, "_proven", proven)
    assert diagnosing.followed(robot, task, x + 0.01, Search(DIRECT)) is refined_design
    (first, _, none), (second, at, multipliers) = asked
    assert none is None
    assert first.grid.count == task.samples
    np.testing.assert_array_equal(second.grid.instants, refined_design.problem.grid.instants)
    np.testing.assert_array_equal(at, x)
    np.testing.assert_array_equal(multipliers, refined_design.gait.multipliers)

    answers = iter([refined_design, None])
    monkeypatch.setattr(diagnosing, "_proven", lambda *_, **__: next(answers))
    assert diagnosing.followed(robot, task, x, Search(DIRECT)) is None
