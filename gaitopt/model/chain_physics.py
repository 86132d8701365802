"""Passive joints, gravity and carried weight of a biped's chain, in the order of its joints.

And in sentences for a person: what of a description's physics counts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.physics import STANDARD_GRAVITY, PassiveJoint, Physics
from gaitopt.importers.report import Finding, How
from gaitopt.model.import_options import GRAVITY_WORDS, LEAST_GRAVITY, MOST_GRAVITY, ImportOptions
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.kinematic_tree import joint_slides
from gaitopt.model.symmetry import REFLECTION
from gaitopt.nlp import Array
from gaitopt.units import motion_words

_LEVEL = math.radians(0.5)
"""Angle from the robot's down up to which gravity is taken to point there [rad]: files round
orientations; at this angle a hundredth of the weight points along the ground."""

_SAME = 1e-12  # relative


@dataclass(frozen=True, eq=False)
class PassiveJoints:
    """What the n joints do by themselves; see `PassiveJoint`. Signs are the URDF's.

    Attributes:
        damping: torques per rate, |rate| rate, ..., shape (n, D) [N·m·s/rad, N·m·s²/rad², ...].
        friction: Coulomb friction, shape (n,) [N·m].
        stiffness: torques per angle, angle², ..., shape (n, S) [N·m/rad, N·m/rad², ...].
        rest: angles at which the springs give no torque, shape (n,) [rad].
    """

    damping: Array
    friction: Array
    stiffness: Array
    rest: Array


@dataclass(frozen=True, eq=False)
class CarriedWeight:
    """Point masses whose weight is carried from outside, summed over the links of each body.

    Attributes:
        mass: of each body, the stance foot first, shape (n + 1,) [kg].
        moment: mass times position in the frame of the body's joint, shape (n + 1, 3) [kg·m].
    """

    mass: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class ChainPhysics:
    """What acts on a chain beside its rigid bodies.

    Attributes:
        passive: of the joints; None where none does anything.
        carried: weight carried from outside; None where there is none.
        gravity: in the axes of the stance sole, shape (3,) [m/s²].
        gravity_stated: whether the description gives it.
        uneven: joints or links, with their partners, that were not mirror images: largest
            difference from the mean, by what it is a difference of and joint.
    """

    passive: PassiveJoints | None
    carried: CarriedWeight | None
    gravity: Array
    gravity_stated: bool
    uneven: Mapping[str, Mapping[str, float]]


def chain_physics(
    model: pin.Model,
    tree: JointTree,
    mirror: Array,
    pelvis: pin.SE3,
    rotation: Array,
    physics: Physics,
) -> ChainPhysics:
    """Return the physics of a chain, each joint and body given the mean of it and its partner.

    Args:
        mirror: the leg exchange E, shape (n, n).
        pelvis: placement of the pelvis frame at the neutral posture; its x-z plane is the mirror.

    Raises:
        RobotError: a number of it is not usable, or gravity is none or does not point down.
    """
    names = [str(name) for name in model.names[2:]]
    uneven: dict[str, dict[str, float]] = {}
    own = [physics.joints.get(name, PassiveJoint()) for name in names]
    for name, joint in zip(names, own, strict=True):
        _check_joint(name, joint)
    passive = _even_joints(own, names, mirror, uneven)
    carried = _even_weight(_carried(model, physics), model, tree, mirror, pelvis, uneven)
    gravity = np.array([0.0, 0.0, -fall(physics, rotation)])
    return ChainPhysics(passive, carried, gravity, physics.gravity is not None, uneven)


def fall(physics: Physics, rotation: Array) -> float:
    """Return the acceleration of free fall [m/s²] of a robot; `rotation` as of `Heading`.

    Raises:
        RobotError: there is none, or it does not point along the robot's down.
    """
    if physics.gravity is None:
        return STANDARD_GRAVITY
    size = float(np.linalg.norm(physics.gravity))
    told = ", ".join(f"{n:.6g}" for n in physics.gravity)
    remedy = (
        f"correct it, or leave it out: --without gravity (in Python and in the file for --choices "
        f'without = ["gravity"]) takes {STANDARD_GRAVITY:g} m/s² straight down'
    )
    if not LEAST_GRAVITY <= size <= MOST_GRAVITY:
        raise RobotError(f"gravity of the file is ({told}) m/s²; {GRAVITY_WORDS}; {remedy}")
    angle = gravity_tilt(physics, rotation)
    if angle > _LEVEL:
        raise RobotError(
            f"gravity of the file, ({told}) m/s² along the root link's axes, points "
            f"{math.degrees(angle):.3g} degrees away from the robot's down; the walk is on level "
            f"ground, allowed are {math.degrees(_LEVEL):g}; {remedy}"
        )
    return size


def gravity_tilt(physics: Physics, rotation: Array) -> float:
    """Return the angle of gravity from the robot's down [rad], 0 if none is given.

    The robot's axes are those of `Heading.rotation`.
    """
    if physics.gravity is None:
        return 0.0
    forward, left, up = rotation.T @ np.array(physics.gravity)
    return math.atan2(math.hypot(forward, left), -up)


def _check_joint(name: str, joint: PassiveJoint) -> None:
    """Refuse what no joint does."""
    numbers = {
        "damping": joint.damping,
        "friction": (joint.friction,),
        "springs": (*joint.stiffness, joint.rest),
    }
    for word, values in numbers.items():
        if not all(map(math.isfinite, values)):
            told = ", ".join(f"{v:g}" for v in values)
            raise RobotError(
                f"joint '{name}': its {word} ({told}) must be finite; correct the file, or leave "
                f"it out: --without {word}"
            )
    for word, least in (("damping", next(iter(joint.damping), 0.0)), ("friction", joint.friction)):
        if least < 0.0:
            raise RobotError(
                f"joint '{name}': its {word} is {least:g}, which would drive the joint; it must be "
                f"0 or more; correct the file, or leave it out: --without {word}"
            )


def _even_joints(
    joints: list[PassiveJoint], names: list[str], mirror: Array, uneven: dict[str, dict[str, float]]
) -> PassiveJoints | None:
    if all(joint.idle for joint in joints):
        return None
    damping, stiffness = (
        _padded([getattr(joint, name) for joint in joints]) for name in ("damping", "stiffness")
    )
    friction = np.array([joint.friction for joint in joints])
    rest = np.array([joint.rest for joint in joints])
    swap, strength = np.abs(mirror), np.abs(stiffness).sum(axis=1)
    # The torque of a mirrored joint is that at the mirrored angle, mirrored.
    signs = mirror.sum(axis=1)[:, None] ** np.arange(2, stiffness.shape[1] + 2)
    # The mean of two springs' torques is that of a spring that rests at the weighted mean.
    pull = strength * rest
    both = strength + swap @ strength
    mean_rest = np.divide(pull + mirror @ pull, both, out=np.zeros(len(both)), where=both > 0.0)
    even = PassiveJoints(
        damping=_mean(damping, swap @ damping, "damping", names, uneven),
        friction=_mean(friction, swap @ friction, "friction", names, uneven),
        stiffness=_mean(stiffness, signs * (swap @ stiffness), "stiffness", names, uneven),
        rest=mean_rest,
    )
    _note("rest", np.where(strength > 0.0, np.abs(rest - mean_rest), 0.0), 1.0, names, uneven)
    return even


def _padded(rows: list[tuple[float, ...]]) -> Array:
    width = max(1, *map(len, rows))
    return np.array([[*row, *[0.0] * (width - len(row))] for row in rows])


def _mean(
    own: Array, image: Array, word: str, names: list[str], uneven: dict[str, dict[str, float]]
) -> Array:
    mean = (own + image) / 2.0
    off = np.abs(own - mean).reshape(len(own), -1).max(axis=1)
    _note(word, off, float(np.abs(mean).max()), names, uneven)
    return mean


def _note(
    word: str, off: Array, size: float, names: list[str], uneven: dict[str, dict[str, float]]
) -> None:
    rows = np.flatnonzero(off > _SAME * size)
    if rows.size:
        uneven[word] = {names[k]: float(off[k]) for k in rows}


def _carried(model: pin.Model, physics: Physics) -> CarriedWeight | None:
    """Sum the point masses of the links that each body of the chain is made of."""
    mass, moment = np.zeros(model.njoints - 1), np.zeros((model.njoints - 1, 3))
    for link, point in physics.compensated.items():
        if not model.existFrame(link):
            raise RobotError(f"gravity compensation names a link '{link}' that the robot has not")
        if not all(map(math.isfinite, (point.mass, *point.centre))):
            raise RobotError(
                f"gravity compensation of '{link}' is not finite; correct the file, or leave it "
                "out: --without gravity-compensation"
            )
        frame = model.frames[model.getFrameId(link)]
        body = frame.parentJoint - 1
        mass[body] += point.mass
        moment[body] += point.mass * frame.placement.act(np.array(point.centre))
    return CarriedWeight(mass, moment) if mass.any() or moment.any() else None


def _even_weight(
    weight: CarriedWeight | None,
    model: pin.Model,
    tree: JointTree,
    mirror: Array,
    pelvis: pin.SE3,
    uneven: dict[str, dict[str, float]],
) -> CarriedWeight | None:
    """Return the mean of carried weight and its mirror image in the pelvis frame's x-z plane."""
    if weight is None:
        return None
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    seen = [pelvis.actInv(data.oMi[body + 1]) for body in range(tree.size + 1)]
    partners = [int(k) for k in np.abs(mirror).argmax(axis=1)]
    # The body that takes the place of each: in the chain from foot to foot, and beyond it.
    other = [tree.swing_foot - body for body in range(tree.swing_foot + 1)]
    other += [partners[body - 1] + 1 for body in range(tree.swing_foot + 1, tree.size + 1)]
    mass = (weight.mass + weight.mass[other]) / 2.0
    there = np.array(
        [
            place.rotation @ moment + m * place.translation
            for place, m, moment in zip(seen, weight.mass, weight.moment, strict=True)
        ]
    )
    mean = (there + there[other] @ REFLECTION) / 2.0
    moment = np.array(
        [
            place.rotation.T @ (total - m * place.translation)
            for place, m, total in zip(seen, mass, mean, strict=True)
        ]
    )
    off = np.maximum(np.abs(weight.mass - mass), np.abs(there - mean).max(axis=1))
    rows = np.delete(off, tree.pelvis)  # seen from the trunk, each joint moves one body
    _note("gravity compensation", rows, float(np.abs(mass).max()), list(tree.names), uneven)
    return CarriedWeight(mass, moment)


