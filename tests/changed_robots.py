"""Robots with any of their numbers changed, as derivatives in these know them."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from gaitopt.model.chain_physics import PassiveJoints
from gaitopt.model.joint_tree import FIRST
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole


def changed(robot: Robot, moved: dict[str, np.ndarray], amount: float) -> Robot:
    """The robot with every part moved by an amount: parts of `ModelGradient`, or of a change."""
    model, n = pin.Model(robot.model), robot.tree.size
    got = {name: amount * values for name, values in moved.items()}
    for body in range(n + 1):
        mass, first, second = moments(model.inertias[body + 1])
        if "mass" in got:
            mass += got["mass"][body]
            first = first + got["first"][body]
            second = second + got["second"][body]
        lever = first / mass
        about = second - mass * np.outer(lever, lever)
        inertia = np.trace(about) * np.eye(3) - about
        model.inertias[body + 1] = pin.Inertia(mass, lever, inertia)
    legs = robot.legs
    if "joints" in got:
        for joint in range(n):
            place = model.jointPlacements[FIRST + joint].copy()
            place.translation = place.translation + got["joints"][joint]
            model.jointPlacements[FIRST + joint] = place
        for frame, name in ((robot.swing_frame, "swing_sole"), (robot.pelvis_frame, "pelvis")):
            place = model.frames[frame].placement.copy()
            place.translation = place.translation + got[name]
            model.frames[frame].placement = place
        legs = replace(legs, hips=legs.hips + got["hips"], ankles=legs.ankles + got["ankles"])
    if "armature" in got:
        model.armature = np.array(model.armature) + np.append(np.zeros(6), got["armature"])
    if "gravity" in got:
        model.gravity = pin.Motion(model.gravity.linear + got["gravity"], np.zeros(3))
    if "straight" in got:
        longer = got["reach"]
        legs = replace(
            legs, straight=legs.straight + got["straight"], reach=legs.reach + longer,
            bound=legs.bound + longer,
        )  # fmt: skip
    sole, physics = robot.sole, robot.physics
    if "sole" in got:
        edges = np.array([sole.toe, sole.heel, sole.left, sole.right]) + got["sole"]
        sole = Sole(*map(float, edges))
    if "damping" in got:
        own = physics.passive or PassiveJoints(
            np.zeros((n, 1)), np.zeros(n), np.zeros((n, 1)), np.zeros(n)
        )
        damping = np.column_stack([own.damping[:, 0] + got["damping"], own.damping[:, 1:]])
        passive = replace(own, damping=damping, friction=own.friction + got["friction"])
        physics = replace(physics, passive=passive)
    return replace(robot, model=model, legs=legs, sole=sole, physics=physics)


def moments(inertia: pin.Inertia) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, first and second moments about the frame's origin."""
    second = 0.5 * np.trace(inertia.inertia) * np.eye(3) - inertia.inertia
    second = second + inertia.mass * np.outer(inertia.lever, inertia.lever)
    return inertia.mass, inertia.mass * inertia.lever, second
