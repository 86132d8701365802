"""Arms, waist and other joints beside the legs that are to move: which ones, and in what pairs.

Partners are found by effect: a joint's partner sits on the partner of its body, has the mirrored
line and moves the mirror image of what it moves. A joint in the middle is its own partner.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError, did_you_mean
from gaitopt.importers.physics import Tie, tied_to
from gaitopt.model.import_options import matching
from gaitopt.model.kinematic_tree import (
    LOOP,
    UNDRIVEN,
    LegJoints,
    PosedModel,
    joint_kind,
    line_gap,
    pose_model,
    subtree_centres,
)
from gaitopt.model.scales import REACH
from gaitopt.nlp import Array

ARMS, WAIST = "arms", "waist"
"""Names of groups of joints, beside patterns of joint names."""

_APART = 0.05  # m below legs of 0.6 m, and sine of the angle: lines of a nearly symmetric file

Pairs = tuple[tuple[int, int], ...]


def _groups(posed: PosedModel, legs: LegJoints, rotation: Array) -> dict[str, list[int]]:
    """Return the joints of arms and of the waist, from the pelvis on."""
    # The arms are the longest mirrored pair of branches beside the legs, up to the first fork (the
    # hand), the right one first; the waist is between pelvis and trunk.
    model, partners = posed.model, _partners(posed, legs, rotation)
    middle = {1, *(joint for joint, partner in partners.items() if joint == partner)}
    starts = [
        _right_first(posed, rotation, (joint, partner))
        for joint, partner in partners.items()
        if joint < partner
        and int(model.parents[joint]) in middle
        and joint not in {*legs[0], *legs[1]}
    ]
    arms: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())
    for right, left in starts:
        both = list(zip(_unforked(posed, right), _unforked(posed, left), strict=False))
        if len(both) > len(arms[0]):
            arms = (tuple(a for a, _ in both), tuple(b for _, b in both))
    if not arms[0]:
        return {ARMS: [], WAIST: []}
    pelvis, trunk = (
        list(model.supports[int(model.parents[start])]) for start in (legs[0][0], arms[0][0])
    )
    # From the pelvis towards the root, then from there to the trunk.
    inward = [int(j) for j in pelvis if j not in trunk][::-1]
    waist = [*inward, *(int(j) for j in trunk if j not in pelvis)]
    return {ARMS: [*arms[0], *arms[1]], WAIST: waist}


def moving_pairs(
    posed: PosedModel,
    legs: LegJoints,
    rotation: Array,
    patterns: Sequence[str],
    ties: Mapping[str, Tie],
    loaded: Collection[int],
) -> tuple[Pairs, dict[str, str]]:
    """Return the joints beside the legs that are to move, those that move others first.

    What leads a joint that moves, or follows one, moves too, but for what follows and cannot, or
    moves no mass: names of those come second, with the reason. Each pair is the right and the left
    one, or one in the middle twice.

    Args:
        rotation: as of `Heading`.
        patterns: "arms", "waist", or patterns of joint names as in a shell; a joint's partner moves
            with it.
        loaded: joints of the links on which loads hang.

    Raises:
        RobotError: nothing matches, or a joint has no mirror image or no motor.
    """
    model, asked = posed.model, _asked(posed, legs, rotation, patterns)
    q = posed.q.copy()
    q[[model.joints[j].idx_q for j in asked if model.joints[j].nq == 1]] = 0.0
    partners = _partners(pose_model(model, q, posed.problems), legs, rotation)
    pairs = set()
    for joint in asked:
        if fault := _fault(posed, joint, partners):
            advice = "" if joint in partners else "; leave it locked, or make the robot symmetric"
            raise RobotError(f"joint '{model.names[joint]}' cannot be moved: {fault}{advice}")
        pairs.add((joint, partners[joint]))
    left = dict[str, str]()
    while True:
        moving = {str(model.names[j]) for joints in (*legs, *pairs) for j in joints}
        more = {name: how for name, how in tied_to(ties, moving).items() if name not in left}
        if not more:
            break
        for name, how in more.items():
            joint = int(model.getJointId(name))
            fault = _fault(posed, joint, partners)
            both = joint, partners.get(joint, joint)  # of which no one can move without mass
            if how == "follows" and not (
                _moves_mass(model, joint) or all(_moves_mass(model, one, loaded) for one in both)
            ):
                fault = "it moves no mass"
            if not fault:
                pairs.add((joint, partners[joint]))
            elif how == "follows":
                left[name] = fault
            else:
                follower = next(n for n, tie in ties.items() if tie.master == name)
                raise RobotError(
                    f"joint '{follower}' follows '{name}', which cannot be moved: {fault}; leave "
                    "the ties out, so that every joint has its own motor: --without ties (in "
                    'Python and in the file for --choices without = ["ties"])'
                )
    found = {_right_first(posed, rotation, pair) for pair in pairs}
    return tuple(sorted(found, key=lambda pair: (len(model.supports[pair[0]]), pair))), left


def _fault(posed: PosedModel, joint: int, partners: Mapping[int, int]) -> str:
    """Return why a joint cannot be moved, empty if it can."""
    if (problem := posed.problem(joint, UNDRIVEN)) is not None:
        open_it = "; loops are closed in legs only (--without loops leaves them all open)"
        return f"{problem}{open_it if problem.kind == LOOP else ''}"
    if (kind := joint_kind(posed.model.joints[joint])) != "revolute":
        return f"it is {kind}"
    if joint not in partners:
        return "no joint mirrors it on the other side, and it is not its own mirror image"
    return ""


def _moves_mass(model: pin.Model, joint: int, loaded: Collection[int] = ()) -> bool:
    return any(model.inertias[j].mass or j in loaded for j in model.subtrees[joint])


def moving_joints(
    legs: LegJoints, stance: int, others: Pairs
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the joints that move, and the place of each one's partner among them, shape (n,) each.

    The stance leg from ankle to hip, the swing leg from hip to ankle, then the others.
    """
    joints = (*legs[stance][::-1], *legs[1 - stance])
    partner = dict(zip(joints, joints[::-1], strict=True))
    for first, second in others:
        partner[first], partner[second] = second, first
    joints = (*joints, *dict.fromkeys(j for pair in others for j in pair))
    return joints, tuple(joints.index(partner[j]) for j in joints)


