"""The cost of Eqs. (46) and (47): squared torque per metre walked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.gait.step import Reads, Step
from gaitopt.nlp import Array


@dataclass(frozen=True)
class TorqueCost:
    """J = (1 / d) integral of Gamma' Gamma dt, with (47) the term rho (V T - d)².

    Attributes:
        weights: of the quadrature for T = 1, shape (N,).
        speed: V [m/s].
        penalty: rho [cost / m²]; zero for Eq. (46).
    """

    weights: Array
    speed: float
    penalty: float = 0.0

    def value(self, step: Step) -> float:
        """Return J [N²·m·s]."""
        effort, d, T = self._effort(step), step.step_length, step.duration
        return T / d * effort + self.penalty * (self.speed * T - d) ** 2

    def slope(self, step: Step) -> dict[Reads, Array]:
        """Return the derivatives with respect to what the cost reads, Eqs. (50)-(57).

        Torque: shape (N, n); travel (d, T): shape (1, 2).
        """
        effort, d, T = self._effort(step), step.step_length, step.duration
        torque = step.read(Reads.TORQUE)
        gap = 2.0 * self.penalty * (self.speed * T - d)
        return {
            Reads.TORQUE: (2.0 * T / d * self.weights)[:, None] * torque,
            Reads.TRAVEL: np.array([[-T / d**2 * effort - gap, effort / d + self.speed * gap]]),
        }

    def torque_curvature(self, step: Step) -> Array:
        """Return the second derivative with respect to each torque, shape (N,)."""
        return 2.0 * step.duration / step.step_length * self.weights

    def travel_curvature(self, step: Step) -> Array:
        """Return the second derivative with respect to (d, T), shape (2, 2)."""
        effort, d, T = self._effort(step), step.step_length, step.duration
        V, rho = self.speed, self.penalty
        return np.array(
            [
                [2.0 * T / d**3 * effort + 2.0 * rho, -effort / d**2 - 2.0 * rho * V],
                [-effort / d**2 - 2.0 * rho * V, 2.0 * rho * V**2],
            ]
        )

    def mixed_curvature(self, step: Step) -> tuple[Array, Array]:
        """Return d²J / d(torque) d(d, T) as d(Gamma'Gamma integral) (N, n) and d(T/d) (2,)."""
        d, T = step.step_length, step.duration
        torque = step.read(Reads.TORQUE)
        return 2.0 * self.weights[:, None] * torque, np.array([-T / d**2, 1.0 / d])

    def _effort(self, step: Step) -> float:
        """Integral of Gamma' Gamma for T = 1."""
        return float(self.weights @ (step.read(Reads.TORQUE) ** 2).sum(axis=1))
