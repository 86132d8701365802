"""Masses and inertias set by link: the robot is the one whose file has them."""

from xml.etree import ElementTree as ET

import numpy as np
import pytest
from humanoids import add_joint, add_link, edits
from urdf_edits import edited_urdf, link

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions, InertiaOverride, choices_from_toml
from gaitopt.model.robot import Robot

SIDES = ("left", "right")
TURNING = (0.03, 0.02, 0.015, 0.001, -0.002, 0.0015)


def body(mass, com, turning):
    """An edit that writes bodies into the file, mirrored."""

    def edit(root):
        for side, sign in (("right", 1.0), ("left", -1.0)):
            shin = link(root, f"{side}_shin")
            for old in shin.findall("inertial"):
                shin.remove(old)
            names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            signs = (1.0, 1.0, 1.0, sign, 1.0, sign)
            values = " ".join(
                f"{n}='{s * v!r}'" for n, s, v in zip(names, signs, turning, strict=True)
            )
            x, y, z = com
            shin.append(
                ET.fromstring(
                    f"<inertial><origin xyz='{x} {sign * y} {z}'/><mass value='{mass}'/>"
                    f"<inertia {values}/></inertial>"
                )
            )

    return edit


def given(mass, com, turning):
    mirrored = tuple(v * s for v, s in zip(turning, (1, 1, 1, -1, 1, -1), strict=True))
    return (
        InertiaOverride("right_shin", mass, com, turning),
        InertiaOverride("left_shin", mass, (com[0], -com[1], com[2]), mirrored),
    )


def bodies(robot):
    return np.array([b.toDynamicParameters() for b in robot.model.inertias])


@pytest.mark.parametrize("seed", range(4))
def test_a_body_that_is_set_is_that_of_a_file_that_has_it(robot, seed):
    rng = np.random.default_rng(seed)
    mass, com = float(rng.uniform(1.0, 6.0)), tuple(rng.uniform(-0.1, 0.1, 3))
    written = Robot.from_urdf(edited_urdf(body(mass, com, TURNING)))
    chosen = Robot.from_urdf(robot.urdf, choices=ImportOptions(inertias=given(mass, com, TURNING)))
    np.testing.assert_allclose(bodies(chosen), bodies(written), atol=1e-12)
    assert chosen.mass == pytest.approx(written.mass, abs=1e-12)
    again = Robot.from_urdf(chosen.urdf, choices=chosen.choices)
    np.testing.assert_array_equal(bodies(again), bodies(chosen))
    (told, _) = [f for f in chosen.findings if f.topic == "inertia"]
    assert (told.subject, told.how) == ("right_shin", "given")
    assert f"mass {mass:g} kg, centre of mass (" in told.text
    assert "in place of those of the file: 'right_shin' " in told.text


def test_links_fixed_to_others_keep_theirs(robot):
    def pack(root):
        add_link(root, "pack", 4.0)
        add_joint(root, "strap", "torso", "pack", xyz="-0.1 0 0.3", kind="fixed")

    text = edited_urdf(pack)
    half = ImportOptions(inertias=(InertiaOverride("pack", mass=2.0),))
    packed, light = Robot.from_urdf(text), Robot.from_urdf(text, choices=half)
    assert packed.mass - light.mass == pytest.approx(2.0, abs=1e-12)
    # A pack of half the mass: halfway between the robot with the whole one and with none.
    mean = (bodies(packed) + bodies(robot)) / 2.0
    np.testing.assert_allclose(bodies(light), mean, atol=1e-10)


def test_a_bad_body_of_the_file_is_mended():
    wrong = edited_urdf(body(3.0, (0.0, 0.0, -0.1), (9.0, 0.1, 0.1, 0.0, 0.0, 0.0)))
    with pytest.raises(RobotError, match="the inertia cannot belong to a body"):
        Robot.from_urdf(wrong)
    mended = ImportOptions(inertias=(InertiaOverride("*_shin", inertia=(0.1, 0.1, 0.05, 0, 0, 0)),))
    assert Robot.from_urdf(wrong, choices=mended).mass > 50.0

    def bare(root):
        for side in SIDES:
            foot = link(root, f"{side}_shin")
            foot.remove(foot.find("inertial"))

    whole = InertiaOverride("*_shin", 3.0, (0.0, 0.0, -0.1), (0.1, 0.1, 0.05, 0, 0, 0))
    text = edited_urdf(edits(bare))
    assert Robot.from_urdf(text, choices=ImportOptions(inertias=(whole,))).mass > 50.0


@pytest.mark.parametrize(
    ("override", "told"),
    [
        ({"links": "tail", "mass": 1.0}, "no link matches 'tail'; the links are: .*torso"),
        ({"links": "torzo", "mass": 1.0}, "matches 'torzo'; did you mean 'torso'. the links are"),
        ({"links": "*", "mass": 0.0}, "mass is 0 kg; it must be > 0"),
        ({"links": "*", "mass": "1"}, "mass must be a number"),
        ({"links": "*"}, "nothing is replaced; give mass, com or inertia"),
        ({"links": "*", "com": [0.0, 1.0]}, "com has 2 numbers; give x, y, z"),
        ({"links": "*", "inertia": [1.0, 1.0, 3.0, 0, 0, 0]}, "link '.*': the inertia cannot bel"),
        ({"links": "*", "inertia": [-1.0, 1.0, 1.0, 0, 0, 0]}, "is not positive definite"),
        ({"links": "", "mass": 1.0}, "links must be a pattern of names"),
    ],
)
def test_bodies_that_cannot_be_are_refused(robot, override, told):
    with pytest.raises(RobotError, match=told):
        Robot.from_urdf(robot.urdf, choices=ImportOptions(inertias=(InertiaOverride(**override),)))


def test_choices_files_hold_bodies(tmp_path):
    text = """[[inertias]]
links = "*_shin"
mass = 3.5
com = [0.0, 0.0, -0.12]
"""
    (found,) = choices_from_toml(text).inertias
    assert found == InertiaOverride("*_shin", 3.5, (0.0, 0.0, -0.12))
    with pytest.raises(RobotError, match="inertias: links is missing"):
        choices_from_toml("[[inertias]]\nmass = 1.0\n")
    with pytest.raises(RobotError, match=r"unknown entry inertias\.weight"):
        choices_from_toml('[[inertias]]\nlinks = "a"\nweight = 1.0\n')
