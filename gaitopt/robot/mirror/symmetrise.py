"""Make an almost symmetric robot exactly symmetric: a half step must be the mirror of the next.

Drawings and identified inertias differ a little from left to right. Bodies are averaged with the
mirror image of their partner in the ten dynamic parameters, in which the mean of two bodies that
can exist can exist too (Wensing, Kim and Slotine, 2018, IEEE RA-L 3(1), section III).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.legs.placed import joint_axes, place
from gaitopt.robot.mirror.symmetry import (
    LINE_TOLERANCE,
    REFLECTION,
    mirror_placement,
    mirrored_gap,
)

_EXACT = 1e-9  # m and rad: legs that are this much alike are left as they are
_SAME = 1e-12  # relative: bodies that are this much alike are left as they are
_LIGHT = 1e-3  # of the total mass: links lighter than this are measured against it
_MISSING = 1e-6  # an inertia this much smaller than its partner's was left out of the file


@dataclass(frozen=True)
class Difference:
    """How far a link is from the mirror image of its partner.

    Attributes:
        joint: name of the joint that moves the link, of the root's for the trunk.
        mass: [kg].
        shift: distance between the centres of mass [m].
        inertia: largest difference of an entry of the inertia about the centre of mass [kg·m²].
        relative: largest of the three: per mass, per radius of gyration, per largest inertia.
        kind: which of the three it is, in words.
    """

    joint: str
    mass: float
    shift: float
    inertia: float
    relative: float
    kind: str


@dataclass(frozen=True)
class Symmetrised:
    """A symmetric model and what it took.

    Attributes:
        model: the model, bodies and left leg changed where they had to be.
        gap: largest distance by which a left joint line was moved [m + rad].
        differences: of the bodies, worst first, those that were changed only.
        filled: joints whose links had no inertia in the file and took their partner's.
        mass_matrix: relative change of the mass matrix at the neutral posture.
    """

    model: pin.Model
    gap: float
    differences: tuple[Difference, ...]
    filled: tuple[str, ...]
    mass_matrix: float


@dataclass(frozen=True)
class Sides:
    """Where left and right are in a model of free-flyer and twelve joints.

    Attributes:
        right, left: joints from hip to ankle.
        soles: names of the right and the left sole frame.
        plane: placement of the pelvis frame in the root body; its x-z plane is the mirror.
    """

    right: tuple[int, ...]
    left: tuple[int, ...]
    soles: tuple[str, str]
    plane: pin.SE3


def symmetrise(model: pin.Model, sides: Sides, allowed: float) -> Symmetrised:
    """Return a copy of the model that is its own mirror image.

    Args:
        model: free-flyer and twelve joints, rooted at the pelvis.
        sides: its legs.
        allowed: largest relative difference of a body that may be averaged away.

    Raises:
        RobotError: the legs' joints or the bodies are not mirror images, even nearly.
    """
    even = model.copy()
    gap = _mirror_left_leg(even, sides)
    filled = _fill_missing(even, sides)
    before = pin.crba(even, even.createData(), pin.neutral(even)).copy()
    differences = _average_bodies(even, sides, allowed)
    after = pin.crba(even, even.createData(), pin.neutral(even))
    change = float(np.abs(after - before).max() / np.abs(after).max())
    return Symmetrised(even, gap, differences, filled, change)


def mirrored(inertia: pin.Inertia) -> pin.Inertia:
    """Return the mirror image of a body in the plane y = 0."""
    S = REFLECTION
    return pin.Inertia(inertia.mass, S @ inertia.lever, S @ inertia.inertia @ S)


def _local(model: pin.Model, sides: Sides) -> list[pin.SE3]:
    """Placements of the joints in the pelvis frame at the neutral posture."""
    return [sides.plane.actInv(p) for p in place(model, pin.neutral(model)).places]


def _mirror_left_leg(model: pin.Model, sides: Sides) -> float:
    """Put the joint lines of the left leg on the mirror images of the right ones."""
    local, q = _local(model, sides), pin.neutral(model)
    axes = np.zeros((model.njoints, 3))
    axes[2:] = joint_axes(model, q, range(2, model.njoints)) @ sides.plane.rotation
    worst = _check_lines(model, sides, local, axes)
    soles = [model.frames[model.getFrameId(name)] for name in sides.soles]
    target = mirror_placement(local[sides.right[5]] * soles[0].placement)
    off = (target.inverse() * local[sides.left[5]] * soles[1].placement).homogeneous
    sole_gap = float(np.abs(off - np.eye(4)).max())
    if sole_gap > LINE_TOLERANCE:
        raise RobotError(
            f"the sole frames '{sides.soles[0]}' and '{sides.soles[1]}' are not mirror images: "
            f"they differ by {sole_gap:.3g} (m or rad); allowed is {LINE_TOLERANCE:g}; "
            "both feet must be flat, and the legs alike, in the reference posture"
        )
    if max(worst, sole_gap) < _EXACT:
        return 0.0
    moved = {1: local[1]}
    for right, left in zip(sides.right, sides.left, strict=True):
        goal = REFLECTION @ local[right].translation, REFLECTION @ axes[right]
        moved[left] = _onto(local[left], axes[left], *goal)
        model.jointPlacements[left] = moved[model.parents[left]].actInv(moved[left])
    model.frames[model.getFrameId(sides.soles[1])].placement = moved[sides.left[5]].actInv(target)
    return max(worst, sole_gap)


def _check_lines(model: pin.Model, sides: Sides, local: list[pin.SE3], axes: Array) -> float:
    worst = 0.0
    points = np.array([place.translation for place in local])
    for right, left in zip(sides.right, sides.left, strict=True):
        worst = max(worst, mirrored_gap(points, axes, right, left, model.names))
    return worst


def _onto(place: pin.SE3, axis: Array, point: Array, goal: Array) -> pin.SE3:
    """Return the placement turned and shifted as little as puts its axis on a line."""
    goal = goal * np.sign(goal @ axis)
    turn = np.cross(axis, goal)
    shift = point - place.translation
    return pin.SE3(
        pin.exp3(turn) @ place.rotation, place.translation + shift - (shift @ goal) * goal
    )


def _seen(model: pin.Model, sides: Sides) -> list[tuple[int, int, pin.SE3, pin.SE3]]:
    """Pairs of bodies and their placements in the pelvis frame, the trunk with itself first."""
    local = _local(model, sides)
    pairs = [(1, 1), *zip(sides.right, sides.left, strict=True)]
    return [(i, j, local[i], local[j]) for i, j in pairs]


def _fill_missing(model: pin.Model, sides: Sides) -> tuple[str, ...]:
    filled = []
    for i, j, first, second in _seen(model, sides)[1:]:
        for to, there, from_, here in ((i, first, j, second), (j, second, i, first)):
            own, other = model.inertias[to], model.inertias[from_]
            if np.abs(own.inertia).max() < _MISSING * np.abs(other.inertia).max():
                image = there.actInv(mirrored(here.act(other)))
                model.inertias[to] = pin.Inertia(own.mass, own.lever, image.inertia)
                filled.append(str(model.names[to]))
    return tuple(filled)


def _average_bodies(model: pin.Model, sides: Sides, allowed: float) -> tuple[Difference, ...]:
    changes, differences = {}, []
    floor = _LIGHT * pin.computeTotalMass(model)
    for i, j, first, second in _seen(model, sides):
        own, image = first.act(model.inertias[i]), mirrored(second.act(model.inertias[j]))
        difference = _difference(str(model.names[j]), own, image, floor)
        if difference.relative > _SAME:
            differences.append(difference)
            mean = (own.toDynamicParameters() + image.toDynamicParameters()) / 2.0
            body = pin.Inertia.FromDynamicParameters(mean)
            changes[i], changes[j] = first.actInv(body), second.actInv(mirrored(body))
    differences.sort(key=lambda d: -d.relative)
    if differences and differences[0].relative > allowed:
        _refuse(model, differences[0], allowed)
    for joint, body in changes.items():
        model.inertias[joint] = body
    return tuple(differences)


def _difference(joint: str, own: pin.Inertia, image: pin.Inertia, floor: float) -> Difference:
    mass = abs(own.mass - image.mass)
    mean = (own.mass + image.mass) / 2.0
    shift = float(np.linalg.norm(own.lever - image.lever)) if mean > 0.0 else 0.0
    entry = float(np.abs(own.inertia - image.inertia).max())
    largest = max(float(np.abs(b.inertia).max()) for b in (own, image))
    size = np.sqrt(largest / mean) if mean > 0.0 and largest > 0.0 else 1.0
    weight = max(mean, floor)
    parts = {
        "mass": mass / weight,
        "centre of mass": shift * mean / (weight * size),
        "inertia": entry / max(largest, floor * size * size),
    }
    kind = max(parts, key=lambda k: parts[k])
    return Difference(joint, mass, shift, entry, float(parts[kind]), kind)


def _refuse(model: pin.Model, worst: Difference, allowed: float) -> None:
    where = "trunk" if worst.joint == model.names[1] else f"link moved by '{worst.joint}'"
    raise RobotError(
        f"the robot differs from its mirror image by {worst.relative:.3g} (relative, in the "
        f"{worst.kind} of the {where}: mass {worst.mass * 1e3:.4g} g, centre of mass "
        f"{worst.shift * 1e3:.4g} mm, inertia {worst.inertia:.3g} kg·m²); allowed is {allowed:g}. "
        "Make the two legs and the trunk symmetric in the URDF, or raise asymmetry in the file for "
        "--choices"
    )
