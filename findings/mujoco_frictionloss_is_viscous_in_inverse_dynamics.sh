#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     inverse dynamics of a hinge with frictionloss 5 N·m, turning steadily at 0.1 rad/s,
#           gives 0.95 N·m of friction for an inertia of 0.01 kg·m² and 5 N·m for 1 kg·m². Below a
#           rate that is inversely proportional to the inertia the joint friction is viscous.
# Guess:    dry friction is 5 N·m whatever the rate and whatever is moved.
# Means:    friction is a soft constraint whose strength follows the inverse inertia at the joint, so
#           the torque of mj_inverse for a light foot moving slowly lacks most of the friction that
#           the same file gives a heavy thigh. Add frictionloss * sign(rate) by hand to size motors.
# Seen:     inertia 0.01: 0.0947 at 0.01 rad/s, 0.947 at 0.1, 5.000 at 1; inertia 1: 5.000 at 0.1
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/python" - <<'PY'
import mujoco


def friction(inertia, rate):
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option gravity="0 0 0"/><worldbody><body>
        <joint type="hinge" axis="0 1 0" frictionloss="5"/>
        <inertial pos="0 0 0" mass="1" diaginertia="{inertia} {inertia} {inertia}"/>
        </body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qvel[0] = rate  # steady: qacc stays zero, so nothing but friction asks for torque
    mujoco.mj_inverse(model, data)
    return float(data.qfrc_inverse[0])


seen = {(i, r): friction(i, r) for i in (0.01, 0.1, 1.0) for r in (0.01, 0.1, 1.0)}
for (inertia, rate), torque in seen.items():
    print(f"inertia {inertia:5} kg·m², rate {rate:5} rad/s: {torque:.4f} N·m of 5")
assert abs(seen[0.01, 0.01] - 0.0947) < 1e-3 and abs(seen[0.01, 0.1] - 0.947) < 1e-2
assert abs(seen[0.01, 1.0] - 5.0) < 1e-3 and abs(seen[1.0, 0.1] - 5.0) < 1e-3
assert abs(seen[0.1, 0.01] / seen[0.01, 0.01] - 10.0) < 1e-6  # proportional to the inertia
PY
