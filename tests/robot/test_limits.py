import sys

import numpy as np
import pytest
from humanoids import edits
from places import CASES
from similar_robots import Units, similar_urdf
from urdf_edits import edited_urdf, joint, set_limit

from gaitopt.errors import RobotError
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot


def both(joint: str, **values: float):
    return edits(*(set_limit(f"{side}_{joint}", **values) for side in ("left", "right")))


def rows(robot: Robot, joint: str) -> list[int]:
    return [robot.joint_names.index(f"{side}_{joint}") for side in ("right", "left")]


def said(robot: Robot) -> list[str]:
    return [f"{f.how}: {f.subject}: {f.text}" for f in robot.findings if f.topic == "limits"]


@pytest.mark.parametrize(
    ("field", "key", "value", "unit"),
    [
        ("torque", "effort", 0.0, "N·m"),
        ("torque", "effort", 1e6, "N·m"),
        ("speed", "velocity", 0.0, "rad/s"),
        ("speed", "velocity", 100.0, "rad/s"),
    ],
)
def test_placeholders_are_no_limits(robot, field, key, value, unit):
    free = Robot.from_urdf(edited_urdf(both("knee", **{key: value})))
    limits = getattr(free.limits, field)
    assert np.flatnonzero(np.isinf(limits)).tolist() == sorted(rows(free, "knee"))
    others = ~np.isinf(limits)
    np.testing.assert_array_equal(limits[others], getattr(robot.limits, field)[others])
    text = f"{field} limit {value:g} {unit} is a placeholder: taken as no limit"
    assert said(free) == [f"warning: right_knee, left_knee: {text}"]


@pytest.mark.parametrize(("torque", "limit"), [(20e3, 20e3), (1e6, np.inf)])
def test_motors_of_giants_are_no_placeholders(torque, limit):
    """A biped three times as long turns its joints with 81 times the torque of its model."""
    units = Units(length=3.0, mass=27.0)
    giant = Robot.from_urdf(similar_urdf(edited_urdf(both("knee", effort=torque / 81.0)), units))
    knees = giant.limits.torque[rows(giant, "knee")]
    np.testing.assert_allclose(knees, limit)


def test_limits_that_are_given_are_not_asked_for():
    text = edited_urdf(both("knee", effort=0.0, velocity=0.0))
    asked = [f.text for f in Robot.from_urdf(text).findings if "give it" in f.text]
    assert [("effort" in one, "velocity" in one) for one in asked] == [
        (True, False),
        (False, True),
    ] * 2
    given = LimitOverride("*knee", torque=100.0)
    left = Robot.from_urdf(text, choices=ImportOptions(limits=(given,))).findings
    assert [f.text for f in left if "give it" in f.text] == [asked[1], asked[3]]


def test_a_joint_without_limits_has_none_in_words():
    def edit(root):
        for side in ("left", "right"):
            moved = joint(root, f"{side}_hip_yaw")
            moved.set("type", "continuous")
            moved.remove(moved.find("limit"))

    free = Robot.from_urdf(edited_urdf(edit))
    names = "right_hip_yaw, left_hip_yaw"
    assert f"warning: {names}: the file gives no torque limit" in said(free)
    assert f"warning: {names}: the file gives no speed limit" in said(free)
    assert not any("placeholder" in line for line in said(free))


@pytest.mark.parametrize("end", [10.0, 1e16, sys.float_info.max])
def test_a_range_beyond_full_turns_is_none(robot, end):
    free = Robot.from_urdf(edited_urdf(both("hip_yaw", lower=-end, upper=end)))
    for row in rows(free, "hip_yaw"):
        assert (free.limits.lower[row], free.limits.upper[row]) == (-np.inf, np.inf)
    assert np.isfinite(free.limits.lower).sum() == 10
    assert free.legs.reach == robot.legs.reach


@pytest.mark.parametrize("end", [np.inf, -np.inf])
def test_a_range_of_one_infinite_end_alone_is_refused(end):
    with pytest.raises(RobotError, match="lower must be below upper"):
        Robot.from_urdf(edited_urdf(both("hip_yaw", lower=end, upper=end)))


