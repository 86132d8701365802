"""What the physics beside the rigid bodies costs: rotors, damping and friction of real robots.

The tables of docs/physics.md are made of it: `python benchmarks/physics.py` prints them.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save
from tables import table

from gaitopt.catalogue.entries import catalogue, description, entry_by_name
from gaitopt.design.design import design
from gaitopt.design.pipeline import Design
from gaitopt.design.process import small_matrices
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.task import Task
from gaitopt.mechanics import newton_euler as chain_loads
from gaitopt.mechanics import single_support as passive
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot

ARMATURES = (0.0, 1e-4, 3e-4, 1e-3, 1e-2)
"""Of every joint of G1 [kg·m²]."""

FRICTION_RATES = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Rates in which friction turns round [rad/s]."""

RUBBING = Path(__file__).parents[1] / "tests" / "data" / "cases" / "urdf_damping_friction.urdf"
RIGID = ("friction", "damping", "springs", "armature")


def free_task(robot: Robot, **changes: Any) -> Task:
    """Return the walk of docs/performance.md: without the habits of docs/habits.md."""
    return humanoid_task(robot, swing_height=None, swing_tilt=None, **changes)


def figures(found: Design) -> dict[str, Any]:
    """What is compared of a walk."""
    gait = found.gait
    jump = np.abs(gait.rate_after - gait.rate_before)
    torque = np.abs(gait.torque).max(axis=0)
    knees = [k for k, name in enumerate(gait.joint_names) if "knee" in name.lower()]
    return {
        "cost": gait.cost,
        "knee": float(torque[knees].max()) if knees else None,
        "largest": float(torque.max()),
        "rear ankle": float(jump[:2].max()),
        "impulse": float(gait.impulse[2]),
        "verdict": found.certificate.verdict,
        "referee": found.certificate.referee.worst,
    }


def rotors() -> Iterator[dict[str, Any]]:
    """G1 at 0.6 m/s with more and more rotor inertia, and with what is published."""
    source, choices = description(entry_by_name("g1"))
    given = {f"{a:g}": (LimitOverride("*", armature=a),) for a in ARMATURES}
    for name, limits in {**given, "published": choices.limits}.items():
        robot = Robot.from_urdf(source, choices=choices.over(limits=limits))
        yield {
            "armature": name,
            **figures(design(robot, free_task(robot, speed=0.6))),
        }


def robots() -> Iterator[dict[str, Any]]:
    """Robots of the catalogue, rigid bodies alone and with all that counts."""
    for entry in catalogue():
        if not entry.file:
            continue
        source, choices = description(entry)
        bare = Robot.from_urdf(source, choices=choices.over(without=RIGID))
        whole = Robot.from_urdf(source, choices=choices)
        task = free_task(bare, **entry.task)
        same = whole.physics.passive is None and not whole.model.armature.any()
        row = {"robot": entry.name, "speed": task.speed, "bare": figures(design(bare, task))}
        yield row if same else {**row, "whole": figures(design(whole, task))}


def smoothness() -> Iterator[dict[str, Any]]:
    """A walk with 3 N·m of friction in each joint, friction turning round at other rates."""
    robot = Robot.from_urdf(RUBBING, choices=ImportOptions(without=("damping",)))
    usual = passive.FRICTION_RATE
    for rate in FRICTION_RATES:
        passive.FRICTION_RATE = chain_loads.FRICTION_RATE = rate
        yield {
            "rate": rate,
            **figures(design(robot, free_task(robot, speed=0.5))),
        }
    passive.FRICTION_RATE = chain_loads.FRICTION_RATE = usual


def page(data: dict[str, list[dict[str, Any]]]) -> str:
    """Return the tables."""
    rows = [
        [r["armature"], f"{r['cost']:.1f}", f"{r['knee']:.1f}", f"{r['rear ankle']:.1f}",
         f"{r['impulse']:.1f}", r["verdict"]]
        for r in data["rotors"]
    ]  # fmt: skip
    head = ["armature, kg·m²", "J", "knee, N·m", "rear ankle's jump, rad/s", "impulse, N·s", ""]
    parts = [table(head, rows)]
    pairs = [(r, r.get("whole")) for r in data["robots"]]
    rows = [
        [r["robot"], f"{r['speed']:g}", f"{r['bare']['cost']:.2f}",
         "the same" if w is None else f"{w['cost']:.2f}",
         f"{r['bare']['largest']:.1f}", "" if w is None else f"{w['largest']:.1f}",
         r["bare"]["verdict"] if w is None else w["verdict"]]
        for r, w in pairs
    ]  # fmt: skip
    head = ["robot", "m/s", "J, rigid bodies", "J, whole", "peak, N·m", "peak, whole", ""]
    parts += [table(head, rows)]
    rows = [
        [f"{r['rate']:g}", f"{r['cost']:.2f}", f"{r['largest']:.3f}", f"{r['referee']:.0e}",
         r["verdict"]]
        for r in data["smoothness"]
    ]  # fmt: skip
    parts += [table(["epsilon, rad/s", "J", "largest torque, N·m", "referee", ""], rows)]
    return "\n\n".join(parts)


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    with small_matrices():
        parts = {"smoothness": smoothness, "rotors": rotors, "robots": robots}
        data = {name: [*part()][: 1 if quick else None] for name, part in parts.items()}
    save("physics", data, quick)
    print(page(data))


if __name__ == "__main__":
    main()
