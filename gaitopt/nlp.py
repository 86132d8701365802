"""The narrow waist between walking and optimisation: a nonlinear program and its solution.

    minimise    cost(x)
    subject to  variables.lower <= x       <= variables.upper
                rows.lower      <= rows(x) <= rows.upper

Rows are scaled so that one unit of each matters about as much as one of another. The Lagrangian is

    L(x, y, z) = cost_scale * cost(x) + y . rows(x) + z . x

with y, z > 0 at an upper limit, < 0 at a lower one, 0 elsewhere. Nothing here knows robots.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import Enum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class Variables:
    """The unknowns.

    Attributes:
        names: one per variable.
        lower, upper: bounds, shape (n,); infinite where there is none.
        scale: typical size of a sensible step of each variable, shape (n,), positive.
    """

    names: tuple[str, ...]
    lower: Array
    upper: Array
    scale: Array


@dataclass(frozen=True)
class Rows:
    """The limits of the constraint rows, shape (m,), scaled; equal where a row is an equality.

    Attributes:
        lower, upper: limits, infinite where there is none.
    """

    lower: Array
    upper: Array


@dataclass(frozen=True)
class Values:
    """Cost and scaled rows (m,) at x (n,).

    Attributes:
        x: parameters.
        cost: in its own unit.
        rows: scaled.
    """

    x: Array
    cost: float
    rows: Array


class Slopes(Protocol):
    """A Jacobian (m, n) that can give some rows, and a product, without being a table."""

    def __getitem__(self, rows: Indices, /) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, n)."""

    def __matmul__(self, step: Array, /) -> Array:
        """Return the change of all rows along a step (n,), shape (m,)."""


@dataclass(frozen=True)
class Point(Values):
    """Values with their exact first derivatives: gradient (n,) of the cost, jacobian (m, n)."""

    gradient: Array
    jacobian: Array

    @property
    def slopes(self) -> Slopes:
        """The Jacobian for those who need few rows of it."""
        return self.jacobian

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return bool(np.isfinite(self.gradient).all() and np.isfinite(self.jacobian).all())

    def most_change(self, scale: Array, rows: Indices | None = None) -> Array:
        """Return how much rows change, to first order, where no variable does by more than scale.

        That is the most they can, or a bound of it, shape (m,).

        Args:
            scale: of the variables, shape (n,).
            rows: numbers of some, ascending (k,), of which a closer bound is wanted, shape (k,).
        """
        found = self.jacobian if rows is None else self.jacobian[rows]
        return np.asarray(np.abs(found) @ scale)


