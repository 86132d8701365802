from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from sample_gait import sample_gait

from gaitopt.view.animation import frames
from gaitopt.view.robot_shapes import robot_shapes
from gaitopt.view.stick_figures import stick_figures, trunk_top

BARE = replace(
    sample_gait(),
    urdf=sample_gait().urdf.replace("<visual>", "<!--").replace("</visual>", "-->"),
)


def test_the_sole_is_that_of_the_swing_foot():
    corners = sample_gait().trajectory.body.sole_corners[0]
    expected = [[0, 0.068, 0], [0, -0.068, 0], [-0.214, 0.068, 0], [-0.214, -0.068, 0]]
    assert corners == pytest.approx(np.array(expected, dtype=float), abs=1e-12)


def test_bones_keep_their_lengths_while_the_robot_walks():
    gait = sample_gait()
    body = gait.trajectory.body
    sticks = stick_figures(body, frames(gait, 2).configuration, trunk_top(gait))
    lengths = np.linalg.norm(np.diff(sticks.legs, axis=2), axis=3)
    # ankle roll to ankle pitch, shin, thigh, and the three hip axes meet in a point
    assert lengths == pytest.approx(np.broadcast_to([0, 0.3, 0.3, 0, 0], (62, 2, 5)), abs=1e-12)
    hips = np.linalg.norm(sticks.legs[:, 0, 5] - sticks.legs[:, 1, 5], axis=1)
    assert hips == pytest.approx(np.full(62, 0.12), abs=1e-12)
    assert sticks.soles[:31, 1] == pytest.approx(gait.swing_sole, abs=1e-12)


def test_the_trunk_ends_where_the_drawing_does():
    gait = sample_gait()
    assert trunk_top(gait) == pytest.approx([0.0, 0.0, 0.595], abs=5e-3)


def test_without_drawing_the_trunk_is_in_proportion_to_the_legs():
    assert trunk_top(BARE) == pytest.approx([0.0, 0.0, 0.54])


def test_a_robot_without_drawing_gets_a_skeleton():
    bones = robot_shapes(BARE)
    # shin, thigh, foot and what joins it to the ankle of two legs, pelvis and trunk
    assert len(bones.shapes) == 10
    assert 0 in bones.carriers
    assert len(robot_shapes(sample_gait()).shapes) > 10


def test_a_skeleton_is_where_the_joints_are():
    """Ends of its bars, by Pinocchio's own kinematics of the file."""
    body = BARE.trajectory.body
    sample = frames(BARE, 1)
    places = body.placements(sample.configuration[7:8])[0]
    sticks = stick_figures(body, sample.configuration[7:8], trunk_top(BARE))
    ends = []
    for carrier, item, inside in robot_shapes(BARE).shapes:
        if item.name.startswith("bone"):
            at = pin.SE3(places[carrier]) * inside
            half = np.array([0.0, 0.0, item.geometry.halfLength])
            ends += [at.act(half), at.act(-half)]
    for points in (sticks.legs[0, 0], sticks.legs[0, 1], sticks.trunk[0]):
        for point in points:
            assert min(np.linalg.norm(np.array(ends) - point, axis=1)) < 1e-9
