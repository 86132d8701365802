"""How long it takes to write twenty strides of G1, at 50 Hz and 1 kHz, in every sampled form.

python benchmarks/exports.py [--quick]
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from common import arguments, save

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.starts import design_gait
from gaitopt.gait.presets import preset_task
from gaitopt.motions.export import FORMATS, export

STRIDES = 20
REPEATS = 3


def main() -> None:
    asked = arguments(__doc__).parse_args()
    robot = robot_by_name("g1")
    gait = design_gait(robot, preset_task("humanoid", robot, speed=0.6), starts=1).gait
    gait.trajectory.at(0.0)
    rates = (50.0,) if asked.quick else (50.0, 1000.0)
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, suffix in [(name, form.suffix) for name, form in FORMATS.items() if form.sampled]:
            path = Path(folder) / f"{name}{suffix}"
            for rate in rates:
                needed = []
                for _ in range(1 if asked.quick else REPEATS):
                    began = time.process_time()
                    export(gait, path, format=name, rate=rate, strides=STRIDES)
                    needed.append(time.process_time() - began)
                found.append({"format": name, "rate_hz": rate, "seconds": min(needed)})
    save("exports", found, asked.quick)


if __name__ == "__main__":
    main()
