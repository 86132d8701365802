"""Robots whose links bear the names of their joints, as URDF and MJCF allow."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait

from gaitopt import biped13, urdf_text
from gaitopt.importers.pinocchio_model import mark_joint_frames, reduced
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.view.page import page_text

TEXT = urdf_text(biped13())
CHILDREN = dict(
    re.findall(r'<joint name="(\w+)" type="\w+">.*?<child link="(\w+)"', TEXT, re.DOTALL)
)


def namesakes(text: str) -> str:
    """Give every link the name of the joint that moves it, save the soles."""
    for joint, link in CHILDREN.items():
        if not link.endswith("_sole"):
            text = text.replace(f'"{link}"', f'"{joint}"')
    return text


@pytest.fixture(scope="module")
def robots():
    return Robot.from_urdf(TEXT), Robot.from_urdf(namesakes(TEXT))


def test_it_is_the_same_robot(robots):
    usual, other = robots
    assert other.joint_names == usual.joint_names
    pin.seed(3)
    q = pin.randomConfiguration(usual.model)
    inertias = [pin.crba(robot.model, robot.model.createData(), q) for robot in robots]
    np.testing.assert_array_equal(*inertias)


def test_a_sole_may_be_asked_for_by_a_name_that_a_joint_has():
    text = namesakes(TEXT).replace('"left_sole_joint"', '"left_sole"')
    robot = Robot.from_urdf(
        text, choices=ImportOptions(swing_sole="left_sole", stance_sole="right_sole")
    )
    assert (robot.stance_sole, robot.swing_sole) == ("right_sole", "left_sole")


def test_its_walk_is_drawn():
    gait = sample_gait()
    same = replace(gait, urdf=namesakes(gait.urdf))
    assert len(page_text(same, steps=1)) == pytest.approx(len(page_text(gait, steps=1)), rel=0.01)


@pytest.mark.parametrize("joint", ["left_hip_yaw", "left_knee", "right_ankle_roll"])
def test_a_joint_is_locked_as_if_nothing_were_named_like_it(joint):
    models = [
        mark_joint_frames(pin.buildModelFromXML(text, pin.JointModelFreeFlyer()))
        for text in (TEXT, namesakes(TEXT))
    ]
    q = pin.neutral(models[0])
    q[7:] = 0.1
    locked = [models[0].getJointId(joint)]
    expected = pin.buildReducedModel(models[0], locked, q)
    found = reduced(models[1], locked, q)
    assert list(found.names) == list(expected.names)
    assert found.inertias.tolist() == expected.inertias.tolist()
    links = [f.name for f in found.frames if f.type == pin.FrameType.BODY]
    assert CHILDREN[joint] not in links
    assert joint in links
    assert len({f.name for f in found.frames}) == found.nframes
