"""Bipeds in MJCF whose ankles are turned by two cranks and two rods in each shin."""

import functools
from xml.etree import ElementTree as ET

import numpy as np
from tied_bipeds import plain_mjcf

from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot

RODS = {
    "inner": ((-0.01, -0.03, -0.10), (-0.06, -0.03, -0.10), (-0.06, -0.035, -0.32)),
    "outer": ((-0.01, 0.03, -0.18), (-0.06, 0.03, -0.18), (-0.06, 0.035, -0.32)),
}
"""Of the left shin: centre and end of the crank, end of the rod on the foot, all joints at 0."""
JOINTS = {
    "ball": ("<joint name='{0}_pin' type='ball'/>",),
    "universal": ("<joint name='{0}_pin' axis='0 1 0'/>", "<joint name='{0}_pin2' axis='1 0 0'/>"),
    "skew": (
        "<joint name='{0}_pin' axis='0 1 0' pos='0 0 0.01'/>",
        "<joint name='{0}_pin2' axis='1 0 0'/>",
    ),
    "hinge": ("<joint name='{0}_pin' axis='0 1 0'/>",),
}


def _text(values):
    return " ".join(repr(float(v)) for v in values)


def parallel_ankles(
    rods="ball",
    *,
    sites=False,
    on_foot=False,
    torque=30.0,
    armature=0.005,
    turned=0.0,
    narrow=False,
    welded=False,
    sliding=(),
) -> str:
    """An MJCF text; every option changes how the same loops are written down.

    Args:
        rods: what joins them to their cranks, of `JOINTS`.
        sites: whether loops are closed between sites, and not between bodies.
        on_foot: whether the rods hang on the foot, and not on the cranks.
        torque: of the motors [N·m; N].
        armature: of the cranks [kg·m²; kg].
        narrow: whether the ankles have a range in which cranks are never at a dead point.
        welded: whether rods end in a cup on a ball, which is welded to the foot.
        sliding: which of `RODS` hang on nuts that slide along the shin in place of cranks.
        turned: angle by which the file draws the cranks away from where the loops close [rad].
    """
    root = ET.fromstring(plain_mjcf())
    root.set("model", "parallel ankles")
    actuators, equality = root.find("actuator"), ET.SubElement(root, "equality")
    for motor in [m for m in actuators if "ankle" in m.get("joint")]:
        actuators.remove(motor)
    for side, mirror in (("left", 1.0), ("right", -1.0)):
        shin, foot = (
            root.find(f".//body[@name='{side}_{name}_body']") for name in ("knee", "ankle_roll")
        )
        below = _place(root, side)
        for name, points in RODS.items():
            centre, end, tip = (np.array(p) * (1.0, mirror, 1.0) for p in points)
            own = f"{side}_{name}"
            s, c = np.sin(turned), np.cos(turned)
            drawn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ (end - centre)
            moves = "axis='0 1 0' range='-1.2 1.2'"
            if name in sliding:
                moves = "type='slide' axis='0 0 1' range='-0.05 0.05'"
            crank = ET.fromstring(
                f"<body name='{own}_crank' pos='{_text(centre)}'><joint name='{own}_motor' "
                f"{moves} armature='{armature!r}'/><inertial "
                f"pos='{_text(drawn / 2.0)}' mass='0.1' diaginertia='4e-5 4e-5 4e-5'/></body>"
            )
            shin.append(crank)
            ET.SubElement(
                actuators, "motor", joint=f"{own}_motor", ctrlrange=f"{-torque!r} {torque!r}"
            )
            carrier, at, to = (
                (foot, tip - below, end - tip) if on_foot else (crank, drawn, tip - end)
            )
            rod = ET.fromstring(
                f"<body name='{own}_rod' pos='{_text(at)}'>"
                f"{''.join(JOINTS[rods]).format(own)}<inertial pos='{_text(to / 2.0)}' "
                "mass='0.1' diaginertia='3e-4 3e-4 1e-5'/></body>"
            )
            carrier.append(rod)
            last, there = (crank, drawn) if on_foot else (foot, tip - below)
            if welded:
                cup = ET.fromstring(
                    f"<body name='{own}_cup' pos='{_text(to)}' quat='0.6 0 0.8 0'><joint "
                    f"name='{own}_pin3' type='ball'/><inertial pos='0 0 0' mass='0.01' "
                    "diaginertia='1e-6 1e-6 1e-6'/></body>"
                )
                rod.append(cup)
                ET.SubElement(equality, "weld", body1=cup.get("name"), body2=last.get("name"))
            elif sites:
                for body, point, word in ((rod, to, "rod"), (last, there, "end")):
                    ET.SubElement(body, "site", name=f"{own}_{word}", pos=_text(point))
                ET.SubElement(equality, "connect", site1=f"{own}_rod", site2=f"{own}_end")
            else:
                ET.SubElement(
                    equality, "connect", body1=f"{own}_rod", body2=last.get("name"),
                    anchor=_text(to),
                )  # fmt: skip
    for joint in root.iter("joint"):
        if narrow and joint.get("name", "").endswith(("ankle_pitch", "ankle_roll")):
            joint.set("range", "-0.4 0.4")
    ET.indent(root)
    return ET.tostring(root, encoding="unicode")


def _place(root, side):
    """Where the foot's frame is in the shin's, all joints at 0."""
    bodies = (
        root.find(f".//body[@name='{side}_{name}_body']") for name in ("ankle_pitch", "ankle_roll")
    )
    return sum(np.array([float(n) for n in body.get("pos").split()]) for body in bodies)


@functools.cache
def looped(**how: object) -> Robot:
    """The biped of `parallel_ankles`."""
    return Robot.from_urdf(parallel_ankles(**how))


def left_open(**choices: object) -> Robot:
    """The biped of `parallel_ankles` without its loops."""
    return Robot.from_urdf(parallel_ankles(), choices=ImportOptions(without=("loops",), **choices))
