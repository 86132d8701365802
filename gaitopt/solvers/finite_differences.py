"""A program whose first derivatives come from differences of its values.

The way of solvers that are given functions only; kept for comparison with exact derivatives.
"""

from __future__ import annotations

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point, Values

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
            nlp: the program.
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
        """Return cost and rows at x (n,).

        Raises:
            EvaluationError: the problem is not defined at x.
        """
        self.evaluations += 1
        return self._nlp.values(x)

    def point(self, x: Array) -> Point:
        """Return cost and rows at x (n,), and their derivatives by forward differences.

        Raises:
            EvaluationError: the problem is not defined at x, or on both sides of it.
        """
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
        raise EvaluationError("a program by finite differences has no second derivatives")

    def describe(self, row: int) -> str:
        """Name a row as the inner program does."""
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
