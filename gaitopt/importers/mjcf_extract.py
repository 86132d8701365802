"""The robot in a compiled MJCF file, as plain numbers; and what a person should know about it.

A robot may float on a free joint, slide and turn on up to six joints, or be fixed to the world:
here it always floats, for it is going to walk.

What acts on its joints are actuators, tendons, springs, friction and equalities. MuJoCo clamps the
control, then the force of each actuator, turns it by gear (and by the coefficient of a fixed
tendon) into a force of the joint, adds those of all actuators of the joint, and clamps the sum
(`actuatorfrcrange`). So the ranges add up, and a joint with one motor without bounds has none,
unless its own range bounds the sum.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from numpy.polynomial import Polynomial

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.mjcf_compile import Compilation, element_named, refusal_of
from gaitopt.importers.mjcf_robot import (
    GEOM_KINDS,
    NO_TURN,
    NOT_FINITE,
    CompiledBody,
    CompiledGeom,
    CompiledJoint,
    CompiledLoop,
    CompiledRobot,
    CompiledSite,
    Pose,
    fault_of,
    pose,
    pose_of,
    se3,
    vector,
)
from gaitopt.importers.physics import Tie, fault_of_tie, real_roots, ties_to_masters
from gaitopt.importers.pinocchio_model import MOST_JOINTS
from gaitopt.importers.report import Finding, How, listed
from gaitopt.importers.xml_document import FileProblem, XmlTree
from gaitopt.nlp import Array
from gaitopt.units import motion_words

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


_CARRIER_MASS_SHARE = 0.01  # of the robot's mass: a body that only carries a joint of the root
_MOST_ROOT_JOINTS = 6
_SHOWN_GROUPS = 3  # of geoms: MuJoCo's viewer shows groups 0, 1 and 2 unless told otherwise
_NO_COLOUR = (0.5, 0.5, 0.5, 1.0)  # of a geom that says no colour; then its material's counts


class _Root(NamedTuple):
    """The body from which a robot hangs."""

    body: int
    carriers: tuple[int, ...] = ()  # between it and the world: they move and have its mass
    joints: tuple[int, ...] = ()  # of body and carriers, which a free-flyer replaces
    free: bool = False  # whether the file lets it float


def extract(
    compiled: Compilation, tree: XmlTree
) -> tuple[CompiledRobot, tuple[FileProblem, ...], tuple[Finding, ...]]:
    """Return the one robot of a compiled file, what is suspicious in it, and how it was read.

    Raises:
        RobotError: nothing moves, a number is not finite, or there are too many joints.
    """
    with np.errstate(all="ignore"):  # what is not finite is refused with its place
        return _Extraction(compiled, tree).run()


class _Tree:
    """The tree of the bodies of a compiled file, and the robots in it."""

    def __init__(self, compiled: Compilation) -> None:
        self.compiled, self.model = compiled, compiled.model
        kinds = compiled.mujoco.mjtJoint
        self.free, self.slide = int(kinds.mjJNT_FREE), int(kinds.mjJNT_SLIDE)
        self.hinge = int(kinds.mjJNT_HINGE)
        self.children: dict[int, list[int]] = {body: [] for body in range(self.model.nbody)}
        for body in range(1, self.model.nbody):
            self.children[int(self.model.body_parentid[body])].append(body)

    def below(self, body: int) -> Iterator[int]:
        """Yield a body and all that hang on it, depth first."""
        yield body
        for child in self.children[body]:
            yield from self.below(child)

    def robots(self) -> list[_Root]:
        """Return all that moves, what has most joints first."""
        found = [root for top in self.children[0] if self._moves(top) for root in self._roots(top)]
        if not found:
            raise RobotError("the MJCF file has no body that moves; it describes no robot")
        return sorted(found, key=lambda root: -self._count(root))

    def _moves(self, body: int) -> bool:
        return any(self.compiled.joints(b) for b in self.below(body))

    def _has(self, kind: int, body: int) -> bool:
        return any(int(self.model.jnt_type[j]) == kind for j in self.compiled.joints(body))

    def _count(self, root: _Root) -> int:
        """Return how many joints a robot has beside those of its root."""
        joints = self.compiled.joints
        return sum(len(joints(b)) for b in self.below(root.body)) - len(joints(root.body))

    def _roots(self, body: int) -> list[_Root]:
        """Return the robots on a body that hangs on the world or on what is fixed to it."""
        if self.compiled.joints(body):
            return [self._jointed(body)]
        hanging = [child for child in self.children[body] if self._moves(child)]
        inner = [root for child in hanging for root in self._roots(child)]
        # What hangs on hinges alone are the limbs of a body that is held.
        return [root for root in inner if root.free] or [_Root(body)]

    def _jointed(self, first: int) -> _Root:
        """Return the robot of which the first body has joints."""
        joints = self.compiled.joints
        if self._has(self.free, first):
            return _Root(first, (), joints(first), True)
        path = [first]
        while len(self.children[path[-1]]) == 1 and self._only_carries(first, path):
            path += self.children[path[-1]]
        if not any(self._has(self.slide, body) for body in path):
            return _Root(first, (), joints(first))
        return _Root(path[-1], tuple(path[:-1]), tuple(j for b in path for j in joints(b)), True)

    def _only_carries(self, first: int, path: list[int]) -> bool:
        """Whether the last body of a path is light, and the joints may still all be the root's."""
        (child,) = self.children[path[-1]]
        count = sum(len(self.compiled.joints(b)) for b in [*path, child])
        light = (
            self.model.body_mass[path[-1]]
            <= _CARRIER_MASS_SHARE * self.model.body_subtreemass[first]
        )
        return bool(light and self.compiled.joints(child) and count <= _MOST_ROOT_JOINTS)


