from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from reference_cases import biped
from urdf_edits import edited_urdf

from gaitopt.model.capsules import DEFAULT_RADIUS, bar_radius, leg_capsules
from gaitopt.model.import_options import PartChange
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.model.sole_detection import points_of

SOLE = Sole(toe=0.0, heel=-0.214, left=0.068, right=-0.068)


def remove(*tags):
    def edit(root):
        for link in root.iter("link"):
            for shape in [s for tag in tags for s in link.findall(tag)]:
                link.remove(shape)

    return edit


def lose_meshes(root):
    """Every shin is drawn by a mesh that is nowhere, every thigh by one and a box as well."""
    for name, keep in (("shin", 0), ("thigh", 1)):
        for side in ("left", "right"):
            link = next(e for e in root.iter("link") if e.get("name") == f"{side}_{name}")
            for visual in link.findall("visual")[keep:]:
                link.remove(visual)
            link.append(
                ET.fromstring(
                    "<visual><geometry><mesh filename='package://nowhere/it.stl'/></geometry>"
                    "</visual>"
                )
            )


def by_name(capsules):
    return {c.name: c for c in capsules}


def test_capsules_cover_what_the_urdf_shows(robot):
    """Shapes and capsules placed by the pelvis-rooted and by the sole-rooted model."""
    whole = pin.buildModelFromXML(robot.urdf, pin.JointModelFreeFlyer())
    capsules = by_name(leg_capsules(robot))
    assert len(capsules) == 12
    data, own = whole.createData(), robot.model.createData()
    pin.framesForwardKinematics(whole, data, pin.neutral(whole))
    pin.framesForwardKinematics(robot.model, own, pin.neutral(robot.model))
    foot = whole.getFrameId(robot.stance_sole)
    for kind, names in ((pin.GeometryType.VISUAL, None), (pin.GeometryType.COLLISION, "foot")):
        shapes = pin.buildGeomFromUrdfString(whole, robot.urdf, kind).geometryObjects
        for item in shapes:
            name = whole.frames[item.parentFrame].name
            capsule = capsules.get(name)
            if capsule is None or (names is None) == name.endswith("_foot"):
                continue
            at = data.oMf[foot].actInv(data.oMi[item.parentJoint] * item.placement)
            points = points_of(item.geometry, around=True).placed(at)
            ends = [own.oMi[capsule.body + 1].act(e) for e in capsule.ends]
            axis = ends[1] - ends[0]
            share = np.clip((points.centres - ends[0]) @ axis / max(axis @ axis, 1e-12), 0.0, 1.0)
            off = np.linalg.norm(points.centres - ends[0] - share[:, None] * axis, axis=1)
            assert (off + points.radii).max() < capsule.radius + 1e-6, name


def test_where_a_capsule_comes_from(robot):
    capsules = by_name(leg_capsules(robot))
    assert capsules["right_foot"].source == capsules["left_foot"].source == "collision"
    assert capsules["right_shin"].source == "visual"
    # thrice half of the diagonal of a sole box 13.6 cm wide and 4 cm high
    assert capsules["right_foot"].radius == pytest.approx(3.0 * np.hypot(0.068, 0.02))
    assert [c.body for c in leg_capsules(robot)] == [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12]


def test_capsules_are_tight_on_the_side_of_the_other_leg(robot):
    """The feet are 13.6 cm wide and the thighs at most 10; outwards they may be round."""
    capsules = by_name(leg_capsules(robot))
    for name, half in (("foot", 0.068), ("thigh", 0.05)):
        for side, inwards in (("right", 1.0), ("left", -1.0)):
            c = capsules[f"{side}_{name}"]
            reach = (c.ends @ [0.0, inwards, 0.0]).max() + c.radius
            assert half <= reach < half + 0.006


def test_bars_of_small_robots_leave_room_between_the_legs(robot):
    """As between NAO's, whose hips are 0.1 m apart: bars of 5 cm would touch as it stands."""
    assert abs(robot.legs.spacing) == pytest.approx(0.12)
    assert bar_radius(robot) == DEFAULT_RADIUS
    narrow = replace(robot, legs=replace(robot.legs, hips=robot.legs.hips / 2.0))
    assert bar_radius(narrow) == pytest.approx(0.42 * 0.06)


def test_capsules_are_those_of_the_proportions(robot):
    """The standing shin is drawn from the ankle below on: it moves along where it gets longer."""
    longer = robot.choices.over(proportions=(PartChange("shin", longer=0.1),))
    was, now = (
        by_name(leg_capsules(one))["right_shin"].ends
        for one in (robot, Robot.from_urdf(robot.urdf, choices=longer))
    )
    np.testing.assert_allclose(now - was, [[0.0, 0.0, 0.1]] * 2, atol=1e-12)


def test_a_robot_that_shows_nothing_has_capsules_between_its_joints(robot):
    bare = Robot.from_urdf(edited_urdf(remove("visual", "collision")), sole=SOLE)
    capsules = by_name(leg_capsules(bare))
    assert set(capsules) == {
        f"{s}_{n}" for s in ("left", "right") for n in ("foot", "shin", "thigh")
    }
    assert {c.source for c in capsules.values()} == {"joints"}
    assert {c.radius for c in capsules.values()} == {DEFAULT_RADIUS}
    for name, length in (("shin", 0.3), ("thigh", 0.3), ("foot", 0.214)):
        for side in ("left", "right"):
            ends = capsules[f"{side}_{name}"].ends
            assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(length)


def test_meshes_that_are_nowhere_are_done_without():
    whole, lost = biped(), Robot.from_urdf(edited_urdf(lose_meshes))
    before, after = by_name(leg_capsules(whole)), by_name(leg_capsules(lost))
    assert after["left_shin"].source == "joints"
    assert after["left_thigh"].source == "visual"
    assert after["left_thigh"].radius < before["left_thigh"].radius
    assert after["left_ankle"] == before["left_ankle"]


def test_other_limits_are_no_other_shape(robot):
    strong = replace(robot, limits=replace(robot.limits, torque=2.0 * robot.limits.torque))
    assert leg_capsules(strong) is leg_capsules(robot)
