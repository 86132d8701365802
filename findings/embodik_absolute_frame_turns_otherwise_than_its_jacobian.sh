#!/usr/bin/env bash
# Version:  embodik 0.23.2
# Does:     AbsoluteFrameTask tracks a frame between two others ("weighted average of two frames"). The rows of its Jacobian for
#           the place are the derivative of the place; those for the orientation are the weighted mean of both Jacobians, which
#           is not the rate of the orientation that it measures, unless the weight is 0 or 1.
#           FrameTask, RelativeFrameTask and COMTask have the derivative of their error to rounding.
# Guess:    at the target, where the error is zero, the Jacobian of a task is the slope of what it tracks.
# Means:    a mean frame of two hands that carry, or of two feet, that are turned against each other by a radian or two turns
#           at another rate than it is asked for, by a tenth to a third; an iteration still gets there, a feed-forward rate
#           does not. Give the task frames that are near parallel, or set the weight to 0 or 1. No report was found.
# Seen:     two limbs of three hinges on a floating trunk, frames 0.82 rad apart: orientation rows off by 0.072 of 1.00 (weight
#           0.3) and 0.086 (0.5); 2.48 rad apart 0.28 and 0.33 of 0.97; place rows, weights 0 and 1, and the
#           other tasks 1e-9
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check embodik==0.23.2 numpy==2.1.3
cd "$work"
"$work/env/bin/python" - <<'PY'
from pathlib import Path

import embodik
import numpy as np

LINK = """<link name="{}"><inertial><origin xyz=".02 .01 -.1"/><mass value="2"/>
<inertia ixx=".03" iyy=".025" izz=".012" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{1}_joint" type="revolute"><parent link="{0}"/><child link="{1}"/><origin {2}/><axis xyz="{3}"/>
<limit lower="-2.5" upper="2.5" effort="100" velocity="10"/></joint>"""
LIMBS = [("b", "l1", 'xyz="0 .1 0"', "0 1 0"), ("l1", "l2", 'xyz="0 .05 -.3" rpy=".2 .1 -.3"', "1 0 0"),
         ("l2", "l3", 'xyz=".1 0 -.3"', "0 0 1"), ("b", "r1", 'xyz="0 -.1 0"', "0 1 0"),
         ("r1", "r2", 'xyz="0 -.05 -.3" rpy=".2 .1 .3"', "1 0 0"), ("r2", "r3", 'xyz=".1 0 -.3"', "0 1 0")]
Path("robot.urdf").write_text('<robot name="r">' + "".join(LINK.format(n) for n in "b l1 l2 l3 r1 r2 r3".split())
                              + "".join(JOINT.format(*limb) for limb in LIMBS) + "</robot>")
model = embodik.RobotModel("robot.urdf", True)


def off(task, q, h=1e-6):
    """Errors of the Jacobian at the target, its rows for the place and the rest, and its largest entry."""
    def error(at):
        model.update_configuration(at)
        task.update(model)
        return np.array(task.get_error())

    error(q)
    if hasattr(task, "set_target_pose"):
        task.set_target_pose(np.array(task.current_position), np.asfortranarray(task.current_orientation))
    else:
        task.set_target_position(np.array(task.current_position))
    assert abs(error(q)).max() < 1e-12
    said = np.array(task.get_jacobian())
    steps = h * np.eye(model.nv)
    true = -np.array([(error(model.integrate(q, s, 1.0)) - error(model.integrate(q, -s, 1.0))) / (2 * h) for s in steps]).T
    wrong = abs(said - true)
    if isinstance(task, embodik.AbsoluteFrameTask):
        alone = [embodik.FrameTask(f"of {frame}", model, frame) for frame in ("l3", "r3")]
        for each in alone:
            each.update(model)
        left, right = (np.array(each.get_jacobian())[3:] for each in alone)
        share = task.get_alpha()
        assert np.allclose(said[3:], share * left + (1 - share) * right, atol=1e-9)
    return wrong[:3].max(), wrong[3:].max(initial=0.0), abs(true[3:]).max(initial=0.0)


def angle():
    legs = [embodik.FrameTask(f"at {frame}", model, frame) for frame in ("l3", "r3")]
    for leg in legs:
        leg.update(model)
    left, right = (np.array(leg.current_orientation) for leg in legs)
    return np.arccos(np.clip((np.trace(left.T @ right) - 1) / 2, -1, 1))


for scale in (0.1, 0.5):
    q = model.integrate(model.neutral_configuration(), scale * np.random.default_rng(3).normal(size=model.nv), 1.0)
    model.update_configuration(q)
    apart = angle()
    for task in (embodik.FrameTask("frame", model, "l3"), embodik.RelativeFrameTask("relative", model, "l3", "r3"),
                 embodik.COMTask("com", model)):
        assert max(off(task, q)[:2]) < 1e-8, task.name
    for weight in (0.0, 0.3, 0.5, 1.0):
        place, turn, largest = off(embodik.AbsoluteFrameTask("mean", model, "l3", "r3", weight), q)
        print(f"frames {apart:.2f} rad apart, weight {weight}: place rows off by {place:.1e}, orientation {turn:.2g} of {largest:.2f}")
        assert place < 1e-8
        if weight in (0.0, 1.0):
            assert turn < 1e-8
        else:
            assert turn > (0.25 if apart > 2 else 0.06) * largest
PY
