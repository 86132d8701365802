"""The robot of a gait, for drawing: the whole body, its upper part in the locked posture."""

from __future__ import annotations

from collections.abc import Mapping

import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.gait.result import Gait
from gaitopt.importers.source import Source, read_source
from gaitopt.model.feet.sole_frames import placement_of
from gaitopt.model.import_options import ImportOptions, choices_from_record
from gaitopt.model.legs.heading import axis_vector
from gaitopt.model.legs.reference_posture import reference_configuration
from gaitopt.nlp import Array


def gait_choices(gait: Gait) -> ImportOptions:
    """Return what was chosen about the gait's robot; nothing for a gait that does not record it.

    Raises:
        RobotError: the record cannot be read.
    """
    record = gait.fact("choices")
    return choices_from_record(record) if isinstance(record, Mapping) else ImportOptions()


def gait_source(gait: Gait, package_dirs: tuple[str, ...] = ()) -> Source:
    """Return the description of the gait's robot.

    Args:
        gait: one step.
        package_dirs: where to look for meshes, before the directories that the gait records.

    Raises:
        RobotError: the URDF cannot be read.
    """
    directories = (*package_dirs, *gait_choices(gait).package_dirs)
    try:
        return read_source(gait.urdf, tuple(dict.fromkeys(directories)))
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error


def walking_model(gait: Gait) -> pin.Model:
    """Return the free-flyer model of a gait's robot; joints beyond the legs stay in the model.

    Raises:
        RobotError: the URDF cannot be read, or lacks a joint or sole frame the gait names.
    """
    model = gait_source(gait).model()
    for name in gait.joint_names:
        if not model.existJointName(name):
            raise RobotError(f"the gait's URDF has no joint '{name}', which the gait moves")
    _add_soles(gait, model)
    for name in (gait.stance_sole, gait.swing_sole_frame):
        if not model.existFrame(name):
            raise RobotError(f"the gait's URDF has no sole frame '{name}'; add a link of that name")
    return model


def joint_indices(gait: Gait, model: pin.Model) -> list[int]:
    """Return the place of each of the gait's joints in a configuration of the model."""
    return [model.joints[model.getJointId(name)].idx_q for name in gait.joint_names]


def resting(gait: Gait, model: pin.Model) -> Array:
    """Return the reference posture with the root at the origin, shape (nq,).

    The joints that are not the legs' stay in it while the robot walks.

    Raises:
        RobotError: the gait records a posture of joints that the robot does not have.
    """
    posture = gait_choices(gait).posture or ()
    # a gait records angles, never the name of a pose
    return reference_configuration(model, dict(posture))  # type: ignore[arg-type]


def upward(gait: Gait) -> Array:
    """Return the upward axis in the root link, shape (3,)."""
    up = gait_choices(gait).up
    return axis_vector("z" if up is None else up)


def _add_soles(gait: Gait, model: pin.Model) -> None:
    """Add the sole frames that the URDF lacks, each to the last joint of its leg."""
    placements = gait_choices(gait).sole_placements
    if placements is None:
        return
    left_stands = gait_choices(gait).stance == "left"
    soles = [(gait.stance_sole, gait.joint_names[0]), (gait.swing_sole_frame, gait.joint_names[-1])]
    for (sole, joint), numbers in zip(soles, placements[:: -1 if left_stands else 1], strict=True):
        if model.existFrame(sole):
            continue
        place, kind = placement_of(numbers), pin.FrameType.OP_FRAME
        frame = pin.Frame(sole, model.getJointId(joint), place, kind)
        model.addFrame(frame, False)
