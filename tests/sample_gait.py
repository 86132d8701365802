"""A real gait from the independent reference solution, for tests of everything that shows gaits."""

import functools
from dataclasses import replace

import numpy as np
import pinocchio as pin
from places import REFERENCE

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task, task_record

CASE = "p43_v1.0_optimum"
_LEG = ("ankle_roll", "ankle_pitch", "knee", "hip_pitch", "hip_roll", "hip_yaw")
JOINT_NAMES = tuple(f"right_{n}" for n in _LEG) + tuple(f"left_{n}" for n in reversed(_LEG))
# In the pelvis-rooted URDF the stance leg's joints turn the other of their two links.
URDF_SIGNS = np.repeat([-1.0, 1.0], 6)
KNOTS = np.array([0.0, 0.4 / 3.0, 0.8 / 3.0, 0.4])


def exchange() -> np.ndarray:
    """E of the biped in URDF signs: joint 13 - i, minus for roll and yaw, plus for pitch."""
    pitch = [("pitch" in n) or ("knee" in n) for n in JOINT_NAMES]
    return np.fliplr(np.diag(np.where(pitch, 1.0, -1.0)))


@functools.cache
def sample_gait(case: str = CASE) -> Gait:
    """The reference optimum at 1.0 m/s as a gait file would hold it."""
    with np.load(REFERENCE) as content:
        ref = {k.split("/")[1]: content[k] for k in content.files if k.startswith(case + "/")}
    urdf = urdf_text(biped13())
    return Gait(
        time=ref["time"],
        **{n: ref[n] * URDF_SIGNS for n in ("q", "dq", "ddq", "torque", "rate_before")},
        ground_wrench=ref["ground_wrench"],
        cop=ref["cop"],
        swing_sole=ref["swing_sole"],
        knots=KNOTS,
        impulse=ref["impulse"],
        rate_after=ref["velocity_after"][6:] * URDF_SIGNS,
        parameters=ref["parameters"],
        parameter_names=tuple(f"p{i}" for i in range(len(ref["parameters"]))),
        joint_names=JOINT_NAMES,
        mirror=exchange(),
        urdf=urdf,
        stance_sole="right_sole",
        swing_sole_frame="left_sole",
        meta=_meta(float(ref["speed"]), float(ref["cost"]), urdf),
    )


def bare_gait() -> Gait:
    """The same gait with nothing recorded about it."""
    return replace(sample_gait(), meta={})


def _meta(speed: float, cost: float, urdf: str) -> dict[str, object]:
    model = pin.buildModelFromXML(urdf, pin.JointModelFreeFlyer())
    joints = [model.joints[model.getJointId(n)] for n in JOINT_NAMES]
    return {
        "task": task_record(Task(speed=speed, duration=0.4)),
        "limits": {
            "torque": [150.0] * 12,
            "speed": [10.0] * 12,
            "lower": [float(model.lowerPositionLimit[j.idx_q]) for j in joints],
            "upper": [float(model.upperPositionLimit[j.idx_q]) for j in joints],
        },
        "sole": {"toe": 0.0, "heel": -0.214, "left": 0.068, "right": -0.068},
        "cost": cost,
        "mass": float(pin.computeTotalMass(model)),
        "status": "optimal: the first-order conditions hold",
        "certificate": {"verdict": "optimal to first order, verified", "certified": True},
        "versions": {"gaitopt": "0.1.0"},
    }
