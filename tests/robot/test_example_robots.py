"""Humanoids of other makers, read from their files as they are."""

import json

import numpy as np
import pinocchio as pin
import pytest
from example_robots import example_robot, needs_example_robots
from numerics import relative_error
from pelvis_rooted import reading_of, rooted_both_ways

from gaitopt.errors import RobotError
from gaitopt.model.capsules import leg_capsules
from gaitopt.model.import_options import ImportOptions, choices_from_record, choices_record
from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole
from gaitopt.model.symmetry import exchange_error, mirror_placement

pytestmark = needs_example_robots

TALOS = "talos_data/robots/talos_reduced.urdf"
G1 = "g1_description/urdf/g1_29dof_rev_1_0.urdf"
ALEXANDER = "alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf"
ICUB = "icub_description/robots/icub_reduced.urdf"
ROMEO = "romeo_description/urdf/romeo_small.urdf"
SIMPLE = "simple_humanoid_description/urdf/simple_humanoid.urdf"
HUMAN = "human_description/robots/human.urdf"

ROBOTS = {
    # mass [kg], forward, pelvis above the sole [m], first and last joint, height of ankle [m]
    TALOS: (90.272, "x", 0.812, "leg_right_6_joint", "leg_left_6_joint", 0.107),
    G1: (33.341, "x", 0.689, "right_ankle_roll_joint", "left_ankle_roll_joint", 0.0526),
    ALEXANDER: (49.081, "x", 0.814, "RIGHT_ANKLE_X", "LEFT_ANKLE_X", 0.084),
    ICUB: (28.347, "-x", 0.478, "r_ankle_roll", "l_ankle_roll", 0.041),
    ROMEO: (40.529, "x", 0.677, "RAnkleRoll", "LAnkleRoll", 0.0675),
}
names = pytest.mark.parametrize("name", ROBOTS)

_READ: dict[str, Robot] = {}


def robot_of(name: str) -> Robot:
    if name not in _READ:
        _READ[name] = Robot.from_urdf(example_robot(name))
    return _READ[name]


@names
def test_it_is_read_as_it_is(name):
    robot = robot_of(name)
    mass, forward, height, first, last, ankle = ROBOTS[name]
    assert robot.mass == pytest.approx(mass, abs=1e-3)
    assert (robot.choices.forward, robot.choices.up) == (forward, "z")
    assert (robot.joint_names[0], robot.joint_names[-1]) == (first, last)
    assert robot.legs.height == pytest.approx(height, abs=1e-3)
    np.testing.assert_allclose(robot.legs.ankles[:, 2], ankle, atol=1e-3)
    assert robot.sole.left == -robot.sole.right


@names
def test_its_soles_are_flat_beside_each_other_and_below_the_hips(name):
    robot = robot_of(name)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, pin.neutral(robot.model))
    swing, pelvis = data.oMf[robot.swing_frame], data.oMf[robot.pelvis_frame]
    np.testing.assert_allclose(swing.rotation, np.eye(3), atol=5e-5)
    np.testing.assert_allclose(pelvis.rotation, np.eye(3), atol=5e-5)
    assert swing.translation[1] > 0.1
    np.testing.assert_allclose(swing.translation[[0, 2]], 0.0, atol=5e-5)
    assert pelvis.translation[1] == pytest.approx(swing.translation[1] / 2.0, abs=1e-5)


@names
def test_mirrored_postures_are_mirror_images(name):
    robot = robot_of(name)
    np.testing.assert_array_equal(robot.mirror @ robot.mirror, np.eye(12))
    assert exchange_error(robot.model, robot.mirror, robot.stance_sole, robot.swing_sole) < 1e-12
    model, data = robot.model, robot.model.createData()
    q = pin.neutral(model)
    q[7:] = np.random.default_rng(4).uniform(-0.5, 0.5, 12)
    pin.framesForwardKinematics(model, data, q)
    seen = data.oMf[robot.swing_frame].actInv(data.oMf[robot.pelvis_frame])
    q[7:] = robot.mirror @ q[7:]
    pin.framesForwardKinematics(model, data, q)
    there = data.oMf[robot.pelvis_frame]
    assert relative_error(mirror_placement(seen).homogeneous, there.homogeneous) < 1e-12


@names
def test_the_rerooted_model_is_the_robot_of_the_file(name):
    for seed in range(3):
        model, other = rooted_both_ways(reading_of(example_robot(name)), seed)
        state = other.state(model)
        assert relative_error(pin.rnea(model, model.createData(), *state), other.effort()) < 1e-10
        D = pin.crba(model, model.createData(), state[0])
        assert relative_error(D, other.mass_matrix()) < 1e-10
        data = model.createData()
        pin.framesForwardKinematics(model, data, state[0])
        for frame, placement in other.placements().items():
            found = data.oMf[model.getFrameId(frame)].homogeneous
            assert relative_error(found, placement) < 1e-10


