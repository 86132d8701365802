from dataclasses import replace

import numpy as np
import pytest
from walks import walk

from gaitopt.design import refinement
from gaitopt.design.active_set import violated_rows
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.refinement import refine
from gaitopt.gait.grid import Grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Start, Status
from gaitopt.solvers import SQP, Solver, solver_by_name
from gaitopt.tolerances import LIMITS


def with_margins(problem: WalkProblem, **changes: object) -> WalkProblem:
    task = replace(problem.task, margins=replace(problem.task.margins, **changes))
    return WalkProblem(problem.robot, task, problem.grid)


def violated_instants(problem, x):
    return np.unique([peak.held for peak in violated_rows(on_fine_grid(problem), x)])


@pytest.fixture(scope="module")
def lenient(refined_design):
    """A walk that holds between its samples, with room to plant a violation."""
    return refined_design.problem, refined_design.solution.x


def test_a_refined_gait_has_no_violated_instant(lenient):
    problem, x = lenient
    assert not violated_rows(on_fine_grid(problem), x)


def dense_torques(problem: WalkProblem, x):
    """Instants, and torques there: an independent look at the whole step."""
    instants = np.linspace(0.0, 1.0, 6001)
    grid = Grid(instants, np.ones(instants.size), instants.size)
    return instants, problem.with_grid(grid).step(x).support.effort[:, 6:]


def test_a_planted_violation_is_found(lenient):
    """Limit the torques just below the largest one of the step: its instant is found."""
    problem, x = lenient
    instants, torque = dense_torques(problem, x)
    instant, _ = np.unravel_index(np.argmax(np.abs(torque)), torque.shape)
    lowered = with_margins(problem, torque_limit=float(np.abs(torque).max()) * (1.0 - 1e-4))
    found = violated_instants(lowered, x)
    np.testing.assert_allclose(found, [instants[instant]], atol=2e-4)


def test_of_every_stretch_the_worst_instant_is_taken(lenient):
    problem, x = lenient
    found = violated_instants(with_margins(problem, torque_limit=40.0), x)
    instants, torque = dense_torques(problem, x)
    excess = np.abs(torque) - 40.0
    violated = (excess > 40.0 * LIMITS).any(axis=1)
    assert 0 < found.size < violated.sum() / 30
    worst = instants[np.argmax(excess, axis=0)[excess.max(axis=0) > 40.0 * LIMITS]]
    assert np.abs(worst[:, None] - found).min(axis=1).max() < 2e-4


def test_samples_alone_leave_violations_between_them(sampled_design):
    found = violated_instants(sampled_design.problem, sampled_design.solution.x)
    assert found.size > 0
    samples = sampled_design.problem.grid.instants
    assert np.abs(found[:, None] - samples).min() > 1e-5


def test_a_walk_with_nothing_violated_is_returned_as_it_is(refined_design):
    problem, solution = refine(
        refined_design.problem, refined_design.solution, solver_by_name("sqp"), Search()
    )
    assert problem is refined_design.problem
    assert solution is refined_design.solution


def test_newton_and_exchange_alone_refine_to_the_same_walk(sampled_design, monkeypatch):
    problem, first = sampled_design.problem, sampled_design.solution
    moved, quick = refine(problem, first, SQP(), Search())
    asked = []

    def no_minimum(*_):
        asked.append(True)
        return False

    monkeypatch.setattr(refinement, "is_strict_minimum", no_minimum)
    held, slow = refine(problem, first, SQP(), Search())
    assert asked == [True] * 2  # at its instants, and beside them; what exchange finds is taken
    for grid, solution in ((moved, quick), (held, slow)):
        assert solution.status is Status.OPTIMAL
        assert not violated_rows(on_fine_grid(grid), solution.x)
    assert quick.cost == pytest.approx(slow.cost, rel=1e-6)
    assert quick.cost > first.cost * (1.0 + 1e-4)
    assert quick.iterations < slow.iterations


