"""SNOPT through Drake on gaitopt's own program: one cost, one vector constraint, exact gradients.

P. Gill, W. Murray, M. Saunders, "SNOPT: an SQP algorithm for large-scale constrained
optimization", SIAM Review 47 (2005).
"""

from __future__ import annotations

import re
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.nlp import NLP, Array
from gaitopt.solvers.adapters import Evaluator, ScaledProgram

UNDEFINED = 1e10
"""Cost where the walk is not defined: too far."""


@dataclass(frozen=True)
class SnoptRun:
    """Where SNOPT ended.

    Attributes:
        x: shape (n,).
        status: SNOPT's INFO code; 1 is "optimality conditions satisfied".
        iterations: major ones.
        marshalling: time spent on Drake's automatic differentiation types [CPU s].
    """

    x: Array
    status: int
    iterations: int
    marshalling: float


class _Functions:
    """Cost and rows of the scaled variables, on numbers or on numbers with gradients."""

    def __init__(self, program: ScaledProgram) -> None:
        from pydrake import autodiffutils

        self._program = program
        self._autodiff = autodiffutils
        self.marshalling = 0.0
        self.error: BaseException | None = None

    def cost(self, u: Any) -> Any:
        return self._kept(self._cost, u)

    def rows(self, u: Any) -> Any:
        return self._kept(self._rows, u)

    def _kept(self, function: Callable[[Any], Any], u: Any) -> Any:
        """Remember an error, which is lost on its way through SNOPT."""
        try:
            return function(u)
        except BaseException as error:
            self.error = error
            raise

    def _cost(self, u: Any) -> Any:
        if u.dtype != object:
            return min(self._program.cost(u), UNDEFINED)
        value = self._autodiff.ExtractValue(u).ravel()
        cost = min(self._program.cost(value), UNDEFINED)
        gradient = self._program.gradient(value)
        return self._autodiff.AutoDiffXd(cost, gradient)

    def _rows(self, u: Any) -> Any:
        if u.dtype != object:
            return self._program.rows(u)
        value = self._autodiff.ExtractValue(u).ravel()
        rows, jacobian = self._program.rows(value), self._program.jacobian(value)
        started = time.process_time()
        marked = self._autodiff.InitializeAutoDiff(rows[:, None], jacobian).ravel()
        self.marshalling += time.process_time() - started
        return marked


def solve(nlp: NLP, x: Array, tolerance: float = 1e-6, feasibility: float = 1e-8) -> SnoptRun:
    """Minimise from x (n,), in scaled variables."""
    from pydrake.solvers import CommonSolverOption, MathematicalProgram, SnoptSolver, SolverOptions

    evaluator = Evaluator(nlp)
    program = ScaledProgram(evaluator, evaluator.point(x))
    functions = _Functions(program)
    scale = program.scale
    drake = MathematicalProgram()
    u = drake.NewContinuousVariables(x.size)
    drake.AddCost(functions.cost, vars=u)
    drake.AddConstraint(functions.rows, lb=nlp.rows.lower, ub=nlp.rows.upper, vars=u)
    drake.AddBoundingBoxConstraint(nlp.variables.lower / scale, nlp.variables.upper / scale, u)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "snopt.out"
        options = SolverOptions()
        options.SetOption(CommonSolverOption.kPrintFileName, str(report))
        for name, value in (
            ("Major optimality tolerance", tolerance),
            ("Major feasibility tolerance", feasibility),
            ("Major iterations limit", 3000),
            ("Iterations limit", 1_000_000),
        ):
            options.SetOption(SnoptSolver().solver_id(), name, value)
        try:
            result = SnoptSolver().Solve(drake, x / scale, options)
        except BaseException as error:  # Drake wraps those of the functions in its own
            raise functions.error or error from error
        found = re.search(r"No\. of major iterations\s+(\d+)", report.read_text())
    return SnoptRun(
        np.asarray(result.GetSolution(u)) * scale,
        int(result.get_solver_details().info),
        int(found[1]) if found else -1,
        functions.marshalling,
    )
