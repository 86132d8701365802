"""The reference posture: how the robot stands with flat feet, and where its arms stay."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from os.path import isfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError, did_you_mean
from gaitopt.importers.physics import Tie
from gaitopt.importers.pinocchio_model import joint_coordinate, put_joint
from gaitopt.importers.report import Finding, How, listed
from gaitopt.importers.text_files import read_text
from gaitopt.model.import_options import UNUSED_SRDF, ImportOptions
from gaitopt.model.overrides import override
from gaitopt.nlp import Array
from gaitopt.units import read_number

Angles = dict[str, float]
KEYFRAME = "keyframe:"
"""Before the name of a posture that is meant as a keyframe of the robot's own file."""

_SHOWN = 20  # names

_NEAR = 0.1  # rad, m: poses are rounded, and a stop gives way; what is further out is a mistake
_ROUNDING = 1e-6  # rad, m: of the digits of a file
_TIED = 0.01  # rad, m: angles of a pose are rounded, those of joints that follow others too


def reference_angles(choices: ImportOptions, model: pin.Model, folder: Path) -> Angles:
    """Return the angles of the reference posture by joint [rad, m], others being 0.

    A pose of the SRDF may name joints that the robot does not have: one file often serves several
    variants. Groups of joints have poses of one name, which make one posture. A name without an
    SRDF, or after "keyframe:", is that of a keyframe of the robot.

    Raises:
        RobotError: the SRDF cannot be read or is given for nothing, there is no such pose, it has
            two angles of a joint, or one far beyond its range.
    """
    if choices.posture is None:
        if choices.srdf is not None and not choices.rotors:
            raise RobotError(UNUSED_SRDF)
        return {}
    angles = _asked(choices, model, folder)
    _check_angles(model, override(model, choices.limits)[0], angles)
    return angles


def _asked(choices: ImportOptions, model: pin.Model, folder: Path) -> Angles:
    name = choices.posture
    if not isinstance(name, str):
        return dict(name or ())
    keyframes = {entry.key(): entry.data() for entry in model.referenceConfigurations}
    if name.startswith(KEYFRAME):
        if choices.srdf is not None and not choices.rotors:
            raise RobotError(UNUSED_SRDF)
        frame = name.removeprefix(KEYFRAME)
        if frame not in keyframes:
            raise RobotError(f"the file has no keyframe '{frame}'; {_has(keyframes, frame)}")
        return _angles_of(model, keyframes[frame])
    if choices.srdf is None and name in keyframes:
        return _angles_of(model, keyframes[name])
    if choices.srdf is None:
        raise RobotError(
            f"the posture '{name}' is asked for by name, but no SRDF is given (--srdf FILE, or "
            f"srdf in the file for --choices and in Python), and {_has(keyframes)}"
        )
    states = list(read_srdf(choices, folder).iter("group_state"))
    poses = list(dict.fromkeys(state.get("name", "") for state in states))
    if name not in poses:
        more = f"; the robot's file has keyframes: {_names(keyframes)}" if keyframes else ""
        hint = did_you_mean(name, poses)
        raise RobotError(f"the SRDF has no pose '{name}'; {hint}it has: {_names(poses)}{more}")
    angles: Angles = {}
    for joint in (joint for s in states if s.get("name", "") == name for joint in s.iter("joint")):
        moved = joint.get("name", "")
        if model.existJointName(moved) and not _is_root(model, joint):
            _put(angles, moved, _value(joint, "value"), f"angles in the pose '{name}'")
    return angles


def _put(found: Angles, joint: str, value: float, what: str) -> None:
    if found.setdefault(joint, value) != value:
        raise RobotError(
            f"the SRDF gives joint '{joint}' two {what}, {found[joint]:g} and {value:g}; remove one"
        )


def _is_root(model: pin.Model, joint: ElementTree.Element) -> bool:
    """Whether a joint of a pose has several values, as that on which a robot floats."""
    several = model.joints[model.getJointId(joint.get("name", ""))].nv > 1
    return several and len(joint.get("value", "").split()) > 1


def _has(keyframes: Mapping[str, Array], wanted: str = "") -> str:
    if not keyframes:
        return "the robot's file has no keyframes"
    return f"{did_you_mean(wanted, keyframes)}it has: {_names(keyframes)}"


def _names(found: Iterable[str]) -> str:
    return listed(found, _SHOWN, quote="") or "none"


def _angles_of(model: pin.Model, q: Array) -> Angles:
    """Return the joint coordinates of a configuration that are not 0; balls keep their 0."""
    angles = {}
    for joint in range(2, model.njoints):
        at = model.joints[joint]
        if at.nv == 1 and (angle := joint_coordinate(at, q)) != 0.0:
            angles[str(model.names[joint])] = angle
    return angles


def posture_doubts(
    model: pin.Model, q: Array, moved: Sequence[Sequence[int]], choices: ImportOptions
) -> list[Finding]:
    """Return which joints stand outside their ranges in the reference posture (nq,) [rad]."""
    given = dict(choices.posture) if isinstance(choices.posture, tuple) else {}
    moving = {j for joints in moved for j in joints}
    findings = []
    for joint in range(2, model.njoints):
        at, name = model.joints[joint], str(model.names[joint])
        if at.nq != 1:
            continue
        angle, unit = float(q[at.idx_q]), _unit(model, joint)
        lower, upper = _range(model, joint)
        if not lower - _ROUNDING <= angle <= upper + _ROUNDING:
            text = (
                f"stands at {angle:.4g} {unit}, outside its range {lower:.4g} to {upper:.4g} {unit}"
            )
            if joint in moving and name not in given:
                text += "; the walk keeps the range, only feet and soles are looked at so"
            how: How = "warning" if name in given else "guessed"
            findings.append(Finding("posture", name, text, how))
    return findings


