"""The instants at which the step is looked at, and the quadrature over them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import SAMPLES, at_most, shown
from gaitopt.contact import AFTER
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, did_you_mean
from gaitopt.nlp import Array

QUADRATURES = ("simpson", "euler")
NODES = 20
"""Chebyshev points of a piece of the proof's grid: torques of walks are then known to 1e-11 of
their limits between them (docs/decisions/extremes.md)."""


_ROUNDING = 1e-9  # of numbers of intervals


@dataclass(frozen=True)
class Grid:
    """Instants in s = t / T and their weights in an integral over the step.

    Attributes:
        instants: shape (N,); the quadrature nodes in order, then instants added by refinement.
        weights: for T = 1, shape (N,); zero at added instants.
        nodes: number of quadrature nodes.
    """

    instants: Array
    weights: Array
    nodes: int

    @property
    def count(self) -> int:
        """Number of instants."""
        return int(self.instants.size)

    def with_instants(self, extra: Array) -> Grid:
        """Return the grid with instants (K,) added, whose rows hold but are not integrated."""
        new = np.setdiff1d(np.round(extra, 12), np.round(self.instants, 12))
        return replace(
            self,
            instants=np.concatenate([self.instants, new]),
            weights=np.concatenate([self.weights, np.zeros(new.size)]),
        )


def uniform_grid(samples: int, quadrature: str = "simpson") -> Grid:
    """Return equidistant instants with the weights of a quadrature rule.

    Args:
        samples: number of instants, at least 3; odd for Simpson's rule.
        quadrature: "simpson", or "euler" (the paper's sum, left end points).

    Raises:
        InputError: unknown rule, too few samples, or an even number of them for Simpson's rule.
    """
    if quadrature not in QUADRATURES:
        raise InputError(
            f"quadrature '{quadrature}' is unknown; {did_you_mean(quadrature, QUADRATURES)}choose "
            f"{' or '.join(QUADRATURES)}"
        )
    if samples < 3:
        raise InputError(f"{shown(samples)} samples are too few for a step; give at least 3")
    at_most(samples, SAMPLES, "samples")
    if quadrature == "simpson" and samples % 2 == 0:
        raise InputError(
            f"Simpson's rule needs an odd number of samples, not {samples}; "
            f"give {samples + 1}, or quadrature 'euler'"
        )
    return Grid(np.linspace(0.0, 1.0, samples), _weights(samples, quadrature), samples)


def _weights(samples: int, quadrature: str) -> Array:
    """Weights of equidistant samples in an integral over [0, 1]."""
    step = 1.0 / (samples - 1)
    if quadrature == "euler":
        weights = np.full(samples, step)
        weights[-1] = 0.0
        return weights
    weights = np.full(samples, 2.0 * step / 3.0)
    weights[1::2] = 4.0 * step / 3.0
    weights[[0, -1]] = step / 3.0
    return weights


def phase_grid(samples: int, quadrature: str, changes: Array) -> Grid:
    """Return equidistant instants in each phase of a step, both sides of every change included.

    What jumps at a change is integrated on both sides apart. The phases share the samples by their
    lengths, rounded up to what the rule needs.

    Args:
        changes: shares of the step at which one phase follows another, shape (k,).

    Raises:
        InputError: as of `uniform_grid`.
    """
    whole = uniform_grid(samples, quadrature)
    if changes.size == 0:
        return whole
    starts, ends = np.r_[0.0, changes + AFTER], np.r_[changes, 1.0]
    instants, weights = [], []
    for start, end in zip(starts, ends, strict=True):
        count = 1 + 2 * max(1, math.ceil((end - start) * (samples - 1) / 2.0 - _ROUNDING))
        instants.append(np.linspace(start, end, count))
        weights.append((end - start) * _weights(count, quadrature))
    joined = np.concatenate(instants)
    return Grid(joined, np.concatenate(weights), joined.size)


STRIDE_EDGES = np.array([0.0, 0.5, 1.0])
"""Shares of a stride of two steps at which they begin and end."""


def over_steps(shares: Array, edges: Array) -> Array:
    """Return where steps follow each other, and shares of each of them, as shares of them all.

    Args:
        shares: of every step, shape (k,); its ends are left out.
        edges: as of `parts`.
    """
    inner = shares[(shares > 0.0) & (shares < 1.0)]
    each = [a + length * inner for a, length in zip(edges, np.diff(edges), strict=False)]
    return np.unique(np.concatenate([edges[1:-1], *each]))


def parts(grid: Grid, edges: Array, changes: Array | None = None) -> tuple[Grid, ...]:
    """Return the instants of every step of several, as shares of that step, in their order.

    Args:
        edges: shares at which steps begin and end, from 0 to 1, shape (steps + 1,).
        changes: shares of a step at which one phase follows another, whose two sides the
            instants are to meet exactly.
    """
    found = []
    for number, (begin, length) in enumerate(zip(edges, np.diff(edges), strict=False)):
        kept, near = step_of(grid.instants, edges) == number, AFTER / length
        s = np.minimum((grid.instants[kept] - begin) / length, 1.0)
        s[s <= 2.0 * near] = 0.0
        s[s >= 1.0 - AFTER] = 1.0
        for change in () if changes is None else changes:
            s[np.abs(s - change) < 0.5 * AFTER] = change
            s[np.abs(s - change - near) < 0.75 * near] = change + AFTER
        found.append(Grid(s, grid.weights[kept] / length, int(kept[: grid.nodes].sum())))
    return tuple(found)


def step_of(instants: Array, edges: Array) -> NDArray[np.int_]:
    """Return the number of the step of each instant; where two meet it is of the first.

    Args:
        instants: shares of all steps, shape (N,).
        edges: as of `parts`.
    """
    return np.asarray(np.searchsorted(edges[1:-1], instants, side="left"))


def chebyshev_points(count: int) -> Array:
    """Return the zeros of the Chebyshev polynomial of degree `count`, increasing, in (-1, 1)."""
    return np.asarray(-np.cos((np.arange(count) + 0.5) * np.pi / count))


def proof_grid(knots: Array) -> Grid:
    """Return the instants at which a walk is proven, whatever its samples.

    Chebyshev points between every two knots of the spline, where all quantities are smooth, with
    the weights of Fejer's first rule (Waldvogel, BIT 46, 2006), and both ends of the step without
    weight.

    Args:
        knots: s of the knots and of the changes of phase, from 0 to 1, shape (n,).
    """
    angles = (np.arange(NODES) + 0.5) * np.pi / NODES
    orders = np.arange(1, NODES // 2 + 1)
    terms = np.cos(2.0 * np.outer(angles, orders)) / (4.0 * orders**2 - 1.0)
    weights = (1.0 - 2.0 * terms.sum(axis=1)) / NODES  # of [0, 1]
    points = 0.5 * (chebyshev_points(NODES) + 1.0)
    lengths = np.diff(knots)
    inside = (knots[:-1, None] + lengths[:, None] * points).ravel()
    instants = np.concatenate([[0.0], inside, [1.0]])
    weighed = np.concatenate([[0.0], np.outer(lengths, weights).ravel(), [0.0]])
    return Grid(instants, weighed, instants.size)