NO_ROTORS = (
    "the file gives the joints of the legs no rotor inertia. Motors behind gears have some "
    "(inertia of the rotor times the gear ratio squared), and where feet are light the walk "
    "depends on it: the optimum of Unitree's G1 at 0.6 m/s costs 1476 N²·m·s with none and 872 "
    "with 0.01 kg·m². Give it where you know it: --armature '*=0.01' (kg·m², by pattern of joint "
    "names)"
)
"""What is said of a file without rotor inertia; the figures are those of docs/physics.md."""

_LEFT = "left out: it counts at joints of the leg, not at cranks and rods of closed loops"
_UNITS = ("N·m·s/rad", "N·m·s²/rad²", "N·m·s³/rad³")
_SPRING_UNITS = ("N·m/rad", "N·m/rad²", "N·m/rad³")
_SERVO_DAMPING_SHARE = 0.15  # of a motor's torque at 1 rad/s: losses stay below a tenth
_SMALL_ASYMMETRY = 0.08  # relative: differences up to this are told, not warned of
_AVERAGED_UNITS = {
    "damping": "N·m·s/rad",
    "friction": "N·m",
    "stiffness": "N·m/rad",
    "rest": "rad",
    "gravity compensation": "kg or kg·m",
}


def physics_findings(
    described: Physics,
    counted: Physics,
    chain: ChainPhysics,
    joints: tuple[str, ...],
    rotation: np.ndarray,
    limits: np.ndarray,
    chosen: float | None = None,
) -> list[Finding]:
    """Return what of a description's physics counts, and what was left out or averaged.

    Args:
        limits: largest torques of the joints, shape (n,) [N·m].
        chosen: acceleration of free fall that the user gave [m/s²].
    """
    findings = _servos(chain, joints, limits)
    for topic, part, text in _PASSIVE:
        own = _by_text(joints, described.joints, text)
        left_out = bool(own) and not _by_text(joints, counted.joints, text)
        findings += [
            _counted(topic, _joints(n, len(joints)), t, part, left_out) for t, n in own.items()
        ]
    findings += _weight(described, counted)
    if chosen is None:
        findings += _gravity(described, counted, rotation)
    else:
        findings.append(
            Finding("gravity", "robot", f"{chosen:g} m/s² downward, as chosen", "given")
        )
    findings += [_averaged(word, off, chain) for word, off in chain.uneven.items()]
    return findings


