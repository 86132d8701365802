import re
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
import pytest
from humanoids import add_joint, add_link, edits
from hypothesis import given, settings
from hypothesis import strategies as st
from pelvis_rooted import reading_of
from places import CASES
from urdf_edits import edited_urdf, joint, link, scale_mass, set_limit

from gaitopt.errors import RobotError
from gaitopt.importers.reader import read_source
from gaitopt.model.chain import RootedChain, build_chain
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.joint_tree import lock_upper_body, reroot
from gaitopt.model.robot import Robot
from gaitopt.model.symmetry import exchange_error, mirrored

quick = settings(deadline=None, derandomize=True, max_examples=25)


def said(robot: Robot, topic: str = "symmetry") -> list[str]:
    return [f"{f.how}: {f.subject}: {f.text}" for f in robot.findings if f.topic == topic]


def advised(error: RobotError) -> ImportOptions:
    """The choice that a refusal names."""
    named = re.search(r"have it averaged: asymmetry = ([\d.e-]+) in", str(error))
    return ImportOptions(asymmetry=float(named.group(1)))


def soles_of(robot: Robot) -> tuple[str, str]:
    return robot.stance_sole, robot.swing_sole


def shift_com(name: str, xyz: str):
    def edit(root):
        link(root, name).find("inertial/origin").set("xyz", xyz)

    return edit


@quick
@given(st.integers(0, 1000))
def test_a_body_mirrored_twice_is_the_body(seed):
    pin.seed(seed)
    body = pin.Inertia.Random()
    image = mirrored(body)
    np.testing.assert_allclose(mirrored(image).matrix(), body.matrix(), atol=1e-14)
    # Mirrored motions carry the same energy: twists mirror with S, rotations with -S.
    twist = np.random.default_rng(seed).normal(size=6)
    signs = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    energy, other = (b.vtiv(pin.Motion(t)) for b, t in ((body, twist), (image, signs * twist)))
    assert energy == pytest.approx(other, rel=1e-12)


def test_the_symmetric_biped_is_left_alone(robot):
    assert said(robot) == []
    reading = reading_of(robot.urdf)
    masses = sorted(b.mass for b in reading.model.inertias)
    assert sorted(b.mass for b in robot.model.inertias) == masses


def test_a_heavier_foot_is_shared_between_the_feet(robot):
    heavy = Robot.from_urdf(edited_urdf(scale_mass("left_foot", 1.05)))
    assert heavy.mass == pytest.approx(robot.mass + 0.05 * 1.64, abs=1e-9)
    feet = [heavy.model.inertias[k].mass for k in (1, 13)]
    assert feet == pytest.approx([1.025 * 1.64] * 2, rel=1e-9)
    assert exchange_error(heavy.model, heavy.mirror, "right_sole", "left_sole") < 1e-12
    first, last = said(heavy)
    assert first.startswith("changed: links moved by 'right_ankle_roll' and 'left_ankle_roll': ")
    assert "averaged left and right, which differed by 82 g in mass" in first
    assert "averaging left and right changed the mass matrix by" in last


def test_the_exchange_sees_a_rotor_on_one_side_only(robot):
    model = robot.model.copy()
    armature = np.zeros(model.nv)
    armature[-1] = 0.05
    model.armature = armature
    assert exchange_error(robot.model, robot.mirror, "right_sole", "left_sole") < 1e-12
    assert exchange_error(model, robot.mirror, "right_sole", "left_sole") > 1e-4


def test_a_trunk_whose_mass_is_to_one_side_is_centred():
    leaning = Robot.from_urdf(edited_urdf(shift_com("torso", "0.01 0.002 0.2975")))
    assert exchange_error(leaning.model, leaning.mirror, "right_sole", "left_sole") < 1e-12
    data = leaning.model.createData()
    pin.centerOfMass(leaning.model, data, pin.neutral(leaning.model))
    pin.updateFramePlacements(leaning.model, data)
    assert data.oMf[leaning.pelvis_frame].actInv(data.com[0])[1] == pytest.approx(0.0, abs=1e-12)
    # The trunk's centre lies 2 mm to the left, its mirror image 2 mm to the right.
    assert "changed: trunk: " in said(leaning)[0]
    assert "4 mm in centre of mass" in said(leaning)[0]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (
            scale_mass("left_foot", 3.0),
            r"by its effect: links moved by 'right_ankle_roll' and 'left_ankle_roll': 3.28e\+03 g "
            r"in mass, .* \(mass matrix [\d.]+ %\)",
        ),
        (
            shift_com("torso", "0 0.05 0.2975"),
            r"allowed is [\d.]+ % .* trunk: 0 g in mass, 100 mm in centre of mass",
        ),
    ],
)
def test_a_lopsided_robot_is_refused_by_its_worst_link(edit, message):
    with pytest.raises(RobotError, match=message) as refused:
        Robot.from_urdf(edited_urdf(edit))
    robot = Robot.from_urdf(edited_urdf(edit), choices=advised(refused.value))
    assert exchange_error(robot.model, robot.mirror, "right_sole", "left_sole") < 1e-12


