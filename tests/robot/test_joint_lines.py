"""Joints judged by their lines: where on its axis a file puts a joint's origin changes nothing."""

from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_arms, add_toes, edits
from places import CASES
from urdf_edits import edited_urdf, joint

from gaitopt.errors import RobotError
from gaitopt.model.capsules import leg_capsules
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.kinematic_tree import points_on_lines
from gaitopt.model.robot import Robot

PARTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
LEGS = [f"{side}_{part}" for side in ("left", "right") for part in PARTS]


def numbers(element, name):
    text = "0 0 0" if element is None else element.get(name, "0 0 0")
    return np.array([float(word) for word in text.split()])


def origin_of(element):
    found = element.find("origin")
    return found if found is not None else ET.SubElement(element, "origin")


def slide(root, name, length):
    """Move a joint's origin along its axis, all that hangs on it back by as much."""
    moved = joint(root, name)
    origin, child = origin_of(moved), moved.find("child").get("link")
    axis = numbers(moved.find("axis"), "xyz")
    step = length * axis / np.linalg.norm(axis)
    R = pin.rpy.rpyToMatrix(*numbers(origin, "rpy"))
    origin.set("xyz", " ".join(map(repr, (numbers(origin, "xyz") + R @ step).tolist())))
    link = next(e for e in root.findall("link") if e.get("name") == child)
    below = [e for e in root.findall("joint") if e.find("parent").get("link") == child]
    for part in (*link.findall("inertial"), *link.findall("visual"), *link.findall("collision")):
        below.append(part)
    for part in below:
        at = origin_of(part)
        at.set("xyz", " ".join(map(repr, (numbers(at, "xyz") - step).tolist())))


def slid(rng, names):
    def edit(root):
        for name in names:
            slide(root, name, rng.uniform(-0.2, 0.2))

    return edit


def facts(robot):
    """All that is found about a robot but for where its joints' frames are."""
    data = robot.model.createData()
    q = pin.neutral(robot.model)
    q[7:] = 0.1 * np.arange(12)
    v, a = np.r_[np.zeros(6), np.ones(12)], np.r_[np.zeros(6), np.arange(12.0)]
    effort = pin.rnea(robot.model, data, q, v, a)
    return np.concatenate(
        [
            effort,
            np.ravel(robot.legs.hips),
            np.ravel(robot.legs.ankles),
            robot.legs.straight,
            [robot.legs.reach, robot.legs.bound, *robot.legs.flexion, *robot.legs.knees],
            np.ravel(robot.sole.corners),
            np.ravel(robot.mirror),
        ]
    )


def said(robot, *topics):
    return [(f.subject, f.text) for f in robot.findings if not topics or f.topic in topics]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("extra", [[], [add_arms(6)], [add_toes()]])
def test_sliding_the_joints_along_their_axes_changes_nothing(seed, extra):
    rng = np.random.default_rng(seed)
    names = LEGS if seed else ["left_ankle_roll", "right_ankle_roll"]
    plain = Robot.from_urdf(edited_urdf(edits(*extra)))
    other = Robot.from_urdf(edited_urdf(edits(*extra, slid(rng, names))))
    assert other.joint_names == plain.joint_names
    assert said(other, "legs", "sole", "heading", "posture") == said(
        plain, "legs", "sole", "heading", "posture"
    )
    np.testing.assert_allclose(facts(other), facts(plain), atol=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_capsules_do_not_follow_the_origins(seed):
    rng = np.random.default_rng(seed)

    def bare(root):
        for link in root.findall("link"):
            if "foot" not in link.get("name") and "sole" not in link.get("name"):
                for tag in ("visual", "collision"):
                    for part in link.findall(tag):
                        link.remove(part)

    for shapes in ([], [bare]):
        plain = Robot.from_urdf(edited_urdf(edits(*shapes)))
        other = Robot.from_urdf(edited_urdf(edits(*shapes, slid(rng, LEGS))))
        for mine, its in zip(world_capsules(plain), world_capsules(other), strict=True):
            np.testing.assert_allclose(mine, its, atol=1e-6)


def world_capsules(robot):
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, pin.neutral(robot.model))
    return [
        np.r_[np.ravel([data.oMi[c.body + 1].act(e) for e in c.ends]), c.radius]
        for c in leg_capsules(robot)
    ]


@pytest.mark.parametrize(
    ("name", "height", "reach"),
    [
        ("ankle_offset_back", 0.88, 0.8),
        ("urdf_ankle_roll_origin_behind", 0.7, 0.62),
        ("massless_twin_legs", 0.88, 0.8),
        ("hip_roll_off_centre", 0.76 + 0.08, 0.76),
        ("urdf_continuous_hip_yaw", 0.7, 0.62),
        ("hips_6mm_apart", 0.88, 0.8),
    ],
)
def test_legs_that_were_taken_for_others(name, height, reach):
    robot = Robot.from_urdf(CASES / f"{name}.urdf")
    assert "knee" in robot.joint_names[robot.legs.knees[0]]
    assert not any("dummy" in joint for joint in robot.joint_names)
    # Hips off the line through knee and ankle make a straight leg a little longer.
    assert robot.legs.reach == pytest.approx(reach, rel=5e-3)
    assert robot.legs.height == pytest.approx(height, rel=5e-3)


