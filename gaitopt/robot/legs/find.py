"""Which joints of a humanoid are its two legs, found from the tree and the geometry alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.choices import AXES
from gaitopt.robot.urdf.values import UrdfProblem

_SAME_HEIGHT = 0.02  # m: feet of a standing robot may differ by this much at its reference posture
_DOWNWARDS = 0.7  # cosine: from the hips a leg goes down
_TOE = 0.03  # m: a joint this far ahead of the one before it, and not below it, bends the toes
_UP_ORDER = ("z", "y", "x", "-z", "-y", "-x")  # the usual one first
_UNMOVED = ("mimic", "free")  # problems of joints that no motor turns
_BODY = pin.FrameType.BODY
_REVOLUTE = ("JointModelRX", "JointModelRY", "JointModelRZ", "JointModelRevoluteUnaligned")


@dataclass(frozen=True)
class Pair:
    """The two legs before it is known which is which.

    Attributes:
        legs: joint ids from hip to ankle, of either leg.
        up: name of the root link's axis that points up.
        beyond: joints beyond the ankles (toes).
    """

    legs: tuple[tuple[int, ...], tuple[int, ...]]
    up: Array
    beyond: tuple[int, ...] = ()


@dataclass(frozen=True)
class Tree:
    """A model at its reference posture.

    Attributes:
        model: free-flyer and joints.
        places: origins of its joints in the root link [m], shape (njoints, 3).
        problems: that were found in its file.
    """

    model: pin.Model
    places: Array
    problems: tuple[UrdfProblem, ...] = ()


def find_legs(tree: Tree, feet: tuple[int, int] | None, up: Array | None) -> Pair:
    """Return the two legs: the pair of mirrored chains that reaches lowest.

    Args:
        tree: the robot.
        feet: joints that carry the feet, if the user named them.
        up: upward axis in the root link if the user named it, shape (3,).

    Raises:
        RobotError: there is no such pair, or its chains are not six revolute joints each.
    """
    axes = [np.array(AXES[name]) for name in _UP_ORDER] if up is None else [up]
    for axis in axes:
        ends = feet or _lowest_pair(tree, axis)
        if ends is not None and (up is not None or _hangs(tree, ends, axis)):
            return _checked(tree, ends, axis, trim=feet is None)
    if feet is not None:
        return _checked(tree, feet, axes[0], trim=False)
    raise RobotError(
        "no two legs were found: no two chains of joints end side by side below everything else "
        "at the reference posture; name the feet in the file for --choices: "
        'feet = ["RIGHT", "LEFT"] (in Python, feet)'
    )


def own_joints(model: pin.Model, end: int, other: int) -> list[int]:
    """Return the joints between the root and a foot that do not carry the other foot too."""
    shared = set(model.supports[other])
    return [j for j in model.supports[end] if j > 1 and j not in shared]


def _lowest_pair(tree: Tree, up: Array) -> tuple[int, int] | None:
    heights = tree.places @ up
    leaves = [j for j in range(2, tree.model.njoints) if len(tree.model.children[j]) == 0]
    if not leaves:
        return None
    first = min(leaves, key=lambda j: float(heights[j]))
    level = [j for j in leaves if j != first and heights[j] - heights[first] < _SAME_HEIGHT]
    if not level:
        return None
    return first, max(level, key=lambda j: _likeness(tree, first, j, up))


def _likeness(tree: Tree, first: int, other: int, up: Array) -> tuple[int, bool, float]:
    """Rank partners: few joints in common, as many of its own, beside rather than behind."""
    mine, its = (own_joints(tree.model, *pair) for pair in ((first, other), (other, first)))
    apart = _across(tree.places[mine[0]] - tree.places[its[0]], up)
    gap = _across(tree.places[first] - tree.places[other], up)
    sideways = abs(float(gap @ apart)) / (float(np.linalg.norm(gap) * np.linalg.norm(apart)) or 1.0)
    return len(mine), len(mine) == len(its), sideways


def _across(vector: Array, up: Array) -> Array:
    return np.asarray(vector - (vector @ up) * up)


def _hangs(tree: Tree, ends: tuple[int, int], up: Array) -> bool:
    starts = [own_joints(tree.model, *pair)[0] for pair in (ends, ends[::-1])]
    down = tree.places[list(ends)].mean(axis=0) - tree.places[starts].mean(axis=0)
    return bool(-(down @ up) > _DOWNWARDS * np.linalg.norm(down) > 0.0)


def _checked(tree: Tree, ends: tuple[int, int], up: Array, *, trim: bool) -> Pair:
    legs = [own_joints(tree.model, *pair) for pair in (ends, ends[::-1])]
    beyond: list[int] = []
    for leg in legs:
        while trim and len(leg) > 1 and _is_toe(tree, leg, up):
            beyond.append(leg.pop())
    for leg in legs:
        _check_leg(tree, leg)
    return Pair((tuple(legs[0]), tuple(legs[1])), up, tuple(beyond))


def _is_toe(tree: Tree, leg: list[int], up: Array) -> bool:
    gap = tree.places[leg[-1]] - tree.places[leg[-2]]
    ahead = float(np.linalg.norm(_across(gap, up)))
    return ahead > _TOE and ahead > abs(float(gap @ up))


def _check_leg(tree: Tree, leg: list[int]) -> None:
    model = tree.model
    names = [model.names[j] for j in leg]
    for joint, name in zip(leg, names, strict=True):
        for problem in tree.problems:
            if problem.name == name and problem.kind in _UNMOVED:
                raise RobotError(f"{problem}; gaitopt needs two legs of six revolute joints each")
        kind = _kind(model.joints[joint])
        if kind != "revolute":
            raise RobotError(
                f"joint '{name}' of a leg is {kind}; gaitopt needs two legs of six revolute "
                "joints each"
            )
    if len(leg) != 6:
        end = foot_name(model, leg[-1]) if leg else "the root"
        raise RobotError(
            f"the leg that ends in '{end}' has {len(leg)} joints of its own; gaitopt needs two "
            f"legs of six revolute joints each; its joints: {', '.join(names) or 'none'}"
        )


def _kind(joint: pin.JointModel) -> str:
    name = joint.shortname()
    if name in _REVOLUTE:
        return "revolute"
    if name.startswith("JointModelRUB") or "Unbounded" in name:
        return "continuous (without a range); give it the type revolute and a limit"
    if name.startswith("JointModelP") and joint.nv == 1:
        return "prismatic"
    return f"one with {joint.nv} degrees of freedom"


def foot_name(model: pin.Model, joint: int) -> str:
    """Return the name of the link that a joint moves, of its sole if it is named so."""
    links = [f.name for f in model.frames if f.parentJoint == joint and f.type == _BODY]
    soles = [name for name in links if "sole" in name.lower()]
    return str([*soles, *links, model.names[joint]][0])
