"""What a file says is one thing, how it says it another: the same robot walks the same."""

import functools

import numpy as np
import pinocchio as pin
import pytest
from example_robots import example_robot, needs_example_robots
from humanoids import add_joint, add_link
from mjcf_rewritings import REWRITINGS as MJCF_REWRITINGS
from mjcf_rewritings import rewritten as rewritten_mjcf
from places import CASES
from reference_cases import biped
from tied_bipeds import tied
from urdf_edits import edited_urdf
from urdf_rewritings import REWRITINGS, rewritten

from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.importers.pinocchio_model import rigid_body
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot
from gaitopt.model.symmetry import mirrored


def facts(robot):
    """What does not depend on names, signs of axes and the order of joints."""
    problem = WalkProblem(robot, preset_task("humanoid", robot))
    x = first_guess(problem)
    step = problem.whole(x)
    values = problem.values(x)
    rows = problem.rows
    outside = np.maximum(rows.lower - values.rows, values.rows - rows.upper)
    return np.concatenate(
        [
            [robot.mass, robot.legs.reach, robot.legs.bound, abs(robot.legs.stance_width)],
            [robot.sole.toe, robot.sole.heel, robot.sole.width, problem.task.duration],
            np.sort(robot.limits.torque), np.sort(robot.limits.speed),
            np.sort(robot.limits.upper - robot.limits.lower),
            [values.cost / 1e4, len(rows.lower)],
            np.sort(np.abs(step.read(quantities.TORQUE)).max(axis=0)) / 100.0,
            np.sort(np.maximum(outside, 0.0))[-50:],
        ]
    )  # fmt: skip


@functools.cache
def of_biped():
    return facts(biped())


@pytest.mark.parametrize("how", REWRITINGS)
def test_the_biped_is_the_same_however_it_is_written(how):
    found = facts(Robot.from_urdf(rewritten(biped().urdf, how, seed=1)))
    np.testing.assert_allclose(found, of_biped(), rtol=1e-8, atol=1e-8)


@functools.cache
def of_mjcf(name):
    return facts(Robot.from_urdf(CASES / f"{name}.xml"))


@pytest.mark.parametrize("name", ["mjcf_damping_stiffness", "mjcf_joint_ref"])
@pytest.mark.parametrize("how", MJCF_REWRITINGS)
def test_an_mjcf_robot_is_the_same_however_it_is_written(how, name):
    robot = Robot.from_urdf(rewritten_mjcf(CASES / f"{name}.xml", how, seed=1))
    np.testing.assert_allclose(facts(robot), of_mjcf(name), rtol=1e-8, atol=1e-8)


@needs_example_robots
@pytest.mark.parametrize("how", ["all at once", "mirrored", "y up", "numbered", "welded to world"])
def test_a_real_robot_is_the_same_however_it_is_written(how):
    path = example_robot("alexander_description/urdf/alexander_v1.lowerBodyOnly.urdf")
    robot = Robot.from_urdf(path)
    choices = ImportOptions(package_dirs=robot.choices.package_dirs)
    other = Robot.from_urdf(rewritten(path.read_text(), how, seed=2), choices=choices)
    np.testing.assert_allclose(facts(other), facts(robot), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("height", [-0.9, 0.0, 0.9, 30.0])
def test_a_spine_is_no_foot_wherever_the_root_is(height):
    """Nothing tells where on its axis a joint is that stands alone; the root's origin does not."""

    def edit(root):
        add_link(root, "chest", 3.0)
        add_joint(root, "spine", "torso", "chest", xyz="0 0 0.4", axis="0 0 1")
        add_link(root, "world_link", 0.0)
        add_joint(root, "weld", "world_link", "torso", xyz=f"0 0 {height}", kind="fixed")

    robot = Robot.from_urdf(edited_urdf(edit))
    assert len(robot.joint_names) == 12
    assert robot.legs.reach == pytest.approx(biped().legs.reach)


@pytest.mark.parametrize("how", ["axes reversed", "mirrored", "all at once"])
def test_followers_follow_however_they_are_written(how):
    """As NAO's hips, whose yaw joints are one motor."""
    robot = tied("NAO's hips")
    other = Robot.from_urdf(rewritten(robot.urdf, how, seed=4), sole=robot.sole)
    np.testing.assert_allclose(facts(other), facts(robot), rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("seed", range(20))
def test_rods_have_mirror_images(seed):
    """Their least moment of inertia is zero, or what rounding leaves of it."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    tensor = np.eye(3) - np.outer(axis, axis)
    tensor -= 1e-15 * np.outer(axis, axis)
    rod = rigid_body(2.0, rng.normal(size=3), tensor)
    placement = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
    back = placement.actInv(mirrored(mirrored(placement.act(rod))))
    np.testing.assert_allclose(back.inertia, tensor, atol=1e-12)
    np.testing.assert_allclose(back.lever, rod.lever, atol=1e-12)
