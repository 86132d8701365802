"""From a walk at its samples to a gait: limits kept between them, a second opinion, the proof."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import Design, design, finished
from gaitopt.design.options import DesignOptions
from gaitopt.design.refine import MAX_ROUNDS, with_work
from gaitopt.design.search import is_walk
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Solution, Start
from gaitopt.solvers import CertifiedSQP
from gaitopt.study.active import exceeded, instants_of, moved, placed, pressures
from gaitopt.study.footing import Footing
from gaitopt.study.setting import Setting
from gaitopt.study.travel import solved, stop_if_interrupted, warm


def finish(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    """Return the finished gait of a setting; the better of two ways if the first is not certified.

    Args:
        setting: robot and task.
        footing: a walk at its samples.
        options: as of `design`.

    Returns:
        The design, or None where refinement left no walk.

    Raises:
        KeyboardInterrupt: Ctrl-C was pressed.
    """
    first = _finished(setting, footing, options)
    if first is not None and (first.certificate.certified or not options.refine):
        return first
    second = _designed(setting, footing, options)
    return min((d for d in (first, second) if d is not None), key=rank, default=None)


def rank(found: Design) -> tuple[bool, float]:
    """Order gaits: certified ones first, then by cost."""
    return not found.certificate.certified, found.solution.cost


def _designed(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    """The usual way, from the walk."""
    direct = replace(options, diagnose=False, approach="direct")
    try:
        found = design(setting.robot.build(), setting.task, direct, start=footing.x)
    except (NoGaitFoundError, UnreachableError) as error:
        stop_if_interrupted(getattr(error, "solution", None))
        return None
    stop_if_interrupted(found.solution)
    return found


def _finished(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    sparse = WalkProblem(setting.robot.build(), setting.task)
    try:
        fine = on_fine_grid(sparse)
        kept = _kept_between(sparse, fine, footing, options)
        if kept is None:
            return None
        problem, solution = kept
        if isinstance(options.solver, CertifiedSQP):
            solution = options.solver.confirm(problem, solution)
            stop_if_interrupted(solution)
        return finished(problem, solution, options.refine, fine)
    except EvaluationError:
        return None


def _kept_between(
    sparse: WalkProblem, fine: WalkProblem, footing: Footing, options: DesignOptions
) -> tuple[WalkProblem, Solution] | None:
    """Solve with the instants where the walk presses on its limits, until no others are needed.

    With a peak come its neighbours on the fine grid, because it moves when the walk gives way; that
    saves a round in three (measured). In the end only those instants are kept where the walk
    presses: limits with nearly the same gradients cost the second opinion more than all the rest.
    """
    solver = warm(options)
    grid = uniform_grid(sparse.task.samples, sparse.task.quadrature)
    if not options.refine:
        solution = solved(solver, sparse, Start(footing.x, placed(sparse, footing.active)))
        return (sparse, solution) if is_walk(solution) else None
    spacing = 1.0 / (fine.grid.count - 1)
    x, active, done = footing.x, footing.active, None
    instants = instants_of(sparse, active)
    for _ in range(MAX_ROUNDS):
        peaks = exceeded(fine, x)
        if done is not None and not peaks:
            break
        active = moved(active, peaks)
        around = [s + k * spacing for _, s in peaks for k in (-1, 0, 1)]
        instants = np.union1d(instants, np.clip(around, 0.0, 1.0))
        problem = sparse.with_grid(grid.with_instants(instants))
        solution = solved(solver, problem, Start(x, placed(problem, active)))
        if not is_walk(solution):
            break
        x, active = solution.x, pressures(problem, solution.multipliers)
        done = problem, solution if done is None else with_work(solution, done[1])
    return done if done is None else _pruned(sparse, *done)


def _pruned(
    sparse: WalkProblem, problem: WalkProblem, solution: Solution
) -> tuple[WalkProblem, Solution]:
    """Return the walk on the grid without added instants at which nothing presses."""
    active = pressures(problem, solution.multipliers)
    grid = uniform_grid(sparse.task.samples, sparse.task.quadrature)
    lean = sparse.with_grid(grid.with_instants(instants_of(sparse, active)))
    return lean, replace(solution, multipliers=placed(lean, active))
