"""A gait that is known as the start of a search: its parameters, and what else of it counts."""

from __future__ import annotations

import numpy as np

from gaitopt.bounds import INSTANTS, at_most
from gaitopt.errors import EvaluationError, InputError
from gaitopt.gait.grid import Grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.recorded import Recorded
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array, kkt_residual
from gaitopt.tolerances import OPTIMALITY

_AT_KNOT, _RATE = "_at_knot_", "_rate_before_impact"  # of names of parameters of joints


def gone_on(problem: WalkProblem, gait: Gait) -> tuple[WalkProblem, Array | None]:
    """Return the walk at the instants of a gait that is an optimum of it, and its multipliers (m,).

    At the task's samples alone such a gait is no optimum: a solver would leave it, and refinement
    might end elsewhere, or nowhere. At its own instants there is nothing left to do. For a gait of
    any other walk, the problem is returned as it is, without multipliers.

    Args:
        problem: the walk, at the task's samples.
        gait: with the parameters of the problem, as `parameters_of` returns them.

    Raises:
        InputError: the instants that the gait records are none.
    """
    rows, bounds = gait.multipliers, gait.bound_multipliers
    if rows is None or bounds is None or gait.parameter_names != problem.layout.names:
        return problem, None
    own = problem.with_grid(with_instants_of(problem.grid, gait))
    if rows.shape != own.rows.lower.shape:
        return problem, None
    try:
        residual = kkt_residual(own, own.point(gait.parameters), rows, bounds)
    except EvaluationError:
        return problem, None
    # least squares may choose other multipliers by rounding, as an audit allows too
    return (own, rows) if residual.worst <= 2.0 * OPTIMALITY else (problem, None)


def with_instants_of(grid: Grid, gait: Recorded) -> Grid:
    """Return a grid with the instants that refinement added to a gait's.

    Raises:
        InputError: they are no numbers from 0 to 1.
    """
    recorded = gait.fact("instants") or []
    if isinstance(recorded, list):
        at_most(len(recorded), INSTANTS, "recorded instants")
    try:
        instants = np.asarray(recorded, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("the gait's 'instants' are not numbers") from error
    if instants.ndim != 1 or not ((instants >= 0.0) & (instants <= 1.0)).all():
        raise InputError("the gait's 'instants' are not numbers from 0 to 1")
    for instant in instants:  # one by one: multipliers are in their order
        grid = grid.with_instants(np.array([instant]))
    return grid


def parameters_of(gait: Gait, problem: WalkProblem) -> Array:
    """Return the parameters (P,) of a gait for a walk; those it lacks are first guesses.

    Raises:
        InputError: the gait moves other joints or has another number of postures.
        UnreachableError: there is no first guess for what the gait does not know.
    """
    at_start = {f"{j}_at_start": q for j, q in zip(gait.joint_names, gait.q[0], strict=True)}
    known = at_start | dict(zip(gait.parameter_names, gait.parameters, strict=True))
    names = problem.layout.names
    joints = [n for n in names if _AT_KNOT in n or n.endswith(_RATE)]
    if set(joints) != {n for n in known if _AT_KNOT in n or n.endswith(_RATE)}:
        raise InputError(
            "the gait given as start moves other joints or has another number of intermediate "
            "postures; take one of the same robot and --postures"
        )
    if all(name in known for name in names):
        return np.array([known[name] for name in names])
    guessed = zip(names, first_guess(problem), strict=True)
    return np.array([known.get(name, value) for name, value in guessed])
