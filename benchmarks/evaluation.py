"""Evaluation and exact Hessian against the bare sweep of `computeRNEADerivatives` calls.

By the compiled kernels, and by the plain path beside them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from common import BareSweep, arguments, interleaved, save, start, walk

from gaitopt.design.process import small_matrices
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics import compiled
from gaitopt.nlp import Array, Start
from gaitopt.solvers.sqp import SQP

SAMPLES = (11, 31, 61, 101, 151, 201, 301)
POINTS = 6
"""Different points evaluated in turn, so that nothing kept from the last call is of use."""


def run(samples: int, rounds: int) -> dict[str, Any]:
    """Time one grid; the points lie around the optimum, the multipliers are those of it."""
    problem = walk(samples=samples)
    solution = SQP().solve(problem, Start(start(problem)))
    rng = np.random.default_rng(0)
    nearby = [solution.x + 1e-4 * rng.normal(size=solution.x.size) for _ in range(POINTS)]
    # Started apart, so that none of them meets the point which the one before it has left.
    first, second, third = (itertools.cycle(nearby[i:] + nearby[:i]) for i in (0, 1, 3))
    parts: dict[str, Callable[[], object]] = {
        "bare": BareSweep(problem, *nearby),
        "values": lambda: problem.values(next(first)),
        "point": lambda: _all_rows(problem, next(second)),
        "point and hessian": lambda: _both(problem, next(third), solution.multipliers),
    }
    for name in ("values", "point", "point and hessian"):
        parts[f"plain {name}"] = _plainly(parts[name])
    times = interleaved(parts, rounds)
    for kind in ("", "plain "):
        times[f"{kind}hessian"] = {
            how: times[f"{kind}point and hessian"][how] - times[f"{kind}point"][how]
            for how in ("min", "median")
        }
    return {
        "samples": samples,
        "rows": problem.rows.lower.size,
        "parameters": problem.layout.size,
        "rows with multipliers": int(np.count_nonzero(solution.multipliers)),
        "seconds": times,
    }


def _plainly(function: Callable[[], object]) -> Callable[[], object]:
    """The same by the plain path."""

    def call() -> None:
        wanted, compiled.WANTED = compiled.WANTED, False
        try:
            function()
        finally:
            compiled.WANTED = wanted

    return call


def _all_rows(problem: WalkProblem, x: Array) -> None:
    """All derivatives, of which Newton's method asks for a few."""
    problem.point(x).slopes.form()


def _both(problem: WalkProblem, x: Array, multipliers: Array) -> None:
    """A Hessian needs the derivatives at its point, which a solver has asked for before."""
    _all_rows(problem, x)
    problem.hessian(x, multipliers, problem.cost_scale)


def measure(samples: tuple[int, ...], rounds: int) -> list[dict[str, Any]]:
    """Time all grids."""
    with small_matrices():
        return [run(count, rounds) for count in samples]


def main() -> None:
    options = arguments(__doc__).parse_args()
    quick = options.quick
    save("evaluation", measure((11, 31) if quick else SAMPLES, 5 if quick else 100), quick)


if __name__ == "__main__":
    main()
