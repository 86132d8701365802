"""The reference posture: how the robot stands with flat feet, and where its arms stay."""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.choices import UNUSED_SRDF, Choices
from gaitopt.robot.files.text_file import read_text

Angles = dict[str, float]


def reference_angles(choices: Choices, model: pin.Model, folder: Path) -> Angles:
    """Return the angles of the reference posture by joint [rad, m], others being 0.

    Args:
        choices: names the pose, or gives the angles. A pose of the SRDF may name joints that the
            robot does not have: one file often serves several variants.
        model: of the robot.
        folder: of the URDF, where the SRDF is looked up too.

    Raises:
        RobotError: the SRDF cannot be read, has no such pose, or is given for nothing.
    """
    if choices.posture is None:
        if choices.srdf is not None and not choices.rotors:
            raise RobotError(UNUSED_SRDF)
        return {}
    if not isinstance(choices.posture, str):
        return dict(choices.posture)
    poses = {s.get("name", ""): s for s in _srdf(choices, folder).iter("group_state")}
    if choices.posture not in poses:
        raise RobotError(
            f"the SRDF has no pose '{choices.posture}'; it has: {', '.join(poses) or 'none'}"
        )
    return {
        joint.get("name", ""): _value(joint, "value")
        for joint in poses[choices.posture].iter("joint")
        if model.existJointName(joint.get("name", "")) and len(joint.get("value", "").split()) == 1
    }


def rotor_armatures(choices: Choices, folder: Path) -> Angles:
    """Return gear² times rotor inertia by joint [kg·m²] from the SRDF.

    Raises:
        RobotError: the SRDF cannot be read or has no rotors.
    """
    rotors = _srdf(choices, folder).findall("rotor_params/joint")
    if not rotors:
        raise RobotError("the SRDF has no <rotor_params>; leave rotors out")
    return {r.get("name", ""): _value(r, "gear_ratio") ** 2 * _value(r, "mass") for r in rotors}


def reference_configuration(model: pin.Model, angles: Angles) -> Array:
    """Return the configuration of a model in the reference posture, its root at the origin.

    Raises:
        RobotError: a joint is unknown, or has more than one coordinate.
    """
    q = np.array(pin.neutral(model))
    for name, angle in angles.items():
        if not model.existJointName(name):
            close = get_close_matches(name, list(model.names), n=1)
            hint = f"; did you mean '{close[0]}'?" if close else ""
            raise RobotError(f"posture: the robot has no joint '{name}'{hint}")
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 1:
            q[joint.idx_q] = angle
        elif joint.nq == 2 and joint.nv == 1:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        else:
            raise RobotError(f"posture: joint '{name}' has {joint.nv} angles; give single ones")
    return q


def _srdf(choices: Choices, folder: Path) -> ElementTree.Element:
    if choices.srdf is None:
        raise RobotError(
            "a pose or rotors are asked for by name, but no SRDF is given; give it: --srdf FILE, "
            "or srdf in the file for --choices and in Python"
        )
    text = choices.srdf
    if not text.lstrip().startswith("<"):
        path = next((p for p in (Path(text), folder / text) if p.is_file()), Path(text))
        text = read_text(path, "SRDF")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise RobotError(f"the SRDF is not well-formed XML: {error}") from None


def _value(element: ElementTree.Element, name: str) -> float:
    text = element.get(name, "")
    try:
        return float(text)
    except ValueError:
        owner = element.get("name")
        raise RobotError(
            f"the SRDF gives {name} of '{owner}' as '{text}'; it must be a number"
        ) from None
