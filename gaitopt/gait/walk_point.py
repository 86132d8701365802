"""A point of the walk's program at which gaps between bodies keep their derivatives as products.

There is a row for every pair of bodies that may meet and every instant, thousands with moving arms,
and a solver looks at few of them. All depend on the joint angles alone, so that their Jacobian is
a small one in these times the derivatives of the angles, and is formed for the rows asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.nlp import Array, Indices, Point, Values


@dataclass(frozen=True)
class Product:
    """Derivatives in x of what depends on the joint angles alone, r numbers at K instants.

    As rows they are counted instant by instant, K r of them.

    Attributes:
        local: in the angles, shape (K, r, n).
        angles: of the angles in x, shape (K, n, P).
    """

    local: Array
    angles: Array

    @property
    def whole(self) -> Array:
        """The derivatives, shape (K, r, P)."""
        return np.asarray(self.local @ self.angles)

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self.local.shape[0] * self.local.shape[1])

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        instants, entries = np.divmod(rows, self.local.shape[1])
        found = np.empty((rows.size, self.angles.shape[2]))
        for instant in np.unique(instants):
            here = slice(*np.searchsorted(instants, [instant, instant + 1]))
            np.matmul(self.local[instant, entries[here]], self.angles[instant], out=found[here])
        return found

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (K r,)."""
        return np.asarray(self.local @ (self.angles @ step)[:, :, None]).ravel()

    def __abs__(self) -> Product:
        """Return a bound of the sizes: as if each joint moved by as much as it can."""
        return Product(np.abs(self.local), np.abs(self.angles))


class RowSlopes:
    """The Jacobian of a walk's rows, shape (m, P), in tables (k, P) and products, in order."""

    def __init__(self, parts: Sequence[Array | Product]) -> None:
        self._parts = parts
        self._edges = np.cumsum([0, *map(len, parts)])

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        cuts = pairwise(rows.searchsorted(self._edges))
        found = zip(self._parts, self._edges[:-1], cuts, strict=True)
        return np.concatenate([part[rows[slice(*cut)] - begin] for part, begin, cut in found])

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (m,)."""
        return np.concatenate([part @ step for part in self._parts])

    def most_change(self, scale: Array) -> Array:
        """Return as of `Point.most_change`."""
        return np.concatenate([part.__abs__() @ scale for part in self._parts])

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        tables = (
            table
            for part in self._parts
            for table in ((part.local, part.angles) if isinstance(part, Product) else (part,))
        )
        return all(np.isfinite(table).all() for table in tables)

    @property
    def whole(self) -> Array:
        """All rows, shape (m, P)."""
        return np.concatenate(
            [
                part.whole.reshape(len(part), -1) if isinstance(part, Product) else part
                for part in self._parts
            ]
        )


class WalkPoint(Point):
    """A point whose Jacobian is formed as far as it is asked for."""

    _slopes: RowSlopes

    def __init__(self, values: Values, gradient: Array, slopes: RowSlopes) -> None:
        """Take values, and the derivatives of the cost (P,) and of the rows."""
        vars(self).update(vars(values), gradient=gradient, _slopes=slopes)

    @property
    def slopes(self) -> RowSlopes:
        """The Jacobian for those who need few rows of it."""
        return self._slopes

    @cached_property
    def jacobian(self) -> Array:
        """The whole Jacobian, shape (m, P)."""
        return self.slopes.whole

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return bool(np.isfinite(self.gradient).all()) and self.slopes.finite

    def most_change(self, scale: Array) -> Array:
        """Return as of `Point`."""
        return self.slopes.most_change(scale)
