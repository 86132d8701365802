"""The force that all actuators of an MJCF file together can give each joint.

MuJoCo clamps the control, then the force of each actuator, turns it by gear (and by the coefficient
of a fixed tendon) into a force of the joint, adds those of all actuators of the joint, and clamps
the sum (`actuatorfrcrange`). So the ranges add up, and a joint with one motor without bounds has
none, unless its own range bounds the sum.

Joints that the equalities of an MJCF file tie to each other or to a place.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from types import ModuleType
from typing import Any

Range = tuple[float, float]
FREE: Range = (-math.inf, math.inf)


@dataclass(frozen=True)
class Motors:
    """What actuators do to the joints.

    Attributes:
        ranges: least and largest force [N·m or N] by joint, of those that have a motor or a range.
        coupled: joints that share an actuator through a tendon, whose ranges are not independent.
        left_out: actuators whose force on joints depends on the posture.
        muscles: actuators that count with what they pull at rest at their best length.
        disabled: actuators in groups that the options of the file switch off.
    """

    ranges: dict[int, Range]
    coupled: frozenset[int]
    left_out: tuple[str, ...]
    muscles: tuple[str, ...] = ()
    disabled: tuple[str, ...] = ()


def motors_of(mujoco: ModuleType, model: Any) -> Motors:
    """Return the force ranges of all joints of an MjModel."""
    kinds = mujoco.mjtTrn
    sums: dict[int, Range] = {}
    coupled: set[int] = set()
    left_out, muscles, disabled = [], [], []
    for index in range(len(model.actuator_trntype)):
        name = str(model.actuator(index).name) or f"number {index}"
        if _switched_off(model, index):
            disabled.append(name)
            continue
        if int(model.actuator_gaintype[index]) == mujoco.mjtGain.mjGAIN_MUSCLE:
            muscles.append(name)
        force = _force(mujoco, model, index)
        kind, target = int(model.actuator_trntype[index]), int(model.actuator_trnid[index, 0])
        gear = float(model.actuator_gear[index, 0])
        arms: dict[int, float] | None = None
        if kind in (kinds.mjTRN_JOINT, kinds.mjTRN_JOINTINPARENT):
            arms = {target: gear} if _single(mujoco, model, target) else {}
        elif kind == kinds.mjTRN_TENDON:
            arms = {j: gear * c for j, c in fixed_tendon(mujoco, model, target).items()} or None
            force = _clamped(force, _tendon_range(model, target))
            coupled.update(arms if arms and len(arms) > 1 else ())
        if arms is None:
            left_out.append(name)
            continue
        for joint, arm in arms.items():
            sums[joint] = _added(sums.get(joint, (0.0, 0.0)), _scaled(force, arm))
    for joint in range(model.njnt):
        if model.jnt_actfrclimited[joint]:
            own = _pair(model.jnt_actfrcrange[joint])
            sums[joint] = _clamped(sums[joint], own) if joint in sums else own
    return Motors(sums, frozenset(coupled), tuple(left_out), tuple(muscles), tuple(disabled))


def fixed_tendon(mujoco: ModuleType, model: Any, tendon: int) -> dict[int, float]:
    """Return the coefficient of each joint of a fixed tendon; none of one in space."""
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    arms: dict[int, float] = {}
    for wrap in range(first, first + count):
        if int(model.wrap_type[wrap]) != mujoco.mjtWrap.mjWRAP_JOINT:
            return {}
        joint = int(model.wrap_objid[wrap])
        arms[joint] = arms.get(joint, 0.0) + float(model.wrap_prm[wrap])
    return arms


def _single(mujoco: ModuleType, model: Any, joint: int) -> bool:
    kinds = mujoco.mjtJoint
    return int(model.jnt_type[joint]) in (kinds.mjJNT_HINGE, kinds.mjJNT_SLIDE)


def _switched_off(model: Any, index: int) -> bool:
    """Whether the options of the file disable the group of an actuator."""
    group = int(model.actuator_group[index])
    return 0 <= group <= 30 and bool(int(model.opt.disableactuator) & (1 << group))


def _force(mujoco: ModuleType, model: Any, index: int) -> Range:
    """Return the force range of an actuator before its gear."""
    force = _by_control(mujoco, model, index)
    if model.actuator_forcelimited[index]:
        force = _clamped(force, _pair(model.actuator_forcerange[index]))
    return force


def _by_control(mujoco: ModuleType, model: Any, index: int) -> Range:
    """Return the force that the range of the control allows; that of a servo depends on posture."""
    gain, bias = int(model.actuator_gaintype[index]), int(model.actuator_biastype[index])
    gains, biases = model.actuator_gainprm[index], model.actuator_biasprm[index]
    if gain == mujoco.mjtGain.mjGAIN_MUSCLE:
        return _scaled(_signal(mujoco, model, index), -_peak(model, index))
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
    least, most = _scaled(_signal(mujoco, model, index), float(gains[0]))
    return least + offset, most + offset


def _peak(model: Any, index: int) -> float:
    """Return the force with which a muscle pulls at rest at its best length."""
    force, scale = (float(n) for n in model.actuator_gainprm[index, 2:4])
    if force >= 0.0:
        return force
    reach = float(model.actuator_acc0[index])  # acceleration by a unit force
    return scale / reach if reach > 0.0 else math.inf


def _signal(mujoco: ModuleType, model: Any, index: int) -> Range:
    """Return the range of what the gain multiplies: the control, or the activation it drives."""
    limited = bool(model.actuator_ctrllimited[index])
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL):
        limited = False
    control = _pair(model.actuator_ctrlrange[index]) if limited else FREE
    kind, kinds = int(model.actuator_dyntype[index]), mujoco.mjtDyn
    if kind == kinds.mjDYN_NONE:
        return control
    follows = kind in (kinds.mjDYN_FILTER, kinds.mjDYN_FILTEREXACT)
    signal = control if follows else FREE
    if kind == kinds.mjDYN_MUSCLE:
        signal = (0.0, 1.0)
    if model.actuator_actlimited[index]:
        signal = _clamped(signal, _pair(model.actuator_actrange[index]))
    return signal


def _tendon_range(model: Any, tendon: int) -> Range:
    limited = bool(model.tendon_actfrclimited[tendon])
    return _pair(model.tendon_actfrcrange[tendon]) if limited else FREE


def _pair(numbers: Any) -> Range:
    return float(numbers[0]), float(numbers[1])


def _scaled(force: Range, by: float) -> Range:
    if by == 0.0:
        return 0.0, 0.0
    least, most = force[0] * by, force[1] * by
    return (least, most) if by > 0.0 else (most, least)


def _added(first: Range, second: Range) -> Range:
    return first[0] + second[0], first[1] + second[1]


def _clamped(force: Range, limits: Range) -> Range:
    """Return what is left of a range when every force in it is clamped."""
    least, most = (min(max(f, limits[0]), limits[1]) for f in force)
    return least, most


_NONE: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Tie:
    """An equality that holds from the start.

    Attributes:
        index: of the equality in the model.
        tag: of its element.
        ends: what it ties, in words.
        joints: of those it ties.
        loop: whether it closes a loop of bodies; else it makes joints follow each other.
    """

    index: int
    tag: str
    ends: str
    joints: frozenset[int]
    loop: bool


def ties_of(mujoco: ModuleType, model: Any) -> list[Tie]:
    """Return the equalities of an MjModel that are active.

    Two bodies that are connected tie all joints on the way from one to the other.
    """
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_EQUALITY):
        return []
    kinds, ties = mujoco.mjtEq, []
    for index in range(model.neq):
        if not model.eq_active0[index]:
            continue
        kind = int(model.eq_type[index])
        ends = [int(model.eq_obj1id[index]), int(model.eq_obj2id[index])]
        if kind == kinds.mjEQ_JOINT:
            tag, what, known = "joint", "joint", [frozenset({end}) for end in ends if end >= 0]
            joints = _NONE.union(*known)
        elif kind == kinds.mjEQ_TENDON:
            tag, what = "tendon", "tendon"
            joints = _NONE.union(*(_tendon(mujoco, model, end) for end in ends if end >= 0))
        elif kind in (kinds.mjEQ_CONNECT, kinds.mjEQ_WELD):
            tag = "connect" if kind == kinds.mjEQ_CONNECT else "weld"
            site = int(model.eq_objtype[index]) == mujoco.mjtObj.mjOBJ_SITE
            what = "site" if site else "body"
            bodies = [int(model.site_bodyid[end]) if site else end for end in ends]
            joints = _between(model, bodies)
        else:
            continue
        names = [str(getattr(model, what)(end).name) for end in ends if end >= 0]
        words = " and ".join(f"'{name}'" for name in names if what != "body" or name != "world")
        ties.append(Tie(index, tag, words, joints, tag in ("connect", "weld")))
    return ties


def _carriers(model: Any, body: int) -> frozenset[int]:
    """Return the joints between a body and the world."""
    joints: set[int] = set()
    while body > 0:
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        joints.update(range(first, first + count))
        body = int(model.body_parentid[body])
    return frozenset(joints)


def _between(model: Any, bodies: Collection[int]) -> frozenset[int]:
    """Return the joints on the way between bodies."""
    carriers = [_carriers(model, body) for body in bodies]
    return _NONE.union(*carriers) - carriers[0].intersection(*carriers)


def _tendon(mujoco: ModuleType, model: Any, tendon: int) -> frozenset[int]:
    """Return the joints that change the length of a tendon."""
    joints = fixed_tendon(mujoco, model, tendon)
    if joints:
        return frozenset(joints)
    first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
    sites = [
        int(model.wrap_objid[w])
        for w in range(first, first + count)
        if int(model.wrap_type[w]) == mujoco.mjtWrap.mjWRAP_SITE
    ]
    return _between(model, [int(model.site_bodyid[s]) for s in sites]) if sites else _NONE
