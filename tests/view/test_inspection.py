import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gaitopt import biped13, urdf_text
from gaitopt.design.summary import brace, shared_name
from gaitopt.model.import_options import ImportOptions
from gaitopt.view.inspection import axis_words, inspect_robot, inspection_tables
from gaitopt.view.inspection_page import inspection_text


@pytest.mark.parametrize(
    ("pair", "expected"),
    [
        (("left_knee", "right_knee"), "{left,right}_knee"),
        (("LHipYaw", "RHipYaw"), "{L,R}HipYaw"),
        (("leg_left_1_joint", "leg_right_1_joint"), "leg_{left,right}_1_joint"),
        (("knee", "other_knee"), "knee, other_knee"),
    ],
)
def test_pairs_are_written_as_a_shell_would(pair, expected):
    assert brace(*pair) == expected


@pytest.mark.parametrize(
    ("pair", "expected"),
    [
        (("left_hip_yaw_joint", "right_hip_yaw_joint"), "hip yaw"),
        (("LHipYaw", "RHipYaw"), "HipYaw"),
        (("LeftKnee", "RightKnee"), "Knee"),
        (("hip_pitch_l", "hip_pitch_r"), "hip pitch"),
        (("leg_left_1_joint", "leg_right_1_joint"), "leg 1"),
        (("knee", "other_knee"), "knee"),
        (("j12", "j27"), ""),
    ],
)
def test_pairs_are_named_by_what_both_share(pair, expected):
    assert shared_name(*pair) == shared_name(*reversed(pair)) == expected


@given(st.floats(0.0, 40.0), st.sampled_from([0, 1, 2]), st.sampled_from([-1.0, 1.0]))
@settings(derandomize=True, deadline=None, max_examples=50)
def test_tilted_axes_are_named_with_their_tilt(tilt, near, sign):
    axis = np.zeros(3)
    axis[near], axis[(near + 1) % 3] = np.cos(np.radians(tilt)), np.sin(np.radians(tilt))
    words = axis_words(sign * axis).split()
    assert words[0] == f"{'+' if sign > 0.0 else '-'}{'xyz'[near]}"
    shown = float(words[1].removesuffix("°")) if len(words) > 1 else 0.0
    assert shown == pytest.approx(tilt, abs=0.51)


def test_an_inspection_keeps_what_it_reached():
    found = inspect_robot(urdf_text(biped13()), ImportOptions())
    assert (found.refusal, found.title) == ("", "biped13")
    assert [s.title for s in inspection_tables(found)][:2] == [
        "Robot", "Joints; axis and range of the right leg"
    ]  # fmt: skip
    broken = inspect_robot("<robot", ImportOptions())
    assert broken.source is None
    assert "not well-formed" in broken.refusal
    armless = inspect_robot('<robot name="a"><link name="b"/></robot>', ImportOptions())
    assert armless.robot is None
    assert armless.refusal


def test_a_name_cannot_break_the_page():
    evil = urdf_text(biped13()).replace('name="biped13"', 'name="&lt;script&gt;alert(1)"')
    text = inspection_text(inspect_robot(evil, ImportOptions()))
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text
    assert "@FIT@" not in text
