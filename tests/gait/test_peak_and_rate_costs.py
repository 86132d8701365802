"""Largest torque and torque rate: what they are, derivatives, sums, and walks made for them."""

from dataclasses import replace

import numpy as np
import pytest
from example_robots import needs_example_robots
from numerics import check_derivative
from scipy.integrate import trapezoid
from walks import walk

from gaitopt.actuators.motors import JointMotor
from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.costs import (
    CostContext,
    ElectricalEnergy,
    MechanicalWork,
    PeakTorque,
    TorqueCost,
    TorqueRate,
    WeightedSum,
    cost_of_text,
)
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.model.robot import Robot
from gaitopt.solvers import solver_by_name

KNEES = {"*_knee": 2.0}
ALL = JointMotor("*", 80.0, 30.0, 300.0, 30.0, 0.05, 0.8, 0.5)
SUM = WeightedSum(
    ((PeakTorque(), 1.0), (TorqueRate(), 1e-3), (TorqueCost(), 0.1), (MechanicalWork(), 2.0))
)


def with_cost(name, cost):
    at = walk(name)
    problem = WalkProblem(at.problem.robot, replace(at.problem.task, cost=cost), at.problem.grid)
    return problem, np.append(at.x, 30.0) if problem.model.layout.peak else at.x


@pytest.mark.parametrize(
    "name",
    [
        "guess", "everything free, penalty, Euler", "upright, toe off, everything free",
        "upright, lifted, five joints", "added instants",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "cost", [PeakTorque({"*knee*": 2.0}), TorqueRate(), SUM], ids=["peak", "rate", "sum"]
)
def test_derivatives_are_exact(name, cost):
    problem, x = with_cost(name, cost)
    y = np.random.default_rng(0).normal(size=problem.rows.lower.size)
    along = 0.1 * np.random.default_rng(1).normal(size=x.size) * problem.layout.scale()
    point = problem.point(x)
    check_derivative(lambda z: problem.values(z).cost, point.gradient @ along, x, along, step=1e-4)
    rows = problem.rows_of("peak torque") if problem.model.layout.peak else slice(0)
    if problem.model.layout.peak:
        check_derivative(
            lambda z: problem.values(z).rows[rows], point.jacobian[rows] @ along, x, along,
            step=1e-4,
        )  # fmt: skip

    def lagrangian(z):
        at = problem.point(z)
        return 0.7 * at.gradient + at.jacobian.T @ y

    bent = problem.hessian(x, y, 0.7)
    np.testing.assert_array_equal(bent, bent.T)
    check_derivative(lagrangian, bent @ along, x, along, step=1e-4)


def test_the_rate_of_torques_that_are_known():
    """Torques that rise by a N·m/s in n joints for T seconds over d metres cost n a² T / d."""
    problem, x = with_cost("optimum 43", TorqueRate())
    step = problem.step(x)
    rise = 7.0 * step.duration * problem.grid.instants[:, None]
    effort = np.hstack([np.zeros((len(rise), 6)), np.tile(rise, (1, 12))])
    ramp = replace(step, support=replace(step.support, effort=effort))
    expected = 12 * 7.0**2 * step.duration / step.step_length
    assert problem.cost.value(ramp) == pytest.approx(expected, rel=1e-12)
    weighed, _ = with_cost("optimum 43", TorqueRate(KNEES))
    assert weighed.cost.value(ramp) == pytest.approx(expected * 14 / 12, rel=1e-12)


def test_it_is_told_how_torques_change_over_the_step():
    problem, x = with_cost("optimum 43", TorqueRate())
    grids = [problem.with_grid(preset_task(samples=n).grid) for n in (31, 61, 601)]
    coarse, finer, close = (one.cost.value(one.step(x)) for one in grids)
    assert 3.0 < (coarse - close) / (finer - close) < 5.0  # of second order in the samples
    fine = grids[-1]
    step = fine.step(x)
    torque, dt = step.read(quantities.TORQUE), step.duration / 600.0
    rates = np.gradient(torque, dt, axis=0, edge_order=2)
    expected = trapezoid((rates**2).sum(axis=1), dx=dt) / step.step_length
    assert close == pytest.approx(expected, rel=5e-3)  # torques have corners at the knots


def test_sums_by_text():
    motors = (ALL,)
    cost = cost_of_text("torque + 0.5 energy + peak-torque", motors=motors, weights=KNEES)
    assert cost == WeightedSum((
        (TorqueCost(KNEES), 1.0), (ElectricalEnergy(motors=motors), 0.5), (PeakTorque(KNEES), 1.0)
    ))  # fmt: skip
    assert cost_of_text(" work ") == MechanicalWork()
    task = preset_task(cost=cost)
    assert task_from_record(task_record(task)).cost == cost
    for text, told in (
        ("torque + 3x energy", "cannot be read"), ("torque +", "cannot be read"),
        ("torque + nan work", "cannot be read"), ("torque + -1 work", "above 0"),
        ("torque + effort", "no cost 'effort'"), ("peak-torque + 2 peak-torque", "once"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=told):
            cost_of_text(text)
    with pytest.raises(InputError, match="has power_smoothing"):
        cost_of_text("torque + peak-torque", power_smoothing=1.0)


def least(robot, preset, **asked):
    """Walks for the least of three costs, and all three figures of each."""
    costs = {
        "torque": TorqueCost(), "peak": PeakTorque(),
        "energy": ElectricalEnergy(motors=(ALL,)),
    }  # fmt: skip
    options = DesignOptions(solver=solver_by_name("sqp"))
    table = {}
    for name, cost in costs.items():
        task = preset_task(preset, robot, cost=cost, samples=21, **asked)
        found = design(robot, task, options)
        assert found.certificate.certified, name
        fine = on_fine_grid(found.problem)
        step = fine.step(found.solution.x)
        context = CostContext(fine.robot, fine.grid, task.speed)
        torque = step.read(quantities.TORQUE)
        table[name] = {
            "torque": costs["torque"].function(context).value(step),
            "peak": float(np.abs(torque).max()),
            "energy": costs["energy"].function(context).value(step),
        }
        if name == "peak":
            assert found.gait.cost == pytest.approx(table[name]["peak"], rel=1e-6)
            assert found.gait.parameter_names[-1] == "peak_torque"
    return table


def best_in_own_column(table):
    for figure in table:
        others = [row[figure] for name, row in table.items() if name != figure]
        assert table[figure][figure] < 0.99 * min(others)


def test_each_walk_is_best_in_its_own_column(robot):
    best_in_own_column(least(robot, "standard", speed=0.9))


@needs_example_robots
def test_each_walk_of_g1_is_best_in_its_own_column():
    source, choices = description(entry_by_name("g1"))
    g1 = Robot.from_urdf(source, choices=choices)
    best_in_own_column(least(g1, "humanoid", speed=0.6))


def test_the_largest_torque_of_a_foot_that_turns(robot):
    task = preset_task(cost=PeakTorque(), speed=0.9, toe_off=0.7, samples=21)
    found = design(robot, task, DesignOptions(solver=solver_by_name("sqp"), toe_begin="given"))
    torque = on_fine_grid(found.problem).step(found.solution.x).read(quantities.TORQUE)
    assert found.gait.cost == pytest.approx(np.abs(torque).max(), rel=1e-5)
