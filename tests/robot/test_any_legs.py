"""Legs of four to seven joints, arms and a waist that move: found by effect, mirrored exactly."""

import functools

import numpy as np
import pytest
from humanoids import add_arms, add_joint, add_link, edits
from synthetic_bipeds import FIVE, SEVEN, SOLE, biped_urdf
from urdf_edits import edited_urdf, joint, link, scale_mass

from gaitopt.design.conflict import contradictions
from gaitopt.errors import RobotError
from gaitopt.gait.initial_guess import flat_feet_gap
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.leg_geometry import (
    common_point,
    find_knee,
    hip_and_ankle,
    missing_joints,
)
from gaitopt.model.robot import Robot
from gaitopt.model.symmetry import exchange_error

X, Y, Z = np.eye(3)


def fixed(*names: str):
    def edit(root):
        for side in ("left", "right"):
            for name in names:
                joint(root, f"{side}_{name}").set("type", "fixed")

    return edit


def with_seventh(root):
    """A second roll at the hip, above the yaw."""
    for side in ("left", "right"):
        yaw = joint(root, f"{side}_hip_yaw")
        place = yaw.find("origin").get("xyz")
        add_link(root, f"{side}_extra", 0.3)
        add_joint(root, f"{side}_seventh", "torso", f"{side}_extra", xyz=place, axis="1 0 0")
        yaw.find("parent").set("link", f"{side}_extra")
        yaw.find("origin").set("xyz", "0 0 0")


def read(edit, **choices) -> Robot:
    limits = (LimitOverride("*seventh*", lower=-1.0, upper=1.0),) if "seventh" in repr(edit) else ()
    return Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(limits=limits, **choices))


def said(robot: Robot, topic: str) -> str:
    return "; ".join(f"{f.how}: {f.subject}: {f.text}" for f in robot.findings if f.topic == topic)


@pytest.mark.parametrize(
    ("edit", "count", "word", "lacks"),
    [
        (fixed("ankle_roll"), 5, "five", "have no ankle roll joint"),
        (fixed("hip_yaw"), 5, "five", "have no hip yaw joint"),
        (fixed("hip_yaw", "ankle_roll"), 4, "four", "have no hip yaw and no ankle roll joint"),
        (fixed(), 6, "six", ""),
        (with_seventh, 7, "seven", ""),
    ],
)
def test_legs_of_four_to_seven_joints_are_found(robot, edit, count, word, lacks):
    found = read(edit)
    assert len(found.joint_names) == 2 * count
    assert found.tree.stance == count
    assert [found.joint_names[k] for k in found.legs.knees] == ["right_knee", "left_knee"]
    assert found.legs.reach == pytest.approx(robot.legs.reach, abs=1e-12)
    np.testing.assert_allclose(found.legs.hips, robot.legs.hips, atol=1e-12)
    np.testing.assert_allclose(found.legs.ankles, robot.legs.ankles, atol=1e-12)
    assert found.legs.stance_width == pytest.approx(robot.legs.stance_width, abs=1e-12)
    assert found.legs.ankles_roll == ("ankle roll" not in lacks)
    soles = found.stance_sole, found.swing_sole
    assert exchange_error(found.model, found.mirror, *soles) < 1e-12
    np.testing.assert_array_equal(found.mirror @ found.mirror, np.eye(2 * count))
    assert f"found: right leg: {word} joints from hip to ankle: right_" in said(found, "legs")
    assert (f"warning: both legs: {lacks}" in said(found, "legs")) == bool(lacks)
    again = Robot.from_urdf(found.urdf, choices=found.choices)
    assert again.model == found.model


@pytest.mark.parametrize("joints", [FIVE, SEVEN])
def test_the_knee_is_between_hip_and_ankle(joints):
    origins = np.cumsum([origin for _, origin, _, _ in joints], axis=0)
    axes = np.array([axis for _, _, axis, _ in joints])
    hip, ankle = hip_and_ankle(origins, axes / np.linalg.norm(axes, axis=1)[:, None])
    names = [name for name, *_ in joints]
    assert names[len(hip)] == "knee"
    assert [names[k] for k in hip] == [n for n in names if n.startswith("hip")]
    assert [*hip, len(hip), *ankle] == list(range(len(joints)))


