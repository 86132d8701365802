"""The independent solution of the reference problem, and how its conventions map to ours.

Angles of the file turn each link against the one before it in the chain from stance to swing foot;
in the URDF the stance leg hangs from the pelvis, so its six angles, rates and torques change sign.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np
from places import REFERENCE

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot

URDF_SIGNS = np.repeat([-1.0, 1.0], 6)
OPTIMA = tuple(f"p{n}_v{v}_optimum" for n in (43, 42) for v in ("0.8", "1.0", "1.2"))
INFEASIBLE = ("p43_v1.0_infeasible", "p42_v1.0_infeasible")
CASES = OPTIMA + INFEASIBLE


@dataclass(frozen=True)
class ReferenceCase:
    """One case of the file, as it is there; `at` gives ours."""

    name: str
    arrays: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    @property
    def parameter_signs(self) -> np.ndarray:
        """From the file's parameters to ours and back."""
        signs = np.ones(self["parameters"].size)
        signs[:36] = np.tile(URDF_SIGNS, 3)
        return signs

    @property
    def x(self) -> np.ndarray:
        """The parameters in the signs of the URDF."""
        return self["parameters"] * self.parameter_signs

    def problem(self, robot: Robot, **changes: object) -> WalkProblem:
        """The walk of this case; by default with the constraints that the file knows."""
        preset = "paper" if self.name.startswith("p42") else "standard"
        changes = {"joint_range": False, "impulse_cop": False, **changes}
        task = reference_task(preset, **changes)
        return WalkProblem(robot, replace(task, speed=float(self["speed"])))


def reference_task(preset: str = "standard", **changes: object) -> Task:
    """A walk without torsional friction, which neither the paper nor other solutions know."""
    return preset_task(preset, **{"torsional_friction": None, **changes})


@functools.cache
def reference_case(name: str) -> ReferenceCase:
    """One case by its name."""
    with np.load(REFERENCE) as content:
        arrays = {
            key.split("/")[1]: content[key] for key in content.files if key.startswith(name + "/")
        }
    return ReferenceCase(name, arrays)


@functools.cache
def biped(stance: str = "right") -> Robot:
    """The biped of the paper's Tables 1 and 2 on one of its feet."""
    swing = {"right": "left", "left": "right"}[stance]
    return Robot.from_urdf(
        urdf_text(biped13()), stance_sole=f"{stance}_sole", swing_sole=f"{swing}_sole"
    )
