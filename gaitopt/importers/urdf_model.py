"""The Pinocchio model of a URDF, made from its values without a loader between.

Pinocchio's own loader drops what it cannot parse (a mass with a blank behind it leaves a body
without mass) and looks for joints and links by name among names of its own ("universe",
"root_joint"). Here every value of the file goes into the model, or the file was refused.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import joint_model, sound_inertia
from gaitopt.importers.urdf_document import Description, Inertial, Joint, Link
from gaitopt.nlp import Array

WORLD, ROOT_JOINT = "universe", "root_joint"
"""Names of Pinocchio's own: the world, and the joint that carries the root link."""
_TAKEN_MARK = " (fixed)"  # marks a frame whose name is taken


def build_model(robot: Description) -> pin.Model:
    """Return the model of a robot; joint 1 is a free-flyer that carries the root link.

    Joints, frames and their order are those of Pinocchio's loader, save that a continuous joint is
    a revolute one without a range: its angle is wanted, not the cosine and sine of it. Limits that
    are not given are infinite; friction and damping are in the model too.

    Raises:
        RobotError: it has no link that can move.
    """
    model = pin.Model()
    model.name = robot.name
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), ROOT_JOINT)
    frame = model.addJointFrame(root, 0)
    below = robot.below
    waiting: list[tuple[Joint | None, str, int]] = [(None, robot.root, frame)]
    while waiting:
        joint, name, parent = waiting.pop()
        if joint is not None:
            parent = _add_joint(model, joint, parent)
        at = _add_link(model, robot.links[name], parent)
        waiting += [(child, child.child, at) for child in reversed(below[name])]
    if model.njoints < 2:
        raise RobotError("the robot has no links that can move; check the file")
    return model


def refuse_taken(robot: Description) -> None:
    """Refuse links and moving joints that bear a name of Pinocchio's own, which finds them by name.

    Raises:
        RobotError: naming the line.
    """
    moving = [joint.entry for joint in robot.joints.values() if joint.kind != "fixed"]
    links = [link.entry for link in robot.links.values() if link.name == WORLD]
    for entry in [*links, *(each for each in moving if each.name in (WORLD, ROOT_JOINT))]:
        raise entry.refusal("this name stands for something else in every robot; rename it")


def body(inertial: Inertial | None) -> pin.Inertia:
    """Return the inertia of a link in its own frame."""
    inertia = pin.Inertia.Zero()
    if inertial is not None:
        turn = inertial.pose.rotation
        # Set one by one: a body of an arm may be impossible, which its constructor refuses.
        inertia.mass = inertial.mass
        inertia.lever = inertial.pose.translation
        inertia.inertia = turn @ sound_inertia(inertial.mass, inertial.inertia) @ turn.T
    return inertia


def _add_link(model: pin.Model, link: Link, parent: int) -> int:
    """Add a link at a frame and return its own frame."""
    inertia, at = body(link.inertial), model.frames[parent]
    place = pin.SE3.Identity() if at.type == pin.FrameType.JOINT else at.placement
    frame = pin.Frame(link.name, at.parentJoint, parent, place, pin.FrameType.BODY, inertia)
    return int(model.addFrame(frame, True))


def _add_joint(model: pin.Model, joint: Joint, parent: int) -> int:
    """Add a joint below the frame of its parent link and return its own frame."""
    at = model.frames[parent]
    place = at.placement * joint.pose
    if joint.kind == "fixed":
        kind = pin.FrameType.FIXED_JOINT
        name = joint.name + (_TAKEN_MARK if joint.name in (WORLD, ROOT_JOINT) else "")
        frame = pin.Frame(name, at.parentJoint, parent, place, kind)
        return int(model.addFrame(frame, False))
    moving = _joint_model(joint)
    new = model.addJoint(at.parentJoint, moving, place, joint.name, *_bounds(joint, moving))
    return int(model.addJointFrame(new, parent))


def _joint_model(joint: Joint) -> pin.JointModel:
    if joint.kind == "floating":
        return pin.JointModelFreeFlyer()
    if joint.kind == "planar":
        return pin.JointModelPlanar()
    return joint_model(np.array(joint.axis), joint.kind == "prismatic")


def _bounds(joint: Joint, moving: pin.JointModel) -> tuple[Array, ...]:
    """Limits in the order of `pin.Model.addJoint`: effort, rate, range, friction, damping."""
    if joint.kind in ("floating", "planar"):
        return ()
    effort, velocity = (np.array([value]) for value in joint.strength)
    lower, upper = (np.array([value]) for value in joint.range)
    friction, damping = np.array([joint.friction]), np.array([joint.damping])
    return (-effort, effort, -velocity, velocity, lower, upper, -friction, friction, damping)
