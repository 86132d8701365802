"""What acts on the joints of an MJCF file: actuators, tendons, springs, friction, equalities.

MuJoCo clamps the control, then the force of each actuator, turns it by gear (and by the coefficient
of a fixed tendon) into a force of the joint, adds those of all actuators of the joint, and clamps
the sum (`actuatorfrcrange`). So the ranges add up, and a joint with one motor without bounds has
none, unless its own range bounds the sum.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from gaitopt.dataclass import dataclass
from gaitopt.importers.mjcf_compile import Compilation
from gaitopt.importers.mjcf_robot import NO_TURN, Pose, pose
from gaitopt.importers.physics import real_roots
from gaitopt.nlp import Array

Range = tuple[float, float]
FREE: Range = (-math.inf, math.inf)


@dataclass(frozen=True)
class ActuatorForces:
    """What actuators do to the joints.

    Attributes:
        ranges: least and largest force [N·m or N] by joint, of those that have a motor or a range.
        driven: joints that actuators turn.
        coupled: joints that share an actuator through a tendon, whose ranges are not independent.
        left_out: actuators whose force on joints depends on the posture.
        muscles: actuators that count with what they pull at rest at their best length.
        dc_motors: actuators that count with their torque at rest, without cogging.
        disabled: actuators in groups that the options of the file switch off.
    """

    ranges: dict[int, Range]
    driven: frozenset[int]
    coupled: frozenset[int]
    left_out: tuple[str, ...]
    muscles: tuple[str, ...] = ()
    dc_motors: tuple[str, ...] = ()
    disabled: tuple[str, ...] = ()


def actuator_forces(compiled: Compilation) -> ActuatorForces:
    """Return the force ranges of all joints."""
    mujoco, model = compiled.mujoco, compiled.model
    kinds, single = mujoco.mjtTrn, (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    sums: dict[int, Range] = {}
    coupled: set[int] = set()
    left_out, muscles, dc_motors, disabled = [], [], [], []
    for index in range(len(model.actuator_trntype)):
        name = compiled.name("actuator", index)
        group = int(model.actuator_group[index])
        if 0 <= group <= 30 and int(model.opt.disableactuator) & (1 << group):
            disabled.append(name)
            continue
        if int(model.actuator_gaintype[index]) == mujoco.mjtGain.mjGAIN_MUSCLE:
            muscles.append(name)
        if _is_dc_motor(compiled, index):
            dc_motors.append(name)
        force = _by_control(compiled, index)
        if model.actuator_forcelimited[index]:
            force = _clamped(force, model.actuator_forcerange[index])
        kind, target = int(model.actuator_trntype[index]), int(model.actuator_trnid[index, 0])
        gear = float(model.actuator_gear[index, 0])
        arms: dict[int, float] | None = None
        if kind in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
            arms = {target: gear} if int(model.jnt_type[target]) in single else {}
        elif kind == kinds.mjTRN_TENDON:
            arms = {j: gear * c for j, c in compiled.fixed_tendon(target).items()} or None
            if model.tendon_actfrclimited[target]:
                force = _clamped(force, model.tendon_actfrcrange[target])
            coupled.update(arms if arms and len(arms) > 1 else ())
        if arms is None:
            left_out.append(name)
            continue
        for joint, arm in arms.items():
            (least, most), own = sums.get(joint, (0.0, 0.0)), _scaled(force, arm)
            sums[joint] = least + own[0], most + own[1]
    driven = frozenset(sums)
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            sums[joint] = _clamped(sums.get(joint, FREE), model.jnt_actfrcrange[joint])
    return ActuatorForces(
        sums, driven, frozenset(coupled), *map(tuple, (left_out, muscles, dc_motors, disabled))
    )


def _by_control(compiled: Compilation, index: int) -> Range:
    """Return the force that the range of the control allows; that of a servo depends on posture."""
    mujoco, model = compiled.mujoco, compiled.model
    gain, bias = int(model.actuator_gaintype[index]), int(model.actuator_biastype[index])
    gains, biases = model.actuator_gainprm[index], model.actuator_biasprm[index]
    if gain == mujoco.mjtGain.mjGAIN_MUSCLE:
        return _scaled(_signal(compiled, index), -_muscle_peak(model, index))
    if _is_dc_motor(compiled, index) and not gains[2:].any():  # else it has a controller
        resistance, constant = (float(n) for n in gains[:2])
        return _scaled(_signal(compiled, index), constant / resistance)
    affine = (mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtGain.mjGAIN_AFFINE)
    if gain not in affine or bias not in (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE):
        return FREE
    if gain == mujoco.mjtGain.mjGAIN_AFFINE and (gains[1] or gains[2]):
        # A damper, which can but brake, and need not.
        idle = not (gains[0] or gains[1]) and bias == mujoco.mjtBias.mjBIAS_NONE
        return (0.0, 0.0) if idle and gains[2] < 0.0 else FREE
    offset = 0.0
    if bias == mujoco.mjtBias.mjBIAS_AFFINE:
        if biases[1] or biases[2]:
            return FREE
        offset = float(biases[0])
    least, most = _scaled(_signal(compiled, index), float(gains[0]))
    return least + offset, most + offset


def _is_dc_motor(compiled: Compilation, index: int) -> bool:
    """Tell whether an actuator is a DC motor, which MuJoCo has since version 4."""
    kind = getattr(compiled.mujoco.mjtGain, "mjGAIN_DCMOTOR", None)
    return kind is not None and int(compiled.model.actuator_gaintype[index]) == kind


def _muscle_peak(model: Any, index: int) -> float:
    """Return the force with which a muscle pulls at rest at its best length."""
    force, scale = (float(n) for n in model.actuator_gainprm[index, 2:4])
    if force >= 0.0:
        return force
    reach = float(model.actuator_acc0[index])  # acceleration by a unit force
    return scale / reach if reach > 0.0 else math.inf


def _signal(compiled: Compilation, index: int) -> Range:
    """Return the range of what the gain multiplies: the control, or the activation it drives."""
    model, kinds = compiled.model, compiled.mujoco.mjtDyn
    limited = bool(model.actuator_ctrllimited[index]) and not compiled.off("CLAMPCTRL")
    signal = _clamped(FREE, model.actuator_ctrlrange[index]) if limited else FREE
    kind = int(model.actuator_dyntype[index])
    if kind == kinds.mjDYN_NONE:
        return signal
    if kind == kinds.mjDYN_MUSCLE:
        signal = (0.0, 1.0)
    elif kind not in (kinds.mjDYN_FILTER, kinds.mjDYN_FILTEREXACT) and not _is_dc_motor(
        compiled, index
    ):
        signal = FREE
    if model.actuator_actlimited[index]:
        signal = _clamped(signal, model.actuator_actrange[index])
    return signal


def _scaled(force: Range, by: float) -> Range:
    if by == 0.0:
        return 0.0, 0.0
    least, most = force[0] * by, force[1] * by
    return (least, most) if by > 0.0 else (most, least)


def _clamped(force: Range, limits: Iterable[float]) -> Range:
    """Return what is left of a range when every force in it is clamped."""
    low, high = (float(end) for end in limits)
    least, most = (min(max(f, low), high) for f in force)
    return least, most


_POLYNOMIAL = 5  # coefficients of a joint equality


@dataclass(frozen=True)
class Equality:
    """An equality that holds from the start.

    Attributes:
        index: of the equality in the model.
        tag: of its element.
        ends: what it ties, in words.
        joints: of those it ties.
        loop: whether it closes a loop of bodies; else it makes joints follow each other.
        pair: the joint that follows and the one that it follows; None for anything else.
        coefficients: of the polynomial in how far the other is from its `ref`, shape (5,).
        places: of a loop: its two bodies, where in them it is closed, and the name of the site
            there, or empty.
    """

    index: int
    tag: str
    ends: str
    joints: frozenset[int]
    loop: bool
    pair: tuple[int, int] | None = None
    coefficients: tuple[float, ...] = ()
    places: tuple[tuple[int, Pose, str], ...] = ()


def active_equalities(compiled: Compilation) -> list[Equality]:
    """Return the equalities that are active.

    Two bodies that are connected tie all joints on the way from one to the other.
    """
    model, kinds = compiled.model, compiled.mujoco.mjtEq
    found: list[Equality] = []
    for index in range(0 if compiled.off("EQUALITY") else model.neq):
        kind = int(model.eq_type[index])
        ends = [int(model.eq_obj1id[index]), int(model.eq_obj2id[index])]
        known = [end for end in ends if end >= 0]
        if not model.eq_active0[index]:
            continue
        if kind == kinds.mjEQ_JOINT:
            tag = what = "joint"
            joints = frozenset(known)
        elif kind == kinds.mjEQ_TENDON:
            tag = what = "tendon"
            joints = frozenset[int]().union(*(_tendon_joints(compiled, end) for end in known))
        elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            tag = "connect" if kind == kinds.mjEQ_CONNECT else "weld"
            site = int(model.eq_objtype[index]) == compiled.mujoco.mjtObj.mjOBJ_SITE
            what = "site" if site else "body"
            joints = _between(compiled, (model.site_bodyid[e] if site else e for e in ends))
        else:
            continue
        pair = (ends[0], ends[1]) if kind == kinds.mjEQ_JOINT and min(ends) >= 0 else None
        names = [str(getattr(model, what)(end).name) for end in known]
        words = " and ".join(f"'{name}'" for name in names if what != "body" or name != "world")
        numbers = tuple(float(value) for value in model.eq_data[index][:_POLYNOMIAL])
        loop = tag in ("connect", "weld")
        places = _places(compiled, index, what == "site", tag == "weld") if loop else ()
        found.append(Equality(index, tag, words, joints, loop, pair, numbers, places))
    return found


def _places(
    compiled: Compilation, index: int, site: bool, weld: bool
) -> tuple[tuple[int, Pose, str], ...]:
    """Return both ends of a loop of bodies."""
    model = compiled.model
    ends = [int(model.eq_obj1id[index]), int(model.eq_obj2id[index])]
    if site:
        found = [
            (int(model.site_bodyid[end]), pose(model.site_pos[end], model.site_quat[end]),
             str(model.site(end).name))
            for end in ends
        ]  # fmt: skip
    else:
        data = model.eq_data[index]
        points = (data[3:6], data[:3]) if weld else (data[:3], data[3:6])
        turned = data[6:10] / np.linalg.norm(data[6:10]) if weld else NO_TURN
        found = [(ends[0], pose(points[0], turned), ""), (ends[1], pose(points[1], NO_TURN), "")]
    return tuple(found)


def _between(compiled: Compilation, bodies: Iterable[int]) -> frozenset[int]:
    """Return the joints on the way between bodies."""
    carriers = [
        frozenset(j for above in compiled.ancestors(int(body)) for j in compiled.joints(above))
        for body in bodies
    ]
    return frozenset[int]().union(*carriers) - carriers[0].intersection(*carriers)


def _tendon_joints(compiled: Compilation, tendon: int) -> frozenset[int]:
    """Return the joints that change the length of a tendon."""
    if joints := compiled.fixed_tendon(tendon):
        return frozenset(joints)
    model, site = compiled.model, compiled.mujoco.mjtWrap.mjWRAP_SITE
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    wraps = [w for w in range(first, first + count) if int(model.wrap_type[w]) == site]
    bodies = [int(model.site_bodyid[model.wrap_objid[w]]) for w in wraps]
    return _between(compiled, bodies) if bodies else frozenset()


class CompiledPassives:
    """Armature, damping, friction and springs of joints, with those of tendons and actuators.

    Tendons count that depend on one joint alone; of others `left_out` tells.

    Args:
        compiled: the file.
    """

    def __init__(self, compiled: Compilation) -> None:
        self.compiled, self.model = compiled, compiled.model
        self.tendons = [compiled.fixed_tendon(tendon) for tendon in range(self.model.ntendon)]

    def armature(self, joint: int) -> float:
        """Return the inertia of rotors and gears seen from a joint [kg·m² or kg]."""
        motors = sum(g * g * float(self.model.actuator_armature[a]) for a, g in self._gears(joint))
        tendons = sum(c * c * self._tendon_armature(t) for t, c in self._tendons(joint))
        return float(self.model.dof_armature[self._dof(joint)]) + motors + tendons

    def damping(self, joint: int) -> tuple[float, ...]:
        """Return the coefficients of a joint's damping; see `physics.PassiveJoint`."""
        if self.compiled.off("DAMPER"):
            return ()
        model, dof = self.model, self._dof(joint)
        total = np.array([model.dof_damping[dof], *model.dof_dampingpoly[dof]])
        total += self._motor_damping(self._gears(joint))
        for tendon, arm in self._tendons(joint):
            total += self._tendon_damping(tendon) * abs(arm) ** np.arange(2, 2 + total.size)
        return _trimmed(total)

    def friction(self, joint: int) -> float:
        """Return the Coulomb friction of a joint [N·m or N]."""
        if self.compiled.off("FRICTIONLOSS"):
            return 0.0
        loss = self.model.tendon_frictionloss
        tendons = sum(abs(c) * float(loss[t]) for t, c in self._tendons(joint))
        return float(self.model.dof_frictionloss[self._dof(joint)]) + tendons

    def spring(self, joint: int) -> tuple[tuple[float, ...], float]:
        """Return the stiffness of a joint's spring and of its tendons, and where they rest."""
        if self.compiled.off("SPRING"):
            return (), 0.0
        model = self.model
        own = _trimmed([model.jnt_stiffness[joint], *model.jnt_stiffnesspoly[joint]])
        rest = float(model.qpos_spring[int(model.jnt_qposadr[joint])]) if own else 0.0
        torque, alone = _expanded(own, 1.0, rest), True
        for tendon, arm in self._tendons(joint):
            stiff = _trimmed([model.tendon_stiffness[tendon], *model.tendon_stiffnesspoly[tendon]])
            least, most = (float(length) for length in model.tendon_lengthspring[tendon])
            if stiff and least == most:
                torque, alone = torque + _expanded(stiff, arm, least), False
        return (own, rest) if alone else _about_rest(torque, rest)

    def left_out(self, tendon: int) -> list[str]:
        """Return what of a tendon does not count, in words."""
        model = self.model
        given = {
            "armature": self._tendon_armature(tendon),
            "damping": self._tendon_damping(tendon).any(),
            "friction": model.tendon_frictionloss[tendon],
            "stiffness": model.tendon_stiffness[tendon],
        }
        least, most = model.tendon_lengthspring[tendon]
        if len(self.tendons[tendon]) == 1:  # which counts, but for a spring that is slack at times
            given = {"stiffness": given["stiffness"] and least != most}
        given["range"] = model.tendon_limited[tendon] and not self.compiled.off("LIMIT")
        return [word for word, value in given.items() if value]

    def _dof(self, joint: int) -> int:
        return int(self.model.jnt_dofadr[joint])

    def _gears(self, joint: int) -> list[tuple[int, float]]:
        """Return the actuators that turn a joint directly, with their gears."""
        kinds = self.compiled.mujoco.mjtTrn
        return self._driving((int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT)), joint)

    def _driving(self, kinds: tuple[int, ...], target: int) -> list[tuple[int, float]]:
        model = self.model
        return [
            (a, float(model.actuator_gear[a, 0]))
            for a in range(len(model.actuator_trntype))
            if int(model.actuator_trntype[a]) in kinds and model.actuator_trnid[a, 0] == target
        ]

    def _tendons(self, joint: int) -> list[tuple[int, float]]:
        """Return the fixed tendons of one joint alone, with their coefficients."""
        return [(t, arms[joint]) for t, arms in enumerate(self.tendons) if set(arms) == {joint}]

    def _pulling(self, tendon: int) -> list[tuple[int, float]]:
        """Return the actuators that pull a tendon, with their gears."""
        return self._driving((int(self.compiled.mujoco.mjtTrn.mjTRN_TENDON),), tendon)

    def _tendon_armature(self, tendon: int) -> float:
        own, motors = self.model.tendon_armature, self.model.actuator_armature
        return float(own[tendon]) + sum(g * g * float(motors[a]) for a, g in self._pulling(tendon))

    def _tendon_damping(self, tendon: int) -> Array:
        own = [self.model.tendon_damping[tendon], *self.model.tendon_dampingpoly[tendon]]
        return np.array(own) + self._motor_damping(self._pulling(tendon))

    def _motor_damping(self, actuators: list[tuple[int, float]]) -> Array | float:
        """Return the damping of actuators: a polynomial in the rate of the joint or tendon."""
        model = self.model
        return sum(
            (g * g * np.array([model.actuator_damping[a], *model.actuator_dampingpoly[a]])
             for a, g in actuators),
            start=0.0,
        )  # fmt: skip


def _trimmed(numbers: Iterable[float]) -> tuple[float, ...]:
    """Return coefficients without the zeros at the end."""
    values = [float(n) for n in numbers]
    while values and values[-1] == 0.0:
        values.pop()
    return tuple(values)


def _expanded(stiffness: tuple[float, ...], arm: float, length: float) -> Polynomial:
    """Return the torque of a spring of stiffness k0 + k1 x + ..., x = arm q - length, in q."""
    stretch = Polynomial([-length, arm])
    return arm * Polynomial([0.0, *stiffness])(stretch) if stiffness else Polynomial([0.0])


def _about_rest(torque: Polynomial, near: float) -> tuple[tuple[float, ...], float]:
    """Return the stiffness of a torque about the angle at which it vanishes, and that angle."""
    if not (roots := real_roots(torque)):
        return (), 0.0
    rest = min(roots, key=lambda r: abs(r - near))
    orders = range(1, torque.degree() + 1)
    return _trimmed(float(torque.deriv(n)(rest)) / math.factorial(n) for n in orders), rest
