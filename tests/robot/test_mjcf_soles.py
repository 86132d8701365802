"""Soles and postures of MJCF files: what MuJoCo lets touch the ground, and its keyframes."""

from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from places import CASES

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot

CASE = CASES / "mj_geom_default_pos.xml"


def drop(robot):
    """Heights of the ankles above the soles [m]."""
    return robot.legs.ankles[:, 2]


def said(robot, topic):
    return "; ".join(f.text for f in robot.findings if f.topic == topic)


def edited(edit):
    root = ET.parse(CASE).getroot()
    edit(root)
    return ET.tostring(root, encoding="unicode")


def foot_geoms(root):
    return [b.find("geom") for b in root.iter("body") if b.get("name") in ("r6", "l6")]


def test_positions_of_a_class_count():
    robot = Robot.from_urdf(CASE)
    assert drop(robot) == pytest.approx([0.08, 0.08], abs=1e-12)
    assert robot.sole.toe - robot.sole.heel == pytest.approx(0.2, abs=1e-12)


def lifted(root):
    """A box for show under each foot, lower and larger than what touches."""
    for geom in foot_geoms(root):
        geom.set("pos", "0.03 0 -0.07")
        geom.set("size", "0.1 0.04 0.01")


@pytest.mark.parametrize("pairs", [False, True])
def test_what_only_shows_is_no_sole(pairs):
    """Pairs with a floor that the file does not hold say what touches, too."""

    def edit(root):
        lifted(root)
        contact = ET.SubElement(root, "contact") if pairs else None
        for body in root.iter("body"):
            if body.get("name") in ("r6", "l6"):
                for geom in body.findall("geom"):
                    mask = "0" if pairs else "1"
                    geom.attrib.update(
                        name=f"{body.get('name')}_pad", contype=mask, conaffinity=mask
                    )
                ET.SubElement(
                    body, "geom", type="box", size="0.2 0.1 0.01", pos="0 0 -0.12",
                    contype="0", conaffinity="0",
                )  # fmt: skip
                if contact is not None:
                    ET.SubElement(contact, "pair", geom1=f"{body.get('name')}_pad", geom2="floor")

    robot = Robot.from_urdf(edited(edit))
    assert drop(robot) == pytest.approx([0.08, 0.08], abs=1e-12)
    assert robot.sole.toe == pytest.approx(0.13, abs=1e-12)
    assert ("contact pairs with 'floor'" in said(robot, "contact")) == pairs
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert again.model == robot.model


@pytest.mark.parametrize("seed", range(6))
def test_soles_are_the_lowest_that_mujoco_finds(seed):
    """Boxes, capsules, spheres and cylinders under a foot against rays of MuJoCo from below."""
    rng = np.random.default_rng(seed)
    kind = ("box", "capsule", "sphere", "cylinder")[seed % 4]
    places = [(x, y) for x in (-0.06, 0.1) for y in (-0.03, 0.03)]
    low = float(rng.uniform(-0.1, -0.05))

    def edit(root):
        for body in root.iter("body"):
            if body.get("name") in ("r6", "l6"):
                for geom in body.findall("geom"):
                    body.remove(geom)
                for x, y in places:
                    size, turn, deep = {
                        "box": ("0.02 0.015 0.01", "0 0 0", 0.01),
                        "capsule": ("0.01 0.02", "0 1.5707963267948966 0", 0.01),
                        "sphere": ("0.008", "0 0 0", 0.008),
                        "cylinder": ("0.015 0.01", "0 0 0", 0.01),
                    }[kind]
                    ET.SubElement(
                        body, "geom", type=kind, size=size, euler=turn,
                        pos=f"{x} {y} {low + deep}", **{"class": "none"},
                    )  # fmt: skip
        defaults = root.find("default")
        none = ET.SubElement(defaults, "default", **{"class": "none"})
        ET.SubElement(none, "geom", pos="0 0 0")

    text = edited(edit)
    robot = Robot.from_urdf(text)
    assert drop(robot) == pytest.approx([-low, -low], abs=1e-9)
    length = {"box": 0.2, "capsule": 0.2, "sphere": 0.16}.get(kind)
    if length is not None:
        assert robot.sole.toe - robot.sole.heel == pytest.approx(length, abs=1e-6)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    foot = model.body("r6").id
    heights = []
    for x in np.linspace(-0.1, 0.14, 25):
        for y in np.linspace(-0.06, 0.06, 13):
            start = data.xpos[foot] + np.array([x, y, -1.0])
            geom = np.zeros(1, np.int32)
            far = mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, 1.0]), None, 1, -1, geom)
            if geom[0] >= 0 and model.geom_bodyid[geom[0]] == foot:
                heights.append(1.0 - far)
    assert min(-np.array(heights)) == pytest.approx(low, abs=1e-4)


@pytest.mark.parametrize("name", ["crouch", "keyframe:crouch"])
def test_keyframes_of_the_file_are_postures(name):
    def edit(root):
        names = [joint.get("name") for joint in root.iter("joint")]
        bend = {"hip_pitch": -0.3, "knee": 0.6, "ankle_pitch": -0.3}
        angles = [next((a for key, a in bend.items() if key in str(n)), 0.0) for n in names]
        qpos = " ".join(map(str, [0, 0, 1, 1, 0, 0, 0, *angles]))
        ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="crouch", qpos=qpos)

    text = edited(edit)
    robot = Robot.from_urdf(text, choices=ImportOptions(posture=name))
    assert dict(robot.choices.posture)["r_knee"] == pytest.approx(0.6)
    with pytest.raises(RobotError, match=r"it has: .*crouch"):
        Robot.from_urdf(text, choices=ImportOptions(posture="stand"))
