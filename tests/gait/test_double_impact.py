"""Double supports that begin with an impact after which both feet stay: section 2.4.1, case two."""

import io
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from rich.console import Console
from walk_checks import check_both_feet_hold, check_referee_agrees, refereed
from walks import walk

from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.cli.report import print_gait
from gaitopt.contact import PhaseEnd
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import attempt, carried_over, gentle, impact_possible
from gaitopt.design.starts import SECOND, StartJob
from gaitopt.design.summary import summarise
from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.grid import proof_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.mechanics.impact import ClosedImpact
from gaitopt.mechanics.single_support import passive_torque
from gaitopt.model.robot import Robot
from gaitopt.model.sole import sole_edge_speeds
from gaitopt.motions.export import stride_record, stride_samples
from gaitopt.nlp import Status
from gaitopt.simulate.second_engine import second_engine
from gaitopt.solvers import solver_by_name
from gaitopt.tolerances import MOMENTUM, REFEREE

NAME = "upright, double support after an impact on both"
QUICK = DesignOptions(refine=False, diagnose=False)
WALK = {"speed": 0.8, "duration": 0.6, "double_support": 0.05, "boundary": "closed"}


@pytest.fixture(scope="module")
def found():
    """Alexander at 0.8 m/s, both of whose feet take the impact."""
    source, choices = description(entry_by_name("alexander"))
    robot = Robot.from_urdf(source, choices=choices)
    task = preset_task("humanoid", robot, **WALK, touch_down="impact")
    return design(robot, task, DesignOptions(diagnose=False))


@pytest.fixture(scope="module")
def gait(found):
    return found.gait


def test_it_is_certified_and_both_feet_take_an_impulse(found):
    assert found.certificate.verdict == "certified"
    kinds = [phase.ends_by for phase in found.problem.schedule.phases]
    assert kinds == [PhaseEnd.IMPACT, PhaseEnd.LIFT_OFF]
    step, margins = found.problem.step(found.solution.x), found.problem.task.margins
    for what in (quantities.IMPULSE, quantities.REAR_IMPULSE):
        (impulse,) = step.read(what)
        assert impulse[2] > 0.0
        assert np.hypot(*impulse[:2]) <= margins.friction * impulse[2] * (1.0 + 1e-5)
        x, y = -impulse[4] / impulse[2], impulse[3] / impulse[2]
        sole = found.problem.robot.sole
        room = min(sole.toe - x, x - sole.heel, sole.left - y, y - sole.right)
        assert room > margins.cop_margin - 1e-4
    assert step.impulse[2] > 5.0


def test_it_costs_less_than_a_touch_down_at_zero_speed(found):
    softly = design(found.problem.robot, gentle(found.problem).task, QUICK).solution.cost
    assert found.solution.cost < 0.8 * softly


def test_the_impulses_are_those_of_the_locked_impact(found):
    """The system of both feet, solved for twenty-four unknowns, knows nothing of this way."""
    problem = found.problem
    step = problem.step(found.solution.x)
    posture = step.double.touchdown.motion[0, 0]
    locked = problem.model.impact.locked(posture, step.rate_before)
    assert locked.valid
    assert relative_error(locked.velocity[6:], step.impact.rate_after) < 1e-10
    assert relative_error(locked.impulse_landing, step.impulse) < 1e-9
    assert locked.impulse_rear == pytest.approx(step.double.struck.rear, abs=1e-9)


def test_a_rear_foot_that_would_leave_sinks(found):
    """The first case of section 2.4.1 is no outcome of this impact, the second is the only one."""
    problem = found.problem
    step = problem.step(found.solution.x)
    free = problem.model.impact.state(step.double.touchdown.motion[0, 0], step.rate_before)
    speeds = sole_edge_speeds(problem.robot.sole.corners) @ free.sole_twist
    assert speeds.min() < -1e-4
    assert free.impulse[2] > 0.0


def test_the_motors_give_back_what_the_impact_takes(found):
    problem = found.problem.with_grid(proof_grid(found.problem.breaks))
    step, robot = problem.step(found.solution.x), problem.robot
    q, dq, _ = step.motion
    damped = passive_torque(robot.physics.passive, q, dq).value
    power = ((step.read(quantities.TORQUE) - damped) * dq).sum(axis=1)
    work = step.duration * problem.grid.weights @ power
    at = ClosedImpact(robot).at(
        step.double.touchdown.motion[0, 0], step.double.touchdown.axes[0], np.zeros(6)
    )
    mass = at.inertia[6:]
    before, after = step.rate_before, step.impact.rate_after
    lost = 0.5 * (before @ mass @ before - after @ mass @ after)
    assert lost > 0.5
    assert work == pytest.approx(lost, rel=1e-8)


def test_both_feet_keep_their_contacts_at_5001_instants(found):
    check_both_feet_hold(found.problem, found.solution.x)


