"""Which first guess leads to the best known optimum: the guess, a slower walk, or noise."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from common import arguments, reference_task, robot_of, save

from gaitopt.design.options import SIGMA, Search
from gaitopt.design.pipeline import is_walk
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import SECOND, StartJob
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot
from gaitopt.nlp import Start
from gaitopt.solvers.sqp import SQP

SPEEDS = tuple(float(v) for v in np.round(np.arange(0.4, 1.301, 0.05), 2))
NOISY = 4
"""Starts with noise."""


def run(robot: Robot, speed: float) -> dict[str, Any]:
    """Make all starts at one speed."""
    problem = WalkProblem(robot, reference_task(speed=speed))
    job = StartJob(robot, problem.task, first_guess(problem), SIGMA, seed=0)
    costs, seconds = [], []
    for number in range(2 + NOISY):
        started = time.process_time()
        outcome = job.run(number, Search())
        costs.append(outcome.solution.cost if outcome.walks else None)
        seconds.append(time.process_time() - started)
    noise = costs[:SECOND] + costs[SECOND + 1 :]
    return {
        "speed": speed, "guess": costs[0], "slower": costs[SECOND],
        "noise": [cost for cost in noise[1:] if cost is not None],
        "cpu seconds": {"guess": seconds[0], "slower": seconds[SECOND]},
    }  # fmt: skip


def neighbours(robot: Robot, speeds: tuple[float, ...]) -> dict[float, float]:
    """Return the best costs of two passes up and two down, each walk from its neighbour."""
    best: dict[float, float] = {}
    x = None
    for speed in 2 * (*speeds, *speeds[::-1]):
        problem = WalkProblem(robot, reference_task(speed=speed))
        solution = SQP().solve(problem, Start(first_guess(problem) if x is None else x))
        if is_walk(solution):
            x = solution.x
            best[speed] = min(solution.cost, best.get(speed, np.inf))
    return best


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    speeds, robot = SPEEDS[:2] if quick else SPEEDS, robot_of()
    with small_matrices():
        records = [run(robot, speed) for speed in speeds]
        best = neighbours(robot, speeds)
    for record in records:
        found = (record["guess"], record["slower"], *record["noise"], best.get(record["speed"]))
        record["best"] = min(cost for cost in found if cost is not None)
    save("starts", records, quick)


if __name__ == "__main__":
    main()
