"""Passive joints, gravity and carried weight of a biped's chain, in the order of its joints."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.physics import STANDARD_GRAVITY, PassiveJoint, Physics
from gaitopt.model.import_options import GRAVITY_WORDS, LEAST_GRAVITY, MOST_GRAVITY
from gaitopt.model.joint_tree import JointTree
from gaitopt.model.symmetry import REFLECTION
from gaitopt.nlp import Array

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
        rotation: forward, left and up of the robot in its root link, columns, shape (3, 3).

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
    """Return the acceleration of free fall [m/s²] of a robot with axes `rotation`, shape (3, 3).

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
    """Return the angle of gravity from the robot's down (axes (3, 3)) [rad]; 0 for none."""
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
