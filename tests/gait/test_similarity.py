"""A robot in other units of length, mass and gravity walks as its model does (dynamic similarity).

What is measured in metres, newtons or seconds anywhere between the file and the walk shows here.
"""

import functools

import numpy as np
import pytest
from reference_cases import biped
from similar_robots import Units, similar_task, similar_urdf

from gaitopt.design.design import design
from gaitopt.design.relaxation import limit_adjustments
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.import_options import ImportOptions
from gaitopt.model.robot import Robot

UNITS = (
    Units(length=2.0, mass=8.0),
    Units(length=3.0, mass=27.0),
    Units(length=0.25, mass=0.02),
    Units(mass=2.0),
    Units(gravity=1.62 / 9.81),
    Units(length=3.3, mass=17.6, gravity=2.1),
)
TASKS = {
    "standard": ("standard", {}),
    "paper": ("paper", {}),
    "humanoid": ("humanoid", {}),
    "robust": ("robust", {}),
    "toe": ("humanoid", {"toe_off": 0.7}),
    "slap": ("humanoid", {"heel_strike": 0.2, "foot_flat": "impact"}),
    "double": ("humanoid", {"double_support": 0.1, "toe_off": 0.6}),
    "struck": ("standard", {"double_support": 0.05, "touch_down": "impact"}),
    "turn": ("humanoid", {"turn_rate": 0.3, "torsional_friction": 0.03}),
    "up": ("humanoid", {"slope": 0.1}),
    "stairs": ("humanoid", {"stairs": 0.1}),
    "soft": ("standard", {"soft_landing": True, "landing_impulse": 0.3}),
}


@functools.cache
def similar(units):
    gravity = None if units.gravity == 1.0 else 9.81 * units.gravity
    return Robot.from_urdf(
        similar_urdf(biped().urdf, units), choices=ImportOptions(gravity=gravity)
    )


@functools.cache
def asked(name):
    preset, changes = TASKS[name]
    return preset_task(preset, biped(), **changes)


@functools.cache
def own_walk():
    return design(biped(), asked("humanoid"))


def close(found, expected, tolerance=1e-9):
    size = max(1.0, np.abs(expected[np.isfinite(expected)]).max(initial=0.0))
    np.testing.assert_allclose(found, expected, rtol=tolerance, atol=tolerance * size)


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("units", UNITS)
def test_the_same_program_is_solved_in_other_units(units, name):
    mine = WalkProblem(biped(), asked(name))
    its = WalkProblem(similar(units), similar_task(asked(name), units))
    x, z = (perturbed(p, first_guess(p), 0.02, seed=3) for p in (mine, its))
    own, other = mine.variables, its.variables
    close(z / other.scale, x / own.scale)
    close(other.lower / other.scale, own.lower / own.scale)
    close(other.upper / other.scale, own.upper / own.scale)
    close(its.rows.lower, mine.rows.lower)
    close(its.rows.upper, mine.rows.upper)
    here, there = mine.point(x), its.point(z)
    close(there.rows, here.rows, 1e-7)
    assert there.cost * its.cost_scale == pytest.approx(here.cost * mine.cost_scale)
    close(
        there.gradient * its.cost_scale * other.scale,
        here.gradient * mine.cost_scale * own.scale,
        1e-7,
    )


@pytest.mark.parametrize("units", UNITS)
def test_the_walk_is_the_same_in_other_units(units):
    mine = own_walk()
    its = design(similar(units), similar_task(asked("humanoid"), units))
    assert mine.certificate.certified
    assert its.certificate.certified
    cost = its.solution.cost / units.of("N²·m·s")
    assert cost == pytest.approx(mine.solution.cost, rel=1e-7)
    close(its.gait.torque / units.of("N·m"), mine.gait.torque, 1e-5)
    close(its.gait.q, mine.gait.q, 1e-5)


@pytest.mark.parametrize("units", UNITS)
def test_a_diagnosis_tries_the_same_changes_in_other_units(units):
    task = asked("robust")
    mine = limit_adjustments(WalkProblem(biped(), task))
    its = limit_adjustments(WalkProblem(similar(units), similar_task(task, units)))
    assert [s.name for s in its] == [s.name for s in mine]
    for one, other in zip(mine, its, strict=True):
        size = units.of(one.unit) if not one.name.startswith("robot ") else 1.0
        assert other.bound == pytest.approx(size * one.bound)
        assert other.step == pytest.approx(size * one.step)
