"""How the eight costs depend on the five unknowns, and which other values would do as well."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gaitopt.nlp import Array
from gaitopt.study.reproduce.curve import Curve, warm_curve
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.unknowns import UNKNOWNS, identified_values, walks_with

STRIDE = 0.01  # of an unknown's range, to either side


@dataclass(frozen=True)
class Sensitivity:
    """Linear dependence of the relative errors of the eight costs on the unknowns.

    Attributes:
        values: where it was taken, shape (5,).
        errors: J over the printed J, minus 1, shape (8,).
        jacobian: of the errors with respect to the unknowns over their ranges, shape (8, 5).
    """

    values: Array
    errors: Array
    jacobian: Array

    @property
    def spread(self) -> float:
        """Root mean square of the errors."""
        return float(np.sqrt((self.errors**2).mean()))

    @cached_property
    def singular(self) -> tuple[Array, Array]:
        """Singular values (5,), largest first, and their directions, one per row (5, 5)."""
        _, values, directions = np.linalg.svd(self.jacobian, full_matrices=False)
        largest = np.abs(directions).argmax(axis=1)
        signs = np.sign(directions[np.arange(len(directions)), largest])
        return values, directions * signs[:, None]

    @property
    def reach(self) -> Array:
        """How far one may go along each direction, in ranges, before the costs move by `spread`.

        Root mean square over the eight speeds; shape (5,).
        """
        return np.asarray(self.spread * np.sqrt(len(self.errors)) / self.singular[0])

    @cached_property
    def play(self) -> Array:
        """Between which values each unknown may lie while the other four make up for it, (5, 2).

        Ends of the region, within all ranges, in which the costs have linearly moved by no more
        than `spread`.
        """
        return np.array([[self._end(i, -1.0), self._end(i, 1.0)] for i in range(len(UNKNOWNS))])

    def _end(self, i: int, sign: float) -> float:
        """Largest (+1) or smallest (-1) value of an unknown in that region."""
        from scipy import optimize

        lower = np.array([u.lower for u in UNKNOWNS])
        ranges = np.array([u.upper - u.lower for u in UNKNOWNS])
        here = (self.values - lower) / ranges
        allowed = len(self.errors) * self.spread**2
        inside = {"type": "ineq", "fun": lambda d: 1.0 - ((self.jacobian @ d) ** 2).sum() / allowed}
        minimise: Any = optimize.minimize  # the published types do not admit our functions
        found = minimise(
            lambda d: -sign * d[i],
            np.zeros(len(here)),
            method="SLSQP",
            bounds=list(zip(-here, 1.0 - here, strict=True)),
            constraints=[inside],
        )
        return float(self.values[i] + ranges[i] * found.x[i])


def relative_errors(curve: Curve) -> Array:
    """Return J over the printed J, minus 1, at the speeds of Table 3; nan without a walk, (8,)."""
    costs = [curve[v].cost if v in curve else np.nan for v in printed().speeds]
    return np.array(costs) / printed().costs - 1.0


def sensitivity(curve: Curve) -> Sensitivity:
    """Return the dependence at the identified values, by central differences.

    Args:
        curve: of the identified biped, at least the speeds of Table 3.
    """
    near = {v: curve[v].solution.x for v in printed().speeds}
    values = identified_values()
    columns = []
    for i, unknown in enumerate(UNKNOWNS):
        shift = np.zeros(len(UNKNOWNS))
        shift[i] = STRIDE * (unknown.upper - unknown.lower)
        ends = [warm_curve(walks_with(values + sign * shift), near) for sign in (1.0, -1.0)]
        up, down = (relative_errors(end) for end in ends)
        columns.append((up - down) / (2.0 * STRIDE))
    return Sensitivity(values, relative_errors(curve), np.stack(columns, axis=1))
