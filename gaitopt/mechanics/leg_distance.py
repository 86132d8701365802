"""Distances of the two legs: of capsules around their bodies, with exact derivatives.

The distance of body a of the stance leg from body b of the swing leg depends only on the joints
between them: a may be held, and those joints move b.

Let r(s, t) be the vector from point t of the second segment to point s of the first. The squared
distance is the minimum of r . r over 0 <= s, t <= 1. How the nearest points move does not matter to
the gradient (envelope theorem); to the Hessian it does, as far as s and t are free to follow. The
distance has continuous derivatives unless the segments are parallel or meet; its Hessian jumps
where a nearest point reaches an end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gaitopt.mechanics.forward_kinematics import (
    ForwardKinematics,
    Placements,
    PostureQuantity,
    PostureQuantityDerivatives,
)
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.spatial import cross, skew, symmetric
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.leg_capsules import Capsule, leg_capsules
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_POINT = 1e-12  # m²: a shorter segment is a point
_PARALLEL = 1e-12  # squared sine of the angle: where the nearest points are becomes rounding
_HELD = 1e-6  # squared sine of the angle: below it (0.06 degrees) s is held in the Hessian
_TOUCHING = 1e-9  # m: a shorter distance has no direction
_TOLD = 3  # pairs that are named, the narrowest first


@dataclass(frozen=True)
class Nearest:
    """Nearest points of M pairs of segments.

    Attributes:
        along: direction vectors of first and second segment [m], shape (M, 2, 3).
        share: s and t, where the nearest points are, from 0 to 1, shape (M, 2).
        second: nearest point of the second segment [m], shape (M, 3).
        between: from there to the nearest point of the first [m], shape (M, 3).
    """

    along: Array
    share: Array
    second: Array
    between: Array

    @property
    def distance(self) -> Array:
        """Distance [m], shape (M,)."""
        return np.asarray(np.linalg.norm(self.between, axis=1))

    def pick(self, chosen: Array) -> Nearest:
        """Return some of the pairs, by their numbers (K,)."""
        return Nearest(
            self.along[chosen], self.share[chosen], self.second[chosen], self.between[chosen]
        )


def nearest(first: Array, second: Array) -> Nearest:
    """Return the nearest points of segments given by their ends, shape (M, 2, 3) each.

    The method is that of Ericson (Real-Time Collision Detection, 2005, section 5.1.9): the nearest
    points of the lines, then each clamped to its segment.
    """
    p, q = first[:, 1] - first[:, 0], second[:, 1] - second[:, 0]
    apart = first[:, 0] - second[:, 0]
    pp, qq, pq = _dot(p, p), _dot(q, q), _dot(p, q)
    p_apart, q_apart = _dot(p, apart), _dot(q, apart)
    skewed = pp * qq - pq**2
    slanted = (skewed > _PARALLEL * pp * qq) & (np.minimum(pp, qq) > _POINT)
    short = np.maximum(pp, _POINT)
    on_line = (pq * q_apart - p_apart * qq) / np.where(slanted, skewed, 1.0)
    s = np.clip(np.where(slanted, on_line, -p_apart / short), 0.0, 1.0)
    t_free = (pq * s + q_apart) / np.maximum(qq, _POINT)
    t = np.clip(t_free, 0.0, 1.0)
    s = np.where(t == t_free, s, np.clip((pq * t - p_apart) / short, 0.0, 1.0))
    here = second[:, 0] + t[:, None] * q
    there = first[:, 0] + s[:, None] * p
    return Nearest(np.stack([p, q], axis=1), np.stack([s, t], axis=1), here, there - here)


def distance_force(near: Nearest) -> Array:
    """Return the six-force on the second segment that works against the distance, shape (M, 6).

    A joint with world axis S that moves the second segment changes the distance by S . force.
    """
    direction = near.between / np.maximum(near.distance, _TOUCHING)[:, None]
    return -np.concatenate([direction, cross(near.second, direction)], axis=1)


def distance_hessian(near: Nearest, axes: Array) -> Array:
    """Return the Hessian of the distance in the rotations of the joints, shape (M, j, j).

    With phi = r . r / 2 and u the free ones of (s, t), the reduced Hessian of phi is
    phi_qq - phi_qu phi_uu^-1 phi_uq; of the distance d it is (that - d' d'^T) / d.

    Args:
        near: nearest points.
        axes: motion axes in the world of joints that move the second segment, from the base on (a
            joint turns those after it), shape (M, j, 6); zero for joints that do not.
    """
    w, r = axes[:, :, 3:], near.between
    moved = axes[:, :, :3] + w @ skew(near.second)  # l + w x point
    upper = moved @ moved.swapaxes(1, 2) - w @ (moved @ skew(r)).swapaxes(1, 2)
    H = symmetric(upper) - _given_way(near, w, moved)
    d = np.maximum(near.distance, _TOUCHING)[:, None, None]
    gradient = axes @ distance_force(near)[:, :, None]
    return np.asarray((H - gradient @ gradient.swapaxes(1, 2)) / d)


def _given_way(near: Nearest, w: Array, moved: Array) -> Array:
    """phi_qu phi_uu^-1 phi_uq: what the nearest points give way, shape (M, j, j)."""
    p, q = near.along[:, 0], near.along[:, 1]
    pp, qq, pq = _dot(p, p), _dot(q, q), _dot(p, q)
    free = (near.share > 0.0) & (near.share < 1.0)
    free &= np.stack([pp, qq], axis=1) > _POINT
    s, t = free[:, 0], free[:, 1]
    s = s & ~(t & (pp * qq - pq**2 < _HELD * pp * qq))
    by_s = np.where(s[:, None], -(moved @ p[:, :, None])[:, :, 0], 0.0)
    turning = (w @ cross(q, near.between)[:, :, None])[:, :, 0]
    by_t = np.where(t[:, None], (moved @ q[:, :, None])[:, :, 0] - turning, 0.0)
    # phi_uu = [[pp, -pq], [-pq, qq]]; a variable that is held is left out
    both = s & t
    determinant = np.where(both, pp * qq - pq**2, 1.0)
    ss = np.where(both, qq / determinant, np.where(s, 1.0 / np.maximum(pp, _POINT), 0.0))
    tt = np.where(both, pp / determinant, np.where(t, 1.0 / np.maximum(qq, _POINT), 0.0))
    st = np.where(both, pq / determinant, 0.0)
    rows = np.stack([by_s, by_t], axis=1)
    inverse = np.stack([np.stack([ss, st], axis=1), np.stack([st, tt], axis=1)], axis=1)
    return np.asarray(rows.swapaxes(1, 2) @ inverse @ rows)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("mi,mi->m", a, b))


_HAIR = 1e-4  # m
_APART = 0.1  # m between the soles of a robot that stands with its legs apart

Pair = tuple[Capsule, Capsule]


@dataclass(frozen=True)
class LegPairs:
    """ForwardKinematics that must keep apart, one of each leg.

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
        """Return the gap to be kept by each pair [m], (M,): what is asked, or what standing leaves.

        No walk keeps bodies farther apart that no joint takes apart. Capsules are not quite round
        about the axes of the hips, so that a gap there changes by a hair.
        """
        return np.minimum(asked, np.maximum(self.standing - _HAIR, 0.0))

    def narrowed(self, asked: float) -> str:
        """Return what a person should know of gaps that are asked for and cannot be, or ""."""
        narrow = [k for k in np.argsort(self.standing) if self.standing[k] < asked]
        if not narrow:
            return ""
        named = [
            f"{pair_name(self.kept[k])} {self.standing[k] * 1e3:.1f} mm" for k in narrow[:_TOLD]
        ]
        rest = f", and {len(narrow) - _TOLD} wider pairs" if len(narrow) > _TOLD else ""
        return (
            f"leg_gap asks for {asked * 1e3:.1f} mm between the legs, but the robot has less when "
            f"it stands; kept is what it has there: {', '.join(named)}{rest}"
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
    pelvis = robot.tree.pelvis
    stance = [c for c in capsules if c.body < pelvis]
    swing = [c for c in capsules if pelvis < c.body <= robot.tree.swing_foot]
    pairs = [(a, b) for a in stance for b in swing]
    standing = ForwardKinematics(robot.model).placed(robot.coupling.angles(_standing(robot))[None])
    gaps = LegGaps(robot.tree, tuple(pairs)).value(standing)[0]
    apart = gaps > 0.0
    return LegPairs(
        tuple(p for p, good in zip(pairs, apart, strict=True) if good),
        tuple(p for p, good in zip(pairs, apart, strict=True) if not good),
        gaps[apart],
    )


def _standing(robot: Robot) -> Array:
    """Joint angles with flat feet well apart, the pelvis upright between them, (n,)."""
    legs, sole, kinematics = robot.legs, robot.sole, LegKinematics(robot)
    spacing = legs.side * max(abs(legs.stance_width), sole.left - sole.right + _APART)
    return kinematics.solve(*kinematics.flat_feet(0.0, spacing))


@dataclass(frozen=True)
class LegGapsDerivatives(PostureQuantityDerivatives):
    """Derivatives of the gaps.

    Attributes:
        value: the gaps [m], shape (N, pairs).
        jacobian: with respect to q, shape (N, pairs, n).
        near: nearest points, instant after instant, N * pairs of them.
        axes: joint motion axes in the world, shape (N, n, 6).
        between: which joints are between the bodies of each pair, shape (pairs, n).
    """

    value: Array
    jacobian: Array
    near: Nearest
    axes: Array
    between: NDArray[np.bool_]

    def hessian(self, weights: Array) -> Array:
        """Return the Hessian in q of sum(weights * gaps), weights (N, pairs), shape (N, n, n).

        Pairs without weight cost nothing.
        """
        instants, pairs = np.nonzero(weights)
        near = self.near.pick(instants * weights.shape[1] + pairs)
        moving = np.flatnonzero(self.between.any(axis=0))  # joints of the legs, not of arms
        between = self.between[np.ix_(pairs, moving)]
        axes = self.axes[np.ix_(instants, moving)] * between[:, :, None]
        H = np.zeros((len(weights), *self.axes.shape[1:2] * 2))
        if instants.size:
            of_pairs = distance_hessian(near, axes) * weights[instants, pairs][:, None, None]
            first = np.flatnonzero(np.diff(instants, prepend=-1))
            H[np.ix_(instants[first], moving, moving)] = np.add.reduceat(of_pairs, first, axis=0)
        return H


class LegGaps(PostureQuantity):
    """Gaps of pairs of capsules [m], negative where they overlap."""

    def __init__(self, tree: JointTree, pairs: tuple[Pair, ...]) -> None:
        """Prepare pairs, of which the first body is on the way from the stance foot to the second.

        Args:
            tree: of the robot's joints.
            pairs: of capsules.
        """
        capsules = list(dict.fromkeys(c for pair in pairs for c in pair))  # few, in many pairs
        self._carriers = [c.body for c in capsules]
        self._ends = np.array([c.ends for c in capsules])
        self._sides = np.array([[capsules.index(c) for c in pair] for pair in pairs]).T
        self._radii = np.array([sum(c.radius for c in pair) for pair in pairs])
        self._between = np.array([tree.path(b.body) & ~tree.path(a.body) for a, b in pairs])

    def value(self, placed: Placements) -> Array:
        """Return the gaps [m], shape (N, pairs)."""
        return self._gaps(self._near(placed))

    def derivatives(self, placed: Placements, axes: Array) -> LegGapsDerivatives:
        """Return the derivatives of the gaps."""
        near = self._near(placed)
        force = distance_force(near).reshape(len(axes), -1, 6)
        jacobian = np.where(self._between, force @ axes.swapaxes(1, 2), 0.0)
        return LegGapsDerivatives(self._gaps(near), jacobian, near, axes, self._between)

    def _near(self, placed: Placements) -> Nearest:
        rotation, origin = placed.rotation[:, self._carriers], placed.origin[:, self._carriers]
        ends = self._ends @ rotation.swapaxes(-1, -2) + origin[..., None, :]
        first, second = self._sides
        return nearest(ends[:, first].reshape(-1, 2, 3), ends[:, second].reshape(-1, 2, 3))

    def _gaps(self, near: Nearest) -> Array:
        return np.asarray(near.distance.reshape(-1, len(self._radii)) - self._radii)
