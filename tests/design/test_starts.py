import json
import os
import pickle
import signal
import sys
import time
import warnings
from contextlib import closing
from dataclasses import dataclass, replace
from multiprocessing import active_children

import numpy as np
import pytest
from liftoff_limits import watched_liftoff_limits

from gaitopt.design import starts as module
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.phase_times import SLOWER
from gaitopt.design.pipeline import RELAXED_LIFTOFF
from gaitopt.design.starts import (
    FASTER,
    SECOND,
    Outcome,
    SecondStart,
    StartJob,
    _distinct,
    design_gait,
    many_starts,
)
from gaitopt.design.summary import motor_summaries, summarise
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Progress, Solution, Status
from gaitopt.solvers import Solver, solver_by_name

QUICK = DesignOptions(solver=solver_by_name("sqp"), refine=False, diagnose=False)


@dataclass(frozen=True)
class Still(Solver):
    """A solver that stays where it starts; its cost tells the starts apart."""

    violation: float = 0.0
    name = "still"

    def solve(self, nlp, start, on_progress=None, stop=None):
        m, n = nlp.rows.lower.size, start.x.size
        cost = 1000.0 + float(np.abs(start.x).sum())
        return Solution(
            start.x, cost, np.zeros(m), np.zeros(n), Status.OPTIMAL, self.violation, 0.0, 1, 1, 0,
            0.0, "still",
        )  # fmt: skip


STILL = replace(QUICK, solver=Still())


@pytest.fixture(scope="module")
def report(robot, standard_task):
    return many_starts(robot, standard_task, QUICK, count=3, seed=5, sigma=0.2)


def test_the_best_of_all_starts_is_designed(report, sampled_design):
    costs = [o.solution.cost for o in report.outcomes if o.walks]
    assert [o.number for o in report.outcomes] == [0, 1, 2]
    assert report.design.gait.cost == pytest.approx(min(costs), rel=1e-8)
    assert report.design.gait.cost <= sampled_design.gait.cost * (1.0 + 1e-6)
    assert report.optima[0].cost == pytest.approx(min(costs), rel=1e-12)
    assert sum(len(o.starts) for o in report.optima) == sum(o.walks for o in report.outcomes)


def test_where_no_start_is_optimal_one_more_is_made(robot, standard_task):
    solves = []

    @dataclass(frozen=True)
    class Tired(Still):
        def solve(self, nlp, start, on_progress=None, stop=None):
            solves.append(start)
            lazy = len(solves) <= 3  # the guess, the slower walk, and what begins there
            return super().solve(nlp, start) if lazy else QUICK.solver.solve(nlp, start)

    told = []
    found = many_starts(
        robot, standard_task, replace(QUICK, solver=Tired()), on_outcome=told.append
    )
    assert [one.number for one in found.outcomes] == [0, 1, 2] == [one.number for one in told]
    assert found.design.certificate.optimal
    assert found.sentences[0] == "3 of 3 starts led to a walk"
    alone = many_starts(robot, standard_task, STILL)  # none of them is optimal
    assert [one.number for one in alone.outcomes] == [0, 1, 2]
    assert not alone.design.certificate.optimal


def test_of_a_slow_walk_that_one_more_is_from_a_faster_one(robot, standard_task):
    slow = replace(standard_task, speed=0.4)
    found = many_starts(robot, slow, STILL)  # none of them is optimal, and then one is disturbed
    assert [one.number for one in found.outcomes] == [0, 1, 2, 3]
    faster = first_guess(WalkProblem(robot, replace(slow, speed=FASTER * 0.4)))
    np.testing.assert_array_equal(found.outcomes[2].solution.x, faster)
    assert found.outcomes[2].solution.iterations == 2  # of both walks
    assert len(many_starts(robot, slow, STILL, count=1).outcomes) == 1


def test_a_slow_walk_is_found_from_a_faster_one_where_no_guess_leads_there(robot):
    """The guesses end where only a vanishing impulse lifts the rear foot."""
    quick = replace(QUICK, solver=QUICK.solver.limited(110))
    found = many_starts(robot, preset_task("robust", robot, speed=0.4), quick)
    assert [one.walks for one in found.outcomes] == [False, False, True]
    assert found.design.certificate.optimal
    mass, impulse = robot.mass, found.design.gait.impulse[2]
    assert 0.01 < impulse / mass < 0.2  # m/s


