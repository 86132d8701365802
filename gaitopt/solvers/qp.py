"""One convex quadratic program, solved by the first backend whose answer stands a check.

    minimise    1/2 x'P x + q'x
    subject to  G x <= h,  lower <= x <= upper

An active-set code may return a wrong step without a word when P is ill-conditioned, so every
answer is judged by its own optimality conditions before it is believed.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.nlp import Array

BACKENDS = ("daqp", "quadprog", "proxqp")
"""In order of speed on these programs: about 1, 2 and 8 ms with 44 variables and 400 rows."""
TRUSTED = 1e-9
"""Relative optimality error below which an answer is taken without asking another backend."""
TOLERABLE = 1e-4
"""Relative optimality error above which an answer is not used at all."""
LARGEST = 1e12
"""Size of limits beyond which rounding alone makes every answer an error above `TOLERABLE`."""
_OPTIONS: dict[str, dict[str, Any]] = {
    "daqp": {"iter_limit": 1000, "primal_tol": 1e-10, "dual_tol": 1e-12},
    "quadprog": {},
    # Its inner iterations cannot be limited: where it fails, more outer ones take minutes.
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0, "max_iter": 30},
}
_LARGEST_OF = {"proxqp": 1e6}  # from which on rounding of limits keeps it from its eps_abs
_DAQP_INFINITY = 1e30  # from which on a limit is none
_DAQP_LOWER = 2  # of what is given to begin with: at its lower limit


@dataclass(frozen=True)
class QuadraticProgram:
    """Data of the program: P (n, n) positive definite, q (n,), G (k, n), h (k,), bounds (n,).

    Attributes:
        P, q, G, h, lower, upper: as above.
        pressing: what is believed to hold with equality at the solution, shape (n + k,), of bounds
            and then of rows: above zero at upper limits, below at lower ones, 0 elsewhere; None
            where nothing is known.
    """

    P: Array
    q: Array
    G: Array
    h: Array
    lower: Array
    upper: Array
    pressing: Array | None = None


@dataclass(frozen=True)
class QuadraticSolution:
    """The minimiser and its multipliers.

    Attributes:
        x: shape (n,).
        rows: multipliers of G x <= h, shape (k,), not negative.
        bounds: multipliers of the bounds, shape (n,), positive at an upper one.
    """

    x: Array
    rows: Array
    bounds: Array


def solve_qp(program: QuadraticProgram, preferred: str) -> QuadraticSolution | None:
    """Solve a convex quadratic program.

    Args:
        preferred: backend asked first; the others follow in the order of `BACKENDS`.

    Returns:
        The solution, or None when no backend found one.
    """
    best, least = None, TOLERABLE
    size = np.abs(program.h).max(initial=0.0)
    if not size <= LARGEST or cholesky(program.P) is None:
        return None
    for backend in (preferred, *(b for b in BACKENDS if b != preferred)):
        if size > _LARGEST_OF.get(backend, LARGEST):
            continue
        solution = _ask(program, backend)
        error = np.inf if solution is None else optimality_error(program, solution)
        if error <= least:
            best, least = solution, error
        if least <= TRUSTED:
            break
    return best


def optimality_error(program: QuadraticProgram, solution: QuadraticSolution) -> float:
    """Return the largest violation of the optimality conditions.

    Gradient and multipliers count relative to the terms of the gradient, distances from limits as
    they are. The lesser of a limit's multiplier and distance must vanish (the natural residual of
    complementarity): distances outside the limit and multipliers of the wrong sign are negative.
    """
    x, rows, bounds = solution.x, solution.rows, solution.bounds
    of_rows = rows @ program.G
    gradient = program.P @ x + program.q + of_rows + bounds
    size = 1.0 + max(np.abs(program.q).max(), np.abs(of_rows).max(initial=0.0))
    error = max(
        float(np.abs(gradient).max()) / size,
        _mismatch(rows / size, program.h - program.G @ x),
        _mismatch(np.maximum(bounds, 0.0) / size, program.upper - x),
        _mismatch(np.maximum(-bounds, 0.0) / size, x - program.lower),
    )
    return error if np.isfinite(error) else np.inf


def _mismatch(multipliers: Array, distances: Array) -> float:
    return float(np.abs(np.minimum(multipliers, distances)).max(initial=0.0))


def cholesky(matrix: Array) -> Array | None:
    """Return the Cholesky factor of a matrix (n, n), None where it is not positive definite."""
    try:
        return np.asarray(np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError:
        return None


def _ask(program: QuadraticProgram, backend: str) -> QuadraticSolution | None:
    return _daqp(program) if backend == "daqp" else _through_qpsolvers(program, backend)


def _daqp(program: QuadraticProgram) -> QuadraticSolution | None:
    """Ask DAQP itself: qpsolvers brings SciPy, which takes longer to import than most answers."""
    import daqp

    n, m = program.q.size, program.h.size
    upper = np.concatenate([program.upper, program.h])
    lower = np.concatenate([program.lower, np.full(m, -_DAQP_INFINITY)])
    np.minimum(upper, _DAQP_INFINITY, out=upper)
    np.maximum(lower, -_DAQP_INFINITY, out=lower)
    begins = [np.zeros(n + m, dtype=np.intc)]
    if (known := program.pressing) is not None:  # which may be no set to begin with
        begins.insert(0, np.where(known < 0.0, 1 + _DAQP_LOWER, known > 0.0).astype(np.intc))
    for begin in begins:
        x, _, flag, info = daqp.solve(
            np.ascontiguousarray(program.P), program.q, program.G, upper, lower, begin,
            **_OPTIONS["daqp"],
        )  # fmt: skip
        if flag > 0:
            multipliers = np.asarray(info["lam"])
            rows = np.maximum(multipliers[n:], 0.0)
            return QuadraticSolution(np.asarray(x), rows, multipliers[:n])
    return None


def _through_qpsolvers(program: QuadraticProgram, backend: str) -> QuadraticSolution | None:
    import qpsolvers

    problem = qpsolvers.Problem(
        program.P, program.q, program.G, program.h, lb=program.lower, ub=program.upper
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a failure is told by the return value
        try:
            found = qpsolvers.solve_problem(problem, solver=backend, **_OPTIONS[backend])
        except (qpsolvers.exceptions.QPError, ValueError):
            return None
    if not found.found or found.x is None or found.z is None or found.z_box is None:
        return None
    return QuadraticSolution(found.x, np.maximum(found.z, 0.0), found.z_box)
