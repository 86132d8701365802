"""Solvers on the same program with the same derivatives, from the same perturbed starts."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import snopt
from common import RESULTS, OutOfTimeError, TimedNLP, arguments, save, start, walk

from gaitopt.design.process import small_matrices
from gaitopt.errors import EvaluationError
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array, Start, kkt_residual, worst_violation
from gaitopt.solvers import SLSQP, SQP, Ipopt, Solver, TrustConstr, TwoStageSQP
from gaitopt.solvers.multipliers import least_squares_multipliers
from gaitopt.tolerances import FEASIBLE

SIGMAS = (0.05, 0.1, 0.2)
STARTS = 20
CAP = 60.0
"""CPU seconds after which a run is stopped."""
FEW = 1
"""Starts per sigma for methods that are often stopped."""
OPTIMAL, SAME_COST = 1e-5, 1e-4
"""Largest KKT residual, and relative difference of costs, of a success."""


@dataclass(frozen=True)
class Method:
    """One line of the table.

    Attributes:
        run: solves a program from a point; returns x, iterations and more to record.
        hessian: whether it is given second derivatives.
        starts: per sigma.
    """

    run: Callable[[TimedNLP, Array], tuple[Array, int, dict[str, Any]]]
    hessian: bool = True
    starts: int = STARTS


def _ours(solver: Solver) -> Callable[[TimedNLP, Array], tuple[Array, int, dict[str, Any]]]:
    def run(nlp: TimedNLP, x: Array) -> tuple[Array, int, dict[str, Any]]:
        solution = solver.solve(nlp, Start(x), stop=nlp.out_of_time)
        return solution.x, solution.iterations, {"status": solution.status.name}

    return run


def _snopt(nlp: TimedNLP, x: Array) -> tuple[Array, int, dict[str, Any]]:
    found = snopt.solve(nlp, x)
    more = {"status": f"INFO {found.status}", "marshalling": found.marshalling}
    return found.x, found.iterations, more


def methods() -> dict[str, Method]:
    """Return the methods that are installed."""
    table = {
        "gaitopt SQP, exact Hessian": Method(_ours(SQP())),
        "gaitopt SQP, then trust-constr": Method(_ours(TwoStageSQP())),
        "gaitopt SQP, BFGS": Method(_ours(SQP(hessian="bfgs")), hessian=False),
    }
    if find_spec("pydrake"):
        table["SNOPT"] = Method(_snopt, hessian=False)
    if find_spec("cyipopt"):
        import_module("cyipopt")  # its BLAS must be there when the threads are limited
        table["IPOPT, exact Hessian"] = Method(_ours(Ipopt()))
        table["IPOPT, limited memory"] = Method(_ours(Ipopt()), hessian=False, starts=FEW)
    table["SciPy SLSQP"] = Method(_ours(SLSQP()), hessian=False)
    table["SciPy trust-constr"] = Method(_ours(TrustConstr()), starts=FEW)
    return table


def run(problem: WalkProblem, method: Method, x: Array) -> dict[str, Any]:
    """Run one method from one start and judge where it ended."""
    counted = TimedNLP(problem, method.hessian, CAP, raising=method.run is _snopt)
    started, cpu = time.perf_counter(), time.process_time()
    record: dict[str, Any] = {"capped": False}
    try:
        end, iterations, more = method.run(counted, x)
        record |= {"iterations": iterations, **more}
    except OutOfTimeError:
        end, record["capped"] = x, True
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    record["capped"] |= cpu > CAP
    return record | _judged(problem, end) | {
        "evaluations": counted.evaluations,
        "points": counted.points,
        "hessians": counted.hessians,
        "seconds": seconds,
        "evaluation seconds": counted.seconds,
        "cpu seconds": cpu,
        "evaluation cpu seconds": counted.cpu_seconds,
    }  # fmt: skip


def _judged(problem: WalkProblem, x: Array) -> dict[str, Any]:
    """Judge a point from the point alone."""
    x = np.clip(x, problem.variables.lower, problem.variables.upper)
    try:
        point = problem.point(x)
    except EvaluationError:
        return {"cost": None, "violation": None, "kkt": None}
    residual = kkt_residual(problem, point, *least_squares_multipliers(problem, point, 1e-5))
    return {
        "cost": point.cost,
        "violation": worst_violation(problem, point)[0],
        "kkt": max(residual.stationarity, residual.complementarity),
    }


def known_optima(records: list[dict[str, Any]]) -> list[float]:
    """Return the distinct costs of all points that satisfy the KKT conditions."""
    costs: list[float] = []
    for record in sorted(
        (r for r in records if _is_feasible(r) and r["kkt"] <= OPTIMAL), key=lambda r: r["cost"]
    ):
        if not costs or record["cost"] > costs[-1] * (1.0 + SAME_COST):
            costs.append(record["cost"])
    return costs


def _is_feasible(record: dict[str, Any]) -> bool:
    return record["violation"] is not None and record["violation"] <= FEASIBLE


def mark_success(records: list[dict[str, Any]], optima: list[float]) -> None:
    """Say of every run whether it ended at a known optimum, and at which."""
    for record in records:
        near = [
            i
            for i, cost in enumerate(optima)
            if _is_feasible(record) and abs(record["cost"] - cost) <= SAME_COST * cost
        ]
        record["optimum"] = near[0] if near else None


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--starts", type=int, default=STARTS)
    parser.add_argument("--only", default="", help="run methods that begin so, keep other results")
    options = parser.parse_args()
    sigmas, count = (SIGMAS[:1], 1) if options.quick else (SIGMAS, options.starts)
    table = {k: method for k, method in methods().items() if k.startswith(options.only)}
    if options.quick and "SciPy trust-constr" in table:
        table["SciPy trust-constr"] = replace(table["SciPy trust-constr"], starts=0)
    problem, records = walk(), _kept(table) if options.only and not options.quick else []
    slow = {name: method for name, method in table.items() if method.starts < STARTS}
    quick = {name: method for name, method in table.items() if name not in slow}
    with small_matrices():
        # Starts outside, methods inside: all methods see the same load.
        for group, seed, sigma in itertools.product((quick, slow), range(count), sigmas):
            x = start(problem, sigma, seed)
            for name, method in group.items():
                if seed < method.starts:
                    found = run(problem, method, x)
                    records.append({"method": name, "sigma": sigma, "seed": seed, **found})
                    print(_line(records[-1]), flush=True)
            if not options.quick:
                _save(records, False)
    _save(records, options.quick)


def _kept(table: dict[str, Method]) -> list[dict[str, Any]]:
    """Runs of the last time, of all methods but those that are run again."""
    last = json.loads((RESULTS / "solvers.json").read_text())["data"]["runs"]
    return [record for record in last if record["method"] not in table]


def _save(records: list[dict[str, Any]], quick: bool) -> None:
    optima = known_optima(records)
    mark_success(records, optima)
    save("solvers", {"optima": optima, "cap": CAP, "runs": records}, quick)


def _line(r: dict[str, Any]) -> str:
    return (
        f"{r['sigma']} {r['seed']:2d} {r['method']:32s} J {r['cost']} violation {r['violation']} "
        f"KKT {r['kkt']} {r.get('status')} {r.get('iterations')} it {r['evaluations']} ev "
        f"{r['cpu seconds']:.2f} s"
    )


if __name__ == "__main__":
    main()
