"""Rotor inertia and reduction, as ROS, Drake and others write them."""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from places import CASES
from urdf_edits import edited_urdf, joint

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.robot import Robot

INERTIA, REDUCTION = 3e-5, 41.0


def knee(text):
    """The generated biped with the rotor of one knee."""

    def edit(root):
        root.append(ET.fromstring(text))

    return edited_urdf(edit)


def armature(text, name="left_knee"):
    model = read_source(text).model()
    return float(model.armature[model.joints[model.getJointId(name)].idx_v])


FORMS = {
    "ROS 1": "<transmission name='t'><type>transmission_interface/SimpleTransmission</type>"
    "<joint name='left_knee'/><actuator name='m'><mechanicalReduction>41</mechanicalReduction>"
    "<motorInertia> 3e-5 </motorInertia></actuator></transmission>",
    "in the joint": "<transmission name='t'><joint name='left_knee'><mechanicalReduction>-41"
    "</mechanicalReduction></joint><actuator name='m'><rotorInertia>3e-5</rotorInertia></actuator>"
    "</transmission>",
    "both": "<transmission><joint name='left_knee'><mechanicalReduction>41</mechanicalReduction>"
    "</joint><actuator name='m'><mechanicalReduction>41.0</mechanicalReduction>"
    "<motorInertia>3e-5</motorInertia></actuator></transmission>",
    "ROS 2": "<ros2_control><transmission><actuator name='m'/><joint name='left_knee'>"
    "<mechanical_reduction>41</mechanical_reduction></joint>"
    "<param name='rotor_inertia'>3e-5</param>"
    "</transmission></ros2_control>",
    "old ROS": "<transmission><joint name='left_knee'/><actuator name='m'/>"
    "<mechanicalReduction>41</mechanicalReduction><rotor_inertia value='3e-5'/></transmission>",
    "Drake": "<transmission><joint name='left_knee'/><actuator name='m'>"
    "<rotor_inertia value='3e-5'/><gear_ratio value='41'/></actuator></transmission>",
    "Gazebo": "<gazebo reference='left_knee'><rotorInertia>3e-5</rotorInertia>"
    "<gearRatio>41</gearRatio></gazebo>",
    "direct": "<gazebo reference='left_knee'><armature>0.05043</armature></gazebo>",
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_armature_is_inertia_times_reduction_squared(form):
    text = knee(FORMS[form])
    assert armature(text) == pytest.approx(INERTIA * REDUCTION**2, rel=1e-14)
    assert armature(text, "right_knee") == 0.0
    (finding,) = [f for f in read_source(text).findings() if f.topic == "armature"]
    assert (finding.subject, finding.how) == ("left_knee", "found")
    assert "0.05043 kg·m²" in finding.text


def test_prefixes_of_drake_need_no_declaration():
    text = knee(FORMS["Drake"]).replace("rotor_inertia", "drake:rotor_inertia")
    text = text.replace("gear_ratio", "drake:gear_ratio")
    assert armature(text) == pytest.approx(INERTIA * REDUCTION**2)


def test_it_may_stand_in_the_joint():
    def edit(root):
        attributes = {"rotor_inertia": "3e-5", "gear_ratio": "41", "damping": "0.5"}
        joint(root, "left_knee").append(ET.Element("dynamics", attributes))

    assert armature(edited_urdf(edit)) == pytest.approx(INERTIA * REDUCTION**2)


def test_two_motors_of_one_joint_add_up():
    text = knee(FORMS["ROS 1"]).replace("</robot>", FORMS["old ROS"] + "</robot>")
    assert armature(text) == pytest.approx(2.0 * INERTIA * REDUCTION**2)


def test_a_rotor_without_a_reduction_is_warned_about():
    text = knee("<transmission><joint name='left_knee'/><rotorInertia>0.02</rotorInertia>"
                "</transmission>")  # fmt: skip
    assert armature(text) == 0.02
    (finding,) = read_source(text).findings()
    assert finding.how == "warning"
    assert "it gives no reduction, which is taken as 1" in finding.text


def test_a_reduction_alone_changes_nothing():
    text = knee("<transmission><joint name='left_knee'/><mechanicalReduction>fast"
                "</mechanicalReduction></transmission>")  # fmt: skip
    assert armature(text) == 0.0
    assert read_source(text).problems == ()


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ("<motorInertia>1e</motorInertia>", r"<motorInertia> is '1e'; it must be a finite number"),
        (
            "<motorInertia>-1</motorInertia>",
            "its rotor inertia is -1.0 kg·m²; it must not be below",
        ),
        ("<motorInertia>1</motorInertia><motorInertia>2</motorInertia>", "is 2, but 1 is given as"),
        ("<motorInertia>1</motorInertia><gear_ratio>0</gear_ratio>", "its reduction is 0"),
        (
            "<motorInertia>1</motorInertia><gear_ratio>50</gear_ratio>",
            r"seen from its joint its rotor has 2500 kg·m² .*; at most 1000 kg·m²; correct it",
        ),
        ("<motorInertia>1</motorInertia><gear_ratio>4_0</gear_ratio>", "<gear_ratio> is '4_0'"),
    ],
)
def test_rotors_that_are_no_numbers_are_refused(inside, message):
    with pytest.raises(RobotError, match=rf"^line \d+: .*{message}"):
        read_source(knee(f"<transmission><joint name='left_knee'/>{inside}</transmission>"))


