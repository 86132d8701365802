"""A robot in one posture: the lines of its leg joints, and how it stands."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.feet.shape import FootShape
from gaitopt.robot.legs.heading import LegLines
from gaitopt.robot.legs.joint_points import joint_lines_of
from gaitopt.robot.legs.measures import centre
from gaitopt.robot.legs.stance import Stance

_NEARLY_FLAT = 0.05  # rad

Legs = tuple[tuple[int, ...], tuple[int, ...]]


@dataclass(frozen=True)
class Placed:
    """A model in one posture, its root at the origin.

    Attributes:
        model: free-flyer and joints.
        q: its configuration, shape (nq,).
        places: placements of its joints in the root link.
    """

    model: pin.Model
    q: Array
    places: list[pin.SE3]

    @cached_property
    def lines(self) -> tuple[Array, Array]:
        """A point and the axis of each joint in the root link; see `joint_lines_of`."""
        return joint_lines_of(self.model, self.q)


def place(model: pin.Model, q: Array) -> Placed:
    """Return the model in a posture."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    return Placed(model, q, [placement.copy() for placement in data.oMi])


def joint_axes(model: pin.Model, q: Array, joints: Iterable[int]) -> Array:
    """Return the unit axes of revolute joints in the world, shape (n, 3).

    Args:
        model: of the robot.
        q: its configuration, shape (nq,).
        joints: ids of n joints.
    """
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    columns = [(j, model.joints[j].idx_v) for j in joints]
    return np.array(
        [pin.getJointJacobian(model, data, j, pin.LOCAL_WORLD_ALIGNED)[3:, v] for j, v in columns]
    )


def legs_at_zero(placed: Placed, legs: Legs) -> Placed:
    """Return the same posture with all leg angles 0."""
    q = placed.q.copy()
    q[[placed.model.joints[j].idx_q for leg in legs for j in leg]] = 0.0
    return place(placed.model, q)


def parallel_feet(first: Placed, second: Placed, legs: Legs) -> bool:
    """Tell whether the feet are flat in both postures, if they are in one.

    Poses in files are rounded and not quite symmetric; with all leg angles 0 the feet are exact.
    """
    for leg in legs:
        turn = first.places[leg[-1]].rotation.T @ second.places[leg[-1]].rotation
        if np.linalg.norm(pin.log3(turn)) > _NEARLY_FLAT:
            return False
    return True


def leg_lines(placed: Placed, leg: tuple[int, ...], shape: FootShape | None = None) -> LegLines:
    """Return the joint lines of a leg in the root link.

    Args:
        placed: the robot.
        leg: joints from hip to ankle.
        shape: of its foot, if known.
    """
    model = placed.model
    rows = [model.joints[joint].idx_q for joint in leg]
    ankle = placed.places[leg[-1]]
    return LegLines(
        points=placed.lines[0][list(leg)],
        axes=placed.lines[1][list(leg)],
        angles=placed.q[rows],
        lower=np.array(model.lowerPositionLimit)[rows],
        upper=np.array(model.upperPositionLimit)[rows],
        foot=None if shape is None else shape.points @ ankle.rotation.T + ankle.translation,
    )


def stance_of(placed: Placed, legs: Legs, rotation: Array) -> Stance:
    """Return the robot in its own axes, with their origin between the hips.

    Args:
        placed: the robot.
        legs: the right and the left one, joints from hip to ankle.
        rotation: columns forward, left, up in the root link, shape (3, 3).
    """
    lines = [leg_lines(placed, leg) for leg in legs]
    pelvis = pin.SE3(rotation, (lines[0].hip + lines[1].hip) / 2.0)
    # The ankles' centres are those of `Legs`: on the pitch axes, where the axes do not meet.
    centres = [centre(line.points @ rotation, line.axes @ rotation, (4, 5)) for line in lines]
    return Stance(
        model=placed.model,
        feet=(legs[0][-1], legs[1][-1]),
        places=(
            pelvis.actInv(placed.places[legs[0][-1]]),
            pelvis.actInv(placed.places[legs[1][-1]]),
        ),
        ankles=np.array([pelvis.actInv(rotation @ point) for point in centres]),
    )