def test_other_optima_are_told_with_their_motors(report):
    best, other = report.optima[:2]
    assert set(best.peak_torques) == {
        motor["joint"] for motor in motor_summaries(report.design.gait)
    }
    worst = max(best.peak_torques, key=lambda n: abs(best.peak_torques[n] - other.peak_torques[n]))
    said = (
        f"; peak torques: {worst} {other.peak_torques[worst]:.3g} N·m instead of "
        f"{best.peak_torques[worst]:.3g}, "
    )
    assert said in report.sentences[2]
    assert said not in report.sentences[1]
    assert summarise(report.design.gait)["optima"] == report.record()["optima"]


def test_the_number_of_workers_changes_nothing(robot, standard_task, report):
    again = many_starts(robot, standard_task, QUICK, count=3, seed=5, sigma=0.2, workers=2)
    for one, other in zip(report.outcomes, again.outcomes, strict=True):
        np.testing.assert_array_equal(one.solution.x, other.solution.x)
    np.testing.assert_array_equal(report.design.gait.parameters, again.design.gait.parameters)


def test_the_first_start_is_the_guess_and_the_others_are_not(robot, standard_task):
    seen = {}
    for seed in (5, 6):
        found = many_starts(robot, standard_task, STILL, count=4, seed=seed, sigma=0.1)
        seen[seed] = [o.solution.x for o in found.outcomes]
    guess = first_guess(WalkProblem(robot, standard_task))
    np.testing.assert_array_equal(seen[5][0], guess)
    np.testing.assert_array_equal(seen[6][0], guess)
    others = [*seen[5][2:4], *seen[6][2:4]]  # a fifth, for none of them is optimal
    away = [np.std((x - guess)[:36]) for x in others]
    assert np.allclose(away, 0.1, rtol=0.4)
    assert len({x.tobytes() for x in others}) == 4


def test_the_second_start_is_a_slower_walk(robot, standard_task):
    found = many_starts(robot, standard_task, STILL, count=2)
    slower = replace(standard_task, speed=SLOWER * standard_task.speed)
    guess = first_guess(WalkProblem(robot, slower))
    np.testing.assert_array_equal(found.outcomes[1].solution.x, guess)
    assert found.outcomes[1].solution.iterations == 2  # of both walks


@pytest.mark.parametrize(("boundary", "each"), [("closed", 1), ("lifted", 2)])
def test_every_start_is_made_by_the_approach_of_the_options(
    robot, standard_task, boundary, each, monkeypatch
):
    """A lifted walk is begun with a relaxed lift-off: two stages each, and the best not again."""
    limits = watched_liftoff_limits(monkeypatch, Still)
    many_starts(robot, replace(standard_task, boundary=boundary), STILL, count=1)
    assert limits == [RELAXED_LIFTOFF, 0.0][-each:]


def test_a_slower_walk_leads_to_a_better_optimum(report, sampled_design):
    assert report.optima[0].starts[0] == 1
    assert report.design.gait.cost < 0.97 * sampled_design.gait.cost


def test_a_start_of_ones_own_is_the_centre(robot, standard_task):
    own = first_guess(WalkProblem(robot, standard_task)) + 0.01
    found = many_starts(robot, standard_task, STILL, count=1, start=own)
    np.testing.assert_array_equal(found.outcomes[0].solution.x, own)


@pytest.mark.parametrize(
    ("start", "message"),
    [
        (np.ones(7), r"the first guess has shape \(7,\); give 43 finite numbers, in the order of"),
        (np.ones((43, 1)), r"the first guess has shape \(43, 1\); give 43"),
        (np.append(np.ones(42), np.nan), "no finite value for pelvis_yaw; give 43"),
        ("a walk", "no array of numbers; give 43|'a walk'; give an array of numbers or a Gait"),
    ],
)
def test_a_start_that_is_none_is_refused_as_design_does(robot, standard_task, start, message):
    for search in (design, many_starts):
        with pytest.raises(InputError, match=message):
            search(robot, standard_task, STILL, start=start)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_stop_keeps_the_best_start_so_far(robot, standard_task, workers):
    told = []
    found = many_starts(
        robot, standard_task, STILL, count=5, workers=workers,
        on_outcome=lambda outcome: told.append(outcome.number), stop=lambda: len(told) >= 2,
    )  # fmt: skip
    told = [o.number for o in found.outcomes]
    assert told[:2] == [0, 1]
    if workers == 1:
        assert found.sentences[0] == "2 of 2 starts led to a walk; 5 were asked for"
    costs = [o.solution.cost for o in found.outcomes]
    best = found.outcomes[int(np.argmin(costs))].solution
    assert found.design.solution.status is Status.INTERRUPTED
    np.testing.assert_array_equal(found.design.gait.parameters, best.x)


