"""Co-design by the exact outer gradient, by Nelder-Mead and by CMA-ES; from five starts (long).

python benchmarks/codesign.py [--quick]

Thigh, shin, hip width and foot length of the thirteen-link biped, its leg and its mass as they are,
for walks of 0.5 to 1.2 m/s. All methods search the same warm walks; what they take is counted in
evaluations of a walk. CMA-ES is left out where `cma` is not installed: pip install cma.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from common import arguments, save
from scipy.optimize import minimize

from gaitopt import DesignOptions, Robot, Task, biped13, urdf_text
from gaitopt.catalogue.parameters import changed
from gaitopt.design.codesign import (
    Study,
    Trial,
    Variable,
    WalkCase,
    WarmWalks,
    codesign,
    first_walks,
    minimised,
)
from gaitopt.design.process import small_matrices
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array

SPEEDS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
RANGES = {"shin": (0.25, 0.35), "hip_width": (0.06, 0.2), "foot_length": (0.16, 0.26)}
STARTS = (
    (0.3, 0.12, 0.214), (0.26, 0.18, 0.25), (0.34, 0.09, 0.17), (0.28, 0.1, 0.25),
    (0.33, 0.19, 0.18),
)  # fmt: skip
CLOSE = 1e-4  # relative: the same value
MOST = 30  # times the evaluations of the exact gradient, where a search without it is given up
COMPARED = (0.5, 0.7, 1.0, 1.2)
"""Speeds of the walks for which methods are compared [m/s]."""


class FoundError(Exception):
    """The value is reached."""


def robot(values: dict[str, float]) -> Robot:
    return Robot.from_urdf(urdf_text(changed(biped13(), values)))


def study(start: tuple[float, ...], speeds: Sequence[float]) -> Study:
    variables = tuple(
        Variable(name, *ends, at) for (name, ends), at in zip(RANGES.items(), start, strict=True)
    )
    walks = tuple(WalkCase(f"{v:g} m/s", 1.0, Task(speed=v, duration=0.4), robot) for v in speeds)
    return Study(biped13(), variables, walks, keep_leg=True)


class Counted:
    """The cost of a design, as a function of shares of the ranges; counts what it takes."""

    def __init__(
        self, study: Study, first: list[Gait], target: float, most: float = np.inf
    ) -> None:
        self.walks = WarmWalks(study, first, DesignOptions())
        ends = np.array([[v.lower, v.upper] for v in study.variables])
        self.lower, self.width = ends[:, 0], ends[:, 1] - ends[:, 0]
        self.target, self.most, self.designs, self.evaluations = target, most, 0, 0
        self.best: Trial | None = None
        self.started = time.process_time()

    def trial(self, share: Array, near: Trial | None) -> Trial | None:
        found = self.walks.trial(self.lower + share * self.width, near)
        self.designs += 1
        if found is not None:
            self.evaluations += found.evaluations
            if self.best is None or found.cost < self.best.cost:
                self.best = found
        return found

    def __call__(self, share: Array) -> float:
        """Value for searches without derivatives, from the best walks until now."""
        found = self.trial(np.clip(share, 0.0, 1.0), self.best)
        assert self.best is not None
        if self.best.cost <= self.target or self.evaluations >= self.most:
            raise FoundError
        return 10.0 * self.best.cost if found is None else found.cost

    def record(self) -> dict[str, Any]:
        assert self.best is not None
        return {
            "designs": self.designs, "evaluations": self.evaluations, "cost": self.best.cost,
            "reached": bool(self.best.cost <= self.target),
            "values": self.best.values.tolist(), "cpu seconds": time.process_time() - self.started,
        }  # fmt: skip


def without_derivatives(counted: Counted, search: Callable[[Counted], object]) -> dict[str, Any]:
    with suppress(FoundError):
        search(counted)
    return counted.record()


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    data: dict[str, Any] = {"compared": COMPARED, "ranges": RANGES, "speeds": SPEEDS, "starts": []}
    with small_matrices():
        asked = study(STARTS[0], COMPARED[:: 3 if quick else 1])
        first = list(first_walks(asked, DesignOptions()))
        start = np.array([(v.start - v.lower) / (v.upper - v.lower) for v in asked.variables])
        own = Counted(asked, first, -np.inf)
        minimised(own.trial, start, own.width)
        data["exact gradient"] = own.record()
        target = own.best.cost * (1.0 + CLOSE) if own.best else -np.inf
        # until the same value, for what comes last only polishes
        again = Counted(asked, first, target)

        def until(share: Array, near: Trial | None) -> Trial | None:
            found = again.trial(share, near)
            if again.best is not None and again.best.cost <= target:
                raise FoundError
            return found

        data["exact gradient, until the same value"] = without_derivatives(
            again, lambda _: minimised(until, start, again.width)
        )
        print(data, flush=True)
        most = MOST * again.evaluations
        data["Nelder-Mead"] = without_derivatives(
            Counted(asked, first, target, most),
            lambda f: minimize(
                f, start, method="Nelder-Mead", bounds=[(0.0, 1.0)] * start.size,
                options={"maxfev": 10_000, "xatol": 1e-6, "fatol": 1e-6},
            ),
        )  # fmt: skip
        print(data["Nelder-Mead"], flush=True)
        try:
            import cma
        except ImportError:
            pass
        else:
            data["CMA-ES"] = without_derivatives(
                Counted(asked, first, target, most),
                lambda f: cma.fmin(
                    f, start, 0.25,
                    {"bounds": [0.0, 1.0], "seed": 1, "verbose": -9},
                ),
            )  # fmt: skip
        print(data, flush=True)
        for at in STARTS[: 1 if quick else None]:
            began = time.process_time()
            found = codesign(study(at, SPEEDS[:: 7 if quick else 1]), DesignOptions())
            data["starts"].append({
                "start": at, "values": dict(found.values),
                "cpu seconds": time.process_time() - began,
                "before": sum(float(gait.cost or 0.0) for gait in found.before),
                "after": sum(float(gait.cost or 0.0) for gait in found.after),
                "designs": len(found.trials), "evaluations": found.evaluations,
                "certified": [g.fact("certificate", "certified") is True for g in found.after],
                "held": list(found.held),
            })  # fmt: skip
            print(data["starts"][-1], flush=True)
    save("codesign", data, quick)


if __name__ == "__main__":
    main()
