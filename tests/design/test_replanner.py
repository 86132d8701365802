"""Replanning goes from walk to walk, keeps its deadline, and never raises for a late one."""

from dataclasses import replace

import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.replanner import ANSWERED, LATE, NEARLY, NONE, Replanner
from gaitopt.errors import InputError
from gaitopt.gait.presets import preset_task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Status
from gaitopt.solvers import sqp


@pytest.fixture(scope="module")
def robot():
    return Robot.from_urdf(sample_gait().urdf)


@pytest.fixture
def planner(robot):
    made = Replanner()
    assert made.replan(robot, preset_task(speed=0.8)).answered
    return made


def test_a_neighbour_is_a_few_iterations_away_and_no_dearer(robot, planner):
    for speed in (0.81, 0.82, 0.83):
        plan = planner.replan(robot, preset_task(speed=speed))
        assert plan.outcome == ANSWERED
        assert plan.solution.iterations <= 8
    known = design(robot, preset_task(speed=0.83), DesignOptions(refine=False))
    assert plan.solution.cost <= known.solution.cost * (1.0 + 1e-6)
    assert plan.gait().speed == pytest.approx(0.83, abs=1e-6)
    assert plan.complete().certificate.certified


def test_near_the_last_walk_newtons_method_goes_along_the_tangent(robot, monkeypatch):
    planner = Replanner()
    assert planner.replan(robot, preset_task(speed=1.19)).answered
    monkeypatch.setattr(sqp, "solve_subproblem", None)  # it needs no quadratic program
    found = planner.replan(robot, preset_task(speed=1.2)).solution
    assert found.status is Status.OPTIMAL
    violations = [one.violation for one in found.history]
    assert violations[1] > violations[0]  # of second order, and corrected by the next step
    assert found.evaluations == found.iterations + 1  # every step was taken
    assert found.hessians < found.iterations  # the first step was by that of the last walk


def test_a_deadline_is_kept_and_the_plan_goes_on_where_it_ended(robot, planner):
    task, last = preset_task(speed=0.9), planner.last
    late = planner.replan(robot, task, deadline=0.0)
    assert late.outcome == LATE
    assert planner.last is last
    with pytest.raises(InputError, match="there is no walk to use: late"):
        late.gait()
    calls = iter(range(100))
    stopped = planner.replan(robot, task, stop=lambda: next(calls) >= 5)
    assert stopped.outcome == LATE
    whole = planner.replan(robot, task)
    alone = Replanner()
    alone.replan(robot, preset_task(speed=0.8))
    usual = alone.replan(robot, task)
    assert whole.answered
    assert whole.solution.iterations < usual.solution.iterations
    assert whole.solution.cost == pytest.approx(usual.solution.cost, rel=1e-8)


@pytest.mark.parametrize(("iterations", "used"), [(2, False), (10, True)])
def test_a_late_plan_helps_another_task_once_it_is_nearly_a_walk(robot, iterations, used):
    planner, alone = Replanner(), Replanner()
    for one in (planner, alone):
        assert one.replan(robot, preset_task(speed=1.0)).answered
    calls = iter(range(1000))
    late = planner.replan(robot, preset_task(speed=1.15), stop=lambda: next(calls) >= iterations)
    assert late.outcome == LATE
    assert (late.solution.violation <= NEARLY) == used
    plan, usual = (one.replan(robot, preset_task(speed=1.151)) for one in (planner, alone))
    assert plan.answered
    assert plan.solution.cost == pytest.approx(usual.solution.cost, rel=1e-8)
    if used:
        assert plan.solution.iterations < 0.6 * usual.solution.iterations
    else:
        assert plan.solution.x == pytest.approx(usual.solution.x, abs=0.0)


def test_where_nothing_walks_it_is_told_and_the_last_walk_stays(robot, planner):
    last = planner.last
    margins = preset_task().margins
    weak = preset_task(speed=0.8, margins=replace(margins, torque_limit=5.0))
    plan = planner.replan(robot, weak)
    assert plan.outcome == NONE
    assert plan.reason
    assert planner.last is last
    far = planner.replan(robot, preset_task(speed=5.0))
    assert far.outcome == NONE
    assert far.reason
    assert planner.replan(robot, preset_task(speed=0.81)).answered


def test_a_changed_robot_or_grid_needs_no_new_start(robot, planner):
    heavy = robot.choices.over(payloads=())
    other = Robot.from_urdf(robot.urdf, choices=replace(heavy, without=("armature",)))
    plan = planner.replan(other, preset_task(speed=0.8))
    assert plan.answered
    finer = planner.replan(other, preset_task(speed=0.8, samples=41))
    assert finer.answered
    assert np.isfinite(finer.solution.cost)
