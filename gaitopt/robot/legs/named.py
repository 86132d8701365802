"""Feet that the user names: by a link, a joint or a frame."""

from __future__ import annotations

import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.robot.choices import SIDES, Choices

_HINTS = ("sole", "foot", "ankle")


def named_feet(model: pin.Model, choices: Choices) -> tuple[int, int] | None:
    """Return the joints that carry the two feet, if the user named both, in any order.

    Raises:
        RobotError: there is no such link, joint or frame, or both are on one foot.
    """
    names = choices.feet
    if choices.sole_placements is None:
        soles = choices.stance_sole, choices.swing_sole
        for name in soles:
            if name is not None:
                joint_of(model, name)
        if names is None and soles[0] is not None and soles[1] is not None:
            names = (soles[0], soles[1])
    if names is None:
        return None
    first, second = (joint_of(model, name) for name in names)
    if first == second or 0 in (first, second):
        raise RobotError(
            f"'{names[0]}' and '{names[1]}' are moved by the same joint; name two different feet"
        )
    return first, second


def joint_of(model: pin.Model, name: str) -> int:
    """Return the joint that moves a link, a joint's child or a frame.

    Raises:
        RobotError: nothing has that name.
    """
    if model.existJointName(name):
        return int(model.getJointId(name))
    for frame in model.frames:
        if frame.name == name:
            return int(frame.parentJoint)
    names = sorted({f.name for f in model.frames if any(h in f.name.lower() for h in _HINTS)})
    raise RobotError(
        f"the URDF has no frame named '{name}'; frames that look like feet: "
        f"{', '.join(names) or 'none'}. Name others, or leave them out to have them found"
    )


def standing_side(
    model: pin.Model, legs: tuple[tuple[int, ...], tuple[int, ...]], choices: Choices
) -> int:
    """Return which foot stands: 0 for the right one, 1 for the left one.

    Raises:
        RobotError: a sole frame is on neither foot, or the names contradict `stance`.
    """
    if choices.sole_placements is not None:
        return SIDES.index(choices.stance or SIDES[0])
    told = {} if choices.stance is None else {SIDES.index(choices.stance): "stance"}
    for name, turn in ((choices.stance_sole, 0), (choices.swing_sole, 1)):
        if name is None:
            continue
        joint = joint_of(model, name)
        sides = [side for side in (0, 1) if legs[side][-1] == joint]
        if not sides:
            raise RobotError(
                f"frame '{name}' is on neither foot; the feet are moved by "
                f"'{model.names[legs[0][-1]]}' (right) and '{model.names[legs[1][-1]]}' (left)"
            )
        told[sides[0] ^ turn] = f"'{name}'"
    if len(told) > 1:
        raise RobotError(
            f"{told[0]} makes the right foot stand, but {told[1]} the left one; "
            "stance_sole must be on the standing foot and swing_sole on the other"
        )
    return next(iter(told), 0)