def test_a_knee_without_a_range_bends_backwards(robot):
    free = Robot.from_urdf(edited_urdf(both("knee", lower=-9.0, upper=9.0)))
    np.testing.assert_array_equal(free.legs.flexion, robot.legs.flexion)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (set_limit("left_knee", effort=140.0), "torque limits of 'right_knee' and 'left_knee', "
         r"150 and 140 N·m; .* unequal_limits = \"tighter"),
        (set_limit("left_knee", velocity=0.0), "speed limits of .*, 10 and none rad/s"),
        (set_limit("left_hip_roll", upper=0.5), r"ranges of 'right_hip_roll' and 'left_hip_roll', "
         r"-0.8 to 0.8 rad and -0.5 to 0.8 rad \(mirrored\)"),
    ],
)  # fmt: skip
def test_legs_of_different_strength_are_refused(edit, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(edited_urdf(edit))


def test_all_limits_that_differ_are_told_at_once_and_either_choice_settles_them():
    edit = edits(
        set_limit("left_knee", effort=140.0),
        set_limit("left_hip_yaw", effort=30.0, velocity=3.0),
        set_limit("left_hip_roll", upper=0.5),
    )
    with pytest.raises(RobotError) as refused:
        Robot.from_urdf(edited_urdf(edit))
    told = str(refused.value)
    for fact in ("150 and 140 N·m", "and 30 N·m", "and 3 rad/s", "-0.8 to 0.8 rad and -0.5 to 0.8"):
        assert fact in told
    for offered in ("tighter", "right", "left"):
        assert f'"{offered}"' in told
        Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits=offered))


@pytest.mark.parametrize(
    ("field", "key", "values"),
    [
        ("speed", "velocity", (18.54, 18.53)),
        ("torque", "effort", (3.0226, 3.023)),
        ("torque", "effort", (150.0, 147.01)),
    ],
)
def test_limits_that_differ_by_rounding_are_tightened_and_told(field, key, values):
    edit = edits(
        set_limit("left_knee", **{key: values[0]}), set_limit("right_knee", **{key: values[1]})
    )
    robot = Robot.from_urdf(edited_urdf(edit))
    assert getattr(robot.limits, field)[rows(robot, "knee")].tolist() == [min(values)] * 2
    (line,) = said(robot)
    assert line.startswith("changed: right_knee, left_knee: ")
    assert f"{field} limits {values[1]:g} and {values[0]:g} " in line
    assert line.endswith("differ: tighter")


@pytest.mark.parametrize("unit", [1.0, -1.0])
def test_flipped_ranges_are_a_fault_of_the_file_and_tighter_comes_last(unit):
    lower, upper = sorted((unit * -0.09, unit * 2.3))
    edit = edits(
        set_limit("left_knee", lower=lower, upper=upper),
        set_limit("right_knee", lower=-upper, upper=-lower),
        set_limit("left_hip_pitch", lower=-1.8, upper=0.7),
        set_limit("right_hip_pitch", lower=-0.7, upper=1.8),
    )
    with pytest.raises(RobotError) as refused:
        Robot.from_urdf(edited_urdf(edit))
    told = str(refused.value)
    assert "the file is broken" in told
    assert told.count("alike when one of the two is turned round") == 2
    assert told.index('"right" or "left"') < told.index('"tighter" leaves only')
    Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits="tighter"))
    for offered in ("right", "left"):
        assert f'"{offered}"' in told
        robot = Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits=offered))
        assert np.ptp([robot.limits.lower[2], robot.limits.upper[2]]) == pytest.approx(2.39)


@pytest.mark.parametrize(
    ("unequal", "torque", "left_range"),
    [("tighter", 140.0, (-0.6, 0.5)), ("right", 150.0, (-0.6, 0.7)), ("left", 140.0, (-0.8, 0.5))],
)
def test_what_differs_is_settled_as_chosen(unequal, torque, left_range):
    edit = edits(
        set_limit("left_knee", effort=140.0),
        set_limit("left_hip_roll", upper=0.5),
        set_limit("right_hip_roll", lower=-0.7, upper=0.6),
    )
    for stance in ("right", "left"):
        choices = ImportOptions(unequal_limits=unequal, stance=stance)
        robot = Robot.from_urdf(edited_urdf(edit), choices=choices)
        knees, hips = rows(robot, "knee"), rows(robot, "hip_roll")
        assert robot.limits.torque[knees].tolist() == [torque, torque]
        lower, upper = robot.limits.lower[hips], robot.limits.upper[hips]
        # Rolls mirror with opposite signs.
        assert (lower[1], upper[1]) == left_range
        assert (-upper[0], -lower[0]) == left_range
        assert len(said(robot)) == 2
        assert all(line.startswith("changed: ") for line in said(robot))


def test_ranges_without_a_common_part_are_refused():
    edit = edits(
        set_limit("left_knee", lower=0.0, upper=1.0), set_limit("right_knee", lower=1.2, upper=2.0)
    )
    for unequal in ("refuse", "tighter"):
        with pytest.raises(RobotError, match=r"'right_knee' and 'left_knee', 1\.2 to") as refused:
            Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits=unequal))
        assert "which have nothing in common" in str(refused.value)
        assert "tighter" not in str(refused.value)
    for unequal in ("right", "left"):
        Robot.from_urdf(edited_urdf(edit), choices=ImportOptions(unequal_limits=unequal))


def test_rounded_ranges_are_tightened(robot):
    rounded = Robot.from_urdf(edited_urdf(set_limit("left_hip_roll", upper=0.797)))
    hips = rows(rounded, "hip_roll")
    assert rounded.limits.upper[hips[1]] == 0.797
    assert rounded.limits.lower[hips[0]] == -0.797
    assert "taken as -0.797 to 0.8 rad" in said(rounded)[0]


