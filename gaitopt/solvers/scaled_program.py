"""A program as SciPy's solvers want it: functions of u = x / scale that always return numbers."""

from __future__ import annotations

import contextlib

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point
from gaitopt.solvers.evaluator import Evaluator


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
        """Return the scaled cost, infinite where undefined."""
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
        """Return the unscaled point at u, or the last one defined."""
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
