"""What of a description's physics counts, what can be left out, and how it is told."""

import json

import numpy as np
import pytest
from places import CASES

from gaitopt.catalogue.entries import catalogue, description, entry_by_name
from gaitopt.cli.request import robot_source
from gaitopt.errors import InputError, RobotError
from gaitopt.gait.assemble import physics_record
from gaitopt.importers.physics import PARTS, PassiveJoint, Physics, PointMass
from gaitopt.importers.reader import read_source
from gaitopt.model.import_options import (
    ImportOptions,
    LimitOverride,
    choices_from_record,
    choices_from_toml,
    choices_record,
)
from gaitopt.model.importer import import_robot
from gaitopt.model.robot import Robot

URDF = CASES / "urdf_damping_friction.urdf"
LINKS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")


def mini(physics: Physics, choices: ImportOptions | None = None) -> Robot:
    """The small biped with some physics."""
    source = read_source(CASES / "base_mini.urdf")
    source.__dict__["physics"] = physics
    return Robot.from_reading(source, import_robot(source, choices or ImportOptions()))


def told(robot: Robot, topic: str) -> list[tuple[str, str]]:
    return [(f.how, f.text) for f in robot.findings if f.topic == topic]


def test_the_dynamics_of_a_urdf_count_and_are_told():
    robot = Robot.from_urdf(URDF)
    np.testing.assert_array_equal(robot.physics.passive.damping, np.full((12, 1), 5.0))
    np.testing.assert_array_equal(robot.physics.passive.friction, np.full(12, 3.0))
    assert robot.physics.carried is None
    [(how, text)] = told(robot, "damping")
    assert how == "found"
    assert "5 N·m·s/rad; counted (--without damping leaves it out)" in text
    [(how, text)] = told(robot, "joint friction")
    assert "3 N·m; counted" in text


def test_parts_can_be_left_out_each_by_itself():
    bare = Robot.from_urdf(URDF, choices=ImportOptions(without=("friction", "damping")))
    assert bare.physics.passive is None
    assert [how for how, _ in told(bare, "damping") + told(bare, "joint friction")] == ["given"] * 2
    half = Robot.from_urdf(URDF, choices=ImportOptions(without=["friction"]))
    assert not half.physics.passive.friction.any()
    assert half.physics.passive.damping.all()
    assert physics_record(half)["without"] == ["friction"]


def test_what_is_left_out_stays_so_in_files():
    choices = ImportOptions(without=("gravity", "friction", "friction"))
    assert choices.without == ("friction", "gravity")  # once each, in the usual order
    record = json.loads(json.dumps(choices_record(choices)))
    assert choices_from_record(record) == choices
    assert choices_from_toml('without = ["friction", "gravity"]\n').without == choices.without


@pytest.mark.parametrize("value", [("frction",), ("Friction",), (3,), "friction", ("",)])
def test_unknown_parts_are_refused(value):
    with pytest.raises(RobotError, match="without") as refused:
        ImportOptions(without=value)
    assert isinstance(value, str) or all(part in str(refused.value) for part in PARTS)


def test_left_and_right_walk_with_the_mean():
    joints = {"left_knee": PassiveJoint(damping=(2.0,)), "right_knee": PassiveJoint(damping=(3.0,))}
    robot = mini(Physics(joints))
    knees = list(robot.legs.knees)
    assert robot.physics.passive.damping[knees].ravel().tolist() == [2.5, 2.5]
    assert [how for how, _ in told(robot, "damping")] == ["found", "found", "warning"]
    joints["right_knee"] = PassiveJoint(damping=(2.1,))
    assert "changed" in [how for how, _ in told(mini(Physics(joints)), "damping")]


