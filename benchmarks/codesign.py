"""Co-design by the exact outer gradient, by Nelder-Mead and by CMA-ES; from five starts (long).

python benchmarks/codesign.py [--quick] [--only compare|cma|starts]

Thigh, shin, hip width and foot length of the thirteen-link biped, its leg and its mass as they are,
for walks of 0.5 to 1.2 m/s. All methods search the same function: the sum of the costs of walks
that are solved warm, from those of the best design until then. The walk at 1.0 m/s has two local
optima; who changes to the other one by luck wins or loses without merit, so that all methods begin
with the walks of the optimum, followed back to each start. Counted are, for all methods alike,
walks solved and evaluations of their programs (cost, rows and, where asked, derivatives at one x
count once; failed ones count). CMA-ES is left out where `cma` is not installed: pip install cma.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from common import RESULTS, arguments, save
from scipy.optimize import minimize

from gaitopt import DesignOptions, Robot, Task, biped13, urdf_text
from gaitopt.catalogue.parameters import changed
from gaitopt.design.codesign import (
    DesignTrial,
    Study,
    Variable,
    WalkCase,
    WarmWalks,
    codesign,
    first_walks,
    minimised,
)
from gaitopt.design.process import small_matrices
from gaitopt.nlp import Array

SPEEDS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2)
RANGES = {"shin": (0.25, 0.35), "hip_width": (0.06, 0.2), "foot_length": (0.16, 0.26)}
STARTS = (
    (0.3, 0.12, 0.214), (0.26, 0.18, 0.25), (0.34, 0.09, 0.17), (0.28, 0.1, 0.25),
    (0.33, 0.19, 0.18),
)  # fmt: skip
CLOSE = 1e-4  # relative: the same value
MOST = 100  # times the evaluations of the exact gradient, where a search without it is given up
BACK = 8  # designs by which walks are followed back to a start
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
        self, walks: WarmWalks, near: DesignTrial, target: float, most: float = np.inf
    ) -> None:
        self.walks, self.near, self.target, self.most = walks, near, target, most
        ends = np.array([[v.lower, v.upper] for v in walks.study.variables])
        self.lower, self.width = ends[:, 0], ends[:, 1] - ends[:, 0]
        self.designs, self.best = 0, near
        self.before = walks.solved, walks.evaluations
        self.started = time.process_time()

    @property
    def evaluations(self) -> int:
        return self.walks.evaluations - self.before[1]

    def trial(self, share: Array, near: DesignTrial | None) -> DesignTrial | None:
        found = self.walks.trial(self.lower + share * self.width, near or self.near)
        self.designs += 1
        if found is not None and found.cost < self.best.cost:
            self.best = found
        if self.best.cost <= self.target or self.evaluations >= self.most:
            raise FoundError
        return found

    def __call__(self, share: Array) -> float:
        """Value for searches without derivatives, from the best walks until now."""
        found = self.trial(np.clip(share, 0.0, 1.0), self.best)
        return 10.0 * self.best.cost if found is None else found.cost

    def record(self) -> dict[str, Any]:
        return {
            "designs": self.designs, "walks": self.walks.solved - self.before[0],
            "evaluations": self.evaluations, "cost": self.best.cost,
            "reached": bool(self.best.cost <= self.target),
            "values": self.best.values.tolist(), "cpu seconds": time.process_time() - self.started,
        }  # fmt: skip


def searched(counted: Counted, search: Callable[[Counted], object]) -> dict[str, Any]:
    with suppress(FoundError):
        search(counted)
    return counted.record()


def followed(walks: WarmWalks, best: DesignTrial, share: Array, ends: Array) -> DesignTrial:
    """Follow the walks of a design to another one."""
    lower, width = ends[:, 0], ends[:, 1] - ends[:, 0]
    near, begin = best, (best.values - lower) / width
    for part in np.linspace(0.0, 1.0, BACK + 1)[1:]:
        found = walks.trial(lower + ((1.0 - part) * begin + part * share) * width, near)
        assert found is not None
        near = found
    return near


def nelder_mead(share: Array) -> Callable[[Counted], object]:
    return lambda f: minimize(
        f, share, method="Nelder-Mead", bounds=[(0.0, 1.0)] * share.size,
        options={"maxfev": 10_000, "xatol": 1e-6, "fatol": 1e-6},
    )  # fmt: skip


def cma_es(share: Array) -> Callable[[Counted], object] | None:
    try:
        import cma
    except ImportError:
        return None
    return lambda f: cma.fmin(f, share, 0.25, {"bounds": [0.0, 1.0], "seed": 1, "verbose": -9})


def compared(quick: bool, cma: bool) -> dict[str, Any]:
    """Return what each method takes from each start to the same value.

    Args:
        quick: whether to compare for two walks from one start.
        cma: whether to search by CMA-ES alone, which takes the longest.
    """
    speeds = COMPARED[:: 3 if quick else 1]
    asked = study(STARTS[2], speeds)
    ends = np.array([[v.lower, v.upper] for v in asked.variables])
    shares = [(np.array(at) - ends[:, 0]) / (ends[:, 1] - ends[:, 0]) for at in STARTS]
    walks = WarmWalks(asked, list(first_walks(asked, DesignOptions())), DesignOptions())

    def evaluate(share: Array, near: DesignTrial | None) -> DesignTrial | None:
        return walks.trial(ends[:, 0] + share * (ends[:, 1] - ends[:, 0]), near)

    best = minimised(evaluate, shares[2], ends[:, 1] - ends[:, 0])
    target, rows = best.cost * (1.0 + CLOSE), list[dict[str, Any]]()
    for number, (at, share) in enumerate(zip(STARTS, shares, strict=True)):
        if quick and number > 0:
            break
        near = followed(walks, best, share, ends)
        row: dict[str, Any] = {"start": at, "cost": near.cost}
        own = Counted(walks, near, target)
        row["exact gradient"] = searched(own, lambda f, s=share: minimised(f.trial, s, f.width))
        most = MOST * row["exact gradient"]["evaluations"]
        name, method = ("CMA-ES", cma_es(share)) if cma else ("Nelder-Mead", nelder_mead(share))
        if method is not None:
            row[name] = searched(Counted(walks, near, target, most), method)
        rows.append(row)
        print(row, flush=True)
    return {"speeds": speeds, "target": target, "rows": rows}


def from_starts(quick: bool) -> list[dict[str, Any]]:
    """Return what the whole co-design finds from each start."""
    rows = []
    for at in STARTS[: 1 if quick else None]:
        began = time.process_time()
        found = codesign(study(at, SPEEDS[:: 7 if quick else 1]), DesignOptions())
        rows.append({
            "start": at, "values": dict(found.values), "cpu seconds": time.process_time() - began,
            "before": sum(float(gait.cost or 0.0) for gait in found.before),
            "after": sum(float(gait.cost or 0.0) for gait in found.after),
            "designs": len(found.trials), "evaluations": found.evaluations,
            "certified": [g.fact("certificate", "certified") is True for g in found.after],
            "held": list(found.held),
        })  # fmt: skip
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--only", choices=("compare", "cma", "starts"))
    given = parser.parse_args()
    found: dict[str, Any] = {"ranges": RANGES, "speeds": SPEEDS}
    with small_matrices():
        if given.only in (None, "compare"):
            found["compared"] = compared(given.quick, cma=False)
        if given.only in (None, "cma"):
            found["searched by CMA-ES"] = compared(given.quick, cma=True)
        if given.only in (None, "starts"):
            found["starts"] = from_starts(given.quick)
    kept = RESULTS / "codesign.json"
    if given.only is not None and kept.exists():
        found = {**json.loads(kept.read_text("utf-8"))["data"], **found}
    save("codesign", found, given.quick)


if __name__ == "__main__":
    main()