class Interrupted(Still):
    """A solver that is stopped at its first iterate."""

    def solve(self, nlp, start, on_progress=None, stop=None):
        return replace(super().solve(nlp, start), status=Status.INTERRUPTED)


def test_a_stop_in_a_start_keeps_its_walk(robot, standard_task):
    found = many_starts(robot, standard_task, replace(QUICK, solver=Interrupted()), count=2)
    assert len(found.outcomes) == 1
    assert found.design.solution.status is Status.INTERRUPTED


def test_a_stop_before_there_is_a_walk_ends_all(robot, standard_task):
    lost = replace(QUICK, solver=Interrupted(violation=0.3))
    with pytest.raises(StoppedError):
        many_starts(robot, standard_task, lost, count=2)


def test_no_walk_from_any_start_is_refused(robot, standard_task):
    lost = replace(QUICK, solver=Still(violation=0.3))
    with pytest.raises(NoGaitFoundError, match="no feasible gait was found"):
        many_starts(robot, standard_task, lost, count=2)


def outcome(number, cost, place, problem, status=Status.OPTIMAL, violation=0.0):
    x = place * problem.variables.scale
    empty = np.zeros(1)
    solution = Solution(
        x, cost, empty, empty, status, violation, 0.0, 1, 1, 0, 0.0, "x"
    )  # fmt: skip
    return Outcome(number, solution)


def test_optima_are_the_same_if_cost_and_place_agree(robot):
    problem = WalkProblem(robot, preset_task())
    found = _distinct(
        [
            outcome(0, 850.0, 0.30, problem),
            outcome(1, 846.0, 0.10, problem),
            outcome(2, 846.00001, 0.11, problem),  # the same
            outcome(3, 846.00002, 0.70, problem),  # as good, another place
            outcome(4, 846.3, 0.12, problem),  # near, another cost
            outcome(5, 800.0, 0.10, problem, Status.ITERATION_LIMIT),  # not optimal
            outcome(6, 700.0, 0.10, problem, violation=0.1),  # no walk
            outcome(7, np.nan, 0.10, problem, Status.NUMERICAL, np.nan),
        ],
        problem,
    )
    assert [(o.cost, o.starts) for o in found] == [
        (846.0, (1, 2)),
        (846.00002, (3,)),
        (846.3, (4,)),
        (850.0, (0,)),
    ]


def test_the_report_can_be_read(report):
    record = json.loads(json.dumps(report.record(), allow_nan=False))
    assert record["starts"] == record["asked"] == 3
    assert record["optima"][0]["cost"] == report.optima[0].cost
    assert report.sentences[0] == f"{record['walks']} of 3 starts led to a walk"
    assert len(report.sentences) == 1 + len(report.optima)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 0}, "0 starts are too few"),
        ({"workers": 0}, "0 workers are too few"),
        ({"seed": -1}, "seed -1 is negative"),
        ({"sigma": -0.1}, "sigma is -0.1 rad"),
        ({"sigma": float("nan")}, "sigma is nan rad"),
    ],
)
def test_bad_options_are_refused(robot, options, message):
    with pytest.raises(InputError, match=message):
        many_starts(robot, **options)


def test_a_path_in_place_of_the_robot_is_refused(standard_task):
    with pytest.raises(InputError, match=r"robot is 'robot\.urdf'; give a Robot, as Robot"):
        design_gait("robot.urdf", standard_task)


copied = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are not copied")


def noted(rounds):
    """Note all that is told: the speed of each round, and its records but for their seconds."""

    def begin_round(problem):
        records = []
        rounds.append((problem.task.speed, problem.describe(0), records))
        return lambda progress: records.append(repr(replace(progress, seconds=0.0)))

    return begin_round


def facts(outcome):
    return pickle.dumps(replace(outcome.solution, seconds=0.0, history=()))


def beside(robot, task, options, stop=lambda: False, rounds=None):
    with closing(SecondStart(robot, task, options)) as second:
        make = noted([] if rounds is None else rounds)
        return many_starts(robot, task, options, second=second, on_progress=make, stop=stop)


