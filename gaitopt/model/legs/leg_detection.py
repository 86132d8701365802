"""Which joints of a humanoid are its two legs, found from the tree and the geometry alone.

Names of sides never decide; they only help to describe. Where there are no two legs the errors say
what there is instead, and what helps.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.model.import_options import AXES, SIDES, ImportOptions
from gaitopt.model.legs.kinematic_tree import (
    LIGHT,
    UNMOVED,
    Tree,
    all_revolute,
    branches,
    foot_name,
    joint_kind,
    own_joints,
    unit,
)
from gaitopt.nlp import Array

SIDE_WORDS = {
    "right": re.compile(r"(?i:right)|(?<![a-zA-Z])[rR](?![a-zA-Z])|^R(?=[A-Z])"),
    "left": re.compile(r"(?i:left)|(?<![a-zA-Z])[lL](?![a-zA-Z])|^L(?=[A-Z])"),
}
"""What a name says about the side it is on."""


def partners_by_name(first: str, other: str) -> bool:
    """Tell whether two names differ in the word for the side, and in nothing else."""
    return any(
        SIDE_WORDS[a].search(first) is not None
        and SIDE_WORDS[b].search(other) is not None
        and SIDE_WORDS[a].sub("*", first) == SIDE_WORDS[b].sub("*", other)
        for a, b in (("right", "left"), ("left", "right"))
    )


def speaks_for_other_side(right: Sequence[str], left: Sequence[str]) -> bool:
    """Tell whether the names of a right leg's joints are those of a left one, and the other way.

    What tells is where the names of two partners differ: `LR_HR` and `LL_HR` are the right and the
    left leg of a robot that begins its legs with L.

    Args:
        right, left: names of the joints from hip to ankle.
    """
    initials = [_initials(*names) for names in zip(right, left, strict=True)]
    return "lr" in initials and "rl" not in initials


def _initials(first: str, other: str) -> str:
    """First letters of what differs in two names, in lower case."""
    start = 0
    while start < min(len(first), len(other)) and first[start] == other[start]:
        start += 1
    return (first[start : start + 1] + other[start : start + 1]).lower()


_SAME = 1e-2  # m: legs whose joints differ by more are not averaged by anyone
_BENT = 1e-3  # rad: mirrored joints stand at angles of one size
_PARALLEL = 2e-2  # rad: lines between mirrored joints
_NEAR = 0.25  # of the chains' length: legs that differ by more are not one pair without names
_FAULTS = 2  # joints: chains that differ at more are two arms of one kind rather than two legs
_JOINTS = 6


@dataclass(frozen=True)
class Unequal:
    """Two six-joint chains that would be a pair of legs, were it not for one joint.

    Attributes:
        legs: joint ids from the root's side to the end.
        row: of the first joint that is at fault.
        bent: whether it is the reference posture that differs, not the robot.
        size: how far the joint is from the mirror image of its partner, seen from the joint before
            it, if any [m], or how much their angles differ in size [rad].
    """

    legs: tuple[list[int], list[int]]
    row: int
    bent: bool
    size: float


def mirror_normal(tree: Tree, legs: tuple[list[int], list[int]]) -> Array | None:
    """Return the normal of the plane between two chains, from the second's side to the first's.

    None if there is no such plane: mirrored joints lie on parallel lines, halved by one plane.

    Args:
        tree: the robot.
        legs: joint ids, as many in each.
    """
    first, other = (tree.places[leg] for leg in legs)
    gaps = first - other
    normal = unit(gaps.sum(axis=0))
    middles = (first + other) @ normal / 2.0
    skew = np.linalg.norm(np.cross(gaps, normal), axis=1)
    if np.any(skew > _PARALLEL * np.linalg.norm(gaps, axis=1)) or np.ptp(middles) > _SAME:
        return None
    return normal if normal.any() else None


def axes_apart(first: Array, other: Array, normal: Array) -> float:
    """Return how far the axes of two legs are from mirror images in a plane, on average [rad].

    Args:
        first, other: of the joints, from hip to ankle, shape (n, 3) each; either sense.
        normal: of the plane, shape (3,).
    """
    image = first - 2.0 * np.outer(first @ normal, normal)
    cosine = np.abs((image * other).sum(axis=1))
    return float(np.arctan2(np.linalg.norm(np.cross(image, other), axis=1), cosine).mean())


def mirrored_pairs(tree: Tree) -> list[tuple[int, int]]:
    """Return the ends of all pairs of six-joint chains that mirror each other."""
    return [
        (legs[0][-1], legs[1][-1])
        for legs in _six_jointed(tree)
        if mirror_normal(tree, legs) is not None
    ]


def unequal_pair(tree: Tree) -> Unequal | None:
    """Return the two six-joint chains that nearly mirror each other, None if there are none.

    By name they are a pair if their joints are called the same but for left and right; without
    that their joints must be nearly where their mirror images are.
    """
    found: list[tuple[bool, int, Unequal]] = []
    for legs in _six_jointed(tree):
        fault = _fault(tree, legs)
        named = all(
            partners_by_name(*(str(tree.model.names[j]) for j in pair))
            for pair in zip(*legs, strict=True)
        )
        if fault is not None and (named or (not fault.bent and _near(tree, fault))):
            found.append((not named, len(found), fault))
    return min(found)[2] if found else None


def _six_jointed(tree: Tree) -> Iterator[tuple[list[int], list[int]]]:
    for pair in combinations(tree.leaves, 2):
        first, other = (own_joints(tree.model, *ends) for ends in (pair, pair[::-1]))
        both = [*first, *other]
        driven = all_revolute(tree.model, both) and not any(tree.problem(j, UNMOVED) for j in both)
        if len(first) == len(other) == _JOINTS and driven:
            yield first, other


def _fault(tree: Tree, legs: tuple[list[int], list[int]]) -> Unequal | None:
    angles = np.abs([[tree.angle(j) for j in leg] for leg in legs])
    bends = np.abs(angles[0] - angles[1])
    if bends.max() > _BENT:
        row = int((bends > _BENT).argmax())
        return Unequal(legs, row, True, float(bends[row]))
    gaps = _mirror_gaps(tree, legs)
    wrong = gaps > _SAME
    if not 0 < wrong.sum() <= _FAULTS:
        return None
    row = int(wrong.argmax())
    return Unequal(legs, row, False, float(gaps[row]))


def _mirror_gaps(tree: Tree, legs: tuple[list[int], list[int]]) -> Array:
    """How far each joint is from its partner's mirror image, seen from the joint before [m].

    The normal of the mirror plane is the line between the first joints, or an axis of the root
    link, whichever leaves fewer joints at fault. Shape (n,).
    """
    first, other = (tree.places[leg] for leg in legs)
    gap, steps = first[0] - other[0], [np.diff(points, axis=0) for points in (first, other)]
    found: list[Array] = []
    for normal in (unit(gap), *np.eye(3)):
        mirrored = steps[1] - 2.0 * np.outer(steps[1] @ normal, normal)
        start = np.linalg.norm(gap - (gap @ normal) * normal)
        found.append(np.r_[start, np.linalg.norm(steps[0] - mirrored, axis=1)])
    return min(found, key=lambda gaps: (int((gaps > _SAME).sum()), float(gaps.sum())))


def _near(tree: Tree, fault: Unequal) -> bool:
    steps = [np.diff(tree.places[leg], axis=0) for leg in fault.legs]
    lengths = [np.linalg.norm(step, axis=1).sum() for step in steps]
    return bool(fault.size < _NEAR * max(lengths))


SAME_HEIGHT = 0.02  # m: feet of a standing robot may differ by this much at its reference posture
NAME_FEET = 'feet = ["RIGHT", "LEFT"] in the file for --choices (in Python, feet)'

_NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
_WAIST = 4  # joints: chains that share more branch off a hand, not off a pelvis
_NEEDS = "gaitopt walks on two legs of six revolute joints each"


def no_pair(tree: Tree) -> RobotError:
    """Return the error for a robot of which no two chains hang like legs."""
    found = f"no two legs were found: {_chains(tree)}"
    if len(tree.leaves) < 2:
        remedy = _too_light(tree) or "give a robot that has them"
        return RobotError(f"{found}; {_NEEDS}; {remedy}")
    legs = _six_jointed_ends(tree, ())
    if legs is None:
        return _unequal(tree) or RobotError(f"{found}; {_NEEDS}, and no two of them are such legs")
    return _unequal(tree) or RobotError(
        f"{found}; no two chains of joints end side by side below everything else at the "
        f"reference posture; {_NEEDS}, as the chains to {legs} are; if it is a biped, say where "
        f'its head is (up: an axis of the root link, as "y", or three numbers) or name the feet: '
        f"{NAME_FEET}"
    )


def no_legs(tree: Tree, ends: tuple[int, int], fault: RobotError) -> RobotError:
    """Return the error for a robot whose lowest pair of chains cannot be its legs.

    Args:
        tree: the robot.
        ends: of the chains.
        fault: what is wrong with them as legs.
    """
    model = tree.model
    names = " and ".join(f"'{foot_name(model, j)}'" for j in ends)
    shared = _shared(tree, ends)
    fingers = ""
    if any(tree.problem(j, ("mimic",)) is not None for j in ends):
        fingers = "follow other joints (<mimic>)"
    elif shared >= _WAIST:
        fingers = f"share {shared} joints"
    if fingers:
        return _unequal(tree) or RobotError(
            f"no two legs were found: {_chains(tree)}; those that reach lowest, to {names}, "
            f"{fingers}, as fingers do; {_NEEDS}{_others(tree, ends)}"
        )
    return _unequal(tree) or RobotError(
        f"{fault}; the chains to {names} were taken for legs, as they reach lowest; if they are "
        f"arms, the robot shows no legs{_others(tree, ends)}"
    )


def no_up(tree: Tree, ends: tuple[int, int]) -> RobotError:
    """Return the error for two mirrored chains of which it cannot be told how they stand."""
    names = " and ".join(f"'{foot_name(tree.model, j)}'" for j in ends)
    return RobotError(
        f"no two legs were found that hang along an axis of the root link; the chains of six "
        f"joints to {names} mirror each other, but no soles show which way is up for them; if "
        "they are the legs, say so: up = [X, Y, Z] in the file for --choices (in Python, up), "
        f"or name the feet: {NAME_FEET}"
    )


def many_legs(tree: Tree, ends: tuple[int, int], up: Array) -> RobotError | None:
    """Return the error for a robot that stands on more than two chains of joints, if it does.

    Args:
        tree: the robot.
        ends: of the two chains that would be its legs.
        up: upward axis in the root link, shape (3,).
    """
    heights = tree.places @ up
    ground = min(heights[j] for j in ends) + SAME_HEIGHT
    low = [j for j in tree.leaves if heights[j] < ground]
    legs = branches(tree.model, low)
    count = len(own_joints(tree.model, *ends))
    legs = [leg for leg in legs if len(leg) == count]
    if len(legs) < 3 or _shared(tree, low) >= _WAIST:
        return None
    number = _NUMBERS.get(len(legs), str(len(legs)))
    joints = "one joint" if count == 1 else f"{count} joints"
    names = ", ".join(f"'{foot_name(tree.model, leg[-1])}'" for leg in legs)
    return RobotError(
        f"no two legs were found: {number} chains of {joints} each reach equally low, "
        f"down to {names}; {_NEEDS}{_others(tree, [leg[-1] for leg in legs])}"
    )


def _too_light(tree: Tree) -> str:
    """Advice where there are chains enough, but what they carry is next to nothing."""
    model = tree.model
    ends = [j for j in range(2, model.njoints) if len(model.children[j]) == 0]
    if len(ends) < 2:
        return ""
    mass = sum(float(body.mass) for body in model.inertias)
    heaviest = max(range(1, model.njoints), key=lambda j: float(model.inertias[j].mass))
    body = "the trunk" if heaviest == 1 else f"the body moved by joint '{model.names[heaviest]}'"
    return (
        f"legs carry mass, but of {mass:.4g} kg, {float(model.inertias[heaviest].mass):.4g} kg of "
        f"it {body}, the chains here have less than {100 * LIGHT:g} %; correct the masses (kg) of "
        "the file"
    )


def _others(tree: Tree, ends: Collection[int]) -> str:
    """Advice to name the feet, where the robot has other chains that may be its legs."""
    legs = _six_jointed_ends(tree, ends)
    if legs is None:
        return ""
    return f"; if its legs are the chains to {legs} or others, name its feet: {NAME_FEET}"


def _six_jointed_ends(tree: Tree, but: Collection[int]) -> str | None:
    """Ends of two chains of six driven revolute joints each, but for some; None if none are."""
    for pair in combinations([j for j in tree.leaves if j not in but], 2):
        legs = [own_joints(tree.model, *ends) for ends in (pair, pair[::-1])]
        driven = [j for leg in legs for j in leg if tree.problem(j, UNMOVED) is None]
        six = [len(leg) for leg in legs] == [_JOINTS, _JOINTS] and len(driven) == 2 * _JOINTS
        if six and all_revolute(tree.model, driven):
            return " and ".join(f"'{foot_name(tree.model, j)}'" for j in pair)
    return None


def _shared(tree: Tree, ends: Collection[int]) -> int:
    """How many joints carry all of some joints."""
    return len(set.intersection(*(set(tree.model.supports[j]) for j in ends)) - {0, 1})


def _unequal(tree: Tree) -> RobotError | None:
    pair = unequal_pair(tree)
    if pair is None:
        return None
    first, other = (str(tree.model.names[leg[pair.row]]) for leg in pair.legs)
    ends = json.dumps([foot_name(tree.model, leg[-1]) for leg in pair.legs], ensure_ascii=False)
    if pair.bent:
        angles = [tree.angle(leg[pair.row]) for leg in pair.legs]
        return RobotError(
            f"the reference posture bends the legs unequally: '{first}' stands at {angles[0]:.4g} "
            f"rad, its partner '{other}' at {angles[1]:.4g} rad; give both legs mirrored angles "
            "with flat feet (posture)"
        )
    away = f"lies {pair.size * 1e3:.1f} mm away from the mirror image of '{other}'"
    if pair.row > 0:
        before = [str(tree.model.names[leg[pair.row - 1]]) for leg in pair.legs]
        away += f", each seen from the joint before it ('{before[0]}' and '{before[1]}')"
    return RobotError(
        f"the legs are not mirror images: '{first}' {away}; correct the <origin> of one of them, "
        f"or of a joint above it; or if they are to be averaged, name the feet: feet = {ends} in "
        "the file for --choices (in Python, feet), and be told how large an asymmetry to choose"
    )


def _chains(tree: Tree) -> str:
    """How many chains of joints there are, and where the longest end."""
    leaves = [j for j in range(2, tree.model.njoints) if len(tree.model.children[j]) == 0]
    if not leaves:
        return "no joint moves"
    lengths = {j: len(tree.model.supports[j]) - 2 for j in leaves}
    most = max(lengths.values())
    longest = [j for j in leaves if lengths[j] == most]
    names = " and ".join(f"'{foot_name(tree.model, j)}'" for j in longest[:2])
    joints = "one joint" if most == 1 else f"{most} joints"
    if len(leaves) == 1:
        return f"one chain of {joints}, which ends in {names}"
    number = _NUMBERS.get(len(leaves), str(len(leaves)))
    more = f" and {len(longest) - 2} more" if len(longest) > 2 else ""
    ends = "ends" if len(longest) == 1 else "end"
    return f"{number} chains, the longest, of {joints}, {ends} in {names}{more}"


_DOWNWARDS = 0.7  # cosine: from the hips a leg goes down
_TOE = 0.03  # m: a joint whose line passes this far ahead of the ankle, and not below, bends toes
_HINGE = 0.5  # sine: the toes' line and that of the ankle's pitch joint are nearly parallel
_SLOPE = 0.5  # of the height by which it is below: how far the toes' line is ahead at least
_FOOT = 1.0 / 3.0  # of the leg: from the ankle to the toes is less
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


_HINTS = ("sole", "foot", "ankle")


def named_feet(model: pin.Model, choices: ImportOptions) -> tuple[int, int] | None:
    """Return the joints that carry the two feet, if the user named both, in any order.

    Raises:
        RobotError: there is no such link, joint or frame, or both are on one foot.
    """
    names = choices.feet
    if choices.sole_placements is None:
        soles = choices.stance_sole, choices.swing_sole
        for name in soles:
            if name is not None:
                joint_of(model, name)
        if names is None and soles[0] is not None and soles[1] is not None:
            names = (soles[0], soles[1])
    if names is None:
        return None
    first, second = (joint_of(model, name) for name in names)
    if first == second or 0 in (first, second):
        raise RobotError(
            f"'{names[0]}' and '{names[1]}' are moved by the same joint; name two different feet"
        )
    return first, second


def joint_of(model: pin.Model, name: str) -> int:
    """Return the joint that moves a link, a joint's child or a frame.

    Raises:
        RobotError: nothing has that name.
    """
    if model.existJointName(name):
        return int(model.getJointId(name))
    for frame in model.frames:
        if frame.name == name:
            return int(frame.parentJoint)
    names = sorted({f.name for f in model.frames if any(h in f.name.lower() for h in _HINTS)})
    raise RobotError(
        f"the URDF has no frame named '{name}'; frames that look like feet: "
        f"{', '.join(names) or 'none'}. Name others, or leave them out to have them found"
    )


def standing_side(
    model: pin.Model, legs: tuple[tuple[int, ...], tuple[int, ...]], choices: ImportOptions
) -> int:
    """Return which foot stands: 0 for the right one, 1 for the left one.

    Raises:
        RobotError: a sole frame is on neither foot, or the names contradict `stance`.
    """
    if choices.sole_placements is not None:
        return SIDES.index(choices.stance or SIDES[0])
    told = {} if choices.stance is None else {SIDES.index(choices.stance): "stance"}
    for name, turn in ((choices.stance_sole, 0), (choices.swing_sole, 1)):
        if name is None:
            continue
        joint = joint_of(model, name)
        sides = [side for side in (0, 1) if legs[side][-1] == joint]
        if not sides:
            raise RobotError(
                f"frame '{name}' is on neither foot; the feet are moved by "
                f"'{model.names[legs[0][-1]]}' (right) and '{model.names[legs[1][-1]]}' (left)"
            )
        told[sides[0] ^ turn] = f"'{name}'"
    if len(told) > 1:
        raise RobotError(
            f"{told[0]} makes the right foot stand, but {told[1]} the left one; "
            "stance_sole must be on the standing foot and swing_sole on the other"
        )
    return next(iter(told), 0)
