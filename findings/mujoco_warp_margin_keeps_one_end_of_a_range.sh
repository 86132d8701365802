#!/usr/bin/env bash
# Version:  mujoco-warp 4.0.0 (warp-lang 1.19.0, on the CPU), mujoco 4.0.0 to compare
# Does:     where the margin of a joint is wider than half its range, both ends of the range are within it: MuJoCo pushes back from
#           both, MuJoCo Warp from the nearer end alone. With a margin up to half the range the two agree to rounding.
# Guess:    the same constraint rows; the model is taken without a word.
# Means:    a joint that a narrow range and a soft margin hold, as a locked toe or a tendon that is no longer to move, is centred by
#           MuJoCo and thrown from end to end by MuJoCo Warp, and policies trained on the one meet other toes in the other.
#           Keep the margin below half the range, or weld the body.
# Seen:     range of 10 degrees to either side, margin 0.5 rad: in the middle 0 rad/s² and 814, at 0.05 rad back with 128 and 939, at
#           0.2 rad with 513 and 1314; with a margin of 0.1 rad alike to 1e-2
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco-warp==4.0.0 mujoco==4.0.0 warp-lang==1.19.0
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
import mujoco
import mujoco_warp
import numpy as np
import warp

warp.config.quiet = True
TOE = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint axis="0 1 0" range="-10 10" margin="{}" armature=".1"/>
<geom type="capsule" size=".05" fromto="0 0 0 0 0 -.4" mass="2"/></body></worldbody></mujoco>"""
seen = {}
for margin in (0.0, 0.1, 0.5):
    model = mujoco.MjModel.from_xml_string(TOE.format(margin))
    for angle in (0.0, 0.05, 0.2):
        data = mujoco.MjData(model)
        data.qpos[:] = angle
        mujoco.mj_forward(model, data)
        theirs = mujoco_warp.put_data(model, mujoco.MjData(model))
        theirs.qpos = warp.array([[angle]], dtype=float)
        mujoco_warp.forward(mujoco_warp.put_model(model), theirs)
        rows, back = int(theirs.nefc.numpy()[0]), theirs.qacc.numpy()[0, 0].item()
        seen[margin, angle] = data.nefc, rows, data.qacc[0], back
        print(f"margin {margin} rad, at {angle} rad: {data.nefc} rows and {data.qacc[0]:.1f} rad/s² in MuJoCo, {rows} and {back:.1f} in Warp")
for (margin, _), (rows, other, acceleration, back) in seen.items():
    if margin < 0.17:
        assert rows == other and np.isclose(acceleration, back, atol=1e-2)
    else:
        assert (rows, other) == (2, 1) and abs(back - acceleration) > 700.0
middle = seen[0.5, 0.0]  # both ends are equally far: by symmetry nothing moves
assert abs(middle[2]) < 1e-9 and abs(middle[3]) > 700.0
PY
