"""Which joints of a humanoid are its two legs, found from the tree and the geometry alone.

A leg is the chain of joints between the pelvis and a foot. Names of sides never decide; they only
help to describe. Where there are no two legs the errors say what there is instead, and what helps.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from itertools import combinations, zip_longest
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, did_you_mean
from gaitopt.model.import_options import AXES, SIDES, ImportOptions
from gaitopt.model.kinematic_tree import (
    LEAST_MASS,
    UNDRIVEN,
    LegJoints,
    PosedModel,
    all_revolute,
    branches,
    foot_name,
    joint_kind,
    own_chains,
    own_joints,
    unit,
)
from gaitopt.model.leg_geometry import NEEDED_JOINTS, hip_and_ankle, missing_joints
from gaitopt.model.scales import REACH
from gaitopt.nlp import Array

LEG_LENGTHS = (6, 5, 7, 4)
"""Numbers of joints that a leg may have, the most usual first."""
_SAME_HEIGHT = 0.03  # of the robot: feet of a standing one differ by less at its posture
SIDE_WORDS = {
    "right": re.compile(r"(?i:right)|(?<![a-zA-Z])[rR](?![a-zA-Z])|^R(?=[A-Z])"),
    "left": re.compile(r"(?i:left)|(?<![a-zA-Z])[lL](?![a-zA-Z])|^L(?=[A-Z])"),
}
"""What a name says about the side it is on."""

_SAME_PLACE = 0.016  # of the robot: legs whose joints differ by more are not averaged by anyone
_SAME_ANGLE = 1e-3  # rad: mirrored joints stand at angles of one size
_PARALLEL = 2e-2  # rad: lines between mirrored joints
_NEARLY_MIRRORED = 0.25  # of the chains' length: what differs more is no pair without names
_FAULTS = 2  # joints: chains that differ at more are two arms of one kind rather than two legs
_MOST_SHARED = 3  # joints: chains that share more branch off a hand, not off a pelvis
_DOWNWARDS = 0.7  # cosine: from the hips a leg goes down
_TOE = 0.03 / REACH  # of the leg: a joint whose line is so far ahead of the ankle's bends toes
_TOE_PARALLEL = 0.5  # sine: the toes' line and that of the ankle's pitch joint are nearly parallel
_TOE_SLOPE = 0.5  # of the height by which it is below: how far the toes' line is ahead at least
_FOOT = 1.0 / 3.0  # of the leg: from the ankle to the toes is less
_LEVEL = 0.7  # cosine: the axis of a knee is level
_UP_ORDER = ("z", "y", "x", "-z", "-y", "-x")  # the usual one first

_MISSING = {"knee": "no knee between hip and ankle"}
_HINTS = ("sole", "foot", "ankle")
_ARM_WORDS = re.compile(r"(?i)arm|shoulder|elbow|wrist|hand|palm|finger|thumb|gripper")
_LEG_WORDS = re.compile(r"(?i)leg|hip|thigh|knee|shin|calf|ankle|foot|feet|toe")
_NUMBERS = ("no", "one", "two", "three", "four", "five", "six", "seven")
_LEGS = "two legs of four to seven revolute joints each"
_NEEDS = f"gaitopt walks on {_LEGS}"
_NAME_FEET = 'feet = ["RIGHT", "LEFT"] in the file for --choices (in Python, feet)'


@dataclass(frozen=True)
class LegPair:
    """The two legs before it is known which is which.

    Attributes:
        legs: joint ids from hip to ankle, of either leg.
        up: upward direction in the root link, shape (3,).
        beyond: joints beyond the ankles (toes).
        lying: whether the legs hang along no axis of the root link, so that `up` is only roughly
            known, from hips and ankles.
        tilt: how up was found where no axis of the root link points up, in words, else empty.
    """

    legs: LegJoints
    up: Array
    beyond: tuple[int, ...] = ()
    lying: bool = False
    tilt: str = ""


class _UnequalPair(NamedTuple):
    """Two chains that would be a pair of legs, were it not for one joint."""

    legs: tuple[list[int], list[int]]  # joint ids from the root's side to the end
    row: int  # of the first joint that is at fault
    bent: bool  # whether it is the reference posture that differs, not the robot
    size: float  # [m] from its partner's mirror image, seen from the joint before; of angles [rad]


def find_legs(posed: PosedModel, feet: tuple[int, int] | None, up: Array | None) -> LegPair:
    """Return the two legs: the pair of mirrored chains that reaches lowest.

    Chains whose joints are named as those of arms count only where there are no others.

    Args:
        feet: joints that carry the feet, if the user named them.
        up: upward axis in the root link if the user named it, shape (3,).

    Raises:
        RobotError: there is no such pair, or its chains are not legs.
    """
    if rooted := _rooted_in_a_leg(posed):
        raise RobotError(rooted)
    axes = [np.array(AXES[name]) for name in _UP_ORDER] if up is None else [up]
    for axis in axes:
        ends = feet or _lowest_pair(posed, axis)
        if ends is None or not (up is not None or _hangs(posed, ends, axis)):
            continue
        if feet is not None:
            return _checked(posed, ends, axis, trim=False)
        if (crowd := _many_legs(posed, ends, axis)) is not None:
            raise crowd
        try:
            pair = _checked(posed, ends, axis, trim=True)
        except RobotError as fault:
            raise no_legs(posed, ends, fault) from None
        return _no_arms(posed, ends, pair)
    if feet is not None:
        return _checked(posed, feet, axes[0], trim=False)
    mirrored = (pair for pair in _leg_like(posed) if mirror_normal(posed, pair) is not None)
    lying = [(a[-1], b[-1]) for a, b in mirrored if _side_by_side(posed, (a[-1], b[-1]))]
    if up is not None or len(lying) != 1 or _unequal_pair(posed) is not None:
        raise _no_pair(posed)
    pair = _checked(posed, lying[0], -unit(_downwards(posed, lying[0])), trim=False)
    return _no_arms(posed, lying[0], replace(pair, lying=True))


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
    if name in list(model.names):
        return int(model.getJointId(name))
    for frame in model.frames:
        if frame.name == name:
            return int(frame.parentJoint)
    names = sorted({f.name for f in model.frames if any(h in f.name.lower() for h in _HINTS)})
    hint = did_you_mean(name, (str(frame.name) for frame in model.frames))
    raise RobotError(
        f"the URDF has no frame named '{name}'; {hint}frames that look like feet: "
        f"{', '.join(names) or 'none'}. Name others, or leave them out to have them found"
    )


def standing_side(model: pin.Model, legs: LegJoints, choices: ImportOptions) -> int:
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


def joint_count(count: int) -> str:
    """Return a number of joints in words, as "one joint" or "5 joints"."""
    return "one joint" if count == 1 else f"{count} joints"


def number_word(number: int) -> str:
    """Return a number in words if it is small."""
    return _NUMBERS[number] if number < len(_NUMBERS) else str(number)


def _partners_by_name(first: str, other: str) -> bool:
    """Tell whether two names differ in the word for the side, and in nothing else."""
    return any(
        SIDE_WORDS[a].search(first) is not None
        and SIDE_WORDS[b].search(other) is not None
        and SIDE_WORDS[a].sub("*", first) == SIDE_WORDS[b].sub("*", other)
        for a, b in (SIDES, SIDES[::-1])
    )


def speaks_for_other_side(right: Sequence[str], left: Sequence[str]) -> bool:
    """Tell whether the names of a right leg's joints are those of a left one, and the other way.

    What tells is where the names of two partners differ: `LR_HR` and `LL_HR` are the right and the
    left leg of a robot that begins its legs with L.
    """
    initials = []
    for pair in zip(right, left, strict=True):
        differ = (a + b for a, b in zip_longest(*pair, fillvalue="") if a != b)
        initials.append(next(differ, "").lower())
    return "lr" in initials and "rl" not in initials


def mirror_normal(posed: PosedModel, legs: Sequence[Sequence[int]]) -> Array | None:
    """Return the normal (3,) of the plane between two chains, from the second side to the first.

    None if there is no such plane: mirrored joints lie on parallel lines, halved by one plane.
    """
    first, other = (posed.points[list(leg)] for leg in legs)
    gaps = first - other
    normal = unit(gaps.sum(axis=0))
    middles = (first + other) @ normal / 2.0
    skew = np.linalg.norm(np.cross(gaps, normal), axis=1)
    parallel = np.all(skew <= _PARALLEL * np.linalg.norm(gaps, axis=1))
    halved = np.ptp(middles) <= _SAME_PLACE * posed.size
    return normal if parallel and halved and normal.any() else None


def axes_apart(first: Array, other: Array, normal: Array) -> float:
    """Return how far unit axes (n, 3) of two legs are from images in a plane, on average [rad].

    Args:
        first, other: from hip to ankle; either sense of an axis will do.
        normal: of the plane, shape (3,).
    """
    image = first - 2.0 * np.outer(first @ normal, normal)
    cosine = np.abs((image * other).sum(axis=1))
    return float(np.arctan2(np.linalg.norm(np.cross(image, other), axis=1), cosine).mean())


def _rooted_in_a_leg(posed: PosedModel) -> str:
    """Say that the root of the file lies in a leg, where it does; else nothing.

    The way from the heaviest body to the root, and on to the end beyond it, is then a leg, with as
    many joints as another chain on that body.
    """
    model = posed.model
    trunk = max(range(1, model.njoints), key=lambda j: float(model.inertias[j].mass))
    way = {int(j) for j in model.supports[trunk]} - {0, 1}
    ends = [{int(j) for j in model.supports[leaf]} - {0, 1} for leaf in posed.leaves]
    beyond = max((len(end) for end in ends if not end & way), default=0)
    others = {len(end - way) for end in ends if trunk in end}
    if len(way) <= _MOST_SHARED or len(way) + beyond not in others.intersection(LEG_LENGTHS):
        return ""
    root = next(frame.name for frame in model.frames if frame.type == pin.FrameType.BODY)
    link = foot_name(model, trunk)
    return (
        f"the root of the file, '{root}', lies in a leg: {joint_count(len(way))} lie between it "
        f"and the heaviest link, '{link}'; gaitopt needs a root above both legs: write the file "
        f"with '{link}' as its root"
    )


def _unequal_pair(posed: PosedModel) -> _UnequalPair | None:
    """Return the two chains, long as legs, that nearly mirror each other, None if none do."""
    # They are a pair by name if that differs in left and right alone; else joints must be near
    # images.
    found: list[tuple[bool, int, _UnequalPair]] = []
    for legs in _leg_like(posed):
        fault = _mirror_fault(posed, legs)
        if fault is None:
            continue
        names = [[str(posed.model.names[j]) for j in leg] for leg in legs]
        named = all(_partners_by_name(a, b) for a, b in zip(*names, strict=True))
        steps = [np.diff(posed.points[leg], axis=0) for leg in legs]
        length = max(np.linalg.norm(step, axis=1).sum() for step in steps)
        if named or (not fault.bent and fault.size < _NEARLY_MIRRORED * length):
            found.append((not named, len(found), fault))
    return min(found)[2] if found else None


def _leg_like(posed: PosedModel, but: Collection[int] = ()) -> list[tuple[list[int], list[int]]]:
    """Return pairs of driven revolute chains as long as legs are, the most usual length alone."""
    found: dict[int, list[tuple[list[int], list[int]]]] = {}
    for pair in combinations([j for j in posed.leaves if j not in but], 2):
        first, other = own_chains(posed.model, pair)
        both = [*first, *other]
        driven = all_revolute(posed.model, both) and not (
            any(posed.problem(j, UNDRIVEN) for j in both) or any(map(posed.finger, pair))
        )
        if len(first) == len(other) and driven:
            found.setdefault(len(first), []).append((first, other))
    return next((found[count] for count in LEG_LENGTHS if count in found), [])


def _mirror_fault(posed: PosedModel, legs: tuple[list[int], list[int]]) -> _UnequalPair | None:
    angles = np.abs([[posed.angle(j) for j in leg] for leg in legs])
    bends = np.abs(angles[0] - angles[1])
    if bends.max() > _SAME_ANGLE:
        row = int((bends > _SAME_ANGLE).argmax())
        return _UnequalPair(legs, row, True, float(bends[row]))
    gaps = _mirror_gaps(posed, legs)
    wrong = gaps > _SAME_PLACE * posed.size
    if not 0 < wrong.sum() <= _FAULTS:
        return None
    row = int(wrong.argmax())
    return _UnequalPair(legs, row, False, float(gaps[row]))


def _mirror_gaps(posed: PosedModel, legs: tuple[list[int], list[int]]) -> Array:
    """How far each joint is from its partner's image, seen from the joint before [m], (n,)."""
    # The normal of the mirror is the line between the first joints, or an axis of the root link,
    # whichever leaves fewer joints at fault.
    first, other = (posed.points[leg] for leg in legs)
    gap, steps = first[0] - other[0], [np.diff(points, axis=0) for points in (first, other)]
    found: list[Array] = []
    most = _SAME_PLACE * posed.size
    for normal in (unit(gap), *np.eye(3)):
        mirrored = steps[1] - 2.0 * np.outer(steps[1] @ normal, normal)
        start = np.linalg.norm(gap - (gap @ normal) * normal)
        found.append(np.r_[start, np.linalg.norm(steps[0] - mirrored, axis=1)])
    return min(found, key=lambda gaps: (int((gaps > most).sum()), float(gaps.sum())))


