"""What can be read off the postures of a step beyond what every walk needs.

A reading is computed only if a constraint looks at it. It depends on the joint angles alone, so its
local derivatives come from the placements of the bodies and the joint axes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from gaitopt.mechanics.bodies import Placements
from gaitopt.nlp import Array


class ReadingSlope(ABC):
    """A reading at N postures and its local derivatives.

    Attributes:
        value: the reading, shape (N, entries).
        jacobian: with respect to q, shape (N, entries, 12).
    """

    value: Array
    jacobian: Array

    @abstractmethod
    def curvature(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * reading), weights (N, entries), (N, 12, 12)."""


class Reading(ABC):
    """A quantity of the posture at each instant."""

    @abstractmethod
    def value(self, placed: Placements) -> Array:
        """Return the reading, shape (N, entries)."""

    @abstractmethod
    def slope(self, placed: Placements, axes: Array) -> ReadingSlope:
        """Return it with its derivatives.

        Args:
            placed: the bodies.
            axes: joint motion axes in the world, shape (N, 12, 6).
        """
