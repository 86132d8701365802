"""The parts of the SQP method, each against its definition."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import textbook_programs as bank
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gaitopt.nlp import Rows, Start
from gaitopt.solvers import SQP
from gaitopt.solvers.adapters import Evaluator
from gaitopt.solvers.globalization import (
    MARGIN,
    NEARLY_FEASIBLE,
    Filter,
    Patience,
    TrustRegion,
    agreement,
    improves,
)
from gaitopt.solvers.hessian import LEAST, convexify, damped_bfgs
from gaitopt.solvers.multipliers import bounds_pressing
from gaitopt.solvers.solver import Recorder, make_iterate, with_least_squares_multipliers
from gaitopt.solvers.subproblem import build_model, hold, pose_subproblem, solve_subproblem
from gaitopt.tolerances import FEASIBLE

SEEDS = st.integers(0, 10_000)
FAST = settings(derandomize=True, deadline=None, max_examples=50)


def equality_solution(
    H: np.ndarray, g: np.ndarray, A: np.ndarray, b: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Solve min g'd + d'Hd/2 with A d = b by its KKT matrix (Nocedal & Wright, Eq. 16.4)."""
    k = A.shape[0]
    K = np.block([[H, A.T], [A, np.zeros((k, k))]])
    solution = np.linalg.solve(K, np.concatenate([-g, b]))
    return solution[: g.size], solution[g.size :]


@FAST
@given(SEEDS, st.integers(0, 6))
def test_convex_model_keeps_step_and_multipliers(seed: int, k: int) -> None:
    rng = np.random.default_rng(seed)
    n = 6
    A, b, g = rng.normal(size=(k, n)), rng.normal(size=k), rng.normal(size=n)
    H = rng.normal(size=(n, n))
    H = H + H.T
    if k:
        # Convex where the step is free, indefinite elsewhere: as at a strict minimiser.
        Z = np.linalg.svd(A)[2][k:].T
        H += Z @ ((np.abs(np.linalg.eigvalsh(H)).max() + 1.0) * np.eye(n - k)) @ Z.T
    else:
        H = H @ H + np.eye(n)
    model = convexify(H, A)
    assert np.linalg.eigvalsh(model.matrix)[0] >= 0.9 * LEAST
    d, y = equality_solution(H, g, A, b)
    d_model, y_model = equality_solution(model.matrix, g + model.linear_term(b, np.inf), A, b)
    np.testing.assert_allclose(d_model, d, atol=1e-7 * (1.0 + np.abs(d).max()))
    np.testing.assert_allclose(
        y_model, y, atol=1e-5 * (1.0 + model.sigma + np.abs(y).max(initial=0.0))
    )


@FAST
@given(SEEDS)
def test_bounded_convex_model_keeps_the_step(seed: int) -> None:
    """Little curvature where the step is free, much in common with where it is not."""
    rng = np.random.default_rng(seed)
    n, k, most = 7, 3, 1e3
    A, b, g = rng.normal(size=(k, n)), rng.normal(size=k), rng.normal(size=n)
    Q1, Q2 = np.split(np.linalg.svd(A)[2].T, [k], axis=1)
    mixed = 100.0 * Q1 @ rng.normal(size=(k, n - k)) @ Q2.T
    H = mixed + mixed.T + 1e-3 * Q2 @ Q2.T
    assert convexify(H, A).sigma > 1e5
    model = convexify(H, A, most)
    eigenvalues = np.linalg.eigvalsh(model.matrix)
    assert eigenvalues[0] >= 0.9 * LEAST
    assert eigenvalues[-1] <= 2.0 * most
    d, y = equality_solution(H, g, A, b)
    d_model, y_model = equality_solution(model.matrix, g + model.linear_term(b, np.inf), A, b)
    np.testing.assert_allclose(d_model, d, atol=1e-6 * np.abs(d).max())
    assert model.at_known is not None
    left = (
        model.range_space @ model.at_known.T @ d
    )  # what is not taken along the free part of the step
    np.testing.assert_allclose(A.T @ (y_model - y), left, atol=1e-6 * np.abs(y).max())


@FAST
@given(SEEDS)
def test_convex_model_of_dependent_rows(seed: int) -> None:
    rng = np.random.default_rng(seed)
    H = rng.normal(size=(5, 5))
    row = rng.normal(size=(1, 5))
    model = convexify(H + H.T, np.vstack([row, 2.0 * row, row]))
    assert model.range_space.shape == (5, 1)
    assert np.linalg.eigvalsh(model.matrix)[0] >= 0.9 * LEAST


