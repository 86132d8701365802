#!/usr/bin/env bash
# Version:  genesis-world 1.4.5 (torch 2.14.1, on the CPU in double precision)
# Does:     the reader of URDF takes k_position and k_velocity of a joint's safety_controller for the gains kp and kv of its
#           position servo. Joints without that element have 100 N·m/rad and 10 N·m·s/rad. No warning.
# Guess:    the element is not used, or it bounds speed and effort near the soft stops: URDF says k_position relates the
#           bounds of position and velocity (1/s), k_velocity those of effort and velocity, and the servo is elsewhere.
# Means:    with the files of example-robot-data 5.0.0 HyQ stands on legs of half the stiffness that it has without the element,
#           TIAGo's arm has a fifth and droops, the forearms of PR2, whose element has no k_position, have none at all; a
#           k_velocity of 0, as in the description of Universal Robots (its issue 376), takes the damping. Set all
#           gains by set_dofs_kp and set_dofs_kv after loading.
# Seen:     thigh of 5 kg asked to 0.5 rad against gravity: no element: rests at 0.457 rad; (50, 10) as HyQ: 0.420 rad; (20, 20) as
#           TIAGo: 0.338 rad; (none, 1) as PR2: 0; (20, 0): swings between 0.00 and 0.68 rad after 6 s; the rests as by hand
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check genesis-world==1.4.5 torch==2.14.1
cd "$work"
"$work/env/bin/python" -W ignore - 2>/dev/null <<'PY'
from pathlib import Path

import genesis as gs
import numpy as np

MASS, ARM, ASKED = 5.0, 0.2, 0.5
KINDS = {  # what stands in the file, and the gains that come of it
    "no element": ("", (100, 10)),
    "HyQ": ('<safety_controller k_position="50" k_velocity="10"/>', (50, 10)),
    "TIAGo": ('<safety_controller k_position="20" k_velocity="20"/>', (20, 20)),
    "PR2": ('<safety_controller k_velocity="1"/>', (0, 1)),
    "Universal Robots": ('<safety_controller k_position="20" k_velocity="0"/>', (20, 0)),
}


def text(safety):
    return f"""<robot name="leg"><link name="base"/><link name="thigh"><inertial><origin xyz="0 0 -{ARM}"/><mass value="{MASS}"/>
<inertia ixx=".07" iyy=".07" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><axis xyz="0 1 0"/>
<limit lower="-1.5" upper="1.5" effort="200" velocity="10"/>{safety}</joint></robot>"""


def rest(kp):
    """Where gravity and a servo of that stiffness balance, by bisection."""
    low, high = 0.0, ASKED
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if kp * (ASKED - middle) > MASS * 9.81 * ARM * np.sin(middle) else (low, middle)
    return low


gs.init(backend=gs.cpu, precision="64", logging_level="error")
scene = gs.Scene(show_viewer=False, sim_options=gs.options.SimOptions(dt=1e-3, gravity=(0.0, 0.0, -9.81)))
legs = {}
for name, (safety, _) in KINDS.items():
    Path("leg.urdf").write_text(text(safety))
    legs[name] = scene.add_entity(gs.morphs.URDF(file="leg.urdf", fixed=True, pos=(0.0, 2.0 * len(legs), 1.5)))
scene.build()
for leg in legs.values():
    leg.control_dofs_position(np.array([ASKED]))
track = {name: [] for name in legs}
for step in range(6000):
    scene.step()
    if step >= 4000:
        for name, leg in legs.items():
            track[name].append(leg.get_dofs_position().numpy()[0])
for name, leg in legs.items():
    kp, kv = leg.get_dofs_kp().numpy()[0].item(), leg.get_dofs_kv().numpy()[0].item()
    least, most = min(track[name]), max(track[name])
    print(f"{name}: {kp:g} N·m/rad, {kv:g} N·m·s/rad; between {least:.3f} and {most:.3f} rad, balance by hand at {rest(kp):.3f}")
    assert (kp, kv) == KINDS[name][1]
    if kv:
        assert abs((least + most) / 2 - rest(kp)) < 0.01 and most - least < 0.05
    else:
        assert most - least > 0.2 and abs((most + least) / 2 - rest(kp)) < 0.03
PY
