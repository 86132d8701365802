"""Infeasible walks: what is said about them, and how long it takes."""

from __future__ import annotations

import time
from typing import Any

from common import arguments, reference_task, robot_of, save

from gaitopt.design.design import design
from gaitopt.errors import NoGaitFoundError, UnreachableError

TASKS: dict[str, dict[str, float]] = {
    "torque_limit 25 N·m": {"torque_limit": 25.0},
    "speed_limit 2 rad/s": {"speed_limit": 2.0},
    "cop_margin 0.07 m": {"cop_margin": 0.07},
    "speed 3.2 m/s": {"speed": 3.2},
    "friction 0.02, torque_limit 45 N·m": {"friction": 0.02, "torque_limit": 45.0},
    "knee_flexion 2.5 rad": {"knee_flexion": 2.5},
    "liftoff_speed 1 m/s": {"liftoff_speed": 1.0},
}
"""Changes of the standard task at 1.0 m/s, one for each way in which it can fail."""


def run(name: str) -> dict[str, Any]:
    """Ask for one walk that does not exist; the time is that of design and diagnosis."""
    robot, task = robot_of(), reference_task(**TASKS[name])
    started = time.process_time()
    record: dict[str, Any] = {"task": name, "constraints": [], "suggestions": []}
    try:
        design(robot, task)
    except (NoGaitFoundError, UnreachableError) as error:
        found = error.diagnosis
        if found is not None:
            record["constraints"] = [c.constraint for c in found.conflict]
            record["suggestions"] = [f"{s.setting} {s.after:g}" for s in found.suggestions]
    return record | {"cpu seconds": time.process_time() - started}


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    records = [run(name) for name in (list(TASKS)[:1] if quick else TASKS)]
    save("diagnosis", records, quick)


if __name__ == "__main__":
    main()
