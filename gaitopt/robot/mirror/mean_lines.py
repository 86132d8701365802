"""Two legs made mirror images of each other: each pair of joint lines meets in the middle.

From the hip down, a joint's line is compared with the mirror image of its partner's as it lies once
the joints before it are mirror images: what the hip is off is not told again of the knee. Both are
then moved half the way, each with all that hangs on it. Lines count, not the origins that may slide
along them or the angle at which a joint frame stands about its own axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.legs.placed import joint_axes, place
from gaitopt.robot.mirror.symmetry import REFLECTION, mirror_placement

_EXACT = 1e-12  # m and rad: legs that are this much alike are left as they are


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

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Right and left joints, from hip to ankle."""
        return list(zip(self.right, self.left, strict=True))


@dataclass(frozen=True)
class LineGap:
    """How far a joint's line is from the mirror image of its partner's.

    Attributes:
        joints: the right and the left one; those of the ankles' last joints for the soles.
        sole: whether it is the soles that differ.
        apart: distance [m].
        turn: angle [rad].
    """

    joints: tuple[int, int]
    sole: bool
    apart: float
    turn: float


def mirror_lines(model: pin.Model, sides: Sides) -> tuple[LineGap, ...]:
    """Make the legs of a model mirror images; tell how far each pair of lines was off.

    Args:
        model: free-flyer and twelve joints, rooted at the pelvis. Joint placements and sole frames
            are changed where they have to be.
        sides: its legs.

    Returns:
        The six pairs of joints from the hip, and the soles.
    """
    q = pin.neutral(model)
    local = [sides.plane.actInv(p) for p in place(model, q).places]
    axes = np.zeros((model.njoints, 3))
    axes[2:] = joint_axes(model, q, range(2, model.njoints)) @ sides.plane.rotation
    moved = {1: local[1]}
    carried = [pin.SE3.Identity(), pin.SE3.Identity()]  # what became of what hangs on either leg
    gaps = []
    for pair in sides.pairs:
        places = [C * local[j] for C, j in zip(carried, pair, strict=True)]
        lines = [C.rotation @ axes[j] for C, j in zip(carried, pair, strict=True)]
        points = [places[0].translation, REFLECTION @ places[1].translation]
        ahead = [lines[0], REFLECTION @ lines[1]]
        point, axis, apart, turn = _mean_line(points, ahead)
        gaps.append(LineGap(pair, False, apart, turn))
        goals = ((point, axis), (REFLECTION @ point, REFLECTION @ axis))
        for side, joint in enumerate(pair):
            moved[joint] = onto_line(places[side], lines[side], *goals[side])
            carried[side] = moved[joint] * local[joint].inverse()
    frames = [model.getFrameId(name) for name in sides.soles]
    ankles = sides.right[-1], sides.left[-1]
    soles = [moved[j] * model.frames[f].placement for j, f in zip(ankles, frames, strict=True)]
    mean, apart, turn = _mean_placement(soles[0], mirror_placement(soles[1]))
    gaps.append(LineGap(ankles, True, apart, turn))
    if max(max(gap.apart, gap.turn) for gap in gaps) > _EXACT:
        for joint in (*sides.right, *sides.left):
            model.jointPlacements[joint] = moved[model.parents[joint]].actInv(moved[joint])
        model.frames[frames[0]].placement = moved[ankles[0]].actInv(mean)
        model.frames[frames[1]].placement = moved[ankles[1]].actInv(mirror_placement(mean))
    return tuple(gaps)


def onto_line(placement: pin.SE3, axis: Array, point: Array, goal: Array) -> pin.SE3:
    """Return the placement turned and shifted as little as puts its axis on a line.

    Args:
        placement: of a joint.
        axis: its axis in the same frame, shape (3,).
        point, goal: a point on and the direction of the line, shape (3,) each.
    """
    goal = goal if goal @ axis >= 0.0 else -goal
    cross = np.cross(axis, goal)
    sine = float(np.linalg.norm(cross))
    angle = float(np.arctan2(sine, axis @ goal))
    turn = cross / sine * angle if sine > 0.0 else np.zeros(3)
    shift = point - placement.translation
    return pin.SE3(
        pin.exp3(turn) @ placement.rotation,
        placement.translation + shift - (shift @ goal) * goal,
    )


def _mean_line(points: list[Array], axes: list[Array]) -> tuple[Array, Array, float, float]:
    """Return point and direction of the line between two, their distance and their angle.

    The distance is that between the points where they cross the plane square to the mean
    direction through the middle of the two origins: the same whichever leg is called the first.
    """
    first, other = axes[0], axes[1] if axes[0] @ axes[1] >= 0.0 else -axes[1]
    axis = first + other
    axis = axis / np.linalg.norm(axis)
    middle = (points[0] + points[1]) / 2.0
    crossings = [
        p + ((middle - p) @ axis) / float(a @ axis) * a
        for p, a in zip(points, (first, other), strict=True)
    ]
    apart = float(np.linalg.norm(crossings[0] - crossings[1]))
    turn = float(np.arctan2(np.linalg.norm(np.cross(first, other)), first @ other))
    return (crossings[0] + crossings[1]) / 2.0, axis, apart, turn


def _mean_placement(first: pin.SE3, other: pin.SE3) -> tuple[pin.SE3, float, float]:
    turn = pin.log3(first.rotation.T @ other.rotation)
    rotation = first.rotation @ pin.exp3(turn / 2.0)
    apart = float(np.linalg.norm(first.translation - other.translation))
    mean = pin.SE3(rotation, (first.translation + other.translation) / 2.0)
    return mean, apart, float(np.linalg.norm(turn))
