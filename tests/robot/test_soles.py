"""Soles: given as a rectangle, or found from the shape of a foot."""

import re
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from example_robots import example_robot, needs_example_robots
from hypothesis import given, settings
from hypothesis import strategies as st
from mesh_files import TETRAHEDRON, write_stl
from places import CASES
from scipy.spatial import ConvexHull, QhullError
from urdf_edits import edited_urdf, link
from urdf_edits import joint as joint_named

from gaitopt import Robot
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.sole import Sole
from gaitopt.model.sole_detection import (
    convex_polygon,
    find_sole,
    foot_points,
    hull_faces,
    largest_rectangle,
)

FOOT = """<robot name='foot'>
<link name='base'/><link name='foot'>
 <inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>
 {shapes}
</link><link name='shoe'>{shoe}</link>
<joint name='ankle' type='revolute'><parent link='base'/><child link='foot'/><axis xyz='1 0 0'/>
 <limit effort='1' velocity='1' lower='-1' upper='1'/></joint>
<joint name='lace' type='{lace}'><parent link='foot'/><child link='shoe'/>
 <origin xyz='0.1 0.02 -0.07'/><axis xyz='0 1 0'/>
 <limit effort='1' velocity='1' lower='-1' upper='1'/></joint></robot>"""
UPRIGHT, ANKLE = np.eye(3), np.zeros(3)


def shape(geometry, xyz="0 0 0", rpy="0 0 0", tag="collision"):
    return f"<{tag}><origin xyz='{xyz}' rpy='{rpy}'/><geometry>{geometry}</geometry></{tag}>"


def box(size, xyz="0 0 0", rpy="0 0 0", tag="collision"):
    return shape(f"<box size='{size}'/>", xyz, rpy, tag)


def read(shapes, *, shoe="", lace="fixed", model=None):
    source = read_source(FOOT.format(shapes=shapes, shoe=shoe, lace=lace))
    model = source.model() if model is None else model(source.model())
    return foot_points(source, model, model.getJointId("ankle"))


def found(shapes, upright=UPRIGHT, ankle=ANKLE, **options):
    return find_sole(read(shapes, **options), upright, np.array(ankle))


def rectangle(sole):
    return sole.toe, sole.heel, sole.left, sole.right


def shapes_in_lost_files(root):
    for name in ("left_foot", "right_foot"):
        for tag in ("visual", "collision"):
            for part in link(root, name).findall(tag):
                geometry = part.find("geometry")
                geometry.clear()
                ElementTree.SubElement(geometry, "mesh", filename=f"package://lost/{name}.stl")


def without_frames(root):
    shapes_in_lost_files(root)
    for name in ("left_sole", "right_sole"):
        root.remove(link(root, name))
        root.remove(joint_named(root, f"{name}_joint"))


def test_both_ways_out_are_told_where_the_meshes_of_the_feet_are_lost():
    lost = "2 meshes cannot be used: 'package://lost/left_foot.stl' of link 'left_foot' was not"
    text = edited_urdf(shapes_in_lost_files)
    with pytest.raises(RobotError, match=r"soles \(frame 'right_sole'\);") as refused:
        Robot.from_urdf(text)
    for words in (lost, "--package-dir DIR", "package_dirs", "--choices", "sole=Sole(toe"):
        assert words in str(refused.value)
    given = ImportOptions(sole=Sole(0.0, -0.2, 0.05, -0.05))
    assert Robot.from_urdf(text, choices=given).sole.heel == -0.2
    with pytest.raises(RobotError, match=f"no sole frames; {lost}.*sole_drop"):
        Robot.from_urdf(edited_urdf(without_frames))


def test_no_directory_is_asked_for_where_no_mesh_is_lost():
    def bare(root):
        for name in ("left_foot", "right_foot"):
            for tag in ("visual", "collision"):
                for part in link(root, name).findall(tag):
                    link(root, name).remove(part)

    with pytest.raises(RobotError, match="shows their soles") as refused:
        Robot.from_urdf(edited_urdf(bare))
    assert "package" not in str(refused.value)
    assert "--sole" in str(refused.value)