@names
def test_resolved_choices_give_the_same_robot_without_its_meshes(name):
    robot = robot_of(name)
    record = json.loads(json.dumps(choices_record(robot.choices), allow_nan=False))
    again = Robot.from_urdf(robot.urdf, choices=choices_from_record(record))
    assert again.model == robot.model
    assert again.choices == robot.choices
    assert (again.sole, again.joint_names) == (robot.sole, robot.joint_names)
    np.testing.assert_array_equal(again.limits.speed, robot.limits.speed)
    np.testing.assert_array_equal(again.legs.hips, robot.legs.hips)


@names
def test_hip_and_ankle_are_never_further_apart_than_the_bound(name, rng):
    robot = robot_of(name)
    legs, model, data = robot.legs, robot.model, robot.model.createData()
    assert legs.reach <= legs.bound
    low, high = (np.clip(b, -np.pi, np.pi) for b in (robot.limits.lower, robot.limits.upper))
    for _ in range(200):
        q = pin.neutral(model)
        q[7:] = rng.uniform(low, high)
        q[[7 + k for k in legs.knees]] = legs.straight
        pin.framesForwardKinematics(model, data, q)
        hip = data.oMf[robot.pelvis_frame].act(legs.hips[1])
        ankle = data.oMf[robot.swing_frame].act(legs.ankles[1])
        assert np.linalg.norm(hip - ankle) <= legs.bound + 1e-9


@names
def test_pitching_the_hip_keeps_the_length_of_the_leg(name):
    robot = robot_of(name)
    legs, model, data = robot.legs, robot.model, robot.model.createData()
    pitch = 6 + int(np.abs(_swing_hip_axes(robot)[:, 1]).argmax())
    q = pin.neutral(model)
    q[7 + legs.knees[1]] = legs.straight[1]
    q[7 + pitch] = 0.4 * robot.legs.flexion[1]
    pin.framesForwardKinematics(model, data, q)
    hip = data.oMf[robot.pelvis_frame].act(legs.hips[1])
    ankle = data.oMf[robot.swing_frame].act(legs.ankles[1])
    assert np.linalg.norm(hip - ankle) == pytest.approx(legs.reach, rel=1e-9)


def _swing_hip_axes(robot: Robot) -> np.ndarray:
    data = robot.model.createData()
    J = pin.computeJointJacobians(robot.model, data, pin.neutral(robot.model))
    return J[3:, 12:15].T


def test_g1_is_described_to_a_person():
    texts = [f.text for f in robot_of(G1).findings if f.topic in ("heading", "sole", "posture")]
    assert "forward is +x, left +y, up +z of the root link: the feet reach 120 mm ahead" in texts[0]
    assert "17 joints that are not the legs', locked at 0: waist_yaw_joint" in texts[1]
    assert "120.0 mm forward, 50.0 mm back, 25.0 mm left" in texts[2]
    assert "4 x sphere of 'right_ankle_roll_link'" in texts[2]


def test_icub_lacks_inertias_and_speed_limits():
    warnings = [f.text for f in robot_of(ICUB).findings if f.how == "warning"]
    assert any("links a mass but no inertia" in w for w in warnings)
    assert any("speed limit 100 rad/s is a placeholder" in w for w in warnings)
    assert np.isinf(robot_of(ICUB).limits.speed).all()


def test_icub_stands_on_soles_longer_than_wide_though_its_meshes_lie():
    robot = robot_of(ICUB)
    assert not any("wider than they are long" in f.text for f in robot.findings)
    sole = robot.sole
    # What a person reads off the upright mesh, in the file's frame 18 mm behind the new one.
    found = (sole.toe + 0.018, sole.heel + 0.018, sole.left, sole.right)
    assert found == pytest.approx((0.099, -0.011, 0.024, -0.024), abs=2e-3)
    assert all(c.source == "collision" for c in leg_capsules(robot))


def test_a_pose_of_the_srdf_locks_the_arms_and_rotors_make_armature():
    choices = ImportOptions(srdf="../srdf/talos.srdf", posture="half_sitting")
    posed = Robot.from_urdf(example_robot(TALOS), choices=choices)
    upright = robot_of(TALOS)
    assert posed.mass == pytest.approx(upright.mass, rel=1e-12)
    assert posed.legs.height == pytest.approx(upright.legs.height, abs=1e-9)
    assert posed.stance_sole == "right_sole_link"
    trunk, other = (r.model.inertias[r.model.frames[r.pelvis_frame].parentJoint] for r in
                    (posed, upright))  # fmt: skip
    assert np.linalg.norm(trunk.lever - other.lever) > 0.005
    again = Robot.from_urdf(posed.urdf, choices=posed.choices)
    assert again.model == posed.model
    rotors = Robot.from_urdf(
        example_robot(TALOS), choices=ImportOptions(srdf="../srdf/talos.srdf", rotors=True)
    )
    # 1e-5 kg·m² behind gears of 100.
    np.testing.assert_allclose(rotors.model.armature[6:], 0.1)
    assert not upright.model.armature.any()


