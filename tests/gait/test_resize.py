"""A walk taken over by a robot of other lengths."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from reference_cases import reference_case

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.parameters import changed
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import UnreachableError
from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import resized
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import Robot
from gaitopt.nlp import worst_violation

X = reference_case("p43_v1.0_optimum").x


@functools.cache
def problem(shin: float = 0.3) -> WalkProblem:
    """The walk of a biped with shins of another length [m]."""
    spec = changed(biped13(), {"geometry.d4": shin})
    return WalkProblem(Robot.from_urdf(urdf_text(spec)), preset_task(speed=1.0))


def stretch(walk: WalkProblem, x: np.ndarray) -> np.ndarray:
    legs = walk.step(x).read(quantities.LEGS)
    return np.linalg.norm(legs, axis=1) / walk.robot.legs.reach


def test_the_same_robot_stands_as_before():
    assert relative_error(resized(X, problem(), problem()), X) < 1e-14


@pytest.mark.parametrize("shin", [0.27, 0.29, 0.31, 0.33])
def test_no_leg_is_straighter_than_before(shin):
    x = resized(X, problem(), problem(shin))
    before, after = stretch(problem(), X), stretch(problem(shin), x)
    assert (after <= before + 1e-12).all()
    assert (after - before).max() == pytest.approx(0.0, abs=1e-12)
    (moved,) = np.flatnonzero(x != X)
    assert problem().layout.names[moved] == "pelvis_height"
    assert x[moved] - X[moved] == pytest.approx(shin - 0.3, rel=0.5)


def test_it_is_nearly_a_walk():
    longer = problem(0.31)
    kept, _ = worst_violation(longer, longer.values(X))
    taken, _ = worst_violation(longer, longer.values(resized(X, problem(), longer)))
    assert taken < 0.5 * kept


def test_shorter_legs_reach_the_ground():
    shorter = problem(0.28)
    with pytest.raises(UnreachableError):
        shorter.values(X)
    assert np.isfinite(shorter.values(resized(X, problem(), shorter)).cost)


def test_a_fixed_height_stays():
    fixed = {"pelvis_height": {"value": 0.5, "free": False}}
    task = preset_task(speed=1.0)
    old = WalkProblem(problem().robot, replace(task, geometry=set_geometry(task.geometry, fixed)))
    new = WalkProblem(problem(0.31).robot, old.task)
    x = old.variables.scale
    np.testing.assert_array_equal(resized(x, old, new), x)
