"""Joints that follow others: which joints of a walk are free, and how all follow from those.

With z the m joints that follow no other and q all n joints of a chain, each of which follows one
z_m or is it by a polynomial f of at most the fourth degree, mostly of the first,

    q = f(z)        dq = S dz        ddq = S ddz + f'' dz²        torque of z = S' torque of q

with S = df/dz, the last by virtual work: what moves the joints that follow comes from the motor of
the one that they follow, with their inertia, rotor, friction and springs. The exchange of left and
right takes f(z) to f(E z) with E of its own: NAO's two hip yaws, one motor, are their own mirror
image.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, reduce
from itertools import pairwise

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.physics import LEAST_MULTIPLIER, Tie, real_roots
from gaitopt.model.joint_limits import JointLimits
from gaitopt.nlp import Array

_SAME = 1e-9  # of coefficients of ties [rad]: those of two legs are written alike
_AFFINE = 2  # coefficients
_BASE = 6  # numbers of the base's motion, before those of the joints
_ORDERS = 5  # f and its derivatives up to the fourth
_WIDEST = 1e3  # rad: of a joint without a range


@dataclass(frozen=True, eq=False)
class Tangent:
    """A coupling at postures: S, and how it changes; of all postures at once.

    Attributes:
        of: the coupling.
        slope: f' of each joint, shape (..., n); (n,) for all postures where ties are affine.
        bend: f'' of each joint, shape (..., n); None where ties are affine.
    """

    of: Coupling
    slope: Array
    bend: Array | None = None

    def rates(self, free: Array) -> Array:
        """Return rates of all joints (..., n), from the free ones' (..., m); S times them."""
        return free if self.of.none else self.slope * free[..., self.of.motor]

    def velocity(self, free: Array) -> Array:
        """Return `rates` behind six numbers of the base that stay as they are, (..., 6 + n)."""
        if self.of.none:
            return free
        return np.concatenate([free[..., :_BASE], self.rates(free[..., _BASE:])], axis=-1)

    def reduced(self, table: Array) -> Array:
        """Return torques of, or derivatives in, the free joints, from those in all: (..., m)."""
        return table if self.of.none else (table * self._along(table)) @ self.of.member

    def effort(self, table: Array) -> Array:
        """Return `reduced` behind six numbers of the base that stay as they are, (..., 6 + m)."""
        if self.of.none:
            return table
        return np.concatenate([table[..., :_BASE], self.reduced(table[..., _BASE:])], axis=-1)

    def reduced_twice(self, table: Array, gradient: Array | None = None) -> Array:
        """Return second derivatives in the free joints (..., m, m), from those in all.

        Args:
            table: second derivatives, shape (..., n, n).
            gradient: first ones, shape (..., n), which count where ties bend.
        """
        if self.of.none:
            return table
        found = np.swapaxes(self.reduced(np.swapaxes(self.reduced(table), -1, -2)), -1, -2)
        if gradient is not None and self.bend is not None:
            found = found + self.of.diagonal(self.bend * gradient)
        return found

    @property
    def matrix(self) -> Array:
        """S, shape (..., n, m)."""
        return self.slope[..., None] * self.of.member

    def _along(self, table: Array) -> Array:
        """The slopes with as many axes before the last as a table has."""
        missing = table.ndim - self.slope.ndim if self.slope.ndim > 1 else 0
        *axes, joints = self.slope.shape
        return self.slope.reshape(*axes, *(1,) * missing, joints)


