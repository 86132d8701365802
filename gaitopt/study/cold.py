"""From nowhere to a first walk: the starts that a single design makes, and disturbed ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from gaitopt.design.options import DesignOptions
from gaitopt.design.start_job import SECOND, Outcome, StartJob
from gaitopt.errors import UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution
from gaitopt.study.interruption import stop_if_interrupted
from gaitopt.study.setting import Setting

_ORIGINS = {0: "cold", SECOND: "slower walk"}  # by number of the start
NOISE = (0.1, 0.2)  # rad, of the disturbed first guesses tried in the end


def cold_walks(setting: Setting, options: DesignOptions) -> Iterator[tuple[str, Solution]]:
    """Yield walks at the samples with where they came from, the most promising first.

    Args:
        setting: robot and task.
        options: as of `design`.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    robot, task = setting.robot.build(), setting.task
    try:
        x = first_guess(WalkProblem(robot, task))
    except UnreachableError:
        return
    job = StartJob(robot, task, replace(options, diagnose=False), x, sigma=0.0, seed=0)
    outcomes = [_outcome(job, number) for number in _ORIGINS]
    for one in sorted((o for o in outcomes if o.walks), key=lambda o: o.solution.cost):
        yield _ORIGINS[one.number], one.solution
    for number, sigma in enumerate(NOISE, SECOND + 1):
        one = _outcome(replace(job, sigma=sigma), number)
        if one.walks:
            yield "disturbed", one.solution


def _outcome(job: StartJob, number: int) -> Outcome:
    outcome = job.run(number)
    stop_if_interrupted(outcome.solution)
    return outcome