def test_where_no_minimum_is_strict_at_its_instants_limits_are_held_beside_them(
    sampled_design, monkeypatch
):
    problem, first = sampled_design.problem, sampled_design.solution
    moved, quick = refine(problem, first, SQP(), Search())
    verdicts = iter((False, True))
    monkeypatch.setattr(refinement, "is_strict_minimum", lambda *_: next(verdicts))
    beside, again = refine(problem, first, SQP(), Search())
    assert not list(verdicts)
    assert beside.grid.count > moved.grid.count
    assert again.status is Status.OPTIMAL
    assert not violated_rows(on_fine_grid(beside), again.x)
    assert 0.0 < quick.cost - again.cost < 1e-6 * quick.cost  # half of REFINED is given away
    assert again.iterations <= quick.iterations + 3
    assert again.optimality <= refinement.CLOSELY


def test_where_exchange_crawls_the_walk_of_newton_is_kept(sampled_design, monkeypatch):
    problem, first = sampled_design.problem, sampled_design.solution
    exchanged = refinement.exchange

    def crawling(*args):
        for grid, solution, near in exchanged(*args):
            *_, newton, _ = args
            ends = Status.OPTIMAL if newton is not None else Status.ITERATION_LIMIT
            yield grid, replace(solution, status=ends), near

    _, quick = refine(problem, first, SQP(), Search())
    monkeypatch.setattr(refinement, "is_strict_minimum", lambda *_: False)
    monkeypatch.setattr(refinement, "exchange", crawling)
    grid, kept = refine(problem, first, SQP(), Search())
    assert kept.status is Status.OPTIMAL
    assert not violated_rows(on_fine_grid(grid), kept.x)
    np.testing.assert_array_equal(kept.x, quick.x)


def test_where_no_instants_moved_rounds_are_solved_once(sampled_design, monkeypatch):
    problem, first = sampled_design.problem, sampled_design.solution
    monkeypatch.setattr(refinement, "resting_walk", lambda *_: None)
    monkeypatch.setattr(refinement, "is_strict_minimum", lambda *_: False)
    grids = []

    def noted(finer):
        grids.append(tuple(finer.grid.instants))
        return lambda _: None

    grid, solution = refine(problem, first, SQP(), Search(on_progress=noted))
    assert solution.status is Status.OPTIMAL
    assert not violated_rows(on_fine_grid(grid), solution.x)
    assert len(grids) == len(set(grids)) > 1


def test_rounds_end_where_one_gets_nowhere(sampled_design, monkeypatch):
    """A round that returns its start at the instants of the one before would do so for ever."""
    problem, first = sampled_design.problem, sampled_design.solution
    monkeypatch.setattr(refinement, "resting_walk", lambda *_: None)
    tried = []

    def nowhere(finer, start):
        tried.append(finer.grid.instants)
        return replace(first, x=start.x, multipliers=start.multipliers)

    fine = on_fine_grid(problem)
    peaks = violated_rows(fine, first.x)
    rounds = refinement.exchange(problem, first.x, (), nowhere, fine, peaks)
    assert all(not near for *_, near in rounds)
    assert len(tried) == 2
    assert set(tried[0]) == set(tried[1]) > set(problem.grid.instants)


class Refusing(Solver):
    """A solver that must not be asked, or that fails when it is."""

    name = "refusing"

    def __init__(self, status: Status | None) -> None:
        self.status = status

    def solve(self, nlp, start, on_progress=None, stop=None) -> Solution:
        assert self.status is not None, "this solver must not be asked"
        m, n = nlp.rows.lower.size, start.x.size
        return Solution(
            start.x, 1.0, np.zeros(m), np.zeros(n), self.status, 1.0, 1.0, 3, 4, 2, 0.5, self.name
        )


def test_a_solution_that_is_none_is_not_refined(sampled_design):
    failed = replace(sampled_design.solution, status=Status.INFEASIBLE)
    problem, solution = refine(sampled_design.problem, failed, Refusing(None), Search())
    assert solution is failed
    assert problem is sampled_design.problem


