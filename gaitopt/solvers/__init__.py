"""Solvers of nonlinear programs; they know nothing of robots."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from gaitopt.errors import InputError, did_you_mean
from gaitopt.settings import checked_arguments
from gaitopt.solvers.adapters import FiniteDifferenceNLP
from gaitopt.solvers.ipopt import Ipopt
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.solvers.slsqp import SLSQP
from gaitopt.solvers.solver import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.solvers.trust_constr import TrustConstr
from gaitopt.solvers.two_stage import ConfirmedSQP, TwoStageSQP

SOLVERS: dict[str, type[TwoStageSQP | SQP | TrustConstr | SLSQP | Ipopt]] = {
    "default": ConfirmedSQP,
    ConfirmedSQP.name: ConfirmedSQP,
    TwoStageSQP.name: TwoStageSQP,
    SQP.name: SQP,
    TrustConstr.name: TrustConstr,
    SLSQP.name: SLSQP,
    Ipopt.name: Ipopt,
}
"""Every solver by its name."""


@checked_arguments
def solver_by_name(name: str, **options: Any) -> Solver:
    """Make a solver.

    Args:
        name: one of `SOLVERS`.
        options: attributes of the solver's class; the rest keep their defaults.

    Raises:
        InputError: there is no such solver, or it has no such option or value.
    """
    if name not in SOLVERS:
        raise InputError(
            f"there is no solver {name!r}; {did_you_mean(name, SOLVERS)}choose one of "
            f"{', '.join(SOLVERS)}"
        )
    allowed = [field.name for field in fields(SOLVERS[name])]
    for option in options:
        if option not in allowed:
            hint = did_you_mean(option, allowed)
            raise InputError(
                f"solver {name} has no option {option!r}; {hint}it has {', '.join(allowed)}"
            )
    return SOLVERS[name](**options)


__all__ = [
    "SLSQP",
    "SOLVERS",
    "SQP",
    "ConfirmedSQP",
    "FiniteDifferenceNLP",
    "Ipopt",
    "Solver",
    "TrustConstr",
    "TwoStageSQP",
    "least_squares_multipliers",
    "solver_by_name",
]
