"""MuJoCo's inverse dynamics beside the gait's own numbers, for every robot of the catalogue.

python benchmarks/second_engine.py [--quick]

The motion is the first guess of the robot's default walk: what is compared is mechanics, whatever
the walk. Both engines have the robot with left and right averaged; what that changed of the
file's own inertias is told beside.
"""

from __future__ import annotations

from typing import Any

import mujoco
import walks_section
from common import arguments, save

from gaitopt.catalogue.entries import catalogue, description
from gaitopt.design.process import small_matrices
from gaitopt.errors import GaitoptError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot
from gaitopt.simulate.second_engine import second_engine

INSTANTS = 61
QUICK = ("biped13", "g1", "talos")


def averaging(robot: Robot) -> str:
    """Return what averaging left and right changed, which both engines have alike."""
    told = [f.text for f in robot.findings if (f.topic, f.subject) == ("symmetry", "robot")]
    return told[0].split(";")[0] if told else "the same"


def compared(name: str, robot: Robot) -> dict[str, Any]:
    """Return the largest differences of the engines."""
    problem = WalkProblem(robot, preset_task("humanoid", robot))
    gait = gait_at(problem, first_guess(problem), {})
    found = second_engine(gait, INSTANTS)
    return {
        "robot": name,
        "joints": len(gait.joint_names),
        "torque": found.torque,
        "wrench": max(found.force, found.moment),
        "impact": max(found.rate_after, found.impulse),
        "agrees": found.agrees,
        "own_inertias": averaging(robot),
    }


def rows(quick: bool) -> list[dict[str, Any]]:
    """Return a row for every robot that is here."""
    found = []
    for entry in catalogue():
        if quick and entry.name not in QUICK:
            continue
        try:
            source, choices = description(entry)
            robot = Robot.from_urdf(source, choices=choices)
            found.append(compared(entry.name, robot))
        except GaitoptError as error:
            found.append({"robot": entry.name, "refused": str(error).splitlines()[0]})
    return found


def main(quick: bool) -> None:
    """Compare, print, save."""
    with small_matrices():
        found = rows(quick)
    print(f"MuJoCo {mujoco.__version__}\n\n{walks_section.second_engine(found)}")
    save("second_engine", found, quick)


if __name__ == "__main__":
    main(arguments(__doc__).parse_args().quick)
