"""Pairs of chains that are each other's mirror image, exactly or but for one fault."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from gaitopt.nlp import Array
from gaitopt.robot.legs.sides import partners_by_name
from gaitopt.robot.legs.tree import UNMOVED, Tree, all_revolute, own_joints, unit

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
