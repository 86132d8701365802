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
