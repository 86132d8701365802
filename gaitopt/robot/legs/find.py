"""Which joints of a humanoid are its two legs, found from the tree and the geometry alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.choices import AXES
from gaitopt.robot.legs.alike import mirrored_pairs, unequal_pair
from gaitopt.robot.legs.refused import SAME_HEIGHT, many_legs, no_legs, no_pair
from gaitopt.robot.legs.tree import UNMOVED, Tree, foot_name, joint_kind, own_joints, unit

_DOWNWARDS = 0.7  # cosine: from the hips a leg goes down
_TOE = 0.03  # m: a joint whose line passes this far ahead of the ankle, and not below, bends toes
_HINGE = 0.5  # sine: the toes' line and that of the ankle's pitch joint are nearly parallel
_SLOPE = 0.5  # of the height by which it is below: how far the toes' line is ahead at least
_FOOT = 1.0 / 3.0  # of the leg: from the ankle to the toes is less
_JOINTS = 6
_UP_ORDER = ("z", "y", "x", "-z", "-y", "-x")  # the usual one first


@dataclass(frozen=True)
class Pair:
    """The two legs before it is known which is which.

    Attributes:
        legs: joint ids from hip to ankle, of either leg.
        up: upward direction in the root link, shape (3,).
        beyond: joints beyond the ankles (toes).
        lying: whether the legs hang along no axis of the root link, so that `up` is only roughly
            known, from hips and ankles.
        tilt: how up was found where no axis of the root link points up, in words, else empty.
    """

    legs: tuple[tuple[int, ...], tuple[int, ...]]
    up: Array
    beyond: tuple[int, ...] = ()
    lying: bool = False
    tilt: str = ""


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
            return _legs(tree, ends, axis, named=feet is not None)
    if feet is not None:
        return _checked(tree, feet, axes[0], trim=False)
    lying = [pair for pair in mirrored_pairs(tree) if _side_by_side(tree, pair)]
    if up is not None or len(lying) != 1 or unequal_pair(tree) is not None:
        raise no_pair(tree)
    pair = _checked(tree, lying[0], -unit(_downwards(tree, lying[0])), trim=False)
    return replace(pair, lying=True)


def _legs(tree: Tree, ends: tuple[int, int], up: Array, *, named: bool) -> Pair:
    if named:
        return _checked(tree, ends, up, trim=False)
    crowd = many_legs(tree, ends, up)
    if crowd is not None:
        raise crowd
    try:
        return _checked(tree, ends, up, trim=True)
    except RobotError as fault:
        raise no_legs(tree, ends, fault) from None


def _lowest_pair(tree: Tree, up: Array) -> tuple[int, int] | None:
    heights = tree.places @ up
    leaves = tree.leaves
    if not leaves:
        return None
    first = min(leaves, key=lambda j: float(heights[j]))
    level = [j for j in leaves if j != first and heights[j] - heights[first] < SAME_HEIGHT]
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


def _side_by_side(tree: Tree, ends: tuple[int, int]) -> bool:
    """Tell whether two chains run the same way, as legs do and spread arms do not."""
    starts = [own_joints(tree.model, *pair)[0] for pair in (ends, ends[::-1])]
    spans = np.linalg.norm(tree.places[list(ends)] - tree.places[starts], axis=1)
    return bool(np.linalg.norm(_downwards(tree, ends)) > _DOWNWARDS * spans.mean())


def _downwards(tree: Tree, ends: tuple[int, int]) -> Array:
    """From between the hips to between the ankles [m], shape (3,)."""
    starts = [own_joints(tree.model, *pair)[0] for pair in (ends, ends[::-1])]
    return np.asarray(tree.places[list(ends)].mean(axis=0) - tree.places[starts].mean(axis=0))


def _hangs(tree: Tree, ends: tuple[int, int], up: Array) -> bool:
    legs = [own_joints(tree.model, *pair) for pair in (ends, ends[::-1])]
    if not all(legs):  # one carries the other, or is the root
        return False
    down = _downwards(tree, ends)
    return bool(-(down @ up) > _DOWNWARDS * np.linalg.norm(down) > 0.0)


def _checked(tree: Tree, ends: tuple[int, int], up: Array, *, trim: bool) -> Pair:
    legs = [own_joints(tree.model, *pair) for pair in (ends, ends[::-1])]
    beyond: list[int] = []
    for leg in legs:
        while trim and len(leg) >= _JOINTS and _is_toe(tree, leg, up):
            beyond.append(leg.pop())
    for leg in legs:
        _check_leg(tree, leg, [j for j in beyond if leg[-1] in tree.model.supports[j]])
    return Pair((tuple(legs[0]), tuple(legs[1])), up, tuple(beyond))


def _is_toe(tree: Tree, leg: list[int], up: Array) -> bool:
    """Tell whether the last joint of a leg bends the toes.

    Its line is nearly parallel to that of one of the two joints before it, and passes that one at
    a level distance, rather than below it as the ankle passes the knee. In a leg that has six
    joints without it the distance may slope, if it is short as a foot is.

    Args:
        tree: the robot.
        leg: joints from hip to the end.
        up: upward direction in the root link, shape (3,).
    """
    axis = tree.axes[leg[-1]]
    span = float(np.linalg.norm(tree.places[leg[-1]] - tree.places[leg[0]]))
    for joint in leg[-3:-1]:
        if np.linalg.norm(np.cross(tree.axes[joint], axis)) < _HINGE:
            gap = tree.places[leg[-1]] - tree.places[joint]
            gap = gap - (gap @ axis) * axis
            ahead, below = float(np.linalg.norm(_across(gap, up))), abs(float(gap @ up))
            spare = len(leg) > _JOINTS and np.linalg.norm(gap) < _FOOT * span
            return ahead > _TOE and ahead > (_SLOPE if spare else 1.0) * below
    return False


def _check_leg(tree: Tree, leg: list[int], toes: list[int]) -> None:
    model = tree.model
    names = [str(model.names[j]) for j in leg]
    if len(leg) != _JOINTS:
        end = foot_name(model, leg[-1]) if leg else "the root"
        more = f", beyond them the toes: {', '.join(model.names[j] for j in toes)}" if toes else ""
        raise RobotError(
            f"the chain that ends in '{end}' has {len(leg)} joints of its own; gaitopt needs two "
            f"legs of six revolute joints each; its joints: {', '.join(names) or 'none'}{more}"
        )
    for joint, name in zip(leg, names, strict=True):
        problem = tree.problem(joint, UNMOVED)
        if problem is not None:
            raise RobotError(f"{problem}; gaitopt needs two legs of six revolute joints each")
        kind = joint_kind(model.joints[joint])
        if kind != "revolute":
            raise RobotError(
                f"joint '{name}' is {kind}; gaitopt needs two legs of six revolute joints each"
            )
