"""How a robot stands: at rest, feet side by side, its weight over the middle of the soles."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.errors import InputError
from gaitopt.gait.double_support import PELVIS_CHAIN, SWING_SOLE_CHAIN, place
from gaitopt.gait.parameters import (
    FOOT_SPACING,
    FOOT_YAW,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    PELVIS_ROLL,
    PELVIS_YAW,
    STEP_LENGTH,
    TRUNK_PITCH,
)
from gaitopt.gait.transition_problem import Junction
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

STRETCH = 0.96
"""Distance of hip and ankle over the leg's length, unless a person says otherwise."""
_LEAST, _MOST = 0.5, 0.999
_ITERATIONS, _CENTRED = 50, 1e-13  # m


def standing(robot: Robot, walk: Array, stretch: float = STRETCH) -> Junction:
    """Return the state of a robot that stands as far apart with its feet as it walks.

    Upright, both legs alike, the feet turned out as in the walk, the centre of mass over the middle
    of the soles.

    Args:
        robot: the biped.
        walk: geometric quantities of a double support of its walk, shape (10,).
        stretch: distance of hip and ankle over the leg's length.

    Raises:
        InputError: the stretch is out of range, or the legs have fewer than six motors.
        UnreachableError: the legs cannot stand so.
    """
    if not _LEAST <= stretch <= _MOST:
        raise InputError(f"a stretch of {stretch:g} is none; give one from {_LEAST} to {_MOST}")
    if robot.tree.stance < TWIST or not robot.coupling.none:
        raise InputError(
            "a posture to stand in is found for legs of six joints or more that all have motors; "
            "give two gaits, or a robot with such legs"
        )
    geometry, sole = walk.copy(), robot.sole
    yaw = float(geometry[FOOT_YAW]) / 2.0  # of the pelvis, midway between the feet
    geometry[[STEP_LENGTH, TRUNK_PITCH, PELVIS_ROLL]] = 0.0
    geometry[PELVIS_YAW] = yaw
    aside = np.array([0.0, 0.5 * geometry[FOOT_SPACING], 0.0])
    middle = pin.SE3(pin.utils.rotate("z", yaw), np.zeros(3)) * pin.SE3(np.eye(3), aside)
    hips, mean = robot.legs.hips, robot.legs.hips.mean(axis=0)
    ankle = middle.actInv(robot.legs.ankles[0])
    centre = middle.actInv(
        np.array([0.5 * (sole.toe + sole.heel), 0.5 * (sole.left + sole.right), 0.0])
    )
    wide = ankle[1] - (hips[0] - mean)[1]
    kinematics, ahead = LegKinematics(robot), 0.0  # of the hips over the ankles
    for _ in range(_ITERATIONS):
        room = (stretch * robot.legs.reach) ** 2 - wide**2 - ahead**2
        hip = np.array([ankle[0] + ahead, 0.0, ankle[2] + np.sqrt(max(room, 0.0))])
        pelvis = middle.act(hip - mean)
        geometry[[PELVIS_FORWARD, PELVIS_LATERAL, PELVIS_HEIGHT]] = pelvis
        q = kinematics.solve(place(PELVIS_CHAIN, geometry)[0], place(SWING_SOLE_CHAIN, geometry)[0])
        off = float(centre[0] - middle.actInv(centre_of_mass(robot, q))[0])
        if abs(off) < _CENTRED:
            break
        ahead += off
    still = np.zeros(q.size)
    return Junction(geometry, q, still, still, rests=True)


def centre_of_mass(robot: Robot, q: Array) -> Array:
    """Return the centre of mass in the stance sole frame at joint angles q (n,) [m], shape (3,)."""
    whole = np.concatenate([pin.neutral(robot.model)[:7], robot.coupling.angles(q)])
    return np.array(pin.centerOfMass(robot.model, robot.model.createData(), whole))


def wrench_standing(robot: Robot) -> Array:
    """Return the wrench of the ground on the swing foot of a robot that stands, in its sole frame.

    Both feet press alike, straight down, in the middle of their soles, shape (6,).
    """
    sole, load = robot.sole, 0.5 * robot.weight
    x, y = 0.5 * (sole.toe + sole.heel), -0.5 * (sole.left + sole.right)  # of a mirror image
    return np.array([0.0, 0.0, load, load * y, -load * x, 0.0])
