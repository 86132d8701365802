#!/usr/bin/env bash
# Version:  urdf-usd-converter 0.3.4 (with newton-usd-schemas 0.6.0), newton 1.8.0 (with warp-lang 1.19.0,
#           usd-core 26.11)
# Does:     the converter writes the velocity limit, damping and friction of a URDF joint as attributes of Newton's USD
#           schema, and its effort as "urdf:limit:effort", which Newton's USD reader does not look for: all three
#           joints of the leg come out with Newton's default, 1e6 N·m. Masses, tensors, ranges, rates, damping
#           and friction are right. Newton's own URDF reader has the efforts. Neither program says anything.
# Guess:    two programs that share a schema carry over what both of them have, or warn of a limit that finds no
#           place there.
# Means:    the robot that went through USD has motors without limit: a learner or an optimiser finds gaits that
#           no ankle of 40 N·m can do, and all other numbers compare well. Set joint_effort_limit after reading,
#           or look for 1e6 in it.
# Seen:     efforts 80, 90, 40 N·m in the URDF and by add_urdf; 1e6 three times by add_usd; velocity limits 9, 8,
#           7 rad/s, damping 0.7, 0.3, 0 and friction 0.4, 0.2, 0 by both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for name in convert read; do python3 -m venv "$work/$name"; done
"$work/convert/bin/pip" install --quiet --disable-pip-version-check urdf-usd-converter==0.3.4 \
  newton-usd-schemas==0.6.0 usd-exchange==3.0.1 tinyobjloader==2.0.0rc13 numpy==2.4.6
"$work/read/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0 usd-core==26.11 \
  newton-usd-schemas==0.6.0 numpy==2.4.6
cd "$work"
cat > leg.urdf <<'XML'
<robot name="leg">
  <link name="trunk"><inertial><mass value="8"/>
    <inertia ixx="0.2" iyy="0.17" izz="0.12" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="hip" type="revolute"><parent link="trunk"/><child link="thigh"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1.2" effort="80" velocity="9"/><dynamics damping="0.7" friction="0.4"/></joint>
  <link name="thigh"><inertial><origin xyz="0 0 -0.2"/><mass value="3"/>
    <inertia ixx="0.05" iyy="0.045" izz="0.012" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="knee" type="revolute"><origin xyz="0 0 -0.4"/><parent link="thigh"/><child link="shin"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="0" effort="90" velocity="8"/>
    <dynamics damping="0.3" friction="0.2"/></joint>
  <link name="shin"><inertial><origin xyz="0 0 -0.15"/><mass value="2"/>
    <inertia ixx="0.03" iyy="0.028" izz="0.006" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="ankle" type="revolute"><origin xyz="0 0 -0.38"/><parent link="shin"/><child link="foot"/>
    <axis xyz="0 1 0"/><limit lower="-0.8" upper="0.5" effort="40" velocity="7"/></joint>
  <link name="foot"><inertial><origin xyz="0.04 0 -0.03"/><mass value="1"/>
    <inertia ixx="0.001" iyy="0.004" izz="0.0042" ixy="0" ixz="0" iyz="0"/></inertial></link>
</robot>
XML
convert/bin/python - > convert.txt 2>&1 <<'PY'
import urdf_usd_converter

asset = urdf_usd_converter.Converter().convert("leg.urdf", "usd")
PY
if grep -i "warning\|effort" convert.txt; then echo "the converter says something now"; exit 1; fi
read/bin/python -W ignore - 2>/dev/null <<'PY'
import xml.etree.ElementTree as ET

import numpy as np
import warp

warp.config.quiet = True
import newton

limits = [joint.find("limit").attrib for joint in ET.parse("leg.urdf").getroot().iter("joint")]
effort, rate = ([float(limit[key]) for limit in limits] for key in ("effort", "velocity"))

builders = {"URDF": newton.ModelBuilder(), "USD": newton.ModelBuilder()}
builders["URDF"].add_urdf("leg.urdf", floating=False)
builders["USD"].add_usd("usd/leg.usda")
for name, builder in builders.items():
    print(name, "efforts", builder.joint_effort_limit, "rates", np.round(builder.joint_velocity_limit, 3))
    assert np.allclose(builder.body_mass, [8, 3, 2, 1])
    assert np.allclose(builder.joint_velocity_limit, rate)
    assert np.allclose(builder.joint_friction, [0.4, 0.2, 0.0])
    assert np.allclose(builder.joint_limit_lower, [-1.0, -2.0, -0.8])
    assert np.allclose(builder.joint_limit_upper, [1.2, 0.0, 0.5], atol=1e-6)
assert builders["URDF"].joint_effort_limit == effort == [80.0, 90.0, 40.0]
assert builders["USD"].joint_effort_limit == [1e6] * 3
with open("usd/Payload/Physics.usda") as file:
    kept = [line.strip() for line in file if "effort" in line]
print(kept)
assert len(kept) == 3
PY
