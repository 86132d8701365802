"""From a walk at its samples to a gait: limits kept between them, a second opinion, the proof."""

from __future__ import annotations

from dataclasses import replace

from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import Design, design, finished
from gaitopt.design.exchange import pruned
from gaitopt.design.options import DesignOptions
from gaitopt.errors import EvaluationError, NoGaitFoundError, UnreachableError
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers import CertifiedSQP
from gaitopt.study.between_samples import keep
from gaitopt.study.footing import Footing
from gaitopt.study.interruption import stop_if_interrupted
from gaitopt.study.setting import Setting
from gaitopt.study.travel import warm


def finish(setting: Setting, footing: Footing, options: DesignOptions) -> Design | None:
    """Return the finished gait of a setting; the better of two ways if the first is not certified.

    Args:
        setting: robot and task.
        footing: a walk of it.
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
        between = fine if options.refine else None
        kept = keep(sparse, footing.x, footing.active, warm(options), between)
        if kept is None:
            return None
        problem, solution = pruned(sparse, kept.problem, kept.solution)
        if isinstance(options.solver, CertifiedSQP):
            solution = options.solver.confirm(problem, solution)
            stop_if_interrupted(solution)
        return finished(problem, solution, options.refine, fine)
    except EvaluationError:
        return None
