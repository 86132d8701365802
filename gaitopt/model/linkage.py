"""Linkages: motors that turn joints in common; loops of any shape as functions of joints.

All joints of a loop are lines in one frame, that of the body which carries them, where the joints
of the leg are at 0. With q of these and u of all others, its ends stay together where

    phi(q, u) = 0

u(q) is followed from there over the range of q; its derivatives up to the third are exact: phi
vanishes for truncated power series in q too, and each step with the inverse of phi_u at the posture
makes one more of their orders right. Where phi has more rows than u, as of planar loops in space,
or u turns a rod about itself, the inverse is the least one.

Truncated power series in at most two variables: exact derivatives up to the third order.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np

from gaitopt.nlp import Array

ORDER = 3
"""Up to which derivatives are exact."""

_POWERS = [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]
_PLACE = {power: k for k, power in enumerate(_POWERS)}
_PRODUCTS = [
    (a, b, _PLACE[p[0] + q[0], p[1] + q[1]])
    for a, p in enumerate(_POWERS)
    for b, q in enumerate(_POWERS)
    if sum(p) + sum(q) <= ORDER
]
_LEFT, _RIGHT = ([one[side] for one in _PRODUCTS] for side in (0, 1))
_GATHER = np.array([[float(c == k) for _, _, c in _PRODUCTS] for k in range(len(_POWERS))])


class Series:
    """Power series in at most two variables up to the third order, of K postures at once.

    Attributes:
        terms: coefficients of x^i y^j in the order of `_POWERS`, shape (10, K).
    """

    def __init__(self, terms: Array) -> None:
        self.terms = terms

    @classmethod
    def constant(cls, value: Array) -> Series:
        """Return numbers (K,) that depend on nothing."""
        terms = np.zeros((len(_POWERS), len(value)))
        terms[0] = value
        return cls(terms)

    @classmethod
    def variable(cls, number: int, value: Array) -> Series:
        """Return one of the variables at some values (K,)."""
        found = cls.constant(value)
        found.terms[_PLACE[(1, 0) if number == 0 else (0, 1)]] = 1.0
        return found

    def __add__(self, other: Series | float) -> Series:
        if isinstance(other, Series):
            return Series(self.terms + other.terms)
        terms = self.terms.copy()
        terms[0] += other
        return Series(terms)

    def __mul__(self, other: Series | float) -> Series:
        if not isinstance(other, Series):
            return Series(self.terms * other)
        return Series(_GATHER @ (self.terms[_LEFT] * other.terms[_RIGHT]))

    def through(self, *derivatives: Array) -> Series:
        """Return f of it, given f and its first three derivatives at its value, (K,) each."""
        moved = Series(self.terms.copy())
        moved.terms[0] = 0.0
        found, power = Series.constant(derivatives[0]), moved
        for order, one in enumerate(derivatives[1:], 1):
            found = found + Series(power.terms * (one / math.factorial(order)))
            power = power * moved
        return found

    @property
    def value(self) -> Array:
        """The numbers themselves, (K,)."""
        return np.asarray(self.terms[0])

    def at(self, variables: tuple[int, ...]) -> Array:
        """Return the derivative in some variables, (K,)."""
        i, j = variables.count(0), variables.count(1)
        return np.asarray(self.terms[_PLACE[i, j]] * math.factorial(i) * math.factorial(j))

    def derivatives(self, order: int, m: int) -> Array:
        """Return all derivatives of an order in m variables, shape (K, m, ..., m)."""
        every = [self.at(variables) for variables in product(range(m), repeat=order)]
        return np.stack(every, axis=-1).reshape(-1, *(m,) * order)


def dot(point: list[Series], direction: Array) -> Series:
    """Return the component of a point along a direction (3,)."""
    x, y, z = (one * float(d) for one, d in zip(point, direction, strict=True))
    return x + y + z


def cross_matrix(axis: Array) -> Array:
    """Return the matrix of the cross products of an axis (3,) with vectors, shape (3, 3).

    Not `pinocchio.skew`: the command reads tables of linkages before it imports Pinocchio.
    """
    return np.cross(np.eye(3), axis)


def turned_about(point: list[Series], axis: Array, angle: Series) -> list[Series]:
    """Return a point turned about an axis of unit length, shape (3,) (Rodrigues)."""
    a = angle.value
    sine = angle.through(np.sin(a), np.cos(a), -np.sin(a), -np.cos(a))
    versine = angle.through(1.0 - np.cos(a), np.sin(a), np.cos(a), -np.sin(a))
    once = cross_matrix(axis)
    twice = once @ once
    return [
        own + dot(point, once[k]) * sine + dot(point, twice[k]) * versine
        for k, own in enumerate(point)
    ]


Point = tuple[float, float, float]

_NEWTON = 12  # iterations from a neighbour; four are needed
_RANK = 1e-7  # of the largest singular value: below it there is none
_STEP = 0.05  # rad, between postures from which others are found
_BEYOND = 0.05  # rad: the range beyond which angles go on evenly
_FASTEST = 25.0  # turns of a motor per turn of a joint: more is a dead point
_LEAST = 0.02  # determinant of rates of size 1: less moves joints in one way only
OPEN = 1e-4
"""Of a loop [m]: what is open by more is not closed."""
MOST_JOINTS = 2
"""Of a leg that motors turn in common."""


class LoopClosure(NamedTuple):
    """Joints in loops, those of the leg first; coordinates are 0 where those of the leg are.

    Attributes:
        parents: of each, the one that carries it; -1 for none.
        axes: of unit length.
        points: on their lines [m].
        slides: whether it slides along its axis.
        ends: pairs of points [m] that are held together, each with the joint that moves it, or -1.
        motors: which of them motors turn.
        lower, upper: range of those of the leg [rad], which holds 0.
    """

    parents: tuple[int, ...]
    axes: tuple[Point, ...]
    points: tuple[Point, ...]
    slides: tuple[bool, ...]
    ends: tuple[tuple[int, Point, int, Point], ...]
    motors: tuple[int, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def way(self, joint: int) -> list[int]:
        """Return a joint and all that carry it, from it on."""
        found = []
        while joint >= 0:
            found.append(joint)
            joint = self.parents[joint]
        return found


class Rod(NamedTuple):
    """A crank on a motor and the rod to a point beyond the joints, where all joints are at 0.

    All are in the frame of the body before the first joint.

    Attributes:
        crank_centre: a point of the motor's axis [m].
        crank_axis: its direction; the motor turns about it as a right-handed screw.
        crank_end: where the rod is on the crank [m].
        rod_end: where the rod is on the link beyond the last joint [m].
    """

    crank_centre: Point
    crank_axis: Point
    crank_end: Point
    rod_end: Point


class Linkage(NamedTuple):
    """Motors that turn joints of one leg together; the other leg has their mirror image.

    Attributes:
        joints: their names, from the pelvis on.
        motors: names of as many motors.
        jacobian: rates of the motors per rate of the joints, a row for each motor; empty with rods.
        rods: of each motor; empty with a Jacobian.
        torque, speed, power: limits of each motor [N·m, rad/s, W; N, m/s, W where it slides];
            None for none.
        range: least and largest angle of each motor, which is at 0 where all joints are [rad; m];
            None for none.
        closure: loops of other shapes than a crank with a rod; with neither Jacobian nor rods.
    """

    joints: tuple[str, ...]
    motors: tuple[str, ...]
    jacobian: tuple[tuple[float, ...], ...]
    rods: tuple[Rod, ...]
    torque: tuple[float | None, ...]
    speed: tuple[float | None, ...]
    power: tuple[float | None, ...]
    range: tuple[tuple[float, float] | None, ...]
    closure: LoopClosure | None = None

    def slides(self, motor: int) -> bool:
        """Return whether a motor slides along its axis in place of turning about it."""
        closure = self.closure
        return closure is not None and closure.slides[closure.motors[motor]]


def _gap(closure: LoopClosure, values: Array) -> tuple[Array, Array]:
    """Return how far ends are apart at K postures, (K, r), and the derivative (K, r, n)."""
    count = len(values)
    here = (np.broadcast_to(np.eye(3), (count, 3, 3)), np.zeros((count, 3)))
    moved: list[tuple[Array, Array]] = []  # rotation and translation of the bodies
    lines: list[tuple[Array, Array]] = []  # axes and points of the joints
    for k, parent in enumerate(closure.parents):
        R, t = moved[parent] if parent >= 0 else here
        axis, point = np.array(closure.axes[k]), np.array(closure.points[k])
        lines.append((R @ axis, R @ point + t))
        if closure.slides[k]:
            moved.append((R, t + lines[k][0] * values[:, k, None]))
            continue
        across = cross_matrix(axis)
        sine, versine = np.sin(values[:, k]), 1.0 - np.cos(values[:, k])
        own = np.eye(3) + sine[:, None, None] * across + versine[:, None, None] * across @ across
        moved.append((R @ own, t + (R @ (point - own @ point)[..., None])[..., 0]))
    gaps = np.zeros((count, 3 * len(closure.ends)))
    jacobian = np.zeros((*gaps.shape, len(closure.parents)))
    for row, (first, x, second, y) in enumerate(closure.ends):
        rows = slice(3 * row, 3 * row + 3)
        for joint, end, sign in ((first, x, 1.0), (second, y, -1.0)):
            R, t = moved[joint] if joint >= 0 else here
            at = R @ np.array(end) + t
            gaps[:, rows] += sign * at
            for k in closure.way(joint):
                a, p = lines[k]
                jacobian[:, rows, k] += sign * (a if closure.slides[k] else np.cross(a, at - p))
    return gaps, jacobian


def _closed(closure: LoopClosure, q: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return u at which loops are closed, from one near it; gap (K, r); derivative in q and u."""
    m = q.shape[1]
    for _ in range(_NEWTON):
        gaps, J = _gap(closure, np.concatenate([q, u], axis=1))
        step = (np.linalg.pinv(J[:, :, m:], rcond=_RANK) @ gaps[..., None])[..., 0]
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
        u = u - np.clip(step, -0.3, 0.3)
    return u, gaps, J


