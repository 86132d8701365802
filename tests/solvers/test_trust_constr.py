"""SciPy's interior point method as wrapped, and the two stages together."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
import textbook_programs as bank

from gaitopt.errors import EvaluationError
from gaitopt.nlp import Array, Start, Status
from gaitopt.solvers import SQP, TrustConstr, TwoStageSQP
from gaitopt.solvers.trust_constr import missed_rows, nearest_rows, working_set_of


def many_sided_disk(m: int = 60) -> bank.Textbook:
    """Nearest point to (1, 2) in a polygon of m sides around the unit disk."""
    angle = 2.0 * np.pi * np.arange(m) / m
    sides = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    slope = np.array([-1.0, -2.0])
    order = np.argsort(sides @ slope)[:2]  # the corner lies between the two steepest sides
    corner = np.linalg.solve(sides[order], np.ones(2))
    multipliers = np.zeros(m)
    multipliers[order] = np.linalg.solve(sides[order].T, -slope - corner)
    return bank.Textbook(
        title="polygon",
        start=np.array([-0.5, 0.1]),
        cost=lambda x: slope @ x + 0.5 * x @ x,
        gradient=lambda x: slope + x,
        curvature=lambda x: np.eye(2),
        value=lambda x: sides @ x,
        jacobian=lambda x: sides,
        row_curvatures=lambda x: [np.zeros((2, 2))] * m,
        variables=bank.free(2),
        rows=bank.limits([-np.inf] * m, [1.0] * m),
        solution=corner,
        best=float(slope @ corner + 0.5 * corner @ corner),
        multipliers=multipliers,
        bound_multipliers=np.zeros(2),
    )


def test_rows_not_given_are_found_when_violated() -> None:
    program = many_sided_disk()
    solver = TrustConstr(rows_kept=5, tolerance=1e-9)
    solution = solver.solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-5)
    np.testing.assert_allclose(solution.multipliers, program.multipliers, atol=1e-4)


def test_nearest_rows_are_chosen() -> None:
    program = many_sided_disk(8)  # sides at 0, 45, 90 ... degrees
    point = program.point(np.array([0.9, 0.2]))
    choice = nearest_rows(program, point, np.eye(8)[5], 2)
    np.testing.assert_array_equal(choice.rows, [0, 5])
    outside = program.point(np.array([0.0, 1.2]))
    np.testing.assert_array_equal(missed_rows(program, outside, choice, 1e-8), [2])


def test_held_rows_are_equalities_at_the_limit_their_multiplier_tells() -> None:
    program = bank.two_sided()
    choice = working_set_of(program, program.multipliers, program.bound_multipliers)
    np.testing.assert_array_equal(choice.rows, [0])
    np.testing.assert_array_equal(choice.bounds, [2])
    np.testing.assert_array_equal(choice.row_limits, [[1.0], [1.0]])
    np.testing.assert_array_equal(choice.bound_limits, [[-2.0], [-2.0]])


@pytest.mark.parametrize("program", bank.SOLVABLE, ids=lambda program: program.title)
def test_confirms_a_solution_in_few_iterations(program: bank.Textbook) -> None:
    answer = SQP().solve(program, Start(program.start))
    solution = TrustConstr().solve(program, Start(answer.x, answer.multipliers))
    assert solution.status is Status.OPTIMAL
    assert solution.iterations <= 9
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-6)


def test_held_rows_may_depend_on_each_other(capfd: pytest.CaptureFixture[str]) -> None:
    corner = many_sided_disk()
    rows = np.tile(np.arange(60), 5)  # every side five times
    program = replace(
        corner,
        value=lambda x: corner.value(x)[rows],
        jacobian=lambda x: corner.jacobian(x)[rows],
        row_curvatures=lambda x: [np.zeros((2, 2))] * rows.size,
        rows=bank.limits([-np.inf] * rows.size, [1.0] * rows.size),
        multipliers=corner.multipliers[rows] / 5.0,
    )
    solver = TrustConstr(tolerance=1e-9)
    near = Start(program.solution + 1e-9, program.multipliers, program.bound_multipliers)
    solution = solver.solve(program, near)
    assert solution.status is Status.OPTIMAL
    assert capfd.readouterr() == ("", "")


def test_wrong_multipliers_are_put_right() -> None:
    program = bank.hs43()
    wrong = np.array([0.0, 5.0, 0.0])  # the row that is not active
    solution = TrustConstr().solve(program, Start(program.start, wrong))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-5)
    np.testing.assert_allclose(solution.multipliers, program.multipliers, atol=1e-5)


@pytest.mark.parametrize("limit", [3, 25])
def test_confirming_counts_towards_the_iteration_limit(limit: int) -> None:
    program = bank.hs43()
    wrong = np.array([0.0, 5.0, 0.0])
    solution = TrustConstr(max_iterations=limit).solve(program, Start(program.start, wrong))
    assert solution.status is Status.ITERATION_LIMIT
    assert len(solution.history) == limit


OTHER_OPTIONS = {
    "tolerance": 1e-2,
    "feasibility": 1e-3,
    "max_iterations": 4,
    "rows_kept": 2,
    "row_scale": 2.0,
    "initial_radius": 0.01,
}


@pytest.mark.parametrize("option", [field.name for field in fields(TrustConstr)])
def test_every_option_has_an_effect(option: str) -> None:
    usual = TrustConstr(rows_kept=1)
    other = replace(usual, **{option: OTHER_OPTIONS[option]})

    def differ(program: bank.Textbook) -> bool:
        start = Start(program.start, np.zeros_like(program.multipliers))
        one, two = (solver.solve(program, start) for solver in (usual, other))
        return not np.array_equal(one.x, two.x)

    assert any(differ(program) for program in (bank.hs7(), many_sided_disk()))


def test_steps_over_the_edge_are_taken_back() -> None:
    program, seen = bank.undefined_region(), []

    def cost(x: Array) -> float:
        seen.append(x.min())
        if x.min() <= 0.0:
            raise EvaluationError("outside")
        return program.cost(x)

    solver = TrustConstr(initial_radius=8.0)
    solution = solver.solve(replace(program, cost=cost), Start(np.array([0.1, 0.1])))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-4)


def test_two_stages_tell_their_story() -> None:
    program, told = bank.hs100(), []
    first = SQP().solve(program, Start(program.start))
    both = TwoStageSQP().solve(program, Start(program.start), told.append)
    assert both.solver == "sqp+trust-constr"
    assert both.status is Status.OPTIMAL
    assert both.history == tuple(told)
    assert both.history[len(first.history)].iteration == len(first.history)
    assert both.iterations > first.iterations
    assert both.evaluations > first.evaluations
    seconds = [record.seconds for record in both.history]
    assert seconds == sorted(seconds)


def test_answer_that_is_not_confirmed_says_so() -> None:
    program = bank.hs100()
    solver = TwoStageSQP(SQP(max_iterations=3), TrustConstr(max_iterations=1))
    solution = solver.solve(program, Start(program.start))
    assert solution.status is not Status.OPTIMAL
    assert solution.solver != "sqp+trust-constr"


def test_infeasible_program_needs_no_certificate() -> None:
    program = bank.infeasible()
    solution = TwoStageSQP().solve(program, Start(program.start))
    assert solution.status is Status.INFEASIBLE
    assert solution.solver == "sqp (not confirmed by trust-constr)"


def test_interior_point_repairs_what_the_first_left_undone() -> None:
    program = bank.hs43()
    solver = TwoStageSQP(SQP(max_iterations=2), TrustConstr())
    solution = solver.solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    assert solution.solver == "trust-constr (after sqp)"
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-5)