def test_overrides_replace_limits_by_pattern(robot):
    limits = (
        LimitOverride("*_ankle_*", torque=60.0, speed=np.inf, armature=0.02),
        LimitOverride("*_ankle_roll", torque=33.0),
        LimitOverride("*_knee", lower=0.1, upper=1.9),
    )
    changed = Robot.from_urdf(robot.urdf, choices=ImportOptions(limits=limits))
    pitch, roll, knee = (rows(changed, j) for j in ("ankle_pitch", "ankle_roll", "knee"))
    assert changed.limits.torque[pitch + roll].tolist() == [60.0, 60.0, 33.0, 33.0]
    assert np.isinf(changed.limits.speed[pitch + roll]).all()
    assert changed.limits.lower[knee].tolist() == [0.1, 0.1]
    assert changed.limits.upper[knee].tolist() == [1.9, 1.9]
    expected = np.zeros(18)
    expected[[6 + r for r in pitch + roll]] = 0.02
    np.testing.assert_array_equal(changed.model.armature, expected)
    assert "given: *_ankle_roll: torque 33 N·m (2 joints)" in said(changed)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ([LimitOverride("*knee*", lower=5.0)], "with the lower given there, the range of joint "
         r"'left_knee' is from lower = 5 rad to upper = 2\.6 rad; lower must be below upper"),
        ([LimitOverride("*", lower=0.5), LimitOverride("*_knee", upper=0.3)],
         r"limits of '\*': .* 'left_knee' is from lower = 0\.5 rad to upper = 0\.3 rad"),
    ],
)  # fmt: skip
def test_an_end_beyond_the_other_of_the_file_is_refused(robot, overrides, message):
    with pytest.raises(RobotError, match=message):
        Robot.from_urdf(robot.urdf, choices=ImportOptions(limits=overrides))


def test_only_the_last_of_many_overrides_counts(robot):
    overrides = (LimitOverride("*knee", lower=5.0), LimitOverride("*knee", lower=0.3))
    changed = Robot.from_urdf(robot.urdf, choices=ImportOptions(limits=overrides))
    assert changed.limits.lower[rows(changed, "knee")].tolist() == [0.3, 0.3]


def test_ranges_in_degrees_are_told():
    turned = {"hip_yaw": (-60, 40), "hip_roll": (-45, 35), "hip_pitch": (-120, 30)}
    turned |= {"knee": (-5, 150), "ankle_pitch": (-50, 30), "ankle_roll": (-20, 20)}
    mirrored = ("hip_yaw", "hip_roll", "ankle_roll")

    def edit(root):
        for name, (lower, upper) in turned.items():
            set_limit(f"left_{name}", lower=lower, upper=upper)(root)
            ends = (-upper, -lower) if name in mirrored else (lower, upper)
            set_limit(f"right_{name}", lower=ends[0], upper=ends[1])(root)

    told = [line for line in said(Robot.from_urdf(edited_urdf(edit))) if "degrees" in line]
    text = "-20 to 20 rad, are more than a turn; are ranges of the file in degrees?"
    assert len(told) == 1
    assert told[0].startswith("warning: 12 joints: ranges as that of 'right_ankle_roll', ")
    assert text in told[0]


def test_ranges_in_radians_of_a_file_in_degrees_are_told():
    """The commonest slip in MJCF: without <compiler angle="radian"/> all angles are degrees."""
    text = (CASES / "base_mini.xml").read_text()
    told = said(Robot.from_urdf(text.replace('angle="radian"', 'angle="degree"')))
    (line,) = [one for one in told if "no leg walks with that" in one]
    assert line.startswith(
        "warning: 12 joints: the widest of the ranges, that of 'right_hip_pitch'"
    )
    assert "0.0419 rad or 2.4 degrees" in line
    assert not any("no leg walks" in one for one in said(Robot.from_urdf(text)))


def test_a_pattern_without_a_joint_is_refused(robot):
    choices = ImportOptions(limits=(LimitOverride("*_nee", torque=1.0),))
    with pytest.raises(RobotError, match=r"no joint matches '\*_nee'; the joints are: left_"):
        Robot.from_urdf(robot.urdf, choices=choices)


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_lower_and_higher_limits_than_the_files_can_be_chosen(robot, share):
    chosen = LimitOverride(
        "*knee*", torque=share * robot.limits.torque[2], speed=share * robot.limits.speed[2]
    )
    again = Robot.from_urdf(robot.urdf, choices=ImportOptions(limits=(chosen,)))
    for kind in ("torque", "speed"):
        ratio = getattr(again.limits, kind) / getattr(robot.limits, kind)
        assert ratio[list(robot.legs.knees)] == pytest.approx(share)
        assert sorted(ratio)[5] == pytest.approx(1.0)