def test_an_arm_on_one_side_only_shows_in_the_trunk():
    def one_arm(root):
        add_link(root, "arm", 8.0)
        add_joint(root, "shoulder", "torso", "arm", xyz="0 0.3 0.4")

    with pytest.raises(RobotError, match=r"by its effect: trunk: 0 g in mass, 98.9 mm"):
        Robot.from_urdf(edited_urdf(one_arm))


def test_inertias_left_out_of_one_leg_are_its_partners(robot):
    def empty(root):
        for name in ("right_thigh", "right_shin"):
            tensor = link(root, name).find("inertial/inertia")
            tensor.attrib.update(dict.fromkeys(("ixx", "iyy", "izz"), "0"))

    filled = Robot.from_urdf(edited_urdf(empty))
    for mine, its in zip(filled.model.inertias, robot.model.inertias, strict=True):
        np.testing.assert_allclose(mine.matrix(), its.matrix(), atol=1e-12)
    assert said(filled)[0].startswith("warning: right_hip_pitch, right_knee: the file gives these")


def _nudge(size: float):
    def edit(root):
        joint(root, "left_knee").find("origin").set("xyz", f"{size} 0 {-0.3 + size}")
        joint(root, "left_ankle_pitch").find("origin").set("rpy", f"0 0 {size}")

    return edit


@pytest.mark.parametrize("size", [-2e-5, 1e-4, -1e-3])
def test_joints_a_little_off_meet_in_the_middle(robot, size):
    rounded = Robot.from_urdf(edited_urdf(_nudge(size)))
    error = exchange_error(rounded.model, rounded.mirror, "right_sole", "left_sole")
    assert error < 1e-12
    told = "\n".join(said(rounded))
    assert f"'left_knee': averaged left and right, which differed by {size_words(size)}" in told
    np.testing.assert_allclose(rounded.legs.hips, robot.legs.hips, atol=1e-12)
    # The left shank is turned by `size`, and the thigh shorter by it: half of that on either side.
    assert rounded.legs.reach == pytest.approx(robot.legs.reach - size / 2.0, abs=1e-2 * abs(size))


def size_words(size: float) -> str:
    return f"{np.hypot(size, size) * 1e3:.3g} mm and 0 degrees"


def test_crooked_legs_are_refused_by_the_joint_and_accepted_as_advised():
    edit = edits(_nudge(1.8e-2))
    message = r"joints 'right_knee' and 'left_knee': 25.5 mm and 0 degrees \(mass matrix .* feet "
    with pytest.raises(RobotError, match=message) as refused:
        Robot.from_urdf(edited_urdf(edit))
    assert "joints 'right_ankle_pitch' and 'left_ankle_pitch': 0 mm and 1.03 degrees" in str(
        refused.value
    )
    robot = Robot.from_urdf(edited_urdf(edit), choices=advised(refused.value))
    assert exchange_error(robot.model, robot.mirror, "right_sole", "left_sole") < 1e-12


def test_all_that_is_wrong_is_told_at_once():
    edit = edits(
        _nudge(1.8e-2),
        scale_mass("left_foot", 3.0),
        set_limit("left_hip_yaw", effort=10.0),
    )
    with pytest.raises(RobotError) as refused:
        Robot.from_urdf(edited_urdf(edit))
    told = str(refused.value)
    assert told.startswith("2 faults keep this robot from being used: (1) ")
    for fact in (
        "torque limits of 'right_hip_yaw' and 'left_hip_yaw'",
        "'right_knee' and 'left_knee'",
        "'right_ankle_roll' and 'left_ankle_roll': 3.28e+03 g",
    ):
        assert fact in told


def test_an_impossible_body_does_not_hide_what_else_is_wrong():
    def impossible(root):
        link(root, "left_shin").find("inertial/inertia").set("ixx", "9")

    with pytest.raises(RobotError) as refused:
        Robot.from_urdf(edited_urdf(edits(impossible, _nudge(1.8e-2))))
    told = str(refused.value)
    assert "the inertia cannot belong" in told
    assert "'right_knee' and 'left_knee': 25.5 mm" in told


