"""Clamped cubic splines through knots, Eqs. (40)-(44), as constant matrices.

In s = t / T a spline is linear in its coefficients c = (knot values, T * rate at start, T * rate at
end), so a whole motion is one matrix product, and so is its derivative with respect to any of them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache
from math import comb

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.nlp import Array

_VALUE_POWERS = np.array([0.0, -1.0, -2.0])  # of T, for q, dq, ddq per unit of a knot value
_GRIDS = 16  # of knots: a design has one, or a few where feet turn or both stand
_KEPT = 6  # maps: of two durations, as of a trial point and the one before it
_RATE_POWERS = np.array([1.0, 0.0, -1.0])  # of T, for q, dq, ddq per unit of an end rate


@dataclass(frozen=True)
class SplineBasis:
    """The linear map from coefficients to motion at chosen instants.

    Coefficients are ordered: value at each of the n knots, rate at the start, rate at the end.

    Attributes:
        knots: s of the knots, from 0 to 1, shape (n,).
        instants: s of the instants, shape (N,).
        unit: the map for T = 1, shape (N, 3, n + 2); the middle axis is (q, dq, ddq).
    """

    knots: Array
    instants: Array
    unit: Array

    def at(self, duration: float, order: int = 0) -> Array:
        """Return the map for step duration T, or its derivative of given order in T.

        Args:
            duration: T [s].
            order: 0, 1 or 2.

        Returns:
            Shape (N, 3, n + 2), read-only: it is kept, as the same is asked for several times.
        """
        if (duration, order) not in self._maps:
            if len(self._maps) == _KEPT:
                self._maps.clear()
            factor = duration ** (self._powers - order)
            for k in range(order):
                factor *= self._powers - k
            self._maps[duration, order] = self.unit * factor
            self._maps[duration, order].setflags(write=False)
        return self._maps[duration, order]

    @cached_property
    def _maps(self) -> dict[tuple[float, int], Array]:
        return {}

    @cached_property
    def _powers(self) -> Array:
        """Powers of T that the entries of the map grow with, shape (3, n + 2)."""
        powers = np.repeat(_VALUE_POWERS[:, None], self.knots.size + 2, axis=1)
        powers[:, -2:] = _RATE_POWERS[:, None]
        return powers


@dataclass(frozen=True)
class TwoSplines:
    """One spline after another, which share their knot and nothing else: the rates may jump there.

    Coefficients are those of the first, then those of the second.

    Attributes:
        parts: their bases, at all instants.
        later: at which instants the second one counts, shape (N,).
    """

    parts: tuple[SplineBasis, SplineBasis]
    later: NDArray[np.bool_]

    @property
    def knots(self) -> Array:
        """Knots of both (k,), from 0 to 1, the one they share once."""
        first, second = (part.knots for part in self.parts)
        return np.concatenate([first, second[1:]])

    @property
    def instants(self) -> Array:
        """The instants s, shape (N,)."""
        return self.parts[0].instants

    def at(self, duration: float, order: int = 0) -> Array:
        """Return the map for step duration T, as of `SplineBasis`, shape (N, 3, coefficients)."""
        chosen = self.later[:, None, None]
        first, second = (part.at(duration, order) for part in self.parts)
        return np.concatenate([first * ~chosen, second * chosen], axis=2)


def two_splines(early: Array, late: Array, instants: Array, later: NDArray[np.bool_]) -> TwoSplines:
    """Build the basis of two splines.

    Args:
        early, late: their knots in s = t / T; the last of one is the first of the other.
        instants: within [0, 1], shape (N,).
        later: at which of them the second one counts, shape (N,).
    """
    parts = (
        replace(spline_basis(knots, np.clip(instants, knots[0], knots[-1])), instants=instants)
        for knots in (early, late)
    )
    first, second = parts
    return TwoSplines((first, second), later)


@dataclass(frozen=True)
class JumpingSpline:
    """A spline whose rates jump at one of its knots.

    Coefficients are ordered: value at each of the n knots but the last, rates before and after the
    jump, then as of a `SplineBasis`: last value, rate at the start, rate at the end.

    Attributes:
        parts: before and after the jump.
        columns: from these coefficients to those of the parts, constant, shape (n + 5, n + 4).
    """

    parts: TwoSplines
    columns: Array

    @property
    def knots(self) -> Array:
        """Knots from 0 to 1, shape (n,)."""
        return self.parts.knots

    @property
    def instants(self) -> Array:
        """The instants s, shape (N,)."""
        return self.parts.instants

    def at(self, duration: float, order: int = 0) -> Array:
        """Return the map for step duration T, as of `SplineBasis`, shape (N, 3, n + 4)."""
        return np.asarray(self.parts.at(duration, order) @ self.columns)


def jumping_spline(knots: Array, instants: Array, jump: float) -> JumpingSpline:
    """Build the basis of a spline whose rates jump at a knot; at that instant they have not yet.

    Args:
        knots, instants: as of `spline_basis`.
        jump: one of the inner knots.
    """
    at = int(np.argmin(np.abs(knots - jump)))
    parts = two_splines(knots[: at + 1], knots[at:], instants, instants > knots[at])
    n = knots.size
    values = [*range(n - 1), n + 1]
    before, after, start, end = n - 1, n, n + 2, n + 3
    order = [*values[: at + 1], start, before, *values[at:], after, end]
    return JumpingSpline(parts, np.eye(n + 4)[order])


def spline_basis(knots: Array, instants: Array) -> SplineBasis:
    """Build the basis for knots and instants in s = t / T.

    Args:
        knots: increasing, first 0, last 1, shape (n,), n >= 2.
        instants: within [0, 1], shape (N,).
    """
    size = knots.size
    second = _knot_second_derivatives(tuple(knots.tolist()))
    values = np.eye(size, size + 2)
    piece = np.clip(np.searchsorted(knots, instants, side="right") - 1, 0, size - 2)
    h = np.diff(knots)[piece][:, None]
    b = (instants - knots[piece])[:, None] / h
    a = 1.0 - b
    left, right = values[piece], values[piece + 1]
    left_second, right_second = second[piece], second[piece + 1]
    position = (
        a * left + b * right + h**2 / 6 * ((a**3 - a) * left_second + (b**3 - b) * right_second)
    )
    rate = (right - left) / h + h / 6 * (
        (3 * b**2 - 1) * right_second - (3 * a**2 - 1) * left_second
    )
    return SplineBasis(
        knots, instants, np.stack([position, rate, a * left_second + b * right_second], 1)
    )


Basis = SplineBasis | TwoSplines | JumpingSpline


def on_coefficients(basis: Basis, duration: float, weights: Array, order: int = 0) -> Array:
    """Return what weights of a motion (N, 3, j) weigh on its spline's coefficients, shape (K, j).

    Args:
        basis, duration, order: of the map from them, as of `SplineBasis.at`.
        weights: of (q, dq, ddq) of j joints.
    """
    linear = basis.at(duration, order)
    return np.asarray(linear.reshape(-1, linear.shape[2]).T @ weights.reshape(-1, weights.shape[2]))


@dataclass(frozen=True)
class SplineInX:
    """Splines of j joints whose coefficients, and perhaps their duration, depend on parameters x.

    Attributes:
        basis: of the splines.
        duration: T [s].
        coefficients: shape (K, j).
        jacobian: their derivatives in x, shape (K, j, P).
        lasts: derivatives of T in x, shape (P,); None where T is fixed.
    """

    basis: Basis
    duration: float
    coefficients: Array
    jacobian: Array
    lasts: Array | None

    def motion(self) -> Array:
        """Return the derivatives of (q, dq, ddq) in x, shape (N, 3, j, P)."""
        linear, (count, *sizes) = self.basis.at(self.duration), self.jacobian.shape
        found = linear.reshape(-1, count) @ self.jacobian.reshape(count, -1)
        found = found.reshape(-1, 3, *sizes)
        if self.lasts is not None:
            stretched = self.basis.at(self.duration, 1) @ self.coefficients
            for column in np.flatnonzero(self.lasts):
                found[..., column] += self.lasts[column] * stretched
        return np.asarray(found)

    def hessian(self, weights: Array) -> Array:
        """Return the Hessian in x of weights (N, 3, j) . motion, coefficients linear, (P, P)."""
        P = self.jacobian.shape[2]
        if self.lasts is None:
            return np.zeros((P, P))
        first, second = (
            on_coefficients(self.basis, self.duration, weights, order) for order in (1, 2)
        )
        H = np.outer(self.lasts, first.ravel() @ self.jacobian.reshape(-1, P))
        twice = float(np.sum(second * self.coefficients))
        return np.asarray(H + H.T + twice * np.outer(self.lasts, self.lasts))


def bernstein(share: Array, degree: int = 3) -> Array:
    """Return the Bernstein polynomials at shares of an interval, shape (N, degree + 1)."""
    k, s = np.arange(degree + 1), share[:, None]
    ways = np.array([comb(degree, one) for one in range(degree + 1)])
    return np.asarray(ways * s**k * (1.0 - s) ** (degree - k))


@lru_cache(maxsize=_GRIDS)
def _knot_second_derivatives(knots: tuple[float, ...]) -> Array:
    """Second derivatives at the knots as a map of the coefficients, shape (n, n + 2), read-only.

    Continuity of the first derivative at the inner knots and the given end rates make a tridiagonal
    system (de Boor, 2001, chapter IV).
    """
    size = len(knots)
    h = np.diff(knots)
    matrix, rhs = np.zeros((size, size)), np.zeros((size, size + 2))
    slope = np.zeros((size - 1, size + 2))
    rows = np.arange(size - 1)
    slope[rows, rows + 1], slope[rows, rows] = 1.0 / h, -1.0 / h
    matrix[0, :2] = h[0] / 3, h[0] / 6
    rhs[0] = slope[0]
    rhs[0, -2] -= 1.0
    matrix[-1, -2:] = h[-1] / 6, h[-1] / 3
    rhs[-1] = -slope[-1]
    rhs[-1, -1] += 1.0
    for i in range(1, size - 1):
        matrix[i, i - 1 : i + 2] = h[i - 1] / 6, (h[i - 1] + h[i]) / 3, h[i] / 6
        rhs[i] = slope[i] - slope[i - 1]
    found = np.asarray(np.linalg.solve(matrix, rhs), dtype=np.float64)
    found.setflags(write=False)
    return found
