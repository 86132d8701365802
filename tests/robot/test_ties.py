"""Joints that follow others: read from both formats, reflected, mirrored, refused with advice."""

import re

import mujoco
import numpy as np
import pytest
from example_robots import example_robot, needs_example_robots
from humanoids import add_arms, add_joint, add_link, edits
from mjcf_edits import added, at, edited, together
from synthetic_bipeds import SIX, biped_urdf
from tied_bipeds import bent, equality, mimic, nao_like, plain_mjcf, read, tied
from urdf_edits import edited_urdf, joint, link, set_limit

from gaitopt.errors import RobotError
from gaitopt.importers.physics import Tie, tied_to, ties_to_masters
from gaitopt.importers.reader import read_source
from gaitopt.model.coupling import couple
from gaitopt.model.import_options import SIDES, ImportOptions, LimitOverride, Payload
from gaitopt.model.joint_limits import JointLimits
from gaitopt.model.robot import Robot


def both(name, master, **numbers):
    """An edit that makes a joint of either leg of the biped follow another of the same leg."""

    def edit(root):
        for side in ("left", "right"):
            mimic(root, f"{side}_{name}", f"{side}_{master}", **numbers)

    return edit


def said(robot, topic):
    return [f"{f.how}: {f.subject} {f.text}" for f in robot.findings if f.topic == topic]


def test_one_motor_turns_both_hips_of_nao():
    """It mirrors itself: both hips turn the same way, and so does their image."""
    robot = tied("NAO's hips")
    (row,) = (k for k, n in enumerate(robot.joint_names) if "yaw_pitch" in n)
    assert robot.joint_names[row] == "left_hip_yaw_pitch"
    assert len(robot.joint_names) == 11 == robot.tree.size - 1
    assert robot.mirror[row].tolist() == [float(k == row) for k in range(11)]
    np.testing.assert_array_equal(robot.mirror @ robot.mirror, np.eye(11))
    (told,) = said(robot, "ties")
    assert told.startswith(
        "found: right_hip_yaw_pitch follows 'left_hip_yaw_pitch': its angle is 1"
    )
    assert robot.legs.knees == (2, 9)  # of all twelve joints
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert again.joint_names == robot.joint_names
    assert again.model == robot.model


def test_limits_are_those_of_the_joint_that_is_followed():
    """The elbow turns 1.5 times as far as its shoulder, from -0.3 rad on the left."""
    robot = tied("elbows and shanks")
    k = robot.joint_names.index("left_shoulder_pitch")
    limits = robot.limits
    assert limits.speed[k] == pytest.approx(12.0 / 1.5)
    assert limits.range(k) == pytest.approx(((-2.5 + 0.3) / 1.5, (2.5 + 0.3) / 1.5))
    assert limits.torque[k] == 150.0
    other = robot.joint_names.index("right_shoulder_pitch")
    assert limits.range(other) == pytest.approx(tuple(-end for end in limits.range(k)[::-1]))
    ankle = robot.joint_names.index("left_ankle_roll")
    assert limits.speed[ankle] == 12.0  # the shank turns a quarter as fast
    elbow = robot.coupling.names.index("left_elbow")
    assert robot.coupling.reach(elbow, limits) == pytest.approx((-2.5, 2.5))


@pytest.mark.parametrize("idle", [{"effort": 0.0}, {"effort": 0.0, "velocity": 0.0}])
def test_joints_that_follow_need_no_motor(idle):
    """They have torque and speed of the motor that turns them, and nobody asks for other ones."""

    def edit(root):
        for name in ("right_hip_yaw_pitch", "left_hip_roll", "right_hip_roll"):
            set_limit(name, **idle)(root)
        for side in ("left", "right"):
            mimic(root, f"{side}_hip_roll", f"{side}_ankle_roll", multiplier=-0.5)

    robot, plain = read(edited(nao_like(), edit)), tied("NAO's hips")
    assert said(robot, "limits") == said(robot, "file") == []
    rows = [plain.joint_names.index(name) for name in robot.joint_names]
    for field in ("torque", "speed"):
        of_both = getattr(robot.limits, field), getattr(plain.limits, field)[rows]
        np.testing.assert_array_equal(*of_both)


