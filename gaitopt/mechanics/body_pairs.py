"""Which bodies of a robot must keep apart: the two legs, and arms and all they may run into.

Of a pair that is nearer than asked when the robot stands, what it has there is kept. Pairs that
overlap there are left out: bodies that no joint takes apart, or capsules too generous. Those of an
arm that hangs at its side may overlap a little: by no more than there, as if they were thinner.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.mechanics.capsule_distance import CapsuleGaps, Pair, nearest
from gaitopt.mechanics.forward_kinematics import ForwardKinematics, Placements
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.arm_capsules import arm_bodies, arm_capsules
from gaitopt.model.leg_capsules import Capsule, leg_capsules
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_TOLD = 3  # pairs that are named, the narrowest first
_HAIR = 1e-4  # m, of the thirteen-link biped
_SHRUNK = 1.0  # of the radius of an arm's capsule: its axis is outside
_POSTURES = 200
_APART = 0.1  # m, likewise, between the soles of a robot that stands with its legs apart


@dataclass(frozen=True)
class CapsulePairs:
    """Capsules that must keep apart.

    Attributes:
        kept: the pairs.
        dropped: pairs left out because they overlap even when the robot stands with its legs apart.
        standing: gaps of those that are kept when the robot stands so [m], shape (kept,).
        hair: by which such gaps may change [m].
    """

    kept: tuple[Pair, ...]
    dropped: tuple[Pair, ...]
    standing: Array
    hair: float = _HAIR

    def least(self, asked: float) -> Array:
        """Return the gap to be kept by each pair [m], (M,): what is asked, or what standing leaves.

        No walk keeps bodies farther apart that no joint takes apart. Capsules are not quite round
        about the axes of the joints, so that a gap there changes by a hair.
        """
        there = self.standing - self.hair
        return np.minimum(asked, np.where(self.standing > 0.0, np.maximum(there, 0.0), there))

    def narrowed(self, option: str, where: str, asked: float) -> str:
        """Return what a person should know of gaps that are asked for and cannot be, or "".

        Args:
            option: by which they are asked for.
            where: they are.
            asked: the gap [m].
        """
        narrow = [k for k in np.argsort(self.standing) if self.standing[k] < asked]
        if not narrow:
            return ""
        named = [
            f"{pair_name(self.kept[k])} {self.standing[k] * 1e3:.1f} mm" for k in narrow[:_TOLD]
        ]
        rest = f", and {len(narrow) - _TOLD} wider pairs" if len(narrow) > _TOLD else ""
        return (
            f"{option} asks for {asked * 1e3:.1f} mm {where}, but the robot has less when it "
            f"stands; kept is what it has there: {', '.join(named)}{rest}"
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each pair that is kept."""
        return tuple(map(pair_name, self.kept))

    @property
    def sentences(self) -> tuple[str, ...]:
        """What a person should know: which pairs are left out, which shapes are guesses."""
        said = []
        if self.dropped:
            names = ", ".join(map(pair_name, self.dropped))
            said.append(f"not kept apart, for their capsules overlap when standing: {names}")
        bodies = {c.body: c for pair in (*self.kept, *self.dropped) for c in pair}
        guessed = [c for _, c in sorted(bodies.items()) if c.source == "joints"]
        if guessed:
            said.append(
                f"taken as bars of {guessed[0].radius:.3g} m radius between their joints, for no "
                "shape of them was found (are the meshes in --package-dir, package_dirs in "
                f"Python?): {', '.join(c.name for c in guessed)}"
            )
        return tuple(said)


def narrowed_gaps(robot: Robot, leg_gap: float | None, arm_gap: float | None) -> tuple[str, ...]:
    """Return what a person should know of gaps between its bodies that cannot be as asked for [m].

    Raises:
        UnreachableError: the robot cannot stand on flat feet with its knees bent.
    """
    told = []
    if leg_gap is not None:
        told.append(leg_pairs(robot).narrowed("leg_gap", "between the legs", leg_gap))
    if arm_gap is not None:
        told.append(arm_pairs(robot).narrowed("arm_gap", "around the arms", arm_gap))
    return tuple(filter(None, told))


def pair_name(pair: Pair) -> str:
    """Return the names of both bodies."""
    return f"{pair[0].name} and {pair[1].name}"


@lru_cache(maxsize=16)
def leg_pairs(robot: Robot) -> CapsulePairs:
    """Return the pairs of a robot's leg bodies, stance leg first; the result is kept.

    Raises:
        UnreachableError: the robot cannot stand on flat feet with its knees bent.
    """
    capsules = leg_capsules(robot)
    pelvis = robot.tree.pelvis
    stance = [c for c in capsules if c.body < pelvis]
    swing = [c for c in capsules if pelvis < c.body <= robot.tree.swing_foot]
    return _apart(robot, [(a, b) for a in stance for b in swing], shrunk=0.0)