@pytest.mark.parametrize("seed", range(8))
def test_branches_without_mass_are_no_legs(seed):
    """Twins of the legs that reach as low or lower, of no mass or of next to none."""
    rng = np.random.default_rng(seed)
    lower, mass = rng.choice([0.0, 0.01, 0.1]), rng.choice([0.0, 1e-4])
    count = int(rng.integers(3, 8))

    def twins(root):
        for side, sign in (("left", 1.0), ("right", -1.0)):
            parent, xyz = "torso", f"0 {0.06 * sign} 0"
            for k in range(count):
                name = f"{side}_rod_{k}"
                body = (
                    f"<inertial><mass value='{mass}'/><inertia ixx='1e-7' iyy='1e-7' izz='1e-7' "
                    "ixy='0' ixz='0' iyz='0'/></inertial>"
                    if mass
                    else ""
                )
                root.append(ET.fromstring(f"<link name='{name}'>{body}</link>"))
                root.append(
                    ET.fromstring(
                        f"<joint name='{name}_joint' type='revolute'><parent link='{parent}'/>"
                        f"<child link='{name}'/><origin xyz='{xyz}'/><axis xyz='0 1 0'/>"
                        "<limit effort='1' velocity='1' lower='-1' upper='1'/></joint>"
                    )
                )
                parent, xyz = name, f"0 0 {-(0.6 + lower) / (count - 1)}"

    robot = Robot.from_urdf(edited_urdf(twins))
    assert set(robot.joint_names) == set(LEGS)


@pytest.mark.parametrize("parts", [["hip_yaw"], ["ankle_roll"], list(PARTS)])
def test_continuous_joints_have_no_range_or_the_given_one(robot, parts):
    def edit(root):
        for name in LEGS:
            if name.split("_", 1)[1] in parts:
                joint(root, name).set("type", "continuous")

    free = Robot.from_urdf(edited_urdf(edit))
    rows = [k for k, name in enumerate(free.joint_names) if name.split("_", 1)[1] in parts]
    assert free.model.nq == robot.model.nq
    assert np.isinf(free.limits.lower[rows]).all()
    assert np.isinf(free.limits.upper[rows]).all()
    np.testing.assert_array_equal(free.limits.torque, robot.limits.torque)
    given = ImportOptions(limits=(LimitOverride("*", lower=-0.5, upper=0.5),))
    held = Robot.from_urdf(edited_urdf(edit), choices=given)
    np.testing.assert_array_equal(held.limits.lower[rows], -0.5)
    again = Robot.from_urdf(free.urdf, choices=free.choices)
    assert again.model == free.model


@pytest.mark.parametrize(("x", "z"), [(0.12, -0.09), (0.1, -0.11), (0.06, -0.1)])
def test_toes_are_trimmed_only_beyond_six_joints(robot, x, z):
    def placed(root):
        for side in ("left", "right"):
            joint(root, f"{side}_toe_0").find("origin").set("xyz", f"{x} 0 {z}")

    toed = Robot.from_urdf(edited_urdf(edits(add_toes(), placed)))
    assert toed.joint_names == robot.joint_names


def test_a_seventh_joint_that_is_no_toe_carries_the_foot():
    def below(root):
        for side in ("left", "right"):
            joint(root, f"{side}_toe_0").find("origin").set("xyz", "0 0 -0.2")

    with pytest.raises(RobotError, match="no collision box or visual shape of the feet shows"):
        Robot.from_urdf(edited_urdf(edits(add_toes(), below)))


def test_points_are_where_lines_meet():
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.2, 0.9], [0.4, 0.2, 0.5], [0.0, 0.7, 0.1]])
    axes = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    found = points_on_lines(points, axes, [0, 0, 1, 2])
    expected = [[0.0, 0.0, 0.0], [0.1, 0.2, 0.5], [0.1, 0.2, 0.5], [0.1, 0.7, 0.1]]
    np.testing.assert_allclose(found, expected, atol=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_the_knee_lies_beyond_hips_whose_axes_do_not_meet(seed):
    """Hip joints far from each other change the leg's length more than the knee does."""
    rng = np.random.default_rng(seed)
    steps = {name: rng.uniform(-0.25, 0.25, 3) for name in ("hip_roll", "hip_pitch")}

    def edit(root):
        for side, sign in (("left", 1.0), ("right", -1.0)):
            for name, (x, y, z) in steps.items():
                xyz = f"{0.2 * x} {sign * (0.02 + 0.3 * abs(y))} {-abs(z)}"
                origin_of(joint(root, f"{side}_{name}")).set("xyz", xyz)

    robot = Robot.from_urdf(edited_urdf(edit))
    assert [robot.joint_names[k] for k in robot.legs.knees] == ["right_knee", "left_knee"]
    assert robot.legs.straight == pytest.approx([0.0, 0.0], abs=0.2)
    assert robot.legs.reach < 0.75
