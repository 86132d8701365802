"""One step of the walk: everything computed at x, and its exact derivatives.

Having a `Step` means that the work is done (see `StepModel` for how).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property

from gaitopt.gait.boundary import Posture, PostureSlope
from gaitopt.gait.parameters import DURATION, STEP_LENGTH
from gaitopt.mechanics.impact import ImpactSlope, ImpactState
from gaitopt.mechanics.readings import ReadingSlope
from gaitopt.mechanics.support import SupportSlope, SupportState
from gaitopt.nlp import Array


class Reads(Enum):
    """What a constraint or a cost may look at; the comments say how much of it there is."""

    TORQUE = "torque"  # at each instant (12) [N.m]
    WRENCH = "wrench"  # at each instant (6): ground force and moment in the stance sole [N, N.m]
    CORNERS = "corners"  # at each instant (12): corners of the swing sole, x y z each [m]
    ANGLES = "angles"  # at each instant (12) [rad]
    RATES = "rates"  # at each instant (12) [rad/s]
    IMPULSE = "impulse"  # once (6): of the ground on the landing foot [N.s, N.m.s]
    SOLE_TWIST = "sole_twist"  # once (6): old stance sole after the impact [m/s, rad/s]
    LEGS = "legs"  # two legs (3): ankle to hip in double support [m]
    GAPS = "gaps"  # two loops (6) in the lifted form, else none: pelvis, swing sole [m, 1]
    TRAVEL = "travel"  # once (2): step length [m], duration [s]
    TRUNK = "trunk"  # at each instant (3), if asked for: roll, pitch, yaw of the trunk [rad]
    LEG_GAPS = "leg_gaps"  # at each instant (pairs), if asked for: between bodies of the legs [m]

    # Members are single objects; Enum's own hash, in Python, is a twentieth of an evaluation.
    __hash__ = object.__hash__


@dataclass(frozen=True)
class Step:
    """Everything about one step at x.

    Attributes:
        x: parameters (P,).
        geometry: geometric quantities, free and fixed (10,).
        posture: double support at the start.
        q_end: posture at the end, E q_start, (12,).
        rate_before: joint rates before the impact (12,) [rad/s].
        impact: the robot just after it.
        coefficients: of the spline (n + 2, 12): knots, rate at start, rate at end.
        motion: q, dq, ddq at the instants, shape (3, N, 12).
        support: single support at the instants.
        optional: quantities that only some constraints look at; without entries unless they do.
    """

    x: Array
    geometry: Array
    posture: Posture
    q_end: Array
    rate_before: Array
    impact: ImpactState
    coefficients: Array
    motion: Array
    support: SupportState
    optional: dict[Reads, Array]

    @property
    def duration(self) -> float:
        """T [s]."""
        return float(self.geometry[DURATION])

    @property
    def step_length(self) -> float:
        """Distance d walked in one step [m]."""
        return float(self.geometry[STEP_LENGTH])

    def read(self, what: Reads) -> Array:
        """Return a quantity, one row per instant (or leg), shape (K, entries)."""
        return self._readings[what]

    @cached_property
    def _readings(self) -> dict[Reads, Array]:
        effort, corners = self.support.effort, self.support.corners
        return {
            Reads.TORQUE: effort[:, 6:],
            Reads.WRENCH: effort[:, :6],
            Reads.CORNERS: corners.reshape(len(corners), 12),
            Reads.ANGLES: self.motion[0],
            Reads.RATES: self.motion[1],
            Reads.IMPULSE: self.impact.impulse[None],
            Reads.SOLE_TWIST: self.impact.sole_twist[None],
            Reads.LEGS: self.posture.legs,
            Reads.GAPS: self.posture.gaps,
            Reads.TRAVEL: self.geometry[None, [STEP_LENGTH, DURATION]],
            **self.optional,
        }


@dataclass(frozen=True)
class StepSlope:
    """Derivatives of a step with respect to x.

    Attributes:
        posture, impact, support, optional: the local derivatives they are made of.
        coefficients: of the spline coefficients, shape (n + 2, 12, P).
        motion: of (q, dq, ddq) at each instant, shape (N, 36, P).
        reads: of each quantity, shape (K, entries, P).
    """

    posture: PostureSlope
    impact: ImpactSlope
    support: SupportSlope
    optional: dict[Reads, ReadingSlope]
    coefficients: Array
    motion: Array
    reads: dict[Reads, Array]