def test_joints_beside_a_leg_that_follow_need_a_range():
    """None in the file is one of no width; choices may give it, and then nobody asks for one."""

    def edit(root):
        for side, axis in (("left", "0 1 0"), ("right", "0 -1 0")):
            add_link(root, f"{side}_rod", 0.2)
            ends = f"{side}_hip_pitch_link", f"{side}_rod"
            add_joint(root, f"{side}_rod", *ends, xyz="0 0 0", axis=axis)
            mimic(root, f"{side}_rod", f"{side}_knee", multiplier=-0.5)
            joint(root, f"{side}_rod").remove(joint(root, f"{side}_rod").find("limit"))

    text = edited(biped_urdf(SIX), edit)
    with pytest.raises(RobotError, match=r"no range in common.*give other ranges \(\[\[limits\]\]"):
        read(text)
    whole = (LimitOverride("*_rod", torque=9.0, speed=9.0, lower=-3.0, upper=3.0),)
    assert said(read(text, limits=whole), "file") == []


def test_ties_that_bend_the_legs_unequally_are_told_first():
    def yaws(root):
        mimic(root, "right_hip_yaw", "left_hip_yaw", multiplier=-1.0, offset=0.1)

    with pytest.raises(
        RobotError, match=r"\(1\) the ties of joints are not mirror images: .*\(2\)"
    ):
        Robot.from_urdf(edited_urdf(yaws))


def test_one_actuator_turns_both_hips():
    def cross(root):
        added(
            ".", f"<equality>{equality('right_hip_yaw', 'left_hip_yaw', (0.0, -1.0))}</equality>"
        )(root)
        actuators = root.find("actuator")
        actuators.remove(actuators.find("motor[@joint='right_hip_yaw']"))

    robot, plain = Robot.from_urdf(edited(plain_mjcf(), cross)), Robot.from_urdf(plain_mjcf())
    rows = [plain.joint_names.index(name) for name in robot.joint_names]
    assert len(rows) == 11
    np.testing.assert_array_equal(robot.limits.torque, plain.limits.torque[rows])


def test_a_tie_through_others_is_that_to_the_first():
    ties = {"a": Tie("a", "b", 2.0, 0.1), "b": Tie("b", "c", -3.0, 0.2)}
    found, faults = ties_to_masters(ties)
    assert faults == {}
    assert found["a"] == Tie("a", "c", -6.0, pytest.approx(0.5))
    assert tied_to(found, ["b"]) == {"c": "leads", "a": "follows"}
    rolls = both("ankle_roll", "hip_roll", multiplier=-1.0)
    knees = both("knee", "ankle_pitch", multiplier=-2.0)
    robot = Robot.from_urdf(edited_urdf(edits(rolls, knees)))
    assert len(robot.joint_names) == 8
    assert robot.limits.torque.shape == (8,)


TIE = r"^line \d+: joint 'left_knee': its <mimic> cannot be followed: "


@pytest.mark.parametrize(
    ("master", "numbers", "message"),
    [
        ("no_joint", {}, "it follows 'no_joint', which is no joint that moves; name one that does"),
        ("left_sole_joint", {}, "it follows 'left_sole_joint', which is no joint that moves"),
        ("left_knee", {}, "it follows itself; name the joint that it follows"),
        (
            "left_hip_pitch",
            {"multiplier": float("nan")},
            "its multiplier and offset must be finite",
        ),
        ("left_hip_pitch", {"offset": float("inf")}, "its multiplier and offset must be finite"),
        ("left_hip_pitch", {"multiplier": 0.0}, "its multiplier is 0; allowed are 1e-06 to 1000"),
        ("left_hip_pitch", {"multiplier": -1e9}, r"its multiplier is -1e\+09; allowed are"),
        ("left_hip_pitch", {"offset": 1e9}, r"its offset is 1e\+09 rad; allowed are 1000"),
    ],
)
def test_what_no_joint_can_follow_is_refused(master, numbers, message):
    """And what is advised works: without the <mimic>, or with all ties left out, it is a robot."""
    text = edited_urdf(lambda root: mimic(root, "left_knee", master, **numbers))
    with pytest.raises(RobotError, match=TIE + message) as caught:
        Robot.from_urdf(text)
    assert ", or remove <mimic> there" in str(caught.value)
    assert len(Robot.from_urdf(text, choices=ImportOptions(without=("ties",))).joint_names) == 12


