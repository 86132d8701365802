import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_joint, add_link, edits
from hypothesis import given, settings
from hypothesis import strategies as st
from pelvis_rooted import reading_of
from urdf_edits import edited_urdf, joint, link, scale_mass

from gaitopt.errors import RobotError
from gaitopt.robot.choices import Choices
from gaitopt.robot.mirror.symmetrise import mirrored
from gaitopt.robot.mirror.symmetry import exchange_error
from gaitopt.robot.model import Robot

quick = settings(deadline=None, derandomize=True, max_examples=25)


def said(robot: Robot, topic: str = "symmetry") -> list[str]:
    return [f"{f.how}: {f.subject}: {f.text}" for f in robot.findings if f.topic == topic]


def shift_com(name: str, xyz: str):
    def edit(root):
        link(root, name).find("inertial/origin").set("xyz", xyz)

    return edit


@quick
@given(st.integers(0, 1000))
def test_a_body_mirrored_twice_is_the_body(seed):
    pin.seed(seed)
    body = pin.Inertia.Random()
    image = mirrored(body)
    np.testing.assert_allclose(mirrored(image).matrix(), body.matrix(), atol=1e-14)
    # Mirrored motions carry the same energy: twists mirror with S, rotations with -S.
    twist = np.random.default_rng(seed).normal(size=6)
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    energy, other = (b.vtiv(pin.Motion(t)) for b, t in ((body, twist), (image, signs * twist)))
    assert energy == pytest.approx(other, rel=1e-12)


def test_the_symmetric_biped_is_left_alone(robot):
    assert said(robot) == []
    reading = reading_of(robot.urdf)
    masses = sorted(b.mass for b in reading.model.inertias)
    assert sorted(b.mass for b in robot.model.inertias) == masses


def test_a_heavier_foot_is_shared_between_the_feet(robot):
    heavy = Robot.from_urdf(edited_urdf(scale_mass("left_foot", 1.05)))
    assert heavy.mass == pytest.approx(robot.mass + 0.05 * 1.64, abs=1e-9)
    feet = [heavy.model.inertias[k].mass for k in (1, 13)]
    assert feet == pytest.approx([1.025 * 1.64] * 2, rel=1e-9)
    assert exchange_error(heavy.model, heavy.mirror, "right_sole", "left_sole") < 1e-12
    first, last = said(heavy)
    assert first.startswith("changed: left_ankle_roll: averaged with its mirror image: the two ")
    assert "82 g in mass" in first
    assert "4.9 % in mass" in first
    assert "averaging changed the mass matrix by" in last


def test_a_trunk_whose_mass_is_to_one_side_is_centred():
    leaning = Robot.from_urdf(edited_urdf(shift_com("torso", "0.01 0.003 0.2975")))
    assert exchange_error(leaning.model, leaning.mirror, "right_sole", "left_sole") < 1e-12
    data = leaning.model.createData()
    pin.centerOfMass(leaning.model, data, pin.neutral(leaning.model))
    pin.updateFramePlacements(leaning.model, data)
    assert data.oMf[leaning.pelvis_frame].actInv(data.com[0])[1] == pytest.approx(0.0, abs=1e-12)
    # The trunk's centre lies 3 mm to the left, its mirror image 3 mm to the right.
    assert "changed: trunk: " in said(leaning)[0]
    assert "6 mm in centre of mass" in said(leaning)[0]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            scale_mass("left_foot", 1.2),
            r"by 0.182 \(relative, in the mass of the link moved by 'left_ankle_roll': mass 328 g",
        ),
        (
            shift_com("torso", "0 0.05 0.2975"),
            r"in the centre of mass of the trunk: .* centre of mass 100 mm.*allowed is 0.08",
        ),
    ],
)
def test_a_lopsided_robot_is_refused_by_its_worst_link(edit, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edit))
    robot = Robot.from_urdf(edited_urdf(edit), choices=Choices(asymmetry=0.6))
    assert exchange_error(robot.model, robot.mirror, "right_sole", "left_sole") < 1e-12


def test_an_arm_on_one_side_only_shows_in_the_trunk():
    def one_arm(root):
        add_link(root, "arm", 8.0)
        add_joint(root, "shoulder", "torso", "arm", xyz="0 0.3 0.4")

    with pytest.raises(RobotError, match=r"in the centre of mass of the trunk"):
        Robot.from_urdf(edited_urdf(one_arm))


def test_inertias_left_out_of_one_leg_are_its_partners(robot):
    def empty(root):
        for name in ("right_thigh", "right_shin"):
            tensor = link(root, name).find("inertial/inertia")
            tensor.attrib.update(dict.fromkeys(("ixx", "iyy", "izz"), "0"))

    filled = Robot.from_urdf(edited_urdf(empty))
    for mine, its in zip(filled.model.inertias, robot.model.inertias, strict=True):
        np.testing.assert_allclose(mine.matrix(), its.matrix(), atol=1e-12)
    assert said(filled)[0].startswith("warning: right_hip_pitch, right_knee: the file gives these")


def _nudge(size: float):
    def edit(root):
        joint(root, "left_knee").find("origin").set("xyz", f"{size} 0 {-0.3 + size}")
        joint(root, "left_ankle_pitch").find("origin").set("rpy", f"0 0 {size}")

    return edit


@pytest.mark.parametrize("size", [3e-6, -2e-5])
def test_rounded_placements_are_mirrored_from_the_right_leg(robot, size):
    rounded = Robot.from_urdf(edited_urdf(_nudge(size)))
    error = exchange_error(rounded.model, rounded.mirror, "right_sole", "left_sole")
    assert error < 1e-12
    assert "the left leg's joints were moved onto the mirror image" in said(rounded)[0]
    np.testing.assert_allclose(rounded.legs.hips, robot.legs.hips, atol=1e-12)


def test_crooked_legs_are_refused_by_the_joint():
    message = r"the axis of 'right_knee' mirrors to a line .* away from its match 'left_knee'"
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edits(_nudge(2e-3))))
