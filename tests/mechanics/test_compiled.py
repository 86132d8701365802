"""What is compiled against the plain path, which Newton-Euler, MuJoCo and differences check."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from changed_robots import changed
from synthetic_bipeds import SYNTHETIC, synthetic

from gaitopt.mechanics import compiled
from gaitopt.mechanics.capsule_distance import nearest
from gaitopt.mechanics.forward_kinematics import ForwardKinematics
from gaitopt.mechanics.single_support import by_pinocchio
from gaitopt.model.robot import Robot

ROBOTS = ("biped", "on a slope, with rotors", *SYNTHETIC)
COUNTS = (1, 2, 3, 4, 5, 31)  # four instants are computed together
DOWN = (0.48, -0.36, -0.8)
CLOSE = 1e-13  # of the largest entry


@pytest.fixture(params=ROBOTS)
def any_robot(request, robot):
    if request.param in SYNTHETIC:
        return synthetic(request.param)
    if request.param == "biped":
        return robot
    rotors = changed(robot, {"armature": np.linspace(0.01, 0.2, robot.tree.size)}, 1.0)
    return rotors.on_ground(DOWN)


def random_motion(robot: Robot, count: int, seed: int = 0) -> np.ndarray:
    """Return q, dq, ddq, shape (3, N, n)."""
    size = np.array([1.0, 4.0, 30.0])[:, None, None]
    return size * np.random.default_rng(seed).normal(size=(3, count, robot.tree.size))


def check(found, expected) -> None:
    for one, other in zip(found, expected, strict=True):
        assert one.shape == other.shape
        assert np.abs(one - other).max(initial=0.0) <= CLOSE * np.abs(other).max(initial=0.0)


def test_kernels_are_built_where_there_is_a_compiler():
    assert compiled.BUILT or not (shutil.which("g++") or shutil.which("clang++"))


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("derivatives", [False, True])
def test_inverse_dynamics(any_robot, count, derivatives):
    motion = random_motion(any_robot, count)
    found = compiled.bodies_of(any_robot).inverse_dynamics(*motion, derivatives)
    check(found, by_pinocchio(any_robot, motion, derivatives))


def test_tables_of_other_shapes_are_refused(robot):
    motion = random_motion(robot, 3)
    with pytest.raises(ValueError, match=r"dq must have shape \(3, 12, \)"):
        compiled.bodies_of(robot).inverse_dynamics(motion[0], motion[1, :2], motion[2], True)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_stays_so(robot, value):
    motion = random_motion(robot, 5)
    motion[0, 2, 3] = value
    effort, *_ = compiled.bodies_of(robot).inverse_dynamics(*motion, False)
    assert not np.isfinite(effort[2]).any()
    assert np.isfinite(effort[[0, 1, 3, 4]]).all()


@pytest.mark.parametrize("asked", ["0", "1"])
def test_the_plain_path_can_be_asked_for(asked):
    say = "from gaitopt.mechanics import compiled; print(compiled.in_use() == compiled.BUILT)"
    done = subprocess.run(
        [sys.executable, "-c", say],
        env={**os.environ, "GAITOPT_COMPILED": asked},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == str(asked == "1" or not compiled.BUILT)


@pytest.mark.parametrize("count", COUNTS)
def test_forward_kinematics(any_robot, count):
    q = random_motion(any_robot, count)[0]
    found = compiled.bodies_of(any_robot).placed(q)
    check([found], [ForwardKinematics(any_robot.model).placed(q).frames])


def segments_at(rng) -> tuple[np.ndarray, np.ndarray]:
    """Segments of any kind, their ends (c, 2, 3): also points, and two that are parallel."""
    ends = rng.normal(size=(9, 2, 3))
    ends[3, 1], ends[4, 1] = ends[3, 0], ends[4, 0]  # points
    ends[6] = ends[5] + 0.3
    ends[8] = ends[7][::-1] * 0.5
    return ends, np.array([*np.ndindex(9, 9)]).T


@pytest.mark.parametrize("count", COUNTS)
def test_nearest_points_of_segments(rng, count):
    ends, sides = segments_at(rng)
    frames = ForwardKinematics(synthetic("five").model).placed(rng.normal(size=(count, 10))).frames
    carriers = np.array([0, 2, 5, 7, 10, 3, 3, 4, 4])  # those that are parallel stay so
    world = np.einsum("cnij,cej->cnei", frames[carriers][:, :, :3, :3], ends)
    world += frames[carriers][:, :, None, :3, 3]
    first, second = (world[side].reshape(-1, 2, 3) for side in sides)
    along = ends[:, 1] - ends[:, 0]
    expected = nearest(first, second)
    found = compiled.kernels.nearest(
        frames, carriers, np.concatenate([ends[:, 0], along], axis=1), sides,
        (along**2).sum(axis=1)[sides],
    )  # fmt: skip
    s, t = expected.share
    check([found[11:]], [expected.between.T])  # of parallel ones the nearest points are rounding
    apart = np.abs(found[6:8] - np.stack([s, t])).max(axis=0) > 1e-9
    p, q = expected.along
    sine = np.linalg.norm(np.cross(p, q), axis=1)
    assert not apart[sine > 1e-6].any()


@pytest.mark.parametrize(
    ("carriers", "sides", "said"),
    [([11], [[0], [0]], "carriers must be from 0 to 10"), ([0], [[0], [1]], "sides must be")],
)
def test_numbers_of_nothing_are_refused(carriers, sides, said):
    frames = ForwardKinematics(synthetic("five").model).placed(np.zeros((2, 10))).frames
    with pytest.raises(ValueError, match=said):
        compiled.kernels.nearest(frames, carriers, np.ones((1, 6)), sides, np.ones((2, 1)))