@copied
@pytest.mark.parametrize("speed", [0.6, 1.0])
def test_a_second_start_beside_the_first_comes_to_the_same(robot, speed, monkeypatch):
    task = preset_task("standard", robot, speed=speed)
    told, told_beside, made = [], [], []
    alone = many_starts(robot, task, QUICK, on_progress=noted(told))
    run = StartJob.run
    with closing(SecondStart(robot, task, QUICK)) as second:
        monkeypatch.setattr(StartJob, "run", lambda s, n, how: made.append(n) or run(s, n, how))
        found = many_starts(robot, task, QUICK, second=second, on_progress=noted(told_beside))
    assert made == [0]  # the other was made by the copy
    assert told_beside == told
    assert len(told) > 2
    assert [*map(facts, found.outcomes)] == [*map(facts, alone.outcomes)]
    assert found.sentences == alone.sentences
    np.testing.assert_array_equal(found.design.gait.parameters, alone.design.gait.parameters)
    assert active_children() == []


@dataclass(frozen=True)
class Doomed(Still):
    """Stays where it starts and tells of it three times; in a copy of the process it ends first."""

    end: object = None
    home: int = 0

    def solve(self, nlp, start, on_progress=None, stop=None):
        for k in range(3):
            on_progress(Progress(k, 0.0, 0.0, 0, 0.0, 1.0, 0.0, k))
            if k == 1 and os.getpid() != self.home:
                self.end()
        return super().solve(nlp, start)


def doomed(end):
    return replace(QUICK, solver=Doomed(end=end, home=os.getpid()))


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def leave():
    os._exit(0)


def fail():
    raise ValueError("only in the copy")


def give_no_answer():
    Solution.__reduce__ = lambda _: fail()  # it cannot be sent


def come_late():
    time.sleep(60.0)


@copied
@pytest.mark.parametrize("end", [die, leave, fail, give_no_answer, come_late])
def test_a_second_start_whose_copy_is_lost_is_made_here(robot, standard_task, end, monkeypatch):
    monkeypatch.setattr(module, "LATE", 2.0)
    told, told_beside = [], []
    options = doomed(end)
    alone = many_starts(robot, standard_task, options, on_progress=noted(told))
    found = beside(robot, standard_task, options, rounds=told_beside)
    assert [*map(facts, found.outcomes)] == [*map(facts, alone.outcomes)]
    assert told_beside == told  # nothing twice
    assert [len(records) for *_, records in told[1:3]] == [3, 3]
    assert active_children() == []


@copied
def test_what_a_copy_warns_of_is_warned_of_here(robot, standard_task):
    def warn():
        warnings.warn("a rough floor", stacklevel=1)

    @dataclass(frozen=True)
    class Warns(Still):
        def solve(self, nlp, start, on_progress=None, stop=None):
            warn()
            return super().solve(nlp, start)

    with pytest.warns(UserWarning, match="a rough floor") as caught:
        beside(robot, standard_task, replace(QUICK, solver=Warns()))
    assert len(caught) > 2
    assert active_children() == []


@copied
def test_an_error_of_a_second_start_is_that_of_the_first_process(robot, standard_task):
    @dataclass(frozen=True)
    class Refusing(Still):
        def solve(self, nlp, start, on_progress=None, stop=None):
            if nlp.task.speed < 1.0:
                raise InputError("too slow for this solver; give a faster walk")
            return super().solve(nlp, start)

    with pytest.raises(InputError, match="too slow for this solver; give a faster walk"):
        beside(robot, standard_task, replace(QUICK, solver=Refusing()))
    assert active_children() == []


@dataclass(frozen=True)
class Waiting(Still):
    """The slower walk is searched for until that is stopped."""

    heeds: bool = True

    def solve(self, nlp, start, on_progress=None, stop=None):
        found = super().solve(nlp, start)
        if nlp.task.speed == 1.0:
            return found
        on_progress(told := Progress(0, 0.0, 0.0, 0, 0.0, 1.0, 0.0, 0))
        while not (self.heeds and stop(told)):
            time.sleep(0.01)
        return replace(found, status=Status.INTERRUPTED)


@copied
@pytest.mark.parametrize("heeds", [True, False])
def test_a_second_start_ends_when_it_is_to_stop(robot, standard_task, heeds):
    rounds = []
    options = replace(QUICK, solver=Waiting(heeds=heeds))
    found = beside(
        robot, standard_task, options, lambda: any(records for *_, records in rounds), rounds
    )
    assert found.design.solution.status is Status.INTERRUPTED
    numbers = [one.number for one in found.outcomes]
    assert numbers == ([0, SECOND] if heeds else [0])  # what does not heed is not waited for
    assert active_children() == []
