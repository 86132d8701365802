"""Newton's method confirms strict minima, and nothing else; least squares without SciPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import textbook_programs as bank
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import nnls

from gaitopt.nlp import Array, Progress, Start, Status
from gaitopt.solvers.multipliers import nonnegative_least_squares
from gaitopt.solvers.newton import Newton, is_strict_minimum
from gaitopt.solvers.solver import Iterate, with_least_squares_multipliers
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.trust_constr import TrustConstr
from gaitopt.solvers.two_stage import ConfirmedSQP

REGULAR = [program for program in bank.SOLVABLE if program.title != "HS26"]
"""Strict minima; the curvature of the other one vanishes at its solution."""


@pytest.mark.parametrize("program", REGULAR, ids=lambda program: program.title)
def test_comes_back_to_a_minimum_quadratically(program: bank.Textbook) -> None:
    first = SQP(tolerance=1e-9).solve(program, Start(program.start))
    assert first.status is Status.OPTIMAL
    found = Newton().solve(program, Start(first.x))
    assert found.status is Status.OPTIMAL
    assert found.iterations >= 1
    np.testing.assert_allclose(found.x, program.solution, atol=1e-6)


def test_a_saddle_is_not_confirmed() -> None:
    saddle = replace(
        bank.rosenbrock_in_disk(),
        cost=lambda x: -float(x @ x),
        gradient=lambda x: -2.0 * x,
        curvature=lambda x: -2.0 * np.eye(x.size),
    )
    found = Newton().solve(saddle, Start(np.zeros(2)))  # the gradient vanishes there
    assert found.status is Status.STALLED
    assert found.iterations == 0
    at_saddle = with_least_squares_multipliers(saddle, saddle.point(np.zeros(2)))
    assert not is_strict_minimum(saddle, at_saddle, -2.0 * np.eye(2))
    assert is_strict_minimum(saddle, at_saddle, 2.0 * np.eye(2))


@pytest.mark.parametrize("program", REGULAR, ids=lambda program: program.title)
def test_rows_that_press_make_a_minimum_strict(program: bank.Textbook) -> None:
    """At the solution the Hessian is positive along the rows that press, not everywhere."""
    found = SQP(tolerance=1e-9).solve(program, Start(program.start))
    solution = with_least_squares_multipliers(program, program.point(found.x))
    scale = program.variables.scale
    hessian = program.hessian(found.x, solution.multipliers, program.cost_scale)
    hessian = hessian * np.outer(scale, scale)
    assert is_strict_minimum(program, solution, hessian)
    assert not is_strict_minimum(program, solution, hessian - 1e4 * np.eye(scale.size)) or (
        np.linalg.matrix_rank(pressing(program, solution)) == scale.size
    )


def pressing(program: bank.Textbook, solution: Iterate) -> Array:
    """Gradients of the rows and bounds with multipliers."""
    rows = np.abs(solution.multipliers) > 1e-6
    bounds = np.abs(solution.bound_multipliers) > 1e-6
    equal = program.rows.lower == program.rows.upper
    return np.vstack([solution.point.jacobian[rows | equal], np.eye(bounds.size)[bounds]])


@pytest.mark.parametrize("program", REGULAR, ids=lambda program: program.title)
def test_default_confirms_and_tells(program: bank.Textbook) -> None:
    told: list[Progress] = []
    both = ConfirmedSQP().solve(program, Start(program.start), told.append)
    assert both.solver == "sqp+newton"
    assert both.status is Status.OPTIMAL
    assert both.history == tuple(told)
    assert [one.iteration for one in told] == list(range(len(told)))


def test_where_newton_stops_the_interior_point_method_has_its_say() -> None:
    program = bank.hs43()
    solver = ConfirmedSQP(SQP(max_iterations=2))
    solution = solver.solve(program, Start(program.start))
    assert solution.status is Status.OPTIMAL
    assert solution.solver == "trust-constr (after sqp)"


def test_a_limit_touched_at_one_of_three_instants_close_together_is_confirmed() -> None:
    """It is 8e-7 away at the two beside, at which least squares would press on it as well."""
    instants = np.array([-9e-4, 0.0, 9e-4])
    gradients = np.column_stack([np.ones(3), instants])
    program = bank.Textbook(
        title="a parabola below a limit",
        start=bank.array(0.9, 0.1),
        cost=lambda x: (x[0] - 3.0) ** 2 + 1e-2 * x[1] ** 2,
        gradient=lambda x: bank.array(2.0 * (x[0] - 3.0), 2e-2 * x[1]),
        curvature=lambda x: np.diag([2.0, 2e-2]),
        value=lambda x: gradients @ x - instants**2,
        jacobian=lambda x: gradients,
        row_curvatures=lambda x: [np.zeros((2, 2))] * 3,
        variables=bank.free(2),
        rows=bank.limits([-np.inf] * 3, [1.0] * 3),
        solution=bank.array(1.0, 0.0),
        best=4.0,
        multipliers=bank.array(0.0, 4.0, 0.0),
        bound_multipliers=np.zeros(2),
    )
    found = Newton().solve(program, Start(program.solution + 1e-9))
    assert found.status is Status.OPTIMAL
    np.testing.assert_allclose(found.x, program.solution, atol=1e-12)
    np.testing.assert_allclose(found.multipliers, program.multipliers, atol=1e-12)
    assert ConfirmedSQP().solve(program, Start(program.start)).solver == "sqp+newton"
    solution = Start(program.solution, program.multipliers)
    assert TrustConstr().solve(program, solution).status is Status.OPTIMAL


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.integers(0, 10_000), st.integers(1, 12), st.booleans())
def test_least_squares_are_those_of_scipy(seed: int, count: int, alike: bool) -> None:
    rng = np.random.default_rng(seed)
    A, b = rng.normal(size=(8, count)), rng.normal(size=8)
    if alike and count > 1:  # as a limit that is held at two instants close together
        A[:, 1] = A[:, 0] + 1e-9 * rng.normal(size=8)
    A /= np.linalg.norm(A, axis=0)
    x, least = nonnegative_least_squares(A, b), nnls(A, b)[1]
    assert x.min() >= 0.0
    assert np.linalg.norm(A @ x - b) <= least + 1e-9


@settings(derandomize=True, deadline=None, max_examples=100)
@given(st.integers(0, 10_000))
def test_a_small_difference_that_is_needed_is_found(seed: int) -> None:
    """As where a limit presses between two instants close together."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(20, 8))
    A /= np.linalg.norm(A, axis=0)
    A[:, 1] = A[:, 0] + 1e-8 * rng.normal(size=20)
    size = rng.uniform(1.0, 40.0, size=8) * (rng.random(8) < 0.8)
    size[:2] = rng.uniform(10.0, 40.0, size=2)
    x = nonnegative_least_squares(A, A @ size)
    assert x.min() >= 0.0
    assert np.abs(A @ (x - size)).max() <= 1e-11
