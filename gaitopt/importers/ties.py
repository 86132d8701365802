"""Joints that follow others: <mimic> of a URDF, <joint> in the <equality> of an MJCF file.

A joint that follows others that follow others again is told with the one that they all follow.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Literal

from numpy.polynomial import Polynomial

from gaitopt.dataclass import dataclass

How = Literal["leads", "follows"]

LARGEST = 1e3
"""Of a multiplier, and of an offset [rad or m]: gears between joints are near 1."""
LEAST = 1e-6
"""Of a multiplier: a joint that follows with less stands still."""
DEGREE = 4
"""Largest power of a tie: that of MuJoCo's `polycoef`."""


@dataclass(frozen=True)
class Tie:
    """A joint whose coordinate is a polynomial of that of another, mostly of degree one.

    Attributes:
        joint: that follows.
        master: that it follows.
        multiplier: its rate over that of the master, where the master is at 0.
        offset: its coordinate where that of the master is 0 [rad or m].
        bend: coefficients of the second and higher powers of the master's coordinate.
    """

    joint: str
    master: str
    multiplier: float = 1.0
    offset: float = 0.0
    bend: tuple[float, ...] = ()

    @classmethod
    def of(cls, joint: str, master: str, coefficients: Iterable[float]) -> Tie:
        """Return the tie of coefficients of the powers 0, 1, 2, ... of the master's coordinate."""
        offset, multiplier, *bend = (*(float(c) for c in coefficients), 0.0, 0.0)
        while bend and bend[-1] == 0.0:
            bend.pop()
        return cls(joint, master, multiplier, offset, tuple(bend))

    @property
    def coefficients(self) -> tuple[float, ...]:
        """Of the powers 0, 1, 2, ... of the master's coordinate."""
        return (self.offset, self.multiplier, *self.bend)

    def at(self, angle: float) -> float:
        """Return the coordinate where that of the master is `angle` [rad]."""
        return float(Polynomial(self.coefficients)(angle))

    def __str__(self) -> str:
        """Return it as a sentence without its first word, the joint."""
        if self.bend:
            powers = (f"{c:+.6g} q^{k}" for k, c in enumerate(self.bend, 2) if c)
            told = " ".join((f"{self.offset:.6g} {self.multiplier:+.6g} q", *powers))
            return f"follows '{self.master}': where that one is at q, it is at {told} rad"
        told = f"follows '{self.master}': its angle is {self.multiplier:.6g} times that one's"
        return told if not round(self.offset, 12) else f"{told} {self.offset:+.6g} rad"

    def after(self, other: Tie) -> Tie:
        """Return the tie to the joint that the master follows in turn."""
        if self.bend or other.bend:
            through = Polynomial(self.coefficients)(Polynomial(other.coefficients))
            return Tie.of(self.joint, other.master, through.coef)
        return Tie(
            self.joint,
            other.master,
            self.multiplier * other.multiplier,
            self.multiplier * other.offset + self.offset,
        )


def fault_of_tie(tie: Tie, joints: Iterable[str]) -> str:
    """Return what is wrong with a tie taken by itself, empty if nothing is."""
    if not all(map(math.isfinite, tie.coefficients)):
        return "its multiplier and offset must be finite numbers; correct them"
    if any(abs(c) > LARGEST for c in tie.bend):
        largest = max(tie.bend, key=abs)
        return (
            f"a coefficient is {largest:g}; allowed are {LARGEST:g} to either side of 0; correct it"
        )
    if not tie.bend and not LEAST <= abs(tie.multiplier) <= LARGEST:
        return (
            f"its multiplier is {tie.multiplier:g}; allowed are {LEAST:g} to {LARGEST:g} to either "
            "side of 0; correct it"
        )
    if abs(tie.multiplier) > LARGEST:
        return f"its multiplier is {tie.multiplier:g}; allowed are {LARGEST:g}; correct it"
    if abs(tie.offset) > LARGEST:
        return f"its offset is {tie.offset:g} rad; allowed are {LARGEST:g}; correct it"
    if tie.master == tie.joint:
        return "it follows itself; name the joint that it follows"
    if tie.master not in set(joints):
        return f"it follows '{tie.master}', which is no joint that moves; name one that does"
    return ""


def resolved(ties: Mapping[str, Tie]) -> tuple[dict[str, Tie], dict[str, str]]:
    """Return the ties of joints to those that follow no other.

    Returns:
        The ties by joint; by joint what is wrong with those of a circle, or that lead into one.
    """
    found, faults = {}, {}
    for name, tie in ties.items():
        seen = [name]
        # A long line of polynomials would soon have more powers than memory has numbers.
        while tie.master in ties and tie.master not in seen and len(tie.bend) < DEGREE:
            seen.append(tie.master)
            tie = tie.after(ties[tie.master])
        if tie.master in seen:
            circle = " follows ".join(f"'{joint}'" for joint in (*seen, tie.master))
            faults[name] = (
                f"joints follow each other in a circle: {circle}; let one of them be free"
            )
        elif len(tie.bend) > DEGREE - 1:
            faults[name] = (
                f"it follows '{tie.master}' through others with power {len(tie.bend) + 1}; allowed "
                f"is {DEGREE}"
            )
        elif max(map(abs, tie.coefficients)) > LARGEST or not (
            tie.bend or abs(tie.multiplier) >= LEAST
        ):
            faults[name] = f"it follows '{tie.master}' with {tie.multiplier:g}, through others"
        else:
            found[name] = tie
    return found, faults


def among(ties: Mapping[str, Tie], names: Collection[str]) -> dict[str, Tie]:
    """Return the ties of joints that move with one that moves."""
    return {name: tie for name, tie in ties.items() if name in names and tie.master in names}


def tied_to(
    ties: Mapping[str, Tie], names: Iterable[str]
) -> dict[str, Literal["leads", "follows"]]:
    """Return the joints beside some that follow one of those or one of theirs, or lead them."""
    given = set(names)
    masters = {ties[name].master if name in ties else name for name in given}
    found: dict[str, How] = dict.fromkeys(sorted(masters - given), "leads")
    return found | {
        name: "follows" for name, tie in ties.items() if tie.master in masters and name not in given
    }
