#!/usr/bin/env bash
# Version:  idyntree 15.1.0
# Does:     a continuous joint whose <limit> has only effort and velocity is read with a range from
#           0 to 0, and the exporter writes it as a revolute joint that cannot move. The joint's
#           <mimic> is left out of the file. Nothing says either. Without <limit>, or with a range
#           that its type does not need, it stays continuous.
# Guess:    the URDF that is written moves as the one that was read.
# Means:    a robot that went through iDynTree (to reduce or re-root it) has locked wheels, wrists or
#           hips for every reader that keeps to ranges, and loose fingers or toes; look for ranges of
#           no width before a walk is designed.
# Seen:     continuous, effort and velocity: range [0.0, 0.0], written "revolute 0 0"; without limit:
#           no range, written "continuous"; mimic elements 1 before, 0 after
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check idyntree==15.1.0
cd "$work"
"$work/env/bin/python" - <<'PY'
from xml.etree import ElementTree

import idyntree.bindings as idyn

LINK = (
    '<link name="{}"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" '
    'iyz="0" izz="0.01"/></inertial></link>'
)
JOINT = (
    '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>{}</joint>'
)
LIMIT = '<limit effort="20" velocity="5"/>'
RANGE = '<limit lower="-1" upper="1" effort="20" velocity="5"/>'
text = (
    '<robot name="wheels">'
    + "".join(LINK.format(name) for name in ("base", "limited", "free", "told", "follower"))
    + JOINT.format("limited", "continuous", "base", "limited", LIMIT)
    + JOINT.format("free", "continuous", "base", "free", "")
    + JOINT.format("told", "revolute", "base", "told", RANGE)
    + JOINT.format("follower", "revolute", "base", "follower", RANGE + '<mimic joint="told"/>')
    + "</robot>"
)
open("wheels.urdf", "w").write(text)
loader = idyn.ModelLoader()
assert loader.loadModelFromFile("wheels.urdf")
model = loader.model()
exporter = idyn.ModelExporter()
exporter.init(model)
assert exporter.exportModelToFile("written.urdf", "urdf")
written = ElementTree.parse("written.urdf")
seen = {}
for index in range(model.getNrOfJoints()):
    joint, name = model.getJoint(index), model.getJointName(index)
    held = [joint.getMinPosLimit(0), joint.getMaxPosLimit(0)] if joint.hasPosLimits() else None
    out = written.find(f"joint[@name='{name}']")
    limit = out.find("limit")
    ends = "" if limit is None else f" {limit.get('lower')} {limit.get('upper')}"
    seen[name] = held, out.get("type") + ends
    print(f"{name}: range {held}, written \"{out.get('type')}{ends}\"")
ties = text.count("<mimic"), len(written.findall("joint/mimic"))
print("mimic elements before and after:", *ties)
assert seen["limited"] == ([0.0, 0.0], "revolute 0 0")
assert seen["free"][0] is None and seen["free"][1].startswith("continuous")
assert seen["told"] == ([-1.0, 1.0], "revolute -1 1")
assert ties == (1, 0)
PY