def _lowest_pair(posed: PosedModel, up: Array) -> tuple[int, int] | None:
    heights = posed.points @ up
    leaves = _without_arms(posed)
    if not leaves:
        return None
    first = min(leaves, key=lambda j: float(heights[j]))
    near = _SAME_HEIGHT * posed.size
    level = [j for j in leaves if j != first and heights[j] - heights[first] < near]
    return (first, max(level, key=lambda j: _likeness(posed, first, j, up))) if level else None


def _without_arms(posed: PosedModel) -> list[int]:
    """Return the leaves that are not named as arms; all, where those are no two legs."""
    arms = [j for j in posed.leaves if _named_as_arm(posed, j)]
    apart = arms and _leg_like(posed, arms)
    return [j for j in posed.leaves if j not in arms] if apart else posed.leaves


def _named_as_arm(posed: PosedModel, end: int) -> bool:
    names = [str(posed.model.names[j]) for j in posed.model.supports[end] if j > 1]
    words = " ".join([*names, foot_name(posed.model, end)])
    return bool(_ARM_WORDS.search(words)) and not _LEG_WORDS.search(words)


def _no_arms(posed: PosedModel, ends: tuple[int, int], pair: LegPair) -> LegPair:
    """Return a pair of legs that was found.

    Raises:
        RobotError: it is named as arms, of a robot on wheels or a table.
    """
    if not all(_named_as_arm(posed, end) for end in ends):
        return pair
    raise RobotError(
        f"no two legs were found: the chains that reach lowest, to {_quoted(posed, ends)}, are "
        f"named as arms; {_NEEDS}; if these are, name their feet: {_NAME_FEET}"
    )


