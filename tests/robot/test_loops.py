"""Loops of bodies in the legs of an MJCF file: cranks and rods by MuJoCo, and what is refused."""

import re
from xml.etree import ElementTree as ET

import mujoco
import numpy as np
import pytest
from looped_bipeds import RODS, left_open, looped, parallel_ankles
from mjcf_edits import added, at, edited, together

from gaitopt.errors import RobotError
from gaitopt.gait.motor_space import driven_joints
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot

POSTURES = np.array([[0.0, 0.0], [0.2, -0.15], [-0.3, 0.1], [0.35, 0.05]])
"""Pitch and roll of the left ankle."""
SKEW = {"rods": "skew", "narrow": True}
WELDED = {"welded": True, "narrow": True}
WRITTEN = (
    {"rods": "universal"},
    {"sites": True},
    {"sites": True, "turned": 0.2},
    {"on_foot": True},
    {"on_foot": True, "rods": "universal", "sites": True},
)


def left_ankle(robot):
    """The joints of the left leg that motors turn."""
    return next(g for g in driven_joints(robot) if g.names[0].startswith("left"))


def angles(robot, group, posture):
    """All angles, with those of a group at some."""
    q = np.zeros((1, len(robot.joint_names)))
    q[:, group.rows] = posture
    return q


@pytest.mark.parametrize("how", WRITTEN, ids=str)
def test_however_a_loop_is_written_its_rods_are_the_same(how):
    robot = looped(**how)
    for linkage, as_written in zip(looped().linkages, robot.linkages, strict=True):
        np.testing.assert_allclose(as_written.rods, linkage.rods, atol=1e-12)
        assert as_written.torque == linkage.torque == (30.0, 30.0)
        turned = how.get("turned", 0.0)
        np.testing.assert_allclose(as_written.range, [[turned - 1.2, turned + 1.2]] * 2, atol=1e-12)


def test_rods_are_those_of_the_file():
    (linkage,) = looped().linkages
    assert linkage.joints == ("right_ankle_pitch", "right_ankle_roll")
    for rod, (centre, end, tip) in zip(linkage.rods, RODS.values(), strict=True):
        for point, given in zip((rod.crank_centre, rod.crank_end, rod.rod_end), (centre, end, tip),
                                strict=True):  # fmt: skip
            np.testing.assert_allclose(point, np.array(given) * (1.0, -1.0, 1.0), atol=1e-15)


@pytest.mark.parametrize("how", [{}, *WRITTEN, SKEW, WELDED], ids=str)
def test_a_gait_file_keeps_the_loops(how):
    robot = looped(**how)
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert again.linkages == robot.linkages
    np.testing.assert_array_equal(again.multibody.armature, robot.multibody.armature)
    told, kept = ([f for f in one.findings if f.topic == "loops"] for one in (robot, again))
    assert len(kept) == 3
    assert kept == told
    mujoco.MjModel.from_xml_string(robot.urdf)


class InMuJoCo:
    """The left ankle of a file in MuJoCo, its loops closed by the residual of MuJoCo itself."""

    def __init__(self, text):
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self.ankle = [self.dof(f"left_ankle_{axis}") for axis in ("pitch", "roll")]
        self.motors = [self.dof(f"left_{name}_motor") for name in RODS]
        pins = [j for j in map(self.model.joint, range(self.model.njnt)) if "_pin" in j.name]
        self.loose = [
            d
            for joint in pins
            if joint.name.startswith("left")
            for d in range(int(joint.dofadr[0]), int(joint.dofadr[0]) + len(joint.damping))
        ]
        self.others = [*self.motors, *self.loose]

    def dof(self, name):
        return int(self.model.joint(name).dofadr[0])

    def close(self, posture):
        """Put the ankle into a posture, the loops closed; return the Jacobian of its loops."""
        mujoco.mj_resetData(self.model, self.data)
        for axis, angle in zip(("pitch", "roll"), posture, strict=True):
            self.data.joint(f"left_ankle_{axis}").qpos[:] = angle
        for _ in range(30):
            J, gap = self.loops()
            step = np.zeros(self.model.nv)
            step[self.others] = -np.linalg.lstsq(J[:, self.others], gap, rcond=1e-9)[0]
            mujoco.mj_integratePos(self.model, self.data.qpos, step, 1.0)
        J, gap = self.loops()
        assert np.abs(gap).max() < 1e-12
        return J

    def loops(self):
        mujoco.mj_forward(self.model, self.data)
        held = self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        J, gap = self.data.efc_J.reshape(-1, self.model.nv)[held], self.data.efc_pos[held]
        left = np.abs(J[:, self.ankle]).max(axis=1) + np.abs(J[:, self.others]).max(axis=1) > 0.0
        return J[left], gap[left]

    def rates(self, J):
        """Rates of all joints of the loops per rate of the ankle's, first those of the motors."""
        return -np.linalg.lstsq(J[:, self.others], J[:, self.ankle], rcond=1e-9)[0]


