#!/usr/bin/env bash
# Version:  bvh-converter 1.0.2, against bvhio 1.5.4 and bvhsdk 0.2.1
# Does:     where joints below the root have position channels (six channels each, as BVH allows), the table of
#           world positions is made from the fixed OFFSETs of these joints; what the motion says of them is
#           read past. Rotations of any order and the root's positions are right. Nothing says so.
# Guess:    a channel that a file has is applied; bvhio and bvhsdk put the joint where the channels say.
# Means:    a recording whose thighs were fitted to a person comes out with the legs of the rest posture:
#           steps are too long or short and feet slide. Compare the distance of hip and knee in the table
#           with that in the motion.
# Seen:     thigh at (10.5, 19.0, 30.2), the root plus its OFFSET, for (10.7, 18.5, 30.4), the root plus its
#           position channels, by hand, bvhio and bvhsdk
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check bvh-converter==1.0.2 bvhio==1.5.4 \
  bvhsdk==0.2.1
cd "$work"
cat > walk.bvh <<'BVH'
HIERARCHY
ROOT hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT thigh
  {
    OFFSET 0.5 -1.0 0.2
    CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
    JOINT shin
    {
      OFFSET 0.1 -4.0 0.3
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -4 1
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.01
0 0 0 0 0 0 0.5 -1.0 0.2 0 0 0 0 0 0
10 20 30 0 0 0 0.7 -1.5 0.4 0 0 0 0 0 0
BVH
env/bin/bvh-converter walk.bvh > /dev/null
env/bin/python -W ignore - <<'PY'
import csv

import bvhio
import bvhsdk
import numpy as np

(header, _, second) = [row for row in csv.reader(open("walk_worldpos.csv")) if row]
table = dict(zip(header, map(float, second)))
seen = {"bvh-converter": [table[f"thigh.{axis}"] for axis in "XYZ"]}
root = bvhio.readAsHierarchy("walk.bvh")
root.loadPose(1)
seen["bvhio"] = next(joint.PositionWorld for joint, _, _ in root.layout() if joint.Name == "thigh")
joints = bvhsdk.ReadFile("walk.bvh").getlistofjoints()
seen["bvhsdk"] = next(joint.getPosition(1) for joint in joints if joint.name == "thigh")
hips = np.array([10.0, 20.0, 30.0])
for name, place in seen.items():
    print(name, "thigh at", np.round(np.array(place, dtype=float), 3))
    channel = [0.5, -1.0, 0.2] if name == "bvh-converter" else [0.7, -1.5, 0.4]
    assert np.allclose(np.array(place, dtype=float), hips + channel, atol=1e-4)
PY
