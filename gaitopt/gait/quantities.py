"""The quantities of a step that constraints and costs read: names, units, frames, shapes.

Each is an array with one row per instant (or one per leg, or a single one) and one column per
entry: `step.read(quantities.TORQUE)` has shape (instants, joints).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, there_are
from gaitopt.nlp import Array

if TYPE_CHECKING:
    from gaitopt.model.robot import Robot

_XYZ = ("x", "y", "z")
_WRENCH = tuple(f"{kind} {axis}" for kind in ("force", "moment") for axis in _XYZ)
CORNER_NAMES = ("toe left", "toe right", "heel left", "heel right")


@dataclass(frozen=True, eq=False)
class Quantity:
    """Something of a step that has a value at every x, with exact derivatives.

    Attributes:
        name: as `quantity` finds it.
        unit: of all entries, or of the first and the last half of them, "N, N·m".
        frame: in which it is expressed, or what it is of.
        entries: names of the columns; empty where the robot decides, see `labels`.
        rows: names of the rows; empty where there is one per instant.
        optional: whether it is computed only if a constraint reads it.
    """

    name: str
    unit: str
    frame: str
    entries: tuple[str, ...] = ()
    rows: tuple[str, ...] = ()
    optional: bool = False

    def __repr__(self) -> str:
        """Return name and unit."""
        return f"<Quantity {self.name} [{self.unit}]>"

    def __reduce__(self) -> tuple[object, tuple[str]]:
        """Pickle by name: a quantity is a single object."""
        return quantity, (self.name,)

    def labels(self, robot: Robot) -> tuple[str, ...]:
        """Return the names of its columns for a robot."""
        if self in BODY_GAPS:
            from gaitopt.mechanics.capsule_distance import arm_pairs, leg_pairs

            return (leg_pairs if self is LEG_GAPS else arm_pairs)(robot).names
        return self.entries or robot.joint_names


TORQUE = Quantity("torque", "N·m", "joints")
ANGLES = Quantity("angles", "rad", "joints")
RATES = Quantity("rates", "rad/s", "joints")
ACCELERATIONS = Quantity("accelerations", "rad/s²", "joints")
WRENCH = Quantity(
    "wrench", "N, N·m", "footprint of the stance sole: of the ground on the foot", _WRENCH
)
CORNERS = Quantity(
    "corners", "m", "stance sole: corners of the swing sole",
    tuple(f"{corner} {axis}" for corner in CORNER_NAMES for axis in _XYZ),
)  # fmt: skip
TRUNK = Quantity(
    "trunk", "rad", "direction of travel: attitude of the pelvis frame",
    ("roll", "pitch", "yaw"), optional=True,
)  # fmt: skip
FOOT_TURN = Quantity(
    "foot_turn", "rad, rad/s, rad/s²",
    "stance foot: about the line of it that rests; no entries where none of its phases turns it",
    ("angle", "rate", "acceleration"),
)  # fmt: skip
LEG_GAPS = Quantity("leg_gaps", "m", "distances of the capsules of the legs", optional=True)
ARM_GAPS = Quantity(
    "arm_gaps", "m", "distances of the capsules of moving arms from others", optional=True
)
BODY_GAPS = (LEG_GAPS, ARM_GAPS)
PEAK = Quantity(
    "peak", "N·m", "what the torques stay below at every instant, a parameter; see `PeakTorque`",
    ("peak torque",), optional=True,
)  # fmt: skip
FRONT_WRENCH = Quantity(
    "front_wrench", "N, N·m",
    "front sole while both feet stand: of the ground on the foot; no entries in other walks",
    _WRENCH,
)  # fmt: skip
IMPULSE = Quantity(
    "impulse", "N·s, N·m·s", "landing sole: of the ground on the foot", _WRENCH, ("",)
)
REAR_IMPULSE = Quantity(
    "rear_impulse", "N·s, N·m·s",
    "standing sole: of the ground on the foot, at an impact after which both stand or by which it "
    "comes to lie flat; no entries in other walks", _WRENCH, ("",),
)  # fmt: skip
SOLE_TWIST = Quantity(
    "sole_twist", "m/s, rad/s", "footprint of the old stance sole, after the impact",
    tuple(f"{kind} {axis}" for kind in ("velocity", "rate") for axis in _XYZ), ("",),
)  # fmt: skip
LEGS = Quantity(
    "legs", "m", "from ankle to hip in double support", _XYZ, ("stance leg", "swing leg")
)
GAPS = Quantity(
    "gaps", "m, 1", "what the lifted form has to close", _WRENCH, ("pelvis", "swing sole")
)
TRAVEL = Quantity(
    "travel", "m, s", "the step, or the path of a stride of two", ("step length", "duration"), ("",)
)
ADVANCE = Quantity(
    "advance", "m, m, s, m",
    "a step of a stride, on the average, and its first one; no entries where all are alike",
    ("forward", "left", "duration", "first forward"), ("",),
)  # fmt: skip

ALL = (
    TORQUE, WRENCH, CORNERS, ANGLES, RATES, ACCELERATIONS, IMPULSE, SOLE_TWIST, LEGS, GAPS, TRAVEL,
    TRUNK, LEG_GAPS, ARM_GAPS, FOOT_TURN, PEAK, FRONT_WRENCH, REAR_IMPULSE, ADVANCE,
)  # fmt: skip


def quantity(name: str) -> Quantity:
    """Return the quantity of a name.

    Raises:
        InputError: there is none.
    """
    for one in ALL:
        if one.name == name:
            return one
    raise InputError(f"there is no quantity '{name}'; {there_are((q.name for q in ALL), name)}")


def columns(
    reads: Sequence[Quantity], values: Mapping[Quantity, Array]
) -> list[tuple[Quantity, slice]]:
    """Return which columns each of several quantities, (N, e), has among all of them."""
    ends = np.cumsum([values[one].shape[1] for one in reads]).tolist()
    return [
        (one, slice(end - values[one].shape[1], end)) for one, end in zip(reads, ends, strict=True)
    ]


def typical_entries(one: Quantity, robot: Robot) -> Array:
    """Return the size of a quantity's entries in a good walk, (e,), by which costs are scaled.

    The torques' is such that their squares sum to (m g L)² / 200, as in a good walk of the
    thirteen-link biped; the others are of the order of a walk.
    """
    count = len(one.labels(robot))
    if one is TORQUE:
        weight = robot.mass * float(np.linalg.norm(robot.model.gravity.linear))
        return np.full(count, weight * robot.legs.reach / np.sqrt(_TYPICAL_EFFORT * count))
    if one in (WRENCH, FRONT_WRENCH):
        return np.full(count, robot.weight)
    if one is PEAK:
        return np.full(count, _TYPICAL_PEAK * robot.weight * robot.legs.reach)
    return np.full(count, robot.legs.reach if one.unit == "m" else 1.0)


_TYPICAL_PEAK = 0.1  # of m g L; the largest torque of a good walk
_TYPICAL_EFFORT = 200.0  # cost of a good walk in units of (m g L)² T / d / 200; measured
