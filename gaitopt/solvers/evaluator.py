"""A nonlinear program that counts its evaluations and never returns a number that is not one."""

from __future__ import annotations

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
        if not (np.isfinite(point.gradient).all() and np.isfinite(point.jacobian).all()):
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
