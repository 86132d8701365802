"""A hundred random walks that do not exist: every command that a diagnosis prints is run.

python benchmarks/infeasible.py [--quick] [--count N] [--first SEED] [--resume]

Every task is saved when it is done; `--resume` goes on after the last one saved. A command that
neither walks nor says that there is no gait, or that takes too long, is kept as failed.
"""

from __future__ import annotations

import json
import os
import resource
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import RESULTS, arguments, save

COUNT, QUICK = 100, 3
ROBOTS: dict[str, dict[str, tuple[float, float]]] = {
    "": {"torque-limit": (15.0, 45.0), "speed": (1.6, 3.4), "duration": (0.12, 0.22)},
    "g1": {"torque-limit": (6.0, 22.0), "speed": (1.3, 2.6), "duration": (0.15, 0.25)},
    "talos": {"torque-limit": (30.0, 90.0), "speed": (1.5, 3.0), "duration": (0.15, 0.3)},
    "romeo": {"torque-limit": (8.0, 35.0), "speed": (0.9, 2.2), "duration": (0.15, 0.3)},
    "simple_humanoid": {"torque-limit": (15.0, 60.0), "speed": (1.3, 2.6), "duration": (0.15, 0.3)},
}
"""Robots of the catalogue (the first is the biped) with ranges that are hard for them."""
LIMITS: dict[str, tuple[float, float]] = {
    "speed-limit": (1.0, 4.0),
    "clearance": (0.12, 0.6),
    "leg-extension": (0.6, 0.85),
    "friction": (0.01, 0.12),
    "cop-margin": (0.02, 0.08),
    "trunk-roll": (0.002, 0.03),
    "trunk-pitch": (0.002, 0.03),
    "trunk-yaw": (0.002, 0.03),
    "knee-flexion": (0.8, 2.4),
    "liftoff-speed": (0.05, 0.8),
    "minimum-load": (150.0, 700.0),
    "lateral-gap": (0.15, 0.5),
    "step-width": (0.08, 0.16),
    "torsional-friction": (0.0005, 0.006),
    "swing-tilt": (0.003, 0.03),
    "leg-gap": (0.08, 0.3),
}
"""Ranges of limits that are hard for any of them."""
KINDS = (0.5, 0.3, 0.2)
"""Shares of tasks with one, two and three hard limits."""
WALKED, NO_GAIT = (0, 1), 3
TIME_LIMIT = 1200  # s of processor, so that other work on the machine ends nothing


def options(seed: int) -> list[str]:
    """Return the options of a random command line."""
    rng = np.random.default_rng(seed)
    robot = "" if rng.random() < 0.5 else str(rng.choice([name for name in ROBOTS if name]))
    ranges = {**ROBOTS[robot], **LIMITS}
    kinds = rng.choice(list(ranges), size=1 + rng.choice(len(KINDS), p=KINDS), replace=False)
    words = ["--robot", robot] if robot else []
    for kind in kinds:
        words += [f"--{kind}", f"{rng.uniform(*ranges[str(kind)]):.4g}"]
    return words


def run(command: str) -> tuple[int, float, str]:
    """Run a command line in a shell; return exit code, CPU seconds and what it says of errors."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    limited = f"ulimit -t {TIME_LIMIT}; {command}"
    done = subprocess.run(limited, shell=True, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.returncode, spent, done.stderr


def _failure(command: str, said: str, folder: str) -> dict[str, str]:
    """Return what to record of a command that failed, without the places of this machine."""
    last = said.strip().splitlines()[-1:] or [""]
    return {"command": command.replace(folder, "DIR"), "said": last[0].replace(folder, "DIR")}


def one(seed: int) -> dict[str, Any]:
    """Ask for one random walk and follow what is advised if it does not exist."""
    words = options(seed)
    with tempfile.TemporaryDirectory() as folder:
        rest = ["--no-page", "--no-figures", "--output", folder]
        asked = [sys.executable, "-m", "gaitopt", "optimise", *words, *rest]
        code, seconds, said = run(shlex.join(asked))
        record: dict[str, Any] = {"seed": seed, "options": words, "code": code, "cpu": seconds}
        if code in WALKED:
            return record
        if code != NO_GAIT:
            return record | _failure(shlex.join(asked), said, folder)
        lines = said.splitlines()
        commands = [line.strip() for line in lines if line.startswith("    ")]
        followed = [(command, *run(command)) for command in commands]
        told = Path(folder) / "suggestions" / "diagnosis.json"
        diagnosis = json.loads(told.read_text()) if told.is_file() else {}
    return record | {
        "said": [line for line in lines if line.startswith("- ")],
        "settings": [
            " and ".join([s["setting"], *(change["setting"] for change in s["also"])])
            for s in diagnosis.get("suggestions", [])
        ],
        "diagnosis seconds": diagnosis.get("cpu_seconds"),
        "impossible": len(diagnosis.get("impossible", [])),
        "followed": [
            {"code": code, "cpu": spent} | (_failure(command, why, folder) if code else {})
            for command, code, spent, why in followed
        ],
    }


def main() -> None:
    """Run them, print a line each, keep the records."""
    parser = arguments(__doc__)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--resume", action="store_true", help="go on after what was saved")
    given = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    data: dict[str, Any] = {"walked": 0, "failed": [], "next": given.first, "records": []}
    if given.resume:
        data = json.loads((RESULTS / "infeasible.json").read_text())["data"]
    count, records = QUICK if given.quick else given.count, data["records"]
    while len(records) < count:
        record = one(data["next"])
        data["next"] += 1
        if record["code"] != NO_GAIT:
            data["walked"] += record["code"] in WALKED
            data["failed"] += [] if record["code"] in WALKED else [record]
            print(record["seed"], record["options"], "exit", record["code"], flush=True)
        else:
            records.append(record)
            codes = [f["code"] for f in record["followed"]]
            print(record["seed"], record["options"], record["settings"], codes,
                  f"{record['cpu']:.1f} s, diagnosis {record['diagnosis seconds'] or 0.0:.1f} s",
                  flush=True)  # fmt: skip
        save("infeasible", data, given.quick)


if __name__ == "__main__":
    main()