def test_free_directions_get_the_absolute_curvature() -> None:
    model = convexify(np.diag([3.0, -2.0, -5.0]), np.array([[0.0, 0.0, 4.0]]))
    np.testing.assert_allclose(model.matrix, np.diag([3.0, 2.0, LEAST]), atol=1e-12)
    assert model.sigma == pytest.approx(5.0 + LEAST)
    np.testing.assert_allclose(
        model.linear_term(np.array([2.0]), np.inf), [0, 0, -0.5 * model.sigma]
    )
    np.testing.assert_allclose(model.linear_term(np.array([2.0]), 0.1), [0, 0, -0.1 * model.sigma])


@FAST
@given(SEEDS)
def test_rows_held_give_the_step_of_the_quadratic_program(seed: int) -> None:
    program, x, guess = near_limits(seed)
    iterate = make_iterate(program, program.point(x), *guess)
    hessian = scaled_hessian(program, x, iterate.multipliers)
    model = build_model(program, iterate, hessian, True, 1e4, tight=True)
    step = solve_subproblem(pose_subproblem(model, 1e3, 1e4, 1e3), "quadprog")
    held = hold(program, iterate, hessian, 1e4, every=True)
    assert step is not None
    assume(held is not None)
    assert held is not None
    np.testing.assert_allclose(held.step.d, step.d, atol=1e-6)
    np.testing.assert_allclose(held.step.multipliers, step.multipliers, atol=1e-4)
    np.testing.assert_allclose(held.step.box_multipliers, step.box_multipliers, atol=1e-4)
    np.testing.assert_allclose(held.step.change, step.change, atol=1e-6)
    assert held.predicted_decrease(step.d) == pytest.approx(model.predicted_decrease(step.d))
    pressing = held.step.multipliers, held.step.box_multipliers / program.variables.scale
    left = make_iterate(program, iterate.point, *pressing).residual.stationarity
    assert held.residual == pytest.approx(left, rel=1e-6, abs=1e-9)


def test_rows_are_let_go_and_held_as_the_step_asks() -> None:
    found = []
    for seed in range(50):
        program, x, guess = near_limits(seed)
        iterate = make_iterate(program, program.point(x), *guess)
        hessian = scaled_hessian(program, x, iterate.multipliers)
        held = hold(program, iterate, hessian, 1e4, every=True)
        found.append(held is not None)
        if held is not None:
            assert hold(program, iterate, hessian, 1e-9, every=True) is None  # slack is cheaper
        free = make_iterate(program, program.point(x), np.zeros(9), np.zeros(6))
        assert hold(program, free, -hessian, 1e4, every=True) is None  # a maximum
    assert sum(found) >= 40


@pytest.mark.parametrize("program", [bank.hs71(), bank.hs15(), bank.hs76()])
def test_bounds_press_as_the_rows_multipliers_say(program: bank.Textbook) -> None:
    solution = program.point(program.solution)
    found = bounds_pressing(program, solution, program.multipliers)
    np.testing.assert_allclose(found, program.bound_multipliers, atol=1e-5)
    assert not bounds_pressing(program, solution, np.zeros(solution.rows.size)).any()


def scaled_hessian(program: bank.Textbook, x: np.ndarray, multipliers: np.ndarray) -> np.ndarray:
    scale = program.variables.scale
    return program.hessian(x, multipliers, 1.0) * np.outer(scale, scale)


