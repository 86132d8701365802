#!/usr/bin/env bash
# Version:  pin 4.1.0, mujoco 4.0.0
# Does:     a body of MJCF needs no name and no place. Pinocchio's MJCF reader cuts one out that has no attribute
#           at all, <body>, with its joint and its mass, and hangs what is below it on the body above. Written as
#           <body pos="0 0 0"> it is read. MuJoCo, saving a file, leaves zero places out: the same robot has
#           a joint less after it was saved. Nothing is said.
# Guess:    a body is a body with or without attributes, and what MuJoCo saves is what it had read.
# Means:    hips and ankles of several axes are built of such bodies, one for each axis, all in one place: a leg loses
#           its ankle pitch and the rest still looks right. Name every body, and compare joints and kilograms
#           with MuJoCo's.
# Seen:     leg of hip, knee, ankle pitch, ankle roll: as written 4 joints and 5.3 kg in both; saved by MuJoCo
#           4 and 5.3 in MuJoCo, 3 and 5.1 in Pinocchio; saved with names 4 and 5.3 in both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import pinocchio as pin

BODY = '<body {} pos="{}"><joint name="{}" axis="{}"/><geom type="capsule" size=".05 .1" mass="{}"/>'
PARTS = [
    ("thigh", "0 0 1", "hip", "0 1 0", 3.0),
    ("shin", "0 0 -.4", "knee", "0 1 0", 1.5),
    ("cross", "0 0 -.4", "ankle_pitch", "0 1 0", 0.2),
    ("foot", "0 0 0", "ankle_roll", "1 0 0", 0.6),
]


def leg(named):
    """MJCF of a leg whose ankle is two bodies in one place."""
    bodies = ""
    for name, pos, *rest in PARTS:
        pos = "0 0 0" if name == "cross" else "0 0 -.4" if name == "foot" else pos
        bodies += BODY.format(f'name="{name}"' if named or name != "cross" else "", pos, *rest)
    return f"<mujoco><worldbody>{bodies}{'</body>' * len(PARTS)}</worldbody></mujoco>"


def counts(text):
    """Joints and kilograms by MuJoCo and by Pinocchio."""
    Path("leg.xml").write_text(text)
    theirs = mujoco.MjModel.from_xml_path("leg.xml")
    read = pin.buildModelFromMJCF("leg.xml")
    ours = read[0] if isinstance(read, tuple) else read
    mass = sum(inertia.mass for inertia in ours.inertias)
    return (theirs.njnt, round(float(theirs.body_mass.sum()), 6)), (ours.njoints - 1, round(mass, 6))


def saved(text):
    spec = mujoco.MjSpec.from_string(text)
    spec.compile()
    return spec.to_xml()


assert "<body>" in saved(leg(named=False)) and "<body>" not in leg(named=False)
seen = {
    "as written": counts(leg(named=False)),
    "saved by MuJoCo": counts(saved(leg(named=False))),
    "saved with names": counts(saved(leg(named=True))),
}
for name, (theirs, ours) in seen.items():
    print(f"{name}: joints and kg: MuJoCo {theirs}, Pinocchio {ours}")
assert seen["as written"] == seen["saved with names"] == ((4, 5.3), (4, 5.3))
assert seen["saved by MuJoCo"] == ((4, 5.3), (3, 5.1))
PY