@pytest.mark.parametrize(
    ("rotor", "said"),
    [
        ("<armature>0.3</armature>", "armature 0.3 kg: rotor inertia 0.3 kg of the file"),
        (
            "<rotorInertia>3e-5</rotorInertia><gearRatio>100</gearRatio>",
            "armature 0.3 kg: rotor inertia 3e-05 kg·m² of the file, times the reduction 100 squ",
        ),
        ("<armature>5000</armature>", "its rotor has 5000 kg .*; at most 1000 kg; correct it"),
        ("<armature>much</armature>", r"it must be a finite number \[kg\]; correct it"),
    ],
)
def test_armature_of_joints_that_slide_is_a_mass(rotor, said):
    def edit(root):
        joint(root, "left_knee").set("type", "prismatic")
        root.append(ET.fromstring(f"<gazebo reference='left_knee'>{rotor}</gazebo>"))

    text = edited_urdf(edit)
    try:
        (told,) = [f.text for f in read_source(text).findings() if f.topic == "armature"]
    except RobotError as error:
        told = str(error)
    assert re.search(said, told), told


@pytest.mark.parametrize(
    ("joints", "reason"),
    [
        ("<joint name='left_knee'/><joint name='right_knee'/>", "it has 2 joints and 0 actuators"),
        ("<joint name='left_knee'/><actuator/><actuator/>", "it has 1 joints and 2 actuators"),
        ("<joint name='knee'/>", "the robot has no joint 'knee'"),
        ("<joint name='left_sole_joint'/>", "joint 'left_sole_joint' is fixed"),
    ],
)
def test_rotors_of_no_single_joint_are_told(joints, reason):
    text = knee(f"<transmission name='t'>{joints}<rotorInertia>1</rotorInertia></transmission>")
    (problem,) = read_source(text).problems
    assert problem.kind == "rotor"
    assert f"transmission 't': its rotor inertia is not counted: {reason}" in str(problem)
    assert not np.any(read_source(text).model().armature)


@pytest.mark.parametrize(
    ("reference", "reason"),
    [("left_shin", "the robot has no joint 'left_shin'"), ("left_sole_joint", "is fixed")],
)
def test_armature_of_no_moving_joint_is_told(reference, reason):
    text = knee(f"<gazebo reference='{reference}'><armature>0.03</armature></gazebo>")
    (problem,) = read_source(text).problems
    assert problem.kind == "rotor"
    assert "<gazebo>: its armature is not counted: " in str(problem)
    assert reason in str(problem)
    assert not np.any(read_source(text).model().armature)


def test_the_rotors_of_a_file_count_in_its_robot():
    robot = Robot.from_urdf(CASES / "urdf_transmission_rotor.urdf")
    np.testing.assert_allclose(robot.model.armature[6:], 0.25, rtol=1e-14)
    told = [f for f in robot.findings if f.topic == "armature" and "reduction 50 squared" in f.text]
    assert len(told) == 1
