"""A cost declared in one file: absolute mechanical work per metre."""

from dataclasses import replace

import numpy as np
import pytest
from numerics import check_differences, check_jacobian, jacobian_difference, relative_error, steps
from scipy.integrate import simpson
from walks import walk

from gaitopt.actuators.motors import JointMotor
from gaitopt.cli.config import SCHEMA
from gaitopt.cli.request import make_request
from gaitopt.design.audit import audit
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.costs import (
    ElectricalEnergy,
    MechanicalWork,
    PositiveWork,
    TorqueCost,
    cost_by_name,
)
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.solvers import SQP


def test_it_is_the_integral_of_absolute_power():
    problem, x = walk("guess").problem, walk("guess").x
    step = problem.step(x)
    power = np.abs(step.read(quantities.TORQUE) * step.read(quantities.RATES)).sum(axis=1)
    expected = simpson(power, dx=step.duration / 30.0) / step.step_length
    found = WalkProblem(problem.robot, preset_task(cost=MechanicalWork(1e-9))).values(x).cost
    assert relative_error(found, expected) < 1e-9
    rounded = WalkProblem(problem.robot, preset_task(cost=MechanicalWork(2.0))).values(x).cost
    assert expected - 2.0 * 12.0 * step.duration / step.step_length < rounded < expected


def test_its_integrand_has_exact_derivatives(robot, rng):
    function = MechanicalWork(weights={"*_knee": 2.0}).integrand(robot)
    entries = np.concatenate(
        [rng.normal(0.0, 30.0, (3, 12)), rng.normal(0.0, 2.0, (3, 12))], axis=1
    )
    move, weights = np.zeros(24), np.array([[0.7], [-1.3], [0.4]])
    check_jacobian(lambda d: function.value(entries + d), function.jacobian(entries), move)
    H = function.hessian(entries, weights)
    check_jacobian(lambda d: function.vjp(entries + d, weights), H, move, step=1e-4)


MOTOR = JointMotor("*", 80.0, 30.0, 300.0, 30.0, 0.05, 0.7, 0.9)
COSTS = (MechanicalWork(), PositiveWork(), ElectricalEnergy(0.4, motors=(MOTOR,)))


@pytest.mark.parametrize("cost", COSTS, ids=lambda cost: cost.name)
@pytest.mark.parametrize("name", ["guess", "everything free", "everything free, penalty, Euler"])
def test_the_hessian_of_the_walk_is_exact(name, cost):
    known = walk(name)
    problem = WalkProblem(
        known.problem.robot, replace(known.problem.task, cost=cost), known.problem.grid
    )
    scale, rows = problem.variables.scale, problem.rows.lower.size
    H = problem.hessian(known.x, np.zeros(rows), 1.0)
    found = [
        jacobian_difference(lambda at: problem.point(at).gradient, known.x, scale, h)
        for h in steps(1e-6)  # of powers that turn round within 2 W
    ]
    check_differences(scale * H, found)


@pytest.fixture(scope="module")
def lazy(robot):
    """The walk of the least work."""
    task = preset_task(cost=MechanicalWork())
    return design_gait(robot, task, DesignOptions(SQP()), starts=1)


def test_a_walk_of_least_work_works_less(robot, lazy):
    assert lazy.certificate.certified
    assert audit(lazy.gait).passed
    strong = design_gait(robot, preset_task(), DesignOptions(SQP()), starts=1)
    there = WalkProblem(robot, preset_task(cost=MechanicalWork())).values(strong.solution.x).cost
    assert lazy.gait.cost < 0.6 * there
    effort = WalkProblem(robot, preset_task()).values(lazy.solution.x).cost
    assert effort > strong.gait.cost


def test_it_is_known_by_name_with_its_fields():
    assert cost_by_name("work", power_smoothing=3.0) == MechanicalWork(3.0)
    assert (MechanicalWork().unit, TorqueCost().unit) == ("J/m", "N²·m·s")
    assert {"cost", "weights", "power_smoothing", "regeneration"} == set(SCHEMA["cost"])
    assert make_request({"cost": "work"}, None).task.cost == MechanicalWork()
    with pytest.raises(InputError, match="'torque' has no power_smoothing; it has weights"):
        make_request({"power_smoothing": 3.0}, None)
    with pytest.raises(InputError, match=r"power_smoothing is 0.0 W; it must be above 0"):
        MechanicalWork(0.0)
