"""Walks whose foot lands on its heel or turns about its toe, against those that stand flat.

python benchmarks/phases.py [--quick] [SECTION...]

The tables of docs/phases.md are those that it prints, its figure is made of what it saves; sections
that are not run keep their results.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from common import RESULTS, arguments, robot_of, save
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import Design, attempt
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.errors import GaitoptError
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.presets import humanoid_task, preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import TOUCH_DOWNS, Task
from gaitopt.model.robot import Robot

SPEEDS = (0.6, 0.8, 1.0, 1.2, 1.4, 1.6)
DURATIONS = (0.4, 0.5)
"""Speeds of the biped [m/s], and first guesses of the duration of its steps, which is free [s]."""
BEGIN = 0.7
STARTS, SIGMA = 10, 0.1
ROBOTS = {"g1": ((0.8, 0.5), (1.0, 0.5)), "talos": ((0.8, 0.7), (1.0, 0.6))}
"""Speeds [m/s] and durations of steps [s] of other robots."""
FREE_WALKS = {
    "g1": ((0.6, 0.8, 1.0, 1.2), (0.4, 0.5)),
    "talos": ((0.6, 0.8, 1.0, 1.2), (0.6,)),
}
"""Speeds of other robots [m/s], and first guesses of the duration of their steps [s]."""


standard_task = partial(preset_task, "standard")
"""Makes the task of the biped's walks, with torsional friction as the command line has it."""