def test_joints_that_follow_each_other_in_a_circle_are_refused():
    def edit(root):
        both("knee", "ankle_pitch", multiplier=2.0)(root)
        both("ankle_pitch", "hip_pitch", multiplier=2.0)(root)
        both("hip_pitch", "knee", multiplier=2.0)(root)

    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(edited_urdf(edit))
    circle = re.search("in a circle: (.*?); let one of them be free", str(caught.value)).group(1)
    first, *others = re.findall(r"'left_(\w+)'", circle)
    assert others[-1] == first
    assert {first, *others} == {"knee", "ankle_pitch", "hip_pitch"}


def test_ties_that_are_not_mirror_images_are_refused_with_the_image():
    def edit(root):
        mimic(root, "left_ankle_roll", "left_hip_roll", multiplier=-1.0, offset=0.1)
        mimic(root, "right_ankle_roll", "right_hip_roll", multiplier=-0.9)

    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(edited_urdf(edit))
    told = str(caught.value)
    assert (
        "'left_ankle_roll' follows 'left_hip_roll': its angle is -1 times that one's +0.1" in told
    )
    assert "'right_ankle_roll' follows 'right_hip_roll': its angle is -0.9 times" in told
    image = re.search(r"a mirror '(\w+)' follows '(\w+)': its angle is (\S+) times (.*?);", told)
    name, master, multiplier, rest = image.groups()
    offset = re.search(r"(\S+) rad", rest)
    wrong = {"left": (-1.0, 0.1), "right": (-0.9, 0.0)}
    side = "left" if name.startswith("right") else "right"

    def corrected(root):
        k, c = wrong[side]
        mimic(root, f"{side}_ankle_roll", f"{side}_hip_roll", multiplier=k, offset=c)
        c = float(offset.group(1)) if offset else 0.0
        mimic(root, name, master, multiplier=float(multiplier), offset=c)

    assert len(Robot.from_urdf(edited_urdf(corrected)).joint_names) == 10


def test_one_leg_tied_is_refused():
    text = edited_urdf(lambda root: mimic(root, "left_knee", "left_hip_pitch", multiplier=-2.0))
    with pytest.raises(RobotError, match=r"but in a mirror 'right_knee' follows"):
        Robot.from_urdf(text)


@pytest.mark.parametrize(
    ("multiplier", "offset", "fits"), [(1.0, 0.0, True), (0.5, 0.0, False), (1.0, 0.1, False)]
)
def test_hips_on_one_motor_turn_alike(multiplier, offset, fits):
    """A mirrored posture of NAO's hips is one that the motor can take only for equal angles."""
    text = nao_like(multiplier, offset=offset)
    if fits:
        assert len(read(text).joint_names) == 11
    else:
        with pytest.raises(RobotError, match="the ties of joints are not mirror images"):
            read(text)


def test_ranges_without_anything_in_common_are_refused():
    def edit(root):
        both("ankle_roll", "hip_roll", multiplier=1.0, offset=0.0)(root)
        for side in ("left", "right"):
            set_limit(f"{side}_ankle_roll", lower=-0.2, upper=-0.1)(root)
            set_limit(f"{side}_hip_roll", lower=0.1, upper=0.2)(root)

    with pytest.raises(RobotError, match="joints that are tied have no range in common, as angles"):
        Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits="right"))


def add_drives(root):
    """Drives beside the knees, as some robots have them: the knee follows at -0.5 times."""
    for side, y in (("left", 0.1), ("right", -0.1)):
        add_link(root, f"{side}_drive", 0.2)
        add_joint(
            root,
            f"{side}_knee_drive",
            f"{side}_thigh",
            f"{side}_drive",
            xyz=f"0 {y} -0.2",
            axis="0 1 0",
        )
        mimic(root, f"{side}_knee", f"{side}_knee_drive", multiplier=-0.5)


def test_what_leads_a_leg_moves_too():
    robot = Robot.from_urdf(edited_urdf(add_drives))
    assert len(robot.joint_names) == 12
    assert "left_knee_drive" in robot.joint_names
    assert "left_knee" not in robot.joint_names
    assert [robot.coupling.names[k] for k in robot.legs.knees] == ["right_knee", "left_knee"]
    assert robot.multibody.tied.size == 2


def test_a_leg_cannot_follow_what_cannot_move():
    def edit(root):
        add_drives(root)
        for side in ("left", "right"):
            joint(root, f"{side}_knee_drive").set("type", "prismatic")

    with pytest.raises(RobotError) as caught:
        Robot.from_urdf(edited_urdf(edit))
    assert re.search(
        "follows '.*_knee_drive', which cannot be moved: it is pris", str(caught.value)
    )
    assert "--without ties" in str(caught.value)
    free = Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(without=("ties",)))
    assert len(free.joint_names) == 12


