"""What an MJCF file may leave out or add, and what is too much of it."""

import numpy as np
import pinocchio as pin
import pytest
from mjcf_edits import added, at, edited, together
from mjcf_text import mjcf_text

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import MOST_JOINTS
from gaitopt.importers.reader import read_source
from gaitopt.model.robot import Robot

SHIN = ".//body[@name='left_knee_body']"
FOOT = "type='box' size='0.1 0.05 0.01' pos='0.05 0 -0.05'"


@pytest.fixture(scope="module")
def sound():
    """The text of a sound biped."""
    return mjcf_text(read_source(urdf_text(biped13())).model(), foot_geom=FOOT)


def knee_body(text):
    model = read_source(text).model()
    return model.inertias[model.getJointId("left_knee")]


def test_what_has_no_inertia_is_a_point_mass(sound):
    lamp = "<body name='lamp' pos='0 0 -0.1'><inertial pos='0 0.2 0' mass='1.5'/></body>"
    point = pin.Inertia(1.5, np.array([0.0, 0.2, -0.1]), np.zeros((3, 3)))
    text = edited(sound, added(SHIN, lamp))
    assert knee_body(text).isApprox(knee_body(sound) + point, 1e-9)
    lamp = lamp.replace("0 0.2 0", "0 0 0.2")
    lit = Robot.from_urdf(edited(sound, added(".//worldbody/body", lamp)))
    assert lit.mass == pytest.approx(Robot.from_urdf(sound).mass + 1.5)


@pytest.mark.parametrize(
    "values", [{"range": "0 0"}, {"range": "1 -1", "limited": "false"}, {"range": None}]
)
def test_leg_joints_may_have_no_limits(sound, values):
    free = [at(f".//joint[@name='{side}_knee']", **values) for side in ("left", "right")]
    robot = Robot.from_urdf(edited(sound, together(*free)))
    assert robot.joint_names == Robot.from_urdf(sound).joint_names


def test_a_point_mass_moves_only_with_something_extended(sound):
    text = edited(sound, at(f"{SHIN}/inertial", fullinertia=None))
    with pytest.raises(RobotError, match="mass and inertia of moving bodies"):
        read_source(text)
    shell = "<body><inertial pos='0 0 0' mass='0.1' diaginertia='0.01 0.02 0.02'/></body>"
    found = knee_body(edited(text, added(SHIN, shell)))
    assert found.mass == pytest.approx(knee_body(sound).mass + 0.1)


@pytest.mark.parametrize("kind", ["hinge", "slide", "ball"])
def test_joints_beyond_the_most_are_refused(sound, kind):
    finger = "<body><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><joint type='{}'/></body>"
    there = read_source(sound).model().njoints - 2
    fill = [finger.format(kind)] * (MOST_JOINTS - there)
    assert read_source(edited(sound, added(SHIN, *fill))).problems == ()
    text = edited(sound, added(SHIN, *fill, finger.format(kind)))
    told = rf"^the MJCF file has {MOST_JOINTS + 1} joints that move; at most {MOST_JOINTS} can"
    with pytest.raises(RobotError, match=told):
        read_source(text)


def test_keyframes_are_postures_that_the_model_knows(sound):
    qpos = " ".join(["0 0 1 1 0 0 0", *map(str, np.arange(12) / 10.0)])
    text = edited(sound, added(".", f"<keyframe><key name='home' qpos='{qpos}'/></keyframe>"))
    for source in (read_source(text), read_source(read_source(text).text)):
        model = source.model()  # a reference configuration is part of it
        home = model.referenceConfigurations["home"]
        np.testing.assert_allclose(home[7:], np.arange(12) / 10.0)
        np.testing.assert_allclose(home[:7], [0, 0, 0, 0, 0, 0, 1])
        assert source.geometry(pin.GeometryType.COLLISION).ngeoms == 2


@pytest.mark.parametrize("default", ["<default><joint armature='0.03'/></default>", ""])
def test_the_outermost_class_may_be_called_without_a_name(sound, default):
    main = at(".//worldbody/body", childclass="main")
    text = edited(sound, together(main, added(".", *([default] if default else []))))
    source = read_source(text)
    np.testing.assert_allclose(source.model().armature[6:], 0.03 if default else 0.0)
    assert source.geometry(pin.GeometryType.COLLISION).ngeoms == 2