def _rates(closure: LoopClosure, J: Array) -> Array:
    """Return the rates of the motors per rate of the leg's joints (K, m, m)."""
    m = len(closure.lower)
    others = -np.linalg.pinv(J[:, :, m:], rcond=_RANK) @ J[:, :, :m]
    own = np.broadcast_to(np.eye(m), (len(J), m, m))
    return np.asarray(np.concatenate([own, others], axis=1)[:, list(closure.motors)])


class _Table(NamedTuple):
    """Postures over the range from which others are found."""

    axes: tuple[Array, ...]  # angles of each joint of the leg [rad]
    u: Array  # of all others there, (N, p) or (N, N', p)
    sound: Array  # whether loops are closed and motors can hold the joints, (N,) or (N, N')
    rates: Array  # of the motors where the joints of the leg are at 0, (m, m)


@lru_cache(maxsize=16)
def _table(closure: LoopClosure) -> _Table:
    """Follow the loops from where the leg's joints are at 0 over their range."""
    axes, zeros = list[Array](), list[int]()
    for low, high in zip(closure.lower, closure.upper, strict=True):
        below, above = (math.ceil((end + 2.0 * _BEYOND) / _STEP) for end in (-low, high))
        axes.append(np.asarray(_STEP * np.arange(-below, above + 1)))
        zeros.append(below)
    m, count = len(axes), len(closure.parents)
    u = np.zeros((1, count - m))
    q = np.zeros((1, m))
    sound = np.ones(1, dtype=bool)
    for joint in range(m):
        n, zero = len(axes[joint]), zeros[joint]
        lines = np.zeros((n, *u.shape))
        fine = np.zeros((n, len(u)), dtype=bool)
        for way in (range(zero, n), range(zero, -1, -1)):
            near, going = u, sound
            for k in way:
                at = q.copy()
                at[:, joint] = axes[joint][k]
                near, gaps, J = _closed(closure, at, near)
                rates = _rates(closure, J)
                sizes = np.linalg.norm(rates, axis=2)
                whole = np.linalg.det(rates / np.maximum(sizes, 1e-9)[..., None])
                going = (
                    going
                    & (np.abs(gaps).max(axis=1) < OPEN)
                    & (sizes.max(axis=1) < _FASTEST)
                    & (np.abs(whole) > _LEAST)
                )
                lines[k], fine[k] = near, going
        u, sound = lines.reshape(-1, count - m), fine.ravel()
        q = np.repeat(q[None], n, axis=0)
        q[:, :, joint] = axes[joint][:, None]
        q = q.reshape(-1, m)
    shape = tuple(len(axis) for axis in axes[::-1])
    rates = _rates(closure, _closed(closure, np.zeros((1, m)), np.zeros((1, count - m)))[2])[0]
    return _Table(tuple(axes), u.reshape(*shape, count - m), sound.reshape(shape), rates)