def test_different_rotors_are_averaged():
    limits = (LimitOverride("left_knee", armature=0.1), LimitOverride("right_knee", armature=0.11))
    robot = Robot.from_urdf(edited_urdf(lambda _: None), choices=ImportOptions(limits=limits))
    knees = [6 + robot.joint_names.index(f"{side}_knee") for side in ("left", "right")]
    assert robot.model.armature[knees].tolist() == pytest.approx([0.105] * 2)
    first = said(robot)[0]
    assert first.startswith("changed: rotors of 'right_knee' and 'left_knee': averaged left and ")
    assert "0.01 kg·m² (armature)" in first


# Seeded families: any joint, any direction, sizes over decades.

JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
LINKS = ("thigh", "shin", "foot")


def disturbed(seed: int, size: float):
    """Shift, turn and reweigh parts of the left leg by about `size` (m, rad, relative)."""
    rng = np.random.default_rng(seed)

    def edit(root):
        for name in rng.choice(JOINTS, 2, replace=False):
            origin = joint(root, f"left_{name}").find("origin")
            xyz = np.array([float(v) for v in origin.get("xyz", "0 0 0").split()])
            rpy = np.array([float(v) for v in origin.get("rpy", "0 0 0").split()])
            xyz, rpy = (v + size * rng.uniform(-1.0, 1.0, 3) for v in (xyz, rpy))
            origin.set("xyz", " ".join(map(repr, xyz.tolist())))
            origin.set("rpy", " ".join(map(repr, rpy.tolist())))
        for name in rng.choice(LINKS, 2, replace=False):
            inertial = link(root, f"left_{name}").find("inertial")
            scale = 1.0 + 10.0 * size * rng.uniform(-1.0, 1.0)
            mass = inertial.find("mass")
            mass.set("value", repr(float(mass.get("value")) * scale))
            tensor = inertial.find("inertia")
            for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
                tensor.set(key, repr(float(tensor.get(key, "0")) * scale))

    return edited_urdf(edit)


def chain_of(urdf: str, **choices) -> tuple[ImportedRobot, RootedChain]:
    source = read_source(urdf, ())
    reading = import_robot(source, ImportOptions(asymmetry=1.0, **choices))
    return reading, build_chain(reading)


def recomputed(urdf: str, seed: int) -> tuple[float, float]:
    """Effect of averaging, from chains rooted at either sole, at other postures."""
    mass, feet = 0.0, 0.0
    rng = np.random.default_rng(seed)
    postures = rng.uniform(-1.0, 1.0, (300, 12))
    scales, changes = [], []
    for stance in ("right", "left"):
        reading, chain = chain_of(urdf, stance=stance)
        file = reroot(
            lock_upper_body(reading.model, *reading.sole_names, reading.q), *reading.sole_names
        )
        low, high = (
            b[7:] for b in (chain.model.lowerPositionLimit, chain.model.upperPositionLimit)
        )
        order = slice(None) if stance == "right" else slice(None, None, -1)
        matrices = []
        for posture in postures:
            q = pin.neutral(file)
            q[7:] = np.clip(posture[order], low, high)
            places = []
            for model in (file, chain.model):
                data = model.createData()
                matrices.append(pin.crba(model, data, q)[6:, 6:].copy())
                pin.framesForwardKinematics(model, data, q)
                sole, other = (model.getFrameId(name) for name in reading.sole_names)
                places.append(data.oMf[sole].actInv(data.oMf[other]))
            moved = np.linalg.norm(places[0].translation - places[1].translation)
            turned = np.linalg.norm(pin.log3(places[0].rotation.T @ places[1].rotation))
            feet = max(feet, moved / 0.6, turned)  # the biped's legs are 0.6 m long
        even = np.array(matrices[1::2])[:, order, order]
        changes.append(even - np.array(matrices[::2])[:, order, order])
        scales.append(np.diagonal(even, axis1=1, axis2=2))
    largest = np.maximum(*scales)
    largest = np.sqrt(np.maximum(largest, largest[:, ::-1]))
    for change in changes:
        mass = max(mass, np.abs(change / largest[:, :, None] / largest[:, None, :]).max())
    return mass, feet


@pytest.mark.parametrize("size", [1e-7, 1e-5, 1e-3, 1e-2])
def test_any_disturbed_robot_becomes_its_own_mirror_image(size):
    for seed in range(3):
        chain = chain_of(disturbed(seed, size))[1]
        assert exchange_error(chain.model, chain.mirror, "right_sole", "left_sole") < 1e-10
        assert 0.02 * size < chain.symmetry.effect.size < 30.0 * size


@pytest.mark.parametrize(("seed", "size"), [(0, 1e-4), (1, 1e-3), (2, 1e-2)])
def test_the_told_effect_is_that_of_an_independent_computation(seed, size):
    urdf = disturbed(seed, size)
    effect = chain_of(urdf)[1].symmetry.effect
    mass, feet = recomputed(urdf, seed + 100)
    # The largest of other random postures: it varies, by how much depends on their number.
    assert effect.mass_matrix == pytest.approx(mass, rel=0.3)
    assert effect.feet == pytest.approx(feet, rel=0.3)


