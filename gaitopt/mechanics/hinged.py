"""A robot on hinges: the stance foot turns about a line of its sole that rests on the ground.

A hinge is one more joint, between the ground and the stance foot. The model is then rooted at the
footprint, the place of the sole where it stood flat, a body without mass; the stance foot is the
first body that moves. Inverse dynamics, placements and all their derivatives need nothing new, and
the torque of the hinge is the moment of the ground about the line.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from gaitopt.contact import ContactMode
from gaitopt.model.chain_physics import CarriedWeight, ChainPhysics, PassiveJoints
from gaitopt.model.joint_tree import FIRST, joint_axes
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

HINGE = "stance foot on the ground"
"""Name of the joint, with that of its contact."""

FOOTPRINT = "footprint"
"""Name of the frame where the stance sole stood flat."""


_KEPT = 8  # hinged robots, one for each robot and contact


def standing_robot(robot: Robot, *contacts: ContactMode) -> Robot:
    """Return a robot whose joints are the hinges of contacts, then its own; itself without any.

    Of several hinges, one after the other from the ground, one at most is not at 0: a foot turns
    about one line at a time, and the others do nothing.
    What is measured of the legs (limits, mirror, geometry) is still that of the robot's own joints.

    Args:
        robot: rooted at its stance sole.
        contacts: of its stance foot; those without a hinge add none.
    """
    for contact in reversed(contacts):  # each comes between the ground and those before
        if contact.hinge(robot.sole) is not None:
            robot = _hinged(robot, contact)
    return robot


@lru_cache(maxsize=_KEPT)
def _hinged(robot: Robot, contact: ContactMode) -> Robot:
    """Return a robot with one more hinge under its first body."""
    hinge, model = contact.hinge(robot.sole), robot.model
    assert hinge is not None
    name = f"{HINGE}, {contact.name}"
    line = pin.SE3(np.eye(3), hinge.point)
    rooted = pin.Model()
    rooted.name, rooted.gravity = model.name, model.gravity
    base = rooted.addJoint(0, pin.JointModelFreeFlyer(), model.jointPlacements[1], model.names[1])
    foot = rooted.addJoint(base, pin.JointModelRevoluteUnaligned(hinge.axis), line, name)
    new = {0: 0, 1: foot}
    for joint, axis in enumerate(joint_axes(model), FIRST):
        place = model.jointPlacements[joint]
        if model.parents[joint] == 1:
            place = line.inverse() * place
        new[joint] = rooted.addJoint(
            new[int(model.parents[joint])],
            pin.JointModelRevoluteUnaligned(axis),
            place,
            model.names[joint],
        )
    for joint in range(1, model.njoints):
        moved = line.inverse() if joint == 1 else pin.SE3.Identity()
        rooted.appendBodyToJoint(new[joint], model.inertias[joint], moved)
    armature = np.array(rooted.armature)
    armature[-robot.tree.size :] = np.array(model.armature)[-robot.tree.size :]
    rooted.armature = armature
    for frame in model.frames:
        if frame.type == pin.FrameType.OP_FRAME and frame.name != FOOTPRINT:
            joint = int(frame.parentJoint)
            place = line.inverse() * frame.placement if joint == 1 else frame.placement
            rooted.addFrame(pin.Frame(frame.name, new[joint], place, frame.type), False)
    footprint = pin.Frame(FOOTPRINT, base, pin.SE3.Identity(), pin.FrameType.OP_FRAME)
    rooted.addFrame(footprint, False)
    return replace(
        robot,
        model=rooted,
        joint_names=(name, *robot.joint_names),
        coupling=robot.coupling.led(name),
        stance_sole=FOOTPRINT,
        physics=_physics(robot.physics, line),
    )


def _physics(physics: ChainPhysics, line: pin.SE3) -> ChainPhysics:
    """The hinge does nothing by itself; the footprint has no weight to carry."""
    passive, carried = physics.passive, physics.carried
    if passive is not None:
        passive = PassiveJoints(
            *(_led(values) for values in (passive.damping, passive.friction)),
            *(_led(values) for values in (passive.stiffness, passive.rest)),
        )
    if carried is not None:
        moment = carried.moment.copy()
        of_foot = moment[0] - carried.mass[0] * line.translation  # about a point of the line
        moment[0] = line.rotation.T @ of_foot
        carried = CarriedWeight(_led(carried.mass), _led(moment))
    return replace(physics, passive=passive, carried=carried)


def _led(values: Array) -> Array:
    """A table by joint or body with zeros in front for the hinge or the footprint."""
    return np.concatenate([np.zeros((1, *values.shape[1:])), values])
