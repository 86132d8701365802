"""Memory of one design, and page faults of one evaluation with and without kept memory."""

from __future__ import annotations

import resource
import sys
import tracemalloc
from typing import Any

import numpy as np
from common import arguments, reference_task, robot_of, save, start, walk
from threadpoolctl import threadpool_limits

from gaitopt.design.design import design
from gaitopt.design.process import small_matrices
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Start
from gaitopt.solvers.sqp import SQP

SOLVES = 5
MEGABYTE = 2.0**20


def resident() -> float:
    """Return the largest resident size so far [MB]; the system counts in kB, macOS in bytes."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size / MEGABYTE if sys.platform == "darwin" else size / 1024.0


def page_faults(problem: WalkProblem) -> float:
    """Return the page faults per evaluation of one solve."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    solution = SQP().solve(problem, Start(start(problem)))
    after = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    return (after - before) / solution.evaluations


def measure(solves: int) -> dict[str, Any]:
    """Measure in the order that needs no second process: the settings stay for good."""
    problem = walk()
    with threadpool_limits(limits=1, user_api="blas"):
        page_faults(problem)  # imports
        plain = [page_faults(problem) for _ in range(solves)]
    with small_matrices():
        page_faults(problem)  # the first one fetches what is then kept
        kept = [page_faults(problem) for _ in range(solves)]
    before = resident()
    robot, task = robot_of(), reference_task(speed=1.0)
    design(robot, task)
    after = resident()
    tracemalloc.start()
    design(robot, task)
    held, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    jacobian = problem.point(start(problem)).jacobian
    return {
        "resident before": before,
        "resident after": after,
        "peak of one design": peak / MEGABYTE,
        "held after one design": held / MEGABYTE,
        "one Jacobian": jacobian.nbytes / MEGABYTE,
        "page faults of an evaluation": {
            "plain": float(np.median(plain)),
            "kept": float(np.median(kept)),
        },
    }


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    save("memory", measure(2 if quick else SOLVES), quick)


if __name__ == "__main__":
    main()
