"""Distances of a robot's bodies: of capsules around them, with exact derivatives.

The distance of body a from body b depends only on the joints between them: a may be held, and those
joints move b. Joints on the branch of a move it the other way, the outermost first.

Let r(s, t) be the vector from point t of the second segment to point s of the first. The squared
distance is the minimum of r . r over 0 <= s, t <= 1. How the nearest points move does not matter to
the gradient (envelope theorem); to the Hessian it does, as far as s and t are free to follow. The
distance has continuous derivatives unless the segments are parallel or meet; its Hessian jumps
where a nearest point reaches an end.

Which bodies of a robot must keep apart: the two legs, and arms and all they may run into.

Of a pair that is nearer than asked when the robot stands, what it has there is kept. Pairs that
overlap there are left out: bodies that no joint takes apart, or capsules too generous. Those of an
arm that hangs at its side may overlap a little: by no more than there, as if they were thinner.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass
from gaitopt.mechanics import compiled
from gaitopt.mechanics.forward_kinematics import (
    ForwardKinematics,
    Placements,
    PostureQuantity,
    PostureQuantityDerivatives,
)
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.mechanics.spatial import cross, skew, symmetric
from gaitopt.model.capsules import Capsule, arm_bodies, arm_capsules, leg_capsules
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Indices

_POINT = 1e-12  # m²: a shorter segment is a point
_PARALLEL = 1e-12  # squared sine of the angle: where the nearest points are becomes rounding
_HELD = 1e-6  # squared sine of the angle: below it (0.06 degrees) s is held in the Hessian
_TOUCHING = 1e-9  # m: a shorter distance has no direction


@dataclass(frozen=True)
class Nearest:
    """Nearest points of M pairs of segments; in memory the components come first.

    Attributes:
        along: direction vectors of first and second segments [m], shape (M, 3) each.
        share: s and t, where the nearest points are, from 0 to 1, shape (M,) each.
        begin: where the second segment begins [m], shape (M, 3).
        between: from its nearest point to that of the first [m], shape (M, 3).
    """

    along: tuple[Array, Array]
    share: tuple[Array, Array]
    begin: Array
    between: Array

    @property
    def second(self) -> Array:
        """Nearest point of the second segment [m], shape (M, 3)."""
        return self.begin + self.share[1][:, None] * self.along[1]

    @cached_property
    def distance(self) -> Array:
        """Distance [m], shape (M,)."""
        between = self.between.T
        return np.asarray(np.sqrt(_dot(between, between)))

    @cached_property
    def force(self) -> Array:
        """Six-force on the second segment that works against the distance, shape (M, 6).

        A joint with world axis S that moves the second segment changes the distance by S . force.
        """
        found = np.empty((6, len(self.begin)))
        x, y, z = np.divide(self.between.T, -np.maximum(self.distance, _TOUCHING), out=found[:3])
        a, b, c = self.second.T
        found[3], found[4], found[5] = b * z - c * y, c * x - a * z, a * y - b * x
        return found.T

    def pick(self, chosen: Indices) -> Nearest:
        """Return some of the pairs, by their numbers (K,)."""
        (p, q), (s, t) = self.along, self.share
        return Nearest(
            (p[chosen], q[chosen]), (s[chosen], t[chosen]), self.begin[chosen], self.between[chosen]
        )


def nearest(first: Array, second: Array) -> Nearest:
    """Return the nearest points of segments given by their ends, shape (M, 2, 3) each."""
    (start, end), (begin, stop) = (
        np.ascontiguousarray(s.transpose(1, 2, 0)) for s in (first, second)
    )
    p, q = end - start, stop - begin
    return _nearest(start, p, begin, q, _dot(p, p), _dot(q, q))


def _nearest(start: Array, p: Array, begin: Array, q: Array, pp: Array, qq: Array) -> Nearest:
    """Return the nearest points of segments.

    The method is that of Ericson (Real-Time Collision Detection, 2005, section 5.1.9): the nearest
    points of the lines, then each clamped to its segment.

    Args:
        start, p: where the first ones begin, and from there to their ends [m], shape (3, M).
        begin, q: the same of the second ones.
        pp, qq: squared lengths [m²], shape (M,).
    """
    between = start - begin
    pq, p_apart, q_apart = _dot(p, q), _dot(p, between), _dot(q, between)
    both, short, other = pp * qq, np.maximum(pp, _POINT), np.maximum(qq, _POINT)
    skewed = both - pq * pq
    level = skewed <= _PARALLEL * both
    level |= np.minimum(pp, qq) <= _POINT
    skewed[level] = 1.0
    s = (pq * q_apart - p_apart * qq) / skewed
    s[level] = -p_apart[level] / short[level]
    s = _clamped(s)
    t_free = (pq * s + q_apart) / other
    t = _clamped(t_free)
    np.copyto(s, _clamped((pq * t - p_apart) / short), where=t != t_free)
    between += s * p
    between -= t * q
    return Nearest((p.T, q.T), (s, t), begin.T, between.T)


def _clamped(share: Array) -> Array:
    return np.minimum(np.maximum(share, 0.0), 1.0)


def distance_hessian(
    near: Nearest, axes: Array, reversed_order: NDArray[np.bool_] | None = None
) -> Array:
    """Return the Hessian of the distance in the rotations of the joints, shape (M, j, j).

    With phi = r . r / 2 and u the free ones of (s, t), the reduced Hessian of phi is
    phi_qq - phi_qu phi_uu^-1 phi_uq; of the distance d it is (that - d' d'^T) / d.

    Args:
        axes: motion axes in the world of joints that move the second segment, from the base on (a
            joint turns those after it), shape (M, j, 6); zero for joints that do not.
        reversed_order: pairs of joints of which the later one turns the other, (M, j, j).
    """
    w, r = axes[:, :, 3:], near.between
    moved = axes[:, :, :3] + w @ skew(near.second)  # l + w x point
    upper = moved @ moved.swapaxes(1, 2) - w @ (moved @ skew(r)).swapaxes(1, 2)
    if reversed_order is not None:
        upper = np.where(reversed_order, upper.swapaxes(1, 2), upper)
    H = symmetric(upper) - _given_way(near, w, moved)
    d = np.maximum(near.distance, _TOUCHING)[:, None, None]
    gradient = axes @ near.force[:, :, None]
    return np.asarray((H - gradient @ gradient.swapaxes(1, 2)) / d)


def _given_way(near: Nearest, w: Array, moved: Array) -> Array:
    """phi_qu phi_uu^-1 phi_uq: what the nearest points give way, shape (M, j, j)."""
    p, q = near.along
    pp, qq, pq = _dot(p.T, p.T), _dot(q.T, q.T), _dot(p.T, q.T)
    s, t = (
        (share > 0.0) & (share < 1.0) & (square > _POINT)
        for share, square in zip(near.share, (pp, qq), strict=True)
    )
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
    """Return the products of vectors (k, M)."""
    return np.asarray(np.einsum("im,im->m", a, b))


Pair = tuple[Capsule, Capsule]


@dataclass(frozen=True)
class CapsuleGapsDerivatives(PostureQuantityDerivatives):
    """Derivatives of the gaps, formed as far as they are asked for.

    Attributes:
        value: the gaps [m], shape (N, pairs).
        of: what they are gaps of.
        near: nearest points, pair after pair, pairs * N of them.
        placed: the bodies.
        axes: joint motion axes in the world, shape (N, n, 6).
    """

    value: Array
    of: CapsuleGaps
    near: Nearest
    placed: Placements
    axes: Array

    @cached_property
    def jacobian(self) -> Array:  # type: ignore[override]  # a field of others, as read-only
        """With respect to q, shape (N, pairs, n)."""
        force = self.near.force.reshape(-1, len(self.axes), 6).swapaxes(0, 1)
        return np.asarray(self.of.between * (force @ self.axes.swapaxes(1, 2)))

    def rows(self, instants: Indices, entries: Indices) -> Array:
        near = self.near.pick(entries * len(self.axes) + instants)
        slopes = (self.axes[instants] @ near.force[:, :, None])[:, :, 0]
        return np.asarray(slopes * self.of.between[entries])

    def along(self, step: Array) -> Array:
        moved = (self.axes * step[:, :, None]).swapaxes(0, 1)
        twist = (self.of.paths @ moved.reshape(len(moved), -1)).reshape(-1, *moved.shape[1:])
        twist = np.ascontiguousarray(twist.transpose(2, 0, 1))
        first, second = self.of.sides
        apart = twist.take(second, axis=1) - twist.take(first, axis=1)
        found = _dot(apart.reshape(6, -1), self.near.force.T)
        return found.reshape(apart.shape[1:]).T

    def most(self, changes: Array) -> Array:
        return changes @ self.of.levers(self.placed).T

    def vjp(self, weights: Array) -> Array:
        instants, pairs = np.nonzero(weights)
        found = np.zeros((len(weights), self.axes.shape[1]))
        np.add.at(found, instants, weights[instants, pairs, None] * self.rows(instants, pairs))
        return found

    def hessian(self, weights: Array) -> Array:
        instants, pairs = np.nonzero(weights)  # pairs without weight cost nothing
        near = self.near.pick(pairs * len(weights) + instants)
        moving = np.flatnonzero(self.of.between[pairs].any(axis=0))
        between = self.of.between[np.ix_(pairs, moving)]
        axes = self.axes[np.ix_(instants, moving)] * between[:, :, None]
        first = between < 0.0
        reverse = first[:, :, None] & first[:, None, :] if first.any() else None
        H = np.zeros((len(weights), *self.axes.shape[1:2] * 2))
        if instants.size:
            of_pairs = distance_hessian(near, axes, reverse)
            of_pairs *= weights[instants, pairs][:, None, None]
            begin = np.flatnonzero(np.diff(instants, prepend=-1))
            H[np.ix_(instants[begin], moving, moving)] = np.add.reduceat(of_pairs, begin, axis=0)
        return H


class CapsuleGaps(PostureQuantity):
    """Gaps of pairs of capsules [m], negative where they overlap.

    Attributes:
        sides: numbers of the first and of the second capsule of each pair, shape (2, pairs).
        paths: which of n joints move each capsule, 1 or 0, shape (capsules, n).
        between: which joints are between the bodies of each pair: 1 on the branch of the second, -1
            on that of the first, else 0, shape (pairs, n).
    """

    def __init__(self, tree: JointTree, pairs: tuple[Pair, ...]) -> None:
        """Prepare pairs, of which the first body comes before the second.

        Args:
            pairs: of capsules.
        """
        capsules = list(dict.fromkeys(c for pair in pairs for c in pair))  # few, in many pairs
        self._tree, self._carriers = tree, np.array([c.body for c in capsules], dtype=np.int64)
        self._levers: Array | None = None
        self._ends = np.array([c.ends for c in capsules])
        number = {c: k for k, c in enumerate(capsules)}
        self.sides = np.array([[number[c] for c in pair] for pair in pairs]).T
        self.paths = np.array([tree.path(c.body) for c in capsules], dtype=np.float64)
        self.between = self.paths[self.sides[1]] - self.paths[self.sides[0]]
        self._radii = np.array([sum(c.radius for c in pair) for pair in pairs])[:, None]
        start, end = self._ends.swapaxes(0, 1)
        self._squares = _dot((end - start).T, (end - start).T)[self.sides]
        self._segments = np.concatenate([start, end - start], axis=1)
        # where a capsule begins and the vector to its end, in columns, homogeneous
        self._local = np.zeros((len(capsules), 4, 2))
        self._local[:, :3, 0], self._local[:, :3, 1], self._local[:, 3, 0] = start, end - start, 1.0

    def value(self, placed: Placements) -> Array:
        """Return the gaps [m], shape (N, pairs)."""
        return self._gaps(self._near(placed))

    def derivatives(self, placed: Placements, axes: Array) -> CapsuleGapsDerivatives:
        near = self._near(placed)
        return CapsuleGapsDerivatives(self._gaps(near), self, near, placed, axes)

    def _gaps(self, near: Nearest) -> Array:
        return np.asarray((near.distance.reshape(len(self._radii), -1) - self._radii).T)

    def levers(self, placed: Placements) -> Array:
        """Return how far from each joint a pair's points can be at most [m], shape (pairs, n).

        However the joints stand: the way from joint to joint, and on to the far end of the capsule.
        That is 0 for joints that are not between the bodies of the pair.

        Args:
            placed: the bodies, at any posture.
        """
        if self._levers is None:
            self._levers = self._longest(placed.origin[0])
        return self._levers

    def _longest(self, origin: Array) -> Array:
        tree = self._tree
        parents = np.array(tree.parents) + 1
        spans = np.linalg.norm(origin[1:] - origin[parents], axis=1)
        depth = np.concatenate([[0.0], tree.moves @ spans])
        far = depth[self._carriers] + np.linalg.norm(self._ends, axis=2).max(axis=1)
        first, second = self.sides
        side = np.where(self.between > 0.0, far[second][:, None], far[first][:, None])
        return np.asarray(np.abs(self.between) * (side - depth[1:]))

    def _near(self, placed: Placements) -> Nearest:
        if compiled.in_use():
            found = compiled.kernels.nearest(
                placed.frames, self._carriers, self._segments, self.sides, self._squares
            )
            p, q, (s, t), begin, between = np.split(found, [3, 6, 8, 11])
            return Nearest((p.T, q.T), (s, t), begin.T, between.T)
        frames = placed.frames.take(self._carriers, axis=0)
        count = frames.shape[1]
        ends = (frames.reshape(len(frames), -1, 4) @ self._local).reshape(len(frames), count, 4, 2)
        ends = np.ascontiguousarray(ends.transpose(3, 2, 0, 1)[:, :3])  # (2, 3, capsules, N)
        sides = (ends.take(side, axis=2).reshape(2, 3, -1) for side in self.sides)
        (start, p), (begin, q) = sides
        return _nearest(start, p, begin, q, *np.repeat(self._squares, count, axis=1))


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
            f"{pair_name(self.kept[k])} {fixed(self.standing[k] * 1e3, 1)} mm"
            for k in narrow[:_TOLD]
        ]
        rest = f", and {len(narrow) - _TOLD} wider pairs" if len(narrow) > _TOLD else ""
        return (
            f"{option} asks for {fixed(asked * 1e3, 1)} mm {where}, but the robot has less when it "
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
