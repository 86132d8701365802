"""Where the command line starts a design."""

import numpy as np
import pytest
from reference_cases import biped

from gaitopt.cli.config import read_config
from gaitopt.cli.request import make_request
from gaitopt.cli.results import task_text
from gaitopt.design.pipeline import parameters_of
from gaitopt.errors import InputError
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.settings import NO_LIMIT


def problem(**changes) -> WalkProblem:
    return WalkProblem(biped(), preset_task(speed=1.0, **changes))


@pytest.mark.parametrize("boundary", ["closed", "lifted"])
def test_a_gait_is_its_own_start(boundary):
    walk = problem(boundary=boundary)
    guess = first_guess(walk)
    x = perturbed(walk, guess, 0.05, 1)
    found = parameters_of(gait_at(walk, x, {}), walk)
    np.testing.assert_array_equal(found, x)
    assert np.abs(found - guess).max() > 0.01


def test_a_walk_of_the_closed_form_starts_the_lifted_one():
    walk, closed = problem(boundary="lifted"), problem()
    gait = gait_at(closed, first_guess(closed), {})
    step = walk.step(parameters_of(gait, walk))
    np.testing.assert_allclose(step.motion[0, : len(gait.q)], gait.q, atol=1e-9)


def test_a_walk_of_another_number_of_postures_is_refused():
    walk, other = problem(), problem(postures=1)
    with pytest.raises(InputError, match="another number of intermediate postures"):
        parameters_of(gait_at(walk, first_guess(walk), {}), other)


def test_none_lifts_a_limit_of_the_preset(tmp_path):
    given = {"torsional_friction": NO_LIMIT, "leg_extension": NO_LIMIT, "speed": 0.8}
    request = make_request(given, None)
    assert request.task == preset_task(torsional_friction=None, leg_extension=None, speed=0.8)
    (tmp_path / "task.toml").write_text(task_text(request, tmp_path))
    assert read_config(tmp_path / "task.toml")["torsional_friction"] == NO_LIMIT
    assert make_request({"speed": 0.8}, None).task.margins.torsional_friction is not None


def test_only_a_limit_can_be_none(tmp_path):
    config = tmp_path / "task.toml"
    config.write_text('[margins]\ntorsional_friction = "never"')
    with pytest.raises(InputError, match=r"margins.torsional_friction = 'never' .* mm, or none"):
        read_config(config)
    config.write_text('[margins]\nfriction = "none"')
    with pytest.raises(InputError, match=r"margins.friction = 'none' is wrong; give a number$"):
        read_config(config)
