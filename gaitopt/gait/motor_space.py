"""Limits of motors that turn joints through rods or in common: torque, speed, power, angle of each.

With J(q) the rates of the motors per rate of the joints, torque = J^-T Gamma, rate = J dq, and the
power is their product: that of each motor, which may drive while the other brakes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.actuators.linkages import (
    DEAD,
    JointPair,
    MotorAngles,
    check_linkage,
    linkages_from_rows,
    motor_angles,
)
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, there_are
from gaitopt.gait import quantities
from gaitopt.gait.constraint import FREE, Constraint, ConstraintBlock, ConstraintContext
from gaitopt.gait.functions import QuantityFunction
from gaitopt.model.linkage import Linkage
from gaitopt.nlp import Array
from gaitopt.settings import checked
from gaitopt.units import motion_words

if TYPE_CHECKING:
    from gaitopt.model.multibody import Multibody
    from gaitopt.model.robot import Robot

_KINDS = ("torque", "speed", "power")
_ENTRIES = 3  # quantities: torques, rates, angles


@dataclass(frozen=True)
class DrivenJoints:
    """The joints of one leg that a linkage turns.

    Attributes:
        linkage: of the leg that the table speaks of.
        where: the joints of it before they bend.
        rows: of the joints, in those of the robot that follow no other.
        signs: of their angles as seen in the leg that the table speaks of, shape (m,).
        names: of the joints.
    """

    linkage: Linkage
    where: JointPair
    rows: tuple[int, ...]
    signs: Array
    names: tuple[str, ...]

    def motors(self, q: Array) -> MotorAngles:
        """Return the motors at angles (K, n) [rad] of the joints, per angle of their own."""
        return motor_angles(self.linkage, self.where, q[:, self.rows] * self.signs)

    def values(self, torque: Array, rate: Array, q: Array) -> dict[str, Array]:
        """Return torque, speed, power and angle of the motors.

        Args:
            torque, rate, q: of the robot's joints [N·m, rad/s, rad], shape (K, n) each.

        Returns:
            Shape (K, m) each [N·m, rad/s, W, rad; of motors that slide N, m/s, W, m]; and the
            cosines of `Reach` before the angle.
        """
        at = self.motors(q)
        J = at.jacobian
        turned = torque[:, self.rows] * self.signs
        held: Array = np.asarray(
            np.linalg.solve(np.swapaxes(J, 1, 2), turned[..., None])[..., 0], dtype=np.float64
        )
        turning = (J @ (rate[:, self.rows] * self.signs)[..., None])[..., 0]
        power = held * turning
        told = {"torque": held, "speed": turning, "power": power}
        return {**told, "reach": at.reach.cosine, "angle": at.angle}

    def accelerations(self, rate: Array, acceleration: Array, q: Array) -> Array:
        """Return the accelerations of the motors [rad/s² or m/s²], shape (K, m); see `values`."""
        at = self.motors(q)
        dq, ddq = (part[:, self.rows] * self.signs for part in (rate, acceleration))
        turned = np.einsum("kij,kj->ki", at.jacobian, ddq)
        return np.asarray(turned + np.einsum("kijx,kj,kx->ki", at.first, dq, dq))


def driven_joints(robot: Robot, linkages: tuple[Linkage, ...] = ()) -> list[DrivenJoints]:
    """Return the joints of both legs that linkages turn: those of the robot's file, and others.

    Raises:
        InputError: a joint is not there, does not move by itself, or is turned by two linkages; the
            joints do not follow each other.
        SpecError: the motors cannot hold the joints.
    """
    every = (*robot.linkages, *linkages)
    return joints_of_linkages(robot.joint_names, robot.mirror, robot.multibody, every)


def joints_of_linkages(
    names: tuple[str, ...], mirror: Array, body: Multibody, linkages: tuple[Linkage, ...]
) -> list[DrivenJoints]:
    """Return the joints that linkages turn, both legs one after the other for each linkage.

    Args:
        names: of the joints that move by themselves.
        mirror: the exchange E of left and right.
        linkages: of one leg each.

    Raises:
        InputError, SpecError: see `driven_joints`.
    """
    found: list[DrivenJoints] = []
    for linkage in linkages:
        for name in linkage.joints:
            if name not in names:
                raise InputError(
                    f"a linkage turns '{name}', but no joint that moves by itself is called so; "
                    f"{there_are(names, name)}"
                )
        own = [names.index(name) for name in linkage.joints]
        where = _in_a_row(body, linkage)
        check_linkage(linkage, where)
        others = [int(np.abs(mirror[:, row]).argmax()) for row in own]
        signs = np.array([mirror[o, row] for o, row in zip(others, own, strict=True)])
        for rows, turned in ((own, np.ones(len(own))), (others, signs)):
            told = tuple(names[row] for row in rows)
            found.append(DrivenJoints(linkage, where, tuple(rows), turned, told))
    taken: set[int] = set()
    for one in found:
        if again := taken & {*one.rows}:
            raise InputError(
                f"two linkages turn '{names[min(again)]}'; give the joints of one leg only, once: "
                "the other leg is its mirror image; or leave the loops of its file open by "
                "--without loops, if one of the two is of these"
            )
        taken |= {*one.rows}
    return found


def _in_a_row(body: Multibody, linkage: Linkage) -> JointPair:
    rows = [body.joint_names.index(name) for name in linkage.joints]
    for before, after in pairwise(rows):
        if linkage.rods and body.parent[after] != before:
            raise InputError(
                f"a linkage with rods turns '{body.joint_names[before]}', then "
                f"'{body.joint_names[after]}', but these do not follow each other in the robot; "
                "give them from the pelvis on, or rates in place of rods"
            )
    return JointPair(body.placement[rows], body.axis[rows])


@dataclass(frozen=True)
class MotorLimits(QuantityFunction):
    """Torque, speed and power of motors over their limits, of torques, rates and angles.

    Attributes:
        groups: the joints.
        count: n, of the robot's joints.
        kept: of each group, which of its 5 m rows have limits: torques, speeds, powers, cosines of
            `Reach`, angles.
        limits: of these rows.
    """

    groups: tuple[DrivenJoints, ...]
    count: int
    kept: tuple[tuple[int, ...], ...]
    limits: tuple[Array, ...]

    def value(self, quantity: Array) -> Array:
        parts = np.split(quantity, _ENTRIES, axis=1)
        found = []
        for group, kept, limits in zip(self.groups, self.kept, self.limits, strict=True):
            values = np.concatenate([*group.values(*parts).values()], axis=1)
            found.append(values[:, kept] / limits)
        return np.concatenate(found, axis=1)

    def jacobian(self, quantity: Array) -> Array:
        found = []
        for group, kept, limits in zip(self.groups, self.kept, self.limits, strict=True):
            local = _Local(group, np.split(quantity, _ENTRIES, axis=1)).first[:, kept]
            rows = np.zeros((len(quantity), len(kept), _ENTRIES * self.count))
            rows[:, :, self._columns(group)] = local / limits[:, None]
            found.append(rows)
        return np.concatenate(found, axis=1)

    def hessian(self, quantity: Array, weights: Array) -> Array:
        found = np.zeros((len(quantity), _ENTRIES * self.count, _ENTRIES * self.count))
        begin = 0
        for group, kept, limits in zip(self.groups, self.kept, self.limits, strict=True):
            end = begin + len(kept)
            local = _Local(group, np.split(quantity, _ENTRIES, axis=1)).second()[:, kept]
            weighted = np.einsum("kr,krij->kij", weights[:, begin:end] / limits, local)
            columns = self._columns(group)
            found[:, columns[:, None], columns] += weighted
            begin = end
        return found

    def _columns(self, group: DrivenJoints) -> Array:
        rows = np.array(group.rows)
        return np.concatenate([rows + k * self.count for k in range(_ENTRIES)])


class _Local:
    """Torques, speeds, powers, reach, angles of m motors in (Gamma, dq, q) of their m joints.

    Attributes:
        first: derivatives, shape (K, 5 m, 3 m).
    """

    def __init__(self, group: DrivenJoints, parts: list[Array]) -> None:
        m, signs = len(group.rows), group.signs
        self._torque, self._rate, q = (part[:, group.rows] * signs for part in parts)
        self._at = at = motor_angles(group.linkage, group.where, q)
        self._W = W = np.linalg.inv(at.jacobian)
        # dW = -W dJ W; the last axes are those of the angles
        self._JW = np.einsum("kabc,kbd->kadc", at.first, W)  # (dJ W)
        self._W1 = -np.einsum("kab,kbdc->kadc", W, self._JW)
        self._y = np.einsum("kji,kj->ki", W, self._torque)
        self._s = np.einsum("kij,kj->ki", at.jacobian, self._rate)
        self._parts = G, V, Q = slice(0, m), slice(m, 2 * m), slice(2 * m, 3 * m)
        self._y1, self._s1, c1, a1 = np.zeros((4, len(q), m, 3 * m))
        self._y1[:, :, G] = W.swapaxes(1, 2)
        self._y1[:, :, Q] = np.einsum("kjix,kj->kix", self._W1, self._torque)
        self._s1[:, :, V] = at.jacobian
        self._s1[:, :, Q] = np.einsum("kijx,kj->kix", at.first, self._rate)
        p1 = self._y1 * self._s[..., None] + self._s1 * self._y[..., None]
        c1[:, :, Q], a1[:, :, Q] = at.reach.first, at.jacobian
        self._seen = np.tile(signs, _ENTRIES)
        self.first = np.concatenate([self._y1, self._s1, p1, c1, a1], axis=1) * self._seen

    def second(self) -> Array:
        """Return the second derivatives, shape (K, 5 m, 3 m, 3 m)."""
        at, W, JW, W1, (G, V, Q) = self._at, self._W, self._JW, self._W1, self._parts
        both = np.einsum("kab,kbcx,kcdy->kadxy", W, JW, JW)
        W2 = both + both.swapaxes(3, 4)
        W2 -= np.einsum("kab,kbcxy,kcd->kadxy", W, at.second, W)
        y2, s2, c2 = np.zeros((3, *self._y1.shape, self._y1.shape[-1]))
        y2[:, :, G, Q] = np.einsum("kjix->kijx", W1)
        y2[:, :, Q, G] = np.einsum("kjix->kixj", W1)
        y2[:, :, Q, Q] = np.einsum("kjixy,kj->kixy", W2, self._torque)
        s2[:, :, V, Q] = at.first
        s2[:, :, Q, V] = np.einsum("kijx->kixj", at.first)
        s2[:, :, Q, Q] = np.einsum("kijxy,kj->kixy", at.second, self._rate)
        crossed = self._y1[..., :, None] * self._s1[..., None, :]
        p2 = y2 * self._s[..., None, None] + s2 * self._y[..., None, None]
        p2 += crossed + crossed.swapaxes(2, 3)
        a2 = np.zeros_like(c2)
        c2[:, :, Q, Q], a2[:, :, Q, Q] = at.reach.second, at.first
        found = np.concatenate([y2, s2, p2, c2, a2], axis=1)
        return np.asarray(found * self._seen * self._seen[:, None])


@dataclass(frozen=True)
class LoopMotors(Constraint):
    """Motors of loops of bodies in the robot's file keep limits of their own."""

    name, unit, words = "loop motors", "1", "share of the limits of motors of loops"
    reads = (quantities.TORQUE, quantities.RATES, quantities.ANGLES)

    def asked(self, context: ConstraintContext) -> bool:
        return bool(context.robot.linkages)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        """Return up to four rows for each motor, and one for the reach of each rod.

        Raises:
            InputError: the linkages do not fit the robot.
        """
        groups = self._groups(context.robot)
        kept: list[tuple[int, ...]] = []
        limits: list[Array] = []
        labels: list[str] = []
        lower: list[float] = []
        upper: list[float] = []
        for group in groups:
            limited = _limited(group)
            kept.append(tuple(row for row, *_ in limited))
            limits.append(np.array([limit for _, _, limit, *_ in limited]))
            labels += [label for _, label, *_ in limited]
            lower += [low for *_, low, _ in limited]
            upper += [high for *_, high in limited]
        count = len(context.robot.joint_names)
        function = MotorLimits(tuple(groups), count, tuple(kept), tuple(limits))
        return self.over_step(
            context, function, tuple(labels), lower=np.array(lower), upper=np.array(upper)
        )

    def _groups(self, robot: Robot) -> list[DrivenJoints]:
        return driven_joints(robot)


