"""The paper's method, SLSQP with finite-difference gradients, against gaitopt from the same guess.

"all" takes differences for cost and constraints, "constraints" for the constraints only: the
paper's mode with an analytical gradient of the cost. Both walk on gaitopt's own evaluation.
"""

from __future__ import annotations

import time
from typing import Any

from common import Clock, TimedNLP, arguments, save, start, told, walk

from gaitopt.design.process import small_matrices
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import NLP, Array, Progress, Start
from gaitopt.solvers import SLSQP, SQP, FiniteDifferenceNLP, Solver
from gaitopt.tolerances import FEASIBLE

CAP = 600.0
"""CPU seconds after which a run is stopped."""
REPEATS = 5
"""Of our own solve, before and after each of the others."""
NEAR = (0.01, 0.001, 1e-4)
"""Relative distances to the cost of gaitopt's optimum whose first crossing is timed."""


def run(problem: WalkProblem, solver: Solver, x: Array, differences: str, cap: float) -> Any:
    """Solve once; return cost, work and the history of feasible costs."""
    counted = TimedNLP(problem)
    nlp: NLP = counted
    if differences != "none":
        nlp = FiniteDifferenceNLP(counted, cost_gradient_only=differences == "constraints")
    seen: list[tuple[float, Progress]] = []

    def record(progress: Progress) -> None:
        seen.append((time.process_time() - cpu, progress))

    started, cpu = time.perf_counter(), time.process_time()
    solution = solver.solve(nlp, Start(x), record, Clock(cap))
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    return {
        **told(solution),
        "evaluations": counted.evaluations,
        "points": counted.points,
        "hessians": counted.hessians,
        "seconds": seconds,
        "cpu seconds": cpu,
        "evaluation seconds": counted.seconds,
        "evaluation cpu seconds": counted.cpu_seconds,
        "feasible": [[t, p.cost] for t, p in seen if p.violation <= FEASIBLE],
    }


def first_time(record: dict[str, Any], cost: float) -> float | None:
    """Return when a feasible iterate cost no more than this [CPU s], None if never."""
    return next((seconds for seconds, value in record["feasible"] if value <= cost), None)


def main() -> None:
    options = arguments(__doc__).parse_args()
    cap = 3.0 if options.quick else CAP
    repeats = 1 if options.quick else REPEATS
    problem = walk()
    x = start(problem)
    ours: list[Any] = []
    paper: dict[str, Any] = {}
    with small_matrices():
        for differences in ("all", "constraints"):
            ours += [run(problem, SQP(), x, "none", cap) for _ in range(repeats)]
            paper[differences] = run(problem, SLSQP(), x, differences, cap)
            print({k: v for k, v in paper[differences].items() if k != "feasible"}, flush=True)
            ours += [run(problem, SQP(), x, "none", cap) for _ in range(repeats)]
    best = ours[0]["cost"]
    for record in (*paper.values(), *ours):
        record["first time"] = {str(near): first_time(record, best * (1 + near)) for near in NEAR}
        del record["feasible"]
    middle = sorted(ours, key=lambda r: r["cpu seconds"])[len(ours) // 2]
    data = {"cap": cap, "ours": middle, "runs": ours, "paper": paper}
    save("paper_method", data, options.quick)


if __name__ == "__main__":
    main()