def test_only_the_rates_jump_as_both_feet_come_to_stand(gait):
    trajectory, touch = gait.trajectory, gait.duration - 0.05
    before, after = trajectory.at([touch], before=True), trajectory.at([touch])
    moving = trajectory.body.moving
    assert after.q == pytest.approx(before.q, abs=1e-12)
    assert after.dq[0, moving] == pytest.approx(gait.rate_after, abs=1e-9)
    assert before.dq[0, moving] == pytest.approx(gait.rate_before, abs=1e-9)
    assert np.abs(gait.rate_after - gait.rate_before).max() > 0.1
    end, start = trajectory.at([gait.duration], before=True), trajectory.at([gait.duration])
    assert end.dq == pytest.approx(start.dq, abs=1e-10)


def test_a_second_engine_signs_and_sees_a_wrong_rear_impulse(gait):
    assert 0.0 < second_engine(gait).largest < 1e-9
    wrong = replace(gait, rear_impulse=gait.rear_impulse + 0.01 * np.eye(6)[2])
    assert second_engine(wrong, instants=5).impulse > 1e-4


def test_the_referee_agrees_and_sees_a_wrong_impulse():
    problem, step = check_referee_agrees(walk(NAME).problem, walk(NAME).x)
    struck = replace(step.double.struck, rear=1.001 * step.double.struck.rear)
    wrong = replace(step, double=replace(step.double, struck=struck))
    verdict = refereed(problem, wrong)
    assert verdict.impulse > REFEREE
    assert verdict.momentum > MOMENTUM


def test_the_same_motion_has_parameters_of_either_kind():
    at = walk("upright, double support")
    task = replace(at.problem.task, touch_down="impact")
    struck = WalkProblem(at.problem.robot, task)
    y = carried_over(at.x, at.problem, struck)
    one, other = at.problem.step(at.x), struck.step(y)
    assert relative_error(other.motion, one.motion) < 1e-10
    assert relative_error(other.read(quantities.TORQUE), one.read(quantities.TORQUE)) < 1e-9
    assert np.abs(other.impulse).max() == 0.0
    again = carried_over(y, struck, at.problem)
    assert relative_error(again, at.x) < 1e-9


def test_no_impact_is_possible_on_both_feet_of_the_biped(robot):
    """All that its feet can take together is none; so it touches down at zero speed."""
    task = preset_task(duration=0.5, double_support=0.05, touch_down="impact")
    found = design(robot, task, QUICK)
    assert found.problem.task.touch_down == "gentle"
    softly = design(robot, replace(task, touch_down="gentle"), QUICK)
    assert found.solution.cost == pytest.approx(softly.solution.cost, rel=1e-6)
    struck = WalkProblem(robot, task)
    x = carried_over(softly.solution.x, softly.problem, struck)
    assert not impact_possible(struck, x)
    stalled = attempt(struck, Search(QUICK), x)
    assert stalled.x.shape == x.shape
    assert stalled.hessian is None  # that of the gentle walk has other variables
    loose = WalkProblem(robot, task.with_margins({"impulse_cop": False, "friction": 50.0}))
    assert impact_possible(loose, x)


def test_a_start_from_a_walk_without_an_impact_looks_for_room_for_one_too(robot):
    """Else the solver crawls where all limits on the impulse meet: 300 Hessians, not 30."""
    task = preset_task(double_support=0.05, touch_down="impact")
    search = Search(replace(QUICK, solver=solver_by_name("sqp")))
    job = StartJob(robot, task, first_guess(WalkProblem(robot, task)), 0.1, 0)
    second = job.run(SECOND, search).solution
    assert second.status is Status.STALLED
    assert not second.multipliers.any()
    assert second.hessians < 60


def test_file_table_and_export_tell_the_rear_foot(gait, tmp_path):
    again = load_gait(save_gait(gait, tmp_path / "gait.npz"))
    assert again.striking
    assert again.rear_impulse == pytest.approx(gait.rear_impulse, abs=0.0)
    impact = summarise(again)["impact"]
    assert not impact["at_zero_speed"]
    assert 0.0 < impact["rear_foot"]["vertical_impulse_Ns"] < 1.0
    console = Console(file=io.StringIO(), width=100)
    print_gait(console, again)
    assert "rear foot, impact" in console.file.getvalue()
    told = stride_record(again, stride_samples(again))["impact"]["impulse_in_rear_sole"]
    assert list(told.values()) == pytest.approx(gait.rear_impulse.tolist())
    with pytest.raises(InputError, match="rear_impulse"):
        replace(gait, rear_impulse=np.zeros(5))


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"touch_down": "impact"}, "give double_support, or leave it out"),
        ({"touch_down": "hard", "double_support": 0.05}, "choose gentle or impact"),
        (
            {"touch_down": "impact", "double_support": 0.05, "soft_landing": True},
            "leave out one of them",
        ),
    ],
)
def test_a_touch_down_that_cannot_be_is_refused(changes, match):
    with pytest.raises(InputError, match=match):
        preset_task(**changes)