def armature_findings(
    before: pin.Model,
    model: pin.Model,
    legs: Iterable[tuple[int, ...]],
    choices: ImportOptions,
    generated: bool,
) -> list[Finding]:
    """Return what of a description's rotor inertias (`before` choices) counts, or its want."""
    rows = [model.joints[j].idx_v for leg in legs for j in leg]
    names = [str(model.names[j]) for leg in legs for j in leg]
    left_out = "armature" in choices.without
    stated = {  # what the user replaced is told as such
        name: float(before.armature[row])
        for name, row in zip(names, rows, strict=True)
        if left_out or before.armature[row] == model.armature[row]
    }
    findings = []
    for text, subjects in _grouped({n: f"{v:.4g} kg·m²" for n, v in stated.items() if v}).items():
        subject = _joints(subjects, len(names))
        at_joint = f"rotor inertia at the joint {text}"
        findings.append(_counted("armature", subject, at_joint, "armature", left_out))
    chosen = any(entry.armature is not None for entry in choices.limits)
    if not any(model.armature[rows]) and not (left_out or chosen):
        if generated:
            text = "made without rotors; --armature PATTERN=VALUE gives it some"
            findings.append(Finding("armature", "robot", text))
        else:
            findings.append(Finding("armature", "robot", NO_ROTORS, "warning"))
    return findings


