import json
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.errors import NoGaitFoundError, UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Status
from gaitopt.solvers import Solver, solver_by_name

SAMPLED = DesignOptions(solver=solver_by_name("sqp"), refine=False)
UNEXPLAINED = replace(SAMPLED, diagnose=False)  # for messages, which no diagnosis changes
UNEXPLAINED_BETWEEN = DesignOptions(diagnose=False)  # which holds between the samples too


def test_the_cost_at_1_metre_per_second(sampled_design):
    assert sampled_design.solution.status is Status.OPTIMAL
    assert sampled_design.gait.meta["cost"] == pytest.approx(3346.4, rel=5e-3)
    assert sampled_design.problem.grid.count == 31
    assert sampled_design.gait.meta["refined"] is False


def test_the_gait_walks_as_asked(refined_design):
    gait = refined_design.gait
    assert gait.duration == pytest.approx(0.4)
    assert gait.step_length == pytest.approx(0.4, abs=1e-8)
    assert gait.speed == pytest.approx(1.0, abs=1e-7)
    assert np.abs(gait.torque).max() <= 150.0 * (1.0 + 1e-6)
    assert np.abs(gait.dq).max() <= 10.0 * (1.0 + 1e-6)
    assert gait.ground_wrench[:, 2].min() >= 25.0
    assert gait.impulse[2] > 1.0


def test_refinement_costs_little_and_certifies(sampled_design, refined_design):
    assert refined_design.certificate.certified
    assert refined_design.problem.grid.count > 31
    excess = refined_design.solution.cost / sampled_design.solution.cost - 1.0
    assert 0.0 < excess < 0.01


@pytest.mark.parametrize(
    "changes",
    [
        {"speed": 0.6, "double_support": 0.08, "touch_down": "impact"},
        {"speed": 1.0, "double_support": 0.08, "touch_down": "impact"},
        {"speed": 0.7, "toe_off": 0.8, "heel_strike": 0.15},
    ],
)
def test_a_search_that_may_end_early_comes_to_the_walk_of_one_that_does_not(
    robot, changes, monkeypatch
):
    task = preset_task("standard", robot, **changes)
    found = design(robot, task, UNEXPLAINED_BETWEEN)
    monkeypatch.setattr("gaitopt.design.design.quadratic", lambda _: None)
    thorough = design(robot, task, UNEXPLAINED_BETWEEN)
    assert thorough.certificate.certified
    assert found.certificate.certified
    assert found.solution.cost == pytest.approx(thorough.solution.cost, rel=1e-6)


def test_the_work_of_all_rounds_is_counted(sampled_design, refined_design):
    assert refined_design.solution.iterations > sampled_design.solution.iterations
    assert refined_design.solution.evaluations > sampled_design.solution.evaluations


def test_the_gait_records_how_it_was_found(refined_design):
    meta = refined_design.gait.meta
    assert meta["refined"] is True
    assert meta["solver"]["name"] == "sqp"
    assert meta["solver"]["iterations"] == refined_design.solution.iterations
    assert meta["status"] == Status.OPTIMAL.value
    assert meta["certificate"]["verdict"] == "certified"
    assert set(meta["versions"]) >= {"gaitopt", "pinocchio", "numpy", "python"}
    json.dumps(dict(meta), allow_nan=False)


def test_the_same_question_has_the_same_bits_as_answer(robot, standard_task, sampled_design):
    again = design(robot, standard_task, SAMPLED)
    np.testing.assert_array_equal(again.solution.x, sampled_design.solution.x)
    np.testing.assert_array_equal(again.gait.torque, sampled_design.gait.torque)


def test_a_start_near_the_optimum_is_quick(robot, standard_task, sampled_design):
    x = sampled_design.solution.x
    start = x + 1e-3 * sampled_design.problem.variables.scale
    again = design(robot, standard_task, SAMPLED, start=start)
    assert again.solution.iterations < sampled_design.solution.iterations
    assert relative_error(again.solution.cost, sampled_design.solution.cost) < 1e-6


