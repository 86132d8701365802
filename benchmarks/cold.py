"""Cold solves from perturbed starts: time in seconds and in bare sweeps timed in between."""

from __future__ import annotations

import time
from typing import Any

from common import BareSweep, arguments, interleaved, save, start, told, walk

from gaitopt.design.process import small_matrices
from gaitopt.nlp import Array, Start
from gaitopt.solvers.sqp import SQP

SIGMAS = (0.05, 0.1, 0.2)
STARTS = 20
SWEEPS = 10
"""Bare sweeps timed before and after every solve."""


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    problem = walk()
    guess = start(problem)
    records: list[dict[str, Any]] = []
    with small_matrices():
        sweep = BareSweep(problem, guess)
        SQP().solve(problem, Start(guess))  # imports and caches

        def run(x: Array) -> dict[str, Any]:
            before = interleaved({"bare": sweep}, SWEEPS)["bare"]["median"]
            started, cpu = time.perf_counter(), time.process_time()
            solution = SQP().solve(problem, Start(x))
            seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
            after = interleaved({"bare": sweep}, SWEEPS)["bare"]["median"]
            return {
                **told(solution),
                "seconds": seconds,
                "cpu seconds": cpu,
                "bare": (before + after) / 2.0,
            }

        records.append({"sigma": 0.0, "seed": 0, **run(guess)})
        for sigma in SIGMAS[:1] if quick else SIGMAS:
            for seed in range(2 if quick else STARTS):
                x = start(problem, sigma, seed)
                records.append({"sigma": sigma, "seed": seed, **run(x)})
    save("cold", records, quick)


if __name__ == "__main__":
    main()