@pytest.mark.parametrize(
    ("failure", "kept"),
    [(Status.INFEASIBLE, Status.OPTIMAL), (Status.INTERRUPTED, Status.INTERRUPTED)],
)
def test_a_round_that_fails_keeps_the_gait_before_it(sampled_design, failure, kept):
    first = sampled_design.solution
    problem, solution = refine(sampled_design.problem, first, Refusing(failure), Search())
    assert solution.status is kept
    assert solution.x is first.x
    assert problem is sampled_design.problem
    assert solution.iterations == first.iterations + 3
    assert solution.evaluations == first.evaluations + 4
    assert solution.hessians == first.hessians + 2
    assert solution.seconds == pytest.approx(first.seconds + 0.5)


@pytest.fixture(scope="module")
def nearly(sampled_design):
    """The same walk, not quite solved at its samples."""
    problem = sampled_design.problem
    return SQP(early=True).solve(problem, Start(first_guess(problem)))


def test_a_walk_nearly_solved_is_refined_to_the_same_with_less_work(sampled_design, nearly):
    problem, solved = sampled_design.problem, sampled_design.solution
    assert nearly.status is Status.OPTIMAL
    assert nearly.optimality > SQP().tolerance
    assert nearly.evaluations < solved.evaluations
    _, usual = refine(problem, solved, SQP(), Search())
    finer, found = refine(problem, nearly, SQP(), Search())
    assert not violated_rows(on_fine_grid(finer), found.x)
    assert found.cost == pytest.approx(usual.cost, rel=1e-8)
    assert found.evaluations < usual.evaluations


def test_a_walk_nearly_solved_is_left_where_no_minimum_is_near(sampled_design, nearly, monkeypatch):
    problem = sampled_design.problem
    monkeypatch.setattr(refinement, "resting_walk", lambda *_: None)
    assert refine(problem, nearly, SQP(), Search()) == (problem, nearly)
    failed = problem, replace(nearly, status=Status.INFEASIBLE), True
    monkeypatch.setattr(refinement, "exchange", lambda *_: iter([failed]))
    assert refine(problem, nearly, SQP(), Search()) == (problem, nearly)


def test_a_walk_nearly_solved_keeps_its_last_complete_round_where_it_is_stopped(
    sampled_design, nearly, monkeypatch
):
    problem = sampled_design.problem
    finer, found = refine(problem, nearly, SQP(), Search())
    stopped = replace(found, x=nearly.x, status=Status.INTERRUPTED)
    rounds = [(finer, found, True), (finer, stopped, True)]
    monkeypatch.setattr(refinement, "exchange", lambda *_: iter(rounds))
    grid, kept = refine(problem, nearly, SQP(), Search())
    assert grid is finer
    assert kept.status is Status.INTERRUPTED
    np.testing.assert_array_equal(kept.x, found.x)


def test_where_a_walk_nearly_solved_leads_to_no_minimum_exchange_begins_when_it_is_solved(
    sampled_design, nearly, monkeypatch
):
    problem, solved = sampled_design.problem, sampled_design.solution
    monkeypatch.setattr(refinement, "is_strict_minimum", lambda *_: False)
    starts = []
    exchanged = refinement.exchange

    def noted(sparse, x, *args):
        starts.append(x)
        return exchanged(sparse, x, *args)

    monkeypatch.setattr(refinement, "exchange", noted)
    finer, found = refine(problem, nearly, SQP(), Search())
    assert not violated_rows(on_fine_grid(finer), found.x)
    assert len(starts) == 2
    np.testing.assert_array_equal(starts[0], nearly.x)
    np.testing.assert_allclose(starts[1], solved.x, atol=1e-6)


def test_a_design_is_the_same_where_its_search_could_not_end_early(
    robot, standard_task, refined_design, monkeypatch
):
    monkeypatch.setattr(refinement, "is_strict_minimum", lambda *_: False)
    monkeypatch.setattr(refinement, "resting_walk", lambda *_: None)
    options = DesignOptions(solver=solver_by_name("sqp"))
    exchanged = design(robot, standard_task, options)
    assert exchanged.certificate.certified
    assert exchanged.solution.cost == pytest.approx(refined_design.solution.cost, rel=1e-6)
    assert exchanged.solution.hessians > refined_design.solution.hessians


def test_margins_of_the_helper_are_real():
    problem = walk("guess").problem
    changed = with_margins(problem, friction=0.5).task.margins
    assert changed == replace(problem.task.margins, friction=0.5) != problem.task.margins
