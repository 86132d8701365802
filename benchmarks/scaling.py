"""Solving with more postures and more samples: time, iterations and cost, one start each."""

from __future__ import annotations

import time
from typing import Any

from common import BareSweep, Clock, TimedNLP, arguments, interleaved, save, start, told, walk

from gaitopt.design.process import small_matrices
from gaitopt.nlp import Start
from gaitopt.solvers.sqp import SQP

POSTURES = (1, 2, 3, 4, 5, 6, 7, 8)
SAMPLES = (11, 31, 61, 101, 151, 201, 301)
DEFAULT_POSTURES, DEFAULT_SAMPLES = 2, 31
CAP = 60.0
"""CPU seconds after which a run is stopped."""


def run(postures: int, samples: int) -> dict[str, Any]:
    """Solve one walk from its first guess."""
    problem = walk(postures=postures, samples=samples)
    x = start(problem)
    counted = TimedNLP(problem)
    started, cpu = time.perf_counter(), time.process_time()
    solution = SQP().solve(counted, Start(x), stop=Clock(CAP))
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    bare = interleaved({"bare": BareSweep(problem, x)}, 20)["bare"]
    return {
        "postures": postures,
        "samples": samples,
        "parameters": problem.layout.size,
        "rows": problem.rows.lower.size,
        **told(solution),
        "evaluations": counted.evaluations,
        "seconds": seconds,
        "cpu seconds": cpu,
        "evaluation seconds": counted.seconds,
        "bare": bare["median"],
    }


def measure(postures: tuple[int, ...], samples: tuple[int, ...]) -> dict[str, Any]:
    """Solve all."""
    with small_matrices():
        run(DEFAULT_POSTURES, DEFAULT_SAMPLES)  # imports and caches
        return {
            "cap": CAP,
            "postures": [run(count, DEFAULT_SAMPLES) for count in postures],
            "samples": [run(DEFAULT_POSTURES, count) for count in samples],
        }


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    save("scaling", measure((1, 2), (11, 31)) if quick else measure(POSTURES, SAMPLES), quick)


if __name__ == "__main__":
    main()
