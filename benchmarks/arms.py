"""What arms that swing save: walks with all of the upper body locked, and with arms free.

python benchmarks/arms.py [--quick]

The table of docs/your-robot.md is made of it: it prints it. A walk whose upper body is locked bears
it for nothing, one with motors there pays for them: the locked walk is therefore compared with the
torques that hold its joints. Walks of free arms are sought from the usual first guess and from the
locked walk; the cheaper one counts. The last columns are what more joints cost to compute.
"""

from __future__ import annotations

import itertools
import time
from dataclasses import replace
from typing import Any

import numpy as np
from common import BareSweep, arguments, interleaved, save
from scipy.integrate import simpson
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.mechanics.single_support import SingleSupport
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

ROBOTS = {"g1": 0.6, "talos": 0.5, "icub": 0.3}
"""Of the catalogue, and speed [m/s]."""
FREE = {"arms": ("arms",), "arms and waist": ("arms", "waist")}
POINTS, ROUNDS = 4, 40
DEARER = 0.5  # N²·m·s: by which the walk found from the locked one is another


def turning_moment(gait: Gait) -> float:
    """Return the peak moment of the ground about the vertical through the centre of pressure."""
    force, moment = gait.ground_wrench[:, :3], gait.ground_wrench[:, 3:]
    x, y = gait.cop.T
    return float(np.abs(moment[:, 2] - (x * force[:, 1] - y * force[:, 0])).max())


def same_walk(free: WalkProblem, locked: WalkProblem, x: Array) -> Array:
    """Return the start that a walk with arms locked is for the robot that moves them.

    At the impact arms are loose, so that it is not quite the same walk.
    """
    start = first_guess(free)  # arms at the posture in which they were locked
    at = {name: k for k, name in enumerate(free.layout.names)}
    start[[at[name] for name in locked.layout.names]] = x
    return start


def held_cost(robot: Robot, locked: Design) -> float:
    """Return the cost of a locked walk with the torques that hold what is locked [N²·m·s].

    Args:
        robot: the same with those joints free.
        locked: the walk.
    """
    problem = on_fine_grid(locked.problem)
    step = problem.step(locked.solution.x)
    body, count = robot.multibody, problem.grid.count
    motion = np.zeros((3, count, len(robot.joint_names)))
    motion[0] = body.posture[body.moving]
    motion[:, :, [robot.joint_names.index(n) for n in problem.robot.joint_names]] = step.motion
    torque = SingleSupport(robot, count).state(*motion).effort[:, 6:]
    times = step.duration * problem.grid.instants
    return float(simpson((torque**2).sum(axis=1), x=times) / step.step_length)


def computing(found: Design) -> dict[str, float]:
    """Return what evaluations of a walk at its samples cost, in bare sweeps."""
    problem, x = WalkProblem(found.problem.robot, found.problem.task), found.solution.x
    y = np.zeros(problem.rows.lower.size)
    y[problem.rows_of("torque")] = 1.0
    y[problem.rows_of("friction")] = 1.0
    rng = np.random.default_rng(0)
    nearby = [x + 1e-4 * rng.normal(size=x.size) for _ in range(POINTS)]
    first, second = (itertools.cycle(nearby[k:] + nearby[:k]) for k in (0, 2))

    def both() -> None:
        at = next(second)
        problem.point(at)
        problem.hessian(at, y, problem.cost_scale)

    parts = {"bare": BareSweep(problem, *nearby), "point": lambda: problem.point(next(first))}
    times = interleaved({**parts, "both": both}, ROUNDS)
    bare, point = times["bare"]["min"], times["point"]["min"]
    return {"point": point / bare, "hessian": (times["both"]["min"] - point) / bare}


def walks(name: str, quick: bool) -> list[dict[str, Any]]:
    """Return the walk with arms locked, then with arms and with arms and waist free."""
    speed = ROBOTS[name]
    source, choices = description(entry_by_name(name))
    locked = Robot.from_urdf(source, choices=choices)
    started = time.process_time()
    found = design_gait(locked, humanoid_task(locked, speed=speed))
    rows = [{"robot": name, "free": "nothing", **figures(found, started)}]
    for what, moving in list(FREE.items())[: 1 if quick else None]:
        robot = Robot.from_urdf(source, choices=replace(choices, moving=moving))
        task, direct = humanoid_task(robot, speed=speed), DesignOptions(approach="direct")
        start = same_walk(WalkProblem(robot, task), found.problem, found.solution.x)
        from_locked = design(robot, task, direct, start=start)
        started = time.process_time()
        cold = design(robot, task, direct)
        measured = figures(cold, started)
        best = min((from_locked, cold), key=lambda one: one.gait.cost)
        rows.append(
            {
                "robot": name,
                "free": what,
                "held": held_cost(robot, found),
                **measured,
                **walked(best),
                "from locked": from_locked.gait.cost,
                "moment from locked": turning_moment(from_locked.gait),
                "cold": cold.gait.cost,
            }
        )
    return rows


def walked(found: Design) -> dict[str, Any]:
    """Return what is compared of a walk."""
    return {
        "joints": len(found.gait.joint_names),
        "cost": found.gait.cost,
        "moment": turning_moment(found.gait),
        "verdict": found.certificate.verdict,
    }


def figures(found: Design, started: float) -> dict[str, Any]:
    """Return what is compared, and what it took from a time of the process's clock on [s]."""
    return walked(found) | {"cpu": time.process_time() - started} | computing(found)


def text(data: list[dict[str, Any]]) -> str:
    """Return the table."""
    lines = []
    for row in data:
        held = f"{row['held']:.0f}" if "held" in row else "–"
        moment = f"{row['moment']:.1f}"
        if row.get("from locked", row["cost"]) > row["cost"] + DEARER:
            moment += f" ({row['moment from locked']:.1f} at {row['from locked']:.0f})"
        lines.append([
            row["robot"], row["free"], row["joints"], held, f"{row['cost']:.0f}",
            moment, row["verdict"], f"{row['cpu']:.1f}", f"{row['point']:.1f}",
            f"{row['hessian']:.1f}",
        ])  # fmt: skip
    head = ["robot", "free", "joints", "locked and held, N²·m·s", "optimum, N²·m·s",
            "peak turning moment (from the locked walk), N·m", "verdict", "cold solve, CPU s",
            "derivatives, bare sweeps", "Hessian, bare sweeps"]  # fmt: skip
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
