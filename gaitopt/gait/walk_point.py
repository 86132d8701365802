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
from gaitopt.mechanics.forward_kinematics import PostureQuantityDerivatives
from gaitopt.nlp import Array, Indices, Point, Values


@dataclass(frozen=True)
class Table:
    """Derivatives in x of rows.

    Attributes:
        table: shape (k, P), or of r numbers at K instants, which are counted instant by instant,
            shape (K, r, P).
        per_unit: by which each of those numbers is multiplied, shape (r,); None: by 1.
    """

    table: Array
    per_unit: Array | None = None

    @property
    def whole(self) -> Array:
        """The derivatives, as of `table`."""
        return self.table if self.per_unit is None else self.table * self.per_unit[:, None]

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return bool(np.isfinite(self.table).all())

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self.table.size // self.table.shape[-1])

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        if self.per_unit is None:
            return self.table[rows]
        instants, entries = np.divmod(rows, self.per_unit.size)
        return np.asarray(self.table[instants, entries] * self.per_unit[entries, None])

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (k,) or (K r,)."""
        return _scaled(self.table @ step, self.per_unit)

    def most_change(self, scale: Array, rows: Indices | None) -> Array:
        """Return as of `Point.most_change`."""
        if rows is None:
            return _scaled(np.abs(self.table) @ scale, self.per_unit)
        return np.asarray(np.abs(self[rows]) @ scale)


def _scaled(changes: Array, per_unit: Array | None) -> Array:
    return (changes if per_unit is None else changes * per_unit).ravel()


@dataclass(frozen=True)
class Product:
    """Derivatives in x of what depends on the joint angles alone, r numbers at K instants.

    As rows they are counted instant by instant, K r of them.

    Attributes:
        local: in the angles.
        angles: of the angles in x, shape (K, n, P).
        per_unit: by which each number is multiplied, shape (r,); None: by 1.
    """

    local: PostureQuantityDerivatives
    angles: Array
    per_unit: Array | None = None

    @property
    def whole(self) -> Array:
        """The derivatives, shape (K, r, P)."""
        found = self.local.jacobian @ self.angles
        return np.asarray(found if self.per_unit is None else found * self.per_unit[:, None])

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number, as far as the angles' and values are."""
        return bool(np.isfinite(self.local.value).all() and np.isfinite(self.angles).all())

    def __len__(self) -> int:
        """Return the number of rows."""
        return self.local.value.size

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        instants, local = self._local(rows)
        found = np.empty((rows.size, self.angles.shape[2]))
        for instant in np.unique(instants):
            here = slice(*np.searchsorted(instants, [instant, instant + 1]))
            np.matmul(local[here], self.angles[instant], out=found[here])
        return found

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (K r,)."""
        return _scaled(self.local.along(self.angles @ step), self.per_unit)

    def most(self, changes: Array, rows: Indices | None) -> Array:
        """Return a bound of the changes of all rows (K r,), or a closer one of some (k,).

        Args:
            changes: the most that each angle changes by, shape (K, n).
            rows: numbers of some.
        """
        if rows is None:
            return _scaled(self.local.most(changes), self.per_unit)
        instants, local = self._local(rows)
        return np.asarray((np.abs(local) * changes[instants]).sum(axis=1))

    def _local(self, rows: Indices) -> tuple[Indices, Array]:
        """Return the instants of some rows (k,), and their derivatives in the angles, (k, n)."""
        instants, entries = np.divmod(rows, self.local.value.shape[1])
        local = self.local.rows(instants, entries)
        return instants, local if self.per_unit is None else local * self.per_unit[entries, None]


class RowSlopes:
    """The Jacobian of a walk's rows, shape (m, P), in parts that follow each other."""

    def __init__(self, parts: Sequence[Table | Product]) -> None:
        self._parts = parts
        self._edges = np.cumsum([0, *map(len, parts)])

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        found = zip(self._parts, self._by_part(rows), strict=True)
        return np.concatenate([part[some] for part, some in found])

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (m,)."""
        return np.concatenate([part @ step for part in self._parts])

    def most_change(self, scale: Array, rows: Indices | None = None) -> Array:
        """Return as of `Point.most_change`; as if each joint moved by as much as it can."""
        changes: dict[int, Array] = {}  # of angles, which products share
        found = []
        each = [None] * len(self._parts) if rows is None else self._by_part(rows)
        for part, some in zip(self._parts, each, strict=True):
            if isinstance(part, Product):
                key = id(part.angles)
                if key not in changes:
                    changes[key] = np.abs(part.angles) @ scale
                found.append(part.most(changes[key], some))
            else:
                found.append(part.most_change(scale, some))
        return np.concatenate(found)

    def _by_part(self, rows: Indices) -> list[Indices]:
        """Return some rows by their numbers within the parts that they are of."""
        cuts = pairwise(rows.searchsorted(self._edges))
        return [
            rows[slice(*cut)] - first for cut, first in zip(cuts, self._edges[:-1], strict=True)
        ]

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return all(part.finite for part in self._parts)

    @property
    def whole(self) -> Array:
        """All rows, shape (m, P)."""
        return np.concatenate([part.whole.reshape(len(part), -1) for part in self._parts])


class WalkPoint(Point):
    """A point whose Jacobian is formed as far as it is asked for."""

    _slopes: RowSlopes

    def __init__(self, values: Values, gradient: Array, slopes: RowSlopes) -> None:
        """Take values, and the derivatives of the cost (P,) and of the rows."""
        vars(self).update(vars(values), gradient=gradient, _slopes=slopes)

    @property
    def slopes(self) -> RowSlopes:
        return self._slopes

    @cached_property
    def jacobian(self) -> Array:
        """The whole Jacobian, shape (m, P)."""
        return self.slopes.whole

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self.gradient).all()) and self.slopes.finite

    def most_change(self, scale: Array, rows: Indices | None = None) -> Array:
        return self.slopes.most_change(scale, rows)
