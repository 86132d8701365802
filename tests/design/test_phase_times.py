"""Times of phases where they cost least, and the flat walk where that is cheaper."""

import json
from dataclasses import replace

import numpy as np
import pytest

from gaitopt.design import phase_times
from gaitopt.design.audit import audit
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.phase_times import STEPS, _after, best_times, walks_at_best_times
from gaitopt.design.starts import design_gait
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed, retimed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Start, Status
from gaitopt.solvers.sqp import SQP

OPTIONS = DesignOptions()


def chosen(robot, **changes):
    task = preset_task(toe_off=0.7, **changes)

    def designed(task, start, options):
        return design(robot, task, options, start=start)

    return best_times(robot, task, OPTIONS, designed)


@pytest.fixture(scope="module")
def fast(robot):
    return chosen(robot, speed=1.2, duration=0.5)


@pytest.fixture(scope="module")
def slow(robot):
    return chosen(robot, speed=0.6, duration=0.5)


def test_a_fast_walk_turns_about_its_toe_and_is_certified(fast):
    record = fast.design.gait.meta["phase_times"]
    assert fast.design.certificate.certified
    assert fast.design.certificate.rear_foot_lifts
    assert fast.design.solution.cost == record["cost"] < 5060.0  # N²·m·s
    assert 5500.0 < record["flat_cost"] < 5700.0
    assert record["kept"] is True
    assert fast.design.problem.task.toe_off == record["found"]["toe_off"]
    assert "the turn is kept" in fast.sentence


def test_the_gait_of_a_turn_passes_its_own_check(fast, tmp_path):
    found = audit(load_gait(save_gait(fast.design.gait, tmp_path / "gait.npz")))
    assert found.passed
    assert found.altered == ()


def test_a_slow_walk_stays_flat_and_says_so(slow):
    record = slow.design.gait.meta["phase_times"]
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
    ((timing, x),) = walks_at_best_times(robot, task, OPTIONS)  # a slower walk leads there too
    begin = timing.toe_off

    def cost(share):
        problem = WalkProblem(robot, task.with_changes(toe_off=share))
        return SQP().solve(problem, Start(x)).cost

    best = cost(begin)
    assert best < cost(0.7)
    assert best <= min(cost(begin - STEPS[-1]), cost(begin + STEPS[-1]))


def test_first_walks_that_are_one_and_the_same_are_gone_on_from_once(robot, monkeypatch):
    task = preset_task(toe_off=0.7, speed=1.0, duration=0.5, samples=15)
    x = first_guess(WalkProblem(robot, task))
    one, none = np.zeros(x.size), np.zeros(0)

    def begun(*others):
        walks = [
            Solution(at, 9.0, none, none, Status.OPTIMAL, 0.0, 0.0, 1, 1, 1, 0.1, "sqp")
            for at in (one, *others)
        ]
        monkeypatch.setattr(phase_times, "_first_walks", lambda *_: iter(walks))
        monkeypatch.setattr(phase_times, "_moved", lambda problem, walk, *_: (problem.task, walk))
        return len(walks_at_best_times(robot, task, OPTIONS))

    assert begun(one + 1e-6) == 1
    assert begun(one + 1.0) == 2
    assert begun(one + 1.0, one + 1e-6, one + 1.0 + 1e-6, one + 2.0) == 3


def test_a_move_that_fails_from_the_motion_is_made_from_the_postures(robot, monkeypatch):
    """As that of G1 at 0.6 m/s from 0.86 to 0.94 of the step, where its walk is cheapest."""
    problem = WalkProblem(robot, preset_task(toe_off=0.7, duration=0.5, samples=9))
    x, none = first_guess(problem), np.zeros(0)
    walk = Solution(x, 9.0, none, none, Status.OPTIMAL, 0.0, 0.0, 1, 1, 1, 0.1, "sqp")

    def attempt(trial, search, begin):
        if not np.array_equal(begin, x):
            return replace(walk, status=Status.INFEASIBLE, violation=1.0)
        return replace(walk, cost=9.0 - trial.task.toe_off)

    monkeypatch.setattr(phase_times, "attempt", attempt)
    task, found = phase_times._moved(problem, walk, ("toe_off",), Search(OPTIONS))
    assert task.toe_off > 0.7
    assert found.cost == pytest.approx(9.0 - task.toe_off)


def test_a_beginning_that_is_given_is_taken(robot):
    options = DesignOptions(toe_begin="given", refine=False)
    task = preset_task(toe_off=0.66, speed=1.0, duration=0.5, samples=15)
    found = design_gait(robot, task, options, starts=1)
    assert found.problem.task.toe_off == 0.66
    assert found.gait.turns_at == pytest.approx(0.33)
    assert "phase_times" not in found.gait.meta


def test_design_gait_searches_the_beginning(robot):
    options = DesignOptions(refine=False)
    task = preset_task(toe_off=0.7, speed=1.0, duration=0.5, samples=15)
    found = design_gait(robot, task, options, starts=1)
    assert found.gait.meta["phase_times"]["asked"] == {"toe_off": 0.7}
    assert found.gait.turning


