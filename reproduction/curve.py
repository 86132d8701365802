"""Optimal walks along the speeds: each from its neighbours, in both directions, the lower kept."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from gaitopt.design.phase_times import SLOWER
from gaitopt.design.pipeline import is_walk
from gaitopt.errors import EvaluationError
from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import GEOMETRY_NAMES, STEP_LENGTH
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step import Step
from gaitopt.nlp import Array, Solution, Start
from gaitopt.solvers import SQP

SETTLED = 1e-6  # relative; a cost that falls by less is the same optimum
SOLVER = SQP(max_iterations=150)  # a neighbour's walk needs a tenth of them


@dataclass(frozen=True)
class Optimum:
    """A walk that was found.

    Attributes:
        problem: the walk.
        solution: what the solver returned.
    """

    problem: WalkProblem
    solution: Solution

    @property
    def speed(self) -> float:
        """Asked for [m/s]."""
        return self.problem.task.speed

    @property
    def cost(self) -> float:
        """J [N²·m·s]."""
        return self.solution.cost

    @cached_property
    def step(self) -> Step:
        """Everything about it."""
        return self.problem.step(self.solution.x)

    @property
    def impulse(self) -> float:
        """Vertical impulse of the ground at the impact [N·s]."""
        return float(self.step.read(quantities.IMPULSE)[0, 2])

    @property
    def mean_vertical_force(self) -> float:
        """Of the ground on the stance foot over the step [N]."""
        return float(self.problem.grid.weights @ self.step.read(quantities.WRENCH)[:, 2])


Curve = dict[float, Optimum]


def cost_curve(
    problems: Sequence[WalkProblem], known: Mapping[float, Array] | None = None
) -> Curve:
    """Return the best walk found at each speed, by speed [m/s]; speeds without a walk are left out.

    Several strict local optima exist, so every walk is searched for from the first guess, from a
    slower walk and from both neighbours, until no cost falls any more.

    Args:
        problems: one per speed, slowest first.
        known: points to start from too, by speed [m/s].
    """
    curve: Curve = {}
    for problem in problems:
        starts = [Start(x) for v, x in (known or {}).items() if v == problem.task.speed]
        keep_best(curve, problem, starts or _guesses(problem))
    moved = True
    while moved:
        costs = _costs(curve)
        for order in (problems, problems[::-1]):
            for before, after in pairwise(order):
                if before.task.speed in curve:
                    keep_best(curve, after, [_from(curve[before.task.speed])])
        moved = _fell(costs, _costs(curve))
    return dict(sorted(curve.items()))


def warm_curve(problems: Sequence[WalkProblem], near: Mapping[float, Array]) -> Curve:
    """Return the walks next to known ones, without a search for other optima.

    Args:
        problems: one per speed.
        near: points to start from, by speed [m/s].
    """
    curve: Curve = {}
    for problem in problems:
        keep_best(curve, problem, [Start(near[problem.task.speed])])
    return curve


def keep_best(curve: Curve, problem: WalkProblem, starts: Iterable[Start]) -> None:
    """Solve from each start; keep a walk that is better than the one at hand."""
    speed = problem.task.speed
    for start in starts:
        solution = SOLVER.solve(problem, replace(start, x=stepped(problem, start.x)))
        if is_walk(solution) and (speed not in curve or solution.cost < curve[speed].cost):
            curve[speed] = Optimum(problem, solution)


def stepped(problem: WalkProblem, x: Array) -> Array:
    """Return a neighbour's parameters with the step length of this problem's speed, if in reach."""
    start, at = np.array(x), problem.layout.index(GEOMETRY_NAMES[STEP_LENGTH])
    if at is not None:
        start[at] = problem.task.step_length
    try:
        problem.values(start)
    except EvaluationError:
        return x
    return start


def _guesses(problem: WalkProblem) -> list[Start]:
    """Return where a single design starts: the first guess, and a slower walk from its own."""
    slower = WalkProblem(
        problem.robot, replace(problem.task, speed=SLOWER * problem.task.speed), problem.grid
    )
    found: Curve = {}
    keep_best(found, slower, _first_guess(slower))
    return [*_first_guess(problem), *map(_from, found.values())]


def _from(walk: Optimum) -> Start:
    return Start(walk.solution.x, walk.solution.multipliers)


def _first_guess(problem: WalkProblem) -> list[Start]:
    try:
        return [Start(first_guess(problem))]
    except EvaluationError:
        return []


def _costs(curve: Curve) -> dict[float, float]:
    return {speed: optimum.cost for speed, optimum in curve.items()}


def _fell(before: Mapping[float, float], after: Mapping[float, float]) -> bool:
    return any(
        speed not in before or cost < before[speed] * (1.0 - SETTLED)
        for speed, cost in after.items()
    )


GROUPS = ("ankle", "knee", "hip")
_STANCE = {"ankle": slice(0, 2), "knee": slice(2, 3), "hip": slice(3, 6)}
_SWING = {"ankle": slice(10, 12), "knee": slice(9, 10), "hip": slice(6, 9)}


@dataclass(frozen=True)
class JointCosts:
    """Shares of J [N²·m·s] by group of joints; they add up to J.

    Attributes:
        stance, swing: of the leg, by name of `GROUPS`.
    """

    stance: dict[str, float]
    swing: dict[str, float]


def joint_costs(optimum: Optimum) -> JointCosts:
    """Return what each group of joints contributes to the cost of a walk, Eq. (46)."""
    step, weights = optimum.step, optimum.problem.grid.weights
    per_joint: Array = (
        weights @ step.read(quantities.TORQUE) ** 2 * step.duration / step.step_length
    )
    return JointCosts(
        {group: float(per_joint[_STANCE[group]].sum()) for group in GROUPS},
        {group: float(per_joint[_SWING[group]].sum()) for group in GROUPS},
    )
