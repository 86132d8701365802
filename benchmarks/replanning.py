"""Replanning along random walks through speed, duration and width: how soon, and how late.

A sample of the plans is compared with a search from a first guess: the next walk of a branch may be
another optimum than the best one.

    python benchmarks/replanning.py [--steps 300] [--deadline 0.1]
"""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from common import arguments, save

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.replanner import ANSWERED, LATE, Replanner
from gaitopt.errors import GaitoptError
from gaitopt.gait.parameters import FOOT_SPACING
from gaitopt.gait.presets import preset_task
from gaitopt.gait.task import Task

STRIDE = {"speed": 0.01, "duration": 0.005, "width": 0.005}
"""Of a step of the random walk, standard deviation: what a controller asks ten times a second."""
SPAN = {"speed": (0.7, 1.3), "duration": (0.85, 1.2), "width": (0.8, 1.2)}
"""Of the quantities, in those of the first task."""
SEARCH = DesignOptions(refine=False, diagnose=False)
COMPARED = 25  # every so many plans that are answered, from the first on


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--deadline", type=float, default=0.1)
    parser.add_argument("--seed", type=int, default=0)
    words = parser.parse_args()
    steps = 20 if words.quick else words.steps
    found = [
        walked("biped13", "standard", 1.0, steps, words.deadline, words.seed),
        walked("g1", "humanoid", 0.6, steps, words.deadline, words.seed),
    ]
    save("replanning", found, words.quick)


def asked(task: Task, now: dict[str, float]) -> Task:
    """Return a task of a speed, a duration and a distance of the feet sideways."""
    width = replace(task.geometry[FOOT_SPACING], free=False, value=now["width"])
    geometry = (*task.geometry[:FOOT_SPACING], width, *task.geometry[FOOT_SPACING + 1 :])
    margins = replace(task.margins, step_width=None)  # the width is asked for
    return replace(
        task, speed=now["speed"], duration=now["duration"], geometry=geometry, margins=margins
    )


def walked(
    name: str, preset: str, speed: float, steps: int, deadline: float, seed: int
) -> dict[str, object]:
    """Return how a robot was replanned along a random walk."""
    robot = robot_by_name(name)
    task = preset_task(preset, robot, speed=speed)
    rng, planner = np.random.default_rng(seed), Replanner()
    first = planner.replan(robot, task)
    assert first.answered
    gait = first.gait()
    own = dict(zip(gait.parameter_names, gait.parameters, strict=True))
    now = {"speed": task.speed, "duration": task.duration, "width": own["foot_spacing"]}
    assert planner.replan(robot, asked(task, now)).answered  # a program of one parameter fewer
    start, seconds, outcomes, dearer = dict(now), [], [], []
    late_in_a_row = longest = 0
    for _ in range(steps):
        for quantity, stride in STRIDE.items():
            low, high = sorted(share * start[quantity] for share in SPAN[quantity])
            now[quantity] = float(
                np.clip(now[quantity] + stride * rng.standard_normal(), low, high)
            )
        plan = planner.replan(robot, asked(task, now), deadline=deadline)
        seconds.append(plan.seconds)
        outcomes.append(plan.outcome)
        late_in_a_row = 0 if plan.answered else late_in_a_row + 1
        longest = max(longest, late_in_a_row)
        if plan.answered and outcomes.count(ANSWERED) % COMPARED == 1:
            try:
                known = design(robot, plan.problem.task, SEARCH)
                dearer.append(plan.solution.cost / known.solution.cost - 1.0)
            except GaitoptError:
                continue
    return {
        "robot": name, "steps": steps, "deadline_s": deadline, "first_s": first.seconds,
        "priority": os.nice(0), "answered": outcomes.count(ANSWERED),
        "late": outcomes.count(LATE), "unanswered_in_a_row": longest,
        "seconds": {f"p{p}": float(np.percentile(seconds, p)) for p in (50, 90, 99, 100)},
        "compared": len(dearer),
        "dearer_than_a_search": {"median": float(np.median(dearer)), "worst": max(dearer)},
    }  # fmt: skip


if __name__ == "__main__":
    main()
