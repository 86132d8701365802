"""Models of URDFs beside those of Pinocchio's loader, MuJoCo and yourdfpy."""

import io

import mujoco
import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from example_robots import BIPEDS, example_robot, needs_example_robots
from places import CASES
from urdf_edits import edited_urdf, joint

from gaitopt import biped13, urdf_text
from gaitopt.importers.reader import read_source
from gaitopt.importers.urdf_document import describe
from gaitopt.importers.urdf_model import model_of_urdf
from gaitopt.importers.xml_document import parse_xml

OWN = {
    "biped13": urdf_text(biped13()),
    "base_mini": (CASES / "base_mini.urdf").read_text(encoding="utf-8"),
    "damped": (CASES / "urdf_damping_friction.urdf").read_text(encoding="utf-8"),
}
FIELDS = (
    "lowerPositionLimit", "upperPositionLimit", "effortLimit", "lowerEffortLimit", "velocityLimit",
    "lowerVelocityLimit", "damping", "friction", "upperDryFrictionLimit", "lowerDryFrictionLimit",
    "armature", "positionLimitMargin",
)  # fmt: skip


def assert_same_model(ours, loaded):
    """Names, order, placements, limits and frames agree; inertias to rounding."""
    assert list(ours.names) == list(loaded.names)
    assert [j.shortname() for j in ours.joints] == [j.shortname() for j in loaded.joints]
    assert list(ours.parents) == list(loaded.parents)
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(ours, field), getattr(loaded, field), err_msg=field)
    for one, other in zip(ours.jointPlacements, loaded.jointPlacements, strict=True):
        np.testing.assert_allclose(one.homogeneous, other.homogeneous, atol=1e-15)
    for one, other in zip(ours.inertias, loaded.inertias, strict=True):
        np.testing.assert_allclose(one.matrix(), other.matrix(), rtol=1e-12, atol=1e-14)
    for one, other in zip(ours.frames, loaded.frames, strict=True):
        assert (one.name, one.type, one.parentJoint, one.parentFrame) == (
            other.name, other.type, other.parentJoint, other.parentFrame,
        )  # fmt: skip
        np.testing.assert_allclose(
            one.placement.homogeneous, other.placement.homogeneous, atol=1e-14
        )


def built(text):
    return model_of_urdf(describe(parse_xml(text)))


@pytest.mark.parametrize("name", OWN)
def test_a_model_is_that_of_the_loader(name):
    loaded = pin.buildModelFromXML(OWN[name], pin.JointModelFreeFlyer())
    assert_same_model(built(OWN[name]), loaded)


@needs_example_robots
@pytest.mark.parametrize("path", [p for p in BIPEDS if "romeo_laas" not in p])
def test_models_of_bipeds_are_those_of_the_loader(path):
    text = example_robot(path).read_text(encoding="utf-8-sig")
    loaded = pin.buildModelFromXML(text, pin.JointModelFreeFlyer())
    assert_same_model(built(text), loaded)


@pytest.mark.parametrize("name", OWN)
def test_mujoco_reads_the_same_bodies(name, rng):
    """The root stands on the ground there, so that all bodies but it are compared."""
    text = OWN[name]
    compiler = "<mujoco><compiler fusestatic='false' discardvisual='true'/></mujoco></robot>"
    other = mujoco.MjModel.from_xml_string(text.replace("</robot>", compiler))
    data = mujoco.MjData(other)
    model = read_source(text).model()
    q = np.array(pin.neutral(model))
    for index in range(other.njnt):
        joint_id = model.getJointId(other.joint(index).name)
        angle = rng.uniform(-1.0, 1.0)
        q[model.joints[joint_id].idx_q] = data.qpos[other.jnt_qposadr[index]] = angle
        assert tuple(other.jnt_range[index]) == pytest.approx(
            (
                model.lowerPositionLimit[model.joints[joint_id].idx_q],
                model.upperPositionLimit[model.joints[joint_id].idx_q],
            )
        )
    mujoco.mj_kinematics(other, data)
    own = model.createData()
    pin.framesForwardKinematics(model, own, q)
    seen = 0
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY or frame.inertia.mass == 0.0 or frame.parentJoint < 2:
            continue
        body = other.body(frame.name)
        place = own.oMf[model.getFrameId(frame.name)]
        np.testing.assert_allclose(data.body(frame.name).xpos, place.translation, atol=1e-9)
        np.testing.assert_allclose(body.mass, frame.inertia.mass, rtol=1e-12)
        np.testing.assert_allclose(body.ipos, frame.inertia.lever, atol=1e-12)
        moments = np.linalg.eigvalsh(frame.inertia.inertia)
        np.testing.assert_allclose(np.sort(body.inertia), moments, rtol=1e-6, atol=1e-12)
        seen += 1
    assert seen == 12


@pytest.mark.parametrize("name", OWN)
def test_yourdfpy_reads_the_same_numbers(name):
    other = yourdfpy.URDF.load(
        io.BytesIO(OWN[name].encode()), load_meshes=False, load_collision_meshes=False,
        build_scene_graph=False, build_collision_scene_graph=False,
    ).robot  # fmt: skip
    robot = describe(parse_xml(OWN[name]))
    assert [each.name for each in other.links] == list(robot.links)
    for each in other.links:
        if each.inertial is not None:
            own = robot.links[each.name].inertial
            assert own.mass == each.inertial.mass
            np.testing.assert_array_equal(own.inertia, each.inertial.inertia)
            origin = np.eye(4) if each.inertial.origin is None else each.inertial.origin
            np.testing.assert_array_equal(own.pose.translation, origin[:3, 3])
    for each in other.joints:
        own = robot.joints[each.name]
        assert (own.kind, own.parent, own.child) == (each.type, each.parent, each.child)
        np.testing.assert_allclose(own.pose.rotation, each.origin[:3, :3], atol=1e-15)
        if each.type == "revolute":
            limit = each.limit
            found = (own.limits.lower, own.limits.upper, own.limits.effort, own.limits.velocity)
            assert found == (limit.lower, limit.upper, limit.effort, limit.velocity)


def test_a_continuous_joint_is_a_revolute_one_without_a_range():
    def edit(root):
        joint(root, "left_knee").set("type", "continuous")

    model = read_source(edited_urdf(edit)).model()
    knee = model.joints[model.getJointId("left_knee")]
    assert (knee.shortname(), knee.nq) == ("JointModelRY", 1)
    assert model.lowerPositionLimit[knee.idx_q] == -np.inf
    assert model.upperPositionLimit[knee.idx_q] == np.inf
    assert model.effortLimit[knee.idx_v] == 150.0


def test_an_infinite_range_is_one():
    def edit(root):
        joint(root, "left_knee").find("limit").attrib.update(lower="-inf", upper="inf")

    model = read_source(edited_urdf(edit)).model()
    row = model.joints[model.getJointId("left_knee")].idx_q
    assert (model.lowerPositionLimit[row], model.upperPositionLimit[row]) == (-np.inf, np.inf)


def test_damping_and_friction_are_told_as_they_are():
    physics = read_source(CASES / "urdf_damping_friction.urdf").physics
    assert len(physics.joints) == 12
    assert {(each.damping, each.friction) for each in physics.joints.values()} == {((5.0,), 3.0)}
    assert read_source(OWN["base_mini"]).physics.joints == {}
