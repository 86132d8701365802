"""A hundred random certified walks looked at 5001 instants: is "certified" true in between?

Robots, tasks and numbers of samples are drawn at random; what is certified is evaluated at equally
spaced instants that have nothing to do with those of the certificate.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common import arguments, reference_task, robot_of, save
from random_bipeds import random_case
from real_robots import robot_of as catalogue_robot

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.errors import GaitoptError
from gaitopt.gait.grid import Grid
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, violations

WALKS = 100
INSTANTS = 5001
SAMPLES = (5, 7, 11, 15, 21, 31, 41, 61, 101)
NAMED = ("g1", "talos", "icub", "alexander", "romeo")
SWITCHES: tuple[dict[str, float], ...] = (
    {},
    {},
    {"trunk_pitch": 0.15, "trunk_yaw": 0.1},
    {"torsional_friction": 0.05},
    {"swing_tilt": 0.3, "leg_gap": 0.01},
    {"friction": 0.4},
    {"clearance": 0.05, "lateral_gap": 0.02},
)


def random_walk(seed: int) -> tuple[str, Robot, Task]:
    """Return the name of a robot, the robot and a task for it."""
    rng = np.random.default_rng([7, seed])
    samples, postures = int(rng.choice(SAMPLES)), int(rng.choice((1, 2, 2, 2, 3)))
    postures = min(postures, max(1, (samples - 3) // 2))
    more: dict[str, Any] = {"samples": samples, "postures": postures}
    kind = int(rng.integers(4))
    if kind == 3:
        name = str(rng.choice(NAMED))
        robot = catalogue_robot(name)
        task = humanoid_task(robot)
        return (
            name,
            robot,
            humanoid_task(robot, speed=float(rng.uniform(0.5, 1.0)) * task.speed, **more),
        )
    more |= SWITCHES[int(rng.integers(len(SWITCHES)))]
    if kind == 0:
        return "biped13", robot_of(), reference_task(speed=float(rng.uniform(0.3, 1.2)), **more)
    spec, speed, _ = random_case(int(rng.integers(10_000)))
    return "random biped", robot_of(spec), reference_task(speed=speed, **more)


def worst_at(problem: WalkProblem, x: Array, count: int = INSTANTS) -> tuple[float, str]:
    """Return the largest scaled violation at equally spaced instants, and which row it is."""
    s = np.linspace(0.0, 1.0, count)
    dense = problem.with_grid(Grid(s, np.ones(count), count))
    excess = violations(dense.rows.lower, dense.rows.upper, dense.values(x).rows)
    row = int(np.argmax(excess))
    return float(excess[row]), dense.describe(row)


def run(seed: int) -> dict[str, Any]:
    """Design one walk and look at it closely."""
    record: dict[str, Any] = {"seed": seed, "outcome": "refused"}
    started = time.process_time()
    try:
        name, robot, task = random_walk(seed)
        record |= {"robot": name, "speed": task.speed, "samples": task.samples}
        with small_matrices():
            found = design(robot, task, DesignOptions(diagnose=False))
    except GaitoptError as error:
        return record | {"reason": str(error)[:200]}
    excess, row = worst_at(found.problem, found.solution.x)
    certificate = found.certificate
    return record | {
        "outcome": "certified" if certificate.certified else "not certified",
        "reason": certificate.verdict[:200],
        "postures": task.postures,
        "violation": excess,
        "row": row,
        "told": certificate.worst.violation,
        "resolution": certificate.resolution,
        "cost": found.solution.cost,
        "iterations": found.solution.iterations,
        "seconds": time.process_time() - started,
    }


def main() -> None:
    """Draw walks until enough of them are certified."""
    quick = arguments(__doc__).parse_args().quick
    walks = 5 if quick else WALKS
    records: list[dict[str, Any]] = []
    while sum(r["outcome"] == "certified" for r in records) < walks and len(records) < 4 * walks:
        records.append(run(len(records)))
        print(records[-1], flush=True)
    certified = [r for r in records if r["outcome"] == "certified"]
    excess = [r["violation"] for r in certified]
    save(
        "proof",
        {
            "instants": INSTANTS,
            "records": records,
            "certified": len(certified),
            "worst": max(excess),
            "median": float(np.median(excess)),
            "told": max(r["told"] for r in certified),
        },
        quick,
    )


if __name__ == "__main__":
    main()