def _asked(
    posed: PosedModel, legs: LegJoints, rotation: Array, patterns: Sequence[str]
) -> list[int]:
    model, used = posed.model, {j for leg in legs for j in leg}
    names = {str(model.names[j]): j for j in range(2, model.njoints) if j not in used}
    asked: list[int] = []
    for pattern in patterns:
        grouped = pattern in (ARMS, WAIST)
        found = _groups(posed, legs, rotation)[pattern] if grouped else []
        found = found or [names[name] for name in matching(pattern, names)]
        if not found:
            raise RobotError(
                f"moving: no joint beside the legs' is meant by '{pattern}'; "
                f"{did_you_mean(pattern, (ARMS, WAIST, *names))}give arms, waist or a pattern of "
                f"names; the joints are: {', '.join(names) or 'none'}"
            )
        asked += [j for j in found if j not in asked]
    return asked


def _right_first(posed: PosedModel, rotation: Array, pair: tuple[int, int]) -> tuple[int, int]:
    """Return a pair with that joint first that moves what is farther to the right."""
    lefts = subtree_centres(posed.model, posed.q)[list(pair)] @ rotation[:, 1]
    return pair if lefts[0] <= lefts[1] else pair[::-1]


def _unforked(posed: PosedModel, joint: int) -> list[int]:
    """Return the chain of driven revolute joints from one on, up to the first fork."""
    chain = []
    while joint_kind(posed.model.joints[joint]) == "revolute" and (
        posed.problem(joint, UNDRIVEN) is None
    ):
        chain.append(joint)
        children = [int(c) for c in posed.model.children[joint]]
        if len(children) != 1:
            break
        joint = children[0]
    return chain


def _partners(posed: PosedModel, legs: LegJoints, rotation: Array) -> dict[int, int]:
    """Return the partner of each joint that has one, in the mirror between the hips."""
    model, left = posed.model, rotation[:, 1]
    hip, ankle = posed.points[[legs[0][0], legs[0][-1]]]
    scale = float(np.linalg.norm(hip - ankle)) / REACH
    points = posed.points / scale
    middle = (points[legs[0][0]] + points[legs[1][0]]) @ left / 2.0
    partners = {1: 1}
    for right_joint, left_joint in zip(*legs, strict=True):
        partners[right_joint], partners[left_joint] = left_joint, right_joint
    centres = subtree_centres(model, posed.q) / scale
    mirror = np.eye(3) - 2.0 * np.outer(left, left)
    for joint in range(2, model.njoints):
        parent = int(model.parents[joint])
        if joint in partners or parent not in partners or not posed.axes[joint].any():
            continue
        image, axis = mirror @ points[joint] + 2.0 * middle * left, mirror @ posed.axes[joint]
        centre = mirror @ centres[joint] + 2.0 * middle * left
        found = []
        for other in range(2, model.njoints):
            if int(model.parents[other]) != partners[parent] or not posed.axes[other].any():
                continue
            if line_gap(image, axis, points[other], posed.axes[other]) < _APART:
                found.append((float(np.linalg.norm(centres[other] - centre)), other))
        if found:
            partners[joint] = min(found)[1]
    del partners[1]
    return {j: p for j, p in partners.items() if partners.get(p) == j}
