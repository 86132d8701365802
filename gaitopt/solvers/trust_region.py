"""How far a step may go: the radius of the trust region and the ratio that drives it."""

from __future__ import annotations

from dataclasses import dataclass

POOR = 0.25
"""Below this ratio the radius shrinks (Nocedal & Wright, 2006, Algorithm 4.1)."""
GOOD = 0.75
"""Above this ratio the radius grows if the step was held by it (same algorithm)."""
SHRINK = 0.25
"""Factor of a shrinking radius, applied to the step's length (same algorithm)."""
GROW = 2.0
"""Factor of a growing radius (same algorithm)."""
INTERIOR = 0.99
"""A step shorter than this share of the radius is not held by the trust region."""
ROUNDING = 1e-12
"""Relative rounding error of cost and rows (measured; its use is that of Conn,
Gould & Toint, 2000, section 17.4.2)."""


@dataclass(frozen=True)
class TrustRegion:
    """A box around the iterate, in units of the variables' scale.

    Attributes:
        radius: half edge of the box.
        largest: the radius never exceeds it.
    """

    radius: float
    largest: float

    def holds(self, length: float) -> bool:
        """Return whether a step of infinity norm `length` would go on but for the region."""
        return length >= INTERIOR * self.radius

    def after(self, ratio: float, length: float, may_grow: bool = True) -> TrustRegion:
        """Return the region after an accepted step of infinity norm `length`."""
        if ratio < POOR:
            return self.shrunk(length)
        if may_grow and ratio > GOOD and self.holds(length):
            return TrustRegion(min(self.largest, GROW * self.radius), self.largest)
        return self

    def shrunk(self, length: float) -> TrustRegion:
        """Return the region after a rejected step of infinity norm `length`."""
        return TrustRegion(SHRINK * min(self.radius, length), self.largest)


def agreement(actual: float, predicted: float, rounding: float) -> float:
    """Return the ratio of actual to predicted reduction, one when both are rounding errors.

    Conn, Gould & Toint (2000), section 17.4.2: both reductions are raised by the rounding error.
    """
    return (actual + rounding) / (max(predicted, 0.0) + rounding)
