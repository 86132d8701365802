"""Why a robot has no two legs to walk on: what there is instead, and what helps."""

from __future__ import annotations

import json
from collections.abc import Collection
from itertools import combinations

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.legs.alike import unequal_pair
from gaitopt.robot.legs.tree import (
    LIGHT,
    UNMOVED,
    Tree,
    all_revolute,
    branches,
    foot_name,
    own_joints,
)

SAME_HEIGHT = 0.02  # m: feet of a standing robot may differ by this much at its reference posture
NAME_FEET = 'feet = ["RIGHT", "LEFT"] in the file for --choices (in Python, feet)'

_NUMBERS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six"}
_WAIST = 4  # joints: chains that share more branch off a hand, not off a pelvis
_NEEDS = "gaitopt walks on two legs of six revolute joints each"
_SIX = 6


def no_pair(tree: Tree) -> RobotError:
    """Return the error for a robot of which no two chains hang like legs."""
    found = f"no two legs were found: {_chains(tree)}"
    if len(tree.leaves) < 2:
        remedy = _too_light(tree) or "give a robot that has them"
        return RobotError(f"{found}; {_NEEDS}; {remedy}")
    legs = _six_jointed(tree, ())
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
    legs = _six_jointed(tree, ends)
    if legs is None:
        return ""
    return f"; if its legs are the chains to {legs} or others, name its feet: {NAME_FEET}"


def _six_jointed(tree: Tree, but: Collection[int]) -> str | None:
    """Ends of two chains of six driven revolute joints each, but for some; None if none are."""
    for pair in combinations([j for j in tree.leaves if j not in but], 2):
        legs = [own_joints(tree.model, *ends) for ends in (pair, pair[::-1])]
        driven = [j for leg in legs for j in leg if tree.problem(j, UNMOVED) is None]
        six = [len(leg) for leg in legs] == [_SIX, _SIX] and len(driven) == 2 * _SIX
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
