"""Limits of the joints, read from the URDF and compared between the legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array

_RANGE_TOLERANCE = 1e-6  # rad


@dataclass(frozen=True)
class JointLimits:
    """Limits of the twelve joints, in the order of `Robot.joint_names`, shape (12,) each.

    Attributes:
        torque: largest |torque| [N.m].
        speed: largest |rate| [rad/s].
        lower, upper: joint range [rad].
    """

    torque: Array
    speed: Array
    lower: Array
    upper: Array


def joint_limits(model: pin.Model, names: tuple[str, ...], mirror: Array) -> JointLimits:
    """Read the limits of a re-rooted model.

    Args:
        model: free-flyer and twelve joints.
        names: of the joints.
        mirror: the leg exchange E, shape (12, 12).

    Raises:
        RobotError: a limit is missing, or the two legs differ.
    """
    limits = JointLimits(
        torque=np.array(model.effortLimit[6:]),
        speed=np.array(model.velocityLimit[6:]),
        lower=np.array(model.lowerPositionLimit[7:]),
        upper=np.array(model.upperPositionLimit[7:]),
    )
    _check_ranges(names, limits, mirror)
    for field, unit in (("torque", "N.m"), ("speed", "rad/s")):
        values = getattr(limits, field)
        for name, value, other in zip(names, values, np.abs(mirror) @ values, strict=True):
            if not value > 0.0:
                raise RobotError(f"the {field} limit of '{name}' is {value} {unit}; it must be > 0")
            if value != other:
                raise RobotError(
                    f"the {field} limits of '{name}' and its partner in the other leg differ: "
                    f"{value} and {other} {unit}; make them equal in the URDF"
                )
    return limits


def _check_ranges(names: tuple[str, ...], limits: JointLimits, mirror: Array) -> None:
    """Refuse joint ranges that are not mirror images of each other."""
    swapped = mirror @ limits.lower, mirror @ limits.upper
    for row, name in enumerate(names):
        low, high = sorted((swapped[0][row], swapped[1][row]))
        if abs(low - limits.lower[row]) > _RANGE_TOLERANCE or (
            abs(high - limits.upper[row]) > _RANGE_TOLERANCE
        ):
            raise RobotError(
                f"the range of '{name}', {limits.lower[row]:g} to {limits.upper[row]:g} rad, is "
                f"not the mirror image of its partner's, which mirrors to {low:g} to {high:g} rad; "
                "make the ranges of the two legs mirror images in the URDF"
            )