def first_fault(closure: LoopClosure) -> tuple[float, ...]:
    """Return the angles nearest to 0 at which loops open or are at a dead point; empty if none."""
    table = _table(closure)
    wrong = np.argwhere(np.logical_not(table.sound))[:, ::-1]
    inside = np.stack([axis[wrong[:, k]] for k, axis in enumerate(table.axes)], axis=1)
    low, high = np.array(closure.lower), np.array(closure.upper)
    inside = inside[((inside > low - _STEP) & (inside < high + _STEP)).all(axis=1)]
    return tuple(map(float, inside[np.abs(inside).sum(axis=1).argmin()])) if len(inside) else ()


def motor_series(closure: LoopClosure, q: Array) -> list[Series]:
    """Return the angles of the motors at K postures (K, m) [rad] of a leg, 0 where its joints are.

    Beyond the range they go on evenly, at the rates that they have where the joints are at 0.
    """
    return list(_motor_series(closure, np.asarray(q, dtype=np.float64).tobytes()))


@lru_cache(maxsize=32)  # rows, Jacobian and Hessian ask for the postures of both legs in every step
def _motor_series(closure: LoopClosure, postures: bytes) -> tuple[Series, ...]:
    table, m = _table(closure), len(closure.lower)
    q = np.frombuffer(postures).reshape(-1, m)
    given = [Series.variable(k, q[:, k]) for k in range(m)]
    inside = [
        _inside(x, low, high)
        for x, low, high in zip(given, closure.lower, closure.upper, strict=True)
    ]
    values = np.stack([x.value for x in inside], axis=1)
    near = [np.abs(axis - values[:, [k]]).argmin(axis=1) for k, axis in enumerate(table.axes)]
    u, _, J = _closed(closure, values, table.u[tuple(near[::-1])])
    inverse = np.linalg.pinv(J[:, :, m:], rcond=_RANK)
    joints = [*inside, *(Series.constant(u[:, k]) for k in range(u.shape[1]))]
    for _ in range(ORDER):
        gaps = np.stack([one.terms for one in _gap_series(closure, joints)])
        gaps[:, 0] = 0.0
        steps = np.einsum("kpr,rtk->ptk", inverse, gaps)
        joints[m:] = [x + Series(-step) for x, step in zip(joints[m:], steps, strict=True)]
    found = []
    for motor, rates in zip(closure.motors, table.rates, strict=True):
        theta = joints[motor]
        for x, kept, rate in zip(given, inside, rates, strict=True):
            theta = theta + (x + kept * -1.0) * float(rate)
        theta.terms.setflags(write=False)  # of all who ask
        found.append(theta)
    return tuple(found)