@lru_cache(maxsize=16)
def arm_pairs(robot: Robot) -> CapsulePairs:
    """Return the pairs of the bodies of moving arms and others; the result is kept.

    Others are pelvis, waist, thighs, loads and the other arm, as far as an arm may reach them.

    Raises:
        UnreachableError: the robot cannot stand on flat feet with its knees bent.
    """
    arms = arm_bodies(robot)
    reach = _Reach(robot)
    pairs = [
        (a, b)
        for a, b in combinations(arm_capsules(robot), 2)
        if b.body in arms and arms.get(a.body) != arms[b.body] and reach.may_meet((a, b))
    ]
    return _apart(robot, _that_part(robot, pairs), shrunk=_SHRUNK)


def _that_part(robot: Robot, pairs: list[Pair]) -> list[Pair]:
    """Return the pairs that some posture takes farther apart than either is thick.

    A shoulder stays beside the trunk, whatever it does, and so does the beginning of an upper arm:
    what capsules say of them is about capsules. The elbow, where the next body begins, is kept.
    """
    if not pairs:
        return []
    low, high = (
        np.clip(limit, -np.pi, np.pi) for limit in (robot.limits.lower, robot.limits.upper)
    )
    rng = np.random.default_rng(0)
    q = robot.coupling.angles(rng.uniform(low, high, (_POSTURES, len(low))))
    gaps = CapsuleGaps(robot.tree, tuple(pairs)).value(ForwardKinematics(robot.model).placed(q))
    return [
        pair
        for pair, widest in zip(pairs, gaps.max(axis=0), strict=True)
        if widest > 2.0 * min(capsule.radius for capsule in pair)
    ]


class _Reach:
    """How near the joints of a robot could bring two bodies, whatever their ranges."""

    def __init__(self, robot: Robot) -> None:
        self._tree = robot.tree
        neutral = np.zeros((1, robot.tree.size))
        self._placed = ForwardKinematics(robot.model).placed(neutral)
        self._spans: dict[tuple[Capsule, int], tuple[float, float]] = {}

    def may_meet(self, pair: Pair) -> bool:
        """Return whether the longest stretch between is no longer than all others together.

        Stretches lead from the first body to the joint that carries it or the next one, on from
        joint to joint, and to the second body.
        """
        first, second = (self._tree.path(capsule.body) for capsule in pair)
        joints = [*np.flatnonzero(first & ~second)[::-1], *np.flatnonzero(second & ~first)]
        bodies = [int(j) + 1 for j in joints]
        spans = np.linalg.norm(np.diff(self._placed.origin[0, bodies], axis=0), axis=1)
        ends = [self._span(c, b) for c, b in zip(pair, (bodies[0], bodies[-1]), strict=True)]
        least = np.array([*spans, *(low for low, _ in ends)])
        most = np.array([*spans, *(high for _, high in ends)])
        return bool((least - (most.sum() - most)).max() <= 0.0)

    def _span(self, capsule: Capsule, beside: int) -> tuple[float, float]:
        """Return least and largest distance of a capsule from the joint of a body beside it [m]."""
        if (capsule, beside) not in self._spans:  # the same of many pairs
            body, origin = capsule.body, self._placed.origin[0, beside]
            ends = capsule.ends @ self._placed.rotation[0, body].T + self._placed.origin[0, body]
            point = np.array([[origin, origin]])
            near = float(nearest(ends[None], point).distance[0]) - capsule.radius
            far = float(np.linalg.norm(ends - origin, axis=1).max()) + capsule.radius
            self._spans[capsule, beside] = max(near, 0.0), far
        return self._spans[capsule, beside]


def _apart(robot: Robot, pairs: Sequence[Pair], shrunk: float) -> CapsulePairs:
    """Return pairs, of which those are kept that are apart when the robot stands.

    Args:
        robot: the biped.
        pairs: of its capsules.
        shrunk: how much thinner the thinner one of them may be taken for that.
    """
    if not pairs:
        return CapsulePairs((), (), np.zeros(0))
    gaps = CapsuleGaps(robot.tree, tuple(pairs)).value(_standing(robot))[0]
    apart = gaps > -shrunk * np.array([min(c.radius for c in pair) for pair in pairs])
    return CapsulePairs(
        tuple(p for p, good in zip(pairs, apart, strict=True) if good),
        tuple(p for p, good in zip(pairs, apart, strict=True) if not good),
        gaps[apart],
        _HAIR * robot.scales.length,
    )


def _standing(robot: Robot) -> Placements:
    """The bodies: flat feet well apart, the pelvis upright between them, arms where walks begin."""
    legs, sole, kinematics = robot.legs, robot.sole, LegKinematics(robot)
    spacing = legs.side * max(abs(legs.stance_width), sole.width + _APART * robot.scales.length)
    q = kinematics.solve(*kinematics.flat_feet(0.0, spacing))
    return ForwardKinematics(robot.model).placed(robot.coupling.angles(q)[None])