def test_left_and_right_are_treated_alike():
    """The same difference on the other leg gives the mirror image of the same robot."""
    left = chain_of(disturbed(5, 2e-3))[1]
    right = chain_of(disturbed(5, 2e-3), stance="left")[1]
    assert left.symmetry.effect == right.symmetry.effect
    for first, other in zip(left.model.inertias, right.model.inertias, strict=True):
        assert first.mass == pytest.approx(other.mass, abs=1e-12)


@pytest.mark.parametrize("seed", range(2))
def test_what_is_accepted_grows_with_the_choice_and_falls_with_the_size(seed):
    effects = [chain_of(disturbed(seed, size))[1].symmetry.effect.size for size in SIZES]
    assert effects == sorted(effects)
    for allowed in (3e-3,):
        for size, effect in zip(SIZES, effects, strict=True):
            choices = ImportOptions(asymmetry=allowed)
            if effect <= allowed:
                Robot.from_urdf(disturbed(seed, size), choices=choices)
            else:
                with pytest.raises(RobotError, match="not its own mirror image") as refused:
                    Robot.from_urdf(disturbed(seed, size), choices=choices)
                Robot.from_urdf(disturbed(seed, size), choices=advised(refused.value))


SIZES = (1e-4, 1e-3, 1e-2)


@pytest.mark.parametrize("degrees", [0.18, 0.49])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("name", ["hip_yaw", "knee"])
def test_a_leg_a_little_turned_is_read_as_it_is(name, axis, degrees):
    root = ET.parse(CASES / "base_mini.urdf").getroot()
    rpy = np.zeros(3)
    rpy[axis] = np.radians(degrees)
    joint(root, f"left_{name}").find("origin").set("rpy", " ".join(map(str, rpy)))
    robot = Robot.from_urdf(ET.tostring(root, encoding="unicode"))
    assert exchange_error(robot.model, robot.mirror, *soles_of(robot)) < 1e-12
    # It is the leg that is turned, not the robot, and one sole is told to be tilted at most.
    even = Robot.from_urdf(CASES / "base_mini.urdf")
    assert (robot.choices.forward, robot.choices.up) == ("x", "z")
    edges = ("toe", "heel", "left", "right")
    for edge in edges:
        assert getattr(robot.sole, edge) == pytest.approx(getattr(even.sole, edge), abs=2e-3)


@pytest.mark.parametrize("shift", [(2e-3, 0.0, 0.0), (0.0, 0.0, 2e-3), (8e-3, 0.0, 0.0)])
def test_a_hip_ahead_or_above_turns_neither_heading_nor_up(shift):
    root = ET.parse(CASES / "base_mini.urdf").getroot()
    place = np.array([0.0, 0.1, 0.0]) + shift
    joint(root, "left_hip_yaw").find("origin").set("xyz", " ".join(map(str, place)))
    choices = ImportOptions(asymmetry=0.05)
    robot = Robot.from_urdf(ET.tostring(root, encoding="unicode"), choices=choices)
    assert (robot.choices.forward, robot.choices.up) == ("x", "z")
    told = [line for line in said(robot) if "joints" in line]
    assert len(told) == 1
    assert f"differed by {1e3 * max(shift):.3g} mm and 0 degrees" in told[0]


def test_a_hip_of_the_case_is_averaged_and_told():
    robot = Robot.from_urdf(CASES / "urdf_left_hip_0.2mm_off.urdf")
    first, last = said(robot)
    assert "joints 'right_hip_yaw' and 'left_hip_yaw'" in first
    assert "differed by 0.2 mm and 0 degrees: mass matrix 0.066 %, feet 0.032 %" in first
    assert "the placement of the feet by 0.032 % of the leg's length" in last
    assert exchange_error(robot.model, robot.mirror, *soles_of(robot)) < 1e-12


def test_a_light_link_of_the_case_is_judged_by_its_effect():
    robot = Robot.from_urdf(CASES / "urdf_light_link_differs_40g.urdf")
    first, last = said(robot)
    assert "'right_ankle_pitch' and 'left_ankle_pitch': averaged left and right" in first
    assert "differed by 40 g in mass" in first
    assert "changed the mass matrix by 0.42 %" in last


def test_limits_of_the_case_are_the_tighter_ones():
    robot = Robot.from_urdf(CASES / "limits_differ_0.05pct.urdf")
    knees = list(robot.legs.knees)
    assert robot.limits.speed[knees].tolist() == [18.53, 18.53]
    (line,) = said(robot, "limits")
    assert line == "changed: r_knee, l_knee: speed limits 18.53 and 18.54 rad/s differ: tighter"
