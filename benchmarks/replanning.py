"""Replanning along random walks through speed and duration: how soon, and how late.

A sample of the plans is compared with a search from a first guess: the next walk of a branch may be
another optimum than the best one.

    python benchmarks/replanning.py [--steps 300] [--deadline 0.1]
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from common import arguments, save

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.replanner import ANSWERED, LATE, Replanner
from gaitopt.errors import GaitoptError
from gaitopt.gait.presets import preset_task

STRIDE = {"speed": 0.01, "duration": 0.005}
"""Of a step of the random walk, standard deviation: what a controller asks ten times a second."""
SPAN = {"speed": (0.7, 1.3), "duration": (0.85, 1.2)}
"""Of the quantities, in those of the first task."""
SEARCH = DesignOptions(refine=False, diagnose=False)
COMPARED = 25  # every so many plans


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--deadline", type=float, default=0.1)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    steps = 20 if asked.quick else asked.steps
    found = [
        walked("biped13", "standard", 1.0, steps, asked.deadline, asked.seed),
        walked("g1", "humanoid", 0.6, steps, asked.deadline, asked.seed),
    ]
    save("replanning", found, asked.quick)


def walked(
    name: str, preset: str, speed: float, steps: int, deadline: float, seed: int
) -> dict[str, object]:
    """Return how a robot was replanned along a random walk."""
    robot = robot_by_name(name)
    task = preset_task(preset, robot, speed=speed)
    rng, planner = np.random.default_rng(seed), Replanner()
    first = planner.replan(robot, task)
    assert first.answered
    now = {name: getattr(task, name) for name in STRIDE}
    start, seconds, outcomes, dearer = dict(now), [], [], []
    for number in range(steps):
        for quantity, stride in STRIDE.items():
            low, high = (share * start[quantity] for share in SPAN[quantity])
            now[quantity] = float(
                np.clip(now[quantity] + stride * rng.standard_normal(), low, high)
            )
        plan = planner.replan(robot, replace(task, **now), deadline=deadline)
        seconds.append(plan.seconds)
        outcomes.append(plan.outcome)
        if plan.answered and number % COMPARED == 0:
            try:
                known = design(
                    robot, plan.problem.task, DesignOptions(refine=False, diagnose=False)
                )
                dearer.append(plan.solution.cost / known.solution.cost - 1.0)
            except GaitoptError:
                continue
    return {
        "robot": name, "steps": steps, "deadline_s": deadline, "first_s": first.seconds,
        "answered": outcomes.count(ANSWERED), "late": outcomes.count(LATE),
        "seconds": {f"p{p}": float(np.percentile(seconds, p)) for p in (50, 90, 99, 100)},
        "dearer_than_a_search": {"median": float(np.median(dearer)), "worst": max(dearer)},
    }  # fmt: skip


if __name__ == "__main__":
    main()