def _likeness(posed: PosedModel, first: int, other: int, up: Array) -> tuple[int, bool, float]:
    """Rank partners: few joints in common, as many of its own, beside rather than behind."""
    mine, its = own_chains(posed.model, (first, other))
    apart = _across(posed.points[mine[0]] - posed.points[its[0]], up)
    gap = _across(posed.points[first] - posed.points[other], up)
    sideways = abs(float(gap @ apart)) / (float(np.linalg.norm(gap) * np.linalg.norm(apart)) or 1.0)
    return len(mine), len(mine) == len(its), sideways


def _across(vector: Array, up: Array) -> Array:
    return np.asarray(vector - (vector @ up) * up)


def _side_by_side(posed: PosedModel, ends: tuple[int, int]) -> bool:
    """Tell whether two chains run the same way, as legs do and spread arms do not."""
    starts = [chain[0] for chain in own_chains(posed.model, ends)]
    spans = np.linalg.norm(posed.points[list(ends)] - posed.points[starts], axis=1)
    return bool(np.linalg.norm(_downwards(posed, ends)) > _DOWNWARDS * spans.mean())


def _downwards(posed: PosedModel, ends: tuple[int, int]) -> Array:
    """From between the hips to between the ankles [m], shape (3,)."""
    starts = [chain[0] for chain in own_chains(posed.model, ends)]
    return np.asarray(posed.points[list(ends)].mean(axis=0) - posed.points[starts].mean(axis=0))


