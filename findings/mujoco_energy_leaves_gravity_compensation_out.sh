#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     the potential energy (energy flag, mj_energyPos, sensor e_potential) counts the whole weight of a body that has
#           gravcomp, and the springs of joints and tendons, also nonlinear ones. The force of gravcomp, which is
#           constant and does work as weight does, is not counted: a pendulum half compensated gains and loses a
#           tenth of its energy in each swing, without friction, motors or contacts.
# Guess:    potential energy falls by the work that gravity, compensation and springs do, so that the sum with the kinetic one
#           is kept.
# Means:    the sum is the usual check of an integrator, a time step or a new file, and a cost of transport is made
#           from it: a robot that hangs in a harness, or is unloaded on purpose, fails the first and has another
#           second. Add gravcomp * mass * g * height of each body by hand.
# Seen:     1 kg, 0.4 m, released 1.5 rad from hanging, gravcomp 0.5, RK4 of 0.5 ms: sum 8.76 to 9.67 J; with the work of
#           gravcomp 4.8356 J, kept to 1e-6; gravcomp 0: 9.6712 J, kept to 1e-6
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/python" - <<'PY'
import mujoco
import numpy as np


def swing(gravcomp):
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><option timestep="0.0005" integrator="RK4"><flag energy="enable"/>
        </option><worldbody><body pos="0 0 1" gravcomp="{gravcomp}"><joint axis="0 1 0"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.4" mass="1"/></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[0] = 1.5
    mujoco.mj_forward(model, data)
    sums, whole = [], []
    for _ in range(4000):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        sums.append(data.energy.sum())
        whole.append(sums[-1] - gravcomp * 1.0 * 9.81 * data.xipos[1, 2])  # less the work of the compensation
    return np.array(sums), np.array(whole)


for gravcomp in (0.0, 0.5):
    sums, whole = swing(gravcomp)
    print(f"gravcomp {gravcomp}: sum of energies {sums.min():.4f} to {sums.max():.4f} J,"
          f" with the work of gravcomp {whole.min():.6f} to {whole.max():.6f} J")
    assert np.ptp(whole) < 1e-6
assert abs(sums.min() - 8.76) < 0.01 and abs(sums.max() - 9.67) < 0.01
assert np.ptp(swing(0.0)[0]) < 1e-6
PY