@pytest.mark.parametrize("seed", range(8))
def test_of_two_knees_neither_is_of_hip_or_ankle(seed):
    rng = np.random.default_rng(seed)
    thigh, between, shank = rng.uniform(0.2, 0.4), rng.uniform(0.03, 0.15), rng.uniform(0.2, 0.4)
    heights = -np.cumsum([0.0, 0.0, 0.0, thigh, between, shank, 0.0])
    points = np.column_stack([np.zeros(7), np.full(7, 0.1), heights]) + rng.normal(0, 3e-3, (7, 3))
    axes = np.array([Z, X, Y, Y, Y, Y, X]) + rng.uniform(-0.03, 0.03, (7, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    assert hip_and_ankle(points, axes) == ([0, 1, 2], [5, 6])
    assert missing_joints(points, axes) == []
    hip, ankle = (common_point(points[rows], axes[rows]) for rows in ([0, 1, 2], [5, 6]))
    knee = find_knee(points, axes, hip, ankle, np.zeros(7), range(3, 7))
    assert knee.row in {3, 4}
    assert knee.reach == pytest.approx(thigh + between + shank, abs=0.02)


@pytest.mark.parametrize(
    ("rows", "missing"),
    [
        ([0, 1, 2, 3, 4, 5], []),
        ([1, 2, 3, 4, 5], ["hip yaw"]),
        ([0, 2, 3, 4, 5], ["hip roll"]),
        ([0, 1, 2, 3, 5], ["ankle pitch"]),
        ([2, 3, 4], ["hip roll", "hip yaw", "ankle roll"]),
        ([0, 1, 2, 4, 5], ["knee"]),
    ],
)
def test_missing_joints_are_named(rows, missing):
    points = np.array([[0.0, 0.1, 0.0]] * 3 + [[0.0, 0.1, -0.4]] + [[0.0, 0.1, -0.75]] * 2)
    axes = np.array([Z, X, Y, Y, Y, X])
    assert missing_joints(points[rows], axes[rows]) == missing


def chest(root):
    """Put the arms on a chest that turns on the torso."""
    add_link(root, "chest", 3.0)
    add_joint(root, "spine", "torso", "chest", xyz="0 0 0.3", axis="0 0 1")
    for side in ("left", "right"):
        joint(root, f"{side}_arm_joint_0").find("parent").set("link", "chest")


def chest_first(root):
    """The same with the chest as the root of the file: the legs hang on the waist."""
    chest(root)
    spine = joint(root, "spine")
    spine.find("parent").set("link", "chest")
    spine.find("child").set("link", "torso")
    spine.find("origin").set("xyz", "0 0 -0.3")


@functools.cache
def wide_legs() -> Robot:
    """Legs as H1 has them: no ankle rolls, and they hang wider apart than the hips' axes meet."""
    wide = np.array([0.0, 0.11, -0.36])
    five = (*SEVEN[:3], ("knee", wide, (0.0, 1.0, 0.0), 2.0), ("ankle", (0, 0, -0.34), Y, 1.0))
    return Robot.from_urdf(
        biped_urdf(five), stance_sole="right_sole", swing_sole="left_sole", sole=SOLE
    )


def test_legs_without_ankle_roll_stand_below_the_line_of_their_feet():
    legs = wide_legs().legs
    assert legs.missing == ("ankle roll",)
    assert legs.spacing == pytest.approx(2.0 * 0.09, abs=0.01)
    assert legs.stance_width == pytest.approx(2.0 * (0.09 + 0.11), abs=1e-9)
    task = preset_task("humanoid", wide_legs(), speed=0.5)
    assert (task.margins.step_width, task.margins.trunk_roll) == (0.43, 0.25)


def test_a_step_that_does_not_put_the_feet_flat_is_told_with_the_missing_joint():
    robot = wide_legs()
    well = WalkProblem(robot, preset_task("humanoid", robot, speed=0.5))
    assert flat_feet_gap(well) < 1e-6
    assert contradictions(well) == ()
    narrow = WalkProblem(robot, preset_task("humanoid", robot, speed=0.5, step_width=0.3))
    assert flat_feet_gap(narrow) > 0.01
    ((constraint, sentence),) = contradictions(narrow)
    assert constraint == "closure"
    assert sentence.startswith("the legs cannot put both feet flat at a step of 0.3")
    assert sentence.endswith("as the legs have no ankle roll joint")


WAISTED = edits(add_arms(4), chest)


def test_arms_and_waist_stay_locked_unless_asked_for(robot):
    assert read(WAISTED).joint_names == robot.joint_names


@pytest.mark.parametrize("patterns", [("arms",), ("*_arm_joint_*",), ("left_arm_joint_?",)])
def test_arms_move_in_pairs(robot, patterns):
    """Both shoulders turn about one line; a joint that is asked for takes its partner along."""
    armed = read(WAISTED, moving=patterns)
    assert armed.joint_names[:12] == robot.joint_names
    assert set(armed.joint_names[12:]) == {
        f"{side}_arm_joint_{k}" for side in ("left", "right") for k in range(4)
    }
    for k, name in enumerate(armed.joint_names):
        partner = armed.joint_names[int(np.abs(armed.mirror[k]).argmax())]
        assert {name.split("_", 1)[0], partner.split("_", 1)[0]} == {"left", "right"}
        assert name.split("_", 1)[1] == partner.split("_", 1)[1]
    assert exchange_error(armed.model, armed.mirror, "right_sole", "left_sole") < 1e-12
    assert armed.limits.torque.shape == (20,)
    assert armed.limits.torque[12:].tolist() == [40.0] * 8
    assert "given: upper body: moves: right_arm_joint_0, left_arm_joint_0" in said(armed, "legs")
    assert armed.mass == pytest.approx(robot.mass + 7.0, abs=1e-9)
    again = Robot.from_urdf(armed.urdf, choices=armed.choices)
    assert again.model == armed.model


@pytest.mark.parametrize("pattern", ["waist", "spine"])
def test_a_waist_mirrors_itself(pattern):
    """Its range is what it has in common with its mirror image."""
    turning = read(WAISTED, moving=(pattern,))
    assert turning.joint_names[-1] == "spine"
    assert turning.mirror[-1].tolist() == [0.0] * 12 + [-1.0]
    assert (turning.limits.lower[-1], turning.limits.upper[-1]) == (-1.2, 1.2)
    assert "spine: mirrors itself with opposite angles" in said(turning, "pairs")
    assert "changed: spine: ranges -1.2 to 1.4 rad and -1.4 to 1.2 rad" in said(turning, "limits")


def test_the_root_of_the_file_may_be_above_the_waist():
    """Whichever link is the root, the same robot moves the same way."""
    moving = ("arms", "waist")
    below, above = (read(edits(add_arms(4), e), moving=moving) for e in (chest, chest_first))
    assert set(above.joint_names) == set(below.joint_names)
    assert above.joint_names[12] == "spine"
    assert exchange_error(above.model, above.mirror, "right_sole", "left_sole") < 1e-12
    order = [above.joint_names.index(name) for name in below.joint_names]
    np.testing.assert_array_equal(above.mirror[np.ix_(order, order)], below.mirror)
    np.testing.assert_array_equal(above.limits.torque[order], below.limits.torque)
    assert above.mass == pytest.approx(below.mass, abs=1e-9)
    assert above.legs.reach == pytest.approx(below.legs.reach, abs=1e-12)


def test_arms_that_differ_a_little_are_averaged():
    uneven = read(edits(WAISTED, scale_mass("left_arm_2", 1.02)), moving=("arms",))
    assert "links moved by 'right_arm_joint_2' and 'left_arm_joint_2': averaged left" in said(
        uneven, "symmetry"
    )
    assert "10 g in mass" in said(uneven, "symmetry")
    masses = {
        str(name): float(uneven.model.inertias[j].mass)
        for j, name in enumerate(uneven.model.names)
        if str(name).endswith("arm_joint_2")
    }
    assert list(masses.values()) == pytest.approx([0.505, 0.505], abs=1e-12)


@pytest.mark.parametrize(("shift", "accepted"), [(0.02, True), (0.06, False)])
def test_hands_count_by_what_the_arm_moves(shift, accepted):
    """A hand 2 cm longer is 7 % of what the wrist moves, and less than 2 % of what the arm does."""

    def longer(root):
        link(root, "left_arm_3").find("inertial/origin").set("xyz", f"0 0 {-0.1 - shift}")

    edit = edits(add_arms(4, step=-0.2), longer)
    if accepted:
        told = said(read(edit, moving=("arms",)), "symmetry")
        assert f"{1e3 * shift:g} mm in centre of mass" in told
    else:
        with pytest.raises(RobotError, match="links moved by 'right_arm_joint_3' and 'left_arm"):
            read(edit, moving=("arms",))


@pytest.mark.parametrize(
    ("edit", "moving", "message"),
    [
        (
            WAISTED,
            ("tail*",),
            r"no joint beside the legs' is meant by 'tail\*'; give arms, waist",
        ),
        (WAISTED, ("left_knee",), "no joint beside the legs' is meant by 'left_knee'"),
        (fixed(), ("arms",), "is meant by 'arms'; .*; the joints are: none"),
    ],
)
def test_what_cannot_move_is_refused(edit, moving, message):
    with pytest.raises(RobotError, match=message):
        read(edit, moving=moving)


def test_one_arm_alone_cannot_move():
    def one(root):
        add_link(root, "arm", 0.5)
        add_joint(root, "arm", "torso", "arm", xyz="0 0.25 0.4", axis="1 0 0")

    with pytest.raises(RobotError, match="joint 'arm' cannot be moved: no joint mirrors it"):
        read(one, moving=("arm",))
