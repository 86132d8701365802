"""Every solver on every textbook program: solution, cost, multipliers, optimality conditions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
import textbook_programs as bank

from gaitopt.nlp import Progress, Solution, Start, Status, kkt_residual
from gaitopt.solvers import SLSQP, SQP, FiniteDifferenceNLP, Solver, TrustConstr, TwoStageSQP


@dataclass(frozen=True)
class Entry:
    """A solver and how closely it should know the answer."""

    label: str
    solver: Solver
    x: float  # the bank has eight digits or more
    multiplier: float  # relative to the largest, or one
    conditions: float


ENTRIES = (
    Entry("sqp", SQP(), 1e-6, 1e-5, 1e-6),
    Entry("sqp by bfgs", SQP(hessian="bfgs"), 1e-6, 1e-5, 1e-6),
    Entry("sqp by quadprog", SQP(qp_solver="quadprog"), 1e-6, 1e-5, 1e-6),
    # An augmented Lagrangian QP is accurate to its tolerance only.
    Entry("sqp by proxqp", SQP(qp_solver="proxqp"), 1e-5, 1e-5, 1e-6),
    # An interior point keeps off active limits by tolerance / multiplier.
    Entry("trust-constr", TrustConstr(), 1e-5, 1e-5, 1e-6),
    Entry("slsqp", SLSQP(), 1e-4, 1e-4, 1e-5),
    Entry("default", TwoStageSQP(), 1e-6, 1e-5, 1e-6),
)
BY_LABEL = pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.label)
BY_TITLE = pytest.mark.parametrize("program", bank.SOLVABLE, ids=lambda program: program.title)


def assert_solves(program: bank.Textbook, solution: Solution, entry: Entry) -> None:
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=entry.x)
    assert solution.cost == pytest.approx(program.best, rel=1e-5)
    size = entry.multiplier * max(1.0, np.abs(program.multipliers).max())
    np.testing.assert_allclose(solution.multipliers, program.multipliers, atol=size)
    np.testing.assert_allclose(solution.bound_multipliers, program.bound_multipliers, atol=size)
    point = program.point(solution.x)
    residual = kkt_residual(program, point, solution.multipliers, solution.bound_multipliers)
    assert residual.worst <= entry.conditions
    assert residual.optimality == pytest.approx(solution.optimality, abs=1e-12)


@BY_TITLE
def test_bank_satisfies_the_optimality_conditions(program: bank.Textbook) -> None:
    point = program.point(program.solution)
    residual = kkt_residual(program, point, program.multipliers, program.bound_multipliers)
    assert residual.worst < 1e-3  # solutions are printed to seven digits, curvatures reach 1000
    assert point.cost == pytest.approx(program.best, rel=1e-7)


@pytest.mark.parametrize(
    "program",
    [*bank.SOLVABLE, bank.hs26(), bank.waechter_biegler(), bank.degenerate(), bank.infeasible()],
    ids=lambda program: program.title,
)
def test_bank_has_right_derivatives(program: bank.Textbook) -> None:
    x = program.start + 0.07 * np.arange(1, program.start.size + 1)
    y = 0.3 + np.arange(program.rows.lower.size)
    slope, bend = [], []
    for e in 1e-5 * np.eye(x.size):
        plus, minus = program.point(x + e), program.point(x - e)
        slope.append((plus.cost - minus.cost + y @ (plus.rows - minus.rows)) / 2e-5)
        change = plus.gradient - minus.gradient + y @ (plus.jacobian - minus.jacobian)
        bend.append(change / 2e-5)
    here = program.point(x)
    np.testing.assert_allclose(slope, here.gradient + y @ here.jacobian, rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(bend, program.hessian(x, y, 1.0), rtol=1e-6, atol=1e-5)


@BY_LABEL
@BY_TITLE
def test_solves(program: bank.Textbook, entry: Entry) -> None:
    solution = entry.solver.solve(program, Start(program.start))
    assert_solves(program, solution, entry)
    assert solution.history[0].iteration == 0
    assert [r.iteration for r in solution.history] == list(range(len(solution.history)))
    counts = [record.evaluations for record in solution.history]
    assert counts == sorted(counts)
    assert counts[-1] <= solution.evaluations


@pytest.mark.parametrize("entry", [ENTRIES[0], ENTRIES[4]], ids=lambda entry: entry.label)
@pytest.mark.parametrize(
    "program",
    [bank.hs7(), bank.hs43(), bank.hs71(), bank.hs76(), bank.two_sided()],
    ids=lambda program: program.title,
)
def test_solves_without_second_derivatives(program: bank.Textbook, entry: Entry) -> None:
    solution = entry.solver.solve(replace(program, has_hessian=False), Start(program.start))
    assert_solves(program, solution, entry)
    assert solution.hessians == 0


@pytest.mark.parametrize("cost_gradient_only", [False, True])
@pytest.mark.parametrize(
    "program", [bank.hs43(), bank.hs71(), bank.two_sided()], ids=lambda program: program.title
)
def test_solves_by_finite_differences(program: bank.Textbook, cost_gradient_only: bool) -> None:
    differences = FiniteDifferenceNLP(program, cost_gradient_only=cost_gradient_only)
    solution = SQP(tolerance=1e-4).solve(differences, Start(program.start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-5)
    assert differences.evaluations > program.start.size * solution.iterations


@BY_LABEL
def test_solves_what_is_degenerate(entry: Entry) -> None:
    program = bank.degenerate()
    solution = entry.solver.solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-4)
    pull = program.point(solution.x).jacobian.T @ solution.multipliers
    np.testing.assert_allclose(pull, [3.0, 0.0], atol=1e-4)  # minus the gradient of the cost


@pytest.mark.parametrize("solver", [SQP(), SQP(hessian="bfgs"), SLSQP()], ids=repr)
def test_finds_a_flat_solution(solver: Solver) -> None:
    program = bank.hs26()
    solution = solver.solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    # The cost is a fourth power there: 1e-3 in x is 1e-12 in cost.
    np.testing.assert_allclose(solution.x, program.solution, atol=5e-3)


@BY_LABEL
def test_same_run_twice(entry: Entry) -> None:
    program = bank.hs100()
    one, two = (entry.solver.solve(program, Start(program.start)) for _ in range(2))
    np.testing.assert_array_equal(one.x, two.x)
    np.testing.assert_array_equal(one.multipliers, two.multipliers)
    assert one.evaluations == two.evaluations


@BY_LABEL
def test_interruption_returns_the_best_iterate(entry: Entry) -> None:
    program, seen = bank.hs71(), []

    def stop(record: Progress) -> bool:
        seen.append(record)
        return len(seen) == 3

    solution = entry.solver.solve(program, Start(program.start), stop=stop)
    assert solution.status is Status.INTERRUPTED
    assert solution.violation == min(record.violation for record in seen)
    assert len(solution.history) == 3


@BY_LABEL
def test_start_without_a_value(entry: Entry) -> None:
    solution = entry.solver.solve(bank.undefined_region(), Start(np.array([-1.0, 2.0])))
    assert solution.status is Status.NUMERICAL
    assert np.isnan(solution.cost)
    np.testing.assert_array_equal(solution.x, [-1.0, 2.0])


@BY_LABEL
def test_iteration_limit(entry: Entry) -> None:
    if isinstance(entry.solver, TwoStageSQP):
        solver: Solver = TwoStageSQP(SQP(max_iterations=2), TrustConstr(max_iterations=2))
    else:
        solver = replace(entry.solver, max_iterations=2)
    program = bank.hs100()
    solution = solver.solve(program, Start(program.start))
    assert solution.status is Status.ITERATION_LIMIT
    # The start is feasible, hence so is the best iterate, and it costs no more.
    assert solution.violation <= 1e-6
    assert solution.cost <= program.values(program.start).cost
    assert solution.optimality > 1.0
