"""Positive work and electrical energy: against hand-computed powers, derivatives, refusals."""

import numpy as np
import pytest
from numerics import check_jacobian, relative_error
from scipy.integrate import simpson, trapezoid
from walks import walk

from gaitopt.actuators.motors import JointMotor
from gaitopt.cli.request import make_request
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.design.summary import energies_per_step, summarise
from gaitopt.errors import InputError, SpecError
from gaitopt.gait import quantities
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import ElectricalEnergy, MechanicalWork, PositiveWork, TorqueCost
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import task_from_record, task_record
from gaitopt.solvers import SQP

ALL = JointMotor("*", 80.0, 30.0, 300.0, 30.0, 0.05, 0.8, 0.0)
KNEE = ALL._replace(joints="*knee*", loss=0.02, efficiency=0.6, friction=0.9)
SHARP = {"power_smoothing": 1e-9}


def entries(rng):
    return np.concatenate([rng.normal(0.0, 30.0, (3, 12)), rng.normal(0.0, 2.0, (3, 12))], axis=1)


def test_power_drawn_by_hand(robot):
    knee, ankle = (robot.joint_names.index(f"right_{n}") for n in ("knee", "ankle_pitch"))
    at = np.zeros((1, 24))
    at[0, [knee, ankle]] = 10.0, -20.0  # torques
    at[0, [12 + knee, 12 + ankle]] = 3.0, 2.0  # the knee drives with 30 W, the ankle brakes with 40
    cost = ElectricalEnergy(0.5, motors=(ALL, KNEE), **SHARP)
    copper = 0.02 * 10.0**2 + 0.05 * 20.0**2
    friction = 0.9 * (np.hypot(3.0, 0.05) - 0.05)
    expected = copper + 30.0 / 0.6 - 0.5 * 0.8 * 40.0 + friction
    assert cost.integrand(robot).value(at)[0, 0] == pytest.approx(expected)
    assert PositiveWork(**SHARP).integrand(robot).value(at)[0, 0] == pytest.approx(30.0)
    assert MechanicalWork(**SHARP).integrand(robot).value(at)[0, 0] == pytest.approx(70.0)


@pytest.mark.parametrize(
    "cost",
    [PositiveWork(weights={"*_knee": 2.0}), ElectricalEnergy(0.4, motors=(ALL, KNEE))],
    ids=lambda cost: cost.name,
)
def test_integrands_have_exact_derivatives(robot, rng, cost):
    function, at = cost.integrand(robot), entries(rng)
    move, weights = np.zeros(24), np.array([[0.7], [-1.3], [0.4]])
    check_jacobian(lambda d: function.value(at + d), function.jacobian(at), move)
    H = function.hessian(at, weights)
    check_jacobian(lambda d: function.vjp(at + d, weights), H, move, step=1e-4)


def test_they_are_integrals_over_the_step():
    problem, x = walk("guess").problem, walk("guess").x
    step = problem.step(x)
    torque, rate = step.read(quantities.TORQUE), step.read(quantities.RATES)
    drawn = 0.05 * torque**2 + np.maximum(torque * rate, 0.0) / 0.8
    expected = simpson(drawn.sum(axis=1), dx=step.duration / 30.0) / step.step_length
    task = preset_task(cost=ElectricalEnergy(motors=(ALL,), **SHARP))
    assert relative_error(WalkProblem(problem.robot, task).values(x).cost, expected) < 1e-9
    positive = np.maximum(torque * rate, 0.0).sum(axis=1)
    expected = simpson(positive, dx=step.duration / 30.0) / step.step_length
    task = preset_task(cost=PositiveWork(**SHARP))
    assert relative_error(WalkProblem(problem.robot, task).values(x).cost, expected) < 1e-9


def test_each_walk_is_the_best_of_its_own_cost(robot):
    costs = (TorqueCost(), PositiveWork(), ElectricalEnergy(motors=(ALL,)))
    found = []
    for cost in costs:
        one = design_gait(robot, preset_task(cost=cost), DesignOptions(SQP()), starts=1)
        assert one.certificate.certified
        found.append(one)
    for own, cost in zip(found, costs, strict=True):
        problem = WalkProblem(robot, preset_task(cost=cost))
        values = [problem.values(one.solution.x).cost for one in found]
        assert min(values) == values[found.index(own)]
        assert sorted(values)[1] > 1.01 * min(values)


def test_costs_of_transport_are_told_whatever_was_minimised(robot):
    envelope = MotorEnvelope(motors=(ALL,))
    task = preset_task(constraints=(envelope,))
    gait = design_gait(robot, task, DesignOptions(SQP()), starts=1).gait
    power = gait.torque * gait.dq
    energies = energies_per_step(gait)
    assert energies["absolute_work"] > energies["positive_work"] > 0.0
    drawn = 0.05 * gait.torque**2 + np.maximum(power, 0.0) / 0.8
    assert energies["electrical"] == pytest.approx(trapezoid(drawn.sum(axis=1), gait.time))
    back = 0.8 * (energies["absolute_work"] - energies["positive_work"])
    assert energies["electrical"] - energies["electrical_regenerated"] == pytest.approx(back)
    transport = summarise(gait)["walk"]["costs_of_transport"]
    lift = robot.mass * 9.81 * gait.step_length
    assert transport["electrical"] == pytest.approx(energies["electrical"] / lift)
    plain = design_gait(robot, preset_task(), DesignOptions(SQP()), starts=1).gait
    assert energies_per_step(plain)["electrical"] is None


def test_motors_are_needed_for_every_joint(robot):
    with pytest.raises(InputError, match=r"'energy' needs the motors.*--motors FILE"):
        make_request({"cost": "energy"}, None)
    with pytest.raises(InputError, match=r"motor of every joint.* right_ankle_roll.* has none"):
        ElectricalEnergy(motors=(KNEE,)).integrand(robot)
    with pytest.raises(SpecError, match="no joint that moves is called so"):
        ElectricalEnergy(motors=(ALL._replace(joints="elbow"),)).integrand(robot)
    with pytest.raises(InputError, match=r"regeneration is 1.2; it must be between 0 and 1"):
        ElectricalEnergy(1.2)
    with pytest.raises(InputError, match=r"power_smoothing is 0.0 W; it must be above 0"):
        PositiveWork(0.0)


def test_it_is_recorded_and_read_again():
    task = preset_task(cost=ElectricalEnergy(0.3, motors=(ALL, KNEE)))
    assert task_from_record(task_record(task)) == task