def free_duration(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield the best walks of the biped, flat and turning, over its speeds."""
    durations = DURATIONS[1:] if quick else DURATIONS
    for speed in SPEEDS[2:3] if quick else SPEEDS:
        yield {"speed": speed, **best_walks(robot_of(), standard_task, speed, durations)}


def others_free(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield the best walks of other robots, flat and turning, over their speeds."""
    for name, (speeds, durations) in FREE_WALKS.items():
        source, choices = description(entry_by_name(name))
        robot = Robot.from_urdf(source, choices=choices)
        of = partial(humanoid_task, robot)
        for speed in speeds[:1] if quick else speeds:
            own = durations[:1] if quick else durations
            yield {"robot": name, "speed": speed, **best_walks(robot, of, speed, own)}


def best_walks(
    robot: Robot, task_of: Callable[..., Task], speed: float, durations: tuple[float, ...]
) -> dict[str, dict[str, Any]]:
    """Return the best walk on flat feet and the best that turns, where that is kept.

    Args:
        robot, speed: of the walks.
        task_of: makes their task of speed and duration.
        durations: first guesses of the duration of a step, which is free [s].
    """
    best: dict[str, Design] = {}
    for duration in durations:
        task = task_of(speed=speed, duration=duration)
        task = task.with_changes(geometry=set_geometry(task.geometry, {"duration": FREE}))
        for changes in ({}, {"toe_off": BEGIN}):
            for one in attempted(robot, task.with_changes(**changes)):
                own = "flat" if one.problem.task.toe_off is None else "toe"
                if own not in best or one.rank < best[own].rank:
                    best[own] = one
    return {kind: record(one) for kind, one in best.items()}


FREE: dict[str, float | bool] = {"free": True}


def attempted(robot: Robot, task: Task) -> list[Design]:
    """Return the walk of a task, if there is one."""
    try:
        return [design_gait(robot, task, DesignOptions(diagnose=False))]
    except GaitoptError:
        return []


def record(one: Design) -> dict[str, Any]:
    """Return what is told of a walk."""
    gait = one.gait
    return {
        "cost": gait.cost,
        "duration": gait.duration,
        "begin": one.problem.task.toe_off,
        "angle": gait.foot_angle,
        "verdict": one.certificate.verdict,
        "iterations": one.solution.iterations,
    }


def disturbed(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield the walks of the biped at 1 m/s from disturbed first guesses."""
    robot = robot_of()
    task = standard_task(speed=1.0, duration=0.5, toe_off=BEGIN)
    problem = WalkProblem(robot, task)
    options = DesignOptions(toe_begin="given", diagnose=False)
    for seed in range(2 if quick else STARTS):
        x = perturbed(problem, first_guess(problem), SIGMA, seed)
        try:
            found = design(robot, task, options, start=x)
        except GaitoptError as error:
            yield {"seed": seed, "verdict": str(error)}
            continue
        yield {"seed": seed, **record(found)}


def others(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield walks of other robots, flat and turning."""
    for name, walks in ROBOTS.items():
        source, choices = description(entry_by_name(name))
        robot = Robot.from_urdf(source, choices=choices)
        for speed, duration in walks[: 1 if quick else None]:
            task = humanoid_task(robot, speed=speed, duration=duration, toe_off=BEGIN)
            for found in attempted(robot, task):
                times = found.gait.meta["phase_times"]
                begin = times["found"] and times["found"]["toe_off"]
                choice = {name: times[name] for name in ("cost", "flat_cost")} | {"begin": begin}
                row = {"robot": name, "speed": speed, "choice": choice}
                yield {**row, "kept": record(found)}


def iterations(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield what walks of the biped take at their samples, flat and turning, from first guesses."""
    robot = robot_of()
    for speed in SPEEDS[2:3] if quick else SPEEDS:
        counts = {}
        for kind, begin in (("flat", None), ("toe", BEGIN)):
            task = standard_task(speed=speed, duration=0.5, toe_off=begin)
            problem = WalkProblem(robot, task)
            found = attempt(problem, Search(), first_guess(problem))
            counts[kind] = {"iterations": found.iterations, "status": found.status.name.lower()}
        yield {"speed": speed, **counts}


def heel_strike(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield walks of the biped that land on their heels, alone and with a turn about the toe."""
    robot, options = robot_of(), DesignOptions(toe_begin="given", diagnose=False)
    for speed, name in ((s, n) for s in ((1.0,) if quick else (1.0, 1.2)) for n in HEELS):
        task = standard_task(speed=speed, duration=0.5).with_changes(**HEELS[name])
        try:
            found = design_gait(robot, task, options)
        except GaitoptError as error:
            yield {"speed": speed, "walk": name, "verdict": str(error)}
            continue
        softly = found.problem.task.margins.soft_landing
        impulse = 0.0 if softly else float(found.gait.impulse[2])
        row = {"speed": speed, "walk": name, "landing": found.gait.landing_angle}
        row["flat"] = [float(one) for one in found.gait.rear_impulse[2:3]]
        yield {**row, "impulse": impulse, "softly": softly, **record(found)}


def double_support(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield walks of the biped at 1 m/s over the time for which both feet stand."""
    robot, options = robot_of(), DesignOptions(diagnose=False)
    for duration in (0.5,) if quick else (0.4, 0.5):
        walks: list[tuple[str, dict[str, Any]]] = [
            ("impact", {}),
            ("zero speed", {"soft_landing": True}),
        ]
        walks += [("both", {"double_support": t}) for t in (TIMES[5:6] if quick else TIMES)]
        for kind, changes in walks:
            task = standard_task(speed=1.0, duration=duration)
            row = {"duration": duration, "kind": kind, "time": changes.get("double_support", 0.0)}
            try:
                found = design(robot, task.with_changes(**changes), options)
            except GaitoptError as error:
                yield {**row, "verdict": str(error)}
                continue
            yield {**row, **record(found), "peak": float(np.abs(found.gait.torque).max())}


def touch_down(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield walks of Alexander over the time for which both feet stand, begun in either way."""
    source, choices = description(entry_by_name("alexander"))
    robot = Robot.from_urdf(source, choices=choices)
    own = {"speed": 0.8, "duration": 0.6, "boundary": "closed"}
    walks: list[tuple[str, dict[str, Any]]] = [
        ("impact", {}),
        ("zero speed", {"soft_landing": True}),
    ]
    for time in BOTH[2:3] if quick else BOTH:
        walks += [(kind, {"double_support": time, "touch_down": kind}) for kind in TOUCH_DOWNS]
    for kind, changes in walks:
        row = {"kind": kind, "time": changes.get("double_support", 0.0)}
        try:
            task = humanoid_task(robot, **own, **changes)
            found = design(robot, task, DesignOptions(diagnose=False))
        except GaitoptError as error:
            yield {**row, "verdict": str(error)}
            continue
        impulse = [float(found.gait.impulse[2]), *map(float, found.gait.rear_impulse[2:3])]
        yield {**row, **record(found), "ended": found.problem.task.touch_down, "impulse": impulse}


def toe_off_both(quick: bool) -> Iterator[dict[str, Any]]:
    """Yield walks of the biped whose rear foot turns about its toe before and while both stand."""
    robot, options = robot_of(), DesignOptions(toe_begin="given", diagnose=False)
    for speed in (1.0,) if quick else (1.0, 1.2):
        for time in (0.1,) if quick else (0.05, 0.1):
            for begin in (None, *BEGINNINGS):
                task = standard_task(speed=speed, duration=0.5)
                row = {"speed": speed, "time": time, "turns from": begin}
                try:
                    asked = task.with_changes(double_support=time, toe_off=begin)
                    found = design(robot, asked, options)
                except GaitoptError as error:
                    yield {**row, "verdict": str(error)}
                    continue
                yield {**row, **record(found)}


BEGINNINGS = (0.5, 0.6, 0.7)
"""Shares of the step from which the rear foot turns."""


def toe_off_both_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of walks whose rear foot turns while both stand."""
    lines = []
    for speed, time in dict.fromkeys((row["speed"], row["time"]) for row in rows):
        cells = []
        for row in rows:
            if (row["speed"], row["time"]) == (speed, time):
                mark = "" if row["verdict"].startswith("certified") else "*"
                cells.append(f"{row['cost']:.0f}{mark}" if "cost" in row else "–")
        lines.append([f"{speed:g} m/s", f"{1e3 * time:g} ms", *cells])
    begins = (f"turning from {begin:g}" for begin in BEGINNINGS)
    return table(("speed", "both feet stand", "flat, N²·m·s", *begins), lines)


BOTH = (0.0006, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""For which both feet of Alexander stand [s]."""


def touch_down_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of the two ways to begin a double support."""
    found = {(row["time"], row["kind"]): row for row in rows}
    lines = []
    for time in dict.fromkeys(row["time"] for row in rows):
        for kind in [kind for at, kind in found if at == time]:
            row = found[time, kind]
            known = "cost" in row
            pushes = " + ".join(f"{one:.3g}" for one in row["impulse"]) if known else "–"
            lines.append([
                f"{1e3 * time:g} ms" if time else "none", kind,
                f"{row['cost']:.0f}" if known else "–", pushes, row["verdict"],
            ])  # fmt: skip
    head = ("both feet stand", "begun", "N²·m·s", "impulse front + rear, N·s", "verdict")
    return table(head, lines)


TIMES = (0.0006, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1)
"""For which both feet stand [s]."""


def double_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of walks with a double support."""
    lines = []
    for time in dict.fromkeys((row["kind"], row["time"]) for row in rows):
        cells = []
        for duration in dict.fromkeys(row["duration"] for row in rows):
            own = [r for r in rows if (r["kind"], r["time"]) == time and r["duration"] == duration]
            one = own[0] if own and "cost" in own[0] else None
            mark = "" if one is None or one["verdict"].startswith("certified") else "*"
            cells.append("–" if one is None else f"{one['cost']:.0f}{mark}")
        kind, span = time
        name = {"impact": "impact", "zero speed": "landing at zero speed"}.get(kind)
        lines.append([name or f"{1e3 * span:g} ms", *cells])
    durations = dict.fromkeys(row["duration"] for row in rows)
    return table(("both feet stand", *(f"steps of {d:g} s" for d in durations)), lines)


HEELS: dict[str, dict[str, Any]] = {
    "flat": {},
    "flat, at zero speed": {"soft_landing": True},
    "heel until 0.1": {"heel_strike": 0.1},
    "heel until 0.2": {"heel_strike": 0.2},
    "heel until 0.3": {"heel_strike": 0.3},
    "toe from 0.7": {"toe_off": 0.7},
    "heel until 0.15, toe from 0.7": {"heel_strike": 0.15, "toe_off": 0.7},
}
HEELS |= {
    f"{name}, then an impact": {**changes, "foot_flat": "impact"}
    for name, changes in HEELS.items()
    if "heel_strike" in changes
}


def heel_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of walks that land on their heels."""
    lines = []
    for row in rows:
        known = "cost" in row
        lines.append([
            f"{row['speed']:g} m/s", row["walk"], f"{row['cost']:.0f}" if known else "–",
            f"{row['landing']:.3f}" if known else "–",
            ("none" if row["softly"] else f"{row['impulse']:.2f}") if known else "–",
            "".join(f"{one:.2f}" for one in row.get("flat", ())) or "–",
            str(row["iterations"]) if known else "–", row["verdict"],
        ])  # fmt: skip
    head = (
        "speed", "walk", "N²·m·s", "landing, rad", "impulse, N·s", "as it lies flat", "iterations",
        "verdict",
    )  # fmt: skip
    return table(head, lines)


FREE_HEAD = (
    "speed", "flat, N²·m·s", "its step, s", "turning, N²·m·s", "its step, s", "begins at",
)  # fmt: skip


def free_cells(row: dict[str, Any]) -> list[str]:
    """Return the cells of a row of walks whose duration is free."""
    cells = [f"{row['speed']:g} m/s"]
    for kind in ("flat", "toe"):
        one = row.get(kind)
        cells += ["–", "–"] if one is None else [f"{one['cost']:.0f}", f"{one['duration']:.3f}"]
    return [*cells, f"{row['toe']['begin']:.3g}" if "toe" in row else "–"]


def iterations_table(rows: list[dict[str, Any]]) -> str:
    """Return the table of iterations at the samples."""
    lines = [
        [f"{row['speed']:g} m/s", *(str(row[kind]["iterations"]) for kind in ("flat", "toe"))]
        for row in rows
    ]
    return table(("speed", "flat", "turning"), lines)


def text(data: dict[str, Any]) -> str:
    """Return the tables."""
    parts = [table(FREE_HEAD, [free_cells(row) for row in data["free duration"]])]
    rows = [[row["robot"], *free_cells(row)] for row in data["others, free duration"]]
    parts.append(table(("robot", *FREE_HEAD), rows))
    parts.append(iterations_table(data["iterations"]))
    rows = [
        [
            one["robot"], f"{one['speed']:g} m/s, {one['kept']['duration']:g} s",
            f"{one['choice']['flat_cost'] or float('nan'):.0f}", f"{one['choice']['cost']:.0f}",
            f"{one['choice']['begin']:.3g}", one["kept"]["verdict"],
        ]
        for one in data["others"]
    ]  # fmt: skip
    head = ("robot", "walk", "flat, N²·m·s", "turning, N²·m·s", "begins at", "the cheaper one")
    parts.append(table(head, rows))
    good = [one for one in data["disturbed"] if one["verdict"].startswith("certified")]
    costs = ", ".join(f"{one['cost']:.0f}" for one in good)
    parts.append(f"Certified from {len(good)} of {len(data['disturbed'])} starts: {costs} N²·m·s.")
    parts.append(heel_table(data["heel strike"]))
    parts.append(double_table(data["double support"]))
    parts.append(touch_down_table(data["touch-down"]))
    parts.append(toe_off_both_table(data["toe-off, both feet"]))
    return "\n\n".join(parts)


SECTIONS = {
    "free duration": free_duration,
    "disturbed": disturbed,
    "others": others,
    "others, free duration": others_free,
    "iterations": iterations,
    "heel strike": heel_strike,
    "double support": double_support,
    "touch-down": touch_down,
    "toe-off, both feet": toe_off_both,
}


def main() -> None:
    """Design the walks, print their tables and save them."""
    parser = arguments(__doc__)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(SECTIONS))
    asked = parser.parse_args()
    saved = RESULTS / "phases.json"
    data = json.loads(saved.read_text())["data"] if saved.exists() and not asked.quick else {}
    with small_matrices():
        for name in asked.sections or SECTIONS:
            data[name] = list(SECTIONS[name](asked.quick))
    if data.keys() == SECTIONS.keys():
        print(text(data))
    save("phases", data, asked.quick)


if __name__ == "__main__":
    main()
