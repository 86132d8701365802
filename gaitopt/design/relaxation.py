"""The elastic program of a walk: how little must the limits give for a walk to exist?

    minimise over x, t   t_1 + t_2 + ... + pull . x + epsilon/2 |(x - x_0) / scale|²
    subject to           lower <= c(x) + t_1 (A_1 + B_1 c(x)) + t_2 (A_2 + B_2 c(x)) + ... <= upper
                         0 <= t <= t_max

with c the scaled rows of the walk; its cost plays no part. Where a row has two limits and is
relaxed, it stands there twice, once for each limit. The sum of t (a 1-norm) keeps most of them at
exactly zero (Nocedal & Wright, 2006, section 17.2): what is left is a small set of limits that
conflict. B couples rows: a coefficient of friction multiplies the vertical force, which is a row
of its own. `pull` asks for little of one variable instead. With neither t nor pull, the program
asks for the nearest walk.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gaitopt.nlp import NLP, Array, Point, Rows, Values, Variables

REGULARITY = 1e-3
"""epsilon: the distance only chooses among walks that are equally near to the limits."""
STEP = 0.3
"""Scale of t for the solver; one unit of t is a change that matters."""

Indices = NDArray[np.int_]
Coupling = tuple[Indices, Indices, float]


@dataclass(frozen=True)
class Relaxation:
    """One number t >= 0 that widens limits.

    Attributes:
        name: of what gives.
        lower, upper: by how much the lower limits fall and the upper ones rise per unit of t,
            scaled like the rows, shape (m,); at an equality by how much its value falls or rises.
        couplings: (rows, partners, factor): factor * partner is added to the row per unit of t.
        largest: bound on t.
    """

    name: str
    lower: Array
    upper: Array
    couplings: tuple[Coupling, ...] = ()
    largest: float = np.inf

    def relief(self, rows: Array, multipliers: Array) -> float:
        """Return how fast the objective of a relaxed program falls per unit of t.

        Args:
            rows: scaled rows at its solution, shape (m,).
            multipliers: of these rows there, shape (m,).
        """
        moved = np.where(multipliers < 0.0, self.lower, -self.upper)
        for target, partner, factor in self.couplings:
            moved[target] += factor * rows[partner]
        return -float(multipliers @ moved)

    @property
    def rows(self) -> NDArray[np.bool_]:
        """Which rows it relaxes, shape (m,)."""
        touched = np.asarray((self.lower != 0.0) | (self.upper != 0.0))
        for rows, _, _ in self.couplings:
            touched[rows] = True
        return touched


class RelaxedProgram(NLP):
    """A program whose limits give; its variables are (x, t)."""

    def __init__(
        self,
        base: NLP,
        relaxations: tuple[Relaxation, ...],
        centre: Array,
        pull: Array | None = None,
    ) -> None:
        """Relax a program.

        Args:
            base: the program.
            relaxations: k of them.
            centre: x_0, shape (n,).
            pull: linear objective on x, shape (n,), by default none.
        """
        self.base, self.relaxations, self.centre = base, relaxations, centre
        self.has_hessian, self.cost_scale = base.has_hessian, 1.0
        k, variables = len(relaxations), base.variables
        self.size = variables.lower.size
        self._pull = np.zeros(self.size) if pull is None else pull
        self._stiffness = REGULARITY / variables.scale**2
        self.variables = Variables(
            (*variables.names, *(r.name for r in relaxations)),
            np.append(variables.lower, np.zeros(k)),
            np.append(variables.upper, [r.largest for r in relaxations]),
            np.append(variables.scale, np.full(k, STEP)),
        )
        lower, upper = base.rows.lower, base.rows.upper
        relaxed = np.zeros(lower.size, dtype=bool)
        for r in relaxations:
            relaxed |= r.rows
        twice = np.flatnonzero(relaxed & np.isfinite(lower) & np.isfinite(upper) & (lower < upper))
        once = np.delete(np.arange(lower.size), twice)
        self.source = np.concatenate([once, twice, twice])
        """Row of the base behind every row, shape (M,)."""
        infinite = np.full(twice.size, np.inf)
        self.rows = Rows(
            np.concatenate([lower[once], lower[twice], -infinite]),
            np.concatenate([upper[once], infinite, upper[twice]]),
        )
        has_lower, has_upper = np.isfinite(self.rows.lower), np.isfinite(self.rows.upper)
        self._offsets = [
            np.where(has_lower, r.lower[self.source], 0.0)
            - np.where(has_upper, r.upper[self.source], 0.0)
            for r in relaxations
        ]

    def split(self, z: Array) -> tuple[Array, Array]:
        """Return x and t of the variables."""
        return z[: self.size], z[self.size :]

    def needed(self, x: Array) -> Array:
        """Return (x, t) with t just large enough for each relaxation's own rows at x.

        Couplings and rows that several relaxations share are ignored: the solver's matter.
        """
        rows = self.base.values(x).rows
        below, above = self.base.rows.lower - rows, rows - self.base.rows.upper
        t = [max(_ratio(below, r.lower), _ratio(above, r.upper), 0.0) for r in self.relaxations]
        return np.append(x, np.minimum(t, [r.largest for r in self.relaxations]))

    def values(self, z: Array) -> Values:
        """Return objective and rows at (x, t)."""
        x, t = self.split(z)
        at = self.base.values(x)
        return Values(z, self._objective(x, t), self._rows(at.rows, t))

    def point(self, z: Array) -> Point:
        """Return objective, rows and their derivatives at (x, t)."""
        x, t = self.split(z)
        at = self.base.point(x)
        jacobian = np.empty((self.source.size, z.size))
        jacobian[:, : x.size] = (at.jacobian + self._coupled(at.jacobian, t))[self.source]
        for i in range(t.size):
            jacobian[:, x.size + i] = self.column(i, at.rows)
        slope = self._pull + self._stiffness * (x - self.centre)
        gradient = np.append(slope, np.ones(t.size))
        return Point(z, self._objective(x, t), self._rows(at.rows, t), gradient, jacobian)

    def hessian(self, z: Array, multipliers: Array, cost_weight: float) -> Array:
        """Return the exact Hessian of cost_weight * objective + multipliers . rows."""
        x, t = self.split(z)
        y = self.base_multipliers(multipliers)
        pulled = [self._pulled(i, y) for i in range(t.size)]
        at_base = y + sum((t[i] * pulled[i] for i in range(t.size)), np.zeros(y.size))
        H = np.zeros((z.size, z.size))
        H[: x.size, : x.size] = self.base.hessian(x, at_base, 0.0)
        H[: x.size, : x.size] += cost_weight * np.diag(self._stiffness)
        for i in range(t.size):
            if pulled[i].any():
                H[: x.size, x.size + i] = pulled[i] @ self.base.point(x).jacobian
                H[x.size + i, : x.size] = H[: x.size, x.size + i]
        return H

    def describe(self, row: int) -> str:
        """Name a row."""
        return self.base.describe(int(self.source[row]))

    def base_multipliers(self, multipliers: Array) -> Array:
        """Return the multipliers of the base's rows, those of both limits together, shape (m,)."""
        together = np.zeros(self.base.rows.lower.size)
        np.add.at(together, self.source, multipliers)
        return together

    def own_multipliers(self, multipliers: Array) -> Array:
        """Return multipliers of these rows that are those of the base's rows together."""
        both = multipliers[self.source]
        low = np.where(np.isfinite(self.rows.lower), np.minimum(both, 0.0), 0.0)
        return low + np.where(np.isfinite(self.rows.upper), np.maximum(both, 0.0), 0.0)

    def column(self, index: int, rows: Array) -> Array:
        """Return the derivative of the rows with respect to one t, shape (M,)."""
        moved = np.zeros(rows.size)
        for target, partner, factor in self.relaxations[index].couplings:
            moved[target] += factor * rows[partner]
        return np.asarray(self._offsets[index] + moved[self.source])

    def _objective(self, x: Array, t: Array) -> float:
        away = x - self.centre
        return float(t.sum() + self._pull @ x + 0.5 * away @ (self._stiffness * away))

    def _rows(self, rows: Array, t: Array) -> Array:
        moved: Array = rows[self.source]
        for i in range(t.size):
            moved = moved + t[i] * self.column(i, rows)
        return moved

    def _coupled(self, jacobian: Array, t: Array) -> Array:
        """Sum of t_i B_i J."""
        moved = np.zeros_like(jacobian)
        for relaxation, amount in zip(self.relaxations, t, strict=True):
            for target, partner, factor in relaxation.couplings:
                moved[target] += amount * factor * jacobian[partner]
        return moved

    def _pulled(self, index: int, y: Array) -> Array:
        """B_i' y."""
        back = np.zeros(y.size)
        for target, partner, factor in self.relaxations[index].couplings:
            np.add.at(back, partner, factor * y[target])
        return back


def _ratio(missing: Array, rate: Array) -> float:
    """Largest missing / rate where a limit is missed and gives."""
    gives = (rate > 0.0) & (missing > 0.0)
    return float((missing[gives] / rate[gives]).max(initial=0.0))