def _hangs(posed: PosedModel, ends: tuple[int, int], up: Array) -> bool:
    if not all(own_chains(posed.model, ends)):  # one carries the other, or is the root
        return False
    down = _downwards(posed, ends)
    return bool(-(down @ up) > _DOWNWARDS * np.linalg.norm(down) > 0.0)


def _checked(posed: PosedModel, ends: tuple[int, int], up: Array, *, trim: bool) -> LegPair:
    legs, beyond = own_chains(posed.model, ends), list[int]()
    for leg in legs:
        while trim and len(leg) > min(LEG_LENGTHS) and _is_toe(posed, leg, up):
            beyond.append(leg.pop())
    for leg, other in (legs, legs[::-1]):
        toes = [j for j in beyond if leg and leg[-1] in posed.model.supports[j]]
        _check_leg(posed, leg, toes, up)
        if len(leg) < len(other) in LEG_LENGTHS:
            raise RobotError(f"{_chain_words(posed.model, leg, toes)}; the other has {len(other)}")
    if trim and len(legs[0]) != LEG_LENGTHS[0] and (fingers := _as_fingers(posed, ends)):
        raise RobotError(f"the chains to {_quoted(posed, ends)} {fingers}, as fingers do")
    return LegPair((tuple(legs[0]), tuple(legs[1])), up, tuple(beyond))


