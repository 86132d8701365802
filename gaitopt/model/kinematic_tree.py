"""The joints of a robot as a tree in one posture: chains, joint lines, placements.

A revolute joint is a line. Where on it a file puts the origin of the joint is arbitrary, so that
nothing found about a robot depends on it (`points_on_lines`).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.xml_document import FileProblem
from gaitopt.nlp import Array

LOOP = "loop"
"""Kind of the problem of a joint in a loop of bodies."""

UNDRIVEN = ("mimic", "free", "held", LOOP)
"""Kinds of problems of joints that no motor turns."""

LEAST_MASS = 2e-4
"""Of the robot's mass: a branch that carries less is no limb."""

_REVOLUTE = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")

# Sine of the angle between two lines. Below the first they do not tell where on each other they
# meet, above the second they do. The weight grows smoothly in between, so that the two legs of a
# robot that are nearly alike have points that are nearly alike.
_NEARLY_PARALLEL = (0.3, 0.6)
_FALLBACK_WEIGHT = 1e-6  # of the joint before, which decides where no line does

LegJoints = tuple[tuple[int, ...], tuple[int, ...]]
"""Joint ids of two legs from hip to ankle."""


@dataclass(frozen=True)
class PosedModel:
    """A model in one posture, its root at the origin.

    Attributes:
        model: free-flyer and joints.
        q: its configuration [rad], shape (nq,).
        placements: of its joints in the root link.
        problems: that were found in its file.
        rods: joints that carry rods of loops, which are no limbs.
    """

    model: pin.Model
    q: Array
    placements: list[pin.SE3]
    problems: tuple[FileProblem, ...] = ()
    rods: frozenset[int] = frozenset()

    @cached_property
    def axes(self) -> Array:
        """Unit axes of the joints in the root link, 0 for those that do not revolve, (njoints, 3).

        Rows 0 and 1, of the universe and the free-flyer, are 0.
        """
        data = self.model.createData()
        pin.computeJointJacobians(self.model, data, self.q)
        axes = np.zeros((self.model.njoints, 3))
        for joint in range(2, self.model.njoints):
            at = self.model.joints[joint]
            if at.nv == 1:
                J = pin.getJointJacobian(self.model, data, joint, pin.LOCAL_WORLD_ALIGNED)
                axes[joint] = J[3:, at.idx_v]
        return axes

    @property
    def size(self) -> float:
        """Diagonal of the box about its joints [m]."""
        return float(np.linalg.norm(np.ptp(self.points[1:], axis=0)))

    @cached_property
    def points(self) -> Array:
        """Points of the joints in the root link [m], shape (njoints, 3).

        Those of `points_on_lines`; the origins of joints that do not revolve, the centre of mass
        for the root.
        """
        origins = np.array([placement.translation for placement in self.placements])
        # a joint of the root whose place on its line nothing else tells is where the robot is, not
        # where its file has the origin
        centre = pin.centerOfMass(self.model, self.model.createData(), self.q)
        if np.isfinite(centre).all():
            origins[:2] = centre
        return points_on_lines(origins, self.axes, [int(p) for p in self.model.parents])

    @cached_property
    def leaves(self) -> list[int]:
        """Joints that carry no other joint, branches without mass left out.

        Such branches stand for rods of a linkage, cables or frames. What carries next to nothing
        is none of a robot's limbs.
        """
        model = self.model
        below = [float(body.mass) for body in model.inertias]
        least, light = LEAST_MASS * sum(below), set()
        for joint in reversed(range(2, model.njoints)):
            below[model.parents[joint]] += below[joint]
        for joint in range(2, model.njoints):
            parent = int(model.parents[joint])
            forks = parent < 2 or len(model.children[parent]) > 1
            if parent in light or joint in self.rods or (forks and below[joint] < least):
                light.add(joint)
        return [
            joint
            for joint in range(2, model.njoints)
            if joint not in light and all(int(c) in light for c in model.children[joint])
        ]

    def problem(self, joint: int, kinds: Collection[str]) -> FileProblem | None:
        """Return the first problem of a joint that is of one of some kinds."""
        name = self.model.names[joint]
        return next((p for p in self.problems if p.name == name and p.kind in kinds), None)

    def finger(self, joint: int) -> bool:
        """Whether a joint follows another beside one that does so too, as fingers on a hand do."""
        model = self.model
        beside = [int(j) for j in model.children[int(model.parents[joint])]]
        followers = [j for j in beside if self.problem(j, ("tied",)) is not None]
        return joint in followers and len(followers) > 1 and len(model.children[joint]) == 0

    def angle(self, joint: int) -> float:
        """Return the angle of a revolute joint [rad]."""
        return float(self.q[self.model.joints[joint].idx_q])


