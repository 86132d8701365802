"""Truncated power series in at most two variables: exact derivatives up to the third order."""

from __future__ import annotations

import math

import numpy as np

from gaitopt.nlp import Array

ORDER = 3
"""Up to which derivatives are exact."""

_POWERS = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
_PLACE = {power: k for k, power in enumerate(_POWERS)}
_PRODUCTS = [
    (a, b, _PLACE[p[0] + q[0], p[1] + q[1]])
    for a, p in enumerate(_POWERS)
    for b, q in enumerate(_POWERS)
    if sum(p) + sum(q) <= ORDER
]
_LEFT, _RIGHT = ([one[side] for one in _PRODUCTS] for side in (0, 1))
_GATHER = np.array([[float(c == k) for _, _, c in _PRODUCTS] for k in range(len(_POWERS))])


class Series:
    """Power series in at most two variables up to the third order, of K postures at once.

    Attributes:
        terms: coefficients of x^i y^j in the order of `_POWERS`, shape (10, K).
    """

    def __init__(self, terms: Array) -> None:
        self.terms = terms

    @classmethod
    def constant(cls, value: Array) -> Series:
        """Return numbers (K,) that depend on nothing."""
        terms = np.zeros((len(_POWERS), len(value)))
        terms[0] = value
        return cls(terms)

    @classmethod
    def variable(cls, number: int, value: Array) -> Series:
        """Return one of the variables at some values (K,)."""
        found = cls.constant(value)
        found.terms[_PLACE[(1, 0) if number == 0 else (0, 1)]] = 1.0
        return found

    def __add__(self, other: Series | float) -> Series:
        if isinstance(other, Series):
            return Series(self.terms + other.terms)
        terms = self.terms.copy()
        terms[0] += other
        return Series(terms)

    def __mul__(self, other: Series | float) -> Series:
        if not isinstance(other, Series):
            return Series(self.terms * other)
        return Series(_GATHER @ (self.terms[_LEFT] * other.terms[_RIGHT]))

    def through(self, *derivatives: Array) -> Series:
        """Return f of it, given f and its first three derivatives at its value, (K,) each."""
        moved = Series(self.terms.copy())
        moved.terms[0] = 0.0
        found, power = Series.constant(derivatives[0]), moved
        for order, one in enumerate(derivatives[1:], 1):
            found = found + Series(power.terms * (one / math.factorial(order)))
            power = power * moved
        return found

    @property
    def value(self) -> Array:
        """The numbers themselves, (K,)."""
        return np.asarray(self.terms[0])

    def at(self, variables: tuple[int, ...]) -> Array:
        """Return the derivative in some variables, (K,)."""
        i, j = variables.count(0), variables.count(1)
        return np.asarray(self.terms[_PLACE[i, j]] * math.factorial(i) * math.factorial(j))


def dot(point: list[Series], direction: Array) -> Series:
    """Return the component of a point along a direction (3,)."""
    x, y, z = (one * float(d) for one, d in zip(point, direction, strict=True))
    return x + y + z


def cross_matrix(axis: Array) -> Array:
    """Return the matrix of the cross products of an axis (3,) with vectors, shape (3, 3).

    Not `pinocchio.skew`: the command reads tables of linkages before it imports Pinocchio.
    """
    return np.cross(np.eye(3), axis)


def turned_about(point: list[Series], axis: Array, angle: Series) -> list[Series]:
    """Return a point turned about an axis of unit length, shape (3,) (Rodrigues)."""
    a = angle.value
    sine = angle.through(np.sin(a), np.cos(a), -np.sin(a), -np.cos(a))
    versine = angle.through(1.0 - np.cos(a), np.sin(a), np.cos(a), -np.sin(a))
    once = cross_matrix(axis)
    twice = once @ once
    return [
        own + dot(point, once[k]) * sine + dot(point, twice[k]) * versine
        for k, own in enumerate(point)
    ]
