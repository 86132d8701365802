#!/usr/bin/env bash
# Version:  newton 1.8.0 with warp-lang 1.19.0, mujoco 3.17.0 and mujoco-warp 3.17.0 (what it asks for)
# Does:     add_mjcf reads kp and kv of a <position> servo and leaves its lag (timeconst) out, and the delay of any actuator.
#           <pid>, <orientation> and <cylinder> are no actuators at all there: the joint hangs free. Nothing is said. The
#           same lag written as <general dyntype="filterexact"> is kept, and so are motors, velocities, damping, armature. All are
#           compared in SolverMuJoCo, which is MuJoCo itself. (Issues 3747 and 3749 asked for <intvelocity> and <damper>, which
#           are read now, 3950 for <dcmotor>; none was found of lag or delay.)
# Guess:    the solver is MuJoCo and the file is MuJoCo's, so a servo does there what it does in MuJoCo, or is refused.
# Means:    a policy or a walk that is tuned in Newton has servos without lag: it holds up to gains and paces at which the same
#           file in MuJoCo, or the robot, rings and falls. Compare nu, na and actuator_delay of both models first, and
#           write lags as <general>.
# Seen:     servo with a lag of 50 ms, after 0.1 s of a step of 0.4 rad: 0.1500 rad, Newton 0.3005, which is that without lag; as
#           <general> 0.1500 both; 3 N·m delayed by 20 ms: 0.0463 and 0.0714 rad; pid, orientation, cylinder: Newton 0 rad
#           for 0.3005, 0.3103 and 0.0188
set -euo pipefail
work=$(mktemp -d)
export WARP_CACHE_PATH="$work/cache"
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0 mujoco==3.17.0 \
  mujoco-warp==3.17.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import contextlib
import io
import warnings

import mujoco
import numpy as np
import warp as wp

wp.config.quiet = True
import newton

XML = """<mujoco><option timestep="0.002"/><worldbody><body><joint name="ankle" {joint}/>
<geom type="box" size=".06 .08 .2" mass="2" pos="0 0 -.3"/></body></worldbody><actuator>{actuator}</actuator></mujoco>"""
HINGE, BALL = 'axis="0 1 0"', 'type="ball"'
LAG = 'dyntype="filterexact" dynprm="0.05" gainprm="60" biastype="affine" biasprm="0 -60 -3"'
CASES = {
    "servo": (HINGE, '<position joint="ankle" kp="60" kv="3"/>', [0.4]),
    "servo with lag, as general": (HINGE, f'<general joint="ankle" {LAG}/>', [0.4]),
    "servo with lag": (HINGE, '<position joint="ankle" kp="60" kv="3" timeconst="0.05"/>', [0.4]),
    "motor": (HINGE, '<motor joint="ankle"/>', [3.0]),
    "motor with delay": (HINGE, '<motor joint="ankle" delay="0.02" nsample="20"/>', [3.0]),
    "pid": (HINGE, '<pid joint="ankle" kp="60" kv="3"/>', [0.4, 0.0]),
    "orientation": (BALL, '<orientation joint="ankle" kp="60" kv="3"/>', [0.1, 0.2, 0.3]),
    "cylinder": (HINGE, '<cylinder joint="ankle" area="0.01" timeconst="0.1"/>', [300.0]),
}


def turned(model, command):
    """Angle of the joint after 0.1 s of the command, in MuJoCo."""
    data = mujoco.MjData(model)
    if model.nu == len(command):
        data.ctrl[:] = command
    for _ in range(50):
        mujoco.mj_step(model, data)
    return data.qpos[0] if model.nq == 1 else 2.0 * np.arccos(min(1.0, data.qpos[0]))


angles = {}
for name, (joint, actuator, command) in CASES.items():
    text = XML.format(joint=joint, actuator=actuator)
    model = mujoco.MjModel.from_xml_string(text)
    said = io.StringIO()
    with warnings.catch_warnings(record=True) as warned, contextlib.redirect_stdout(said):
        warnings.simplefilter("always")
        builder = newton.ModelBuilder()
        newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
        builder.add_mjcf(text)
        solver = newton.solvers.SolverMuJoCo(builder.finalize(device="cpu"), use_mujoco_cpu=True)
    about = [str(one.message) for one in warned if "actuator" in str(one.message).lower() or "joint" in str(one.message).lower()]
    assert not about and "actuator" not in said.getvalue().lower(), (about, said.getvalue())
    other = solver.mj_model
    other.opt.timestep, other.opt.integrator = model.opt.timestep, model.opt.integrator
    angles[name] = turned(model, command), turned(other, command)
    print(f"{name}: MuJoCo {angles[name][0]:.4f} rad, Newton {angles[name][1]:.4f}; inputs {model.nu} and {other.nu},"
          f" states {model.na} and {other.na}")
    if name in ("pid", "orientation", "cylinder"):
        assert model.nu == len(command) and other.nu == 0
        assert abs(angles[name][1]) < 1e-6 and angles[name][0] > 0.01
for name in ("servo", "servo with lag, as general", "motor"):
    assert np.isclose(*angles[name], atol=1e-5)
assert np.isclose(angles["servo with lag"][0], angles["servo with lag, as general"][0], atol=1e-9)
assert np.isclose(angles["servo with lag"][1], angles["servo"][0], atol=1e-5)
assert angles["servo with lag"][1] > 1.5 * angles["servo with lag"][0]
assert np.isclose(angles["motor with delay"][1], angles["motor"][0], atol=1e-5)
assert angles["motor with delay"][1] > 1.5 * angles["motor with delay"][0]
PY