def test_what_follows_a_leg_moves_if_it_can():
    """Arms tied to the legs swing with them; one alone in the middle is locked, and told."""

    def edit(root):
        add_arms(2)(root)
        add_link(root, "tail", 0.1)
        add_joint(root, "tail", "torso", "tail", xyz="-0.1 0.05 0", axis="1 0.5 0")
        mimic(root, "tail", "left_hip_pitch", multiplier=0.3)
        for side in ("left", "right"):
            mimic(root, f"{side}_arm_joint_0", f"{side}_hip_pitch", multiplier=-0.5)

    robot = Robot.from_urdf(edited_urdf(edit))
    assert len(robot.joint_names) == 12
    assert robot.tree.size == 14
    assert set(robot.tree.names[12:]) == {"left_arm_joint_0", "right_arm_joint_0"}
    (warned,) = (t for t in said(robot, "ties") if t.startswith("warning"))
    assert "tail follows 'left_hip_pitch'" in warned
    assert "locked" in warned


def test_a_posture_may_not_contradict_a_tie():
    text = edited_urdf(both("ankle_roll", "hip_roll", multiplier=-1.0))
    kept = Robot.from_urdf(text, choices=ImportOptions(posture=(("left_hip_roll", 0.0),)))
    assert len(kept.joint_names) == 10
    with pytest.raises(RobotError, match="joint 'left_ankle_roll' is put at"):
        Robot.from_urdf(text, choices=ImportOptions(posture=(("left_ankle_roll", 0.2),)))


def test_fingers_stand_where_what_they_follow_puts_them():
    def edit(root):
        add_arms(2)(root)
        for side in ("left", "right"):
            mimic(root, f"{side}_arm_joint_1", f"{side}_arm_joint_0", multiplier=2.0, offset=0.3)

    robot = Robot.from_urdf(edited_urdf(edit))
    body = robot.multibody
    stands = dict(zip(body.joint_names, body.posture, strict=True))
    assert stands["left_arm_joint_1"] == 0.3
    assert body.tied.size == 0  # none of them moves


_TIE = "<joint joint1='{0}_ankle_roll' joint2='{0}_hip_roll' polycoef='{1} -0.8 0 0 0'/>"


def mjcf(left=0.0, right=0.0):
    """The biped in MJCF with ankle rolls that follow hip rolls."""
    parts = _TIE.format("left", left) + _TIE.format("right", right)
    return edited(plain_mjcf(), added(".", f"<equality>{parts}</equality>"))


def test_equalities_of_joints_are_ties():
    robot = Robot.from_urdf(mjcf())
    assert len(robot.joint_names) == 10
    assert "left_ankle_roll" not in robot.joint_names
    assert robot.multibody.tie.tolist() == [[-0.8, 0.0]] * 2
    assert "<equality>" in robot.urdf
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)  # the normal form, without MuJoCo
    assert again.joint_names == robot.joint_names
    assert again.urdf == robot.urdf


def test_an_equality_is_about_the_refs():
    """MuJoCo counts from the posture that the file draws, here with hip rolls at 0.2 rad."""

    def refs(root):
        for side, sign in (("left", 1.0), ("right", 1.0)):
            root.find(f".//joint[@name='{side}_hip_roll']").set("ref", repr(0.2 * sign))

    text = edited(mjcf(0.05, 0.05), refs)
    ties = read_source(text).ties
    assert ties["left_ankle_roll"] == Tie(
        "left_ankle_roll", "left_hip_roll", -0.8, pytest.approx(0.05 + 0.16)
    )


def test_a_motor_may_sit_at_the_joint_that_follows():
    """The torque at the joint that is followed is then that of the motor, through the gear."""

    def unmotored(root):
        for motor in [m for m in root.iter("motor") if m.get("joint", "").endswith("hip_roll")]:
            next(p for p in root.iter() if motor in list(p)).remove(motor)

    robot = Robot.from_urdf(edited(mjcf(), unmotored))
    plain = Robot.from_urdf(plain_mjcf())
    at = plain.limits.torque[plain.joint_names.index("left_ankle_roll")]
    assert robot.limits.torque[robot.joint_names.index("left_hip_roll")] == pytest.approx(0.8 * at)