def test_corners_start_at_the_toes_on_the_left():
    corners = Sole(toe=0.05, heel=-0.15, left=0.06, right=-0.04).corners
    expected = [[0.05, 0.06, 0], [0.05, -0.04, 0], [-0.15, 0.06, 0], [-0.15, -0.04, 0]]
    np.testing.assert_array_equal(corners, expected)


@pytest.mark.parametrize(
    ("toe", "heel", "left", "right"), [(-0.2, 0.1, 0.05, -0.05), (0.1, -0.2, -0.05, 0.05)]
)
def test_an_empty_rectangle_is_refused(toe, heel, left, right):
    with pytest.raises(RobotError, match=r"sole rectangle is empty.*toe must exceed heel"):
        Sole(toe, heel, left, right)


def test_the_lower_face_of_a_box():
    sole = found(box("0.2 0.1 0.04", "0.05 0.01 -0.05"), ankle=[0.03, -0.02, 0.0])
    # Below the ankle: the box reaches from -0.05 to 0.15, the ankle is at 0.03.
    assert sole.sole == Sole(toe=0.12, heel=-0.08, left=0.08, right=-0.02)
    np.testing.assert_allclose(sole.placement.translation, [0.03, -0.02, -0.07], atol=1e-15)
    assert sole.how == (
        "200.0 x 100.0 mm, 70.0 mm below the ankle, from collision geometry: box of 'foot'"
    )


