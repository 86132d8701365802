"""Where the SQP method gets the Hessian of the Lagrangian from."""

from __future__ import annotations

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import Array
from gaitopt.solvers.evaluator import Evaluator
from gaitopt.solvers.hessians import damped_bfgs
from gaitopt.solvers.recorder import Iterate


class Curvature:
    """The Hessian of the Lagrangian in scaled variables, exact or learnt from gradients.

    Attributes:
        definite: whether the Hessian is positive definite by construction.
    """

    def __init__(self, evaluator: Evaluator, exact: bool) -> None:
        """Begin with the identity.

        In scaled variables that is a fair guess; scaling it by the first step, as Nocedal &
        Wright (2006), Eq. 6.20, do, takes more than twice the iterations (measured).

        Args:
            evaluator: the program.
            exact: use its second derivatives if it has any.
        """
        self._evaluator = evaluator
        self._exact = exact and evaluator.nlp.has_hessian
        self._matrix = np.eye(evaluator.nlp.variables.scale.size)
        self.definite = True

    def hessian(self, iterate: Iterate) -> Array:
        """Return the (n, n) Hessian at an iterate; the last known one where it is undefined."""
        if self._exact:
            nlp = self._evaluator.nlp
            scale = nlp.variables.scale
            try:
                H = self._evaluator.hessian(iterate.point.x, iterate.multipliers, nlp.cost_scale)
            except EvaluationError:
                return self._matrix
            self._matrix = 0.5 * (H + H.T) * np.outer(scale, scale)
            self.definite = False
        return self._matrix

    def learn(self, old: Iterate, new: Iterate) -> None:
        """Update the approximation after a step, with the new multipliers at both ends."""
        if self._exact:
            return
        nlp = self._evaluator.nlp
        scale = nlp.variables.scale
        step = (new.point.x - old.point.x) / scale
        change = nlp.cost_scale * (new.point.gradient - old.point.gradient)
        change = change + (new.point.jacobian - old.point.jacobian).T @ new.multipliers
        change = change * scale
        self._matrix = damped_bfgs(self._matrix, step, change)