@needs_example_robots
def test_the_fingers_of_talos_follow_its_grippers():
    """The right gripper moves along as the partner of the left one, and six fingers with each."""
    path = example_robot("talos_data/robots/talos_full_v2.urdf")
    robot = Robot.from_urdf(path, choices=ImportOptions(moving=("gripper_left_joint",)))
    assert len(robot.joint_names) == 14
    assert robot.tree.size == 26
    assert sorted(set(robot.multibody.tie[:, 0])) == [-1.0, 1.0]


def with_rods(root):
    """Rods of no mass that follow the knees, as the twin legs of some robots."""
    add_drives(root)
    for side in ("left", "right"):
        drive = joint(root, f"{side}_knee_drive")
        drive.set("name", f"{side}_rod")
        link(root, f"{side}_drive").remove(link(root, f"{side}_drive").find("inertial"))
        tie = joint(root, f"{side}_knee").find("mimic")
        joint(root, f"{side}_knee").remove(tie)
        mimic(root, f"{side}_rod", f"{side}_knee", multiplier=-1.0)


def test_what_follows_without_mass_stays_out():
    """Rods of a linkage that only draw it."""
    robot = Robot.from_urdf(edited_urdf(with_rods))
    assert robot.coupling.none
    told = said(robot, "ties")
    assert len(told) == 2
    assert all("but is locked: it moves no mass" in text for text in told)


def with_loaded_rods(*sides):
    loads = tuple(Payload(f"{side}_drive", 0.4, (0.05, 0.0, 0.1)) for side in sides)
    choices = ImportOptions(payloads=loads, asymmetry=1.0)
    return Robot.from_urdf(edited_urdf(with_rods), choices=choices)


def test_what_follows_moves_with_a_load():
    robot = with_loaded_rods("left", "right")
    assert {"left_rod", "right_rod"} == {*robot.coupling.names} - {*robot.joint_names}
    masses = [robot.model.inertias[robot.model.getJointId(f"{s}_rod")].mass for s in SIDES]
    assert masses == pytest.approx([0.4, 0.4])
    assert not [text for text in said(robot, "ties") if "locked" in text]
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert again.model == robot.model


def test_a_load_on_one_side_moves_neither():
    robot = with_loaded_rods("left")
    assert robot.coupling.none
    assert len([text for text in said(robot, "ties") if "moves no mass" in text]) == 2


BENT = "bent elbows and shanks"


def test_mujoco_finds_bends_kept_as_the_file_says():
    """Its own model of the file: no residual of the equalities, no rate across them."""

    def refs(root):  # the polynomial is of the distances from these
        for side, sign in (("left", 1.0), ("right", -1.0)):
            root.find(f".//joint[@name='{side}_ankle_roll']").set("ref", repr(0.05 * sign))
            root.find(f".//joint[@name='{side}_shank_twist']").set("ref", repr(-0.1 * sign))

    text = edited(bent().replace("0.02 0.4", "0.0 0.4"), refs)
    robot = Robot.from_urdf(text, moving=("arms", "waist"))
    model = mujoco.MjModel.from_xml_string(text)
    data, coupling = mujoco.MjData(model), robot.coupling
    rng = np.random.default_rng(3)
    z, dz = rng.uniform(-0.4, 0.4, (2, len(robot.joint_names)))
    motion = coupling.motion(np.stack([z, dz, np.zeros(len(z))])[:, None])
    joints = [model.joint(name) for name in coupling.names]
    data.qpos[[int(j.qposadr[0]) for j in joints]] = motion.of_all[0, 0]
    dofs = [int(j.dofadr[0]) for j in joints]
    data.qvel[dofs] = motion.of_all[1, 0]
    mujoco.mj_forward(model, data)
    held = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
    assert held.sum() == 4
    assert np.abs(data.efc_pos[held]).max() < 1e-14
    J = data.efc_J.reshape(-1, model.nv)[held]
    assert np.abs(J[:, dofs] @ coupling.at(z).matrix).max() < 1e-14
    assert np.abs(J).max() > 1.0
    # what an instant later the rates still keep: the acceleration of those that follow is exact
    h, ddq = 1e-5, motion.of_all[2, 0]
    rates = [coupling.at(z + s * h * dz).rates(dz) for s in (-1.0, 1.0)]
    np.testing.assert_allclose((rates[1] - rates[0]) / (2.0 * h), ddq, atol=1e-8)
    assert np.abs(ddq).max() > 1e-2


