"""What a description says beside its rigid bodies: passive joints, gravity, ties of joints, loops.

Joints follow others by <mimic> of a URDF, by <joint> in the <equality> of an MJCF file. One that
follows others that follow others again is told with the one that they all follow.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import field, replace
from typing import Literal

from numpy.polynomial import Polynomial

from gaitopt.dataclass import dataclass
from gaitopt.errors import did_you_mean

STANDARD_GRAVITY = 9.81
"""Acceleration of free fall where a description gives none [m/s²]."""

TIES = "ties"
"""That joints follow others, among `PARTS`."""

LOOPS = "loops"
"""That loops of bodies are closed, among `PARTS`."""

PARTS = (
    "friction", "damping", "springs", "armature", "gravity-compensation", "gravity", TIES, LOOPS,
)  # fmt: skip
"""Parts of a description's physics that can be left out, each by itself."""

GENERATED = "<!-- Made by gaitopt: links without rotors. -->"
"""Marks descriptions that gaitopt makes itself, of bipeds which have no rotors on purpose."""


@dataclass(frozen=True)
class PassiveJoint:
    """What a joint does by itself; its motor must deliver these on top of the rigid bodies' torque.

    Attributes:
        damping: torque per rate [N·m·s/rad], then per |rate| rate [N·m·s²/rad²], and so on, as far
            as the description goes: an odd function, as MuJoCo has it.
        friction: Coulomb friction [N·m], against the motion.
        stiffness: of a spring: torque per angle from `rest` [N·m/rad], then per its square
            [N·m/rad²] and so on: a plain polynomial, again as MuJoCo has it.
        rest: angle at which the spring gives no torque [rad].
    """

    damping: tuple[float, ...] = ()
    friction: float = 0.0
    stiffness: tuple[float, ...] = ()
    rest: float = 0.0

    @property
    def idle(self) -> bool:
        """Whether it does nothing."""
        return not (any(self.damping) or self.friction or any(self.stiffness))


@dataclass(frozen=True)
class LoopFrames:
    """Two frames of a model that are held together, so that a loop of bodies is closed.

    Attributes:
        first, second: their names.
        axes: whether their axes are held together too, not their origins alone.
    """

    first: str
    second: str
    axes: bool


@dataclass(frozen=True)
class PointMass:
    """The part of a link whose weight is carried from outside.

    Attributes:
        mass: factor of compensation times the mass of the link [kg].
        centre: centre of mass in the frame of the link [m].
    """

    mass: float
    centre: tuple[float, float, float]


@dataclass(frozen=True)
class Physics:
    """Passive joints, gravity and its compensation, as the description has them.

    Attributes:
        joints: by joint name; those that do nothing may be left out.
        gravity: along the axes of the root link with every joint coordinate at zero [m/s²]; None
            where the description gives none: then `STANDARD_GRAVITY` along the robot's down.
        compensated: weight that is carried from outside, by name of the link.
    """

    joints: Mapping[str, PassiveJoint] = field(default_factory=dict)
    gravity: tuple[float, float, float] | None = None
    compensated: Mapping[str, PointMass] = field(default_factory=dict)

    def without(self, parts: Collection[str]) -> Physics:
        """Return the physics that is left when some of `PARTS` are left out."""
        changes: dict[str, object] = {}
        if "friction" in parts:
            changes["friction"] = 0.0
        if "damping" in parts:
            changes["damping"] = ()
        if "springs" in parts:
            changes |= {"stiffness": (), "rest": 0.0}
        joints = {name: replace(joint, **changes) for name, joint in self.joints.items()}  # type: ignore[arg-type]
        return Physics(
            joints=joints,
            gravity=None if "gravity" in parts else self.gravity,
            compensated={} if "gravity-compensation" in parts else self.compensated,
        )


def is_generated(text: str) -> bool:
    """Return whether a description was made by gaitopt."""
    return GENERATED in text[:200]


TieRole = Literal["leads", "follows"]

