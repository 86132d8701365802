"""Robots and soles in wrong units: each is told with its value and what is plausible."""

import re
from xml.etree import ElementTree as ET

import pytest
import trimesh
from places import CASES
from similar_robots import Units, similar_urdf
from urdf_edits import edited_urdf

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole


def scaled(lengths=1.0, masses=1.0, inertias=1.0):
    """The biped with other units."""

    def edit(root):
        for element in root.iter():
            for name, factor in (("xyz", lengths), ("size", lengths), ("value", masses)):
                if name in element.attrib:
                    words = element.attrib[name].split()
                    if element.tag != "axis":
                        element.set(name, " ".join(repr(factor * float(w)) for w in words))
            if element.tag == "inertia":
                for name, value in element.attrib.items():
                    element.set(name, repr(inertias * float(value)))

    return edited_urdf(edit)


def warnings(robot):
    """Warnings but for rotors, which the biped has none of."""
    told = [f for f in robot.findings if f.how == "warning" and f.topic != "armature"]
    return [f"{f.topic}: {f.subject}: {f.text}" for f in told]


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ({"lengths": 1e3}, "legs: both legs: the legs are 600 m long .* 0.1 to 5 m .* in mm"),
        ({"lengths": 1e2}, "legs: both legs: the legs are 60 m long .* 0.1 to 5 m .* file in cm"),
        ({"lengths": 0.15}, "legs: .* 0.09 m .* plausible; lengths of the file must be in m$"),
        ({"masses": 1e3, "inertias": 1e3}, r"mass: robot: the robot weighs 5\.687e\+04 kg; 0.5 to "
         "1000 kg are plausible; are masses of the file in g\\? They must be in kg$"),
        ({"inertias": 1e6}, "inertia: left_hip_yaw and 5 more of each leg: "
         "the link that 'left_hip_yaw' moves .* above 1800 mm .* in g·m² or kg·mm²"),
        ({"inertias": 0.0}, "inertia: left_hip_yaw and 5 more of each leg: the link that .* up to "
         "0 kg·m², a radius of gyration of 0 mm; below 0.6 mm is implausible; are inertias left"),
    ],
)  # fmt: skip
def test_wrong_units_are_told(units, message):
    told = warnings(Robot.from_urdf(scaled(**units)))
    # What single links say of the same slip stands beside it.
    assert sum(re.search(message, one) is not None for one in told) == 1
    assert len(told) <= 13


ROUND = (
    "<collision><origin xyz='0.03 0 -0.05'/><geometry><mesh filename='{mesh}'/></geometry>"
    "</collision>"
)


def with_round_feet(folder):
    """The small biped with ellipsoids of 240 x 120 x 40 mm, cut flat below, as feet."""
    ball = trimesh.creation.icosphere(subdivisions=4)
    ball.apply_scale([0.12, 0.06, 0.02])
    ball.vertices[:, 2] = ball.vertices[:, 2].clip(-0.016)
    ball.export(folder / "foot.stl")
    root = ET.parse(CASES / "base_mini.urdf").getroot()
    for link in root.findall("link"):
        if (old := link.find("collision")) is not None:
            link.remove(old)
            link.append(ET.fromstring(ROUND.format(mesh=folder / "foot.stl")))
    return ET.tostring(root, encoding="unicode")


@pytest.mark.parametrize("feet", ["flat", "round"])
@pytest.mark.parametrize("length", [0.1, 0.5, 2.0, 10.0])
def test_legs_and_soles_are_found_whatever_the_size(tmp_path, feet, length):
    flat = (CASES / "base_mini.urdf").read_text()
    text = flat if feet == "flat" else with_round_feet(tmp_path)
    own, other = (
        Robot.from_urdf(similar_urdf(text, Units(length=by, mass=by**3))) for by in (1.0, length)
    )
    assert feet == "flat" or 0.1 < own.sole.length < 0.2
    for edge in ("toe", "heel", "left", "right"):
        assert getattr(other.sole, edge) == pytest.approx(length * getattr(own.sole, edge), 1e-6)
    assert other.joint_names == own.joint_names
    assert other.legs.reach == pytest.approx(length * own.legs.reach)
    # Only whether a robot is as small or large as any that walks depends on its size.
    topics = [[told.split(":")[0] for told in warnings(one)] for one in (own, other)]
    assert topics[0] == [one for one in topics[1] if one not in ("legs", "mass")]


@pytest.mark.parametrize("units", [{}, {"lengths": 2.5}, {"masses": 3.0, "inertias": 3.0}])
def test_other_sizes_are_let_be(units):
    assert warnings(Robot.from_urdf(scaled(**units))) == []


def test_a_sole_larger_than_a_leg_is_refused(robot):
    with pytest.raises(
        RobotError,
        match=r"the sole is 170 m long and 50 m wide, but the legs measure only 0.6 m .* not in mm",
    ):
        Robot.from_urdf(robot.urdf, sole=Sole(120.0, -50.0, 25.0, -25.0))
    large = Sole(0.3, -0.25, 0.2, -0.2)
    assert Robot.from_urdf(robot.urdf, sole=large).sole == large


def test_a_height_of_the_ankle_other_than_that_of_the_foot_is_told(robot):
    seen = float(robot.legs.ankles[0, 2])
    (told,) = warnings(Robot.from_urdf(robot.urdf, choices=ImportOptions(sole_drop=0.5)))
    assert "sole_drop is 500.0 mm as given, but the lower faces of the feet were found " in told
    assert f"found {seen * 1e3:.1f} mm below the ankles; the given one counts" in told
    assert (
        warnings(Robot.from_urdf(robot.urdf, choices=ImportOptions(sole_drop=seen + 0.004))) == []
    )


def test_soles_above_the_ankles_are_told():
    text = (CASES / "base_mini.urdf").read_text()
    assert warnings(Robot.from_urdf(text)) == []
    (told,) = warnings(Robot.from_urdf(text.replace("0.03 0 -0.07", "0.03 0 0.07")))
    assert told.startswith("sole: both feet: the soles lie 60.0 mm above the ankles, where no foot")
