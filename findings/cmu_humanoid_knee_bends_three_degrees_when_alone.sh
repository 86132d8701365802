#!/usr/bin/env bash
# Version:  dm_control 1.0.50 (CMUHumanoid, humanoid_CMU_V2019.xml) with mujoco 4.0.0
# Does:     the file gives joint ranges in radians and does not say so (MJCF reads degrees). Compiled on
#           its own, by MuJoCo or by dm_control's own export, the walker's knee turns by 3.0 degrees.
#           Attached to one of dm_control's arenas it has 169, because the arena's <compiler> is radian.
# Guess:    a walker is the same robot alone and in an arena; ranges of 0.01 to 2.97 say radians.
# Means:    whoever takes this file out of dm_control gets a humanoid that stands with stiff legs and
#           raises nothing. The file of 2020 says radian. Look at the compiled range of the knee.
# Seen:     knee 0.01 to 2.97 degrees alone, 0.57 to 170.0 degrees in the arena and in the file of 2020
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check dm_control==1.0.50 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
from pathlib import Path

import dm_control
import mujoco
import numpy as np
from dm_control.locomotion.arenas import floors
from dm_control.locomotion.walkers import cmu_humanoid


def knee(model):
    """Range of the left knee [degrees]."""
    (joint,) = (k for k in range(model.njnt) if model.joint(k).name.endswith("ltibiarx"))
    return np.degrees(model.jnt_range[joint])


def compiled(root):
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())


folder = Path(dm_control.__file__).parent / "locomotion" / "walkers" / "assets"
found = {
    f"file of {year}": knee(mujoco.MjModel.from_xml_path(str(folder / f"humanoid_CMU_V{year}.xml")))
    for year in (2019, 2020)
}
walker = cmu_humanoid.CMUHumanoid()
found["walker alone"] = knee(compiled(walker.mjcf_model))
arena = floors.Floor()
arena.attach(walker)
found["walker in an arena"] = knee(compiled(arena.mjcf_model))
for name, angles in found.items():
    print(f"{name}: knee {angles[0]:.2f} to {angles[1]:.2f} degrees")
for name in ("file of 2019", "walker alone"):
    assert np.allclose(found[name], [0.01, 2.96706])
for name in ("file of 2020", "walker in an arena"):
    assert np.allclose(found[name], np.degrees([0.01, 2.96706]))
PY