def _is_toe(posed: PosedModel, leg: list[int], up: Array) -> bool:
    """Tell whether the last joint of a leg bends the toes."""
    # Its line is nearly parallel to that of one of the two before it, and passes it at a level
    # distance, not below it as the ankle passes the knee. In a leg that has six joints without it
    # the distance may slope, if it is short as a foot is; in one that has four it must be so short.
    axis = posed.axes[leg[-1]]
    span = float(np.linalg.norm(posed.points[leg[-1]] - posed.points[leg[0]]))
    for joint in leg[-3:-1]:
        if np.linalg.norm(np.cross(posed.axes[joint], axis)) < _TOE_PARALLEL:
            gap = posed.points[leg[-1]] - posed.points[joint]
            gap = gap - (gap @ axis) * axis
            ahead, below = float(np.linalg.norm(_across(gap, up))), abs(float(gap @ up))
            short = bool(np.linalg.norm(gap) < _FOOT * span)
            slope = _TOE_SLOPE if len(leg) > LEG_LENGTHS[0] and short else 1.0
            least = max(_TOE * span, slope * below)
            return ahead > least and (short or len(leg) >= LEG_LENGTHS[0])
    return False


def _chain_words(model: pin.Model, leg: list[int], toes: list[int]) -> str:
    end = foot_name(model, leg[-1]) if leg else "the root"
    names = ", ".join(str(model.names[j]) for j in leg) or "none"
    more = f", beyond them the toes: {', '.join(model.names[j] for j in toes)}" if toes else ""
    return (
        f"the chain that ends in '{end}' has {len(leg)} joints of its own; gaitopt needs {_LEGS}; "
        f"its joints: {names}{more}"
    )


def _check_leg(posed: PosedModel, leg: list[int], toes: list[int], up: Array) -> None:
    if len(leg) not in LEG_LENGTHS:
        raise RobotError(_chain_words(posed.model, leg, toes))
    for joint in leg:
        problem = posed.problem(joint, UNDRIVEN)
        if posed.finger(joint):
            problem = posed.problem(joint, ("tied",))
        if problem is not None:
            raise RobotError(f"{problem}; gaitopt needs {_LEGS}")
        kind = joint_kind(posed.model.joints[joint])
        if kind != "revolute":
            name = posed.model.names[joint]
            fix = "; if it stands still, make it fixed" if kind == "prismatic" else ""
            raise RobotError(f"joint '{name}' is {kind}; gaitopt needs {_LEGS}{fix}")
    if len(leg) != LEG_LENGTHS[0] and (missing := _essential_joints_missing(posed, leg, up)):
        names = ", ".join(str(posed.model.names[j]) for j in leg)
        lacks = " and ".join(_MISSING.get(name, f"no {name} joint") for name in missing)
        raise RobotError(
            f"the chain that ends in '{foot_name(posed.model, leg[-1])}' cannot put a foot flat at "
            f"a step: it has {lacks}; its joints: {names}"
        )


