#!/usr/bin/env bash
# Version:  mujoco 4.0.0
# Does:     a robot file may say in its <compiler> what it weighs in all (settotalmass), that boxes fitted to meshes are the
#           boxes around them (fitaabb), and the least mass and moment of a body (boundmass, boundinertia). MjSpec.attach()
#           and attach_body() leave out the first two. They keep the bounds, until the whole is saved: to_xml()
#           writes bodies without them. Units of angles and Euler sequences are carried over; of options that
#           differ (time step, gravity) it warns, of these not. Saved without attaching, each file keeps all four.
# Guess:    a robot put into a scene is the robot of its file.
# Means:    gains, torques and gaits found with the file alone are for a robot of another weight than that in the
#           scene, and what is simulated is not what is saved. Compare body_mass of the file alone, the scene, and
#           the saved scene; save the robot alone first, where bounds are needed write <inertial>.
# Seen:     settotalmass 40: 40 kg alone and saved, 1.24 attached; fitaabb: 2.01, 0.46 kg; boundmass 0.5: foot of 0.5 kg alone
#           and attached, 0.016 kg attached and saved, its moments 0.01 and 2.3e-6 kg·m²
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
cd "$work"
"$work/env/bin/python" -W ignore - <<'PY'
import mujoco
import numpy as np

FILE = """
<mujoco>
  <compiler {compiler}/>
  <asset><mesh name="shank" vertex="0 0 0  0.1 0 0  0 0.1 0  0 0 0.4"/></asset>
  <worldbody><body name="leg"><freejoint/>{shape}</body></worldbody>
</mujoco>"""
CAPSULE = '<geom type="capsule" size="0.03 0.2"/>'
FOOT = (
    '<body name="foot" pos="0 0 -0.2"><joint axis="0 1 0" range="-50 50"/>'
    '<geom type="box" size="0.02 0.02 0.005"/></body>'
)
FILES = {
    "settotalmass": FILE.format(compiler='settotalmass="40"', shape=CAPSULE),
    "fitaabb": FILE.format(compiler='fitaabb="true"', shape='<geom type="box" mesh="shank" density="500"/>'),
    "bounds": FILE.format(compiler='boundmass="0.5" boundinertia="0.01"', shape=CAPSULE + FOOT),
}


def saved(spec):
    return mujoco.MjModel.from_xml_string(spec.to_xml())


def readings(text):
    """The robot alone, saved; attached as a whole, saved; attached by its body, saved."""
    alone = mujoco.MjSpec.from_string(text)
    found = [alone.compile(), saved(alone)]
    for whole in (True, False):
        robot, scene = mujoco.MjSpec.from_string(text), mujoco.MjSpec()
        frame = scene.worldbody.add_frame()
        if whole:
            scene.attach(robot, prefix="robot_", frame=frame)
        else:
            frame.attach_body(robot.worldbody.first_body(), "robot_", "")
        found += [scene.compile(), saved(scene)]
    return found


seen = {name: readings(text) for name, text in FILES.items()}
for name, models in seen.items():
    masses = [float(model.body_mass[-1]) for model in models]
    moments = [float(model.body_inertia[-1, 0]) for model in models]
    print(name, "mass of the last body [kg]:", np.round(masses, 4), "moment:", np.array(moments))
capsule = 1000 * np.pi * 0.03**2 * (0.4 + 4 / 3 * 0.03)  # water
box = 500 * 0.1 * 0.1 * 0.4  # around the mesh; its axes are those of its inertia, all but along it
expected = {
    "settotalmass": [40, 40, capsule, capsule, capsule, capsule],
    "fitaabb": [2.0133, 2.0133, 0.4648, 0.4648, 0.4648, 0.4648],
    "bounds": [0.5, 0.5, 0.5, 0.016, 0.5, 0.016],
}
for name, masses in expected.items():
    assert np.allclose([model.body_mass[-1] for model in seen[name]], masses, rtol=1e-3)
assert abs(expected["fitaabb"][0] / box - 1) < 0.01
least = 0.016 * (0.01**2 + 0.04**2) / 12
assert np.allclose([model.body_inertia[-1, 0] for model in seen["bounds"]], [0.01, 0.01, 0.01, least, 0.01, least])
# What is carried over: degrees.
assert all(np.isclose(model.jnt_range[-1, 1], np.radians(50)) for model in seen["bounds"])
PY