def test_damping_like_the_gain_of_a_servo_is_warned_of():
    joints = {f"{side}_knee": PassiveJoint(damping=(100.0,)) for side in ("left", "right")}
    warned = [text for how, text in told(mini(Physics(joints)), "damping") if how == "warning"]
    assert len(warned) == 1
    assert "at 1 rad/s" in warned[0]
    assert "--without damping" in warned[0]
    mild = {name: PassiveJoint(damping=(2.0,)) for name in joints}
    assert [how for how, _ in told(mini(Physics(mild)), "damping")] == ["found"]


def test_springs_of_mirrored_joints_pull_like_their_mean():
    """Stiffness 10 at rest at 0.4 and 30 at 0.2, one angle being the other's opposite."""
    joints = {
        "left_hip_roll": PassiveJoint(stiffness=(10.0,), rest=0.4),
        "right_hip_roll": PassiveJoint(stiffness=(30.0,), rest=-0.2),
    }
    passive, names = mini(Physics(joints)).physics.passive, ("left_hip_roll", "right_hip_roll")
    rows = [mini(Physics(joints)).joint_names.index(n) for n in names]
    assert passive.stiffness[rows].ravel().tolist() == [20.0, 20.0]
    np.testing.assert_allclose(passive.rest[rows], [0.25, -0.25])  # (10 · 0.4 + 30 · 0.2) / 40


def test_carried_weight_of_one_leg_is_shared():
    carried = {"left_knee_link": PointMass(2.0, (0.01, 0.02, -0.15))}
    robot = mini(Physics(compensated=carried))
    mass, moment = robot.physics.carried.mass, robot.physics.carried.moment
    body = robot.joint_names.index("left_knee") + 1
    assert (mass[body], mass[12 - body], mass.sum()) == (1.0, 1.0, 2.0)
    np.testing.assert_allclose(moment[body], [0.01, 0.02, -0.15])
    assert robot.weight == pytest.approx((robot.mass - 2.0) * 9.81)
    assert "warning" in [how for how, _ in told(robot, "gravity compensation")]


def test_gravity_of_the_description_counts():
    robot = mini(Physics(gravity=(0.0, 0.0, -1.62)))
    np.testing.assert_array_equal(robot.model.gravity.linear, [0.0, 0.0, -1.62])
    assert robot.weight == pytest.approx(robot.mass * 1.62)
    assert robot.legs.gravity == pytest.approx(1.62)
    [(how, text)] = told(robot, "gravity")
    assert (how, "1.62 m/s²" in text) == ("warning", True)
    earth = mini(Physics(gravity=(0.0, 0.0, -1.62)), ImportOptions(without=("gravity",)))
    np.testing.assert_array_equal(earth.model.gravity.linear, [0.0, 0.0, -9.81])
    [(how, text)] = told(earth, "gravity")
    assert (how, "left out, as chosen: 9.81" in text) == ("given", True)


def test_gravity_that_is_almost_down_is_straightened():
    angle = 0.005
    robot = mini(Physics(gravity=(9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))))
    np.testing.assert_allclose(robot.model.gravity.linear, [0.0, 0.0, -9.81])
    assert "0.29 degrees" in told(robot, "gravity")[0][1]


@pytest.mark.parametrize(
    ("gravity", "said"),
    [
        ((0.0, 0.0, 9.81), "180 degrees away"),
        ((9.81, 0.0, 0.0), "90 degrees away"),
        ((0.0, 0.2, -9.81), "1.17 degrees away"),
        ((0.0, 0.0, 0.0), "at least 0.01"),
        ((0.0, 0.0, -np.inf), "at least 0.01"),
        ((0.0, 0.0, np.nan), "at least 0.01"),
    ],
)
def test_gravity_that_no_walk_stands_is_refused_with_advice_that_works(gravity, said):
    with pytest.raises(RobotError, match=said) as refused:
        mini(Physics(gravity=gravity))
    assert "--without gravity" in str(refused.value)
    assert mini(Physics(gravity=gravity), ImportOptions(without=("gravity",))).weight > 0.0


