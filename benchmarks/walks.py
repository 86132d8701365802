"""Whether gaits walk in simulation: 100 steps of many robots, every way, a library of the biped.

python benchmarks/walks.py [--quick] [--only PART ...]

The tables of docs/performance.md are made of it. Robots whose package is not installed are left
out.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, robot_of, save, saved
from walks_section import walk_table

from gaitopt import biped13, urdf_text
from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.design.walkability import weak_points
from gaitopt.errors import GaitoptError
from gaitopt.gait.presets import preset_task
from gaitopt.gait.result import Gait
from gaitopt.model.import_options import ImportOptions, Payload
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
WAYS: tuple[tuple[str, str, str, dict[str, Any]], ...] = (
    ("backward", "biped13", "robust", {"speed": -0.4}),
    ("sideways", "biped13", "robust", {"speed": 0.0, "lateral_speed": 0.2, "duration": 0.5}),
    ("ahead and aside", "biped13", "robust",
     {"speed": 0.5, "lateral_speed": 0.15, "duration": 0.5}),
    ("along a circle", "biped13", "robust", {"speed": 0.5, "turn_rate": 0.4}),
    ("turning in place", "biped13", "robust", {"speed": 0.0, "turn_rate": 0.5, "duration": 0.5}),
    ("slope of 6 %", "biped13", "robust", {"speed": 0.8, "slope": float(np.arctan(0.06))}),
    ("stairs of 0.10 m", "biped13", "robust", {"speed": 0.5, "stairs": 0.1}),
    ("load of 10 kg", "biped13", "robust", {"speed": 0.8}),
    ("both feet for 50 ms", "biped13", "robust",
     {"speed": 0.8, "duration": 0.5, "double_support": 0.05, "boundary": "closed"}),
    ("heel until 0.2", "biped13", "humanoid",
     {"speed": 1.0, "duration": 0.5, "heel_strike": 0.2}),
    ("heel until 0.15, toe from 0.7", "biped13", "humanoid",
     {"speed": 1.0, "duration": 0.5, "heel_strike": 0.15, "toe_off": 0.7}),
    ("heel and toe along a circle", "biped13", "humanoid",
     {"speed": 1.0, "duration": 0.5, "heel_strike": 0.15, "toe_off": 0.7, "turn_rate": 0.3}),
    ("toe from 0.7", "biped13", "standard", {"speed": 1.2, "duration": 0.5, "toe_off": 0.7}),
    ("along a circle", "g1", "robust", {"speed": 0.4, "turn_rate": 0.3}),
    ("backward", "g1", "robust", {"speed": -0.3}),
    ("toe from 0.7", "g1", "robust", {"speed": 0.8, "duration": 0.5, "toe_off": 0.7}),
    ("both feet for 50 ms", "g1", "robust",
     {"speed": 0.5, "duration": 0.5, "double_support": 0.05, "boundary": "closed"}),
)  # fmt: skip
"""Other walks: name, robot, preset, task."""
LOADED = "load of 10 kg"
THOROUGH = "thorough"
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
        "speed_ratio": _ratio(walk.speed, walk.designed_speed),
        "designed_cost": _ratio(walk.designed_cost, 1.0),
        "cost_ratio": _ratio(walk.cost, walk.designed_cost),
        "real_time": walk.simulated / seconds,
        "second_engine": second_engine(gait).largest,
        "cause": str(weak[0]) if weak and not walk.walked else "",
    }


def _ratio(a: float, b: float) -> float | None:
    """Return a / b, None where it has no value: of a walk in place, of one that fell at once."""
    return a / b if np.isfinite([a, b]).all() and b else None


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


def ways() -> Iterator[dict[str, Any]]:
    """Yield walks in other ways, each of the first guess with its phases as they are given."""
    for words, name, preset, changes in WAYS:
        robot = robot_named(name)
        if robot is None:
            continue
        if words == LOADED:
            loaded = ImportOptions(payloads=(Payload("torso", 10.0),))
            robot = Robot.from_urdf(urdf_text(biped13()), choices=loaded)
        row = {"robot": f"{name}, {words},", "speed": changes["speed"], "preset": preset}
        task = preset_task(preset, robot, **changes)
        try:
            found = design_gait(robot, task, DesignOptions(toe_begin="given"), starts=1)
        except GaitoptError as error:
            yield {**row, "verdict": str(error).splitlines()[0]}
            continue
        yield {**row, "verdict": found.certificate.verdict, **walked(found.gait, DEFAULT_STEPS)}


def thorough() -> dict[str, Any]:
    """Return what a robust biped at 1 m/s survives."""
    robot = robot_of()
    gait = design_gait(robot, preset_task("robust", robot, speed=1.0)).gait
    found = battery(gait, thorough=True)
    return {
        "checks": [
            {
                "name": one.check.name,
                "passed": one.passed,
                "speed_ratio": _ratio(one.walk.last_speed, one.walk.designed_speed),
                "cost_ratio": _ratio(one.walk.cost, one.walk.designed_cost),
            }
            for one in found.checks
        ],
        "pushes_Ns": {push.direction: push.impulse for push in found.pushes},
        "starts": f"{found.starts_walked} of {len(found.starts)}",
    }


def main(quick: bool, only: list[str]) -> None:
    """Design, walk, print; save what there is after each part."""
    some = list(WALKS[2:3] if quick else WALKS)
    steps, few = DEFAULT_STEPS if quick else STEPS, DEFAULT_STEPS
    speeds = [("biped13", round(float(v), 2)) for v in SPEEDS[:: 20 if quick else 1]]
    parts: dict[str, Callable[[], Iterable[dict[str, Any]]]] = {
        "robust": lambda: rows(some, "robust", steps),
        "ways": lambda: [] if quick else ways(),
        "default": lambda: [] if quick else rows(some, "", few),
        "library": lambda: rows(speeds, "robust", steps),
    }
    found: dict[str, Any] = {} if quick or not only else saved("walks")
    with small_matrices():
        for name, part in parts.items():
            if name in only or not only:
                found[name] = list(part())
                print(f"\n{name.capitalize()}\n\n{walk_table(found[name])}", flush=True)
                save("walks", found, quick)
        walking = [row for row in found["library"] if row.get("steps") == row.get("asked", 0)]
        found["share"] = len(walking) / len(found["library"])
        print(f"\nLibrary: {100.0 * found['share']:.0f} % walk")
        if THOROUGH in only or not (only or quick):
            found |= thorough()
        print({name: found[name] for name in found if name not in parts})
        save("walks", found, quick)


if __name__ == "__main__":
    parser = arguments(__doc__)
    parser.add_argument(
        "--only", nargs="+", default=[], help="parts to run, the others stay as they were saved",
        choices=("robust", "ways", "default", "library", THOROUGH),
    )  # fmt: skip
    asked = parser.parse_args()
    main(asked.quick, asked.only)
