"""Replanning: the next walk from the last one, within a deadline.

A walk whose task changes a little is a few iterations from the one before. So a controller, or a
person with a slider, is answered in tens of milliseconds. What is answered is optimal at its
samples; `complete` refines and certifies it between them when there is time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

from gaitopt.dataclass import dataclass
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import Design, attempt, complete, derived, is_walk
from gaitopt.errors import EvaluationError, InputError, UnreachableError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess, resized
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import Solution, Start, Status, Stop, never, stopping
from gaitopt.settings import checked_arguments, checked_facts

ANSWERED, LATE, NONE = "optimal at the samples", "late", "no walk"
NEARLY = 1e-3
"""Scaled violation of a late plan with which it is a better start for another task than the last
walk: where tasks come faster than answers, each would else begin as far away as the one before."""


@checked_facts
@dataclass(frozen=True, eq=False)
class Plan:
    """What came of replanning.

    Attributes:
        problem: the walk that was asked for.
        outcome: "optimal at the samples"; "late": the deadline came first; "no walk": none was
            found, from the last walk or from a first guess.
        solution: of the problem; None where not even a first guess exists. Only where the outcome
            is "optimal at the samples" is it a walk to be used.
        seconds: that it took, of the clock.
        reason: why there is no walk; empty if there is one.
    """

    problem: WalkProblem
    outcome: str
    solution: Solution | None
    seconds: float
    reason: str = ""

    @property
    def answered(self) -> bool:
        """Whether there is a walk of the task asked for."""
        return self.outcome == ANSWERED

    def gait(self) -> Gait:
        """Return the walk as a gait that claims no certificate.

        Raises:
            InputError: there is none.
        """
        meta = {"status": ANSWERED, "refined": False}
        return gait_at(self.problem, self._walk().x, meta)

    @checked_arguments
    def complete(self, options: DesignOptions | None = None, stop: Stop = never) -> Design:
        """Return the walk refined between its samples, confirmed and certified.

        Args:
            stop: where it says True, the best walk until then is returned.

        Raises:
            InputError: there is none.
            EvaluationError: the walk is not defined between its samples.
        """
        return complete(self.problem, self._walk(), Search(options or DesignOptions(), stop=stop))

    def _walk(self) -> Solution:
        if self.solution is None or not self.answered:
            raise InputError(f"there is no walk to use: {self.reason or self.outcome}")
        return self.solution


class Replanner:
    """Goes from walk to walk as its task, or its robot, changes.

    Not for several threads at once.

    Attributes:
        options: solver and kind of derivatives.
        last: the last plan with a walk, from which the next begins; None before the first.
    """

    @checked_arguments
    def __init__(self, options: DesignOptions | None = None) -> None:
        self.options = options or DesignOptions()
        self.last: Plan | None = None
        self._unfinished: Plan | None = None

    @checked_arguments
    def replan(
        self, robot: Robot, task: Task, *, deadline: float | None = None, stop: Stop = never
    ) -> Plan:
        """Return the walk of a task: from the last one, else from a first guess.

        A plan that was late goes on where it ended if the same task is asked for again, or another
        one while it was nearly a walk.

        Args:
            robot: who walks, the same object as before unless it has changed.
            deadline: seconds from now after which the answer is "late"; it is looked at in every
                iteration, of some milliseconds.
            stop: asked as often; where it says True, the answer is "late" too.

        Raises:
            InputError: the task, the robot or the deadline cannot be.
        """
        if deadline is not None and math.isnan(deadline):
            raise InputError("the deadline is nan s; give seconds, or None for no deadline")
        began = time.perf_counter()

        def ends() -> bool:
            return stop() or (deadline is not None and time.perf_counter() - began >= deadline)

        known = None if self.last is None else self.last.problem
        problem = WalkProblem(robot, task, neighbour=known)
        solution, reason = None, ""
        for begin in self._starts(problem):
            if begin is None:
                reason = "the step asked for is longer than the legs"
                continue
            if begin.multipliers is None and self.last is None:
                solution = attempt(problem, Search(self.options, stop=ends), begin.x)
            else:
                solver = self.options.solver.first_stage.near_solution()
                derivable = derived(problem, self.options)
                solution = solver.solve(derivable, begin, stop=stopping(ends))
            if solution.status is Status.INTERRUPTED or _walks(solution):
                break
        outcome = NONE
        if solution is not None and _walks(solution):
            outcome, reason = ANSWERED, ""
        elif solution is not None:
            outcome = LATE if solution.status is Status.INTERRUPTED else NONE
            reason = solution.status.value if outcome == NONE else ""
        seconds = time.perf_counter() - began
        plan = Plan(problem, outcome, solution, seconds, reason)
        if plan.answered:
            self.last = plan
        self._unfinished = plan if outcome == LATE else None
        return plan

    def _starts(self, problem: WalkProblem) -> Iterator[Start | None]:
        """Yield where to begin, the most promising first; None in place of a first guess."""
        for plan in (self._unfinished, self.last):
            if plan is None or plan.solution is None:
                continue
            same = plan.problem.task == problem.task
            if plan is self._unfinished and not same and plan.solution.violation > NEARLY:
                continue
            known, x = plan.solution, plan.solution.x
            if plan.problem.robot is not problem.robot:
                try:
                    x = resized(x, plan.problem, problem)
                except (InputError, UnreachableError, EvaluationError):
                    continue
            if x.shape == (problem.layout.size,):
                fits = known.multipliers.shape == problem.rows.lower.shape
                yield Start(x, known.multipliers, known.hessian) if fits else Start(x)
        try:
            guess = first_guess(problem)
        except UnreachableError:
            yield None
        else:
            yield Start(guess)


def _walks(solution: Solution) -> bool:
    return is_walk(solution) and solution.status is Status.OPTIMAL
