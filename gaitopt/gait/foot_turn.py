"""How the stance foot turns about a line of its sole: after it landed on it, before it leaves.

Before it leaves, the angle is 0 until the last phase begins; from there it is a clamped cubic
spline of time that leaves 0 with rate 0, linear in its parameters: angle at the end, at the inner
knots, rate at the end. Its second derivative jumps where it begins, and with it torques and wrench.

A foot that landed on a line starts with an angle that is a parameter and with the rate that the
impact leaves it; a spline of the first phase brings both to 0 at its end: the foot meets the ground
flat without a second impact. With one, the rate at the end is a parameter too, the last.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from gaitopt.contact import Schedule
from gaitopt.dataclass import dataclass
from gaitopt.gait.spline import SplineBasis, spline_basis
from gaitopt.nlp import Array

INNER_KNOTS = 1
_INSIDE = tuple(f"inside_{k + 1}" for k in range(INNER_KNOTS))
NAMES = ("foot_angle_at_end", *(f"foot_angle_{k}" for k in _INSIDE), "foot_rate_at_end")
"""Parameters [rad, ..., rad/s]; the first is also the angle of the rear foot at the next start."""
LANDING_NAMES = ("landing_angle", *(f"landing_angle_{k}" for k in _INSIDE))
"""Parameters of a foot that lands on a line [rad, ...], the angle of the landing first."""
SLAP_NAME = "landing_rate_at_flat"
"""One more where it comes to lie flat by an impact: the rate before it [rad/s]."""
LARGEST_ANGLE = 0.8  # rad: what of a foot turned farther rests on the ground is no line of its sole
LARGEST_RATE = 15.0  # rad/s
ANGLE_SCALE, RATE_SCALE = 0.3, 4.0  # rad, rad/s: sensible sizes of an optimisation step


@dataclass(frozen=True)
class FootTurn:
    """The angle of the hinge as a function of what shapes it, p numbers.

    They are the parameters before the foot leaves; after a landing the parameters, then the rate
    that the impact leaves [rad/s].

    Attributes:
        begin: share of the step at which the foot begins to turn.
        instants: s of the instants, shape (N,).
        end: share of the step at which it stops.
        landed: whether it turns after its landing.
        slapping: whether that ends with a rate.
    """

    begin: float
    instants: Array
    end: float = 1.0
    landed: bool = False
    slapping: bool = False

    @cached_property
    def knots(self) -> Array:
        """Share of the step of the spline's knots, shape (m,)."""
        return np.linspace(self.begin, self.end, INNER_KNOTS + 2)

    @cached_property
    def basis(self) -> SplineBasis:
        """From spline coefficients (m + 2,) to angle, rate and acceleration; 0 beyond its ends."""
        basis = spline_basis(self.knots, np.clip(self.instants, self.begin, self.end))
        turning = (self.instants > self.begin) | self.landed
        turning &= self.instants <= self.end
        return replace(basis, instants=self.instants, unit=basis.unit * turning[:, None, None])

    @cached_property
    def coefficients(self) -> Array:
        """Matrix from what shapes it to spline coefficients, shape (m + 2, p)."""
        matrix = np.zeros((INNER_KNOTS + 4, INNER_KNOTS + 2 + self.slapping))
        angle, rate = (0, -2) if self.landed else (INNER_KNOTS + 1, -1)
        matrix[angle, 0] = matrix[rate, -1] = 1.0
        inner = slice(1, INNER_KNOTS + 1)
        matrix[inner, inner] = np.eye(INNER_KNOTS)
        if self.slapping:
            matrix[-1, -2] = 1.0
        return matrix

    def guess(self, angle: float, duration: float) -> Array:
        """Return what shapes an angle that grows or falls as the square of time, shape (p,).

        One that ends with a rate falls evenly.

        Args:
            angle: at the end, or at the landing [rad].
            duration: of the step [s].
        """
        share = np.arange(1, INNER_KNOTS + 1) / (INNER_KNOTS + 1)
        power = 1.0 if self.slapping else 2.0
        inner = angle * (1.0 - share if self.landed else share) ** power
        rate = power * angle / ((self.end - self.begin) * duration)
        ends = np.full(1 + self.slapping, -rate if self.landed else rate)
        found: Array = np.r_[angle, inner, ends]
        return found


def with_knot(turn: FootTurn, shape: Array, duration: float, at: float) -> tuple[Array, Array]:
    """Return knots and coefficients of the same turn with one knot more.

    Args:
        duration: of the step [s].
        at: the knot, as a share of the step.

    Returns:
        Shares of the step (k,), and angles at them, then the rates at both ends (k + 2,).
    """
    near = np.abs(turn.knots - at) < 1e-9
    knots = turn.knots if near.any() else np.sort(np.append(turn.knots, at))
    plain = turn.coefficients @ shape
    angles = replace(turn, instants=knots).basis.at(duration)[:, 0] @ plain
    return knots, np.concatenate([angles, plain[-2:]])


def foot_turn(schedule: Schedule, instants: Array) -> FootTurn:
    """Return the turn at instants (N,) of a schedule whose last phase has a hinge."""
    return FootTurn(schedule.turns_from, instants)


def landing_turn(schedule: Schedule, instants: Array) -> FootTurn:
    """Return the turn at instants (N,) of a schedule whose first phase has a hinge."""
    end, slapping = schedule.first.end, schedule.slapping
    return FootTurn(0.0, instants, end, landed=True, slapping=slapping)
