"""Robots of other makers as they are drawn: whole bodies, feet flat, arms where they are locked."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from example_robots import DIRECTORY, needs_example_robots

from gaitopt.catalogue.entries import robot_by_name
from gaitopt.design.audit import robot_of
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import humanoid_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.view.body import upward, walking_model
from gaitopt.view.page import page_text
from gaitopt.view.scene import hip_height
from gaitopt.view.shapes import robot_shapes
from gaitopt.view.skeleton import sole_corners, stick_figures, trunk_top
from gaitopt.view.walk import walk

pytestmark = needs_example_robots

_GAITS = {}


def gait_of(name):
    """A guessed walk: what is drawn does not depend on its being optimal."""
    if name not in _GAITS:
        robot = robot_by_name(name)
        problem = WalkProblem(robot, humanoid_task(robot, leg_gap=None))
        _GAITS[name] = gait_at(problem, first_guess(problem), {})
    return _GAITS[name]


names = pytest.mark.parametrize("name", ["g1", "talos", "icub", "human"])


@names
def test_the_text_alone_gives_the_same_robot(name):
    robot, again = robot_by_name(name), robot_of(gait_of(name))
    assert again.joint_names == robot.joint_names
    assert again.sole == robot.sole
    assert again.legs.reach == pytest.approx(robot.legs.reach, rel=1e-12)
    assert again.mass == pytest.approx(robot.mass, rel=1e-12)
    for mine, its in zip(again.model.inertias, robot.model.inertias, strict=True):
        assert mine.isApprox(its, 1e-9)


@names
def test_the_drawn_robot_stands_on_flat_soles(name):
    gait = gait_of(name)
    model = walking_model(gait)
    film = walk(gait, model, 2)
    data = model.createData()
    for k in (0, len(gait.time) - 1):  # both feet on the ground
        pin.framesForwardKinematics(model, data, film.q[k])
        for sole in (gait.stance_sole, gait.swing_sole_frame):
            place = data.oMf[model.getFrameId(sole)]
            assert place.translation[2] == pytest.approx(0.0, abs=1e-4)
            assert place.rotation == pytest.approx(np.eye(3), abs=1e-3)
    sole = robot_by_name(name).sole
    assert np.ptp(sole_corners(gait, model), axis=0) == pytest.approx(
        [sole.toe - sole.heel, sole.left - sole.right, 0.0], abs=1e-4
    )


@names
def test_the_drawn_robot_stands_upright(name):
    gait = gait_of(name)
    model = walking_model(gait)
    film = walk(gait, model, 1)
    sticks = stick_figures(gait, model, film.q[:1])
    lean = sticks.trunk[0, 1] - sticks.trunk[0, 0]
    assert lean[2] > 0.95 * np.linalg.norm(lean) > 0.0
    assert lean[2] > 0.25 * hip_height(gait, model, film)
    assert float(upward(gait) @ trunk_top(gait, model)) > 0.0


def test_arms_stay_where_they_are_locked():
    gait = gait_of("talos")
    model = walking_model(gait)
    at = model.joints[model.getJointId("arm_left_4_joint")].idx_q
    assert walk(gait, model, 1).q[:, at] == pytest.approx(-0.525366)


def test_meshes_are_drawn_where_they_are_and_bones_where_not():
    gait = gait_of("alexander")
    model = walking_model(gait)
    found = robot_shapes(gait, model)  # the gait records where they are
    assert found.note == ""
    assert found.geometry.ngeoms == 14
    choices = {k: v for k, v in gait.fact("choices").items() if k != "package_dirs"}
    lost = replace(gait, meta={**gait.meta, "choices": choices})
    bones = robot_shapes(lost, model)
    assert "are not drawn; give the directory that holds its package" in bones.note
    assert "The robot is drawn as a skeleton" in page_text(lost, steps=1)
    assert robot_shapes(lost, model, (str(_share()),)).geometry.ngeoms == 14


def _share() -> Path:
    return Path(str(DIRECTORY)).parents[1]
