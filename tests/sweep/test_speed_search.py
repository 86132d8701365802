import math
from dataclasses import replace

import pytest

from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError, NoGaitFoundError, StoppedError
from gaitopt.gait.presets import preset_task
from gaitopt.nlp import Status
from gaitopt.solvers.solver import Solver
from gaitopt.solvers.sqp import SQP
from gaitopt.sweep.speed_search import fastest

FAST = DesignOptions(refine=False, diagnose=False)


def task_at(speed):
    return preset_task(speed=speed, samples=15, speed_limit=4.0, torque_limit=40.0)


@pytest.fixture(scope="module")
def found(robot):
    tried = []
    best = fastest(
        robot, task_at, 0.5, FAST, resolution=0.03, on_try=lambda v, d: tried.append((v, d))
    )
    return best, tried


def test_the_fastest_walk_is_the_last_that_was_found(found):
    best, tried = found
    walked = [speed for speed, design in tried if design is not None]
    refused = [speed for speed, design in tried if design is None]
    assert walked == sorted(walked)
    assert len(walked) > 1
    assert best.speed == walked[-1] == best.design.gait.speed.__round__(6)
    assert best.refused == min(speed for speed in refused if speed > best.speed)
    assert best.refused < best.speed + 0.06


def test_what_limits_it_is_said(found):
    assert any("speed" in sentence for sentence in found[0].binding)


def test_gaits_found_on_the_way_are_optimal(found):
    assert all(d.certificate.optimal for _, d in found[1] if d is not None)


def test_no_walk_to_begin_with_is_an_error(robot):
    with pytest.raises(NoGaitFoundError):
        fastest(robot, lambda v: preset_task(speed=v, torque_limit=5.0, samples=15), 1.0, FAST)


def test_a_resolution_must_be_positive(robot):
    with pytest.raises(InputError, match="resolution"):
        fastest(robot, task_at, 0.5, FAST, resolution=0.0)


class Stopping(Solver):
    """A solver that is stopped at a call of its choice."""

    name = "stopping"

    def __init__(self, at):
        self.calls, self.at = 0, at

    def solve(self, nlp, start, on_progress=None, stop=None):
        self.calls += 1
        solution = SQP().solve(nlp, start, on_progress, stop)
        if self.calls < self.at:
            return solution
        return replace(solution, status=Status.INTERRUPTED)


@pytest.mark.parametrize("at", [1, 2])
def test_a_stop_is_no_answer_and_keeps_the_fastest_so_far(robot, at):
    options, tried = replace(FAST, solver=Stopping(at)), []
    best = fastest(robot, task_at, 0.5, options, on_try=lambda v, d: tried.append(v))
    assert best.interrupted
    assert best.speed == 0.5
    assert tried == [0.5]
    assert math.isinf(best.refused)


def test_a_stop_before_the_first_walk_is_told(robot):
    class Lost(Stopping):
        def solve(self, nlp, start, on_progress=None, stop=None):
            solution = super().solve(nlp, start, on_progress, stop)
            return replace(solution, cost=math.nan, violation=math.inf)

    with pytest.raises(StoppedError):
        fastest(robot, task_at, 0.5, replace(FAST, solver=Lost(1)))
