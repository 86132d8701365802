"""The joints of a robot as a tree: chains, joint lines, placements in one posture.

A revolute joint is a line. Where on it a file puts the origin of the joint is arbitrary, so that
nothing found about a robot depends on it (`points_on_lines`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.importers.xml_document import FileProblem
from gaitopt.nlp import Array

UNMOVED = ("mimic", "free")
"""Problems of joints that no motor turns."""

LIGHT = 2e-4
"""Of the robot's mass: a branch that carries less is no limb."""

_BODY = pin.FrameType.BODY
_REVOLUTE = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")


@dataclass(frozen=True)
class Tree:
    """A model at its reference posture.

    Attributes:
        model: free-flyer and joints.
        places: points of its joints in the root link [m], shape (njoints, 3); see `joint_points`.
        axes: of its joints there, 0 for those that do not revolve, shape (njoints, 3).
        problems: that were found in its file.
        q: the reference posture, shape (nq,); None for the neutral one.
    """

    model: pin.Model
    places: Array
    axes: Array
    problems: tuple[FileProblem, ...] = ()
    q: Array | None = None

    @cached_property
    def leaves(self) -> list[int]:
        """Joints that carry no other joint, branches without mass left out.

        Such branches stand for rods of a linkage, cables or frames. What carries next to nothing
        is none of a robot's limbs.
        """
        bodies = [float(body.mass) for body in self.model.inertias]
        below = bodies.copy()
        for joint in reversed(range(2, self.model.njoints)):
            below[self.model.parents[joint]] += below[joint]
        least, found = LIGHT * sum(bodies), []
        light = set()
        for joint in range(2, self.model.njoints):
            parent = int(self.model.parents[joint])
            forks = parent < 2 or len(self.model.children[parent]) > 1
            if parent in light or (forks and below[joint] < least):
                light.add(joint)
        for joint in range(2, self.model.njoints):
            if joint not in light and all(int(c) in light for c in self.model.children[joint]):
                found.append(joint)
        return found

    def problem(self, joint: int, kinds: Collection[str]) -> FileProblem | None:
        """Return the first problem of a joint that is of one of some kinds."""
        name = self.model.names[joint]
        fits = (p for p in self.problems if p.name == name and p.kind in kinds)
        return next(fits, None)

    def angle(self, joint: int) -> float:
        """Return the angle of a revolute joint in the reference posture [rad]."""
        return 0.0 if self.q is None else float(self.q[self.model.joints[joint].idx_q])


def own_joints(model: pin.Model, end: int, other: int) -> list[int]:
    """Return the joints between the root and a foot that do not carry the other foot too."""
    shared = set(model.supports[other])
    return [j for j in model.supports[end] if j > 1 and j not in shared]


def branches(model: pin.Model, ends: Collection[int]) -> list[list[int]]:
    """Return the chains to some joints from where they part, one for each first joint."""
    shared = set.intersection(*(set(model.supports[j]) for j in ends))
    chains = [[j for j in model.supports[end] if j not in shared] for end in ends]
    return list({chain[0]: chain for chain in chains if chain}.values())


def joint_kind(joint: pin.JointModel) -> str:
    """Return "revolute", or what a joint is instead, in words."""
    name = joint.shortname()
    if name in _REVOLUTE:
        return "revolute"
    if name.startswith("JointModelRUB") or "Unbounded" in name:
        return "continuous (without a range); give it the type revolute and a limit"
    if name.startswith("JointModelP") and joint.nv == 1:
        return "prismatic"
    return f"one with {joint.nv} degrees of freedom"


def all_revolute(model: pin.Model, joints: Collection[int]) -> bool:
    """Tell whether all joints are revolute and have a range."""
    return all(joint_kind(model.joints[j]) == "revolute" for j in joints)


def foot_name(model: pin.Model, joint: int) -> str:
    """Return the name of the link that a joint moves, of its sole if it is named so."""
    links = [f.name for f in model.frames if f.parentJoint == joint and f.type == _BODY]
    soles = [name for name in links if "sole" in name.lower()]
    return str([*soles, *links, model.names[joint]][0])


def unit(vector: Array) -> Array:
    """Return a vector at length 1, or as it is if it has no length."""
    return np.asarray(vector / (float(np.linalg.norm(vector)) or 1.0))


