"""Walks whose double support begins with an impact, by way of those that touch down at zero speed.

An impact that both feet take asks a lot: no joint gives an impulse, and each foot's must be inside
its friction cone and its sole. At many a posture none is but zero, where all limits on it meet and
no solver settles. So the walk that touches down gently is found first, and an impact only tried
where there is room for one (docs/decisions/landing.md).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gaitopt.gait import quantities
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.functions import Entries, FrictionCone, Linear
from gaitopt.gait.parameters import Layout
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array

_NONE = 1e-9
"""Largest vertical impulse of the front foot that is none, where 1 N·s is the most there may be."""


def gentle(problem: WalkProblem) -> WalkProblem:
    """Return the same walk touching down at zero speed."""
    task = replace(problem.task, touch_down="gentle")
    return WalkProblem(problem.robot, task, problem.grid)


def carried_over(x: Array, one: WalkProblem, other: WalkProblem) -> Array:
    """Return the parameters of a walk whose double support begins in the other way, same motion.

    Of an impact: as it is after it, and without an impulse where there was none.

    Args:
        x: parameters of a walk, shape (P,).
        one: the walk they are of.
        other: the walk they are to be of.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    model, follows = one.model, other.model
    assert isinstance(model, DoubleStepModel)
    assert isinstance(follows, DoubleStepModel)
    a, b = one.layout, other.layout
    assert isinstance(a, Layout)
    assert isinstance(b, Layout)
    found = np.zeros(b.size)
    for name in ("knots", "rates", "start", "shape", "front", "largest"):
        found[getattr(b, name)] = x[getattr(a, name)]
    found[b.late] = follows.bends(model.late_motion(one.step(x)))
    return found


def impact_possible(problem: WalkProblem, x: Array) -> bool:
    """Return whether there may be an impact that both feet take, at the posture in which they do.

    Cones count as the pyramids around them, so that where there is none there is none indeed.

    Args:
        problem: a walk whose double support begins with an impact.
        x: parameters, shape (P,).

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    model = problem.model
    assert isinstance(model, DoubleStepModel)
    by_front = {
        quantities.IMPULSE: np.eye(6),
        quantities.REAR_IMPULSE: model.rear_impulses(problem.step(x)),
    }
    rows = []
    for block in problem.blocks:
        if block.reads[0] not in by_front or len(block.reads) > 1:
            continue
        matrix = by_front[block.reads[0]]
        if isinstance(block.function, FrictionCone):
            mu = block.function.friction
            sides = [[sign * (axis == 0), sign * (axis == 1), -mu, 0, 0, 0]
                     for axis in (0, 1) for sign in (-1.0, 1.0)]  # fmt: skip
            rows.append(np.array(sides) @ matrix)
        elif isinstance(block.function, Linear | Entries) and (block.lower == 0.0).all():
            rows.append(-np.asarray(block.function.jacobian(np.zeros((1, 6)))) @ matrix)
    from scipy.optimize import linprog  # slow to import, and few walks ask for it

    above = np.concatenate(rows)
    free = (-np.inf, np.inf)
    bounds = [free, free, (0.0, 1.0), free, free, free]
    cost = np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.0])
    found = linprog(cost, A_ub=above, b_ub=np.zeros(len(above)), bounds=bounds)
    return found.x is None or bool(found.x[2] > _NONE)