class _Extraction:
    """One reading of a compiled file."""

    def __init__(self, compiled: Compilation, tree: XmlTree) -> None:
        self.compiled, self.model, self.tree = compiled, compiled.model, tree
        self.bodies = _Tree(compiled)
        self.root, *self.others = self.bodies.robots()
        self.data = compiled.mujoco.MjData(self.model)
        compiled.mujoco.mj_kinematics(self.model, self.data)  # of the posture as drawn
        self.forces, self.passive = actuator_forces(compiled), CompiledPassives(compiled)
        self.joint_names = _names("joint", (self.model.joint(j) for j in range(self.model.njnt)))
        self.body_names = _names("body", (self.model.body(b) for b in range(self.model.nbody)))
        self.paired = {int(g) for g in [*self.model.pair_geom1, *self.model.pair_geom2]}
        self.kinds = {
            int(getattr(compiled.mujoco.mjtJoint, f"mjJNT_{kind.upper()}")): kind
            for kind in ("hinge", "slide", "ball")
        }
        self.findings: list[Finding] = []
        self.equalities = active_equalities(compiled)
        self.ends: dict[int, list[CompiledSite]] = {}  # of loops, by body, that have no site
        self.closed: set[int] = set()  # equalities that are loops of this robot

    def run(self) -> tuple[CompiledRobot, tuple[FileProblem, ...], tuple[Finding, ...]]:
        """Return the robot, problems and findings."""
        kept = [*self.bodies.below(self.root.body), *reversed(self.root.carriers)]
        moving = {j for b in kept for j in self.compiled.joints(b)} - set(self.root.joints)
        joints = sorted(moving)
        if len(joints) > MOST_JOINTS:
            raise RobotError(
                f"the MJCF file has {len(joints)} joints that move; at most {MOST_JOINTS} can be "
                "read; make those that a walk does not need fixed (remove their <joint>)"
            )
        self._check_root()
        self._tell_root()
        loops, turned = self._loops(kept)
        place = {body: index for index, body in enumerate(kept)}
        bodies = tuple(self._body(body, place) for body in kept)
        shown = {geom.mesh for body in bodies for geom in body.geoms}
        gravity = (0.0, 0.0, 0.0) if self.compiled.off("GRAVITY") else self.model.opt.gravity
        ties, tied = self._ties(moving)
        robot = CompiledRobot(
            ties=ties,
            name=str(self.model.names[: self.model.names.index(b"\0")].decode("utf-8", "replace")),
            gravity=vector(gravity),
            bodies=_with_some_drawn(bodies),
            meshes=tuple(mesh for name, mesh in self.compiled.meshes.items() if name in shown),
            keyframes=self._keyframes(joints),
            loops=loops,
            motors=tuple(self.joint_names[j] for j in sorted(turned & moving)),
        )
        tag, name, fault = fault_of(robot)
        if fault:
            raise refusal_of(self.tree, tag, name, fault)
        self._tell_joints(robot, joints)
        self._tell_actuators(moving)
        self._tell_rest(joints)
        problems = [*tied, *self._force_problems(joints)]
        problems.sort(key=lambda problem: problem.line)
        return robot, tuple(problems), tuple(self.findings)

    def _body(self, body: int, place: dict[int, int]) -> CompiledBody:
        model = self.model
        world = pose(self.data.xpos[body], self.data.xquat[body])
        index, where = -1, world
        if body in self.root.carriers:
            # What carried the root hangs on it now, as it stands in the posture that is drawn.
            root = pose(self.data.xpos[self.root.body], self.data.xquat[self.root.body])
            index, where = 0, pose_of(se3(root).actInv(se3(world)))
        elif body != self.root.body:
            index = place[int(model.body_parentid[body])]
            where = pose(model.body_pos[body], model.body_quat[body])
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        geoms = [self._geom(g) for g in range(first, first + count)]
        sites = [
            int(s) for s in np.flatnonzero(model.site_bodyid == body) if model.site(int(s)).name
        ]
        return CompiledBody(
            name=self.body_names[body],
            parent=index,
            place=where,
            mass=float(model.body_mass[body]),
            centre=pose(model.body_ipos[body], model.body_iquat[body]),
            moments=vector(model.body_inertia[body]),
            gravcomp=self._gravcomp(body),
            joints=tuple(
                self._joint(j) for j in self.compiled.joints(body) if j not in self.root.joints
            ),
            geoms=tuple(geom for geom in geoms if geom is not None),
            sites=(
                *(
                    CompiledSite(
                        str(model.site(s).name), pose(model.site_pos[s], model.site_quat[s])
                    )
                    for s in sites
                ),
                *self.ends.get(body, ()),
            ),
        )

    def _gravcomp(self, body: int) -> float:
        """Return the compensation of a body's weight; none where motors are what compensates it."""
        # MuJoCo counts negative ones only beside one that is positive.
        carriers = (j for b in self.compiled.ancestors(body) for j in self.compiled.joints(b))
        if any(self.model.jnt_actgravcomp[j] for j in carriers):
            return 0.0
        return (
            float(self.model.body_gravcomp[body]) if (self.model.body_gravcomp > 0).any() else 0.0
        )

    def _joint(self, joint: int) -> CompiledJoint:
        model, passive, kind = self.model, self.passive, self.kinds[int(self.model.jnt_type[joint])]
        name, pos = self.joint_names[joint], vector(model.jnt_pos[joint])
        if kind == "ball":  # its three rates have the same of each
            armature = float(model.dof_armature[int(model.jnt_dofadr[joint])])
            return CompiledJoint(
                name, kind, pos, armature=armature, damping=passive.damping(joint),
                friction=passive.friction(joint), stiffness=passive.spring(joint)[0],
            )  # fmt: skip
        limited = model.jnt_limited[joint] and not self.compiled.off("LIMIT")
        lower, upper = (float(end) for end in (model.jnt_range[joint] if limited else FREE))
        least, most = self.forces.ranges.get(joint, FREE)
        stiffness, rest = passive.spring(joint)
        return CompiledJoint(
            name=name,
            kind=kind,
            pos=pos,
            axis=vector(model.jnt_axis[joint]),
            ref=float(model.qpos0[int(model.jnt_qposadr[joint])]),
            lower=lower,
            upper=upper,
            armature=passive.armature(joint),
            damping=passive.damping(joint),
            friction=passive.friction(joint),
            stiffness=stiffness,
            rest=rest,
            least=least,
            most=most,
        )

    def _geom(self, geom: int) -> CompiledGeom | None:
        model, kinds = self.model, self.compiled.mujoco.mjtGeom
        names = {int(getattr(kinds, f"mjGEOM_{name.upper()}")): name for name in GEOM_KINDS}
        names[int(kinds.mjGEOM_SDF)] = "mesh"
        kind = names.get(int(model.geom_type[geom]))
        if kind is None:  # planes and height fields are terrain
            return None
        place, mesh = pose(model.geom_pos[geom], model.geom_quat[geom]), ""
        if kind == "mesh":
            index = int(model.geom_dataid[geom])
            mesh = str(model.mesh(index).name)
            moved = se3(pose(model.mesh_pos[index], model.mesh_quat[index]))
            place = pose_of(se3(place) * moved.inverse())
        red, green, blue, opacity = (float(n) for n in model.geom_rgba[geom])
        if (red, green, blue, opacity) == _NO_COLOUR and model.geom_matid[geom] >= 0:
            red, green, blue, opacity = map(float, model.mat_rgba[model.geom_matid[geom]])
        name = str(model.geom(geom).name)
        touches = model.geom_contype[geom] or model.geom_conaffinity[geom]
        return CompiledGeom(
            name=name,
            kind=kind,
            size=(0.0, 0.0, 0.0) if mesh else vector(model.geom_size[geom]),
            place=place,
            mesh=mesh,
            rgba=(red, green, blue, opacity),
            touches=bool(touches) or geom in self.paired or name in self.compiled.touching,
            drawn=int(model.geom_group[geom]) < _SHOWN_GROUPS and opacity > 0.0,
        )

    def _keyframes(
        self, joints: list[int]
    ) -> tuple[tuple[str, tuple[tuple[str, float], ...]], ...]:
        model = self.model
        names = _names("key", (model.key(k) for k in range(model.nkey)))
        single = [j for j in joints if self.kinds[int(model.jnt_type[j])] != "ball"]
        places = [(self.joint_names[j], int(model.jnt_qposadr[j])) for j in single]
        return tuple(
            (names[k], tuple((joint, float(model.key_qpos[k, at])) for joint, at in places))
            for k in range(model.nkey)
        )

    # What is told

    def _announce(self, topic: str, subject: str, text: str, how: How = "warning") -> None:
        self.findings.append(Finding(topic, subject, text, how))

    def _check_root(self) -> None:
        """Check the numbers of the joints that hold the root, though they do not count."""
        model = self.model
        for joint in self.root.joints:
            dofs, at = model.dof_jntid == joint, model.jnt_qposadr[joint]
            own = (model.jnt_axis[joint], model.jnt_pos[joint], model.dof_armature[dofs])
            passive = (model.dof_damping[dofs], model.dof_frictionloss[dofs])
            spring = (model.jnt_stiffness[joint], model.qpos0[at], model.qpos_spring[at])
            if not all(np.isfinite(numbers).all() for numbers in (*own, *passive, *spring)):
                raise refusal_of(self.tree, "joint", self.joint_names[joint], NOT_FINITE)

    def _tell_root(self) -> None:
        name, root, model = f"'{self.body_names[self.root.body]}'", self.root, self.model
        if self.others:
            others = listed((str(model.body(r.body).name) for r in self.others), None)
            text = f"the file holds others that move, too, which are left out: {others}"
            self._announce("root", name, text, "guessed")
        dofs = [d for d in range(model.nv) if int(model.dof_jntid[d]) in root.joints]
        passive = {
            "armature": model.dof_armature,
            "damping": model.dof_damping,
            "friction": model.dof_frictionloss,
        }
        if words := [word for word, values in passive.items() if values[dofs].any()]:
            text = f"floats free: the {', '.join(words)} of what holds it in the file is left out"
            self._announce("root", name, text, "changed")
        if not root.joints:
            self._announce("root", name, "floats, though the file fixes it to the world", "changed")
        elif int(model.jnt_type[root.joints[0]]) != self.bodies.free:
            names = ", ".join(self.joint_names[j] for j in root.joints)
            text = f"floats; the joints that hold it in the file do not count: {names}"
            self._announce("root", name, text, "changed")
        held = [e for e in self.equalities if e.joints and e.joints <= set(root.joints)]
        if tags := sorted({f"<{equality.tag}>" for equality in held}):
            text = f"floats; what holds it in <equality> does not count: {', '.join(tags)}"
            self._announce("root", name, text, "changed")

    def _tell_joints(self, robot: CompiledRobot, joints: list[int]) -> None:
        model = self.model
        if robot.drawn_posture:
            drawn = ", ".join(f"{n} {value:.4g}" for n, value in robot.drawn_posture.items())
            text = (
                "joint coordinates, ranges and postures are MuJoCo's: the posture that the file "
                f"draws has them at their ref, not at 0: {drawn} (rad, or m)"
            )
            self._announce("posture", "all joints", text, "found")
        for joint in joints:
            least, most = (float(end) for end in model.jnt_range[joint])
            if not model.jnt_limited[joint] and least > most:
                text = f"its range {least:g} to {most:g} is upside down: to MuJoCo, it has none"
                self._announce("limits", self.joint_names[joint], text)
        for index in range(len(model.actuator_trntype)):
            for what in ("force", "ctrl"):
                least, most = (float(end) for end in getattr(model, f"actuator_{what}range")[index])
                if not getattr(model, f"actuator_{what}limited")[index] and least > most:
                    text = f"its {what}range {least:g} to {most:g} is upside down: to MuJoCo, none"
                    self._announce("limits", f"actuator {self._quoted('actuator', index)}", text)
        if lost := self.compiled.lost:
            text = (
                f"mesh files were not found: {listed(lost, 3)}; no mass depends on them, their "
                "shapes are left out; --package-dir DIR says where they are"
            )
            self._announce("meshes", "robot", text)

    def _quoted(self, kind: str, index: int) -> str:
        return f"'{self.compiled.name(kind, index)}'"

    def _tell_actuators(self, joints: set[int]) -> None:
        forces = self.forces
        for names, text in (
            (forces.left_out, "their force on the joints depends on the posture and is left out"),
            (forces.muscles, "muscles count with their pull at rest at their best length"),
            (forces.dc_motors, "DC motors count with their torque at rest, which falls with speed"),
            (forces.disabled, "<option actuatorgroupdisable> switches them off: not counted"),
        ):
            if names:
                self._announce("limits", "actuators", f"{text}: {', '.join(names)}")
        if self.compiled.off("ACTUATION"):
            text = (
                '<flag actuation="disable"> switches all motors off; a walk needs them: their '
                "ranges count all the same"
            )
            self._announce("limits", "actuators", text)
        if coupled := sorted(forces.coupled & joints):
            text = (
                "share motors through a tendon; each has the torque that it could have alone, "
                "though not all of them at once"
            )
            self._announce("limits", ", ".join(self.joint_names[j] for j in coupled), text)

    def _tell_rest(self, joints: list[int]) -> None:
        model = self.model
        for tendon in range(model.ntendon):
            if passive := self.passive.left_out(tendon):
                text = f"the {' and '.join(passive)} of this tendon is left out"
                self._announce("physics", f"tendon {self._quoted('tendon', tendon)}", text)
        flags = ("equality", "limit", "spring", "damper", "frictionloss")
        if off := [flag for flag in flags if self.compiled.off(flag.upper())]:
            text = f"<flag> in <option> switches off {', '.join(off)}: what the file has of it does"
            self._announce("physics", "robot", f"{text} not count")
        held = sum(float(part) for part in model.body_gravcomp)
        if held and any(model.jnt_actgravcomp[j] for j in joints):
            text = (
                "what joints with actuatorgravcomp move is not carried from outside: their motors "
                "bear that weight, and so does the ground here, though MuJoCo takes it off a root "
                "that floats"
            )
            self._announce("gravity compensation", "robot", text)
        if model.opt.density or model.opt.viscosity:
            self._announce("physics", "robot", "the drag of the medium in <option> is left out")
        if scene := self.compiled.scene:
            names = listed(scene, None)
            text = f"contact pairs with {names}, which the file does not hold, are left out"
            self._announce("contact", "robot", text, "found")
        for words in self.compiled.said:
            self._announce("mujoco", "file", f"MuJoCo warns: {words}")

    def _force_problems(self, joints: list[int]) -> list[FileProblem]:
        """Return the joints whose motors cannot hold zero force; tell of those with two ranges."""
        problems = []
        for joint in joints:
            least, most = self.forces.ranges.get(joint, FREE)
            name = self.joint_names[joint]
            slides = int(self.model.jnt_type[joint]) == self.bodies.slide
            unit = motion_words("N·m", slides=slides)
            given = f"its motors give from {least:g} to {most:g} {unit}"
            if not least < 0.0 < most:
                text = (
                    f"joint '{name}': {given}, which does not reach to both sides of 0; correct "
                    "the ranges and the gear of its actuators"
                )
                element = element_named(self.tree, "joint", name)
                problems.append(self._problem("torque", name, text, element))
            elif -least != most:
                text = f"{given}; a walk keeps the smaller of the two to both sides"
                self._announce("limits", name, text, "changed")
        return problems

    def _ties(self, joints: set[int]) -> tuple[tuple[Tie, ...], list[FileProblem]]:
        """Return which joints follow others, and all that ties joints as problems."""
        elements = [e for section in self.tree.root.findall("equality") for e in section]
        slides = {j for j in joints if int(self.model.jnt_type[j]) != self.bodies.hinge}
        hinges = [self.joint_names[j] for j in joints - slides]
        ties, told, others = dict[str, Tie](), dict[str, Equality](), []
        for equality in self.equalities:
            fault = ""
            if equality.pair is not None:
                joint, master = (self.joint_names[j] for j in equality.pair)
                fault = "a joint can follow one other only; remove that <joint>"
                if joint not in told:
                    ties[joint] = Tie.of(joint, master, equality.coefficients)
                    told[joint] = equality
                    continue
            others.append((equality, fault))
        for joint, equality in told.items():
            fault = fault_of_tie(ties[joint], hinges)
            if joint not in hinges:
                fault = "it slides or is a ball; remove that <joint>"
            if fault:
                others.append((equality, fault))
                del ties[joint]
        for joint, fault in ties_to_masters(ties)[1].items():
            others.append((told[joint], fault))
            del ties[joint]
        problems = []
        for joint, tie in ties.items():
            text = f"joint '{joint}': it follows '{tie.master}', by <joint> in <equality>"
            element = self._element(elements, told[joint])
            problems.append(self._problem("tied", joint, text, element))
        for equality, fault in others:
            why = f": {fault}"
            if equality.index in self.closed:
                why = ", a loop of bodies"
            elif not fault:
                why = (
                    ", which is not supported in a leg: every leg joint has its own motor; remove "
                    f"that <{equality.tag}>"
                )
            words = f"<{equality.tag}> of {equality.ends} in <equality> ties it{why}"
            kind = "mimic" if not equality.loop else "held"
            kind = "loop" if equality.index in self.closed else kind
            element = self._element(elements, equality)
            for name in sorted(self.joint_names[j] for j in equality.joints & joints):
                problems.append(self._problem(kind, name, f"joint '{name}': {words}", element))
        return tuple(ties.values()), problems

    def _loops(self, kept: list[int]) -> tuple[tuple[CompiledLoop, ...], frozenset[int]]:
        """Return the loops of bodies, and those of their joints that actuators turn."""
        loops, joints = [], set[int]()
        names = {str(self.model.site(s).name) for s in range(self.model.nsite)}
        for equality in self.equalities:
            if not equality.loop or any(body not in kept for body, *_ in equality.places):
                continue
            self.closed.add(equality.index)
            sites = []
            for end, (body, where, site) in enumerate(equality.places, 1):
                name = site or f"loop_{equality.index}_{end}"
                while not site and name in names:
                    name += "_"
                if not site:
                    self.ends.setdefault(body, []).append(CompiledSite(name, where))
                names.add(name)
                sites.append(name)
            loops.append(CompiledLoop(equality.tag, *sites))
            joints |= equality.joints
        return tuple(loops), self.forces.driven & joints

    def _element(self, elements: list[Element], equality: Equality) -> Element | None:
        return elements[equality.index] if len(elements) == self.model.neq else None

    def _problem(self, kind: str, name: str, text: str, element: Element | None) -> FileProblem:
        line = 0 if element is None else self.tree.line(element)
        return FileProblem(
            kind, name, text, line, "" if element is None else self.tree.file(element)
        )


def _names(kind: str, elements: Iterable[object]) -> list[str]:
    """Return names of elements of a model that all differ, made up where none is given."""
    given = [str(element.name) for element in elements]  # type: ignore[attr-defined]
    names, known = [], set(given)
    for index, name in enumerate(given):
        made = name or f"{kind}_{index}"
        while not name and made in known:
            made += "_"
        known.add(made)
        names.append(made)
    return names


def _with_some_drawn(bodies: tuple[CompiledBody, ...]) -> tuple[CompiledBody, ...]:
    """Draw everything where a file would show nothing at all."""
    if any(geom.drawn for body in bodies for geom in body.geoms):
        return bodies
    return tuple(
        replace(body, geoms=tuple(replace(g, drawn=g.rgba[3] > 0.0) for g in body.geoms))
        for body in bodies
    )