def test_a_foot_whose_joint_is_turned():
    # Forward is -y of the joint, up is -z: as if it were hung upside down and turned.
    upright = np.array([[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    sole = found(box("0.1 0.2 0.04", "0.01 -0.06 0.05"), upright)
    assert rectangle(sole.sole) == pytest.approx((0.16, -0.04, 0.04, -0.06))
    np.testing.assert_allclose(sole.placement.translation, [0.0, 0.0, 0.07], atol=1e-15)
    np.testing.assert_array_equal(sole.placement.rotation, upright)
    corner = sole.placement.act(sole.sole.corners[0])
    np.testing.assert_allclose(corner, [-0.04, -0.16, 0.07], atol=1e-12)


def test_a_turned_box_is_measured_along_the_foot():
    sole = found(box("0.2 0.1 0.04", rpy="0 0 1.5707963267948966"))
    assert rectangle(sole.sole) == pytest.approx((0.05, -0.05, 0.1, -0.1))
    assert sole.how.endswith(
        "wider than long: see whether the mesh lies turned, or give the rectangle (sole)"
    )


def test_studs_carry_the_hull_of_their_lowest_points():
    studs = [(-0.05, 0.025), (-0.05, -0.025), (0.12, 0.03), (0.12, -0.03)]
    text = "".join(shape("<sphere radius='0.005'/>", f"{x} {y} -0.03") for x, y in studs)
    sole = found(text)
    assert sole.sole == Sole(toe=0.12, heel=-0.05, left=0.025, right=-0.025)
    np.testing.assert_allclose(sole.placement.translation, [0.0, 0.0, -0.035])
    assert "4 x sphere of 'foot'" in sole.how


def test_capsules_lie_on_their_sides():
    lying = "0 1.5707963267948966 0"
    capsule = "<capsule radius='0.02' length='0.18'/>"
    sole = found(
        shape(capsule, "0.03 0.04 -0.05", lying) + shape(capsule, "0.03 -0.04 -0.05", lying)
    )
    assert rectangle(sole.sole) == pytest.approx((0.12, -0.06, 0.04, -0.04))
    assert sole.placement.translation[2] == pytest.approx(-0.07)


def test_a_round_foot_holds_a_square():
    sole = found(shape("<cylinder radius='0.1' length='0.04'/>", "0.02 0 -0.03"))
    side = 0.1 * np.sqrt(0.5)
    assert rectangle(sole.sole) == pytest.approx((0.02 + side, 0.02 - side, side, -side), rel=1e-3)


def test_toes_and_heels_that_curve_up_do_not_count():
    flat = box("0.14 0.08 0.02", "0.01 0 -0.06")
    # Its rear lower edge touches the front lower edge of the flat part.
    c, s = np.cos(0.3), np.sin(0.3)
    x, z = 0.08 + 0.05 * c - 0.01 * s, -0.07 + 0.05 * s + 0.01 * c
    tilted = box("0.1 0.08 0.02", f"{x} 0 {z}", "0 -0.3 0")
    shorter = found(flat + tilted)
    assert rectangle(shorter.sole)[0] == pytest.approx(0.08)
    long = 0.14 + 0.1 * c  # from heel to raised toe
    assert f"the foot is {1e3 * long:.0f} mm long, rounded or raised" in shorter.how
    level = box("0.1 0.08 0.02", "0.12 0 -0.06")
    assert rectangle(found(flat + level).sole)[0] == pytest.approx(0.17)
    assert "mm long" not in found(flat + level).how


def test_links_fixed_to_the_foot_belong_to_it():
    shoe = box("0.3 0.12 0.02")
    fixed = found(box("0.1 0.1 0.02"), shoe=shoe)
    assert fixed.sole == Sole(toe=0.25, heel=-0.05, left=0.08, right=-0.04)
    np.testing.assert_allclose(fixed.placement.translation, [0.0, 0.0, -0.08])
    moving = found(box("0.1 0.1 0.02"), shoe=shoe, lace="revolute")
    assert moving.sole == Sole(toe=0.05, heel=-0.05, left=0.05, right=-0.05)


def test_links_of_locked_joints_belong_to_the_foot():
    def lock(model):
        return pin.buildReducedModel(model, [model.getJointId("lace")], pin.neutral(model))

    shoe = box("0.3 0.12 0.02")
    locked = found(box("0.1 0.1 0.02"), shoe=shoe, lace="revolute", model=lock)
    assert locked.sole == Sole(toe=0.25, heel=-0.05, left=0.08, right=-0.04)


def test_what_is_drawn_counts_where_nothing_touches():
    drawn = box("0.3 0.2 0.02", tag="visual")
    assert found(drawn).sole.toe == pytest.approx(0.15)
    assert "visual geometry" in found(drawn).how
    both = found(drawn + box("0.2 0.1 0.02"))
    assert (both.sole.toe, "collision geometry" in both.how) == (pytest.approx(0.1), True)
    assert read("") is None


def test_meshes_are_measured_at_their_corners(tmp_path):
    # A tetrahedron standing on the face z = 0, a right triangle of 0.3 m by 0.2 m.
    path = write_stl(tmp_path / "foot.stl", TETRAHEDRON)
    sole = found(shape(f"<mesh filename='file://{path}'/>", "0 0 -0.1"))
    # The largest rectangle in a right triangle has half of its legs as sides.
    assert rectangle(sole.sole) == pytest.approx((0.15, 0.0, 0.1, 0.0), abs=1e-6)
    assert sole.placement.translation[2] == pytest.approx(-0.1)


@pytest.mark.parametrize(
    "text",
    [
        shape("<sphere radius='0.05'/>"),
        box("0.2 0.1 0.04", rpy="0 0.3 0"),
        shape("<capsule radius='0.05' length='0.1'/>", rpy="1.5707963267948966 0 0"),
        box("0.02 0.02 0.02"),
    ],
    ids=["ball", "edge", "roller", "stud"],
)
def test_feet_without_a_flat_part_ask_for_a_sole(text):
    with pytest.raises(
        RobotError,
        match=r"within .* mm of its lowest point holds a rectangle of .* mm only, less than 5 cm²"
        r".* of 'foot'\); give the sole rectangle \(--sole.*sole_drop there\)",
    ):
        found(text)


@pytest.mark.parametrize(
    ("old", "foot"),
    [
        ("<box [^>]*>", "<sphere radius='0.02'/>"),
        ("<box [^>]*>", "<box size='0.01 0.01 0.02'/>"),
        ('xyz="0.03 0 -0.07"', 'xyz="0.03 0.3 -0.07"'),  # of both feet to the left
    ],
)
def test_feet_whose_shapes_show_no_sole_walk_on_one_that_is_given(old, foot):
    text = (CASES / "base_mini.urdf").read_text(encoding="utf-8")
    text = re.sub(old, foot, text)
    with pytest.raises(RobotError, match=r"give the sole rectangle .* and (the height|sole_drop)"):
        Robot.from_urdf(text)
    sole = Sole(0.13, -0.07, 0.03, -0.03)
    robot = Robot.from_urdf(text, choices=ImportOptions(sole=sole, sole_drop=0.09))
    assert robot.sole == sole
    assert robot.legs.ankles[0, 2] == pytest.approx(0.09)


def test_a_foot_on_its_edge_is_told_by_its_angle():
    with pytest.raises(
        RobotError, match=r"lower face is tilted by 17\.19 degrees, say which .* up"
    ):
        found(box("0.2 0.1 0.04", rpy="0 0.3 0"))
    with pytest.raises(RobotError) as caught:
        found(box("0.02 0.02 0.02"))
    assert "tilted" not in str(caught.value)


coordinate = st.floats(-0.2, 0.2).map(lambda v: round(v, 4))
clouds = st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=12).map(np.array)


def area_on_a_grid(cloud, count=60):
    """The largest area of a rectangle in the hull whose edges in x are on a grid."""
    try:
        hull = ConvexHull(cloud)
    except QhullError:
        return 0.0
    x = np.linspace(*cloud[:, 0][[cloud[:, 0].argmin(), cloud[:, 0].argmax()]], count)
    top, bottom = np.full(count, np.inf), np.full(count, -np.inf)
    for a, b, c in hull.equations:  # a x + b y + c <= 0 inside
        if b > 1e-12:
            top = np.minimum(top, -(a * x + c) / b)
        elif b < -1e-12:
            bottom = np.maximum(bottom, -(a * x + c) / b)
    high = np.minimum.outer(top, top) - np.maximum.outer(bottom, bottom)
    return float((np.abs(np.subtract.outer(x, x)) * high.clip(0.0)).max())


@settings(max_examples=80, deadline=None, derandomize=True)
@given(cloud=clouds)
def test_the_rectangle_lies_inside_and_is_the_largest(cloud):
    toe, heel, left, right = largest_rectangle(cloud)
    area, other = (toe - heel) * (left - right), area_on_a_grid(cloud)
    if area > 0.0:
        corners = np.array([[x, y] for x in (toe, heel) for y in (left, right)])
        angles = np.linspace(0.0, 2.0 * np.pi, 100)
        directions = np.column_stack([np.cos(angles), np.sin(angles)])
        sticks_out = (directions @ corners.T).max(axis=1) - (directions @ cloud.T).max(axis=1)
        assert sticks_out.max() < 1e-9
    if max(area, other) > 1e-5:
        assert other * (1.0 - 1e-9) <= area <= 1.3 * other


@settings(deadline=None, max_examples=100)
@given(st.integers(0, 10_000), st.integers(4, 16), st.booleans())
def test_hulls_of_few_points_are_those_of_qhull(seed, count, on_a_grid):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points = points.round() if on_a_grid else points  # many points in one plane then
    try:
        hull = ConvexHull(points)
    except QhullError:
        assert len(hull_faces(points)[1]) == 0
        return
    normals, areas = hull_faces(points)
    assert areas.sum() == pytest.approx(hull.area, rel=1e-9)
    np.testing.assert_allclose(areas @ normals, 0.0, atol=1e-9 * hull.area)  # it is closed
    for normal in normals:
        assert (hull.equations[:, :3] @ normal).max() == pytest.approx(1.0)


@settings(deadline=None, max_examples=100)
@given(st.integers(0, 10_000), st.integers(3, 40))
def test_polygons_are_those_of_qhull(seed, count):
    points = np.random.default_rng(seed).normal(size=(count, 2)).round(2)
    try:
        hull = ConvexHull(points)
    except QhullError:
        assert len(convex_polygon(points)) < 3
        return
    corners = convex_polygon(points)
    assert {tuple(one) for one in corners} <= {tuple(one) for one in points}
    x, y = corners.T
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))  # positive: counterclockwise
    assert area == pytest.approx(hull.volume, rel=1e-9)


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_biped_stands_on_its_box(side):
    source = read_source(urdf_text(biped13()))
    model = source.model()
    foot = foot_points(source, model, model.getJointId(f"{side}_ankle_roll"))
    sole = find_sole(foot, UPRIGHT, ANKLE)
    geometry = biped13().geometry
    # The toe edge is l1 = -0.137 m ahead of the ankle.
    assert sole.sole == Sole(toe=0.137, heel=-0.077, left=0.068, right=-0.068)
    np.testing.assert_array_equal(sole.placement.translation, [0.0, 0.0, -geometry.d1])