def _essential_joints_missing(posed: PosedModel, leg: Sequence[int], up: Array) -> list[str]:
    """Return which joints a chain lacks to put a foot flat at a step, sideways along its knee."""
    points, axes = posed.points[list(leg)], posed.axes[list(leg)]
    knee = axes[len(hip_and_ankle(points, axes)[0])]
    side = unit(_across(knee, up))
    rotation = np.column_stack([np.cross(side, up), side, up])
    missing = missing_joints(points @ rotation, axes @ rotation)
    if abs(float(knee @ side)) < _LEVEL:
        return ["knee"]
    rolls = ["hip roll", "ankle roll"]
    return [name for name in missing if name in NEEDED_JOINTS or set(rolls) <= {*missing, name}]


def no_up(posed: PosedModel, legs: LegJoints) -> RobotError:
    """Return the error for two mirrored chains of which it cannot be told how they stand."""
    return RobotError(
        f"no two legs were found that hang along an axis of the root link; the chains of "
        f"{number_word(len(legs[0]))} joints to {_quoted(posed, [leg[-1] for leg in legs])} mirror "
        "each other, but no soles show which way is up for them; if they are the legs, say so: up "
        "= [X, Y, Z] in the file for --choices (in Python, up), or name the feet: " + _NAME_FEET
    )


def _no_pair(posed: PosedModel) -> RobotError:
    """Return the error for a robot of which no two chains hang like legs."""
    found = f"no two legs were found: {_chains(posed)}; "
    if len(posed.leaves) < 2:
        remedy = _too_light(posed) or "give a robot that has them"
        return RobotError(f"{found}{_NEEDS}; {remedy}")
    legs = _candidates(posed, ())
    if not legs:
        return _unequal(posed) or RobotError(f"{found}{_NEEDS}, and no two of them are such legs")
    return _unequal(posed) or RobotError(
        f"{found}no two chains of joints end side by side below everything else at the "
        f"reference posture; {_NEEDS}, as the chains to {legs} are; if it is a biped, say where "
        f'its head is (up: an axis of the root link, as "y", or three numbers) or name the feet: '
        f"{_NAME_FEET}"
    )


def no_legs(posed: PosedModel, ends: tuple[int, int], fault: RobotError) -> RobotError:
    """Return the error for a robot whose lowest pair of chains, by their ends, may be no legs."""
    names = _quoted(posed, ends)
    if fingers := _as_fingers(posed, ends):
        return _unequal(posed) or RobotError(
            f"no two legs were found: {_chains(posed)}; those that reach lowest, to {names}, "
            f"{fingers}, as fingers do; {_NEEDS}{_others(posed, ends)}"
        )
    return _unequal(posed) or RobotError(
        f"{fault}; the chains to {names} were taken for legs, as they reach lowest; if they are "
        f"arms, the robot shows no legs{_others(posed, ends)}"
    )


def _as_fingers(posed: PosedModel, ends: tuple[int, int]) -> str:
    """Return what the ends of two chains have in common with fingers, empty if nothing."""
    if any(posed.problem(j, ("mimic", "tied")) is not None for j in ends):
        return "follow other joints (<mimic>)"
    shared = _shared(posed, ends)
    return f"share {shared} joints" if shared > _MOST_SHARED else ""


def _many_legs(posed: PosedModel, ends: tuple[int, int], up: Array) -> RobotError | None:
    """Return the error for a robot that stands on more than two chains of joints, if it does."""
    heights = posed.points @ up
    ground = min(heights[j] for j in ends) + _SAME_HEIGHT * posed.size
    low = [j for j in _without_arms(posed) if heights[j] < ground]
    count = len(own_joints(posed.model, *ends))
    feet = [leg[-1] for leg in branches(posed.model, low) if len(leg) == count]
    if len(feet) < 3 or _shared(posed, low) > _MOST_SHARED:
        return None
    names = ", ".join(f"'{foot_name(posed.model, foot)}'" for foot in feet)
    return RobotError(
        f"no two legs were found: {number_word(len(feet))} chains of {joint_count(count)} each "
        f"reach equally low, down to {names}; {_NEEDS}; if two of them are, name its feet: "
        f"{_NAME_FEET}"
    )