@dataclass(frozen=True, eq=False)
class CoupledMotion:
    """The motion of all joints at N instants, from that of the free ones.

    Attributes:
        tangent: of the coupling at the postures.
        free: z, dz, ddz, shape (3, N, m).
        orders: f and its derivatives up to the fourth, shape (5, N, n); empty where ties are
            affine.
    """

    tangent: Tangent
    free: Array
    orders: Array

    @cached_property
    def of_all(self) -> Array:
        """Angles, rates and accelerations of all joints, shape (3, N, n)."""
        tangent = self.tangent
        if tangent.of.none:
            return self.free
        q, dq, ddq = self.free
        found = np.stack([tangent.of.angles(q), tangent.rates(dq), tangent.rates(ddq)])
        if self.bends:
            found[2] += self.orders[2] * self._rate**2
        return found

    @property
    def bends(self) -> bool:
        """Whether S depends on the posture."""
        return len(self.orders) > 0

    @cached_property
    def parts(self) -> tuple[Array, Array, Array]:
        """d(dq)/dz, d(ddq)/dz and d(ddq)/d(dz) of joints that follow by bends, (N, n, m) each."""
        _, _, second, third, _ = self.orders
        member, dz, ddz = self.tangent.of.member, self._rate, self._acceleration
        each = (second * dz, second * ddz + third * dz**2, 2.0 * second * dz)
        return each[0][..., None] * member, each[1][..., None] * member, each[2][..., None] * member

    def reduced(self, jacobian: Array) -> Array:
        """Return derivatives in the free (z, dz, ddz) side by side, from those in all.

        Args:
            jacobian: shape (N, r, 3 n).

        Returns:
            Shape (N, r, 3 m).
        """
        if self.tangent.of.none:
            return jacobian
        q, dq, ddq = np.split(jacobian, 3, axis=2)
        of_z, of_dz, of_ddz = map(self.tangent.reduced, (q, dq, ddq))
        if self.bends:
            P, Q, R = self.parts
            of_z = of_z + dq @ P + ddq @ Q
            of_dz = of_dz + ddq @ R
        return np.concatenate([of_z, of_dz, of_ddz], axis=2)

    def curvature(self, by_motion: Array, weights: Array, torque: Array) -> tuple[Array, ...]:
        """Return what the motion of joints that follow by bends bends by itself.

        Of weights . S' torque, the parts in which only S and the motion are differentiated twice:
        blocks (z, z), (z, dz), (dz, dz) and (z, ddz), shape (N, m, m) each.

        Args:
            by_motion: its derivative in q, dq, ddq of all joints, shape (N, 3 n).
            weights: of the free joints' torques, shape (N, m).
            torque: of all joints [N·m], shape (N, n).
        """
        _, _, second, third, fourth = self.orders
        dz, ddz = self._rate, self._acceleration
        g, v, a = np.split(by_motion, 3, axis=1)
        w = weights[:, self.tangent.of.motor]
        zz = g * second + v * third * dz + a * (third * ddz + fourth * dz**2) + torque * third * w
        zv, vv, za = v * second + 2.0 * a * third * dz, 2.0 * a * second, a * second
        return tuple(map(self.tangent.of.diagonal, (zz, zv, vv, za)))

    @property
    def _rate(self) -> Array:
        return np.asarray(self.free[1][:, self.tangent.of.motor])

    @property
    def _acceleration(self) -> Array:
        return np.asarray(self.free[2][:, self.tangent.of.motor])