# Sine of the angle between two lines from which on they tell where on each other they meet; they
# have no say below the first, and their full one from the second on. In between it grows smoothly,
# so that the two legs of a robot that are nearly alike have points that are nearly alike.
_ASKEW = (0.3, 0.6)
_FAINT = 1e-6  # weight of the joint before, which decides where no line does


def joint_lines_of(model: pin.Model, q: Array) -> tuple[Array, Array]:
    """Return a point and the direction of the line of each joint.

    Args:
        model: free-flyer and joints.
        q: its configuration, shape (nq,).

    Returns:
        Points in the world [m], shape (njoints, 3), as `points_on_lines` chooses them, or the
        origins of joints that do not revolve; and unit axes, 0 for those, shape (njoints, 3).
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    origins = np.array([placement.translation for placement in data.oMi])
    axes = np.zeros((model.njoints, 3))
    for joint in range(2, model.njoints):
        at = model.joints[joint]
        if at.nv == 1:
            J = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            axes[joint] = J[3:, at.idx_v]
    return points_on_lines(origins, axes, [int(p) for p in model.parents]), axes


def points_on_lines(points: Array, axes: Array, parents: Sequence[int]) -> Array:
    """Return the point of each line of a tree that is nearest to the line of its parent.

    As far as the two are parallel, the lines of its children decide, and where those are too, the
    point of the parent.

    Args:
        points: any point of each line [m], shape (n, 3).
        axes: unit vectors along the lines, 0 for what is a point and no line, shape (n, 3).
        parents: row of the parent of each, which comes before it; its own for none.
    """
    found = np.array(points)
    for row in map(int, np.flatnonzero(axes.any(axis=1))):
        parent = parents[row]
        children = [k for k in range(len(points)) if parents[k] == row != k]
        weight, along = _FAINT, _FAINT * float((found[parent] - points[row]) @ axes[row])
        if parent == row:
            along = 0.0
        left = 1.0
        for beside in ([parent], children):
            sides = [_meeting(points, axes, row, k) for k in beside]
            say = max((s for s, _ in sides), default=0.0)
            for share, place in sides:
                part = left * share / max(len(beside), 1)
                weight, along = weight + part, along + part * place
            left *= 1.0 - say
        found[row] = points[row] + along / weight * axes[row]
    return found


def _meeting(points: Array, axes: Array, row: int, other: int) -> tuple[float, float]:
    """Return how clearly another line tells a place on a line, and which, from its point [m]."""
    cosine = float(axes[row] @ axes[other])
    sine = float(np.linalg.norm(np.cross(axes[row], axes[other])))
    share = _share(sine)
    if share == 0.0:
        return 0.0, 0.0
    gap = points[other] - points[row]
    return share, float(gap @ axes[row] - cosine * (gap @ axes[other])) / sine**2


def _share(sine: float) -> float:
    """Weight of a line, from 0 to 1 with a continuous slope."""
    part = min(max((sine - _ASKEW[0]) / (_ASKEW[1] - _ASKEW[0]), 0.0), 1.0)
    return part * part * (3.0 - 2.0 * part)


LegJoints = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True)
class Placed:
    """A model in one posture, its root at the origin.

    Attributes:
        model: free-flyer and joints.
        q: its configuration, shape (nq,).
        places: placements of its joints in the root link.
    """

    model: pin.Model
    q: Array
    places: list[pin.SE3]

    @cached_property
    def lines(self) -> tuple[Array, Array]:
        """A point and the axis of each joint in the root link; see `joint_lines_of`."""
        return joint_lines_of(self.model, self.q)


def place(model: pin.Model, q: Array) -> Placed:
    """Return the model in a posture."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    return Placed(model, q, [placement.copy() for placement in data.oMi])


def joint_axes(model: pin.Model, q: Array, joints: Iterable[int]) -> Array:
    """Return the unit axes of revolute joints in the world, shape (n, 3).

    Args:
        model: of the robot.
        q: its configuration, shape (nq,).
        joints: ids of n joints.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    columns = [(j, model.joints[j].idx_v) for j in joints]
    return np.array(
        [pin.getJointJacobian(model, data, j, pin.LOCAL_WORLD_ALIGNED)[3:, v] for j, v in columns]
    )