@checked
@dataclass(frozen=True)
class MotorSpace(LoopMotors):
    """Motors that turn joints in common keep limits of their own on torque, speed and power.

    Attributes:
        linkages: see `gaitopt.actuators.linkages.read_linkages`; none: the constraint is off.
    """

    name, unit, words = "motor space", "1", "share of the limits of motors of linkages"
    linkages: tuple[Linkage, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "linkages", linkages_from_rows(self.linkages))

    def asked(self, context: ConstraintContext) -> bool:
        del context
        return bool(self.linkages)

    def _groups(self, robot: Robot) -> list[DrivenJoints]:
        return driven_joints(robot, self.linkages)[2 * len(robot.linkages) :]


def _limited(group: DrivenJoints) -> list[tuple[int, str, float, float, float]]:
    """Return of the rows that have limits: number, label, limit, and how many of it are allowed."""
    m, linkage = len(group.rows), group.linkage
    found = []
    for k, kind in enumerate(_KINDS):
        # what a motor brakes with is no load of its supply: power is limited where it drives
        least = -FREE if kind == "power" else -1.0
        for i, (motor, limit) in enumerate(
            zip(linkage.motors, getattr(linkage, kind), strict=True)
        ):
            if limit is not None:
                told = motion_words(kind, slides=linkage.slides(i))
                label = f"{group.names[0]} {told} of motor {motor}"
                found.append((k * m + i, label, limit, least, 1.0))
    if linkage.rods:
        for i, motor in enumerate(linkage.motors):
            label = f"{group.names[0]} reach of the rod of motor {motor}"
            found.append((len(_KINDS) * m + i, label, DEAD, -1.0, 1.0))
    if linkage.closure is not None:
        for i, joint in enumerate(group.names):
            found.append((len(_KINDS) * m + i, f"{joint} range of its loops", DEAD, -1.0, 1.0))
    for i, (motor, ends) in enumerate(zip(linkage.motors, linkage.range, strict=True)):
        if ends is not None:
            told = motion_words("angle", slides=linkage.slides(i))
            label = f"{group.names[0]} {told} of motor {motor}"
            largest = max(abs(end) for end in ends if np.isfinite(end))
            low, high = (end / largest if np.isfinite(end) else FREE * end for end in ends)
            found.append(((1 + len(_KINDS)) * m + i, label, largest, low, high))
    return found
