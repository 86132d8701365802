"""The instants at which the step is looked at, and the quadrature over them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gaitopt.bounds import SAMPLES, at_most, shown
from gaitopt.errors import InputError
from gaitopt.nlp import Array

QUADRATURES = ("simpson", "euler")


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
        """Return the grid with instants added, where constraints hold but nothing is integrated."""
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
        raise InputError(f"quadrature '{quadrature}' is unknown; choose {' or '.join(QUADRATURES)}")
    if samples < 3:
        raise InputError(f"{shown(samples)} samples are too few for a step; give at least 3")
    at_most(samples, SAMPLES, "samples")
    if quadrature == "simpson" and samples % 2 == 0:
        raise InputError(
            f"Simpson's rule needs an odd number of samples, not {samples}; "
            f"give {samples + 1}, or quadrature 'euler'"
        )
    step = 1.0 / (samples - 1)
    if quadrature == "euler":
        weights = np.full(samples, step)
        weights[-1] = 0.0
    else:
        weights = np.full(samples, 2.0 * step / 3.0)
        weights[1::2] = 4.0 * step / 3.0
        weights[[0, -1]] = step / 3.0
    return Grid(np.linspace(0.0, 1.0, samples), weights, samples)