def test_progress_is_told_with_the_walk_it_is_of(robot, standard_task, sampled_design):
    told = []

    def watch(problem):
        return lambda progress: told.append((problem, progress))

    start = sampled_design.solution.x
    again = design(robot, standard_task, SAMPLED, start=start, on_progress=watch)
    assert told
    assert all(isinstance(problem, WalkProblem) for problem, _ in told)
    assert [p for _, p in told] == list(again.solution.history)
    assert told[-1][0].describe(told[-1][1].worst)


def test_motors_that_are_too_weak_are_named(robot):
    weak = preset_task(torque_limit=20.0)
    options = replace(UNEXPLAINED, solver=solver_by_name("sqp", max_iterations=25))
    with pytest.raises(
        NoGaitFoundError,
        match=r"no feasible gait was found \(.+\) at 1 m/s with steps of 0\.4 s; the least "
        r"violation leaves \w+ .*: [-\d.]+ \S+, allowed [-\d.]+",
    ) as caught:
        design(robot, weak, options)
    assert caught.value.exit_code == 3


class Answering(Solver):
    """A solver with a ready answer."""

    name = "answering"

    def __init__(self, **changes: object) -> None:
        self.changes = changes

    def solve(self, nlp, start, on_progress=None, stop=None) -> Solution:
        m, n = nlp.rows.lower.size, start.x.size
        answer = Solution(
            start.x, 1.0, np.zeros(m), np.zeros(n), Status.OPTIMAL, 0.0, 0.0, 1, 1, 0, 0.0, "x"
        )
        return replace(answer, **self.changes)


@pytest.mark.parametrize(
    "changes",
    [
        {"cost": np.nan, "status": Status.NUMERICAL},
        {"violation": 0.1, "status": Status.ITERATION_LIMIT},
        {"violation": 1e-5, "status": Status.OPTIMAL},
    ],
)
def test_an_answer_that_is_no_gait_is_refused(robot, changes):
    with pytest.raises(NoGaitFoundError, match=r"no feasible gait was found \("):
        design(robot, preset_task(), DesignOptions(solver=Answering(**changes)))


def test_the_message_tells_value_and_limit_of_the_worst_row(robot):
    """With motors of 2 N.m the torques of the first guess are the worst of all rows."""
    task = preset_task(torque_limit=2.0)
    problem = WalkProblem(robot, task)
    torque = problem.step(first_guess(problem)).support.effort[:, 6:]
    instant, joint = np.unravel_index(np.argmax(np.abs(torque)), torque.shape)
    value = torque[instant, joint]
    with pytest.raises(NoGaitFoundError) as caught:
        design(robot, task, replace(UNEXPLAINED, solver=Answering(violation=1.0)))
    assert str(caught.value).endswith(
        f"{robot.joint_names[joint]} torque at t = {instant / 30 * task.duration:.4f} s: "
        f"{value:.5g} N·m, allowed {np.sign(value) * 2.0:.5g}"
    )


def test_a_point_that_cannot_be_evaluated_says_why(robot):
    problem = WalkProblem(robot, preset_task())
    x = first_guess(problem)
    x[problem.layout.index("pelvis_height")] = 0.9
    solver = Answering(x=x, cost=np.inf, violation=np.inf, status=Status.NUMERICAL)
    with pytest.raises(NoGaitFoundError, match="the stance leg is too short"):
        design(robot, preset_task(), DesignOptions(solver=solver))


def test_a_speed_beyond_the_legs_is_refused_at_once(robot):
    with pytest.raises(UnreachableError, match="longer than the legs can span"):
        design(robot, preset_task(speed=5.0), UNEXPLAINED)


@pytest.mark.parametrize("differences", ["all", "constraints"])
def test_finite_differences_see_the_same_walk(robot, standard_task, sampled_design, differences):
    """The paper's mode and the blunt one: near the optimum they stay at its cost."""
    solver = solver_by_name("sqp", max_iterations=3)
    options = DesignOptions(solver=solver, refine=False, differences=differences)
    found = design(robot, standard_task, options, start=sampled_design.solution.x)
    assert relative_error(found.solution.cost, sampled_design.solution.cost) < 1e-5
    assert found.solution.hessians == 0
