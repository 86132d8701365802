"""A sweep over speed against as many cold starts: processor time, iterations, costs."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

from common import arguments, reference_task, robot_of, save
from process import run

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import tune_process
from gaitopt.design.starts import many_starts
from gaitopt.model.robot import Robot
from gaitopt.sweep.grid import parse_axis
from gaitopt.sweep.scheduler import SweepProgress, sweep

SPEEDS, QUICK = "0.4:1.3:0.05", "0.95:1.05:0.05"
STARTS = (1, 2)
"""Of a cold design: the first guess alone, and what `gaitopt optimise` tries by default."""


class Stages:
    """How much processor each stage of a sweep takes, and how many jobs."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.jobs: dict[str, int] = {}
        self._last = time.process_time()

    def __call__(self, progress: SweepProgress) -> None:
        now, stage = time.process_time(), progress.stage
        self.seconds[stage] = self.seconds.get(stage, 0.0) + now - self._last
        self.jobs[stage] = self.jobs.get(stage, 0) + 1
        self._last = now


def cold(robot: Robot, speed: float, starts: int = 1) -> dict[str, Any]:
    """Design one gait from its first guess, or from as many starts as the command makes."""
    started, cpu = time.perf_counter(), time.process_time()
    task = reference_task(speed=speed)
    if starts == 1:
        found = design(robot, task, DesignOptions())
    else:
        found = many_starts(robot, task, count=starts).design
    return {
        "speed": speed,
        "seconds": time.perf_counter() - started,
        "cpu seconds": time.process_time() - cpu,
        "cost": found.solution.cost,
        "certified": found.certificate.certified,
        "iterations": found.solution.iterations,
    }


def swept(robot: Robot, text: str) -> dict[str, Any]:
    """Design all of them by a sweep."""
    stages = Stages()
    started, cpu = time.perf_counter(), time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        axis = parse_axis("speed", text)
        library = sweep(
            robot, reference_task(), [axis], Path(folder) / "library", on_progress=stages
        )
        rows = library.rows
    return {
        "seconds": time.perf_counter() - started,
        "cpu seconds": time.process_time() - cpu,
        "stages": {
            k: {"cpu seconds": s, "jobs": stages.jobs[k]} for k, s in stages.seconds.items()
        },
        "gaits": [
            {k: row[k] for k in ("speed", "cost", "certified", "iterations", "seconds", "origin")}
            for row in rows
        ],
    }


def commands(speeds: tuple[float, ...], text: str) -> dict[str, float]:
    """Return the seconds by the clock of one `sweep` command and of as many `optimise` commands."""
    single = ("optimise", "--quiet", "--no-page", "--no-figures", "--speed")
    with tempfile.TemporaryDirectory() as compiled:
        run((*single, "1", "--output"), compiled)  # compiles the modules
        alone = [run((*single, f"{v:g}", "--output"), compiled)["wall"] for v in speeds[::2]]
        many = run(("sweep", "--quiet", "--speeds", text, "--output"), compiled)["wall"]
        alone += [run((*single, f"{v:g}", "--output"), compiled)["wall"] for v in speeds[1::2]]
    return {"sweep": many, "optimise": sum(alone)}


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    text = QUICK if quick else SPEEDS
    robot = robot_of()
    tune_process()  # as the commands do
    cold(robot, 1.0)  # imports and caches
    speeds = parse_axis("speed", text).values
    # Before, between and after, because the load of a machine changes; the median counts.
    sweeps = [swept(robot, text)]
    half = {n: [cold(robot, speed, n) for speed in speeds[::2]] for n in STARTS}
    sweeps.append(swept(robot, text))
    data: dict[str, Any] = {}
    for starts, before in half.items():
        gaits = before + [cold(robot, speed, starts) for speed in speeds[1::2]]
        data[f"cold, {starts}"] = sorted(gaits, key=lambda one: one["speed"])
    sweeps.append(swept(robot, text))
    data["sweep"] = sorted(sweeps, key=lambda one: one["cpu seconds"])[1]
    data["sweeps, cpu seconds"] = [one["cpu seconds"] for one in sweeps]
    data["commands"] = commands(speeds, text)
    save("sweep", data, quick)


if __name__ == "__main__":
    main()
