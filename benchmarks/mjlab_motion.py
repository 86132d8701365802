"""mjlab's own loader on motions of G1: one walk, and a whole library by its index.

python benchmarks/mjlab_motion.py --python MJLAB [--quick]

MJLAB is a Python that has mjlab, best in an environment of its own: python -m venv v; v/bin/pip
install mjlab. There the loader of its motion tracking reads every file, and every body is compared
with where mjlab's own model of the robot has it at the same joint angles.
"""

from __future__ import annotations

import csv
import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.starts import design_gait
from gaitopt.gait.presets import preset_task
from gaitopt.motions.export import export, export_library
from gaitopt.sweep.grid import parse_axis
from gaitopt.sweep.scheduler import sweep

READ = """
import json, sys
import mujoco, numpy as np, torch
from importlib.metadata import version
from mjlab.asset_zoo.robots.unitree_g1.g1_constants import get_spec
from mjlab.tasks.tracking.mdp.commands import MotionLoader

spec = get_spec()
if not any(j.type == mujoco.mjtJoint.mjJNT_FREE for j in spec.joints):
    spec.body("pelvis").add_freejoint()
model = spec.compile()
bodies = [model.body(k).name for k in range(1, model.nbody)]
joints = [model.joint(k).name for k in range(1, model.njnt)]
data, found = mujoco.MjData(model), []
for path in sys.argv[1:]:
    names = np.load(path)
    assert list(names["joint_names"]) == joints, "other joints, or another order"
    assert list(names["body_names"]) == bodies, "other bodies, or another order"
    motion = MotionLoader(path, torch.arange(len(bodies)))
    place = turn = 0.0
    for k in range(0, motion.time_step_total, max(1, motion.time_step_total // 50)):
        data.qpos[:3], data.qpos[3:7] = motion.body_pos_w[k, 0], motion.body_quat_w[k, 0]
        data.qpos[7:] = motion.joint_pos[k]
        mujoco.mj_kinematics(model, data)
        place = max(place, float(np.abs(data.xpos[1:] - motion.body_pos_w[k].numpy()).max()))
        own, told = data.xquat[1:], motion.body_quat_w[k].numpy()
        turn = max(turn, float((1.0 - np.abs((own * told).sum(axis=1))).max()))
    found.append({"instants": motion.time_step_total, "place": place, "turn": turn})
print(json.dumps({"mjlab": version("mjlab"), "motions": found}))
"""


def read_by_mjlab(python: str, paths: list[Path]) -> dict[str, Any]:
    """Return what mjlab's loader reads, and how far the bodies are from its own model's."""
    command = [python, "-c", READ, *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(done.stderr)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def main() -> None:
    """Export, read, compare."""
    parser = arguments(__doc__)
    parser.add_argument("--python", required=True, help="a Python with mjlab")
    asked = parser.parse_args()
    robot = robot_by_name("g1")
    task = preset_task("humanoid", robot, speed=0.6)
    data: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        gait = design_gait(robot, task, starts=1).gait
        one = export(gait, Path(folder) / "one.npz", format="motion", rate=50.0, strides=20)
        data["walk"] = read_by_mjlab(asked.python, [one])
        axis = parse_axis("speed", "0.5,0.6" if asked.quick else "0.4:0.8:0.1")
        sweep(robot, task, [axis], Path(folder) / "library")
        index = export_library(
            Path(folder) / "library", Path(folder) / "motions", format="motion", strides=20
        )
        rows = list(csv.DictReader(index.read_text("utf-8").splitlines()))
        files = [index.parent / row["file"] for row in rows if row["file"]]
        read = read_by_mjlab(asked.python, files)
        speeds = [float(row["speed"]) for row in rows if row["file"]]
        travelled = []
        for path in files:
            places, fps = (np.load(path)[name] for name in ("body_pos_w", "fps"))
            seconds = (len(places) - 1) / float(fps[0])
            travelled.append(float(places[-1, 0, 0] - places[0, 0, 0]) / seconds)
        data["library"] = {
            **read,
            "points": len(rows),
            "files": len(files),
            "speeds": speeds,
            "speeds of the bases": travelled,
        }
    print(json.dumps(data, indent=1))
    save("mjlab_motion", data, asked.quick)


if __name__ == "__main__":
    main()
