from dataclasses import replace

import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.view.body import walking_model
from gaitopt.view.shapes import robot_shapes
from gaitopt.view.skeleton import sole_corners, stick_figures, trunk_top
from gaitopt.view.walk import walk

BARE = replace(
    sample_gait(),
    urdf=sample_gait().urdf.replace("<visual>", "<!--").replace("</visual>", "-->"),
)


def test_the_sole_is_recovered_from_the_swing_foot():
    gait = sample_gait()
    corners = sole_corners(gait, walking_model(gait))
    expected = [[0, 0.068, 0], [0, -0.068, 0], [-0.214, 0.068, 0], [-0.214, -0.068, 0]]
    assert corners == pytest.approx(np.array(expected, dtype=float), abs=1e-12)


def test_bones_keep_their_lengths_while_the_robot_walks():
    gait = sample_gait()
    model = walking_model(gait)
    sticks = stick_figures(gait, model, walk(gait, model, 2).q)
    lengths = np.linalg.norm(np.diff(sticks.legs, axis=2), axis=3)
    # ankle roll to ankle pitch, shin, thigh, and the three hip axes meet in a point
    assert lengths == pytest.approx(np.broadcast_to([0, 0.3, 0.3, 0, 0], (62, 2, 5)), abs=1e-12)
    hips = np.linalg.norm(sticks.legs[:, 0, 5] - sticks.legs[:, 1, 5], axis=1)
    assert hips == pytest.approx(np.full(62, 0.12), abs=1e-12)
    assert sticks.soles[:31, 1] == pytest.approx(gait.swing_sole, abs=1e-12)


def test_the_trunk_ends_where_the_drawing_does():
    gait = sample_gait()
    assert trunk_top(gait, walking_model(gait)) == pytest.approx([0.0, 0.0, 0.595], abs=5e-3)


def test_without_drawing_the_trunk_is_in_proportion_to_the_legs():
    assert trunk_top(BARE, walking_model(BARE)) == pytest.approx([0.0, 0.0, 0.54])


def test_a_robot_without_drawing_gets_a_skeleton():
    model = walking_model(BARE)
    bones = robot_shapes(BARE, model).geometry
    # shin, thigh, foot and what joins it to the ankle of two legs, pelvis and trunk
    assert bones.ngeoms == 10
    assert {b.parentJoint for b in bones.geometryObjects} >= {1}
    assert robot_shapes(sample_gait(), walking_model(sample_gait())).geometry.ngeoms > 10
