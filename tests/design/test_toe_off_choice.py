"""Where turning about the toe pays: its best beginning, and the flat walk where that is cheaper."""

import json

import pytest

from gaitopt.design import toe_off
from gaitopt.design.audit import audit
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.design.toe_off import best_beginnings, best_toe_off
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Start, Status
from gaitopt.solvers.sqp import SQP

OPTIONS = DesignOptions()


def chosen(robot, **changes):
    task = preset_task(toe_off=0.7, **changes)

    def designed(task, start, options):
        return design(robot, task, options, start=start)

    return best_toe_off(robot, task, OPTIONS, designed)


@pytest.fixture(scope="module")
def fast(robot):
    return chosen(robot, speed=1.2, duration=0.5)


@pytest.fixture(scope="module")
def slow(robot):
    return chosen(robot, speed=0.6, duration=0.5)


def test_a_fast_walk_turns_about_its_toe_and_is_certified(fast):
    record = fast.design.gait.meta["toe_off"]
    assert fast.design.certificate.certified
    assert fast.design.certificate.rear_foot_lifts
    assert fast.design.solution.cost == record["cost"] < 5060.0  # N²·m·s
    assert 5500.0 < record["flat_cost"] < 5700.0
    assert record["kept"] is True
    assert fast.design.problem.task.toe_off == record["begin"]
    assert "the turn is kept" in fast.sentence


def test_the_gait_of_a_turn_passes_its_own_check(fast, tmp_path):
    found = audit(load_gait(save_gait(fast.design.gait, tmp_path / "gait.npz")))
    assert found.passed
    assert found.altered == ()


def test_a_slow_walk_stays_flat_and_says_so(slow):
    record = slow.design.gait.meta["toe_off"]
    assert record["kept"] is False
    assert record["flat_cost"] < record["cost"]
    assert slow.design.problem.task.toe_off is None
    assert not slow.design.gait.turning
    assert "the flat walk is kept" in slow.sentence
    json.dumps(record)


def test_walks_of_1_m_s_cost_less_from_nearly_every_start(robot):
    problem = WalkProblem(robot, preset_task(toe_off=0.7, speed=1.0, duration=0.5))
    x = first_guess(problem)
    found = [SQP().solve(problem, Start(perturbed(problem, x, 0.1, seed))) for seed in range(10)]
    walks = [s.cost for s in found if s.status is Status.OPTIMAL]
    assert sum(cost <= 3864.0 for cost in walks) >= 8  # N²·m·s; the flat one costs 4190


def test_the_best_beginning_costs_less_than_those_beside_it(robot):
    task = preset_task(toe_off=0.7, speed=1.0, duration=0.5)
    (begin, x), *others = best_beginnings(robot, task, OPTIONS)

    def cost(share):
        problem = WalkProblem(robot, task.with_changes(toe_off=share))
        return SQP().solve(problem, Start(x)).cost

    best = cost(begin)
    assert len(others) == 1  # from the slower walk, or from the first guess
    assert best < cost(0.7)
    assert best <= min(cost(begin - toe_off.STEPS[-1]), cost(begin + toe_off.STEPS[-1]))


def test_a_beginning_that_is_given_is_taken(robot):
    options = DesignOptions(toe_begin="given", refine=False)
    task = preset_task(toe_off=0.66, speed=1.0, duration=0.5, samples=15)
    found = design_gait(robot, task, options, starts=1)
    assert found.problem.task.toe_off == 0.66
    assert found.gait.turns_at == pytest.approx(0.33)
    assert "toe_off" not in found.gait.meta


def test_design_gait_searches_the_beginning(robot):
    options = DesignOptions(refine=False)
    task = preset_task(toe_off=0.7, speed=1.0, duration=0.5, samples=15)
    found = design_gait(robot, task, options, starts=1)
    assert found.gait.meta["toe_off"]["asked"] == 0.7
    assert found.gait.turning


def test_an_unknown_way_to_begin_is_refused():
    with pytest.raises(InputError, match="best, given"):
        DesignOptions(toe_begin="late")


def test_no_walk_at_all_is_told_with_the_reasons_of_the_flat_one(robot):
    with pytest.raises(NoGaitFoundError, match="no feasible gait"):
        chosen(robot, torque_limit=2.0)


def test_a_search_that_is_stopped_keeps_what_it_has(robot, fast):
    flat = design(robot, preset_task(speed=1.2, duration=0.5, samples=15), DesignOptions())
    stopped = []

    def designed(task, start, options):
        if task.toe_off is not None:
            raise StoppedError(flat.solution)
        stopped.append(True)
        return flat

    task = preset_task(toe_off=0.7, speed=1.2, duration=0.5)
    found = best_toe_off(robot, task, OPTIONS, designed, stop=lambda: bool(stopped))
    assert found.design.solution.status is Status.INTERRUPTED
    assert not found.design.gait.turning
    assert "the flat walk is kept" in found.sentence