def loop_findings(model: pin.Model, names: Sequence[str], counted: Physics) -> list[Finding]:
    """Warn of friction, damping and springs of cranks and rods, which a walk leaves out."""
    findings = []
    for slides in (False, True):
        own = tuple(n for n in names if joint_slides(model.joints[model.getJointId(n)]) == slides)
        findings += [
            Finding(
                topic, ", ".join(at), f"{motion_words(told, slides=slides)}; {_LEFT}", "warning"
            )
            for topic, _, text in _PASSIVE
            for told, at in _by_text(own, counted.joints, text).items()
        ]
    return findings


def _servos(chain: ChainPhysics, joints: tuple[str, ...], limits: np.ndarray) -> list[Finding]:
    """Warn of damping so strong that it is rather the gain of a servo than a loss of the joint."""
    if chain.passive is None:
        return []
    torque = chain.passive.damping.sum(axis=1)  # at 1 rad/s
    strong = torque > _SERVO_DAMPING_SHARE * limits
    if not strong.any():
        return []
    worst = int(np.argmax(np.where(strong, torque / limits, 0.0)))
    text = (
        f"damping takes {torque[worst]:.4g} of the {limits[worst]:.4g} N·m of '{joints[worst]}' at "
        "1 rad/s, more than bearings and gears do; if it is the gain of a servo in a simulation, "
        "leave it out: --without damping"
    )
    names = [name for name, is_strong in zip(joints, strong, strict=True) if is_strong]
    return [Finding("damping", _joints(names, len(joints)), text, "warning")]


def _joints(names: Sequence[str], count: int) -> str:
    """Return joints in words; where it is all of them, their names would hide what is said."""
    return "all joints of the legs" if len(names) == count else ", ".join(names)