MOST_COEFFICIENT = 1e3
"""Of a multiplier, and of an offset [rad or m]: gears between joints are near 1."""
LEAST_MULTIPLIER = 1e-6
"""Of a multiplier: a joint that follows with less stands still."""
MOST_POWER = 4
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


def real_roots(f: Polynomial) -> list[float]:
    """Return the real roots of a polynomial, in order; none where it is constant."""
    roots = f.trim().roots()
    return sorted(float(r.real) for r in roots if abs(r.imag) <= 1e-9 * (1.0 + abs(r.real)))


def fault_of_tie(tie: Tie, joints: Iterable[str]) -> str:
    """Return what is wrong with a tie taken by itself, empty if nothing is."""
    if not all(map(math.isfinite, tie.coefficients)):
        return "its multiplier and offset must be finite numbers; correct them"
    most = f"{MOST_COEFFICIENT:g}"
    if abs(largest := max(tie.bend, key=abs, default=0.0)) > MOST_COEFFICIENT:
        return f"a coefficient is {largest:g}; allowed are {most} to either side of 0; correct it"
    if not tie.bend and not LEAST_MULTIPLIER <= abs(tie.multiplier) <= MOST_COEFFICIENT:
        return (
            f"its multiplier is {tie.multiplier:g}; allowed are {LEAST_MULTIPLIER:g} to {most} to "
            "either side of 0; correct it"
        )
    if abs(tie.multiplier) > MOST_COEFFICIENT:
        return f"its multiplier is {tie.multiplier:g}; allowed are {most}; correct it"
    if abs(tie.offset) > MOST_COEFFICIENT:
        return f"its offset is {tie.offset:g} rad; allowed are {most}; correct it"
    if tie.master == tie.joint:
        return "it follows itself; name the joint that it follows"
    if tie.master not in (known := set(joints)):
        hint = did_you_mean(tie.master, known)
        return f"it follows '{tie.master}', which is no joint that moves; {hint}name one that does"
    return ""


def ties_to_masters(ties: Mapping[str, Tie]) -> tuple[dict[str, Tie], dict[str, str]]:
    """Return the ties of joints to those that follow no other, by the joint that follows.

    And by joint what is wrong with those of a circle, or that lead into one.
    """
    found, faults = {}, {}
    for name, tie in ties.items():
        seen = [name]
        # A long line of polynomials would soon have more powers than memory has numbers.
        while tie.master in ties and tie.master not in seen and len(tie.bend) < MOST_POWER:
            seen.append(tie.master)
            tie = tie.after(ties[tie.master])
        if tie.master in seen:
            circle = " follows ".join(f"'{joint}'" for joint in (*seen, tie.master))
            faults[name] = (
                f"joints follow each other in a circle: {circle}; let one of them be free"
            )
        elif len(tie.bend) > MOST_POWER - 1:
            faults[name] = (
                f"it follows '{tie.master}' through others with power {len(tie.bend) + 1}; allowed "
                f"is {MOST_POWER}"
            )
        elif max(map(abs, tie.coefficients)) > MOST_COEFFICIENT or not (
            tie.bend or abs(tie.multiplier) >= LEAST_MULTIPLIER
        ):
            faults[name] = f"it follows '{tie.master}' with {tie.multiplier:g}, through others"
        else:
            found[name] = tie
    return found, faults


def ties_among(ties: Mapping[str, Tie], names: Collection[str]) -> dict[str, Tie]:
    """Return the ties of joints that move with one that moves."""
    return {name: tie for name, tie in ties.items() if name in names and tie.master in names}


def tied_to(ties: Mapping[str, Tie], names: Iterable[str]) -> dict[str, TieRole]:
    """Return the joints beside some that follow one of those or one of theirs, or lead them."""
    given = set(names)
    masters = {ties[name].master if name in ties else name for name in given}
    found: dict[str, TieRole] = dict.fromkeys(sorted(masters - given), "leads")
    return found | {
        name: "follows" for name, tie in ties.items() if tie.master in masters and name not in given
    }
