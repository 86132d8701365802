"""How the stance foot turns about a line of its sole at the end of a step.

The angle is 0 until the last phase begins; from there it is a clamped cubic spline of time that
leaves 0 with rate 0, linear in its parameters: angle at the end, at the inner knots, rate at the
end. Its second derivative jumps where it begins, and with it torques and wrench.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gaitopt.contact.schedule import Schedule
from gaitopt.gait.spline import SplineBasis, spline_basis
from gaitopt.nlp import Array

INNER_KNOTS = 1
NAMES = (
    "foot_angle_at_end",
    *(f"foot_angle_inside_{k + 1}" for k in range(INNER_KNOTS)),
    "foot_rate_at_end",
)
"""Parameters [rad, ..., rad/s]; the first is also the angle of the rear foot at the next start."""
LARGEST_ANGLE = 0.8  # rad: what of a foot turned farther rests on the ground is no line of its sole
LARGEST_RATE = 15.0  # rad/s
ANGLE_SCALE, RATE_SCALE = 0.3, 4.0  # rad, rad/s: sensible sizes of an optimisation step


@dataclass(frozen=True)
class FootTurn:
    """The angle of the hinge as a function of the parameters.

    Attributes:
        begin: share of the step at which the last phase begins.
        instants: s of the instants, shape (N,).
    """

    begin: float
    instants: Array

    @cached_property
    def knots(self) -> Array:
        """Share of the step of the spline's knots, shape (m,)."""
        return np.linspace(self.begin, 1.0, INNER_KNOTS + 2)

    @cached_property
    def basis(self) -> SplineBasis:
        """From spline coefficients (m + 2,) to angle, rate and acceleration; 0 before it begins."""
        basis = spline_basis(self.knots, np.maximum(self.instants, self.begin))
        turning = self.instants > self.begin
        return replace(basis, instants=self.instants, unit=basis.unit * turning[:, None, None])

    @cached_property
    def coefficients(self) -> Array:
        """Matrix from parameters to spline coefficients, shape (m + 2, p)."""
        matrix = np.zeros((INNER_KNOTS + 4, len(NAMES)))
        matrix[INNER_KNOTS + 1, 0] = 1.0
        matrix[1 : INNER_KNOTS + 1, 1:-1] = np.eye(INNER_KNOTS)
        matrix[-1, -1] = 1.0
        return matrix

    def guess(self, angle: float, duration: float) -> Array:
        """Return parameters of an angle that grows as the square of time, shape (p,).

        Args:
            angle: at the end [rad].
            duration: of the step [s].
        """
        inner = angle * (np.arange(1, INNER_KNOTS + 1) / (INNER_KNOTS + 1)) ** 2
        found: Array = np.r_[angle, inner, 2.0 * angle / ((1.0 - self.begin) * duration)]
        return found


def foot_turn(schedule: Schedule, instants: Array) -> FootTurn:
    """Return the turn of a schedule whose last phase has a hinge."""
    begin = float(schedule.changes[-1]) if schedule.changes.size else 0.0
    return FootTurn(begin, instants)
