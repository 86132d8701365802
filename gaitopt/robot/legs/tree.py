"""The joints of a robot as a tree: what ends where, what hangs on what."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.urdf.values import UrdfProblem

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
    problems: tuple[UrdfProblem, ...] = ()
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

    def problem(self, joint: int, kinds: Collection[str]) -> UrdfProblem | None:
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