@pytest.mark.parametrize("how", [{}, *WRITTEN, SKEW, WELDED], ids=str)
def test_angles_rates_and_torques_of_the_motors_are_those_of_mujoco(how):
    """Of its loops closed by Newton's method, and of forces of rods that leave no ball a torque."""
    robot, there = looped(**how), InMuJoCo(parallel_ankles(**how))
    group = left_ankle(robot)
    torque = np.zeros((1, len(robot.joint_names)))
    torque[:, group.rows] = 20.0, -7.0
    turned = how.get("turned", 0.0)
    for posture in POSTURES:
        J, q = there.close(posture), angles(robot, group, posture)
        motors = [there.data.joint(f"left_{name}_motor").qpos[0] for name in RODS]
        at = group.motors(q)
        np.testing.assert_allclose(at.angle[0], np.array(motors) + turned, atol=1e-9)
        np.testing.assert_allclose(at.jacobian[0] * group.signs, there.rates(J)[:2], atol=1e-9)
        tree = np.zeros(there.model.nv)
        tree[there.ankle] = torque[0, group.rows]
        passive = [*there.ankle, *there.loose]
        force = np.linalg.lstsq(J[:, passive].T, tree[passive], rcond=1e-9)[0]
        closed = tree - J.T @ force
        assert np.abs(closed[passive]).max() < 1e-9
        held = group.values(torque, np.zeros_like(torque), q)["torque"][0]
        np.testing.assert_allclose(held, closed[there.motors], atol=1e-8)


