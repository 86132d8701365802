#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     the second number of a dcmotor's saturation limits its current; what is limited is the force. The winding is
#           heated by the current that the voltage would drive through it without the limit, and the state "current" (with
#           an inductance) is that one, too. A torque that a servo asks for beyond the limit is not given, and heats.
#           Also, the on-board controller divides by the resistance of the cold winding, so that a hot one gives less than
#           it was asked for with no limit reached, where the reference says "delivered exactly until a limit is reached"
#           (a remark in mujoco_warp's pull request 1667 calls the cold resistance intended).
# Guess:    a motor that is held at 3 A heats by the square of 3 A; an actuator of 0.3 N·m at 0.1 N·m/A has 3 A.
# Means:    a servo with large gains drives its winding to hundreds of degrees in a walk in which it never has more than its rated
#           current: thermal limits rule out the gait, or a policy learns to avoid what costs nothing. Bound the command
#           itself (ctrlrange, Vmax, gains), and integrate (force / K)^2 R(T) as a check. No report was found.
# Seen:     blocked motor, K 0.1 N·m/A, 0.5 ohm, limit 3 A, 100 s: force 0.3 N·m; at 6 V 102 K warmer, asked for 5 N·m 675 K, by
#           hand for 3 A 9.3 K; 8.7 K, as by hand, where 1.5 V or 0.3 N·m are all that is asked for; with an inductance
#           its current state is 8.5 A. 60 K above the ambient, asked for 0.3 N·m: 0.242
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np

K, R, LIMIT = 0.1, 0.5, 3.0  # N·m/A, ohm at 25 degrees, A
TO_AIR, CAPACITY, SLOPE = 2.0, 5.0, 0.004  # K/W, J/K, 1/K
TIME = 100.0
XML = f"""<mujoco><option gravity="0 0 0" timestep="0.002"/><worldbody><body>
<joint name="ankle" axis="0 1 0" stiffness="1e5" damping="100"/><geom size=".1" mass="1"/></body></worldbody>
<actuator><dcmotor joint="ankle" resistance="{R}" motorconst="{K}"
thermal="{TO_AIR} {CAPACITY} 0 {SLOPE} 25 25" {{more}}/></actuator></mujoco>"""


def run(more, command, start=0.0, time=TIME):
    """Force and temperature above the ambient after a time; the joint is held by a stiff spring."""
    model = mujoco.MjModel.from_xml_string(XML.format(more=more))
    data = mujoco.MjData(model)
    data.ctrl[0], data.act[0] = command, start
    mujoco.mj_forward(model, data)
    for _ in range(round(time / model.opt.timestep)):
        mujoco.mj_step(model, data)
    assert abs(data.qpos[0]) < 1e-5 and abs(data.qvel[0]) < 1e-6
    return data.actuator_force[0], data.act.copy()


def by_hand(current):
    """CAPACITY T' = current^2 R (1 + SLOPE T) - T / TO_AIR, from 0."""
    heat = current**2 * R / CAPACITY
    rate = 1.0 / (TO_AIR * CAPACITY) - heat * SLOPE
    return heat / rate * (1.0 - np.exp(-rate * TIME))


right = by_hand(LIMIT)
limited = f'saturation="0 {LIMIT} 0"'
servo = 'input="ff" controller="0.001 0 0 0 0 0" ' + limited
for name, more, command, seen in (
    ("6 V", limited, 6.0, 102.2),
    ("6 V, with inductance", 'inductance="0.001" ' + limited, 6.0, 102.2),
    ("asked for 5 N·m", servo, 5.0, 675.4),
):
    force, act = run(more, command)
    print(f"{name}: force {force:.3f} N·m, states {act.round(2)} (temperature first), by hand {right:.2f} K")
    assert np.isclose(force, K * LIMIT) and np.isclose(force / K, LIMIT)
    assert np.isclose(act[0], seen, rtol=0.01) and act[0] > 10 * right
    if "inductance" in name:
        assert np.isclose(act[1], 6.0 / (R * (1 + SLOPE * act[0])), rtol=1e-4) and act[1] > 2.5 * LIMIT

# without a command beyond the limit the heat is right, with or without it
for more, command in (("", 1.5), (limited, 1.5), (servo, 0.3)):
    force, act = run(more, command)
    print(f"at {command} ({more or 'no limit'}): force {force:.4f} N·m, {act[0]:.3f} K, by hand {by_hand(force / K):.3f} K")
    assert force <= K * LIMIT and np.isclose(act[0], by_hand(force / K), rtol=1e-2)

force, act = run(servo, 0.3, start=60.0, time=0.0)
print(f"60 K above the ambient, asked for 0.3 N·m: {force:.4f}")
assert np.isclose(force, 0.3 / (1 + SLOPE * 60.0), atol=1e-4) and force < 0.25
PY
