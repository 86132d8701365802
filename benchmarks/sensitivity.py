"""Thirty derivatives of the optimal cost in the design, against one evaluation and re-designs."""

from __future__ import annotations

import itertools
import time
from typing import Any

import numpy as np
from common import arguments, interleaved, reference_task, robot_of, save

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.robot_changes import Anatomy
from gaitopt.design.sensitivity import Envelope, robot_changes
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Start
from gaitopt.solvers import solver_by_name

QUANTITIES = 30
_MOVED = 1e-12  # so that no evaluation is the one kept


def times(robot: Robot, task: Task, rounds: int) -> dict[str, Any]:
    """Time derivatives and evaluations of one robot's walk in turns."""
    found = design(robot, task, DesignOptions())
    problem, x, y = found.problem, found.solution.x, found.certificate.multipliers[0]
    points = itertools.cycle(x + _MOVED * np.random.default_rng(0).normal(size=(64, x.size)))
    anatomy = cached_workspace(problem.robot, Anatomy)
    chosen = anatomy.changes[:QUANTITIES]
    first = Envelope(problem, x, y)
    assert len(chosen) == QUANTITIES
    assert {c.name for c in chosen} <= {c.name for c in robot_changes(first)}

    def gradient() -> None:
        at = Envelope(problem, next(points), y)
        for change in chosen:
            at.per_unit(change)

    def evaluation() -> None:
        at = next(points)
        problem.point(at)
        problem.hessian(at, y, problem.cost_scale)

    taken = interleaved(
        {
            "evaluation with its Hessian": evaluation,
            "evaluation without": lambda: problem.point(next(points)),
            "gradient of 30 quantities": gradient,
            "what they move in the robot, once for all its walks": lambda: Anatomy(robot).changes,
        },
        rounds,
    )
    started = time.process_time()
    solver = solver_by_name("sqp", tolerance=1e-9)
    for change in chosen[:5]:
        del change
        again = WalkProblem(problem.robot, problem.task, problem.grid)
        solver.solve(again, Start(x, y))
    warm = (time.process_time() - started) / 5.0
    return {"seconds": taken, "seconds of one walk solved again, warm": warm}


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    source, choices = description(entry_by_name("g1"))
    g1 = Robot.from_urdf(source, choices=choices)
    rounds = 5 if quick else 60
    data = {
        "biped13": times(robot_of(), reference_task(speed=1.0), rounds),
        "g1": times(g1, reference_task("humanoid", g1, speed=0.6), rounds),
    }
    save("sensitivity", data, quick)


if __name__ == "__main__":
    main()
