"""Joints that follow others: which joints of a walk are free, and how all follow from those.

With z the m joints that follow no other and q all n joints of a chain,

    q = S z + s        dq = S dz        ddq = S ddz        torque of z = S' torque of q

the last by virtual work: what moves the joints that follow comes from the motor of the one that
they follow, with their inertia, rotor, friction and springs. The exchange of left and right takes
S z + s to S E z + s with E of its own: NAO's two hip yaws, one motor, are their own mirror image.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gaitopt.errors import RobotError
from gaitopt.importers.ties import Tie
from gaitopt.model.legs.joint_limits import JointLimits
from gaitopt.nlp import Array

_SAME = 1e-9  # of multipliers and offsets [rad]: those of two legs are written alike


@dataclass(frozen=True, eq=False)
class Coupling:
    """All n joints of a chain from the m of them that follow no other.

    Attributes:
        names: of the n joints.
        free: which of them follow no other, in their order, shape (m,).
        matrix: S, shape (n, m): one entry in each row.
        offset: s [rad], shape (n,).
        mirror: the exchange of left and right for all joints, shape (n, n).
    """

    names: tuple[str, ...]
    free: NDArray[np.int64]
    matrix: Array
    offset: Array
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
    def motor(self) -> NDArray[np.int64]:
        """Which of the m joints each of the n follows or is, shape (n,)."""
        return np.asarray(np.abs(self.matrix).argmax(axis=1), dtype=np.int64)

    @cached_property
    def multiplier(self) -> Array:
        """Rate of each joint over that of the one it follows or is, shape (n,)."""
        return np.asarray(self.matrix.sum(axis=1))

    @cached_property
    def constraints(self) -> Array:
        """Return C with C dq = 0 of all rates that the ties allow, a row for each, (n - m, n)."""
        rows = np.setdiff1d(np.arange(len(self.names)), self.free)
        led = self.free[self.motor[rows]]
        each = np.arange(len(rows))
        found = np.zeros((len(rows), len(self.names)))
        found[each, rows], found[each, led] = 1.0, -self.multiplier[rows]
        return found

    def angles(self, free: Array) -> Array:
        """Return the angles of all joints (..., n), from those of the free ones (..., m)."""
        return free if self.none else free @ self.matrix.T + self.offset

    def rates(self, free: Array) -> Array:
        """Return rates or accelerations of all joints (..., n), from the free ones' (..., m)."""
        return free if self.none else free @ self.matrix.T

    def motion(self, free: Array) -> Array:
        """Return angles, rates and accelerations of all joints, from the free ones', (3, ...)."""
        if self.none:
            return free
        return np.stack([self.angles(free[0]), *map(self.rates, free[1:])])

    def reduced(self, table: Array) -> Array:
        """Return torques of, or derivatives in, the free joints, from those in all: (..., m)."""
        return table if self.none else table @ self.matrix

    def reduced_twice(self, table: Array) -> Array:
        """Return a table of pairs of free joints (..., m, m), from one of pairs of all."""
        return table if self.none else self.matrix.T @ table @ self.matrix

    def padded(self, count: int) -> Array:
        """Return S with so many further coordinates in front, which are free."""
        (n, m), size = self.matrix.shape, count
        whole = np.zeros((size + n, size + m))
        whole[:size, :size], whole[size:, size:] = np.eye(size), self.matrix
        return whole

    def led(self, name: str) -> Coupling:
        """Return the coupling of a chain with one further free joint in front."""
        return Coupling(
            (name, *self.names),
            np.concatenate([[0], self.free + 1]),
            self.padded(1),
            np.concatenate([[0.0], self.offset]),
            np.pad(self.mirror, ((1, 0), (1, 0))),
        )

    def put(self, free: Array, joint: int, angle: float) -> None:
        """Write into the free joints' angles (m,) what puts one of all joints at an angle."""
        row = self.motor[joint]
        free[row] = (angle - self.offset[joint]) / self.multiplier[joint]

    def reach(self, joint: int, limits: JointLimits) -> tuple[float, float]:
        """Return the range of one of all joints under limits of the free ones [rad]."""
        own, k = limits.range(int(self.motor[joint])), self.multiplier[joint]
        low, high = sorted(float(k * end + self.offset[joint]) for end in own)
        return low, high

    def exchange(self) -> Array:
        """Return the exchange E of left and right for the free joints, shape (m, m).

        Raises:
            RobotError: the mirror image of a posture that the ties allow is one that they do not.
        """
        mirror = self.mirror
        if self.none:
            return mirror
        E = np.asarray((mirror @ self.matrix)[self.free])
        turned, moved = self.matrix @ E, mirror @ self.offset
        off = np.maximum(
            np.abs(mirror @ self.matrix - turned).max(axis=1), np.abs(moved - self.offset)
        )
        if off.max() <= _SAME:
            return E
        wrong = [int(row) for row in np.flatnonzero(off > _SAME) if row not in self.free]
        row = wrong[0] if wrong else int(off.argmax())
        partner = int(np.abs(mirror[row]).argmax())
        told = " and ".join(f"'{self.names[r]}' {self._words(r)}" for r in sorted({row, partner}))
        raise RobotError(
            f"the ties of joints are not mirror images: {told}, but in a mirror "
            f"'{self.names[partner]}' {self._image(row)}; correct the file, or leave all "
            "ties out, so that every joint has its own motor: --without ties (in Python and in the "
            'file for --choices without = ["ties"])'
        )

    def _tie(self, row: int) -> Tie:
        master = self.names[int(self.free[self.motor[row]])]
        return Tie(self.names[row], master, float(self.multiplier[row]), float(self.offset[row]))

    def _words(self, row: int) -> str:
        return "follows no other" if row in self.free else str(self._tie(row))

    def _image(self, row: int) -> Tie:
        """Return the tie of a joint seen in a mirror."""
        mirror = self.mirror
        tie, master = self._tie(row), int(self.free[self.motor[row]])
        ends = [int(np.abs(mirror[joint]).argmax()) for joint in (row, master)]
        signs = [float(mirror[joint].sum()) for joint in (row, master)]
        return Tie(
            self.names[ends[0]],
            self.names[ends[1]],
            signs[0] * tie.multiplier * signs[1],
            signs[0] * tie.offset,
        )

    def limits(self, limits: JointLimits) -> JointLimits:
        """Return the limits of the free joints, from those of all.

        Of ranges and speeds of a tie the tightest hold: a joint that follows at k times the rate
        passes on its range, and its speed 1 / |k| times. The torque is that of the free joint,
        whose motor turns all of them.

        Raises:
            RobotError: the ranges of joints that are tied have nothing in common.
        """
        if self.none:
            return limits
        size = np.abs(self.multiplier)
        sides = [(end - self.offset) / self.multiplier for end in (limits.lower, limits.upper)]
        lower, upper = np.minimum(*sides), np.maximum(*sides)
        found = JointLimits(
            torque=limits.torque[self.free],
            speed=self._tightest(limits.speed / size, np.minimum),
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
                "or leave all ties out: --without ties"
            )
        return found

    def complete(self, torque: Array) -> Array:
        """Return torque limits (n,) where free joints without any have that of their motors.

        One motor turns all joints of a tie. Where a file states its torque at a joint that follows
        at k times the rate, it is |k| times that at the joint which is followed.
        """
        if self.none:
            return torque
        given = np.isfinite(torque) & (torque > 0.0)
        reflected = np.where(given, torque, np.inf) * np.abs(self.multiplier)
        of_motor = self._tightest(reflected, np.minimum)
        found = torque.copy()
        lacks = ~given[self.free] & np.isfinite(of_motor)
        found[self.free[lacks]] = of_motor[lacks]
        return found

    def _tightest(self, values: Array, tighter: np.ufunc) -> Array:
        """Return of each tie the tightest of the values of its joints, shape (m,)."""
        found = values[self.free].copy()
        tighter.at(found, self.motor, values)
        return np.asarray(found)


def couple(names: Sequence[str], ties: Mapping[str, Tie], mirror: Array) -> Coupling:
    """Return the coupling of the joints of a chain.

    Args:
        names: of the joints, each with the one that it follows.
        ties: by the joint that follows; joints beside the chain's do not count.
        mirror: the exchange of left and right, shape (n, n).
    """
    free = [row for row, name in enumerate(names) if name not in ties]
    matrix, offset = np.zeros((len(names), len(free))), np.zeros(len(names))
    for row, name in enumerate(names):
        tie = ties.get(name, Tie(name, name))
        matrix[row, free.index(names.index(tie.master))] = tie.multiplier
        offset[row] = tie.offset
    return Coupling(tuple(names), np.array(free, dtype=np.int64), matrix, offset, mirror)