def _gap_series(closure: LoopClosure, joints: list[Series]) -> list[Series]:
    found = []
    for first, x, second, y in closure.ends:
        ends = []
        for joint, end in ((first, x), (second, y)):
            point = [Series.constant(np.full(len(joints[0].value), n)) for n in end]
            for k in closure.way(joint):
                axis, on = np.array(closure.axes[k]), closure.points[k]
                if closure.slides[k]:
                    point = [p + joints[k] * float(a) for p, a in zip(point, axis, strict=True)]
                    continue
                point = [p + -n for p, n in zip(point, on, strict=True)]
                point = turned_about(point, axis, joints[k])
                point = [p + n for p, n in zip(point, on, strict=True)]
            ends.append(point)
        found += [a + b * -1.0 for a, b in zip(*ends, strict=True)]
    return found


def _inside(x: Series, low: float, high: float) -> Series:
    """Return an angle as it is in its range, and bent towards its ends beyond."""
    v = x.value
    z = (v - np.clip(v, low, high)) / _BEYOND
    s = 1.0 + z * z
    return x.through(
        np.clip(v, low, high) + _BEYOND * np.arctan(z),
        1.0 / s,
        -2.0 * z / (_BEYOND * s**2),
        np.where(z == 0.0, 0.0, (6.0 * z * z - 2.0) / (_BEYOND**2 * s**3)),
    )