@dataclass(frozen=True, eq=False)
class Coupling:
    """All n joints of a chain from the m of them that follow no other.

    Attributes:
        names: of the n joints.
        free: which of them follow no other, in their order, shape (m,).
        motor: which of the m joints each of the n follows or is, shape (n,).
        coefficients: of the powers 0, 1, ... of that joint's angle [rad], shape (n, 2) or more.
        mirror: the exchange of left and right for all joints, shape (n, n).
    """

    names: tuple[str, ...]
    free: NDArray[np.int64]
    motor: NDArray[np.int64]
    coefficients: Array
    mirror: Array

    @property
    def free_names(self) -> tuple[str, ...]:
        """Names of the m joints."""
        return tuple(self.names[row] for row in self.free)

    @cached_property
    def none(self) -> bool:
        """Whether no joint follows another: then nothing is to be done."""
        return len(self.free) == len(self.names)

    @cached_property
    def affine(self) -> bool:
        """Whether all ties are of the first degree, so that S is the same in every posture."""
        return bool(self.coefficients.shape[1] == _AFFINE)

    @cached_property
    def bent(self) -> NDArray[np.int64]:
        """Which joints follow by higher powers."""
        return np.flatnonzero(np.abs(self.coefficients[:, _AFFINE:]).sum(axis=1))

    @cached_property
    def member(self) -> Array:
        """Which free joint each joint follows or is, as ones in a matrix (n, m)."""
        return np.asarray((self.motor[:, None] == np.arange(len(self.free))).astype(float))

    def diagonal(self, values: Array) -> Array:
        """Return numbers of all joints (..., n), added up, on the diagonal of a (..., m, m)."""
        return (values @ self.member)[..., None] * np.eye(len(self.free))

    def orders(self, free: Array) -> Array:
        """Return f and its derivatives up to the fourth (5, ..., n), from free joints (..., m)."""
        z, degree = free[..., self.motor], self.coefficients.shape[1]
        found = np.zeros((_ORDERS, *z.shape))
        powers = [z**k for k in range(degree)]
        for order in range(min(_ORDERS, degree)):
            for k in range(order, degree):
                factor = float(np.prod(np.arange(k - order + 1, k + 1)))
                found[order] += factor * self.coefficients[:, k] * powers[k - order]
        return found

    def at(self, free: Array) -> Tangent:
        """Return S at postures of the free joints (..., m)."""
        if self.affine:
            return self._constant
        orders = self.orders(free)
        return Tangent(self, orders[1], orders[2])

    @cached_property
    def _constant(self) -> Tangent:
        return Tangent(self, self.coefficients[:, 1])

    def motion(self, free: Array) -> CoupledMotion:
        """Return the motion of all joints, from angles, rates and accelerations (3, N, m)."""
        if self.affine:
            return CoupledMotion(self._constant, free, np.zeros((0, 0, 0)))
        orders = self.orders(free[0])
        return CoupledMotion(Tangent(self, orders[1], orders[2]), free, orders)

    def constraints(self, free: Array) -> Array:
        """Return C (n - m, n) with C dq = 0 for all rates that the ties allow at z (m,)."""
        rows = np.setdiff1d(np.arange(len(self.names)), self.free)
        led = self.free[self.motor[rows]]
        each = np.arange(len(rows))
        found = np.zeros((len(rows), len(self.names)))
        found[each, rows], found[each, led] = 1.0, -self.at(free).slope[rows]
        return found

    def angles(self, free: Array) -> Array:
        """Return the angles of all joints (..., n), from those of the free ones (..., m)."""
        if self.none:
            return free
        z = free[..., self.motor]
        found = np.broadcast_to(self.coefficients[:, -1], z.shape)
        for column in self.coefficients.T[-2::-1]:  # Horner's rule
            found = found * z + column
        return np.asarray(found)

    def led(self, name: str) -> Coupling:
        """Return the coupling of a chain with one further free joint in front."""
        own = np.zeros((1, self.coefficients.shape[1]))
        own[0, 1] = 1.0
        return Coupling(
            (name, *self.names),
            np.concatenate([[0], self.free + 1]),
            np.concatenate([[0], self.motor + 1]),
            np.concatenate([own, self.coefficients]),
            np.pad(self.mirror, ((1, 0), (1, 0))),
        )

    def put(self, free: Array, joint: int, angle: float, limits: JointLimits) -> None:
        """Write into the free joints' angles (m,) what puts one of all joints at an angle.

        Args:
            free: angles, written to.
            angle: where it is put [rad]; where no posture does, as near as its range allows.
        """
        row = int(self.motor[joint])
        offset, slope, *bend = self.coefficients[joint]
        if not any(bend):
            free[row] = (angle - offset) / slope
            return
        low, high = (_end(end) for end in limits.range(row))
        f = Polynomial(self.coefficients[joint])
        met = [z for z in real_roots(f - angle) if low <= z <= high]
        free[row] = met[0] if met else min((low, high), key=lambda z: abs(f(z) - angle))

    def reach(self, joint: int, limits: JointLimits) -> tuple[float, float]:
        """Return the range of one of all joints under limits of the free ones [rad]."""
        falling = Polynomial(self.coefficients[joint]).trim().coef[::-1]
        # Horner's rule: Polynomial multiplies an end that is infinite by 0

        def at(end: float) -> float:
            return reduce(lambda value, c: value * end + c, map(float, falling))

        low, high = sorted(map(at, limits.range(int(self.motor[joint]))))
        return low, high

    def exchange(self) -> Array:
        """Return the exchange E of left and right for the free joints, shape (m, m).

        Raises:
            RobotError: the mirror image of a posture that the ties allow is one that they do not.
        """
        mirror = self.mirror
        if self.none:
            return mirror
        E, off = np.zeros((len(self.free),) * 2), np.full(len(self.names), np.inf)
        for r, row in enumerate(self.free):
            partner = int(np.abs(mirror[row]).argmax())
            E[r, self.motor[partner]] = mirror[row, partner] * self.coefficients[partner, 1]
        powers = np.arange(self.coefficients.shape[1])
        for row in range(len(self.names)):
            partner, r = int(np.abs(mirror[row]).argmax()), self.motor[row]
            if E[r, self.motor[partner]] == 0.0:
                continue
            turned = self.coefficients[row] * E[r, self.motor[partner]] ** powers
            off[row] = np.abs(turned - mirror[row, partner] * self.coefficients[partner]).max()
        if off.max() <= _SAME:
            return E
        wrong = [int(row) for row in np.flatnonzero(off > _SAME) if row not in self.free]
        row = wrong[0] if wrong else int(off.argmax())
        partner = int(np.abs(mirror[row]).argmax())
        told = " and ".join(
            f"'{self.names[r]}' {'follows no other' if r in self.free else self._tie(r)}"
            for r in sorted({row, partner})
        )
        raise RobotError(
            f"the ties of joints are not mirror images: {told}, but in a mirror "
            f"'{self.names[partner]}' {self._image(row)}; correct the file, or leave all "
            "ties out, so that every joint has its own motor: --without ties (in Python and in the "
            'file for --choices without = ["ties"])'
        )

    def _tie(self, row: int) -> Tie:
        master = self.names[int(self.free[self.motor[row]])]
        return Tie.of(self.names[row], master, self.coefficients[row])

    def _image(self, row: int) -> Tie:
        """Return the tie of a joint seen in a mirror."""
        mirror = self.mirror
        tie, master = self._tie(row), int(self.free[self.motor[row]])
        ends = [int(np.abs(mirror[joint]).argmax()) for joint in (row, master)]
        signs = [float(mirror[joint].sum()) for joint in (row, master)]
        turned = (signs[0] * c * signs[1] ** k for k, c in enumerate(tie.coefficients))
        return Tie.of(self.names[ends[0]], self.names[ends[1]], turned)

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return the limits of the free joints, from those of all.

        Of ranges and speeds of a tie the tightest hold: a joint that follows at k times the rate
        passes on its range, and its speed 1 / |k| times; k is the largest in that range. The
        torque is that of the free joint, whose motor turns all of them.

        Raises:
            RobotError: the ranges of joints that are tied have nothing in common, or a joint that
                follows turns back within its range.
        """
        if self.none:
            return limits
        given = [self._passed_on(row, limits) for row in range(len(self.names))]
        lower, upper = map(np.array, zip(*given, strict=True))
        found = JointLimits(
            torque=limits.torque[self.free],
            speed=limits.speed[self.free],
            lower=self._tightest(lower, np.maximum),
            upper=self._tightest(upper, np.minimum),
        )
        for row in np.flatnonzero(~(found.lower < found.upper)):
            group = [self.names[k] for k in np.flatnonzero(self.motor == row)]
            ranges = ", ".join(
                f"'{name}' {lower[k]:.4g} to {upper[k]:.4g} rad"
                for k, name in enumerate(self.names)
                if name in group
            )
            raise RobotError(
                f"joints that are tied have no range in common, as angles of "
                f"'{self.free_names[row]}': {ranges}; correct the ranges or the ties in the file, "
                "give other ranges ([[limits]] in the file for --choices), or leave all ties out: "
                "--without ties"
            )
        most = np.array([self._slopes(row, found)[1] for row in range(len(self.names))])
        speed = self._tightest(limits.speed / most, np.minimum)
        return JointLimits(found.torque, speed, found.lower, found.upper)

    def _passed_on(self, row: int, limits: JointLimits) -> tuple[float, float]:
        """Return the range that a joint leaves the one that it follows or is [rad].

        Of a joint that follows by a bend, the part of the other's own range in which it keeps its.
        """
        own = limits.range(row)
        if row not in self.bent:
            offset, slope = self.coefficients[row, :_AFFINE]
            low, high = sorted(float((end - offset) / slope) for end in own)
            return low, high
        low, high = (_end(end) for end in limits.range(int(self.free[self.motor[row]])))
        f = Polynomial(self.coefficients[row])
        cuts = {z for end in own if np.isfinite(end) for z in real_roots(f - end)}
        ends = [low, *sorted(z for z in cuts if low < z < high), high]
        kept = [(a, b) for a, b in pairwise(ends) if own[0] <= float(f((a + b) / 2.0)) <= own[1]]
        if not kept:
            return np.inf, -np.inf
        return kept[0][0], kept[-1][1]

    def _slopes(self, row: int, limits: JointLimits) -> tuple[float, float]:
        """Return the least and the largest |f'| of a joint under limits of the free joints."""
        f = Polynomial(self.coefficients[row])
        if row not in self.bent:
            return (abs(float(self.coefficients[row, 1])),) * 2
        low, high = (_end(end) for end in limits.range(int(self.motor[row])))
        slope, inside = f.deriv(), [z for z in real_roots(f.deriv(2)) if low < z < high]
        sizes = [abs(float(slope(z))) for z in (low, high, *inside)]
        turns = [z for z in real_roots(slope) if low < z < high]
        if turns or min(sizes) < LEAST_MULTIPLIER:
            at = turns[0] if turns else min((low, high), key=lambda z: abs(slope(z)))
            master = self.free_names[int(self.motor[row])]
            raise RobotError(
                f"joint '{self.names[row]}' {self._tie(row)}; it turns back where that one is at "
                f"{at:.4g} rad, within the range {low:.4g} to {high:.4g} rad: give '{master}' a "
                "range that ends 0.01 rad before it or earlier, or leave all ties out: "
                "--without ties"
            )
        return min(sizes), max(sizes)

    def complete(self, limits: JointLimits) -> JointLimits:
        """Return limits in which joints without torque or speed have what their motor gives them.

        One motor turns all joints of a tie. Where a file states its torque at a joint that follows
        at k times the rate, it is |k| times that at the joint which is followed, the least where k
        changes with the posture; and its speed one |k|-th, of the largest k. A joint that is
        followed keeps what it has itself.
        """
        torque, speed = (self._filled(limits, field) for field in ("torque", "speed"))
        return replace(limits, torque=torque, speed=speed)

    def _filled(self, limits: JointLimits, field: str) -> Array:
        """Return one kind of limits (n,), those that are not given from others of the same tie."""
        values = np.asarray(getattr(limits, field))
        none = np.isinf(values) | (values == 0.0)
        lacks = none & np.isin(self.motor, self.motor[~none])
        if not lacks.any():
            return values
        ranges = self.limits(limits) if len(self.bent) else limits
        slopes = np.array([self._slopes(row, ranges) for row in range(len(values))])
        ratio = slopes[:, 0] if field == "torque" else 1.0 / slopes[:, 1]
        of_others = self._tightest(np.where(none, np.inf, values * ratio), np.minimum)
        of_motor = np.where(none[self.free], of_others, values[self.free])
        return np.where(lacks, of_motor[self.motor] / ratio, values)

    def _tightest(self, values: Array, tighter: np.ufunc) -> Array:
        """Return of each tie the tightest of the values of its joints, shape (m,)."""
        found = values[self.free].copy()
        tighter.at(found, self.motor, values)
        return np.asarray(found)


def _end(end: float) -> float:
    """Return the end of a range, a far one where there is none [rad]."""
    return float(np.clip(end, -_WIDEST, _WIDEST))


def couple(names: Sequence[str], ties: Mapping[str, Tie], mirror: Array) -> Coupling:
    """Return the coupling of the joints of a chain.

    Args:
        ties: by the joint that follows; joints beside the chain's do not count.
        mirror: the exchange of left and right, shape (n, n).
    """
    free = [row for row, name in enumerate(names) if name not in ties]
    each = [ties.get(name, Tie(name, name)) for name in names]
    coefficients = np.zeros((len(names), max(len(tie.coefficients) for tie in each)))
    for row, tie in enumerate(each):
        coefficients[row, : len(tie.coefficients)] = tie.coefficients
    motor = [free.index(names.index(tie.master)) for tie in each]
    return Coupling(
        tuple(names),
        np.array(free, dtype=np.int64),
        np.array(motor, dtype=np.int64),
        coefficients,
        mirror,
    )
