"""The physics of a robot as plain values, units in the keys: for gait files and summaries."""

from __future__ import annotations

import numpy as np

from gaitopt.model.import_options import matching
from gaitopt.model.robot import Robot

GRAVITY_KEY = "gravity_m_per_s2"


def physics_record(robot: Robot) -> dict[str, object]:
    """Return what counts beside the rigid bodies, and where it is from, as JSON can hold it.

    Keys of the result: gravity_m_per_s2 (down), gravity_from, carried_weight_N (from outside),
    without (parts that were left out) and joints: by name, what is not 0 of armature_kg_m2,
    damping and stiffness (coefficients of the first and higher powers; SI units), friction_Nm and
    rest_rad, and armature_from.
    """
    physics, carried = robot.physics, robot.physics.carried
    gravity = float(np.linalg.norm(physics.gravity))
    joints = {name: _joint(robot, row) for row, name in enumerate(robot.joint_names)}
    return {
        GRAVITY_KEY: gravity,
        "gravity_from": "file" if physics.gravity_stated else "standard",
        "carried_weight_N": 0.0 if carried is None else gravity * float(carried.mass.sum()),
        "without": list(robot.choices.without),
        "joints": {name: facts for name, facts in joints.items() if facts},
    }


def _joint(robot: Robot, row: int) -> dict[str, object]:
    passive, facts = robot.physics.passive, dict[str, object]()
    armature = float(robot.model.armature[6 + row])
    if armature:
        facts["armature_kg_m2"] = armature
        facts["armature_from"] = _origin(robot, robot.joint_names[row])
    if passive is not None:
        if passive.damping[row].any():
            facts["damping"] = passive.damping[row].tolist()
        if passive.friction[row]:
            facts["friction_Nm"] = float(passive.friction[row])
        if passive.stiffness[row].any():
            facts["stiffness"] = passive.stiffness[row].tolist()
            facts["rest_rad"] = float(passive.rest[row])
    return facts


def _origin(robot: Robot, joint: str) -> str:
    """Return who gave a joint its rotor inertia."""
    given = [
        entry
        for entry in robot.choices.limits
        if entry.armature is not None and joint in matching(entry.joints, robot.joint_names)
    ]
    return (given[-1].source or "chosen") if given else "file"