def _counted(topic: str, subject: str, text: str, part: str, left_out: bool) -> Finding:
    if left_out:
        return Finding(topic, subject, f"{text}; left out, as chosen (without)", "given")
    return Finding(topic, subject, f"{text}; counted (--without {part} leaves it out)")


def _by_text(
    names: tuple[str, ...], joints: Mapping[str, PassiveJoint], text: Callable[[PassiveJoint], str]
) -> dict[str, list[str]]:
    """Return the joints of which the same is to be said, by what that is."""
    return _grouped({name: text(joints[name]) for name in names if name in joints})


def _grouped(texts: Mapping[str, str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for name, text in texts.items():
        if text:
            found.setdefault(text, []).append(name)
    return found


def _damping(joint: PassiveJoint) -> str:
    return _terms("torque against the motion", joint.damping, _UNITS)


def _friction(joint: PassiveJoint) -> str:
    return f"Coulomb friction {joint.friction:.4g} N·m" if joint.friction else ""


def _spring(joint: PassiveJoint) -> str:
    told = _terms("spring", joint.stiffness, _SPRING_UNITS)
    return f"{told}, at rest at {joint.rest:.4g} rad" if told else ""


_PASSIVE = (
    ("damping", "damping", _damping),
    ("joint friction", "friction", _friction),
    ("springs", "springs", _spring),
)
"""Topic of findings, name among `PARTS` and words of what a joint does by itself."""


def _terms(word: str, values: tuple[float, ...], units: tuple[str, ...]) -> str:
    """Return the coefficients of an odd function of one variable, those that are 0 left out."""
    parts = [
        f"{value:.4g} {units[k] if k < len(units) else f'(power {k + 1})'}"
        for k, value in enumerate(values)
        if value
    ]
    return f"{word} {' and '.join(parts)}" if parts else ""


def _weight(described: Physics, counted: Physics) -> list[Finding]:
    mass = sum(point.mass for point in described.compensated.values())
    if not described.compensated:
        return []
    text = f"the weight of {mass:.4g} kg is carried from outside"
    subject = ", ".join(described.compensated)
    left_out = not counted.compensated
    finding = _counted("gravity compensation", subject, text, "gravity-compensation", left_out)
    if left_out:
        return [finding]
    text = f"{finding.text}; the ground and the motors do not feel it"
    return [Finding(finding.topic, subject, text, "warning")]


def _gravity(described: Physics, counted: Physics, rotation: np.ndarray) -> list[Finding]:
    if described.gravity is None:
        return []
    size = math.hypot(*described.gravity)
    if counted.gravity is None:
        text = f"{size:.4g} m/s² in the file; left out, as chosen: {STANDARD_GRAVITY:g} m/s²"
        return [Finding("gravity", "robot", text, "given")]
    text, angle = (
        f"{fall(counted, rotation):.6g} m/s² downward, as the file has it",
        gravity_tilt(counted, rotation),
    )
    if angle > 1e-6:
        text += f" but for {math.degrees(angle):.2g} degrees, which were straightened"
    odd = abs(size - STANDARD_GRAVITY) > 0.01 * STANDARD_GRAVITY
    return [Finding("gravity", "robot", text, "warning" if odd else "found")]


def _averaged(word: str, off: Mapping[str, float], chain: ChainPhysics) -> Finding:
    """Return how far left and right were apart."""
    apart, unit = 2.0 * max(off.values()), _AVERAGED_UNITS[word]
    size = math.inf
    if chain.passive is not None and word in ("damping", "friction", "stiffness"):
        size = float(np.abs(getattr(chain.passive, word)).max())
    elif chain.passive is not None and word == "rest":
        size = 1.0
    elif chain.carried is not None:
        size = float(np.abs(chain.carried.mass).max())
    topics = {"stiffness": "springs", "rest": "springs", "friction": "joint friction"}
    how: How = "changed" if apart <= _SMALL_ASYMMETRY * size else "warning"
    text = (
        f"{word} is not the mirror image of the other leg's: they differ by up to {apart:.3g} "
        f"{unit}, and both legs walk with the mean"
    )
    return Finding(topics.get(word, word), ", ".join(off), text, how)
