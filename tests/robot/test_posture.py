"""The reference posture against the ranges of the joints."""

import math
from pathlib import Path

import pinocchio as pin
import pytest
from urdf_edits import add_arm, edited_urdf, joint

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.reference_posture import reference_angles, rotor_armatures
from gaitopt.model.robot import Robot

POSES = """<robot name="biped13"><group_state name="{name}" group="all">
<joint name="shoulder" value="{angle}"/></group_state></robot>"""


def armed(lower=-1.0, upper=1.0, kind="revolute"):
    """The biped with an arm whose shoulder has a range."""

    def edit(root):
        add_arm(root)
        joint(root, "shoulder").set("type", kind)
        joint(root, "shoulder").find("limit").attrib.update(lower=f"{lower}", upper=f"{upper}")

    return edited_urdf(edit)


def read(angle, text=None, **choices):
    choices = ImportOptions(posture={"shoulder": angle}, asymmetry=1.0, **choices)
    return Robot.from_urdf(text or armed(), choices=choices)


def told(robot):
    return [
        (f.how, f.text) for f in robot.findings if (f.topic, f.subject) == ("posture", "shoulder")
    ]


@pytest.mark.parametrize(
    ("angle", "hint"),
    [(9.0, "degrees. 9 degrees are 0.1571 rad; "), (-1.2, ""), (2.0, ""), (200.0, "")],
)
def test_an_angle_far_beyond_the_range_is_refused(angle, hint):
    text = (
        f"posture: joint 'shoulder' is at {angle:g} rad, but its range is -1 to 1 rad; {hint}give"
    )
    with pytest.raises(RobotError, match=f"^{text} an angle in its range"):
        read(angle)


def test_a_pose_of_an_srdf_is_held_to_the_same():
    far = POSES.format(name="far", angle=1.5)
    with pytest.raises(RobotError, match=r"'shoulder' is at 1.5 rad, but its range is -1 to 1 rad"):
        Robot.from_urdf(armed(), choices=ImportOptions(posture="far", srdf=far))
    near = POSES.format(name="near", angle=1.04)
    robot = Robot.from_urdf(armed(), choices=ImportOptions(posture="near", srdf=near))
    assert told(robot) == [("warning", "stands at 1.04 rad, outside its range -1 to 1 rad")]
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert told(again) == told(robot)


@pytest.mark.parametrize("angle", ["0.1 0.2", "", " ", "low"])
def test_a_joint_of_a_pose_has_one_angle(angle):
    """It was passed over without a word, and stood at zero."""
    pose = POSES.format(name="p", angle=angle)
    with pytest.raises(RobotError, match=f"value of 'shoulder' as '{angle}'; it must be a number"):
        Robot.from_urdf(armed(), choices=ImportOptions(posture="p", srdf=pose))


def test_joints_of_other_robots_and_the_root_are_no_part_of_a_pose():
    more = '<joint name="root_joint" value="0 0 1 0 0 0 1"/><joint name="other" value="9"/>'
    pose = POSES.format(name="p", angle=0.25).replace("</group_state>", f"{more}</group_state>")
    robot = Robot.from_urdf(armed(), choices=ImportOptions(posture="p", srdf=pose))
    assert dict(robot.choices.posture) == {"shoulder": 0.25}


def test_groups_of_joints_make_one_pose():
    """Those of left and right arms have one name; the last one alone counted."""
    own = POSES.format(name="p", angle=0.25)
    other = '<group_state name="p" group="legs"><joint name="left_knee" value="0.3"/></group_state>'
    robot = Robot.from_urdf(
        armed(),
        choices=ImportOptions(posture="p", srdf=own.replace("</robot>", f"{other}</robot>")),
    )
    assert dict(robot.choices.posture) == {"shoulder": 0.25, "left_knee": 0.3}
    twice = own.replace("</robot>", own[own.index("<group") :].replace("0.25", "0.5"))
    with pytest.raises(
        RobotError, match=r"'shoulder' two angles in the pose 'p', 0\.25 and 0\.5; r"
    ):
        Robot.from_urdf(armed(), choices=ImportOptions(posture="p", srdf=twice))


def test_a_joint_of_an_srdf_has_one_rotor():
    rotor = '<joint name="shoulder" mass="1e-4" gear_ratio="{}"/>'
    rotors = "<robot><rotor_params>{}{}</rotor_params></robot>"
    same = rotors.format(rotor.format(10), rotor.format(10))
    choices = ImportOptions(srdf=same, rotors=True)
    assert rotor_armatures(choices, Path()) == pytest.approx({"shoulder": 0.01})
    other = rotors.format(rotor.format(10), rotor.format(20))
    with pytest.raises(RobotError, match=r"'shoulder' two armatures .*, 0\.01 and 0\.04; remove"):
        rotor_armatures(ImportOptions(srdf=other, rotors=True), Path())


