"""What counts of a description's physics, in sentences for a person."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
import pinocchio as pin

from gaitopt.importers.physics import STANDARD_GRAVITY, PassiveJoint, Physics
from gaitopt.importers.report import Finding, How
from gaitopt.model.chain_physics import ChainPhysics, fall, gravity_tilt
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.legs.kinematic_tree import joint_slides
from gaitopt.units import motion_words

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
        described: as the description has it.
        counted: what is left of it after the user's choice.
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
    """Return what of the description's rotor inertias counts, and warn where there are none.

    Args:
        before: as the description has it.
        model: after the user's choices.
        generated: whether gaitopt made the description, whose motors have no rotors on purpose.
    """
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
