"""Robots of other joints than two legs of six walk: designed, certified, stored, checked again."""

import numpy as np
import pytest
from synthetic_bipeds import SOLE, synthetic
from urdf_edits import add_arm, edited_urdf

from gaitopt.design.audit import audit
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.result import robot_of
from gaitopt.model.robot import Robot
from gaitopt.nlp import Status


@pytest.mark.parametrize("name", ["five and arms", "seven, torso first"])
def test_it_walks_and_its_file_is_checked(name, tmp_path):
    robot = synthetic(name)
    found = design(robot, preset_task(boundary="lifted", speed=0.5, duration=0.5))
    assert found.certificate.certified
    gait = found.gait
    assert gait.q.shape == (31, robot.tree.size)
    others = slice(robot.tree.legs.stop, None)
    assert np.ptp(gait.q[:, others], axis=0).max() > 0.05  # arms swing
    save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(tmp_path / "gait.npz")
    assert robot_of(again).joint_names == robot.joint_names
    judged = audit(again)
    assert not judged.altered
    assert judged.certificate.certified


def test_a_gait_remembers_joints_beside_detected_legs():
    robot = Robot.from_urdf(edited_urdf(add_arm), moving=("shoulder",))
    problem = WalkProblem(robot, preset_task(boundary="lifted"))
    again = robot_of(gait_at(problem, first_guess(problem), {}))
    assert again.joint_names == robot.joint_names
    np.testing.assert_array_equal(again.mirror, robot.mirror)


def test_arms_that_move_save_cost():
    """From the walk with arms locked, although the torques of the arms count too."""
    free = synthetic("five and arms")
    locked = Robot.from_urdf(free.urdf, stance_sole="right_sole", swing_sole="left_sole", sole=SOLE)
    task = preset_task(boundary="lifted", speed=0.5, duration=0.5, samples=15)
    options = DesignOptions(refine=False)
    still = design(locked, task, options)
    problem = WalkProblem(free, task)
    start, at = first_guess(problem), {name: k for k, name in enumerate(problem.layout.names)}
    start[[at[name] for name in still.problem.layout.names]] = still.solution.x
    swinging = design(free, task, options, start=start)
    assert swinging.solution.status is Status.OPTIMAL
    assert swinging.gait.cost < still.gait.cost
