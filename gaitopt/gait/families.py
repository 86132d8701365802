"""Families of constraint rows: one quantity in, rows with limits, unit and names out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitopt.gait.step import Reads
from gaitopt.nlp import Array


class RowMap(ABC):
    """A function from one row of a quantity (entries,) to constraint rows (r,)."""

    @abstractmethod
    def value(self, quantity: Array) -> Array:
        """Return rows (K, r) of a quantity (K, entries)."""

    @abstractmethod
    def slope(self, quantity: Array) -> Array:
        """Return the derivative, shape (K, r, entries), or (r, entries) where it is constant."""

    def jacobian(self, quantity: Array, slopes: Array) -> Array:
        """Return d rows / d x, shape (K, r, P), from d quantity / d x, shape (K, entries, P)."""
        return np.asarray(self.slope(quantity) @ slopes)

    def pull(self, quantity: Array, weights: Array) -> Array:
        """Return the slope of weights . rows, weights (K, r), shape (K, entries)."""
        return np.asarray((weights[:, None] @ self.slope(quantity))[:, 0])

    @abstractmethod
    def curvature(self, quantity: Array, weights: Array) -> Array | None:
        """Return the Hessian of weights . rows, shape (K, entries, entries); None if linear."""


@dataclass(frozen=True)
class Linear(RowMap):
    """Rows = matrix @ quantity, matrix (r, entries)."""

    matrix: Array

    def value(self, quantity: Array) -> Array:
        """Return matrix @ quantity."""
        return quantity @ self.matrix.T

    def slope(self, quantity: Array) -> Array:
        """Return the matrix."""
        del quantity
        return self.matrix

    def curvature(self, quantity: Array, weights: Array) -> None:
        """Return None: the rows are linear."""
        del quantity, weights


@dataclass(frozen=True)
class Entries(RowMap):
    """Rows = factor * chosen entries of the quantity: a linear map without a product.

    Attributes:
        chosen: a slice of the entries, so that nothing is copied.
        count: number of entries of the quantity.
        factor: one for all rows, or shape (r,).
    """

    chosen: slice
    count: int
    factor: float | Array = 1.0

    def value(self, quantity: Array) -> Array:
        """Return factor * entries."""
        return np.asarray(quantity[:, self.chosen] * self.factor)

    def slope(self, quantity: Array) -> Array:
        """Return the constant derivative, shape (r, entries)."""
        del quantity
        return np.asarray(np.eye(self.count)[self.chosen] * np.reshape(self.factor, (-1, 1)))

    def jacobian(self, quantity: Array, slopes: Array) -> Array:
        """Return factor * chosen slopes."""
        del quantity
        chosen = slopes[:, self.chosen]
        if isinstance(self.factor, float) and self.factor == 1.0:
            return chosen
        return np.asarray(chosen * np.reshape(self.factor, (-1, 1)))

    def pull(self, quantity: Array, weights: Array) -> Array:
        """Return factor * weights in the places of the entries."""
        pull = np.zeros(quantity.shape)
        pull[:, self.chosen] = weights * self.factor
        return pull

    def curvature(self, quantity: Array, weights: Array) -> None:
        """Return None: the rows are linear."""
        del quantity, weights


@dataclass(frozen=True)
class FrictionCone(RowMap):
    """mu f_z - sqrt(f_x² + f_y² + smoothing²) of a force (or force and moment), Eqs. (33), (34).

    The smoothing keeps the cone differentiable where the force is vertical.
    """

    friction: float
    smoothing: float

    def value(self, quantity: Array) -> Array:
        """Return the margin to the cone, shape (K, 1)."""
        return self.friction * quantity[:, 2:3] - self._tangential(quantity)[:, None]

    def slope(self, quantity: Array) -> Array:
        """Return the derivative, shape (K, 1, entries)."""
        slope = np.zeros((quantity.shape[0], 1, quantity.shape[1]))
        slope[:, 0, :2] = -quantity[:, :2] / self._tangential(quantity)[:, None]
        slope[:, 0, 2] = self.friction
        return slope

    def curvature(self, quantity: Array, weights: Array) -> Array:
        """Return the Hessian, shape (K, entries, entries)."""
        length = self._tangential(quantity)[:, None, None]
        f = quantity[:, :2]
        hessian = np.zeros((*quantity.shape, quantity.shape[1]))
        hessian[:, :2, :2] = (f[:, :, None] * f[:, None, :] / length**2 - np.eye(2)) / length
        return weights[:, :1, None] * hessian

    def _tangential(self, quantity: Array) -> Array:
        x, y = quantity[:, 0], quantity[:, 1]
        return np.asarray(np.sqrt(x**2 + y**2 + self.smoothing**2))


@dataclass(frozen=True)
class Torsion(RowMap):
    """c f_z -+ M of a force and moment, M about the vertical through the centre of pressure.

    M = m_z + (m_x f_x + m_y f_y) / f_z, with f_z / (f_z² + least²) for 1 / f_z, so that it stays
    smooth where the load vanishes; there M is about the origin.
    """

    coefficient: float
    least: float

    def value(self, quantity: Array) -> Array:
        """Return the margins to both sides, shape (K, 2)."""
        f, m = quantity[:, :3], quantity[:, 3:]
        lever = (m[:, :2] * f[:, :2]).sum(axis=1)
        moment, limit = m[:, 2] + lever * self._inverse(f)[0], self.coefficient * f[:, 2]
        return np.stack([limit - moment, limit + moment], axis=1)

    def slope(self, quantity: Array) -> Array:
        """Return the derivative, shape (K, 2, 6)."""
        f, m = quantity[:, :3], quantity[:, 3:]
        g, dg, _ = self._inverse(f)
        moment = np.zeros(quantity.shape)
        moment[:, :2], moment[:, 3:5] = m[:, :2] * g[:, None], f[:, :2] * g[:, None]
        moment[:, 2], moment[:, 5] = (m[:, :2] * f[:, :2]).sum(axis=1) * dg, 1.0
        limit = self.coefficient * np.eye(6)[2]
        return np.stack([limit - moment, limit + moment], axis=1)

    def curvature(self, quantity: Array, weights: Array) -> Array:
        """Return the Hessian, shape (K, 6, 6)."""
        f, m = quantity[:, :3], quantity[:, 3:]
        g, dg, ddg = self._inverse(f)
        upper = np.zeros((len(quantity), 6, 6))
        upper[:, 0, 3] = upper[:, 1, 4] = g
        upper[:, :2, 2], upper[:, 2, 3:5] = m[:, :2] * dg[:, None], f[:, :2] * dg[:, None]
        hessian = upper + upper.swapaxes(1, 2)
        hessian[:, 2, 2] = (m[:, :2] * f[:, :2]).sum(axis=1) * ddg
        return np.asarray((weights[:, 1] - weights[:, 0])[:, None, None] * hessian)

    def _inverse(self, force: Array) -> tuple[Array, Array, Array]:
        """f_z / (f_z² + least²) and its two derivatives, shape (K,) each."""
        f, square = force[:, 2], force[:, 2] ** 2 + self.least**2
        bend = 2.0 * f * (f**2 - 3.0 * self.least**2) / square**3
        return f / square, (self.least**2 - f**2) / square**2, bend


@dataclass(frozen=True)
class Length(RowMap):
    """Euclidean length of a vector, Eq. (31)."""

    def value(self, quantity: Array) -> Array:
        """Return the lengths, shape (K, 1)."""
        return np.asarray(np.linalg.norm(quantity, axis=1)[:, None])

    def slope(self, quantity: Array) -> Array:
        """Return the unit vectors, shape (K, 1, 3)."""
        return (quantity / self.value(quantity))[:, None, :]

    def curvature(self, quantity: Array, weights: Array) -> Array:
        """Return weights (I - u u') / length, shape (K, 3, 3)."""
        length = self.value(quantity)[:, :, None]
        u = self.slope(quantity)
        return weights[:, :1, None] * (np.eye(3) - u.swapaxes(1, 2) * u) / length


@dataclass(frozen=True)
class Family:
    """Constraint rows of one kind.

    Attributes:
        name: of the family: "torque".
        equation: of the paper: "(28)".
        reads: the quantity.
        rows: the map from that quantity.
        labels: what each of the r rows speaks of: ("right_knee torque", ...).
        unit: of value and limits.
        lower, upper: limits, shape (K, r); infinite where there is none.
        scale: a change of the value that matters, shape (r,).
        instants: rows of the quantity it looks at, shape (K,).
        times: s = t / T of each of the K, or None where time means nothing.
    """

    name: str
    equation: str
    reads: Reads
    rows: RowMap
    labels: tuple[str, ...]
    unit: str
    lower: Array
    upper: Array
    scale: Array
    instants: NDArray[np.int_]
    times: Array | None

    @property
    def size(self) -> int:
        """Number of rows, K * r."""
        return int(self.lower.size)

    def take(self, quantity: Array) -> Array:
        """Return the instants of a quantity (K, ...) that the family looks at."""
        return quantity[self.where]

    @cached_property
    def per_unit(self) -> Array:
        """One over the scale of each row, shape (r, 1)."""
        return 1.0 / self.scale[:, None]

    @cached_property
    def where(self) -> NDArray[np.int_] | slice:
        """The instants, as a slice if they are consecutive: then nothing is copied."""
        if self.instants.size == 0 or np.any(np.diff(self.instants) != 1):
            return self.instants
        return slice(int(self.instants[0]), int(self.instants[-1]) + 1)