class NLP(ABC):
    """A nonlinear program; every method is a pure function of its arguments.

    That may keep what it has just computed: let every thread make a program of its own.

    Attributes:
        variables: names, bounds and scale of x.
        rows: limits of the scaled constraint rows.
        cost_scale: makes the cost of order one to ten; solvers minimise cost_scale * cost.
        has_hessian: whether `hessian` may be called.
    """

    variables: Variables
    rows: Rows
    cost_scale: float
    has_hessian: bool

    @abstractmethod
    def values(self, x: Array) -> Values:
        """Return cost and rows at x (n,).

        Raises:
            EvaluationError: the problem is not defined at x.
        """

    @abstractmethod
    def point(self, x: Array) -> Point:
        """Return cost, rows and their derivatives at x (n,).

        Raises:
            EvaluationError: the problem is not defined at x.
        """

    @abstractmethod
    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the (n, n) Hessian of cost_weight * cost(x) + multipliers . rows(x).

        Raises:
            EvaluationError: the problem is not defined at x.
        """

    def cost_curvature(self, x: Array) -> Array | None:
        """Return the (n, n) Hessian of cost_scale * cost as if what it is told of were linear in x.

        Of a sum of squares that is Gauss and Newton's, never below zero. None where it is not known
        or leads no better to a solution from far away than the Hessian itself.
        """
        del x
        return None

    def is_tip(self, x: Array) -> bool:
        """Return whether limits all but meet at x (n,) in a point without multipliers.

        As at the tip of a cone. No solver settles there, and one that has come so far may give up.
        """
        del x
        return False

    @abstractmethod
    def describe(self, row: int) -> str:
        """Name a row to a person: "left_knee torque at 80.0 % of the step"."""


class Status(Enum):
    """How a solver stopped; the value is a sentence for people."""

    OPTIMAL = "optimal: the first-order conditions hold"
    STALLED = "feasible but stalled: no further progress before the optimality tolerance"
    UNBOUNDED = "unbounded: the cost falls without end within the limits"
    INFEASIBLE = "infeasible: no nearby point reduces the violation"
    ITERATION_LIMIT = "iteration limit reached"
    INTERRUPTED = "interrupted: the best iterate so far was kept"
    NUMERICAL = "numerical trouble: the problem could not be evaluated near the iterate"


@dataclass(frozen=True)
class Progress:
    """One line of a solver's progress.

    Attributes:
        iteration: from 0.
        cost: unscaled cost.
        violation: largest scaled row or bound violation.
        worst: index of the row with the largest violation.
        optimality: `Residual.optimality` of the iterate with the multipliers that the solver has
            there, or those of least squares where it has none.
        radius: step bound in units of variables.scale, nan if the solver has none.
        seconds: wall time since the start.
        evaluations: values and points computed so far.
        solver: name of the method that made the iteration.
    """

    iteration: int
    cost: float
    violation: float
    worst: int
    optimality: float
    radius: float
    seconds: float
    evaluations: int
    solver: str = ""


ProgressCallback = Callable[[Progress], None]
StopCallback = Callable[[Progress], bool]
"""Asked after every iteration; True ends the solver, which returns its best iterate."""

Stop = Callable[[], bool]
"""Asked now and then by work of many solves; once it says True it must go on saying so."""


def never() -> bool:
    """Return that there is no reason to stop."""
    return False


def stopping(stop: Stop, early: StopCallback | None = None) -> StopCallback:
    """Return what a solver asks after every iteration: `stop`, and then `early` if given."""

    def asked(progress: Progress) -> bool:
        return stop() or (early is not None and early(progress))

    return asked


@dataclass(frozen=True)
class Start:
    """Where a solver starts.

    Attributes:
        x: shape (n,).
        multipliers: shape (m,), if a good guess is known.
        hessian: of a neighbour's Lagrangian, as of `Solution`, for the first step in place of its
            own: that goes along the tangent of the solutions as a task changes.
    """

    x: Array
    multipliers: Array | None = None
    hessian: Array | None = None


@dataclass(frozen=True)
class Solution:
    """What a solver found.

    Attributes:
        x: best point, shape (n,).
        cost: unscaled cost at x.
        multipliers: of the scaled rows, shape (m,); sign as in the module docstring.
        bound_multipliers: of the bounds on x, shape (n,).
        status: how it stopped.
        violation: largest scaled row or bound violation at x.
        optimality: `Residual.optimality` at x.
        iterations, evaluations, hessians: counts (evaluations of values or points).
        seconds: wall time.
        solver: name of the solver.
        history: one record per iteration.
        hessian: of the Lagrangian in scaled variables, the last one computed, shape (n, n); None
            where there was none.
    """

    x: Array
    cost: float
    multipliers: Array
    bound_multipliers: Array
    status: Status
    violation: float
    optimality: float
    iterations: int
    evaluations: int
    hessians: int
    seconds: float
    solver: str
    history: tuple[Progress, ...] = ()
    hessian: Array | None = None


@dataclass(frozen=True)
class Residual:
    """How far a point and its multipliers are from satisfying the KKT conditions.

    Attributes:
        stationarity: infinity norm of cost_scale * grad f + J' y + z.
        feasibility: largest violation of a row or bound.
        complementarity: largest |multiplier| times distance to the limit it belongs to; infinite
            where there is no such limit.
    """

    stationarity: float
    feasibility: float
    complementarity: float

    @property
    def optimality(self) -> float:
        """Larger one of stationarity and complementarity: what a solver's tolerance bounds."""
        return max(self.stationarity, self.complementarity)

    @property
    def worst(self) -> float:
        """Largest of the three."""
        return max(self.optimality, self.feasibility)


def violations(lower: Array, upper: Array, value: Array) -> Array:
    """Return how far each value lies outside [lower, upper], zero inside; same shape."""
    return np.maximum(0.0, np.maximum(lower - value, value - upper))


def worst_violation(nlp: NLP, values: Values) -> tuple[float, int]:
    """Return the largest row or bound violation and the index of the worst row."""
    rows = violations(nlp.rows.lower, nlp.rows.upper, values.rows)
    bounds = violations(nlp.variables.lower, nlp.variables.upper, values.x)
    row = int(np.argmax(rows)) if rows.size else 0
    return float(max(rows.max(initial=0.0), bounds.max(initial=0.0))), row


def kkt_residual(nlp: NLP, point: Point, multipliers: Array, bound_multipliers: Array) -> Residual:
    """Compute the KKT residual from its definition (Nocedal & Wright, 2006, Theorem 12.1).

    Args:
        nlp: the program.
        point: of it.
        multipliers, bound_multipliers: of its rows, shape (m,), and of its bounds, shape (n,).
    """
    held = np.flatnonzero(multipliers)  # few of thousands
    pull = multipliers[held] @ point.slopes[held]
    gradient = nlp.cost_scale * point.gradient + pull + bound_multipliers
    return Residual(
        stationarity=float(np.abs(gradient).max(initial=0.0)),
        feasibility=worst_violation(nlp, point)[0],
        complementarity=max(
            _complementarity(nlp.rows.lower, nlp.rows.upper, point.rows, multipliers),
            _complementarity(nlp.variables.lower, nlp.variables.upper, point.x, bound_multipliers),
        ),
    )


def _complementarity(lower: Array, upper: Array, value: Array, multiplier: Array) -> float:
    active = np.flatnonzero(multiplier)  # few of them
    weight, at = multiplier[active], value[active]
    distance = np.where(weight > 0.0, upper[active] - at, at - lower[active])
    return float(np.abs(distance * weight).max(initial=0.0))
