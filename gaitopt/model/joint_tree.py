"""The tree of a robot's joints, rooted at the stance sole: the paper's chain from foot to foot.

Branches that are kept moving (waist, arms) hang on that chain. A pelvis-rooted model carries the
ground reaction in its free-flyer only after solving for it. Rooted at the sole, one recursive
Newton-Euler call returns [R0; Gamma] of Eq. (1), and its derivatives come with it. Every joint
keeps the sign and the meaning it has in the URDF.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import cached_property

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, did_you_mean, there_are
from gaitopt.importers.pinocchio_model import joint_motions, reduced
from gaitopt.nlp import Array

TWIST = 6
"""Degrees of freedom of a rigid body."""

FIRST = 2
"""Pinocchio's index of joint 0: its joints 0 and 1 are the universe and the stance foot."""


@dataclass(frozen=True, eq=False)
class JointTree:
    """Which joint moves which body.

    Joint j carries body j + 1; body 0 is the stance foot, which does not move. The joints of the
    stance leg come first, from foot to pelvis, then those of the swing leg, from pelvis to foot,
    then all others (waist, arms, head), every branch depth first. A joint thus comes after the
    joints that move it.

    Attributes:
        names: of the n joints.
        parents: of each joint, the joint that carries the body it sits on; -1 for the stance foot.
        stance, swing: number of joints of the stance leg and of the swing leg.

    Raises:
        RobotError: the joints are not in that order.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    stance: int
    swing: int

    def __post_init__(self) -> None:
        feet = self.stance + self.swing
        serial = self.parents[:feet] == tuple(range(-1, feet - 1))
        if not (serial and all(-1 <= p < j for j, p in enumerate(self.parents))):
            raise RobotError(
                f"the joints {list(self.names)} are not in the order stance leg, swing leg, other "
                "branches; root the model at the stance sole first"
            )

    @property
    def size(self) -> int:
        """Number of joints n."""
        return len(self.names)

    @property
    def legs(self) -> slice:
        """Joints between the two feet."""
        return slice(self.stance + self.swing)

    @property
    def pelvis(self) -> int:
        """Body between the legs."""
        return self.stance

    @property
    def swing_foot(self) -> int:
        """Body at the end of the swing leg."""
        return self.stance + self.swing

    @property
    def serial(self) -> bool:
        """Whether it is one chain from foot to foot."""
        return self.size == self.swing_foot

    @property
    def determined(self) -> bool:
        """Whether the placements of pelvis and swing foot determine all joint angles."""
        return self.serial and self.stance == self.swing == TWIST

    @cached_property
    def moves(self) -> NDArray[np.bool_]:
        """Whether joint j moves the body that joint i carries, at [i, j], shape (n, n)."""
        mask = np.eye(self.size, dtype=np.bool_)
        for joint, parent in enumerate(self.parents):
            if parent >= 0:
                mask[joint] |= mask[parent]
        mask.setflags(write=False)
        return mask

    def path(self, body: int) -> NDArray[np.bool_]:
        """Return which joints are between the stance foot and a body, shape (n,)."""
        return np.zeros(self.size, np.bool_) if body == 0 else self.moves[body - 1]

    def up_to(self, per_joint: Array) -> Array:
        """Sum over the joints that move each body, shape (..., n, k) of the joints' (..., n, k)."""
        return self._inward[0] @ per_joint

    def beyond(self, per_body: Array) -> Array:
        """Sum over the bodies that each joint moves, shape (N, n, ...) of the bodies' (N, n, ...).

        The stance foot is not among them.
        """
        flat = per_body.reshape(*per_body.shape[:2], -1)
        return (self._inward[1] @ flat).reshape(per_body.shape)

    def sum_before(self, per_joint: Array) -> Array:
        """Sum over the joints that move each one, itself apart, shape (..., n) of (..., n)."""
        return (per_joint.reshape(-1, self.size) @ self._strictly).reshape(per_joint.shape)

    def sum_beyond(self, per_body: Array) -> Array:
        """Sum over the bodies that each joint moves, shape (..., n) of the bodies' (..., n)."""
        return (per_body.reshape(-1, self.size) @ self._inward[0]).reshape(per_body.shape)

    def joined(self, upper: Array, lower: Array) -> Array:
        """Return a table of pairs of joints (..., n, n) from closed forms for either order.

        At [i, j] it is `upper` where i is j or moves it, `lower` where j moves i, and zero for
        joints of different branches, which move no body in common.
        """
        found = np.where(self._above, upper, lower)
        if not self.serial:
            found *= self._related
        return found

    def symmetric(self, upper: Array) -> Array:
        """Return `joined` with its transpose: a symmetric table (..., n, n)."""
        return self.joined(upper, np.swapaxes(upper, -1, -2))

    def from_legs(self, of_legs: Array) -> Array:
        """Return a table (..., n) from one of the legs' joints (..., legs), zero for the others."""
        if self.serial:
            return of_legs
        table = np.zeros((*of_legs.shape[:-1], self.size))
        table[..., self.legs] = of_legs
        return table

    @cached_property
    def _inward(self) -> tuple[Array, Array]:
        """The mask as numbers, and its transpose."""
        numbers = self.moves.astype(np.float64)
        return numbers, numbers.T

    @cached_property
    def _strictly(self) -> Array:
        return self._inward[1] - np.eye(self.size)

    @cached_property
    def _above(self) -> NDArray[np.bool_]:
        return np.ascontiguousarray(self.moves.T)

    @cached_property
    def _related(self) -> Array:
        """1 at [i, j] where joint i moves joint j, is it, or is moved by it; else 0."""
        return np.maximum(*self._inward)


def joint_tree(model: pin.Model, pelvis: int, swing_foot: int) -> JointTree:
    """Return the tree of a model that is rooted at the stance sole.

    Raises:
        RobotError: see `JointTree`.
    """
    return JointTree(
        names=tuple(str(name) for name in model.names[FIRST:]),
        parents=tuple(int(parent) - FIRST for parent in model.parents[FIRST:]),
        stance=pelvis - FIRST + 1,
        swing=swing_foot - pelvis,
    )


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

    The others are locked in a posture (nq,), the neutral one by default.

    Raises:
        RobotError: a sole is no frame but a joint, or there is no joint of a name of `moving`.
    """
    stance, swing = (_supports(model, sole) for sole in (stance_sole, swing_sole))
    if unknown := [name for name in moving if not model.existJointName(name)]:
        raise RobotError(
            f"there is no joint '{unknown[0]}' to be kept moving; "
            f"{there_are(map(str, model.names[2:]), unknown[0])}"
        )
    kept = stance ^ swing | {int(model.getJointId(name)) for name in moving}
    locked = [j for j in range(2, model.njoints) if j not in kept]
    q = pin.neutral(model) if posture is None else posture
    return reduced(model, locked, q)


def reroot(model: pin.Model, stance_sole: str, swing_sole: str) -> pin.Model:
    """Return the same robot as a tree rooted at the stance sole.

    Joint 1 is a free-flyer at the stance sole (held still while the foot stands), followed by the
    stance leg from ankle to hip, the swing leg from hip to ankle and all other branches, each depth
    first (see `JointTree`).
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
            f"the URDF has no frame named '{frame}', a joint being none; "
            f"{did_you_mean(frame, (f.name for f in others))}those that look like feet: "
            f"{', '.join(names) or 'none'}. Name the sole frames, or add them to the URDF"
        )
    return int(model.frames[model.getFrameId(frame)].parentJoint)
