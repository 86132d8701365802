"""Root a humanoid at its stance sole: the paper's serial chain from right foot to left foot.

A pelvis-rooted model carries the ground reaction in its free-flyer only after solving for it.
Rooted at the sole, one recursive Newton-Euler call returns [R0; Gamma] of Eq. (1), and its
derivatives come with it. Every joint keeps the sign and the meaning it has in the URDF.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.frame_names import reduced

FOOT_JOINT = "stance_foot"
PELVIS_FRAME = "pelvis"


def lock_upper_body(
    model: pin.Model, stance_sole: str, swing_sole: str, posture: np.ndarray | None = None
) -> pin.Model:
    """Keep the free-flyer and the joints that move one sole but not the other; lock the rest.

    Args:
        model: pelvis-rooted model with a free-flyer.
        stance_sole: name of the sole frame of the standing foot.
        swing_sole: name of the sole frame of the other foot.
        posture: configuration (nq,) in which the other joints are locked; neutral by default.

    Raises:
        RobotError: a leg does not have six revolute joints.
    """
    stance, swing = (_supports(model, sole) for sole in (stance_sole, swing_sole))
    legs = stance ^ swing
    for sole, count in ((stance_sole, len(stance - swing)), (swing_sole, len(swing - stance))):
        if count != 6:
            raise RobotError(
                f"the leg that ends in frame '{sole}' has {count} joints of its own; "
                "gaitopt needs two legs of six revolute joints each"
            )
    for joint in legs:
        if model.joints[joint].nv != 1:
            raise RobotError(
                f"joint '{model.names[joint]}' has {model.joints[joint].nv} degrees of freedom; "
                "every leg joint must be revolute"
            )
    locked = [j for j in range(2, model.njoints) if j not in legs]
    q = pin.neutral(model) if posture is None else posture
    return reduced(model, locked, q)


def reroot(model: pin.Model, stance_sole: str, swing_sole: str) -> pin.Model:
    """Return the same robot as a chain rooted at the stance sole.

    Args:
        model: free-flyer and twelve leg joints, rooted at the pelvis (see `lock_upper_body`).
        stance_sole, swing_sole: names of the sole frames.

    Returns:
        A model whose joint 1 is a free-flyer at the stance sole (held still while the foot
        stands), followed by the stance leg from ankle to hip and the swing leg from hip to ankle.
    """
    up = _path(model, stance_sole)
    down = _path(model, swing_sole)
    rooted = pin.Model()
    rooted.name = model.name
    rooted.gravity = model.gravity
    moved: dict[int, tuple[int, pin.SE3]] = {}  # old joint -> new joint, old frame in new frame

    sole = model.frames[model.getFrameId(stance_sole)].placement
    parent = rooted.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), FOOT_JOINT)
    moved[up[-1]] = (parent, sole.inverse())
    for child, body in zip(reversed(up), [*reversed(up[:-1]), 1], strict=True):
        parent = _add_joint(rooted, parent, model, child, moved[child][1], reverse=True)
        moved[body] = (parent, model.jointPlacements[child].inverse())
    for child in down:
        placement = moved[model.parents[child]][1] * model.jointPlacements[child]
        parent = _add_joint(rooted, parent, model, child, placement, reverse=False)
        moved[child] = (parent, pin.SE3.Identity())
    for old, (new, placement) in moved.items():
        rooted.appendBodyToJoint(new, model.inertias[old], placement)
    for frame in model.frames:
        # Links and joints may share a name; one frame of that name is enough here.
        known = rooted.existFrame(frame.name)
        if frame.parentJoint in moved and frame.type != pin.FrameType.JOINT and not known:
            new, placement = moved[frame.parentJoint]
            rooted.addFrame(
                pin.Frame(frame.name, new, placement * frame.placement, pin.FrameType.OP_FRAME),
                False,
            )
    return rooted


def joint_axis(model: pin.Model, joint: int) -> np.ndarray:
    """Return the unit axis of a revolute joint in its own frame, shape (3,)."""
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    column = model.joints[joint].idx_v
    axis = pin.getJointJacobian(model, data, joint, pin.LOCAL)[:, column]
    if abs(np.linalg.norm(axis[3:]) - 1.0) > 1e-9 or np.abs(axis[:3]).max() > 1e-12:
        raise RobotError(
            f"joint '{model.names[joint]}' is not revolute; every leg joint must be revolute"
        )
    return np.asarray(axis[3:]).copy()


def _add_joint(
    rooted: pin.Model,
    parent: int,
    model: pin.Model,
    joint: int,
    placement: pin.SE3,
    *,
    reverse: bool,
) -> int:
    axis = joint_axis(model, joint)
    new = rooted.addJoint(
        parent,
        pin.JointModelRevoluteUnaligned(-axis if reverse else axis),
        placement,
        model.names[joint],
    )
    old_v, new_v = model.joints[joint].idx_v, rooted.joints[new].idx_v
    old_q, new_q = model.joints[joint].idx_q, rooted.joints[new].idx_q
    for name in ("effortLimit", "velocityLimit", "armature"):
        _copy_entry(rooted, model, name, new_v, old_v)
    for name in ("lowerPositionLimit", "upperPositionLimit"):
        _copy_entry(rooted, model, name, new_q, old_q)
    return int(new)


def _copy_entry(target: pin.Model, source: pin.Model, name: str, to: int, from_: int) -> None:
    values = np.array(getattr(target, name))
    values[to] = getattr(source, name)[from_]
    setattr(target, name, values)


def _supports(model: pin.Model, frame: str) -> set[int]:
    return {j for j in model.supports[_joint_of(model, frame)] if j > 1}


def _path(model: pin.Model, frame: str) -> list[int]:
    """Joints from the pelvis out to the sole."""
    return [j for j in model.supports[_joint_of(model, frame)] if j > 1]


def _joint_of(model: pin.Model, frame: str) -> int:
    if not model.existFrame(frame):
        names = sorted(f.name for f in model.frames if "sole" in f.name or "foot" in f.name)
        raise RobotError(
            f"the URDF has no frame named '{frame}'; frames that look like feet: "
            f"{', '.join(names) or 'none'}. Name the sole frames, or add them to the URDF"
        )
    return int(model.frames[model.getFrameId(frame)].parentJoint)
