"""Whether gaits walk in simulation: 100 steps of many robots, and a library of the biped.

python benchmarks/walks.py [--quick]

The tables of docs/simulation.md are made of it: it prints them. Robots whose package is not
installed are left out.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, robot_of, save
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.design.walkability import weak_points
from gaitopt.errors import GaitoptError
from gaitopt.gait.presets import preset_task
from gaitopt.gait.result import Gait
from gaitopt.model.robot import Robot
from gaitopt.simulate.battery import battery
from gaitopt.simulate.second_engine import second_engine
from gaitopt.simulate.walk import WalkOptions, simulate

STEPS, DEFAULT_STEPS = 100, 20
WALKS = (
    ("biped13", 0.5),
    ("biped13", 0.8),
    ("biped13", 1.0),
    ("biped13", 1.2),
    ("g1", 0.6),
    ("talos", 0.5),
    ("icub", 0.3),
    ("T1", 0.5),
    ("GR3", 0.6),
)
"""Robots and speeds [m/s]."""
FILES = {
    "T1": ("holosoma", "data/robots/t1/t1_29dof.urdf"),
    "GR3": ("fourier_robot_descriptions", "assets/urdf/gr3.urdf"),
}
"""Descriptions in other packages."""
SPEEDS = np.linspace(0.4, 1.35, 20)
"""Of the library [m/s]."""


def robot_named(name: str) -> Robot | None:
    """Return a robot, None if its package is not installed."""
    if name == "biped13":
        return robot_of()
    if name not in FILES:
        source, choices = description(entry_by_name(name))
        return Robot.from_urdf(source, choices=choices)
    package, inside = FILES[name]
    found = find_spec(package)
    if found is None or found.submodule_search_locations is None:
        return None
    return Robot.from_urdf(Path(next(iter(found.submodule_search_locations))) / inside)


def walked(gait: Gait, steps: int) -> dict[str, Any]:
    """Return what a simulated walk is, timed by the processor."""
    began = time.process_time()
    walk = simulate(gait, WalkOptions(steps=steps))
    seconds = time.process_time() - began
    weak = [point for point in weak_points(gait) if point.weak]
    return {
        "ending": walk.ending.value,
        "steps": walk.steps,
        "asked": steps,
        "speed_ratio": walk.speed / gait.speed,
        "designed_cost": walk.designed_cost,
        "cost_ratio": walk.cost / walk.designed_cost,
        "real_time": walk.simulated / seconds,
        "second_engine": second_engine(gait).largest,
        "cause": str(weak[0]) if weak and not walk.walked else "",
    }


def rows(asked: list[tuple[str, float]], preset: str, steps: int) -> Iterator[dict[str, Any]]:
    """Yield designed and simulated walks."""
    for name, speed in asked:
        robot = robot_named(name)
        if robot is None:
            continue
        row = {"robot": name, "speed": speed, "preset": preset}
        try:
            usual = "standard" if name == "biped13" else "humanoid"
            task = preset_task(preset or usual, robot, speed=float(speed))
            found = design_gait(robot, task)
        except GaitoptError as error:
            yield {**row, "verdict": str(error).splitlines()[0]}
            continue
        yield {**row, "verdict": found.certificate.verdict, **walked(found.gait, steps)}


def line(row: dict[str, Any]) -> list[str]:
    """Return a walk as a line of the table."""
    cells = [f"{row['robot']} {row['speed']:.2f} m/s"]
    if "steps" not in row:
        return [*cells, row["verdict"], *[""] * 5]
    end = f"{row['steps']}" if row["steps"] == row["asked"] else f"fell after {row['steps']}"
    numbers = (
        f"{row[name]:.3f}" if np.isfinite(row[name]) else "-"
        for name in ("speed_ratio", "cost_ratio")
    )
    return [
        *cells,
        end,
        *numbers,
        f"{row['designed_cost']:.0f}",
        f"{row['real_time']:.1f}",
        f"{row['second_engine']:.0e}",
    ]


HEAD = ("gait", "steps", "speed / designed", "cost / designed", "designed cost", "x real time",
        "second engine")  # fmt: skip


def thorough() -> dict[str, Any]:
    """Return what a robust biped at 1 m/s survives."""
    robot = robot_of()
    gait = design_gait(robot, preset_task("robust", robot, speed=1.0)).gait
    found = battery(gait, thorough=True)
    return {
        "checks": {one.check.name: one.passed for one in found.checks},
        "pushes_Ns": {push.direction: push.impulse for push in found.pushes},
        "starts": f"{found.starts_walked} of {len(found.starts)}",
    }


def main(quick: bool) -> None:
    """Design, walk, print, save."""
    with small_matrices():
        some = list(WALKS[2:3] if quick else WALKS)
        robust = list(rows(some, "robust", DEFAULT_STEPS if quick else STEPS))
        print(f"Preset robust\n\n{table(HEAD, map(line, robust))}")
        usual = [] if quick else list(rows(some, "", DEFAULT_STEPS))
        print(f"\nDefault\n\n{table(HEAD, map(line, usual))}")
        speeds = [("biped13", round(float(v), 2)) for v in SPEEDS[:: 20 if quick else 1]]
        library = list(rows(speeds, "robust", DEFAULT_STEPS if quick else STEPS))
        share = sum(row.get("steps") == row.get("asked", 0) for row in library) / len(library)
        print(f"\nLibrary: {100.0 * share:.0f} % walk\n\n{table(HEAD, map(line, library))}")
        survived = {} if quick else thorough()
        print(f"\n{survived}")
    save(
        "walks",
        {"robust": robust, "default": usual, "library": library, "share": share, **survived},
        quick,
    )


if __name__ == "__main__":
    main(arguments(__doc__).parse_args().quick)
