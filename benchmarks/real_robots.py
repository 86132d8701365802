"""Humanoids of the catalogue: nine cold starts each, their fastest walk, and known results."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from common import arguments, reference_task, save, told

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.design import design, searched
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.process import small_matrices
from gaitopt.errors import GaitoptError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.sweep.speed_search import fastest

ROBOTS = ("talos", "g1", "alexander", "icub", "romeo", "simple_humanoid", "human")
FREE_SWING: dict[str, Any] = {"swing_height": None, "swing_tilt": None}
"""As the peers: without the habits of docs/habits.md."""
SIGMA, STARTS = 0.05, 9
SHARES = (0.5, 0.75)
"""Of the fastest speed, at which a gait is designed as well."""
FEASIBLE = 1e-4
"""Violation at which a run is called feasible, as the peer counts."""

# Known costs with these settings and no other bounds: robot, step [s], speed [m/s], sole, lowest
# knee angle [rad], cost of an independent solution.
KNOWN = (
    ("g1", 0.4, 0.75, Sole(0.12, -0.05, 0.03, -0.03), 0.106, 1055.85),
    ("talos", 0.7, 0.5, Sole(0.1, -0.1, 0.06, -0.06), 0.05, 1517.6),
    ("alexander", 0.6, 0.6, Sole(0.15, -0.05, 0.045, -0.045), -0.181, 2657.66),
)
ONE_DEGREE = 0.01745  # rad


RIGID = ("friction", "damping", "springs", "armature")
"""Left out here, as the independent solutions did: what of it costs how much is measured by
`physics.py`."""


def robot_of(name: str, **choices: object) -> Robot:
    """Return a robot of the catalogue, rigid bodies alone, with some choices of its own."""
    source, chosen = description(entry_by_name(name))
    return Robot.from_urdf(source, choices=chosen.over(**{"without": RIGID, **choices}))


def cold(robot: Robot, task: Task, count: int, approach: str = "automatic") -> list[dict[str, Any]]:
    """Solve from the first guess and from disturbed ones, on the task's samples."""
    runs, options = [], DesignOptions(diagnose=False, approach=approach)
    with small_matrices():
        problem = WalkProblem(robot, task)
        guess = first_guess(problem)
        for seed in range(count):
            x = perturbed(problem, guess, SIGMA, seed) if seed else guess
            runs.append(_timed(lambda x=x: searched(problem, Search(options), x)))
    return runs


def _timed(solve: Callable[[], Any]) -> dict[str, Any]:
    started = time.process_time()
    try:
        found = solve()
    except GaitoptError as error:
        return {"status": str(error), "cpu seconds": time.process_time() - started}
    feasible = [n for n, h in enumerate(found.history) if h.violation < FEASIBLE]
    return {
        **told(found),
        "feasible at": min(feasible, default=None),
        "cpu seconds": time.process_time() - started,
    }


def designed(robot: Robot, task: Task) -> dict[str, Any]:
    """Design a refined gait and say how it went."""
    started = time.process_time()
    try:
        found = design(robot, task)
    except GaitoptError as error:
        return {"speed": task.speed, "verdict": str(error)}
    return {
        "speed": task.speed,
        "duration": task.duration,
        "cost": found.gait.cost,
        "verdict": found.certificate.verdict,
        "iterations": found.solution.iterations,
        "cpu seconds": time.process_time() - started,
    }


def of_catalogue(name: str, count: int) -> dict[str, Any]:
    """Nine starts, and three speeds up to the fastest."""
    entry = entry_by_name(name)
    robot = robot_of(name)

    def task_at(speed: float) -> Task:
        return humanoid_task(robot, **{**entry.task, "speed": speed, **FREE_SWING})

    speed = float(entry.task["speed"])
    record: dict[str, Any] = {"robot": name, "mass": robot.mass, "speed": speed}
    record["starts"] = cold(robot, task_at(speed), count)
    record["direct"] = cold(robot, task_at(speed), count, "direct")
    try:
        best = fastest(robot, task_at, speed)
    except GaitoptError as error:
        return record | {"refused": str(error), "speeds": []}
    slower = [designed(robot, task_at(round(share * best.speed, 3))) for share in SHARES]
    top = {
        "speed": best.speed,
        "duration": best.design.gait.duration,
        "cost": best.design.gait.cost,
        "verdict": best.design.certificate.verdict,
        "iterations": best.design.solution.iterations,
    }
    return record | {"speeds": [*slower, top], "refused": best.refused, "binding": best.binding}


def known(count: int) -> list[dict[str, Any]]:
    """Solve the walks whose optimum another program has found."""
    records = []
    for name, duration, speed, sole, knee, cost in KNOWN:
        robot = robot_of(name, sole=sole)
        bend = float((robot.legs.flexion * (knee - robot.legs.straight)).max())
        task = bare_task(speed=speed, duration=duration, knee_flexion=bend)
        records.append({"robot": name, "known": cost, "starts": cold(robot, task, count)})
    return records


def bare_task(**changes: object) -> Task:
    """Return a task without trunk, width and clearance bounds, in the lifted form."""
    table = set_geometry(GEOMETRY, {"pelvis_yaw": {"free": False}})
    lifted: dict[str, object] = {"boundary": "lifted", "leg_extension": None, "geometry": table}
    return reference_task(**{**lifted, "impulse_cop": False, **changes})


def head_to_head(count: int) -> list[dict[str, Any]]:
    """The G1 example of RAPTOR: short, upright steps with level feet a fixed width apart."""
    records = []
    for sole in (Sole(0.05, -0.05, 0.015, -0.015), Sole(0.1, -0.1, 0.03, -0.03)):
        robot = robot_of("g1", sole=sole)
        width = {"foot_spacing": {"free": False, "value": 0.237}}
        upright = dict.fromkeys(("trunk_roll", "trunk_pitch", "trunk_yaw"), ONE_DEGREE)
        task = bare_task(
            speed=0.375, duration=0.4, clearance=0.05, swing_tilt=0.01, cop_margin=0.0,
            knee_flexion=0.05, geometry=set_geometry(GEOMETRY, width), **upright,
        )  # fmt: skip
        size = f"{sole.length:.2f} m x {sole.width:.2f} m"
        records.append({"sole": size, "starts": cold(robot, task, count)})
    return records


def main() -> None:
    quick = arguments(__doc__).parse_args()
    count = 2 if quick.quick else STARTS
    names = ROBOTS[:1] if quick.quick else ROBOTS
    data: dict[str, Any] = {"catalogue": [], "known": known(count)}
    data["head to head"] = head_to_head(count)
    for name in names:
        data["catalogue"].append(of_catalogue(name, count))
        last = data["catalogue"][-1]
        took = float(np.median([r["cpu seconds"] for r in last["starts"]]))
        print(f"{name}: {took:.2f} s CPU, {[s.get('speed') for s in last['speeds']]}", flush=True)
    save("real_robots", data, quick.quick)


if __name__ == "__main__":
    main()