def test_motors_do_the_work_of_the_joints():
    robot = looped()
    rng = np.random.default_rng(5)
    torque, rate = rng.normal(scale=30.0, size=(2, 20, len(robot.joint_names)))
    q = rng.normal(scale=0.1, size=torque.shape)
    for group in driven_joints(robot):
        found = group.values(torque, rate, q)
        work = (torque * rate)[:, group.rows].sum(axis=1)
        np.testing.assert_allclose(found["power"].sum(axis=1), work, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("how", [{}, {"on_foot": True}], ids=str)
def test_cranks_rods_and_rotors_resist_as_in_mujoco(how):
    """The armature is what moves beside the ankle adds to MuJoCo's mass matrix of it."""
    robot, plain = looped(**how), Robot.from_urdf(
        parallel_ankles(**how), choices=ImportOptions(without=("loops",))
    )  # fmt: skip
    there = InMuJoCo(parallel_ankles(**how))
    J = there.close((0.0, 0.0))
    M = np.zeros((there.model.nv, there.model.nv))
    mujoco.mj_fullM(there.model, there.data, M)
    T = np.zeros((there.model.nv, 2))
    T[there.ankle], T[there.others] = np.eye(2), there.rates(J)
    added_there = T.T @ M @ T - M[np.ix_(there.ankle, there.ankle)]
    names = robot.multibody.joint_names
    rows = [names.index(f"left_ankle_{axis}") for axis in ("pitch", "roll")]
    more = (robot.multibody.armature - plain.multibody.armature)[rows]
    np.testing.assert_allclose(more, added_there.diagonal(), rtol=1e-9)
    assert more.min() > 2e-3


def test_limits_of_motors_can_be_given():
    limits = (LimitOverride("*_inner_motor", torque=12.0, speed=9.0),)
    robot = Robot.from_urdf(parallel_ankles(), choices=ImportOptions(limits=limits))
    (linkage,) = robot.linkages
    assert linkage.torque == (12.0, 30.0)
    assert linkage.speed == (9.0, None)


def test_nobody_asks_for_a_torque_limit_of_joints_that_motors_turn_from_elsewhere():
    told = [f for f in looped().findings if "no torque limit" in f.text]
    assert told == []
    assert any("ankle" in f.subject for f in left_open().findings if "no torque limit" in f.text)


def motors_at_the_ankles(root):
    for motor in root.findall("actuator/motor"):
        if "ner_motor" in motor.get("joint") or "outer" in motor.get("joint"):
            axis = "pitch" if "inner" in motor.get("joint") else "roll"
            motor.set("joint", f"{motor.get('joint').split('_')[0]}_ankle_{axis}")


def test_loops_that_only_follow_are_left_open():
    """Where the ankles have motors themselves, cranks and rods are pictures."""
    robot = Robot.from_urdf(edited(parallel_ankles(), motors_at_the_ankles))
    assert robot.linkages == ()
    rows = [k for k, name in enumerate(robot.joint_names) if "ankle" in name]
    np.testing.assert_array_equal(robot.limits.torque[rows], 30.0)


def without(path, *names):
    def edit(root):
        parent = root.find(path)
        for element in list(parent):
            if not names or any(name in str(element.attrib) for name in names):
                parent.remove(element)

    return edit


def motor(joint):
    return added("actuator", f"<motor joint='{joint}'/>")


REFUSED = {
    "rods on hinges": (
        lambda root: None, {"rods": "hinge"},
        "it holds 'right_ankle_roll', which opens it by 0.0283 m per rad",
    ),
    "more motors than joints": (
        motor("right_inner_pin"), {"rods": "universal"},
        "there are more motors .*'right_inner_pin'.* than joints of the leg",
    ),
    "fewer motors than joints": (
        without("actuator", "inner"), {},
        r"there are fewer motors \('right_outer_motor'\) than joints of the leg",
    ),
    "no motor at all": (without("actuator"), {}, "no joint in it has an actuator"),
    "one leg alone": (
        without("equality", "left"), {}, "the other leg has no loop through the same joints",
    ),
    "both legs": (
        added(
            "equality",
            "<connect body1='left_ankle_roll_body' body2='right_ankle_roll_body' anchor='0 0 0'/>",
        ),
        {}, "it joins both legs",
    ),
    "a motor that cannot push": (
        lambda root: [
            m.set("ctrlrange", "0 30")
            for m in root.findall("actuator/motor") if m.get("joint") == "right_inner_motor"
        ],
        {}, "its motor 'right_inner_motor' gives 0 N·m to one side",
    ),
    "a loop that is open": (
        at(".//site[@name='right_inner_end']", pos="0.5 0 0"), {"sites": True},
        r"it is open by \d+ mm where the robot stands; at most 0.1 mm are closed",
    ),
    "a dead point in the range": (
        lambda root: None, {"rods": "skew"},
        r"it opens or is at a dead point with 'right_ankle_pitch' at 0.8 rad, .* --limit left_",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_reduced_is_refused_with_advice_that_works(name):
    edit, how, message = REFUSED[name]
    text = edited(parallel_ankles(**how), edit)
    with pytest.raises(RobotError, match=rf"^line \d+: joint 'right_\w+': .*{message}") as e:
        Robot.from_urdf(text)
    assert "eave all loops of bodies open by --without loops: " in str(e.value)
    robot = Robot.from_urdf(text, choices=ImportOptions(without=("loops",)))
    assert len(robot.joint_names) == 12
    assert robot.linkages == ()


def test_loops_of_other_shapes_are_followed_by_newton():
    """The advice of the refusal works: a narrower range of both legs' joints."""
    text = parallel_ankles(rods="skew")
    with pytest.raises(RobotError, match="Either give narrower ranges") as refusal:
        Robot.from_urdf(text)
    advice = re.findall(r"--limit (\w+)\.range=(\S+)rad:([-.\d]+)rad", str(refusal.value))
    limits = tuple(LimitOverride(n, lower=float(a), upper=float(b)) for n, a, b in advice)
    assert len(limits) == 4
    robot = Robot.from_urdf(text, choices=ImportOptions(limits=limits))
    (linkage,) = robot.linkages
    assert linkage.rods == ()
    assert linkage.closure.lower[0] == limits[0].lower
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert again.linkages == robot.linkages


def test_unequal_ranges_of_cranks_are_told():
    """Mirrored ranges are equal, whichever way the axes of the cranks point."""

    def told(*limits, **of_joint):
        edit = at(".//joint[@name='left_inner_motor']", **of_joint)
        choices = ImportOptions(limits=limits)
        robot = Robot.from_urdf(edited(parallel_ankles(), edit), choices=choices)
        return [f.text for f in robot.findings if f.topic == "loops" and f.how == "warning"]

    assert told() == []
    (text,) = told(range="-0.5 1.2")
    other = "'left_inner_motor' of the other leg from -0.5 to 1.2 rad"
    assert f"turns from -1.2 to 1.2 rad, {other}" in text
    as_advised = LimitOverride("right_inner_motor", lower=-0.5, upper=1.2)
    assert told(as_advised, range="-0.5 1.2") == []


def test_a_nut_on_another_screw_in_one_leg_is_told():
    """However small its rate [m/rad] is beside those of cranks."""
    tilted = at(".//joint[@name='left_inner_motor']", axis="0.1 0 1")
    robot = Robot.from_urdf(edited(parallel_ankles(sliding=("inner",), narrow=True), tilted))
    (text,) = [f.text for f in robot.findings if f.topic == "loops" and f.how == "warning"]
    assert text.startswith("rates of the other leg's motors differ by 0.5 %; ")


def test_what_motors_of_loops_lose_is_told_as_left_out():
    """With the units of what moves, and not where it was left out by choice."""
    lossy = [
        at(f".//joint[@name='{side}_{name}_motor']", frictionloss="0.3", damping="0.2")
        for side in ("left", "right")
        for name in RODS
    ]
    text = edited(parallel_ankles(sliding=("inner",), narrow=True), together(*lossy))

    def told(*without):
        robot = Robot.from_urdf(text, choices=ImportOptions(without=without))
        topics = "damping", "joint friction", "springs"
        found = [f for f in robot.findings if f.topic in topics and f.how == "warning"]
        return {(f.subject, f.text.split(";")[0]) for f in found}

    nuts, cranks = (f"right_{name}_motor, left_{name}_motor" for name in ("inner", "outer"))
    friction = {(nuts, "Coulomb friction 0.3 N"), (cranks, "Coulomb friction 0.3 N·m")}
    damping = {
        (nuts, "force against the motion 0.2 N·s/m"),
        (cranks, "torque against the motion 0.2 N·m·s/rad"),
    }
    assert told() == friction | damping
    assert told("friction") == damping


def test_what_balls_of_rods_lose_is_told_as_left_out():
    """Of the text that a gait file keeps too."""
    lossy = [
        at(f".//joint[@name='{side}_{name}_pin']", frictionloss="0.3", damping="0.2", stiffness="4")
        for side in ("left", "right")
        for name in RODS
    ]
    robot = Robot.from_urdf(edited(parallel_ankles(), together(*lossy)))
    pins = "right_inner_pin, right_outer_pin, left_inner_pin, left_outer_pin"
    for one in (robot, Robot.from_urdf(robot.urdf, choices=robot.choices)):
        found = {
            f.text.split(";")[0]
            for f in one.findings
            if set(f.subject.split(", ")) == set(pins.split(", ")) and f.how == "warning"
        }
        assert found == {
            "Coulomb friction 0.3 N·m", "torque against the motion 0.2 N·m·s/rad",
            "spring 4 N·m/rad, at rest at 0 rad",
        }  # fmt: skip


def motor_at_the_roll(root):
    for motor in root.findall("actuator/motor"):
        if "inner" in motor.get("joint"):
            motor.set("joint", f"{motor.get('joint').split('_')[0]}_ankle_roll")
            motor.set("ctrlrange", "-25 25")


def test_a_motor_at_a_joint_and_one_at_a_crank():
    """The joint's own torque is no more that of its motor, which the crank's rod loads too."""
    text = edited(parallel_ankles(narrow=True), motor_at_the_roll)
    robot, there = Robot.from_urdf(text), InMuJoCo(text)
    (linkage,) = robot.linkages
    assert linkage.motors == ("right_ankle_roll", "right_outer_motor")
    assert linkage.torque == (25.0, 30.0)
    rows = [k for k, name in enumerate(robot.joint_names) if "ankle_roll" in name]
    assert np.isinf(robot.limits.torque[rows]).all()
    group = left_ankle(robot)
    for posture in POSTURES:
        J = there.close(posture)
        at = group.motors(angles(robot, group, posture))
        seen = group.signs[1] * at.jacobian[0, 0] * group.signs
        np.testing.assert_allclose(seen, [0.0, 1.0], atol=1e-12)
        np.testing.assert_allclose(at.jacobian[0, 1] * group.signs, there.rates(J)[1], atol=1e-9)


def test_every_element_of_the_text_is_one_that_mujoco_reads_the_same():
    """The normal form closes the same loops, by sites."""
    root = ET.fromstring(looped().urdf)
    assert len(root.findall("equality/connect")) == 4
    assert {m.get("joint") for m in root.findall("actuator/motor")} == {
        f"{side}_{name}_motor" for side in ("left", "right") for name in RODS
    }
    model = mujoco.MjModel.from_xml_string(looped().urdf)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    held = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert held.sum() == 12
    assert np.abs(data.efc_pos[held]).max() < 1e-15