def pose_model(model: pin.Model, q: Array, problems: tuple[FileProblem, ...] = ()) -> PosedModel:
    """Return the model in a posture q [rad], shape (nq,)."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    return PosedModel(model, q, [placement.copy() for placement in data.oMi], problems)


def subtree_centres(model: pin.Model, q: Array) -> Array:
    """Return the centres of mass of all that each joint moves [m], shape (njoints, 3).

    In the world, at configuration q; what has no mass is at its joint.
    """
    data = model.createData()
    pin.centerOfMass(model, data, q)
    return np.array(
        [
            place.act(com) if np.isfinite(com).all() else place.translation
            for place, com in zip(data.oMi, data.com, strict=True)
        ]
    )


def own_joints(model: pin.Model, end: int, other: int) -> list[int]:
    """Return the joints between the root and a foot that do not carry the other foot too."""
    shared = set(model.supports[other])
    return [j for j in model.supports[end] if j > 1 and j not in shared]


def own_chains(model: pin.Model, ends: tuple[int, int]) -> tuple[list[int], list[int]]:
    """Return the joints of both feet's own, root side first."""
    return own_joints(model, *ends), own_joints(model, *ends[::-1])


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


def joint_slides(joint: pin.JointModel) -> bool:
    """Return whether a joint slides along its axis."""
    return joint_kind(joint) == "prismatic"


def all_revolute(model: pin.Model, joints: Collection[int]) -> bool:
    """Tell whether all joints are revolute and have a range."""
    return all(joint_kind(model.joints[j]) == "revolute" for j in joints)


def foot_name(model: pin.Model, joint: int) -> str:
    """Return the name of the link that a joint moves, of its sole if it is named so."""
    links = [
        f.name for f in model.frames if f.parentJoint == joint and f.type == pin.FrameType.BODY
    ]
    soles = [name for name in links if "sole" in name.lower()]
    return str([*soles, *links, model.names[joint]][0])


def line_gap(point: Array, axis: Array, other_point: Array, other_axis: Array) -> float:
    """Return how far apart lines (3,) are, in m or the sine of their angle, the larger one."""
    apart = np.cross(other_point - point, axis)
    return float(max(np.linalg.norm(apart), np.linalg.norm(np.cross(axis, other_axis))))


def unit(vector: Array) -> Array:
    """Return a vector (3,) at length 1, or as it is if it has no length."""
    return np.asarray(vector / (float(np.linalg.norm(vector)) or 1.0))


def angle_between(first: Array, other: Array) -> float:
    """Return the angle between two unit vectors (3,) [rad], exact for small ones too."""
    return float(np.arctan2(np.linalg.norm(np.cross(first, other)), first @ other))


def turn_onto(vector: Array, goal: Array) -> Array:
    """Return the smallest rotation that takes one unit vector onto another, shape (3, 3)."""
    axis = np.cross(vector, goal)
    sine, cosine = float(np.linalg.norm(axis)), float(vector @ goal)
    if sine == 0.0:
        return np.eye(3)
    return np.asarray(pin.exp3(axis / sine * np.arctan2(sine, cosine)))


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
        weight, along = _FALLBACK_WEIGHT, 0.0
        if parent != row:
            along = _FALLBACK_WEIGHT * float((found[parent] - points[row]) @ axes[row])
        left = 1.0
        for beside in ([parent], children):
            meetings = [_meeting(points, axes, row, k) for k in beside]
            for share, place in meetings:
                part = left * share / max(len(beside), 1)
                weight, along = weight + part, along + part * place
            left *= 1.0 - max((share for share, _ in meetings), default=0.0)
        found[row] = points[row] + along / weight * axes[row]
    return found


def _meeting(points: Array, axes: Array, row: int, other: int) -> tuple[float, float]:
    """Return how clearly another line tells a place on a line (0 to 1), and which [m]."""
    cosine = float(axes[row] @ axes[other])
    sine = float(np.linalg.norm(np.cross(axes[row], axes[other])))
    low, high = _NEARLY_PARALLEL
    part = min(max((sine - low) / (high - low), 0.0), 1.0)
    share = part * part * (3.0 - 2.0 * part)
    if share == 0.0:
        return 0.0, 0.0
    gap = points[other] - points[row]
    return share, float(gap @ axes[row] - cosine * (gap @ axes[other])) / sine**2
