"""Programs around programs: one that counts, one in scaled variables, one by finite differences."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point, Values


@dataclass
class Evaluator:
    """Counts what a solver asks of a program.

    Values and derivatives asked at the same x in a row count as one evaluation.

    Attributes:
        nlp: the program.
        evaluations: values or points computed so far, failed ones included.
        hessians: Hessians computed so far.
    """

    nlp: NLP
    evaluations: int = 0
    hessians: int = 0
    _last: Array | None = field(default=None, repr=False)

    def values(self, x: Array) -> Values:
        """Return cost and rows at x (n,).

        Raises:
            EvaluationError: the program is not defined at x, or not finite.
        """
        self._count(x)
        return finite_values(self.nlp.values(x))

    def point(self, x: Array) -> Point:
        """Return cost, rows and their derivatives at x (n,).

        Raises:
            EvaluationError: the program is not defined at x, or not finite.
        """
        self._count(x)
        point = self.nlp.point(x)
        finite_values(point)
        if not point.finite:
            raise EvaluationError("a derivative of the program is not a finite number")
        return point

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the (n, n) Hessian of cost_weight * cost + multipliers . rows.

        Raises:
            EvaluationError: the program is not defined at x, or not finite.
        """
        self.hessians += 1
        matrix = self.nlp.hessian(x, multipliers, cost_weight)
        if not np.isfinite(matrix).all():
            raise EvaluationError("the Hessian of the program is not finite")
        return matrix

    def _count(self, x: Array) -> None:
        if self._last is None or not np.array_equal(x, self._last):
            self.evaluations += 1
            self._last = x.copy()


def finite_values(values: Values) -> Values:
    """Return the values unchanged if they are finite.

    Raises:
        EvaluationError: cost or a row is infinite or not a number.
    """
    if not (np.isfinite(values.cost) and np.isfinite(values.rows).all()):
        raise EvaluationError("the cost or a row of the program is not a finite number")
    return values


class ScaledProgram:
    """Functions of the scaled variables u (n,), each evaluated once per point.

    Where the program is undefined the cost is infinite, which every line search and trust
    region takes for "too far", and the rest is that of the last point where it was defined.

    Attributes:
        first, last: points where derivatives were asked for.
        scale: of the variables, shape (n,).
        nlp: the program.
    """

    def __init__(self, evaluator: Evaluator, point: Point) -> None:
        """Begin at a point that could be evaluated."""
        self._evaluator = evaluator
        self._values: tuple[Array, float, Array] = (point.x, point.cost, point.rows)
        self.last = self.first = point
        self.scale = evaluator.nlp.variables.scale
        self.nlp: NLP = evaluator.nlp

    def x(self, u: Array) -> Array:
        """Return the variables (n,), unscaled."""
        return np.asarray(u) * self.scale

    def cost(self, u: Array) -> float:
        """Return the scaled cost at u (n,), infinite where undefined."""
        return self.nlp.cost_scale * self._evaluate(u)[1]

    def rows(self, u: Array) -> Array:
        """Return the rows (m,)."""
        return self._evaluate(u)[2]

    def gradient(self, u: Array) -> Array:
        """Return the gradient (n,) of the scaled cost with respect to u."""
        return self.nlp.cost_scale * self.point(u).gradient * self.scale

    def jacobian(self, u: Array) -> Array:
        """Return the (m, n) Jacobian of the rows with respect to u."""
        return self.point(u).jacobian * self.scale

    def point(self, u: Array) -> Point:
        """Return the unscaled point at u (n,), or the last one defined."""
        x = self.x(u)
        if not np.array_equal(x, self.last.x):
            with contextlib.suppress(EvaluationError):
                self.last = self._evaluator.point(x)
        return self.last

    def hessian(self, u: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the (n, n) Hessian of cost_weight * cost + multipliers . rows, zero if undefined.

        With respect to u.
        """
        try:
            H = self._evaluator.hessian(self.x(u), multipliers, cost_weight)
        except EvaluationError:
            return np.zeros((self.scale.size, self.scale.size))
        return np.asarray(H * np.outer(self.scale, self.scale))

    def _evaluate(self, u: Array) -> tuple[Array, float, Array]:
        x = self.x(u)
        if not np.array_equal(x, self._values[0]):
            try:
                values = self._evaluator.values(x)
                self._values = (x.copy(), values.cost, values.rows)
            except EvaluationError:
                self._values = (x.copy(), np.inf, self._values[2])
        return self._values


STEP = 1.5e-8
"""Square root of the rounding unit: balances truncation and rounding of a forward difference
(Nocedal & Wright, 2006, Eq. 8.6)."""


class FiniteDifferenceNLP(NLP):
    """The same program without exact derivatives.

    Attributes:
        evaluations: calls of the inner program's `values` and `point` so far.
    """

    def __init__(self, nlp: NLP, step: float = STEP, cost_gradient_only: bool = False) -> None:
        """Wrap a program.

        Args:
            step: relative to the larger of a variable and its scale.
            cost_gradient_only: keep the exact gradient of the cost, and take differences for the
                rows only.
        """
        self._nlp = nlp
        self._step = step
        self._exact_gradient = cost_gradient_only
        self.variables = nlp.variables
        self.rows = nlp.rows
        self.cost_scale = nlp.cost_scale
        self.has_hessian = False
        self.evaluations = 0

    def values(self, x: Array) -> Values:
        self.evaluations += 1
        return self._nlp.values(x)

    def point(self, x: Array) -> Point:
        here = self.values(x)
        gradient = np.empty(x.size)
        jacobian = np.empty((here.rows.size, x.size))
        for i in range(x.size):
            there, h = self._neighbour(x, i)
            gradient[i] = (there.cost - here.cost) / h
            jacobian[:, i] = (there.rows - here.rows) / h
        if self._exact_gradient:
            self.evaluations += 1
            gradient = self._nlp.point(x).gradient
        return Point(x, here.cost, here.rows, gradient, jacobian)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        """Not available.

        Raises:
            EvaluationError: always.
        """
        del x, multipliers, cost_weight
        raise EvaluationError("a program by finite differences has no second derivatives")

    def describe(self, row: int) -> str:
        return self._nlp.describe(row)

    def _neighbour(self, x: Array, i: int) -> tuple[Values, float]:
        """Return values at a point shifted along variable i, within bounds, and the shift."""
        h = self._step * max(abs(float(x[i])), float(self.variables.scale[i]))
        if x[i] + h > self.variables.upper[i]:
            h = -h
        try:
            return self._shifted(x, i, h)
        except EvaluationError:
            return self._shifted(x, i, -h)

    def _shifted(self, x: Array, i: int, h: float) -> tuple[Values, float]:
        moved = x.copy()
        moved[i] += h
        return self.values(moved), float(moved[i] - x[i])
