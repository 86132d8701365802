"""Limits kept between the samples, against the certificate and against the usual refinement."""

from dataclasses import replace

import pytest

from gaitopt.design import refinement as exchange
from gaitopt.design.active_set import active_rows, violated_rows
from gaitopt.design.certificate import certify, on_fine_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers import SQP
from gaitopt.sweep import continuation
from gaitopt.sweep.continuation import solve_between_samples
from gaitopt.tolerances import LIMITS

SOLVER = SQP()


@pytest.fixture(scope="module")
def begun(sampled_design):
    """A walk at its samples, the limits it presses on, and its fine grid."""
    problem = WalkProblem(sampled_design.problem.robot, sampled_design.problem.task)
    solution = sampled_design.solution
    return problem, solution, active_rows(problem, solution.multipliers), on_fine_grid(problem)


@pytest.fixture(scope="module")
def kept(begun):
    problem, solution, active, fine = begun
    return solve_between_samples(problem, solution.x, active, SOLVER, fine)


def test_no_limit_is_exceeded_between_the_samples(begun, kept):
    *_, fine = begun
    assert violated_rows(fine, begun[1].x)
    assert not violated_rows(fine, kept.solution.x)
    assert certify(kept.problem, kept.solution.x).worst.violation <= LIMITS


def test_it_is_the_optimum_that_refinement_finds(begun, kept, refined_design):
    """To a millionth: each leaves violations of its own, up to REFINED."""
    assert kept.solution.cost == pytest.approx(refined_design.solution.cost, rel=1e-6)


def test_without_a_fine_grid_the_samples_suffice(begun):
    problem, solution, active, _ = begun
    alone = solve_between_samples(problem, solution.x, active, SOLVER, None)
    assert alone.solution.cost == pytest.approx(solution.cost, rel=1e-8)
    assert alone.problem.grid.count == problem.task.samples


def test_a_walk_that_costs_too_much_is_not_wanted(begun, kept):
    problem, solution, active, fine = begun
    between = 0.5 * (solution.cost + kept.solution.cost)
    assert (
        solve_between_samples(problem, solution.x, active, SOLVER, fine, cost_limit=between) is None
    )
    assert solve_between_samples(
        problem, solution.x, active, SOLVER, fine, cost_limit=1.001 * kept.solution.cost
    )


def test_a_walk_that_still_exceeds_a_limit_in_the_last_round_is_none(begun, monkeypatch):
    problem, solution, active, fine = begun
    monkeypatch.setattr(exchange, "MAX_ROUNDS", 1)
    monkeypatch.setattr(exchange, "FOLLOWED", 0)
    assert solve_between_samples(problem, solution.x, active, SOLVER, fine) is None
    monkeypatch.setattr(continuation, "violated_rows", lambda fine, x: ())
    assert solve_between_samples(problem, solution.x, active, SOLVER, fine) is not None


def test_no_walk_is_told(begun):
    problem, solution, active, _ = begun
    task = replace(problem.task, margins=replace(problem.task.margins, torque_limit=20.0))
    weak = WalkProblem(problem.robot, task)
    assert solve_between_samples(weak, solution.x, active, SOLVER, on_fine_grid(weak)) is None
