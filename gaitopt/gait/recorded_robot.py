"""The robot of a gait, from what the gait records about it."""

from __future__ import annotations

from collections.abc import Mapping

from gaitopt.errors import GaitFileError, RobotError
from gaitopt.gait.ground import ground_of
from gaitopt.gait.result import Gait
from gaitopt.importers.physics import PARTS
from gaitopt.model.feet.sole import Sole
from gaitopt.model.import_options import ImportOptions, choices_from_record
from gaitopt.model.robot import Robot


def recorded_choices(gait: Gait) -> ImportOptions:
    """Return what was chosen about a gait's robot; nothing for a gait that does not record it.

    Raises:
        RobotError: the record cannot be read.
    """
    record = gait.fact("choices")
    return choices_from_record(record) if isinstance(record, Mapping) else ImportOptions()


def robot_of(gait: Gait) -> Robot:
    """Return the robot a gait was designed for, on the ground that it walks on.

    Raises:
        GaitFileError: neither the choices about it nor its sole are recorded.
        RobotError: the URDF is not a biped, or the choices do not fit it.
    """
    choices = gait.fact("choices")
    if isinstance(choices, Mapping):
        robot = Robot.from_urdf(gait.urdf, choices=_of_its_time(gait, choices_from_record(choices)))
        return robot.on_ground(ground_of(gait).down)
    edges = {name: gait.number("sole", name) for name in ("toe", "heel", "left", "right")}
    missing = [name for name, value in edges.items() if value is None]
    if missing:
        raise GaitFileError(
            f"the gait does not record the {missing[0]} edge of the sole in its 'meta'; "
            "was it designed by gaitopt?"
        )
    sole = Sole(**{name: value for name, value in edges.items() if value is not None})
    return Robot.from_urdf(
        gait.urdf, stance_sole=gait.stance_sole, swing_sole=gait.swing_sole_frame, sole=sole
    )


def _of_its_time(gait: Gait, choices: ImportOptions) -> ImportOptions:
    """Return the choices; a gait of version 0.1 counted nothing but rotor inertias."""
    if gait.fact("physics") is not None:
        return choices
    return choices.over(without=tuple(part for part in PARTS if part != "armature"))


def drawn_robot(gait: Gait) -> Robot:
    """Return the robot of a gait of format 1 or made by hand; what it does not record is found.

    Raises:
        RobotError: the URDF is not a biped, or not one with the gait's joints and sole frames.
    """
    try:
        robot = _robot_or_found(gait)
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error
    for name in set(gait.joint_names) - set(robot.joint_names):
        raise RobotError(f"the gait's URDF has no joint '{name}', which the gait moves")
    return robot


def _robot_or_found(gait: Gait) -> Robot:
    try:
        return robot_of(gait)
    except GaitFileError:
        return Robot.from_urdf(
            gait.urdf, stance_sole=gait.stance_sole, swing_sole=gait.swing_sole_frame
        )
