"""The task that a real humanoid is given unless told otherwise: sized by it, and human-looking.

Without bounds on trunk and step width the least effort is a waddle that no motor controller would
follow; they, and the gaps that keep the legs whole, are on by default here.
"""

from __future__ import annotations

import math

import numpy as np

from gaitopt.gait.constraints import Margins
from gaitopt.gait.task import Task, preset_task
from gaitopt.mechanics.forward_kinematics import turning_arm
from gaitopt.model.robot import Robot

FROUDE = 0.05  # V² / (g h) of a stroll; people change to a run near 0.5 (Alexander, 1989)
TRUNK = {"trunk_roll": 0.15, "trunk_pitch": 0.2, "trunk_yaw": 0.2}  # rad; people stay within
KNEE_FLEXION = 0.1  # rad
LEG_GAP = 0.01  # m
WIDER = 0.03  # m by which the feet may stand farther apart than the hips
LEAST_LOAD = 0.05  # of the weight


def humanoid_task(robot: Robot, **changes: object) -> Task:
    """Return the default task of a robot, with some fields changed.

    Speed and step duration follow from the leg length (dynamic similarity), the margins from
    weight and sole; the double support is lifted.

    Args:
        robot: the biped.
        changes: fields of `Task` and of `Margins`.

    Raises:
        InputError: an unknown field, or a value out of range.
    """
    speed = changes.get("speed") or stroll(robot)
    defaults: dict[str, object] = {"boundary": "lifted", "leg_extension": None, "speed": speed}
    if isinstance(speed, float | int) and speed > 0.0:
        defaults["duration"] = round(robot.legs.natural_step(float(speed)) / float(speed), 2)
    friction = changes.get("friction", Margins().friction)
    if isinstance(friction, float | int):
        sole = robot.sole
        arm = turning_arm(sole.toe - sole.heel, sole.left - sole.right)
        defaults["torsional_friction"] = round(float(friction) * arm, 4)
    defaults |= {**TRUNK, "knee_flexion": KNEE_FLEXION, "leg_gap": LEG_GAP}
    defaults["minimum_load"] = round(LEAST_LOAD * robot.weight, 1)
    gap = changes.get("lateral_gap", Margins().lateral_gap)
    if isinstance(gap, float | int):
        defaults["step_width"] = widest(robot, gap)
    return preset_task("standard", **{**defaults, **changes})


def stroll(robot: Robot) -> float:
    """Return the speed of an easy walk [m/s], to two digits: that of the Froude number 0.05."""
    gravity = float(np.linalg.norm(robot.model.gravity.linear))
    return round(math.sqrt(FROUDE * gravity * robot.legs.height), 2)


def widest(robot: Robot, gap: float = Margins.lateral_gap) -> float:
    """Return how far apart the lines of footsteps may be [m]: a little more than they must.

    Args:
        robot: the biped.
        gap: that must be left between the soles [m].
    """
    soles = robot.sole.left - robot.sole.right + gap
    return round(max(abs(robot.legs.spacing), soles) + WIDER, 3)
