from concurrent.futures import ThreadPoolExecutor

import numpy as np
from reference_cases import biped

from gaitopt.mechanics.impact import Impact
from gaitopt.mechanics.single_support import SingleSupport
from gaitopt.model.robot import cached_workspace


def test_a_robot_has_one_of_each_kind(robot):
    other = biped("left")
    assert cached_workspace(robot, Impact) is cached_workspace(robot, Impact)
    assert cached_workspace(other, Impact) is not cached_workspace(robot, Impact)
    assert cached_workspace(other, Impact).robot is other


def test_every_thread_has_its_own(robot):
    here = cached_workspace(robot, Impact)
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(cached_workspace, robot, Impact).result() is not here


def test_what_was_returned_outlives_the_next_evaluation(robot):
    """Results are copies: the workspace that made them is used again at once."""
    rng = np.random.default_rng(0)
    one, other = (tuple(rng.normal(0.0, 0.3, (4, 12)) for _ in range(3)) for _ in range(2))
    support = SingleSupport(robot, 4)
    state, slope = support.derivatives(*one)
    values = [a.copy() for a in (state.effort, state.corners, slope.effort, slope.axes)]
    support.derivatives(*other)
    for kept_array, value in zip(
        (state.effort, state.corners, slope.effort, slope.axes), values, strict=True
    ):
        assert np.array_equal(kept_array, value)


def test_every_instant_is_evaluated_by_itself(robot):
    rng = np.random.default_rng(1)
    motion = tuple(rng.normal(0.0, 0.3, (3, 12)) for _ in range(3))
    together, slope = SingleSupport(robot, 3).derivatives(*motion)
    for k in range(3):
        alone, own = SingleSupport(robot, 1).derivatives(*(a[k : k + 1] for a in motion))
        assert np.array_equal(alone.effort[0], together.effort[k])
        assert np.array_equal(own.effort[0], slope.effort[k])
        assert np.array_equal(own.corners[0], slope.corners[k])
