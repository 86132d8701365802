"""The quadratic programs of the SQP method: backends, screening of rows, multipliers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gaitopt.solvers import qp
from gaitopt.solvers.qp import (
    BACKENDS,
    QuadraticProgram,
    QuadraticSolution,
    optimality_error,
    solve_qp,
)
from gaitopt.solvers.subproblem import Subproblem, solve_subproblem


def random_program(seed: int, n: int = 8, k: int = 30) -> QuadraticProgram:
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(n, n))
    return QuadraticProgram(
        P=M @ M.T + 0.1 * np.eye(n),
        q=5.0 * rng.normal(size=n),
        G=rng.normal(size=(k, n)),
        h=rng.uniform(0.0, 0.5, size=k),
        lower=np.full(n, -0.4),
        upper=np.full(n, 0.3),
    )


def corner_program() -> QuadraticProgram:
    """min (x - 3)^2 + (y + 2)^2 with x + y <= 0.5, y >= -1.5: at the corner (2, -1.5)."""
    return QuadraticProgram(
        P=2.0 * np.eye(2),
        q=np.array([-6.0, 4.0]),
        G=np.array([[1.0, 1.0]]),
        h=np.array([0.5]),
        lower=np.array([-9.0, -1.5]),
        upper=np.array([9.0, 9.0]),
    )


def test_known_solution() -> None:
    program = corner_program()
    for backend in BACKENDS:
        solution = solve_qp(program, backend)
        assert solution is not None
        np.testing.assert_allclose(solution.x, [2.0, -1.5], atol=1e-8)
        np.testing.assert_allclose(solution.rows, [2.0], atol=1e-7)
        np.testing.assert_allclose(solution.bounds, [0.0, -3.0], atol=1e-7)


@pytest.mark.parametrize(
    ("x", "rows", "bounds", "error"),
    [
        pytest.param([2.0, -9.0], [0.0], [0.0, -3.0], 7.5, id="outside its bounds"),
        pytest.param([1.0, 0.5], [2.0], [0.0, 0.0], 1.0, id="outside its rows"),
        pytest.param([2.0, -1.5], [-2.0], [0.0, -3.0], 2 / 9, id="a row that pulls"),
        pytest.param([1.8, -1.5], [2.0], [0.0, -3.0], 0.2, id="a row that is not active"),
        pytest.param([2.0, -1.5], [2.0], [0.0, 3.0], 3 / 7, id="a bound that pulls"),
        pytest.param([2.0, -1.5], [2.0], [4.0, -3.0], 4 / 11, id="a bound that is not active"),
    ],
)
def test_a_vanishing_slope_is_not_enough(
    x: list[float], rows: list[float], bounds: list[float], error: float
) -> None:
    given = QuadraticSolution(np.array(x), np.array(rows), np.array(bounds))
    program = corner_program()
    q = -(program.P @ given.x + given.rows @ program.G + given.bounds)
    # Distances count as they are, multipliers relative to one plus the largest of q.
    assert optimality_error(replace(program, q=q), given) == pytest.approx(error, rel=1e-9)


def test_a_limit_that_does_not_exist_has_no_say() -> None:
    program = replace(corner_program(), lower=np.array([-np.inf, -1.5]), upper=np.full(2, np.inf))
    exact = QuadraticSolution(np.array([2.0, -1.5]), np.array([2.0]), np.array([0.0, -3.0]))
    assert optimality_error(program, exact) < 1e-15
    pulled = replace(exact, bounds=np.array([-7e-3, -3.0]))
    assert optimality_error(program, pulled) == pytest.approx(1e-3, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("backend", BACKENDS)
def test_backends_agree(backend: str, seed: int) -> None:
    program = random_program(seed)
    solution, reference = solve_qp(program, backend), solve_qp(program, "quadprog")
    assert solution is not None
    assert reference is not None
    np.testing.assert_allclose(solution.x, reference.x, atol=1e-7)
    np.testing.assert_allclose(solution.rows, reference.rows, atol=1e-5)
    assert optimality_error(program, solution) < 1e-8
    assert (solution.rows > 1e-3).sum() >= 2


@pytest.mark.parametrize("seed", range(6))
def test_what_is_believed_to_press_changes_no_answer(seed: int) -> None:
    """Right, wrong, at the other limit, or more than there are variables."""
    program = random_program(seed)
    found = solve_qp(program, "daqp")
    assert found is not None
    right = np.concatenate([found.bounds, found.rows])
    rng = np.random.default_rng(seed)
    guessed = rng.integers(-1, 2, right.size) * np.concatenate([np.ones(8), np.full(30, 0.5)])
    for pressing in (right, -right, np.ones(right.size), guessed, np.zeros(right.size)):
        again = solve_qp(replace(program, pressing=pressing), "daqp")
        assert again is not None
        np.testing.assert_allclose(again.x, found.x, atol=1e-9)
        np.testing.assert_allclose(again.rows, found.rows, atol=1e-7)
        np.testing.assert_allclose(again.bounds, found.bounds, atol=1e-7)


def test_wrong_answer_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    program, asked, honest = random_program(7), [], qp._ask

    def lying(given: QuadraticProgram, backend: str) -> qp.QuadraticSolution | None:
        asked.append(backend)
        solution = honest(given, backend)
        assert solution is not None
        return replace(solution, x=solution.x + 1e-3) if backend == "daqp" else solution

    monkeypatch.setattr(qp, "_ask", lying)
    solution = solve_qp(program, "daqp")
    assert asked == ["daqp", "quadprog"]
    assert solution is not None
    assert optimality_error(program, solution) < 1e-9


def test_no_backend_no_answer() -> None:
    program = replace(random_program(3), h=np.full(30, -9.0))  # incompatible
    assert solve_qp(program, "daqp") is None


def subproblem(seed: int) -> Subproblem:
    rng = np.random.default_rng(seed)
    n, m = 6, 200
    M = rng.normal(size=(n + 1, n + 1))
    value = rng.uniform(-1.0, 1.0, size=m)
    return Subproblem(
        gradient=np.append(3.0 * rng.normal(size=n), 1000.0),
        hessian=M @ M.T + np.eye(n + 1),
        jacobian=rng.normal(size=(m, n)),
        below=-1.05 - value,
        above=1.05 - value,
        box_lower=np.full(n, -0.5),
        box_upper=np.full(n, 0.5),
        use_below=np.zeros(m, dtype=bool),
        use_above=np.zeros(m, dtype=bool),
    )


@pytest.mark.parametrize("seed", range(4))
def test_rows_left_out_do_not_change_the_step(seed: int) -> None:
    screened = subproblem(seed)
    whole = replace(
        screened,
        use_below=np.ones_like(screened.use_below),
        use_above=np.ones_like(screened.use_above),
    )
    few, all_rows = solve_subproblem(screened, "daqp"), solve_subproblem(whole, "daqp")
    assert few is not None
    assert all_rows is not None
    np.testing.assert_allclose(few.d, all_rows.d, atol=1e-8)
    np.testing.assert_allclose(few.multipliers, all_rows.multipliers, atol=1e-5)
    assert np.abs(few.multipliers).sum() > 0.1
    assert few.use_above.sum() + few.use_below.sum() < 200


def test_slack_is_the_violation_left() -> None:
    posed = replace(subproblem(1), above=np.full(200, -2.0), below=np.full(200, -np.inf))
    step = solve_subproblem(posed, "daqp")
    assert step is not None
    left = (posed.jacobian @ step.d - posed.above).max()
    assert step.slack == pytest.approx(left, rel=1e-6)
    assert step.slack > 1.0
    assert step.multipliers.min() >= 0.0


def test_a_matrix_that_is_not_definite_is_not_tried(monkeypatch) -> None:
    program = replace(random_program(0), P=np.diag([1e15, *[1.0] * 6, -0.7]))
    monkeypatch.setattr(qp, "_ask", lambda *_: pytest.fail("a backend was asked"))
    assert solve_qp(program, "daqp") is None


@pytest.mark.parametrize(("limit", "asked"), [(1e5, BACKENDS), (1e8, BACKENDS[:2]), (1e18, ())])
def test_limits_beyond_what_a_backend_can_tell_are_not_given_to_it(monkeypatch, limit, asked):
    """A row broken by 1e9: rounding of the row is above the tolerance that a backend stops at."""
    tried = []
    monkeypatch.setattr(qp, "_ask", lambda _, backend: tried.append(backend))
    assert solve_qp(replace(corner_program(), h=np.array([-limit])), "daqp") is None
    assert tuple(tried) == asked
