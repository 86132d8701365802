"""What the robot is drawn with: the URDF's visual shapes, or a skeleton if it has none."""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.gait.result import Gait
from gaitopt.importers.meshes import MeshProblem
from gaitopt.nlp import Array
from gaitopt.view.body import gait_source, resting
from gaitopt.view.colours import STANCE, SWING, TRUNK
from gaitopt.view.drawable import drawable
from gaitopt.view.skeleton import sole_corners, stick_figures

_BONE = 0.025  # m: radius of the skeleton's limbs
_FOOT = 0.02  # m: thickness of its feet
_ENOUGH = 6  # moving bodies of the legs, of twelve, that must be drawn


@dataclass(frozen=True, eq=False)
class Shapes:
    """What a robot is drawn with.

    Attributes:
        geometry: the shapes.
        note: what is missing and how to get it, or empty.
    """

    geometry: pin.GeometryModel
    note: str = ""


def robot_shapes(gait: Gait, model: pin.Model, package_dirs: tuple[str, ...] = ()) -> Shapes:
    """Return the visual shapes of the gait's robot, a skeleton if those of a leg are missing.

    Args:
        gait: its URDF is drawn.
        model: from `walking_model`.
        package_dirs: where to look for meshes, before the directories that the gait records.

    Raises:
        RobotError: the URDF cannot be read.
    """
    source = gait_source(gait, package_dirs)
    lost = [p for p in source.mesh_problems() if p.kind == "visual"]
    note = _note(lost[0], len(lost)) if lost else ""
    try:
        found = source.geometry(pin.GeometryType.VISUAL)
    except RobotError as error:
        found, note = None, str(error)
    legs = [model.getJointId(name) for name in gait.joint_names]
    if found is not None and (not lost or _covers(found, legs)):
        return Shapes(drawable(found), note)
    return Shapes(_skeleton(gait, model), note and f"{note}. The robot is drawn as a skeleton")


def _note(lost: MeshProblem, count: int) -> str:
    others = f" and {count - 1} more are not drawn" if count > 1 else " is not drawn"
    return (
        f"the mesh '{lost.file}' {lost.reason}: it{others}; give the directory that holds its "
        "package (--package-dir)"
    )


def _covers(shapes: pin.GeometryModel, legs: list[int]) -> bool:
    """Whether thighs, shanks and feet are drawn: enough of a leg to see it walk."""
    drawn = {item.parentJoint for item in shapes.geometryObjects}
    return len(drawn.intersection(legs)) >= _ENOUGH


def _skeleton(gait: Gait, model: pin.Model) -> pin.GeometryModel:
    """Return capsules from joint to joint, plates for the feet and a bar for the trunk."""
    shapes = pin.GeometryModel()
    q = resting(gait, model)
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    sticks = stick_figures(gait, model, q[None])
    count = gait.leg_joints
    names = (gait.joint_names[:count], gait.joint_names[count : 2 * count][::-1])
    for leg, colour in ((0, STANCE), (1, SWING)):
        joints = [model.getJointId(n) for n in names[leg]]
        for lower, upper, joint in zip(
            sticks.legs[0, leg], sticks.legs[0, leg, 1:], joints[1:], strict=False
        ):
            _add_bar(shapes, data, joint, (lower, upper), colour)
        _add_foot(shapes, gait, model, leg, colour)
        heel = (sticks.legs[0, leg, 0], sticks.soles[0, leg].mean(axis=0))
        _add_bar(shapes, data, joints[0], heel, colour)
    _add_bar(shapes, data, 1, tuple(sticks.trunk[0]), TRUNK)
    _add_bar(shapes, data, 1, tuple(sticks.legs[0, :, -1]), TRUNK)
    return shapes


def _add_bar(
    shapes: pin.GeometryModel, data: pin.Data, joint: int, ends: tuple[Array, Array], colour: str
) -> None:
    """Add a capsule between two points of the world, fixed to a joint's link."""
    span = ends[1] - ends[0]
    length = float(np.linalg.norm(span))
    if length < 1e-6:
        return
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), span / length).matrix()
    placement = data.oMi[joint].inverse() * pin.SE3(turn, (ends[0] + ends[1]) / 2.0)
    _add(shapes, joint, coal.Capsule(_BONE, length), placement, colour)


def _add_foot(
    shapes: pin.GeometryModel, gait: Gait, model: pin.Model, leg: int, colour: str
) -> None:
    corners = sole_corners(gait, model) * (1.0, 1.0 - 2.0 * leg, 1.0)
    length, width = np.ptp(corners, axis=0)[:2]
    centre = np.array([*corners.mean(axis=0)[:2], _FOOT / 2.0])
    frame = model.frames[model.getFrameId((gait.stance_sole, gait.swing_sole_frame)[leg])]
    placement = frame.placement * pin.SE3(np.eye(3), centre)
    _add(shapes, frame.parentJoint, coal.Box(length, width, _FOOT), placement, colour)


def _add(
    shapes: pin.GeometryModel, joint: int, shape: object, placement: pin.SE3, colour: str
) -> None:
    item = pin.GeometryObject(f"bone_{shapes.ngeoms}", joint, placement, shape)
    item.meshColor = np.array([*(int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)), 1.0])
    shapes.addGeometryObject(item)
