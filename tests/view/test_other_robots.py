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
from gaitopt.importers.reader import read_source
from gaitopt.view.animation import frames, hip_height
from gaitopt.view.page import page_text
from gaitopt.view.robot_shapes import robot_shapes
from gaitopt.view.stick_figures import at_reference, stick_figures, trunk_top

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
    samples = frames(gait, 2)
    for k in (0, len(gait.time) - 1):  # both feet on the ground
        for place in samples.sole[k]:
            assert place[2, 3] == pytest.approx(0.0, abs=1e-4)
            assert place[:3, :3] == pytest.approx(np.eye(3), abs=1e-3)
    sole = robot_by_name(name).sole
    for corners in gait.trajectory.body.sole_corners:
        assert np.ptp(corners, axis=0) == pytest.approx(
            [sole.toe - sole.heel, sole.left - sole.right, 0.0], abs=1e-12
        )


@names
def test_links_are_drawn_where_the_file_has_them(name):
    """Pinocchio's kinematics of the file, which averaging left and right hardly changes."""
    gait = gait_of(name)
    body, samples = gait.trajectory.body, frames(gait, 1)
    model, data = at_reference(gait, read_source(gait.urdf))
    q = pin.neutral(model)
    q[:7] = samples.configuration[11, :7]
    for joint, angle in zip(body.joint_names, samples.q[11], strict=True):
        q[model.joints[model.getJointId(joint)].idx_q] = angle
    pin.forwardKinematics(model, data, q)
    places = body.placements(samples.configuration[11:12])[0, 1:]
    for joint, place in zip(body.joint_names, places, strict=True):
        drawn = data.oMi[model.getJointId(joint)].homogeneous
        assert place == pytest.approx(drawn, abs=2e-3), joint


@names
def test_the_drawn_robot_stands_upright(name):
    gait = gait_of(name)
    body, samples = gait.trajectory.body, frames(gait, 1)
    sticks = stick_figures(body, samples.configuration[:1], trunk_top(gait))
    lean = sticks.trunk[0, 1] - sticks.trunk[0, 0]
    assert lean[2] > 0.95 * np.linalg.norm(lean) > 0.0
    assert lean[2] > 0.25 * hip_height(body, samples)
    assert float(body.heading[:, 2] @ trunk_top(gait)) > 0.0


def test_arms_stay_where_they_are_locked():
    gait = gait_of("talos")
    arm = gait.trajectory.joint_names.index("arm_left_4_joint")
    assert frames(gait, 1).q[:, arm] == pytest.approx(-0.525366)


def test_meshes_are_drawn_where_they_are_and_bones_where_not():
    gait = gait_of("alexander")
    found = robot_shapes(gait)  # the gait records where they are
    assert found.note == ""
    assert len(found.shapes) == 14
    choices = {k: v for k, v in gait.fact("choices").items() if k != "package_dirs"}
    lost = replace(gait, meta={**gait.meta, "choices": choices})
    bones = robot_shapes(lost)
    assert "are not drawn; give the directory that holds its package" in bones.note
    assert "The robot is drawn as a skeleton" in page_text(lost, steps=1)
    assert len(robot_shapes(lost, (str(_share()),)).shapes) == 14


def _share() -> Path:
    return Path(str(DIRECTORY)).parents[1]
