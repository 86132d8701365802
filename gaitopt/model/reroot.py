"""Root a humanoid at its stance sole: the paper's serial chain from right foot to left foot.

Branches that are kept moving (waist, arms) hang on that chain: then it is a tree.

A pelvis-rooted model carries the ground reaction in its free-flyer only after solving for it.
Rooted at the sole, one recursive Newton-Euler call returns [R0; Gamma] of Eq. (1), and its
derivatives come with it. Every joint keeps the sign and the meaning it has in the URDF.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import joint_motions, reduced
from gaitopt.model.joint_tree import FIRST
from gaitopt.nlp import Array

FOOT_JOINT = "stance_foot"
PELVIS_FRAME = "pelvis"


def lock_upper_body(
    model: pin.Model,
    stance_sole: str,
    swing_sole: str,
    posture: np.ndarray | None = None,
    moving: Collection[str] = (),
) -> pin.Model:
    """Keep the free-flyer, the joints that move one sole but not the other, and `moving`.

    Args:
        posture: configuration (nq,) in which the other joints are locked; neutral by default.
        moving: names of further joints to keep (waist, arms, head).

    Raises:
        RobotError: a sole is no frame but a joint.
    """
    stance, swing = leg_joints(model, stance_sole, swing_sole)
    kept = stance | swing | {int(model.getJointId(name)) for name in moving}
    locked = [j for j in range(2, model.njoints) if j not in kept]
    q = pin.neutral(model) if posture is None else posture
    return reduced(model, locked, q)


def reroot(model: pin.Model, stance_sole: str, swing_sole: str) -> pin.Model:
    """Return the same robot as a tree rooted at the stance sole.

    Returns:
        A model whose joint 1 is a free-flyer at the stance sole (held still while the foot
        stands), followed by the stance leg from ankle to hip, the swing leg from hip to ankle and
        all other branches, each depth first (see `JointTree`).
    """
    rooted = pin.Model()
    rooted.name = model.name
    rooted.gravity = model.gravity
    foot = model.frames[model.getFrameId(stance_sole)]
    first = rooted.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), FOOT_JOINT)
    # Old joint, whose number is also that of its body -> new joint, old frame in new joint's frame.
    moved: dict[int, tuple[int, pin.SE3]] = {foot.parentJoint: (first, foot.placement.inverse())}
    axes = joint_axes(model)
    for joint, body, reverse in _outward(model, foot.parentJoint, _joint_of(model, swing_sole)):
        axis = axes[joint - FIRST]
        if reverse:
            parent, placement = moved[joint]
            new = _add_joint(rooted, parent, model, joint, placement, -axis)
            moved[body] = (new, model.jointPlacements[joint].inverse())
        else:
            parent, placement = moved[model.parents[joint]]
            placement = placement * model.jointPlacements[joint]
            new = _add_joint(rooted, parent, model, joint, placement, axis)
            moved[body] = (new, pin.SE3.Identity())
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


def leg_joints(model: pin.Model, stance_sole: str, swing_sole: str) -> tuple[set[int], set[int]]:
    """Return the joints that move one sole but not the other, of the stance and the swing leg."""
    stance, swing = (_supports(model, sole) for sole in (stance_sole, swing_sole))
    return stance - swing, swing - stance


def reversed_joints(model: pin.Model, stance_sole: str) -> set[str]:
    """Return the joints that `reroot` runs through against their direction, by name."""
    return {str(model.names[j]) for j in _supports(model, stance_sole)}


def _outward(model: pin.Model, foot: int, swing_foot: int) -> Iterator[tuple[int, int, bool]]:
    """Yield every joint on the way out from a foot, the way to the other foot first.

    Yields:
        The joint, the body beyond it, and whether it is passed against its direction.
    """
    ways: dict[int, list[tuple[int, int, bool]]] = {b: [] for b in range(1, model.njoints)}
    for joint in range(2, model.njoints):
        parent = int(model.parents[joint])
        ways[parent].append((joint, joint, False))
        ways[joint].append((joint, parent, True))
    first = set(model.supports[foot]) ^ set(model.supports[swing_foot])
    seen = {foot}
    stack = [iter(sorted(ways[foot], key=lambda way: way[0] not in first))]
    while stack:
        way = next((way for way in stack[-1] if way[1] not in seen), None)
        if way is None:
            stack.pop()
            continue
        seen.add(way[1])
        yield way
        stack.append(iter(sorted(ways[way[1]], key=lambda way: way[0] not in first)))


def joint_axes(model: pin.Model) -> Array:
    """Return the unit axes of all joints but the first, each in its own frame, shape (n, 3)."""
    return joint_motions(model)[:, 3:]


def _add_joint(
    rooted: pin.Model,
    parent: int,
    model: pin.Model,
    joint: int,
    placement: pin.SE3,
    axis: Array,
) -> int:
    new = rooted.addJoint(
        parent, pin.JointModelRevoluteUnaligned(axis), placement, model.names[joint]
    )
    old_v, new_v = model.joints[joint].idx_v, rooted.joints[new].idx_v
    old_q, new_q = model.joints[joint].idx_q, rooted.joints[new].idx_q
    for name in ("effortLimit", "velocityLimit", "armature"):
        getattr(rooted, name)[new_v] = getattr(model, name)[old_v]
    for name in ("lowerPositionLimit", "upperPositionLimit"):
        getattr(rooted, name)[new_q] = getattr(model, name)[old_q]
    return int(new)


def _supports(model: pin.Model, frame: str) -> set[int]:
    return {j for j in model.supports[_joint_of(model, frame)] if j > 1}


def _joint_of(model: pin.Model, frame: str) -> int:
    others = [f for f in model.frames if f.type != pin.FrameType.JOINT]  # joints have no place
    if not any(f.name == frame for f in others):
        names = sorted(f.name for f in others if "sole" in f.name or "foot" in f.name)
        raise RobotError(
            f"the URDF has no frame named '{frame}', a joint being none; those that look like "
            f"feet: {', '.join(names) or 'none'}. Name the sole frames, or add them to the URDF"
        )
    return int(model.frames[model.getFrameId(frame)].parentJoint)
