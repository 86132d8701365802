"""Loops of bodies through a leg, as of parallel ankles: which motors turn which of its joints.

An equality that holds two bodies together ties the joints on the way from one to the other: q of
the leg, and u of cranks, which motors turn, and of rods. The loops stay closed where

    J_q dq + J_u du = 0

so that the joints of the leg, as coordinates of the walk, tell all others; see docs/linkages.md.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import field
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.physics import STANDARD_GRAVITY, LoopFrames
from gaitopt.importers.report import Finding, listed
from gaitopt.importers.xml_document import FileProblem
from gaitopt.model.kinematic_tree import LOOP, LegJoints, joint_slides
from gaitopt.model.linkage import MOST_JOINTS, OPEN, Linkage, LoopClosure, Point, Rod, first_fault
from gaitopt.nlp import Array
from gaitopt.units import motion_words

_STEP = 0.05  # rad: of a joint of the leg, while its loops are followed
_NEWTON = 30  # iterations from one step to the next; a handful are needed
_LARGEST_STEP = 0.3  # rad, m: of Newton's method
_RANK = 1e-5  # of the largest singular value: below it there is none
_OPENS = 1e-3  # m per rad: a joint that opens a loop by more is held by it
_SINGULAR = 0.02  # determinant of the rates of motors, each of size 1: they move in one way only
_UNLIKE = 1e-3  # relative: of the motors of both legs
_WIDEST = math.pi  # rad: range of a joint that has none
_ARM = 0.1  # m: of axes that are held together
_MEET = 1e-5  # m: lines that pass a point nearer than that meet there


@dataclass(frozen=True)
class LegLoops:
    """What the loops of bodies in the legs amount to.

    Attributes:
        linkages: of the right leg.
        armature: inertia of rotors, cranks and rods as seen from the joints that these turn, by
            name of the joint [kg·m²].
        passed_on: joints of the legs whose own motors other joints feel too: their torque is not
            the motor's.
        others: joints of cranks and rods in both legs.
        findings: for a person.
    """

    linkages: tuple[Linkage, ...] = ()
    armature: dict[str, float] = field(default_factory=dict)
    passed_on: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = ()


def leg_loops(
    model: pin.Model,
    q: Array,
    loops: Sequence[LoopFrames],
    motors: Collection[str],
    legs: LegJoints,
    problems: Iterable[FileProblem] = (),
) -> LegLoops:
    """Return which motors turn joints of the legs through loops, closed near q (nq,) [rad].

    Raises:
        RobotError: a loop in a leg cannot be reduced to motors, one for each joint.
    """
    lines = {p.name: p for p in problems if p.kind == LOOP}
    sides: list[list[_Mechanism]] = []
    others: list[str] = []
    for leg, other in (legs, legs[::-1]):
        groups = [
            _Mechanism(model, q, group, leg, motors, lines)
            for group in _groups(model, loops)
            if group.joints & {*leg}
        ]
        for one in groups:
            one.check(other)
            others += one.names(one.others)
        sides.append([one for one in groups if not one.idle])
    right, left = sides
    if [one.rows for one in right] != [one.rows for one in left]:
        one = (right or left)[0]
        raise one.refusal("the other leg has no loop through the same joints")
    found = LegLoops(others=tuple(others))
    for one, twin in zip(right, left, strict=True):
        linkage, unlike = _tighter(one, twin)
        own = (j for each in (one, twin) for j in each.turned if j in each.joints)
        found = LegLoops(
            (*found.linkages, linkage),
            {**found.armature, **one.armature, **twin.armature},
            (*found.passed_on, *(str(model.names[j]) for j in own)),
            found.others,
            (*found.findings, *one.findings(linkage), *unlike),
        )
    return found


def apply_loops(model: pin.Model, loops: LegLoops) -> None:
    """Give a model the armature of loops, and no torque limit where motors are felt elsewhere."""
    for name, value in loops.armature.items():
        model.armature[model.joints[model.getJointId(name)].idx_v] += value
    for name in loops.passed_on:
        at = model.joints[model.getJointId(name)].idx_v
        model.effortLimit[at], model.lowerEffortLimit[at] = math.inf, -math.inf


def _tighter(one: _Mechanism, twin: _Mechanism) -> tuple[Linkage, list[Finding]]:
    """Return the linkage of a mechanism with the tighter limits of the two legs."""
    own, other = one.linkage(), twin.linkage()
    order = _pairing(one, twin)
    rates = np.abs(twin.rates[order])
    largest = rates.max(axis=1, keepdims=True)  # of each motor: some turn, some slide
    unlike = float((np.abs(np.abs(one.rates) - rates) / largest).max())
    findings = []
    if unlike > _UNLIKE:
        text = (
            f"rates of the other leg's motors differ by {100.0 * unlike:.2g} %; they are taken as "
            "the mirror image"
        )
        findings.append(Finding("loops", " and ".join(own.joints), text, "warning"))
    for i, (motor, mine, k) in enumerate(zip(own.motors, own.range, order, strict=True)):
        slides = own.slides(i)
        unit = motion_words("rad", slides=slides)
        if not _same_range(mine, its := other.range[k]):
            moves = "slides" if slides else "turns"
            text = (
                f"{moves} {_range_words(mine, unit)}, '{other.motors[k]}' of the other leg "
                f"{_range_words(its, unit)}; the first holds for both, mirrored: narrow it by "
                f"--limit {motor}.range=LOW:HIGH if the other is tighter"
            )
            findings.append(Finding("loops", f"'{motor}'", text, "warning"))
    torque, speed = (
        tuple(
            min((x for x in (mine, its[k]) if x is not None), default=None)
            for mine, k in zip(of, order, strict=True)
        )
        for of, its in ((own.torque, other.torque), (own.speed, other.speed))
    )
    return own._replace(torque=torque, speed=speed), findings


def _same_range(one: tuple[float, float] | None, other: tuple[float, float] | None) -> bool:
    """Return whether a range is another one, or its mirror image."""
    if one is None or other is None:
        return one is other
    return any(np.allclose(one, ends, rtol=_UNLIKE) for ends in (other, (-other[1], -other[0])))


def _range_words(ends: tuple[float, float] | None, unit: str) -> str:
    return "without a range" if ends is None else f"from {ends[0]:.4g} to {ends[1]:.4g} {unit}"


def _pairing(one: _Mechanism, twin: _Mechanism) -> list[int]:
    """Return the motor of the twin that is most like each motor of a mechanism."""
    apart = np.linalg.norm(np.abs(one.rates)[:, None] - np.abs(twin.rates)[None], axis=2)
    straight, crossed = np.trace(apart), np.trace(apart[:, ::-1])
    order = list(range(len(apart)))
    return order[::-1] if crossed < straight else order


def rods_on_balls(model: pin.Model, loops: Sequence[LoopFrames]) -> frozenset[int]:
    """Return the balls in loops, which carry rods."""
    ways = (way for group in _groups(model, loops) for one in group.connections for way in one.ways)
    return frozenset(j for way in ways for j in way if model.joints[j].nv > 1)


class _Connection(NamedTuple):
    """A pair of frames that are held together."""

    frames: tuple[int, int]
    axes: bool  # whether their axes are held together, too
    base: int  # the last joint that carries both
    ways: tuple[tuple[int, ...], tuple[int, ...]]  # joints from there to either frame


class _Group(NamedTuple):
    """Connections that have joints in common, and all joints on their ways."""

    connections: tuple[_Connection, ...]
    joints: frozenset[int]


def _groups(model: pin.Model, loops: Sequence[LoopFrames]) -> list[_Group]:
    groups: list[_Group] = []
    for loop in loops:
        frames = model.getFrameId(loop.first), model.getFrameId(loop.second)
        ways = [list(model.supports[model.frames[f].parentJoint]) for f in frames]
        shared = [j for j in ways[0] if j in ways[1]]
        first, second = (tuple(int(j) for j in way if j not in shared) for way in ways)
        connection = _Connection(frames, loop.axes, int(shared[-1]), (first, second))
        group = _Group((connection,), frozenset((*first, *second)))
        for other in [g for g in groups if g.joints & group.joints]:
            groups.remove(other)
            group = _Group((*other.connections, *group.connections), other.joints | group.joints)
        groups.append(group)
    return groups


class _Mechanism:
    """The closed loops through some joints of one leg, in a posture in which they are closed."""

    def __init__(
        self,
        model: pin.Model,
        q: Array,
        group: _Group,
        leg: Sequence[int],
        motors: Collection[str],
        lines: dict[str, FileProblem],
    ) -> None:
        self.model, self.data, self.group = model, model.createData(), group
        self.lines, self.motors, self.leg = lines, motors, leg
        self.joints = [j for j in leg if j in group.joints]
        self.rows = [list(leg).index(j) for j in self.joints]
        self.others = sorted(group.joints - {*leg})
        self.turned = [j for j in (*self.joints, *self.others) if self.name(j) in motors]
        self.own = self._columns(self.joints)
        self.free = self._columns(self.others)
        self.driven = [[*self.own, *self.free].index(c) for c in self._columns(self.turned)]
        self.q = self.close(q)
        self.twins: list[int] = []  # of the joints, in the other leg
        self.rates = np.zeros((0, 0))
        self.all_rates = np.zeros((len(self.free), len(self.own)))

    def name(self, joint: int) -> str:
        return str(self.model.names[joint])

    def names(self, joints: Iterable[int]) -> tuple[str, ...]:
        return tuple(self.name(j) for j in joints)

    @property
    def idle(self) -> bool:
        """Whether the motors sit at the joints of the leg themselves, and the rest follows."""
        return self.turned == self.joints

    def _columns(self, joints: Sequence[int]) -> list[int]:
        at = [self.model.joints[j] for j in joints]
        return [c for joint in at for c in range(joint.idx_v, joint.idx_v + joint.nv)]

    def refusal(self, why: str, instead: str = "") -> RobotError:
        """Return the error that says why the loops cannot be reduced, and what can be done."""
        name = self.name(self.joints[0])
        words = f"joint '{name}': it is in a loop of bodies"
        return RobotError(
            f"{self.lines.get(name, words)} that cannot be reduced to motors: {why}. "
            f"{f'Either {instead}, or leave' if instead else 'Leave'} all loops of bodies open by "
            "--without loops: their rods and cranks then stand still, and a table, --linkages FILE "
            "(docs/linkages.md), can say which motors turn the joints through them"
        )

    def check(self, other: Sequence[int]) -> None:
        """Find the rates of the motors, which must be one for each joint and hold them."""
        if self.group.joints & {*other}:
            raise self.refusal("it joins both legs")
        self.twins = [other[row] for row in self.rows if row < len(other)]
        gap = float(np.abs(self.gap(self.q)[0]).max())
        if gap > OPEN:
            raise self.refusal(
                f"it is open by {1e3 * gap:.3g} mm where the robot stands; at most "
                f"{1e3 * OPEN:g} mm are closed"
            )
        J = self.gap(self.q)[1]
        J_q, J_u = J[:, self.own], J[:, self.free]
        U, sizes, V = np.linalg.svd(J_u)
        rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
        held = np.linalg.norm(U[:, rank:].T @ J_q, axis=0)
        if held.max() > _OPENS:
            name = self.name(self.joints[int(held.argmax())])
            raise self.refusal(
                f"it holds '{name}', which opens it by {held.max():.3g} m per rad: its rods have "
                "too few joints"
            )
        if self.idle:
            return
        self._check_motors()
        joints = listed(self.names(self.joints), None)
        cranks = [j for j in self.turned if j in self.others]
        loose = V[rank:, [self.free.index(c) for c in self._columns(cranks)]]
        if loose.size and np.abs(loose).max() > _RANK:
            worst = cranks[int(np.abs(loose).max(axis=0).argmax())]
            raise self.refusal(
                f"motor '{self.name(worst)}' turns where {joints} stand still: at a dead point, or "
                "for want of a motor"
            )
        self.all_rates = -np.linalg.pinv(J_u, rcond=_RANK) @ J_q
        self.rates = np.concatenate([np.eye(len(self.own)), self.all_rates])[self.driven]
        sizes = np.linalg.norm(self.rates, axis=1)
        if not sizes.all() or abs(np.linalg.det(self.rates / sizes[:, None])) < _SINGULAR:
            raise self.refusal(
                f"its motors {listed(self.names(self.turned), None)} move {joints} in one way only "
                f"where the robot stands (rates {np.array2string(self.rates, precision=3)})"
            )

    def _check_motors(self) -> None:
        """Refuse loops whose motors are not one for each joint of the leg."""
        joints = listed(self.names(self.joints), None)
        motors = listed(self.names(self.turned), None) or "none"
        if not self.motors:
            raise self.refusal("no joint in it has an actuator, which says what is driven")
        if len(self.joints) > MOST_JOINTS:
            raise self.refusal(
                f"it ties {joints}, {len(self.joints)} joints; at most {MOST_JOINTS}"
            )
        if len(self.driven) != len(self.joints):
            what = "more" if len(self.driven) > len(self.joints) else "fewer"
            raise self.refusal(
                f"there are {what} motors ({motors}) than joints of the leg ({joints})"
            )

    def gap(self, q: Array) -> tuple[Array, Array]:
        """Return how far the loops are open, and the derivative in all velocities."""
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        gaps, rows = [], []
        for connection in self.group.connections:
            first, second = (data.oMf[f] for f in connection.frames)
            J, K = (
                pin.getFrameJacobian(model, data, f, pin.LOCAL_WORLD_ALIGNED)
                for f in connection.frames
            )
            gaps.append(first.translation - second.translation)
            rows.append(J[:3] - K[:3])
            if connection.axes:
                R = second.rotation
                gaps.append(R @ pin.log3(R.T @ first.rotation))
                rows.append(J[3:] - K[3:])
        return np.concatenate(gaps), np.concatenate(rows)

    def close(self, q: Array) -> Array:
        """Return the posture near one in which the loops are closed, the leg as it is."""
        for _ in range(_NEWTON):
            gap, J = self.gap(q)
            if np.abs(gap).max() < 1e-14:
                break
            step = np.zeros(self.model.nv)
            step[self.free] = -np.linalg.pinv(J[:, self.free], rcond=_RANK) @ gap
            size = np.abs(step).max()
            q = pin.integrate(self.model, q, step * min(1.0, _LARGEST_STEP / (size or 1.0)))
            if size < 1e-14:
                break
        return np.asarray(q)

    def at_zero(self) -> Array:
        """Return the posture in which the leg is at 0, followed from the one here."""
        q = self.q
        places = [self.model.joints[j].idx_q for j in self.joints]
        start = q[places]
        for k in range(1, 1 + math.ceil(np.abs(start).max() / _STEP)):
            q = q.copy()
            q[places] = start * max(0.0, 1.0 - k * _STEP / np.abs(start).max())
            q = self.close(q)
        gap = np.abs(self.gap(q)[0]).max()
        if gap > OPEN:
            raise self.refusal(
                f"it opens by {1e3 * gap:.3g} mm on the way to where its joints are at 0, whence "
                "motors count"
            )
        return q

    def linkage(self) -> Linkage:
        """Return cranks and rods, or what else the loops are, if they are sound in the range."""
        q, model = self.at_zero(), self.model
        pin.forwardKinematics(model, self.data, q)
        pin.updateFramePlacements(model, self.data)
        base = self.data.oMi[int(model.parents[self.joints[0]])]
        rods = [self._rod(joint, base) for joint in self.turned]
        ranges = []
        for joint in self.turned:
            at = model.joints[joint].idx_q
            low, high = (
                float(limit[at] - q[at])
                for limit in (model.lowerPositionLimit, model.upperPositionLimit)
            )
            limited = joint in self.others and (math.isfinite(low) or math.isfinite(high))
            ranges.append((low, high) if limited else None)
        columns = self._columns(self.turned)
        torque, speed = (
            tuple(float(n) if math.isfinite(n) else None for n in limit[columns])
            for limit in (model.effortLimit, model.velocityLimit)
        )
        for joint, most in zip(self.turned, torque, strict=True):
            if most is not None and not most > 0.0:
                raise self.refusal(
                    f"its motor '{self.name(joint)}' gives {abs(most):g} {self._unit(joint)} to "
                    "one side; it must push to both"
                )
        none = (None,) * len(rods)
        names, motors = self.names(self.joints), self.names(self.turned)
        cranks = tuple(rod for rod in rods if rod is not None)
        closure = None
        if len(cranks) < len(rods):
            cranks, closure = (), self._closure(base)
        return Linkage(names, motors, (), cranks, torque, speed, none, tuple(ranges), closure)

    def _closure(self, base: pin.SE3) -> LoopClosure:
        """Return the loops as they are, where the joints of the leg are at 0."""
        model, data = self.model, self.data
        pin.computeJointJacobians(model, data)
        last: dict[int, int] = {}  # the number of the coordinate that moves all beyond a joint
        parents, axes, points, slides = list[int](), list[Point](), list[Point](), list[bool]()
        for joint in (*self.joints, *self.others):
            J = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            at, before = model.joints[joint], self._moved_by(joint, last)
            if at.nv not in (1, 3) or at.nq not in (1, 4):
                raise self.refusal(f"joint '{self.name(joint)}' is no hinge, slide or ball")
            for column in J[:, at.idx_v : at.idx_v + at.nv].T:
                parents.append(before)
                slides.append(not column[3:].any())
                axes.append(_point(base.rotation.T @ (column[:3] if slides[-1] else column[3:])))
                points.append(_point(base.actInv(data.oMi[joint].translation)))
                before = last[joint] = len(parents) - 1
        ends = []
        for connection in self.group.connections:
            joints = (
                self._moved_by(model.frames[f].parentJoint, last, own=True)
                for f in connection.frames
            )
            one, other = joints
            for arm in (np.zeros(3), *(_ARM * np.eye(3)[:2] if connection.axes else ())):
                x, y = (_point(base.actInv(data.oMf[f].act(arm))) for f in connection.frames)
                ends.append((one, x, other, y))
        low, high = zip(*map(self._range, self.joints), strict=True)
        motors = tuple([*self.own, *self.free].index(c) for c in self._columns(self.turned))
        found = LoopClosure(
            tuple(parents), tuple(axes), tuple(points), tuple(slides), tuple(ends), motors,
            low, high,
        )  # fmt: skip
        self._check_range(found)
        return found

    def _range(self, joint: int) -> tuple[float, float]:
        """Return the range of a joint of the leg, with 0 in it [rad]."""
        model, at = self.model, self.model.joints[joint].idx_q
        low, high = float(model.lowerPositionLimit[at]), float(model.upperPositionLimit[at])
        return max(min(low, 0.0), -_WIDEST), min(max(high, 0.0), _WIDEST)

    def _moved_by(self, joint: int, last: Mapping[int, int], *, own: bool = False) -> int:
        """Return the coordinate that moves the body before a joint, or beyond it; -1 for none."""
        way = [int(j) for j in self.model.supports[joint]]
        return next((last[j] for j in reversed(way if own else way[:-1]) if j in last), -1)

    def _check_range(self, closure: LoopClosure) -> None:
        """Refuse loops that open, or are at a dead point, in the range of the leg's joints."""
        if not (fault := first_fault(closure)):
            return
        shares = np.arange(0.95, 0.0, -0.05)
        low, high = np.array(closure.lower), np.array(closure.upper)
        within = (closure._replace(lower=tuple(s * low), upper=tuple(s * high)) for s in shares)
        tried = zip(shares, within, strict=True)
        narrow = next((s for s, one in tried if not first_fault(one)), None)
        names = self.names(self.joints)
        at = ", ".join(f"'{n}' at {a:.3g} rad" for n, a in zip(names, fault, strict=True))
        instead = ""
        if narrow is not None:
            ends = {
                self.name(j): [math.trunc(1e3 * narrow * end) / 1e3 for end in self._range(j)]
                for j in (*self.joints, *self.twins)
            }
            instead = "give narrower ranges, in which it is closed: " + " ".join(
                f"--limit {name}.range={a:g}rad:{b:g}rad" for name, (a, b) in ends.items()
            )
        raise self.refusal(f"it opens or is at a dead point with {at}", instead)

    def _rod(self, crank: int, base: pin.SE3) -> Rod | None:
        """Return the rod of a crank, in the frame of the body before the joints; None if none."""
        if crank in self.joints:
            return None
        mine = [c for c in self.group.connections if any(crank in way for way in c.ways)]
        connection = mine[0]
        first, second = (0, 1) if crank in connection.ways[0] else (1, 0)
        near, far = connection.ways[first][1:], connection.ways[second]
        beyond = [j for j in far if j not in self.joints]
        fits = (
            len(mine) == 1
            and not connection.axes
            and connection.ways[first][0] == crank
            and connection.base == int(self.model.parents[self.joints[0]])
            and list(far) == [*self.joints, *beyond]
            and bool(near) != bool(beyond)
        )
        pivot = self._meeting([*near, *beyond]) if fits else None
        if pivot is None or not self._axis(crank).any():
            return None
        ends = [self.data.oMf[f].translation for f in connection.frames]
        crank_end, rod_end = (pivot, ends[second]) if near else (ends[first], pivot)
        axis = self._axis(crank)
        points = [base.actInv(p) for p in (self.data.oMi[crank].translation, crank_end, rod_end)]
        centre, end, tip = points
        return Rod(_point(centre), _point(base.rotation.T @ axis), _point(end), _point(tip))

    def _unit(self, joint: int) -> str:
        """Return the unit of what a motor gives."""
        return motion_words("N·m", slides=joint_slides(self.model.joints[joint]))

    def _axis(self, joint: int) -> Array:
        pin.computeJointJacobians(self.model, self.data)
        J = pin.getJointJacobian(self.model, self.data, joint, pin.LOCAL_WORLD_ALIGNED)
        return np.asarray(J[3:, self.model.joints[joint].idx_v])

    def _meeting(self, joints: Sequence[int]) -> Array | None:
        """Return the point that none of some joints moves, None if there is none."""
        places = [np.array(self.data.oMi[j].translation) for j in joints]
        rows, gaps = [], []
        for joint, place in zip(joints, places, strict=True):
            kind = self.model.joints[joint]
            if kind.nq == kind.nv == 1 and not np.linalg.norm(self._axis(joint)):
                return None  # it slides
            a = self._axis(joint) if kind.nv == 1 else np.zeros(3)
            rows.append(np.eye(3) - np.outer(a, a))
            gaps.append(rows[-1] @ (place - places[0]))
        moved, *_ = np.linalg.lstsq(np.concatenate(rows), np.concatenate(gaps), rcond=1e-9)
        left = np.concatenate(rows) @ moved - np.concatenate(gaps)
        return places[0] + moved if np.abs(left).max() < _MEET else None

    @property
    def armature(self) -> dict[str, float]:
        """Inertia of all that moves beside the leg, seen from its joints [kg·m²], by name."""
        M = pin.crba(self.model, self.data, self.q)
        S = self.all_rates
        cross = M[np.ix_(self.own, self.free)] @ S
        seen = S.T @ M[np.ix_(self.free, self.free)] @ S + cross + cross.T
        return dict(zip(self.names(self.joints), map(float, np.diag(seen)), strict=True))

    def findings(self, linkage: Linkage) -> list[Finding]:
        """Return what a person should know about the loops."""
        model, data = self.model, self.data
        subject = " and ".join(f"'{name}'" for name in linkage.joints)
        motors = [
            f"'{self.name(motor)}'"
            + (" (no torque limit)" if most is None else f" ({most:.4g} {self._unit(motor)})")
            for motor, most in zip(self.turned, linkage.torque, strict=True)
        ]
        rates = "; ".join(
            ", ".join(f"{n:.3g}" for n in row) + " m/rad" * linkage.slides(motor)
            for motor, row in enumerate(self.rates)
        )
        through = "cranks and rods" if linkage.rods else "loops of bodies"
        text = f"turned by {' and '.join(motors)} through {through}, at rates {rates}"
        bodies = {j for one in self.others for j in model.subtrees[one]}
        mass = sum(float(model.inertias[j].mass) for j in bodies)
        pin.forwardKinematics(model, data, self.q)
        lever = np.zeros((3, len(self.free)))
        for joint in bodies:
            J = pin.computeJointJacobian(model, data, self.q, joint)
            body, R = model.inertias[joint], data.oMi[joint].rotation
            linear = R @ (J[:3] - pin.skew(body.lever) @ J[3:])
            lever += body.mass * linear[:, self.free]
        weight = STANDARD_GRAVITY * float(np.linalg.norm(lever @ self.all_rates, axis=0).max())
        seen = ", ".join(f"{value:.3g} kg·m² at '{name}'" for name, value in self.armature.items())
        counts = f"cranks, rods and rotors count as where the robot stands, as armature: {seen}"
        still = (
            f"cranks and rods of {mass:.3g} kg stand still in a walk; left out is how their weight "
            f"moves with the joints, at most {weight:.2g} N·m"
        )
        return [
            Finding("loops", subject, text),
            Finding("loops", subject, counts),
            Finding("loops", subject, still, "changed"),
        ]


def _point(values: Array) -> Point:
    x, y, z = (float(n) for n in values)
    return x, y, z
