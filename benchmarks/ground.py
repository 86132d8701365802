"""What slopes and stairs ask of robots, against level ground.

python benchmarks/ground.py [--quick]

The tables of docs/ground.md are made of it: it prints them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from common import arguments, robot_of, save
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.design.summary import motor_summaries
from gaitopt.errors import NoGaitFoundError
from gaitopt.gait.presets import preset_task
from gaitopt.model.robot import Robot

SLOPE, RISE = float(np.arctan(0.1)), 0.17
ROBOTS = {
    "biped13": (0.8, 0.4, 0.5, 0.7),
    "g1": (0.6, 0.4, 0.4, 0.7),
    "talos": (0.5, 0.6, 0.4, 0.8),
}
"""Speed [m/s] and duration of a step [s] on slopes, then on stairs."""


def walks(name: str, quick: bool) -> Iterator[dict[str, Any]]:
    """Yield the walks of a robot: level, up and down a slope; level, up and down stairs."""
    robot, preset = robot_of(), "standard"
    if name != "biped13":
        source, choices = description(entry_by_name(name))
        robot, preset = Robot.from_urdf(source, choices=choices), "humanoid"
    slow, fast = ROBOTS[name][2:], ROBOTS[name][:2]
    asked = [
        ("level", fast, {}),
        ("10 % up", fast, {"slope": SLOPE}),
        ("10 % down", fast, {"slope": -SLOPE}),
        ("level", slow, {}),
        ("0.17 m up", slow, {"stairs": RISE}),
        ("0.17 m down", slow, {"stairs": -RISE}),
    ]
    for ground, (speed, duration), changes in asked[: 1 if quick else None]:
        task = preset_task(preset, robot, speed=speed, duration=duration, **changes)
        row = {"robot": name, "ground": ground, "speed": speed, "duration": duration}
        try:
            found = design_gait(robot, task)
        except NoGaitFoundError as error:
            yield {**row, "verdict": str(error)}
            continue
        motors = {
            str(one["joint"]): [one["peak_torque_Nm"], one["peak_power_W"]]
            for one in motor_summaries(found.gait)
        }
        yield {
            **row,
            "verdict": found.certificate.verdict,
            "cost": found.gait.cost,
            "motors": motors,
        }


def text(data: list[dict[str, Any]]) -> str:
    """Return the tables, one for each robot."""
    parts = []
    for name in dict.fromkeys(row["robot"] for row in data):
        own = [row for row in data if row["robot"] == name]
        joints = list(next(row["motors"] for row in own if "motors" in row))
        lines = []
        for row in own:
            walk = f"{row['ground']}, {row['speed']:g} m/s, {row['duration']:g} s"
            cost = f"{row['cost']:.0f}" if "cost" in row else "–"
            motors = [
                "{:.0f}, {:.0f}".format(*row["motors"][joint]) if "motors" in row else "–"
                for joint in joints
            ]
            lines.append([walk, cost, *motors, row["verdict"]])
        head = ["walk", "cost, N²·m·s", *(f"{joint}: N·m, W" for joint in joints), "verdict"]
        parts.append(f"### {name}\n\n{table(head, lines)}")
    return "\n\n".join(parts)


def main() -> None:
    """Design all walks, print their tables and save them."""
    quick = arguments(__doc__).parse_args().quick
    with small_matrices():
        data = [row for name in ROBOTS for row in walks(name, quick)]
    print(text(data))
    save("ground", data, quick)


if __name__ == "__main__":
    main()
