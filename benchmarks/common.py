"""What the benchmarks share: robot, walk, starts, paired clocks, counters, results on disk."""

from __future__ import annotations

import argparse
import datetime
import itertools
import json
import os
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from gaitopt import biped13, urdf_text
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.errors import EvaluationError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task
from gaitopt.model.robot import Robot
from gaitopt.nlp import NLP, Array, Point, Progress, Solution, Values

RESULTS = Path(__file__).parent / "results"
PACKAGES = (
    "pin", "numpy", "scipy", "qpsolvers", "daqp", "cyipopt-wheels", "drake", "gaitopt",
)  # fmt: skip


def robot_of(spec: BipedSpec | None = None) -> Robot:
    """Return a biped on its right foot; by default the paper's."""
    text = urdf_text(spec or biped13())
    return Robot.from_urdf(text, stance_sole="right_sole", swing_sole="left_sole")


def reference_task(**changes: object) -> Task:
    """Return the program that is compared with others: of the preset `standard`, but for torsion.

    Neither the paper nor other solutions limit the turning moment under the foot; figures that
    stand beside theirs, or were measured before `standard` had the limit, are of this one.
    """
    return preset_task("standard", **{"torsional_friction": None, **changes})


def walk(**changes: object) -> WalkProblem:
    """Return that walk at 1.0 m/s of the paper's biped, with some fields changed."""
    return WalkProblem(robot_of(), reference_task(**{"speed": 1.0, **changes}))


def start(problem: WalkProblem, sigma: float = 0.0, seed: int = 0) -> Array:
    """Return the first guess, with normal noise on the joint parameters if sigma is not zero."""
    guess = first_guess(problem)
    return perturbed(problem, guess, sigma, seed) if sigma else guess


def interleaved(
    functions: Mapping[str, Callable[[], object]], rounds: int
) -> dict[str, dict[str, float]]:
    """Time functions in turn, so that all of them see the same load.

    The clock is that of the process: on a busy machine a call may have to wait for its turn.

    Returns:
        Minimum and median CPU time of each [s].
    """
    times: dict[str, list[float]] = {name: [] for name in functions}
    for function in functions.values():
        function()
    for _ in range(rounds):
        for name, function in functions.items():
            started = time.process_time()
            function()
            times[name].append(time.process_time() - started)
    return {
        name: {"min": min(taken), "median": float(np.median(taken))}
        for name, taken in times.items()
    }


class BareSweep:
    """One `computeRNEADerivatives` call per sample: the least that exact derivatives can cost.

    Like the evaluation it works in one `pin.Data`; each call takes the next point.
    """

    def __init__(self, problem: WalkProblem, *points: Array) -> None:
        self._model = problem.robot.model
        self._data = self._model.createData()
        self._motions = itertools.cycle([self._motion(problem, x) for x in points])

    def __call__(self) -> None:
        model, data = self._model, self._data
        for state in next(self._motions):
            pin.computeRNEADerivatives(model, data, *state)

    def _motion(self, problem: WalkProblem, x: Array) -> list[tuple[Array, Array, Array]]:
        """Return configuration, rate and acceleration of the free-floating model at the samples."""
        count, nv = problem.grid.count, self._model.nv
        q = np.tile(pin.neutral(self._model), (count, 1))
        v, a = np.zeros((count, nv)), np.zeros((count, nv))
        q[:, 7:], v[:, 6:], a[:, 6:] = problem.step(x).motion
        return list(zip(q, v, a, strict=True))


class OutOfTimeError(Exception):
    """The time allowed is over, for solvers that cannot be asked to stop."""


@dataclass
class Clock:
    """Stops a solver after some CPU time, as a `stop` callback."""

    seconds: float
    started: float = field(default_factory=time.process_time)

    def __call__(self, _: Progress | None = None) -> bool:
        return time.process_time() - self.started > self.seconds


class TimedNLP(NLP):
    """A program that counts its evaluations and the time they take.

    Values and derivatives asked at the same x in a row are one evaluation.
    """

    def __init__(
        self, nlp: NLP, hessian: bool = True, limit: float = np.inf, raising: bool = False
    ) -> None:
        self._nlp = nlp
        self.variables, self.rows, self.cost_scale = nlp.variables, nlp.rows, nlp.cost_scale
        self.has_hessian = hessian and nlp.has_hessian
        self.evaluations = self.points = self.hessians = self.failures = 0
        self.seconds = self.cpu_seconds = 0.0
        self.out_of_time, self._raising = Clock(limit), raising
        self._last = np.empty(0)

    def values(self, x: Array) -> Values:
        self._count(x)
        return self._timed(self._nlp.values, x)

    def point(self, x: Array) -> Point:
        self._count(x)
        self.points += 1
        return self._timed(self._nlp.point, x)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        self.hessians += 1
        return self._timed(self._nlp.hessian, x, multipliers, cost_weight)

    def describe(self, row: int) -> str:
        return self._nlp.describe(row)

    def _count(self, x: Array) -> None:
        if self._raising and self.out_of_time():
            raise OutOfTimeError
        if not np.array_equal(x, self._last):
            self.evaluations += 1
            self._last = np.array(x)

    def _timed(self, function: Callable[..., Any], *arguments: object) -> Any:
        started, cpu = time.perf_counter(), time.process_time()
        try:
            return function(*arguments)
        except EvaluationError:
            self.failures += 1
            raise
        finally:
            self.seconds += time.perf_counter() - started
            self.cpu_seconds += time.process_time() - cpu


def machine() -> dict[str, object]:
    """Return what a figure depends on besides the code; no names, no paths."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
        "cpus": os.cpu_count(),
        "load": round(os.getloadavg()[0], 2),
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "versions": versions,
    }


def save(name: str, data: object, quick: bool) -> None:
    """Write a result; a quick run is printed only."""
    record = {"machine": machine(), "data": data}
    if quick:
        print(json.dumps(record, indent=1))
        return
    RESULTS.mkdir(exist_ok=True)
    text = json.dumps(record, indent=1, allow_nan=False)
    (RESULTS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def saved(name: str) -> Any:
    """Return a result that is saved."""
    return json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))["data"]


def arguments(description: str | None) -> argparse.ArgumentParser:
    """Return a parser that knows `--quick`."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="a small run; saves nothing")
    return parser


def told(solution: Solution) -> dict[str, Any]:
    """Return what every benchmark keeps of a solution."""
    return {
        "status": solution.status.name,
        "cost": solution.cost,
        "violation": solution.violation,
        "kkt": solution.optimality,
        "iterations": solution.iterations,
        "evaluations": solution.evaluations,
    }