def rotor_armatures(choices: ImportOptions, folder: Path) -> Angles:
    """Return gear² times rotor inertia by joint [kg·m²] from the SRDF.

    Raises:
        RobotError: the SRDF cannot be read, has no rotors, or two of a joint that differ.
    """
    rotors = read_srdf(choices, folder).findall("rotor_params/joint")
    if not rotors:
        raise RobotError("the SRDF has no <rotor_params>; leave rotors out")
    found: Angles = {}
    for rotor in rotors:
        armature = _value(rotor, "gear_ratio") ** 2 * _value(rotor, "mass")
        _put(found, rotor.get("name", ""), armature, "armatures [kg·m²]")
    return found


def reference_configuration(model: pin.Model, angles: Angles) -> Array:
    """Return the configuration (nq,) of a model in the reference posture, its root at the origin.

    Raises:
        RobotError: a joint is unknown, or has more than one coordinate.
    """
    q = np.array(pin.neutral(model))
    for name, angle in angles.items():
        if not model.existJointName(name):
            hint = did_you_mean(name, map(str, model.names))
            raise RobotError(f"posture: the robot has no joint '{name}'{hint and f'; {hint[:-1]}'}")
        joint = model.joints[model.getJointId(name)]
        if joint.nv != 1:
            raise RobotError(f"posture: joint '{name}' has {joint.nv} angles; give single ones")
        put_joint(joint, q, angle)
    return q


def with_ties(
    model: pin.Model, q: Array, ties: Mapping[str, Tie], given: Collection[str]
) -> tuple[Array, dict[str, str]]:
    """Return a configuration (nq,) [rad] with the joints that follow others where those put them.

    Joints that are `given`, by a person or the file, stay where they are; which of them are where
    they cannot be comes second, by joint, in words.
    """
    found, apart = q.copy(), dict[str, str]()
    for name, tie in ties.items():
        joint = model.joints[model.getJointId(name)]
        leader = model.joints[model.getJointId(tie.master)]
        angle, where = joint_coordinate(joint, q), joint_coordinate(leader, q)
        follows = tie.at(where)
        if name in given and abs(angle - follows) > _TIED:
            apart[name] = (
                f"joint '{name}' is put at {angle:.4g} rad, but it follows '{tie.master}' at "
                f"{where:.4g} rad, which puts it at {follows:.4g} rad"
            )
        else:
            put_joint(joint, found, follows)
    return found, apart


def _check_angles(model: pin.Model, widened: pin.Model, angles: Angles) -> None:
    """Refuse angles beyond the range of the file and beyond that of the user."""
    for name, angle in angles.items():
        joint = model.getJointId(name) if model.existJointName(name) else 0
        if joint < 2 or model.joints[joint].nq != 1:
            continue
        ranges = _range(model, joint), _range(widened, joint)
        lower, upper = min(r[0] for r in ranges), max(r[1] for r in ranges)
        if lower - _NEAR <= angle <= upper + _NEAR:
            continue
        unit, turned = _unit(model, joint), float(np.radians(angle))
        degrees = unit == "rad" and abs(angle) > np.pi and lower <= turned <= upper
        hint = f"degrees? {angle:g} degrees are {turned:.4g} rad; " if degrees else ""
        raise RobotError(
            f"posture: joint '{name}' is at {angle:g} {unit}, but its range is {lower:.4g} to "
            f"{upper:.4g} {unit}; {hint}give an angle in its range, or a wider range ([[limits]])"
        )


def _range(model: pin.Model, joint: int) -> tuple[float, float]:
    """Range of a joint; a full turn either way (or any length) where the file gives a wide one."""
    at = model.joints[joint].idx_q
    lower, upper = model.lowerPositionLimit[at], model.upperPositionLimit[at]
    most = 2.0 * np.pi if _unit(model, joint) == "rad" else np.inf
    if not lower < upper:
        return -most, most
    if np.isinf(lower) and np.isinf(upper):
        return -np.inf, np.inf
    return max(float(lower), -most), min(float(upper), most)


def _unit(model: pin.Model, joint: int) -> str:
    return "m" if model.joints[joint].shortname().startswith("JointModelP") else "rad"


def read_srdf(choices: ImportOptions, folder: Path) -> ElementTree.Element:
    """Return the root of the SRDF that is given, a file or its text.

    Args:
        folder: of the robot's file, where the SRDF may lie too.

    Raises:
        RobotError: none is given, it cannot be read, or is no XML.
    """
    if choices.srdf is None:
        raise RobotError(
            "rotors are asked for, but no SRDF is given; give it: --srdf FILE, or srdf in the file "
            "for --choices and in Python"
        )
    text = choices.srdf
    if not text.lstrip().startswith("<"):
        path = next((p for p in (Path(text), folder / text) if isfile(p)), Path(text))
        text = read_text(path, "SRDF")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise RobotError(f"the SRDF is not well-formed XML: {error}") from None


def _value(element: ElementTree.Element, name: str) -> float:
    text = element.get(name, "")
    try:
        return read_number(text)
    except ValueError:
        owner = element.get("name")
        raise RobotError(
            f"the SRDF gives {name} of '{owner}' as '{text}'; it must be a number"
        ) from None