@pytest.mark.parametrize(
    ("joint", "part"),
    [
        (PassiveJoint(friction=-1.0), "friction"),
        (PassiveJoint(friction=np.nan), "friction"),
        (PassiveJoint(damping=(-0.5,)), "damping"),
        (PassiveJoint(damping=(1.0, np.inf)), "damping"),
        (PassiveJoint(stiffness=(np.inf,)), "springs"),
        (PassiveJoint(stiffness=(1.0,), rest=np.nan), "springs"),
    ],
)
def test_joints_that_do_what_no_joint_does_are_refused(joint, part):
    physics = Physics({"left_knee": joint, "right_knee": joint})
    with pytest.raises(RobotError, match=f"joint '.*_knee'.*--without {part}"):
        mini(physics)
    assert mini(physics, ImportOptions(without=(part,))).physics.passive is None


def test_a_robot_that_hangs_is_refused():
    carried = {"base": PointMass(50.0, (0.0, 0.0, 0.2))}
    with pytest.raises(RobotError, match=r"50 kg .* --without gravity-compensation"):
        mini(Physics(compensated=carried))
    assert mini(Physics(compensated=carried), ImportOptions(without=("gravity-compensation",)))


def test_a_file_without_rotors_is_warned_about():
    [(how, text)] = told(Robot.from_urdf(CASES / "base_mini.urdf"), "armature")
    assert how == "warning"
    assert "--armature '*=0.01'" in text
    given = ImportOptions(limits=(LimitOverride("*", armature=0.01),))
    assert told(Robot.from_urdf(CASES / "base_mini.urdf", choices=given), "armature") == []
    left_out = ImportOptions(without=("armature",))
    assert told(Robot.from_urdf(CASES / "base_mini.urdf", choices=left_out), "armature") == []


def test_bipeds_made_by_gaitopt_are_not(robot):
    assert [how for how, _ in told(robot, "armature")] == ["found"]


def test_without_armature_leaves_out_all_of_it():
    choices = ImportOptions(limits=(LimitOverride("*", armature=0.01),), without=("armature",))
    robot = Robot.from_urdf(CASES / "base_mini.urdf", choices=choices)
    assert not robot.model.armature.any()
    assert robot.choices.limits == ()


def test_armature_of_the_command_line_counts_last():
    settings = {
        "urdf": URDF,
        "armature": {"*": 0.01, "*knee*": 0.02},
        "without": ["friction,damping"],
    }
    source, choices = robot_source(settings)
    robot = Robot.from_urdf(source, choices=choices)
    armature = dict(zip(robot.joint_names, robot.model.armature[6:], strict=True))
    assert (armature["left_knee"], armature["left_hip_yaw"]) == (0.02, 0.01)
    assert robot.physics.passive is None
    facts = physics_record(robot)["joints"]["left_knee"]
    assert facts == {"armature_kg_m2": 0.02, "armature_from": "chosen"}
    with pytest.raises(InputError, match="leave out one of the two"):
        robot_source({**settings, "without": ["armature"]})


def test_limits_of_a_user_do_not_lose_the_rotors_of_the_catalogue(tmp_path):
    (tmp_path / "mine.toml").write_text('[[limits]]\njoints = "*knee*"\ntorque = 50.0\n')
    _, choices = robot_source({"robot": "g1", "choices": tmp_path / "mine.toml"})
    given = [entry.joints for entry in choices.limits]
    assert given == [*entry_by_name("g1").rotors, "*knee*"]


@pytest.mark.parametrize("entry", [e for e in catalogue() if e.rotors], ids=lambda e: e.name)
def test_rotors_of_the_catalogue_have_a_source_and_can_be_left_out(entry):
    source, choices = description(entry)
    robot = Robot.from_urdf(source, choices=choices)
    assert (robot.model.armature[6:] > 0.0).all()
    assert {e.source for e in robot.choices.limits} == {entry.rotors_from} != {""}
    bare = Robot.from_urdf(source, choices=choices.over(without=("armature",)))
    assert not bare.model.armature.any()