@pytest.mark.parametrize("coefficients", [(0.1, -2.0), (0.1, 1.0, 0.0, 0.5), (0.0, 1.0)])
def test_what_follows_an_endless_joint_is_endless(coefficients):
    coupling = couple(("a", "b"), {"b": Tie.of("b", "a", coefficients)}, np.eye(2))
    none = np.full(1, np.inf)
    free = JointLimits(torque=none, speed=none, lower=-none, upper=none)
    assert coupling.reach(0, free) == coupling.reach(1, free) == (-np.inf, np.inf)
    half = coupling.reach(1, JointLimits(torque=none, speed=none, lower=np.zeros(1), upper=none))
    at_zero = coefficients[0]
    assert half == ((-np.inf, at_zero) if coefficients[1] < 0.0 else (at_zero, np.inf))


def test_bends_pass_their_limits_on():
    """By ranges inverted, and by the steepest slope between them."""
    coupling = couple(("a", "b"), {"b": Tie.of("b", "a", (0.1, 1.0, 0.5))}, np.eye(2))
    raw = JointLimits(
        torque=np.array([np.inf, 12.0]),
        speed=np.array([9.0, 6.0]),
        lower=np.array([-0.5, -np.inf]),
        upper=np.array([2.0, 1.6]),
    )
    found = coupling.limits(raw)
    assert found.range(0) == pytest.approx((-0.5, 1.0))  # 0.1 + 1 + 0.5 = 1.6
    assert found.speed[0] == pytest.approx(6.0 / 2.0)  # slope 1 + z, at most 2
    assert coupling.complete(raw).torque[0] == pytest.approx(12.0 * 0.5)  # at least 0.5
    assert coupling.reach(1, found) == pytest.approx((0.1 - 0.5 + 0.125, 1.6))
    z = np.zeros(1)
    coupling.put(z, 1, 0.725, found)
    assert z[0] == pytest.approx(0.5)
    coupling.put(z, 1, 7.0, found)  # as near as the range allows
    assert z[0] == pytest.approx(1.0)


def test_a_bend_that_turns_back_is_refused_and_the_advice_works():
    parts = [
        equality(f"{side}_ankle_pitch", f"{side}_knee", (-0.3, -0.45, 0.06, -0.02, 0.01))
        for side in ("left", "right")
    ]
    text = edited(plain_mjcf(), added(".", f"<equality>{''.join(parts)}</equality>"))
    with pytest.raises(RobotError, match="turns back where that one is at") as caught:
        Robot.from_urdf(text)
    told = re.search(r"back where that one is at (\S+) rad, .* give '(\w+)'", str(caught.value))
    assert told.group(2) == "right_knee"
    most = float(told.group(1)) - 0.01
    narrow = [at(f".//joint[@name='{s}_knee']", range=f"0 {most}") for s in ("left", "right")]
    assert len(Robot.from_urdf(edited(text, together(*narrow))).joint_names) == 10
    assert len(Robot.from_urdf(text, choices=ImportOptions(without=("ties",))).joint_names) == 12


def test_bends_of_both_legs_are_mirror_images():
    text = bent().replace("0.4 0.12", "0.4 0.13")
    image = r"but in a mirror .*_shank_twist. follows .* 0.02 \+0.4 q \+0.12 q\^2 -0.1 q\^3"
    with pytest.raises(RobotError, match=image):
        Robot.from_urdf(text, moving=("arms", "waist"))


def test_a_bend_through_others_has_at_most_the_fourth_power():
    square = Tie.of("a", "b", (0.0, 1.0, 0.5))
    found, faults = ties_to_masters({"a": square, "b": Tie.of("b", "c", (0.1, 1.0, 0.2))})
    assert faults == {}
    inner = 0.1 + 0.3 + 0.2 * 0.3**2
    assert found["a"].at(0.3) == pytest.approx(inner + 0.5 * inner**2)
    cubic = Tie.of("b", "c", (0.0, 1.0, 0.0, 0.2))
    assert "with power 6; allowed is 4" in ties_to_masters({"a": square, "b": cubic})[1]["a"]
    line = {f"j{k}": Tie.of(f"j{k}", f"j{k + 1}", (0.0, 1.0, 0.5)) for k in range(30)}
    assert len(ties_to_masters(line)[1]) == 28  # and no number of powers that grows without end


def test_the_normal_form_keeps_bends():
    robot = tied(BENT)
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    np.testing.assert_array_equal(again.coupling.coefficients, robot.coupling.coefficients)
    assert again.urdf == robot.urdf
    (told, *_) = said(robot, "ties")
    assert "where that one is at q, it is at" in told