def _too_light(posed: PosedModel) -> str:
    """Advice where there are chains enough, but what they carry is next to nothing."""
    model = posed.model
    if sum(len(model.children[j]) == 0 for j in range(2, model.njoints)) < 2:
        return ""
    mass = sum(float(body.mass) for body in model.inertias)
    heaviest = max(range(1, model.njoints), key=lambda j: float(model.inertias[j].mass))
    body = "the trunk" if heaviest == 1 else f"the body moved by joint '{model.names[heaviest]}'"
    return (
        f"legs carry mass, but of {mass:.4g} kg, {float(model.inertias[heaviest].mass):.4g} kg of "
        f"it {body}, the chains here have less than {100 * LEAST_MASS:g} %; correct the masses "
        "(kg) of the file"
    )


def _quoted(posed: PosedModel, ends: Collection[int]) -> str:
    return " and ".join(f"'{foot_name(posed.model, j)}'" for j in ends)


def _others(posed: PosedModel, ends: Collection[int]) -> str:
    """Advice to name the feet, where the robot has other chains that may be its legs."""
    legs = _candidates(posed, ends)
    more = f"; if its legs are the chains to {legs} or others, name its feet: {_NAME_FEET}"
    return more if legs else ""


def _candidates(posed: PosedModel, but: Collection[int]) -> str:
    """Ends of two chains that may be legs, but for some; empty if none are."""
    return next((_quoted(posed, (a[-1], b[-1])) for a, b in _leg_like(posed, but)), "")


def _shared(posed: PosedModel, ends: Collection[int]) -> int:
    """How many joints carry all of some joints."""
    return len(set.intersection(*(set(posed.model.supports[j]) for j in ends)) - {0, 1})


def _unequal(posed: PosedModel) -> RobotError | None:
    pair = _unequal_pair(posed)
    if pair is None:
        return None
    first, other = (str(posed.model.names[leg[pair.row]]) for leg in pair.legs)
    ends = json.dumps([foot_name(posed.model, leg[-1]) for leg in pair.legs], ensure_ascii=False)
    if pair.bent:
        angles = [posed.angle(leg[pair.row]) for leg in pair.legs]
        return RobotError(
            f"the reference posture bends the legs unequally: '{first}' stands at {angles[0]:.4g} "
            f"rad, its partner '{other}' at {angles[1]:.4g} rad; give both legs mirrored angles "
            "with flat feet (posture)"
        )
    away = f"lies {pair.size * 1e3:.1f} mm away from the mirror image of '{other}'"
    if pair.row > 0:
        before = [str(posed.model.names[leg[pair.row - 1]]) for leg in pair.legs]
        away += f", each seen from the joint before it ('{before[0]}' and '{before[1]}')"
    return RobotError(
        f"the legs are not mirror images: '{first}' {away}; correct the <origin> of one of them, "
        f"or of a joint above it; or if they are to be averaged, name the feet: feet = {ends} in "
        "the file for --choices (in Python, feet), and be told how large an asymmetry to choose"
    )


def _chains(posed: PosedModel) -> str:
    """How many chains of joints there are, and where the longest end."""
    model = posed.model
    leaves = [j for j in range(2, model.njoints) if len(model.children[j]) == 0]
    if not leaves:
        return "no joint moves"
    lengths = {j: len(model.supports[j]) - 2 for j in leaves}
    most = max(lengths.values())
    longest = [j for j in leaves if lengths[j] == most]
    names = _quoted(posed, longest[:2])
    if len(leaves) == 1:
        return f"one chain of {joint_count(most)}, which ends in {names}"
    more = f" and {len(longest) - 2} more" if len(longest) > 2 else ""
    ends = "ends" if len(longest) == 1 else "end"
    count = number_word(len(leaves))
    return f"{count} chains, the longest, of {joint_count(most)}, {ends} in {names}{more}"