def test_an_unknown_way_to_begin_is_refused():
    with pytest.raises(InputError, match="best or given"):
        DesignOptions(toe_begin="late")


def test_no_walk_at_all_is_told_with_the_reasons_of_the_flat_one(robot):
    """The flat walk is the last that is tried, and the one whose failure is diagnosed."""
    calls = []

    def designed(task, start, options):
        calls.append((task.toe_off, options.diagnose))
        return design(robot, task, replace(options, diagnose=False), start=start)

    with pytest.raises(NoGaitFoundError, match="no feasible gait"):
        best_times(robot, preset_task(toe_off=0.7, torque_limit=2.0), OPTIONS, designed)
    assert calls[-1] == (None, True)
    assert not any(diagnosed for _, diagnosed in calls[:-1])


def test_a_search_that_is_stopped_keeps_what_it_has(robot, fast):
    flat = design(robot, preset_task(speed=1.2, duration=0.5, samples=15), DesignOptions())
    stopped = []

    def designed(task, start, options):
        if task.toe_off is not None:
            raise StoppedError(flat.solution)
        stopped.append(True)
        return flat

    task = preset_task(toe_off=0.7, speed=1.2, duration=0.5)
    found = best_times(robot, task, OPTIONS, designed, stop=lambda: bool(stopped))
    assert found.design.solution.status is Status.INTERRUPTED
    assert not found.design.gait.turning
    assert "the flat walk is kept" in found.sentence


def test_the_best_time_on_both_feet_is_found_from_a_long_one(robot):
    task = preset_task(speed=1.0, duration=0.5, double_support=0.05, samples=21)
    options = DesignOptions(phase_times="best", refine=False)
    found = design_gait(robot, task, options, starts=1)
    record = found.gait.meta["phase_times"]
    time = found.problem.task.double_support
    assert record["found"] == {"double_support": time}
    assert record["flat_cost"] is None
    assert 0.008 < time < 0.025  # s: docs/phases.md has 3852 at 10 ms, 4269 at 50 ms
    given = design_gait(robot, task, DesignOptions(refine=False), starts=1)
    assert found.solution.cost < 0.95 * given.solution.cost
    assert "phase_times" not in given.gait.meta


def test_a_heel_strike_is_searched_and_kept_only_where_it_is_cheaper(robot):
    task = preset_task(speed=1.0, duration=0.5, heel_strike=0.2)
    options = DesignOptions(phase_times="best", refine=False, diagnose=False)
    found = design_gait(robot, task, options, starts=1)
    record = found.gait.meta["phase_times"]
    assert record["kept"] is True
    assert found.problem.task.heel_strike == record["found"]["heel_strike"] > 0.25
    assert found.solution.cost == record["cost"] < 0.9 * record["flat_cost"]


def test_moves_keep_to_what_a_task_allows():
    task = preset_task(duration=0.5, heel_strike=0.3, toe_off=0.4)
    assert _after(task, "heel_strike", 0.04).heel_strike == pytest.approx(0.34)
    assert _after(task, "heel_strike", 0.08) is None  # the foot stands flat between
    both = preset_task(duration=0.5, double_support=0.1)
    assert _after(both, "double_support", 2.0).double_support == pytest.approx(0.2)
    assert _after(both, "double_support", 4.0) is None


@pytest.mark.parametrize(
    "changes",
    [
        {"toe_off": 0.7},
        {"toe_off": 0.7, "heel_strike": 0.2},
        {"toe_off": 0.7, "double_support": 0.05},
        {"toe_off": 0.7, "speed": 0.5, "turn_rate": 0.4},
    ],
)
def test_a_walk_at_other_times_has_the_postures_that_it_had_there(robot, changes):
    task = preset_task(duration=0.5, samples=15, **changes)
    old, new = (WalkProblem(robot, replace(task, toe_off=share)) for share in (0.7, 0.78))
    rng, scale = np.random.default_rng(0), old.variables.scale
    x = first_guess(old) + 0.02 * scale * rng.normal(size=scale.size)
    y = retimed(x, old, new)
    assert not np.array_equal(x, y)
    count = len(old.models)
    for number, model in enumerate(new.models):
        shares = np.round(model.knots[1:-1], 12)

        def postures(walk, at, number=number, shares=shares):
            dense = walk.with_grid(walk.grid.with_instants((number + shares) / count))
            instants = dense.models[number].grid.instants
            rows = np.abs(instants[:, None] - shares).argmin(axis=0)
            return dense.steps(at)[number].motion[0, rows]

        np.testing.assert_allclose(postures(new, y), postures(old, x), atol=1e-9)
    np.testing.assert_allclose(retimed(x, old, old), x, atol=1e-9)


def test_an_unknown_way_to_find_times_is_refused():
    with pytest.raises(InputError, match="phase_times 'soon'"):
        DesignOptions(phase_times="soon")
