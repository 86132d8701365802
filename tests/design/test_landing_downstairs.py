"""Down stairs no impulse within the limits lifts the rear foot: such walks land at zero speed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from gaitopt.design import starts
from gaitopt.design.audit import audit
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import Design, attempt, impulse_vanishes
from gaitopt.design.starts import design_gait
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.impact import Impact
from gaitopt.model.sole import sole_edge_speeds
from gaitopt.nlp import Status

DOWN = {"speed": 0.5, "duration": 0.7, "stairs": -0.17}


@pytest.fixture(scope="module")
def downstairs(robot):
    return design_gait(robot, preset_task(**DOWN))


def test_a_walk_down_stairs_is_certified(downstairs, tmp_path):
    """It used to end with a KKT residual of 2e-2, its multipliers growing without bound."""
    assert downstairs.certificate.certified
    assert downstairs.certificate.rear_foot_lifts
    assert downstairs.problem.task.margins.soft_landing
    gait = load_gait(save_gait(downstairs.gait, tmp_path / "down.npz"))
    assert audit(gait).passed
    assert np.abs(gait.impulse).max() < 1e-6


def test_it_keeps_every_limit_of_the_impact(downstairs, robot):
    task = downstairs.problem.task.with_margins({"soft_landing": False})
    problem = WalkProblem(robot, task)
    values, names = problem.values(downstairs.solution.x).rows, {b.name for b in problem.blocks}
    left_out = names - {block.name for block in downstairs.problem.blocks}
    assert left_out == {"impulse", "impulse friction", "impulse torsion", "lift-off", "impulse cop"}
    for name in left_out:
        rows = problem.rows_of(name)
        low, high = problem.rows.lower[rows], problem.rows.upper[rows]
        assert np.maximum(low - values[rows], values[rows] - high).max() < 1e-6


def lift_off(robot, posture, task):
    """Greatest speed at which an impulse of 1 N·s up lifts the lowest corner of the rear foot.

    The impulse is any inside a cone that holds that of friction, its centre inside the sole.
    """
    rates = np.eye(len(posture))
    after = [Impact(robot).state(posture, rate) for rate in rates]
    twists = np.stack([state.sole_twist for state in after], axis=1)
    impulses = np.stack([state.impulse for state in after], axis=1)
    corners = sole_edge_speeds(robot.sole.corners) @ twists @ np.linalg.pinv(impulses)
    m, sole = task.margins, robot.sole
    a, mu = m.cop_margin, m.friction
    inside = np.array([
        [-1, 0, mu, 0, 0, 0], [1, 0, mu, 0, 0, 0], [0, -1, mu, 0, 0, 0], [0, 1, mu, 0, 0, 0],
        [0, 0, sole.toe - a, 0, 1, 0], [0, 0, -sole.heel - a, 0, -1, 0],
        [0, 0, sole.left - a, -1, 0, 0], [0, 0, -sole.right - a, 1, 0, 0],
    ])  # fmt: skip
    rows = np.vstack([
        np.hstack([-corners, np.ones((4, 1))]), np.hstack([-inside, np.zeros((8, 1))]),
    ])  # fmt: skip
    free = (None, None)
    bounds = [free, free, (1.0, 1.0), free, free, free, free]
    found = linprog(-np.eye(7)[6], A_ub=rows, b_ub=np.zeros(12), bounds=bounds)
    return -found.fun


def test_no_other_landing_would_lift_the_rear_foot_there(downstairs, robot):
    """On level ground there are such impulses, at the end of that walk down stairs none."""
    level = first_guess(WalkProblem(robot, preset_task(speed=0.5, duration=0.7)))
    posture = WalkProblem(robot, preset_task(speed=0.5, duration=0.7)).step(level).q_end
    assert lift_off(robot, posture, preset_task()) > 5e-5
    assert lift_off(robot, downstairs.gait.q[-1], downstairs.problem.task) < -1e-4


@pytest.fixture(scope="module")
def level(robot):
    problem = WalkProblem(robot, preset_task(speed=0.6, duration=0.5, samples=15))
    return problem, attempt(problem, Search(), first_guess(problem))


def test_only_walks_whose_impulse_vanishes_are_taken_for_such(level):
    problem, found = level
    assert found.status is Status.OPTIMAL
    assert not impulse_vanishes(problem, replace(found, status=Status.STALLED))


@pytest.mark.parametrize("touch_down", ["gentle", "impact"])
def test_a_double_support_that_begins_gently_has_no_impulse_that_could_vanish(robot, touch_down):
    task = preset_task(speed=0.6, duration=0.5, double_support=0.05, touch_down=touch_down)
    problem = WalkProblem(robot, task)
    x = first_guess(problem)
    if touch_down == "impact":
        x[problem.model.layout.push] = 0.0
    assert not problem.step(x).impulse.any()
    assert problem.is_tip(x) is (touch_down == "impact")


@pytest.mark.parametrize("of_its_own", [True, False])
def test_where_going_on_proves_nothing_it_starts_afresh(level, monkeypatch, of_its_own):
    """The walk at hand is not proven; that of starts of its own is taken only if it is."""
    problem, found = level
    monkeypatch.setattr(Design, "proven", property(lambda d: of_its_own and soft(d.problem)))
    unproven, options = replace(found, status=Status.STALLED), DesignOptions(refine=False)
    taken = starts._without_impact(problem, unproven, Search(options))
    assert soft(taken.problem) is of_its_own


def soft(problem):
    return bool(problem.task.margins.soft_landing)
