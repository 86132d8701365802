"""Placements of pelvis and swing foot in double support as chains of virtual joints (Fig. 2).

Each target is a product of elementary displacements whose amounts are linear in the geometric
quantities. Such a product is a serial chain, so its twists and their curvature follow the same
formulas as those of a leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from gaitopt.gait.parameters import (
    FOOT_SPACING,
    FOOT_YAW,
    GEOMETRY,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    PELVIS_ROLL,
    PELVIS_YAW,
    STEP_LENGTH,
    TRUNK_PITCH,
)
from gaitopt.nlp import Array

_X, _Y, _Z = np.eye(3)
_ZERO = np.zeros(3)


@dataclass(frozen=True)
class Displacement:
    """A translation along, or a rotation about, a fixed axis of the frame before it.

    Attributes:
        axis: unit vector, shape (3,).
        turns: True for a rotation.
        quantity: row of the geometry table that drives it.
        factor: amount of displacement per unit of that quantity.
    """

    axis: Array
    turns: bool
    quantity: int
    factor: float = 1.0

    @cached_property
    def twist(self) -> Array:
        """Its unit motion, linear part first, shape (6,)."""
        return np.concatenate([_ZERO, self.axis] if self.turns else [self.axis, _ZERO])


PELVIS_CHAIN = (
    Displacement(_X, False, PELVIS_FORWARD),
    Displacement(_Y, False, PELVIS_LATERAL),
    Displacement(_Z, False, PELVIS_HEIGHT),
    Displacement(_Z, True, PELVIS_YAW),
    Displacement(_Y, True, TRUNK_PITCH),
    Displacement(_X, True, PELVIS_ROLL),
)
"""Pelvis in the stance sole frame: translation, then yaw, pitch, roll."""

SWING_SOLE_CHAIN = (
    Displacement(_Z, True, FOOT_YAW, 0.5),
    Displacement(_X, False, STEP_LENGTH, -1.0),
    Displacement(_Y, False, FOOT_SPACING),
    Displacement(_Z, True, FOOT_YAW, 0.5),
)
"""Swing sole in the stance sole frame at the start of the step.

Half of the foot yaw before the offset and half after makes the direction of travel the bisector of
the two feet, so that step length and spacing keep their meaning with feet turned out.
"""


def place(chain: tuple[Displacement, ...], geometry: Array) -> tuple[pin.SE3, Array]:
    """Return the placement and the world axes of its displacements, shape (k, 6).

    Args:
        chain: displacements from the stance sole outwards.
        geometry: the geometric quantities, shape (10,).
    """
    placement = pin.SE3.Identity()
    axes = np.empty((len(chain), 6))
    for row, joint in zip(axes, chain, strict=True):
        row[:] = placement.toActionMatrix() @ joint.twist
        amount = joint.factor * float(geometry[joint.quantity])
        placement = placement * pin.exp6(amount * joint.twist)
    return placement, axes


def drive(chain: tuple[Displacement, ...]) -> Array:
    """Return the matrix from geometric quantities to displacements, shape (k, 10)."""
    matrix = np.zeros((len(chain), len(GEOMETRY)))
    for row, joint in enumerate(chain):
        matrix[row, joint.quantity] = joint.factor
    return matrix