def near_limits(seed: int) -> tuple[bank.Textbook, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Return a convex program in 6 variables, 9 rows, a start, and guessed multipliers.

    Those are of the solution of a program that is a little different.
    """
    rng, n, m = np.random.default_rng(seed), 6, 9
    root, A, g = rng.normal(size=(n, n)), rng.normal(size=(m, n)), rng.normal(size=n)
    H, upper = root @ root.T + 0.1 * np.eye(n), 0.2 * rng.random(m)
    scale = rng.uniform(0.5, 2.0, n).tolist()

    def program(g: np.ndarray) -> bank.Textbook:
        return bank.Textbook(
            "a quadratic program", np.zeros(n), lambda x: g @ x + 0.5 * x @ H @ x,
            lambda x: g + H @ x, lambda _: H, lambda x: A @ x, lambda _: A,
            lambda _: [np.zeros((n, n))] * m, bank.box([-0.3] * n, [0.3] * n, scale),
            Rows(np.full(m, -0.1), upper), np.zeros(n), 0.0, np.zeros(m), np.zeros(n),
        )  # fmt: skip

    known = SQP().solve(program(g + 0.3 * rng.normal(size=n)), Start(np.zeros(n)))
    return program(g), known.x, (known.multipliers, known.bound_multipliers)


def test_filter_by_hand() -> None:
    entries = Filter(ceiling=10.0)
    entries.add(1.0, 5.0)
    entries.add(0.1, 7.0)
    assert entries.accepts(0.5, 6.0)  # less violation than the one, less cost than the other
    assert not entries.accepts(0.5, 7.5)
    assert not entries.accepts(11.0, 0.0)
    entries.add(0.05, 4.0)  # dominates both
    assert entries.entries == [(0.05, 4.0)]


def test_betterment_has_a_margin() -> None:
    assert not improves((1.0 - 0.5 * MARGIN) * 2.0, 3.0, 2.0, 3.0)
    assert improves((1.0 - 2.0 * MARGIN) * 2.0, 3.0, 2.0, 3.0)
    assert not improves(2.0, 3.0 - MARGIN, 2.0, 3.0)
    assert improves(2.0, 3.0 - 3.0 * MARGIN, 2.0, 3.0)
    assert improves(0.0, 3.0 + 1e-13, 0.0, 3.0, noise=1e-12)


def test_region_grows_only_if_it_held_a_good_step() -> None:
    region = TrustRegion(0.4, largest=0.7)
    assert region.after(0.9, 0.4).radius == 0.7
    assert region.after(0.9, 0.2) == region
    assert region.after(0.5, 0.4) == region
    assert region.after(0.1, 0.2).radius == pytest.approx(0.05)
    assert region.shrunk(9.0).radius == pytest.approx(0.1)


def test_a_region_grows_only_if_it_may() -> None:
    region = TrustRegion(0.4, 0.7)
    assert region.after(0.9, 0.4, may_grow=False) == region


def test_patience_ends_when_the_violation_no_longer_falls() -> None:
    patience = Patience(3)
    assert not any(patience.exhausted(v) for v in (1.0, 0.95, 0.8, 0.79, 0.78))
    assert patience.exhausted(0.77)
    assert patience.least == 0.8


def test_patience_is_endless_near_the_limits() -> None:
    patience = Patience(3)
    assert not any(patience.exhausted(0.5 * NEARLY_FEASIBLE) for _ in range(20))


def test_agreement_of_rounding_errors_is_one() -> None:
    assert agreement(-1e-16, 1e-16, rounding=1e-12) == pytest.approx(1.0, abs=1e-3)
    assert agreement(0.3, 0.4, rounding=1e-12) == pytest.approx(0.75)


@FAST
@given(SEEDS, st.booleans())
def test_bfgs_stays_positive_definite(seed: int, convex: bool) -> None:
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(4, 4))
    B = M @ M.T + 0.5 * np.eye(4)
    s = rng.normal(size=4)
    # Along a convex direction the secant equation holds; elsewhere Powell's damping keeps a fifth.
    y = 3.0 * B @ s if convex else rng.normal(size=4) - 2.0 * B @ s
    updated = damped_bfgs(B, s, y)
    assert np.linalg.eigvalsh(updated)[0] > 0.0
    if convex:
        np.testing.assert_allclose(updated @ s, y, rtol=1e-9)
    elif s @ y < 0.2 * s @ B @ s:
        assert s @ updated @ s == pytest.approx(0.2 * s @ B @ s, rel=1e-9)


def test_of_iterates_that_cost_the_same_the_nearest_to_optimality_is_kept() -> None:
    program = bank.hs15()
    end = with_least_squares_multipliers(program, program.point(program.solution))
    x = program.solution - 1e-10 * end.point.gradient  # cheaper, for it exceeds the limits a little
    none = np.zeros(program.rows.lower.size), np.zeros(x.size)
    beyond = make_iterate(program, program.point(x), *none)
    assert 0.0 < beyond.violation <= FEASIBLE
    assert beyond.point.cost < end.point.cost
    assert beyond.residual.worst > 1e3 * end.residual.worst
    dearer = replace(end, point=replace(end.point, cost=1.001 * end.point.cost))
    for order in itertools.permutations((end, beyond, dearer)):
        recorder = Recorder("any", Evaluator(program))
        for iterate in order:
            recorder.keep(iterate)
        assert recorder.best is end
