"""What arms that swing save: walks with all of the upper body locked, and with arms free.

python benchmarks/arms.py [--quick]

The table of docs/your-robot.md is made of it: it prints it. A walk whose upper body is locked bears
it for nothing, one with motors there pays for them: so the walks are designed twice, with all
torques counted, and with those of the legs alone, which are the same in both.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from common import arguments, save
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

ROBOTS = {"g1": 0.6, "talos": 0.5, "icub": 0.3}
"""Of the catalogue, and speed [m/s]."""
SLIGHT = 1e-3
"""Weight of the upper body's torques where those of the legs alone count."""
FREE = {"arms": ("arms",), "arms and waist": ("arms", "waist")}


def turning_moment(gait: Gait) -> float:
    """Return the peak moment of the ground about the vertical through the centre of pressure."""
    force, moment = gait.ground_wrench[:, :3], gait.ground_wrench[:, 3:]
    x, y = gait.cop.T
    return float(np.abs(moment[:, 2] - (x * force[:, 1] - y * force[:, 0])).max())


def same_walk(free: WalkProblem, locked: WalkProblem, x: Array) -> Array:
    """Return the start that a walk with arms locked is for the robot that moves them.

    At the impact arms are loose, so that it is not quite the same walk.
    """
    start = first_guess(free)
    at = {name: k for k, name in enumerate(free.layout.names)}
    start[[at[name] for name in locked.layout.names]] = x
    return start


def walks(name: str, quick: bool) -> list[dict[str, Any]]:
    """Return the walk with arms locked, then with arms and with arms and waist free."""
    speed = ROBOTS[name]
    source, choices = description(entry_by_name(name))
    locked = Robot.from_urdf(source, choices=choices)
    found = design_gait(locked, humanoid_task(locked, speed=speed))
    rows = [{"robot": name, "free": "nothing", **figures(found)}]
    for what, moving in list(FREE.items())[: 1 if quick else None]:
        robot = Robot.from_urdf(source, choices=replace(choices, moving=moving))
        problem = WalkProblem(robot, humanoid_task(robot, speed=speed))
        start = same_walk(problem, found.problem, found.solution.x)
        near = design(robot, problem.task, DesignOptions(approach="direct"), start=start)
        others = set(robot.joint_names) - set(locked.joint_names)
        cost = TorqueCost(weights=dict.fromkeys(sorted(others), SLIGHT))
        task = humanoid_task(robot, speed=speed, cost=cost)
        alone = design(robot, task, DesignOptions(approach="direct"), start=start)
        rows.append(
            {
                "robot": name,
                "free": what,
                "at start": problem.values(start).cost,
                **figures(near),
                "legs alone": alone.gait.cost,
                "verdict of legs alone": alone.certificate.verdict,
            }
        )
    return rows


def figures(found: Any) -> dict[str, Any]:
    """Return what is compared."""
    return {
        "joints": len(found.gait.joint_names),
        "cost": found.gait.cost,
        "moment": turning_moment(found.gait),
        "verdict": found.certificate.verdict,
    }


def text(data: list[dict[str, Any]]) -> str:
    """Return the table."""
    lines = []
    for row in data:
        start = f"{row['at start']:.0f}" if "at start" in row else "–"
        alone = row.get("legs alone", row["cost"])
        lines.append([
            row["robot"], row["free"], row["joints"], start, f"{row['cost']:.0f}",
            f"{row['moment']:.1f}", row["verdict"], f"{alone:.0f}",
            row.get("verdict of legs alone", row["verdict"]),
        ])  # fmt: skip
    head = ["robot", "free", "joints", "start, N²·m·s", "optimum, N²·m·s",
            "peak turning moment, N·m", "verdict", "legs alone, N²·m·s", "verdict"]  # fmt: skip
    return table(head, lines)


def main() -> None:
    """Design all walks, print the table and save it."""
    quick = arguments(__doc__).parse_args().quick
    with small_matrices():
        data = [row for name in list(ROBOTS)[: 1 if quick else None] for row in walks(name, quick)]
    print(text(data))
    save("arms", data, quick)


if __name__ == "__main__":
    main()