@pytest.mark.parametrize(
    ("choices", "message"),
    [
        (ImportOptions(posture="sitting"), "no SRDF is given"),
        (ImportOptions(srdf="none.srdf", posture="a"), r"cannot read the SRDF '.*none.srdf'"),
        (
            ImportOptions(srdf="../srdf/talos.srdf", posture="a"),
            "no pose 'a'; it has: half_sitting",
        ),
        (ImportOptions(srdf="<robot/>", rotors=True), "the SRDF has no <rotor_params>"),
        (ImportOptions(srdf="<robot", rotors=True), "the SRDF is not well-formed XML"),
        (
            ImportOptions(posture={"torso_3_joint": 1.0}),
            "no joint 'torso_3_joint'; did you mean 'torso_",
        ),
        (
            ImportOptions(posture={"arm_left_1_joint": -1.0}),
            r"allowed is 2 % .* by its effect: trunk: 0 g in mass, 19\.5 mm in centre of mass",
        ),
    ],
)
def test_postures_that_cannot_be_used_are_named(choices, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(example_robot(TALOS), choices=choices)


def test_limits_on_the_wrong_side_are_refused_and_can_be_settled():
    with pytest.raises(RobotError) as refused:
        Robot.from_urdf(example_robot(SIMPLE))
    for fact in (
        "2 faults",
        "the file is broken",
        "'RLEG_KNEE' and 'LLEG_KNEE', 0 to 2.618 rad and -2.095 to 0.7 rad (mirrored)",
        "the torque limits of 'RLEG_HIP_P' and 'LLEG_HIP_P', 160 and 100 N·m",
        "the speed limits of 'RLEG_ANKLE_P' and 'LLEG_ANKLE_P', 5.8 and 7 rad/s",
        "the file has no sole frames",
    ):
        assert fact in str(refused.value)
    given = ImportOptions(
        unequal_limits="right", sole=Sole(0.12, -0.08, 0.05, -0.05), sole_drop=0.09, forward="x"
    )
    robot = Robot.from_urdf(example_robot(SIMPLE), choices=given)
    assert robot.mass == pytest.approx(130.8, abs=1e-6)
    assert robot.limits.torque[list(robot.legs.knees)].tolist() == [300.0, 300.0]
    np.testing.assert_allclose(robot.legs.ankles[:, 2], 0.09, atol=1e-12)


def test_a_robot_whose_y_axis_is_up_is_read():
    given = ImportOptions(
        unequal_limits="tighter",
        asymmetry=0.25,
        sole=Sole(0.17, -0.06, 0.04, -0.04),
        sole_drop=0.09,
    )
    robot = Robot.from_urdf(example_robot(HUMAN), choices=given)
    assert (robot.choices.forward, robot.choices.up) == ("x", "y")
    assert (robot.joint_names[0], robot.joint_names[-1]) == ("right_ankle_X", "left_ankle_X")
    assert robot.legs.reach == pytest.approx(0.439 + 0.44, abs=1e-3)


def test_legs_of_three_joints_are_refused():
    with pytest.raises(RobotError, match=r"has 3 joints of its own; .*: FL_HAA, FL_HFE, FL_KFE"):
        Robot.from_urdf(example_robot("bolt_description/robots/bolt.urdf"))


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("anymal_b_simple_description/robots/anymal.urdf", "four chains of 3 joints each .*SHANK'"),
        ("hyq_description/robots/hyq_no_sensors.urdf", "four chains of 3 joints each .*lowerleg'"),
        ("solo_description/robots/solo12.urdf", "four chains of 3 joints each .*LOWER_LEG'"),
        ("centauro_description/urdf/centauro.urdf", "four chains of 6 joints each .*'wheel_4'"),
        ("baxter_description/urdf/baxter.urdf", "five chains, .* as fingers do"),
        (
            "tiago_description/robots/tiago.urdf",
            "11 chains, .*_link', share 8 joints, as fingers do",
        ),
        ("tiago_pro_description/robots/tiago_pro.urdf", "13 chains, .* as fingers do"),
        ("alex_description/urdf/alex_psyonic_hands.urdf", "11 chains, .* as fingers do"),
        ("ur_description/urdf/ur5_robot.urdf", "one chain of 6 joints, which ends in 'wrist_3"),
    ],
)
def test_robots_without_two_legs_are_told_what_they_have(path, message):
    with pytest.raises(RobotError, match=f"^no two legs were found: {message}"):
        Robot.from_urdf(example_robot(path))


def test_an_arm_is_not_called_a_leg():
    with pytest.raises(RobotError, match=r"^the chain that ends in 'LeftGripperYawLink' cannot"):
        Robot.from_urdf(example_robot("alex_description/urdf/alex_nub_hands.urdf"))