def test_a_neutral_posture_out_of_range_is_told():
    robot = Robot.from_urdf(armed(lower=0.3, upper=1.2))
    assert told(robot) == [("guessed", "stands at 0 rad, outside its range 0.3 to 1.2 rad")]
    assert told(Robot.from_urdf(armed(lower=-0.3))) == []


def test_a_range_may_be_widened_or_absent():
    assert read(1.5, limits=(LimitOverride("shoulder", upper=2.0),)).mass > 56.0
    assert read(1.5, armed(0.0, 0.0)).mass > 56.0
    assert read(7.0, armed(kind="continuous")).mass > 56.0  # that turns for ever
    # A narrower range is for the walk; the pose of the file stays.
    narrow = read(0.8, limits=(LimitOverride("shoulder", upper=0.5),))
    assert told(narrow) == [("warning", "stands at 0.8 rad, outside its range -1 to 0.5 rad")]


def test_without_a_range_a_turn_is_the_most():
    with pytest.raises(RobotError, match=r"at 20 rad, .* -6.283 to 6.283 rad; degrees\? 20 deg"):
        read(20.0, armed(0.0, 0.0))
    assert math.radians(20.0) == pytest.approx(0.3491, abs=1e-4)


def test_a_continuous_joint_may_be_given_a_range():
    limits = (LimitOverride("shoulder", lower=-1.0, upper=2.0),)
    robot = read(2.05, armed(kind="continuous"), limits=limits)
    assert told(robot) == [("warning", "stands at 2.05 rad, outside its range -1 to 2 rad")]


def test_a_legs_neutral_posture_out_of_range_is_told():
    def edit(root):
        for side in ("left", "right"):
            joint(root, f"{side}_knee").find("limit").attrib.update(lower="0.2", upper="2.4")

    robot = Robot.from_urdf(edited_urdf(edit))
    said = [f.text for f in robot.findings if (f.topic, f.subject) == ("posture", "right_knee")]
    assert said == [
        "stands at 0 rad, outside its range 0.2 to 2.4 rad; the walk keeps the range, only feet "
        "and soles are looked at so"
    ]
    knees = [f.text for f in robot.findings if (f.topic, f.how) == ("legs", "warning")]
    assert len(knees) == 2
    assert "straight at 0 rad, 0.2 rad outside its range 0.2 to 2.4 rad" in knees[0]


def keyframed():
    """A model with two keyframes, as a reader of MJCF files makes it."""
    model = read_source(armed()).model()
    rows = {name: model.joints[model.getJointId(name)].idx_q for name in ("shoulder", "left_knee")}
    for name, angle in (("home", 0.25), ("sit", 0.5)):
        q = pin.neutral(model)
        q[rows["shoulder"]] = angle
        model.referenceConfigurations[name] = q
    return model


@pytest.mark.parametrize(("name", "angle"), [("home", 0.25), ("keyframe:sit", 0.5)])
def test_keyframes_are_postures(name, angle):
    found = reference_angles(ImportOptions(posture=name), keyframed(), Path())
    assert found == {"shoulder": angle}


@pytest.mark.parametrize(
    ("choices", "told"),
    [
        (ImportOptions(posture="stand"), "no SRDF is given .* and it has: home, sit$"),
        (ImportOptions(posture="keyframe:stand"), "no keyframe 'stand'; it has: home, sit$"),
        (ImportOptions(posture="keyframe:hom"), "'hom'; did you mean 'home'. it has: home, sit$"),
        (
            ImportOptions(posture="stand", srdf=POSES.format(name="far", angle=0.1)),
            "the SRDF has no pose 'stand'; it has: far; the robot's file has keyframes: home, sit$",
        ),
        (
            ImportOptions(posture="keyframe:sit", srdf=POSES.format(name="far", angle=0.1)),
            "an SRDF is given .*, but nothing of it is used",
        ),
    ],
)
def test_unknown_postures_are_answered_with_those_there_are(choices, told):
    with pytest.raises(RobotError, match=told):
        reference_angles(choices, keyframed(), Path())
    with pytest.raises(RobotError, match="the robot's file has no keyframes"):
        reference_angles(ImportOptions(posture="x"), read_source(armed()).model(), Path())
