"""Gaps between the two legs: distances of their bodies' capsules.

The robot is a chain, so the distance of body a of the stance leg from body b of the swing leg
depends only on the joints between them: a may be held, and those joints move b.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitopt.mechanics.bodies import Bodies, Placements
from gaitopt.mechanics.legs import LegKinematics
from gaitopt.mechanics.readings import Reading, ReadingSlope
from gaitopt.mechanics.segments import Nearest, distance_curvature, distance_force, nearest
from gaitopt.nlp import Array
from gaitopt.robot.feet.capsules import DEFAULT_RADIUS, Capsule, leg_capsules
from gaitopt.robot.model import Robot

PELVIS = 6  # its place among the bodies
_HAIR = 1e-4  # m
_APART = 0.1  # m between the soles of a robot that stands with its legs apart

Pair = tuple[Capsule, Capsule]


@dataclass(frozen=True)
class LegPairs:
    """Bodies that must keep apart, one of each leg.

    Attributes:
        kept: capsules of stance and swing leg.
        dropped: pairs left out because they overlap even when the robot stands with its legs
            apart: bodies beside the pelvis that no joint takes apart, or capsules too generous.
        standing: gaps of those that are kept when the robot stands so [m], shape (kept,).
    """

    kept: tuple[Pair, ...]
    dropped: tuple[Pair, ...]
    standing: Array

    def least(self, asked: float) -> Array:
        """Return the gap to be kept by each pair [m]: what is asked, or what standing leaves.

        No walk keeps bodies farther apart that no joint takes apart. Capsules are not quite round
        about the axes of the hips, so that a gap there changes by a hair.
        """
        return np.minimum(asked, np.maximum(self.standing - _HAIR, 0.0))

    def narrowed(self, asked: float) -> str:
        """Return what a person should know of gaps that are asked for and cannot be, or ""."""
        narrow = np.flatnonzero(self.standing < asked)
        if len(narrow) == 0:
            return ""
        named = [f"{pair_name(self.kept[k])} {self.standing[k] * 1e3:.1f} mm" for k in narrow]
        return (
            f"leg_gap asks for {asked * 1e3:.1f} mm between the legs, but the robot has less when "
            f"it stands; kept is what it has there: {', '.join(named)}"
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
        guessed = [c.name for _, c in sorted(bodies.items()) if c.source == "joints"]
        if guessed:
            said.append(
                f"taken as bars of {DEFAULT_RADIUS:g} m radius between their joints, for no shape "
                "of them was found (are the meshes in --package-dir, package_dirs in Python?): "
                + ", ".join(guessed)
            )
        return tuple(said)


def pair_name(pair: Pair) -> str:
    """Return the names of both bodies."""
    return f"{pair[0].name} and {pair[1].name}"


@lru_cache(maxsize=16)
def leg_pairs(robot: Robot) -> LegPairs:
    """Return the pairs of a robot's leg bodies; the result is kept.

    Raises:
        UnreachableError: the robot cannot stand on flat feet with its knees bent.
    """
    capsules = leg_capsules(robot)
    stance = [c for c in capsules if c.body < PELVIS]
    swing = [c for c in capsules if c.body > PELVIS]
    pairs = [(a, b) for a in stance for b in swing]
    standing = Bodies(robot.model).placed(_standing(robot)[None])
    gaps = LegGaps(tuple(pairs)).value(standing)[0]
    apart = gaps > 0.0
    return LegPairs(
        tuple(p for p, good in zip(pairs, apart, strict=True) if good),
        tuple(p for p, good in zip(pairs, apart, strict=True) if not good),
        gaps[apart],
    )


def _standing(robot: Robot) -> Array:
    """Joint angles with flat feet well apart, the pelvis upright between them, (12,)."""
    legs, sole, kinematics = robot.legs, robot.sole, LegKinematics(robot)
    spacing = legs.side * max(abs(legs.spacing), sole.left - sole.right + _APART)
    return kinematics.solve(*kinematics.flat_feet(0.0, spacing))


@dataclass(frozen=True)
class LegGapsSlope(ReadingSlope):
    """Derivatives of the gaps.

    Attributes:
        value: the gaps [m], shape (N, pairs).
        jacobian: with respect to q, shape (N, pairs, 12).
        near: nearest points, instant after instant, N * pairs of them.
        axes: joint motion axes in the world, shape (N, 12, 6).
        between: which joints are between the bodies of each pair, shape (pairs, 12).
    """

    value: Array
    jacobian: Array
    near: Nearest
    axes: Array
    between: NDArray[np.bool_]

    def curvature(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * gaps), weights (N, pairs), shape (N, 12, 12).

        Pairs without weight cost nothing.
        """
        instants, pairs = np.nonzero(weights)
        near = self.near.pick(instants * weights.shape[1] + pairs)
        axes = self.axes[instants] * self.between[pairs][:, :, None]
        H = np.zeros((len(weights), 12, 12))
        bend = distance_curvature(near, axes) * weights[instants, pairs][:, None, None]
        np.add.at(H, instants, bend)
        return H


class LegGaps(Reading):
    """Gaps of pairs of capsules [m], negative where they overlap."""

    def __init__(self, pairs: tuple[Pair, ...]) -> None:
        capsules = list(dict.fromkeys(c for pair in pairs for c in pair))  # few, in many pairs
        self._carriers = [c.body for c in capsules]
        self._ends = np.array([c.ends for c in capsules])
        self._sides = np.array([[capsules.index(c) for c in pair] for pair in pairs]).T
        bodies = np.array([[c.body for c in pair] for pair in pairs])
        self._radii = np.array([sum(c.radius for c in pair) for pair in pairs])
        joints = np.arange(12)  # joint j carries body j + 1
        self._between = (joints >= bodies[:, :1]) & (joints < bodies[:, 1:])

    def value(self, placed: Placements) -> Array:
        """Return the gaps [m], shape (N, pairs)."""
        return self._gaps(self._near(placed))

    def slope(self, placed: Placements, axes: Array) -> LegGapsSlope:
        """Return the derivatives of the gaps."""
        near = self._near(placed)
        force = distance_force(near).reshape(len(axes), -1, 6)
        jacobian = np.where(self._between, force @ axes.swapaxes(1, 2), 0.0)
        return LegGapsSlope(self._gaps(near), jacobian, near, axes, self._between)

    def _near(self, placed: Placements) -> Nearest:
        rotation, origin = placed.rotation[:, self._carriers], placed.origin[:, self._carriers]
        ends = self._ends @ rotation.swapaxes(-1, -2) + origin[..., None, :]
        first, second = self._sides
        return nearest(ends[:, first].reshape(-1, 2, 3), ends[:, second].reshape(-1, 2, 3))

    def _gaps(self, near: Nearest) -> Array:
        return np.asarray(near.distance.reshape(-1, len(self._radii)) - self._radii)