FEET = {
    "talos_data/robots/talos_reduced.urdf": (
        ("leg_right_6_joint", "leg_left_6_joint"), (0.0914, -0.1026, 0.0604, -0.0620, -0.1074)
    ),
    "talos_data/robots/talos_reduced_box.urdf": (
        ("leg_right_6_joint", "leg_left_6_joint"), (0.105, -0.105, 0.065, -0.065, -0.11)
    ),
    "g1_description/urdf/g1_29dof_rev_1_0.urdf": (
        ("right_ankle_roll_joint", "left_ankle_roll_joint"), (0.12, -0.05, 0.025, -0.025, -0.035)
    ),
    "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf": (
        ("RIGHT_ANKLE_X", "LEFT_ANKLE_X"), (0.1491, -0.0400, 0.0441, -0.0441, -0.072)
    ),
    "romeo_description/urdf/romeo_small.urdf": (
        ("RAnkleRoll", "LAnkleRoll"), (0.1079, -0.0735, 0.0407, -0.0359, -0.0675)
    ),
}  # fmt: skip


@needs_example_robots
@pytest.mark.parametrize("path", FEET)
def test_soles_of_others(path):
    joints, expected = FEET[path]
    source = read_source(example_robot(path))
    model = source.model()
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    for joint, sign in zip(joints, (-1.0, 1.0), strict=True):
        foot = model.getJointId(joint)
        sole = find_sole(foot_points(source, model, foot), data.oMi[foot].rotation.T, ANKLE)
        toe, heel, left, right, height = expected
        sides = (left, right) if sign > 0.0 else (-right, -left)
        assert rectangle(sole.sole) == pytest.approx((toe, heel, *sides), abs=2e-3)
        below = data.oMi[foot].rotation @ sole.placement.translation
        np.testing.assert_allclose(below, [0.0, 0.0, height], atol=2e-4)


@needs_example_robots
def test_a_foot_of_icub_faces_backwards_in_its_joint():
    source = read_source(example_robot("icub_description/robots/icub_reduced.urdf"))
    model = source.model()
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    for side in "lr":
        foot = model.getJointId(f"{side}_ankle_roll")
        # Forward is -x of the root link.
        upright = data.oMi[foot].rotation.T @ np.diag([-1.0, -1.0, 1.0])
        sole = find_sole(foot_points(source, model, foot), upright, ANKLE)
        frame = model.frames[model.getFrameId(f"{side}_sole", pin.FrameType.BODY)]
        drop = sole.placement.actInv(frame.placement.translation)[2]
        assert abs(drop) < 2e-4, "the file's sole frame lies in the plane found"
