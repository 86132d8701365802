"""A first step from standing that begins with both feet on the ground."""

from functools import cache

import numpy as np
import pytest
from reference_cases import biped
from strides import check_slopes
from test_transition import mujocos_torques
from transitions import walk

from gaitopt.design.transition import (
    audit_transition,
    certify_transition,
    standing_torque,
    transition_at,
    transition_problem,
)
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.initial_guess import first_guess, perturbed, transition_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.shift_step import starting_still
from gaitopt.gait.spline import spline_basis
from gaitopt.gait.transition import load_transition, save_transition
from gaitopt.gait.transition_problem import (
    LAST_LOAD,
    TransitionProblem,
    TransitionTask,
    junction_of,
    standing,
    step_durations,
    wrench_standing,
)

SHIFT = 0.3


@cache
def problem():
    return transition_problem(None, walk(), steps=2, shift=SHIFT)


@cache
def point():
    return perturbed(problem(), transition_guess(problem()), 0.05, seed=7)


@cache
def moved():
    """A transition that is no optimum."""
    return transition_at(problem(), point(), None, walk(), {"stretch": 0.96})


@pytest.mark.parametrize(("free", "form"), [(False, "closed"), (True, "closed"), (True, "lifted")])
def test_slopes_and_hessians_are_those_of_the_transition(free, form):
    task = preset_task(speed=0.8, trunk_yaw=0.2, boundary=form)
    cycle = WalkProblem(biped(), task)
    at = junction_of(cycle, first_guess(cycle))
    still = standing(cycle.robot, at.geometry)
    front = wrench_standing(cycle.robot)
    asked = TransitionTask(task, still, at, step_durations(still, at, 2), free, SHIFT, front)
    shifted = TransitionProblem(cycle.robot, asked)
    check_slopes(shifted, perturbed(shifted, transition_guess(shifted), 0.05, seed=5))


def test_a_spline_that_begins_without_acceleration():
    knots = np.array([0.0, 0.1, 0.3, 0.6, 1.0])
    basis = starting_still(spline_basis(knots, knots))
    values = np.array([[0.2, 7.0, -0.4, 0.1, 0.3, 0.0, 1.5]]).T
    for duration in (0.5, 2.0):
        motion = (basis.at(duration) @ values)[:, :, 0]
        assert motion[0] == pytest.approx([0.2, 0.0, 0.0], abs=1e-12)
        assert motion[[2, 3, 4], 0] == pytest.approx([-0.4, 0.1, 0.3])
        assert motion[-1, 1] == pytest.approx(1.5)
        changed = values + np.eye(7)[:, [1]]
        assert (basis.at(duration) @ changed)[:, :, 0] == pytest.approx(motion)


def test_mujocos_inverse_dynamics_agrees_with_the_forces_of_both_feet():
    trajectory = moved().trajectory
    assert mujocos_torques(trajectory, np.linspace(0.0, trajectory.period, 201)) < 1e-9
    during = np.linspace(moved().begins, moved().begins + moved().shift.duration, 11)[1:-1]
    assert trajectory.at(during).contact.all()


def test_nothing_jumps_as_the_shift_begins_and_only_forces_as_the_foot_leaves():
    result, robot = moved(), problem().robot
    trajectory = result.trajectory
    times = result.begins + np.array([0.0, result.shift.duration])
    before, after = trajectory.at(times, before=True), trajectory.at(times)
    assert after.q == pytest.approx(before.q, abs=1e-12)
    assert after.dq == pytest.approx(before.dq, abs=1e-10)
    assert after.torque[0] == pytest.approx(before.torque[0], abs=1e-8)
    assert after.wrench[0] == pytest.approx(before.wrench[0], abs=1e-8)
    still = standing_torque(robot, problem().transition.begin.q)
    assert after.torque[0, trajectory.body.moving] == pytest.approx(still, abs=1e-8)
    assert before.wrench[1, 1, 2] == pytest.approx(LAST_LOAD)
    stance = np.array(trajectory.body.leg(0))
    assert after.ddq[1, stance] == pytest.approx(before.ddq[1, stance], abs=1e-8)


def test_both_soles_rest_while_the_weight_moves():
    result = moved()
    times = result.begins + np.linspace(0.0, result.shift.duration, 21)
    samples = result.trajectory.at(times, before=True)
    assert samples.sole == pytest.approx(np.tile(samples.sole[0], (21, 1, 1, 1)), abs=1e-10)
    assert np.ptp(samples.base_position[:, 1]) > 0.01


def test_torques_are_those_that_were_optimised():
    """Also of the leg that is closed at every instant of its own."""
    result, at = moved(), problem()
    step, model = at.steps(point())[0], at.models[0]
    times = result.begins + model.grid.instants * step.duration
    before = model.both | (model.grid.instants > 0.9)
    samples = result.trajectory.at(times, before=before)
    found = samples.torque[:, result.trajectory.body.moving]
    assert found == pytest.approx(step.read(quantities.TORQUE), abs=1e-7)
    assert samples.wrench[model.both, 1] == pytest.approx(step.double.wrench, abs=1e-8)


def test_the_referee_agrees():
    found = certify_transition(problem(), point())
    assert found.refereed


def test_the_file_has_it(tmp_path):
    again = load_transition(save_transition(moved(), tmp_path / "start.npz"))
    assert again.shift.duration == moved().shift.duration
    assert again.trajectory.at(0.6).torque == pytest.approx(moved().trajectory.at(0.6).torque)
    found = audit_transition(again)
    assert found.altered == ()
    assert "shift front_wrench" in found.differences


@pytest.mark.parametrize(
    ("ends", "shift", "words"),
    [
        ((None, walk), 100.0, "give 0.05 to 5.0 s"),
        ((None, walk), -0.3, "give 0.05 to 5.0 s"),
        ((None, walk), float("nan"), "give 0.05 to 5.0 s"),
        ((walk, None), 0.3, "from standing"),
    ],
)
def test_refusals(ends, shift, words):
    before, after = (end and end() for end in ends)
    with pytest.raises(InputError, match=words):
        transition_problem(before, after, shift=shift)
