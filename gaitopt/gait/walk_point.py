"""A point of the walk's program at which gaps between bodies keep their derivatives as products.

There is a row for every pair of bodies that may meet and every instant, thousands with moving arms,
and a solver looks at few of them. All depend on the joint angles alone, so that their Jacobian is
a small one in these times the derivatives of the angles, and is formed for the rows asked for.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gaitopt.nlp import Array, Indices, Point, Values


@dataclass(frozen=True)
class Product:
    """Derivatives in x of what depends on the joint angles alone, r numbers at K instants.

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


class _Part(ABC):
    """Some consecutive rows of a Jacobian, as a table (k, P) or as products."""

    size: int

    @property
    @abstractmethod
    def whole(self) -> Array:
        """All of them, shape (k, P)."""

    @property
    @abstractmethod
    def finite(self) -> bool:
        """Whether every number is."""

    @abstractmethod
    def pick(self, rows: Indices) -> Array:
        """Return some of them by their numbers, ascending (j,), shape (j, P)."""

    @abstractmethod
    def along(self, step: Array) -> Array:
        """Return their change along a step (P,), shape (k,)."""

    @abstractmethod
    def most_change(self, scale: Array) -> Array:
        """Return as of `gaitopt.nlp.Point.most_change`, shape (k,)."""


class _Table(_Part):
    def __init__(self, table: Array) -> None:
        self.size, self._table = len(table), table

    @property
    def whole(self) -> Array:
        return self._table

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self._table).all())

    def pick(self, rows: Indices) -> Array:
        return self._table[rows]

    def along(self, step: Array) -> Array:
        return np.asarray(self._table @ step)

    def most_change(self, scale: Array) -> Array:
        return np.asarray(np.abs(self._table) @ scale)


class _Products(_Part):
    def __init__(self, product: Product) -> None:
        self._product, self._local, self._angles = product, product.local, product.angles
        self.size = self._local.shape[0] * self._local.shape[1]

    @property
    def whole(self) -> Array:
        return self._product.whole.reshape(self.size, -1)

    @property
    def finite(self) -> bool:
        return bool(np.isfinite(self._local).all() and np.isfinite(self._angles).all())

    def pick(self, rows: Indices) -> Array:
        instants, entries = np.divmod(rows, self._local.shape[1])
        found = np.empty((rows.size, self._angles.shape[2]))
        for instant in np.unique(instants):
            here = slice(*np.searchsorted(instants, [instant, instant + 1]))
            np.matmul(self._local[instant, entries[here]], self._angles[instant], out=found[here])
        return found

    def along(self, step: Array) -> Array:
        return self._through(self._local, self._angles @ step)

    def most_change(self, scale: Array) -> Array:
        # as if each joint moved by as much as it can at that instant
        return self._through(np.abs(self._local), np.abs(self._angles) @ scale)

    def _through(self, local: Array, angles: Array) -> Array:
        return np.asarray(local @ angles[:, :, None]).ravel()


class RowSlopes:
    """The Jacobian of a walk's rows, shape (m, P), in parts that follow each other."""

    def __init__(self, parts: Sequence[Array | Product]) -> None:
        self._parts: list[_Part] = [
            _Products(p) if isinstance(p, Product) else _Table(p) for p in parts
        ]
        self._ends = np.cumsum([part.size for part in self._parts])
        self._width = (
            parts[0].angles.shape[2] if isinstance(parts[0], Product) else parts[0].shape[1]
        )

    def __getitem__(self, rows: Indices) -> Array:
        """Return some rows by their numbers, ascending (k,), shape (k, P)."""
        found = np.empty((rows.size, self._width))
        first = 0
        for part, end, last in zip(
            self._parts, self._ends, rows.searchsorted(self._ends), strict=True
        ):
            if last > first:
                found[first:last] = part.pick(rows[first:last] - (end - part.size))
            first = last
        return found

    def __matmul__(self, step: Array) -> Array:
        """Return the change of all rows along a step (P,), shape (m,)."""
        return np.concatenate([part.along(step) for part in self._parts])

    def most_change(self, scale: Array) -> Array:
        """Return as of `Point.most_change`."""
        return np.concatenate([part.most_change(scale) for part in self._parts])

    @property
    def finite(self) -> bool:
        """Whether every derivative is a finite number."""
        return all(part.finite for part in self._parts)

    @property
    def whole(self) -> Array:
        """All rows, shape (m, P)."""
        return np.concatenate([part.whole for part in self._parts])


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
