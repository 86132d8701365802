"""Walks with a finite double support: both feet flat, the load passing from one to the other."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from rich.console import Console
from synthetic_bipeds import synthetic
from walk_checks import (
    FORCE_MIRROR,
    check_base_moves_as_its_twist_says,
    check_both_feet_hold,
    check_referee_agrees,
    refereed,
)
from walks import walk

from gaitopt.cli.report import print_gait
from gaitopt.contact import PhaseEnd
from gaitopt.design.certificate import certify
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.sensitivity import Envelope
from gaitopt.design.summary import summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.grid import proof_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.motions.export import stride_record, stride_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.tolerances import REFEREE
from gaitopt.view.animation import frames, pressure
from gaitopt.view.figures import make_figure
from gaitopt.view.page import page_text

NAME = "upright, double support"


@pytest.fixture(scope="module")
def found(robot):
    """The best walk at 1 m/s whose feet both stand for a fifth of its steps."""
    return design(
        robot, preset_task(duration=0.5, double_support=0.1), DesignOptions(diagnose=False)
    )


@pytest.fixture(scope="module")
def gait(found):
    return found.gait


def test_it_is_certified(found):
    assert found.certificate.verdict == "certified"
    assert found.certificate.both_feet_stay
    schedule = found.problem.schedule
    assert [p.ends_by for p in schedule.phases] == [PhaseEnd.TOUCH_DOWN, PhaseEnd.LIFT_OFF]
    assert [p.both for p in schedule.phases] == [False, True]


def test_the_referee_agrees_and_sees_a_wrong_front_wrench():
    problem, step = check_referee_agrees(walk(NAME).problem, walk(NAME).x)
    wrong = replace(step, double=replace(step.double, front=1.001 * step.double.front))
    verdict = refereed(problem, wrong)
    assert min(verdict.torque, verdict.wrench) > REFEREE


def test_both_feet_keep_their_contacts_at_5001_instants(found):
    """Unilateral, in the friction cone, with the pressure inside the sole, between nodes too."""
    step = check_both_feet_hold(found.problem, found.solution.x)
    late = step.support.corners[-1000:]
    assert np.abs(late[:, :, 2]).max() < 1e-12


def test_nothing_jumps_at_touch_down_and_lift_off_but_forces(gait):
    trajectory, T = gait.trajectory, gait.duration
    for time in (0.4, T):
        before, after = trajectory.at([time], before=True), trajectory.at([time])
        assert after.q == pytest.approx(before.q, abs=1e-12)
        assert after.dq == pytest.approx(before.dq, abs=1e-10)
        assert after.sole == pytest.approx(before.sole, abs=1e-12)
    assert gait.rate_after == pytest.approx(gait.rate_before, abs=1e-12)
    assert np.abs(gait.impulse).max() == 0.0


def test_trajectory_is_the_step_and_the_next_one_its_mirror_image(found, gait):
    problem, x, T = found.problem, found.solution.x, gait.duration
    step, trajectory = problem.step(x), gait.trajectory
    times = problem.grid.instants * T
    ends = (times > 0.0) & ~((times > 0.4) & (times < 0.4 + 1e-9))
    at, moving = trajectory.at(times, before=ends), problem.robot.multibody.moving
    motion = np.stack([at.q, at.dq, at.ddq])[:, :, moving]
    assert relative_error(motion, step.motion) < 1e-11
    assert relative_error(at.torque[:, moving], step.read(quantities.TORQUE)) < 1e-10
    assert relative_error(at.wrench[:, 0], step.read(quantities.WRENCH)) < 1e-10
    assert relative_error(at.wrench[:, 1], step.read(quantities.FRONT_WRENCH)) < 1e-10
    assert at.contact.sum(axis=1).tolist() == [1 + (t > 0.4 + 1e-13) for t in times]
    times = np.array([0.1, 0.42, 0.47, 0.49])
    one, two = trajectory.at(times), trajectory.at(times + T)
    assert relative_error(two.torque[:, moving], one.torque[:, moving] @ gait.mirror.T) < 1e-9
    assert relative_error(two.wrench[:, ::-1], one.wrench * FORCE_MIRROR) < 1e-9
    assert two.standing.tolist() == [1] * 4


def test_base_moves_as_its_twist_says(gait):
    times = np.array([0.2, 0.43, 0.46, gait.duration + 0.47])
    check_base_moves_as_its_twist_says(gait.trajectory, times)


def test_a_second_engine_signs_with_the_forces_of_both_feet(gait):
    assert 0.0 < second_engine(gait).largest < 1e-9
    one = gait.front_wrench.copy()
    one[1, 4] += 1.0
    other = second_engine(replace(gait, front_wrench=one), instants=41)
    assert other.largest < 1e-9  # how the feet share the load is the gait's choice
    assert np.abs(gait.trajectory.at([0.45]).wrench[0, 1]).max() > 10.0


def test_energy_of_the_motors_is_all_there_is(found):
    """On level ground, without an impact, the motors do no work over a step."""
    problem = found.problem.with_grid(proof_grid(found.problem.breaks))
    step = problem.step(found.solution.x)
    power = (step.read(quantities.TORQUE) * step.motion[1]).sum(axis=1)
    weights = step.duration * problem.grid.weights
    assert weights @ np.abs(power) > 10.0
    assert weights @ power == pytest.approx(0.0, abs=1e-9 * (weights @ np.abs(power)))


def test_shorter_double_supports_tend_to_the_landing_at_zero_speed(robot):
    options = DesignOptions(refine=False, diagnose=False)
    softly = design(robot, preset_task(soft_landing=True), options).solution.cost
    costs = [
        design(robot, preset_task(double_support=time), options).solution.cost
        for time in (0.004, 0.001, 0.0004)
    ]
    assert costs[0] < costs[1] < costs[2] < softly
    away = (softly - np.array(costs)) / softly
    assert away[2] < 0.025
    assert away[0] > 3.0 * away[2]


def test_the_file_keeps_the_double_support(gait, tmp_path):
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    assert again.phases == gait.phases
    assert [one.contact for one in again.phases] == ["flat", "both feet"]
    assert again.step_length == pytest.approx(0.5, abs=1e-12)
    t = np.linspace(0.0, 2.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-9
    with np.load(path) as content:
        assert content["front_wrench_1"].shape == (4, 6)
        kept = {key: content[key] for key in content.files if key != "front_wrench_1"}
    np.savez(path, **kept)
    with pytest.raises(GaitFileError):
        load_gait(path)


@pytest.mark.parametrize(
    "change",
    [
        {"double_knots": np.zeros(0)},
        {"double_knots": np.array([0.3, 0.45, 0.5])},
        {"front_wrench": np.zeros((3, 6))},
        {"double_coefficients": np.zeros((4, 12))},
    ],
)
def test_a_double_support_that_does_not_fit_the_step_is_refused(gait, change):
    with pytest.raises(InputError, match=r"double|last knot"):
        replace(gait, **change)


def test_summary_page_and_figures_tell_both_feet(gait):
    contact = summarise(gait)["contact"]
    front = contact["front_foot"]
    assert 0.0 < front["least_vertical_force_N"] < front["largest_vertical_force_N"]
    assert contact["phases"][1]["begin_s"] == pytest.approx(0.4)
    assert summarise(gait)["impact"]["at_zero_speed"]
    page = page_text(gait, 1)
    assert re.search(r'"both": ?true', page)
    lines = make_figure(gait, "ground_force").axes[0].lines
    assert any(str(line.get_label()).startswith("front foot") for line in lines)
    shown = frames(gait, 1)
    at, last = pressure(shown), shown.contact.all(axis=1)
    assert 3 < last.sum() < 10
    arm, force = shown.sole[..., :3, 3], shown.force
    own = np.einsum("nfij,nfj->nfi", shown.sole[..., :3, :3], shown.wrench[..., 3:])
    moment = (np.cross(arm, force) + own).sum(axis=1)
    expected = -moment[:, 1] / force[..., 2].sum(axis=1)
    assert at[:, 0] == pytest.approx(expected, abs=1e-9)
    exported = stride_record(gait, stride_samples(gait))["double_support"]
    assert exported["knots"][0] == pytest.approx(0.4)


def test_the_table_has_a_line_for_the_front_foot(gait):
    console = Console(file=io.StringIO(), width=100)
    print_gait(console, gait)
    assert "front foot" in console.file.getvalue()
    assert "none, at zero" in console.file.getvalue()


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"double_support": 0.0}, "from 0.0004 to 0.2 s"),
        ({"double_support": 0.3}, "from 0.0004 to 0.2 s"),
        ({"double_support": "long"}, "double_support is 'long'"),
        ({"double_support": 0.1, "toe_off": 0.72}, "from 0.7 on at the latest"),
        (
            {"double_support": 0.1, "toe_off": 0.6, "touch_down": "impact"},
            "leave out toe_off or touch_down",
        ),
        ({"double_support": 0.1, "heel_strike": 0.2}, "heel_strike or double_support"),
        ({"double_support": 0.1, "stairs": 0.1}, "double_support or stairs"),
    ],
)
def test_a_double_support_that_cannot_be_is_refused(changes, match):
    with pytest.raises(InputError, match=match):
        preset_task(**changes)


def test_legs_of_other_than_six_joints_are_refused():
    robot = synthetic("seven, waist and arms")
    task = preset_task("humanoid", robot, speed=0.5, duration=0.5, double_support=0.1)
    with pytest.raises(InputError, match="legs of six joints; those of this robot have 7"):
        WalkProblem(robot, task)


def test_an_impact_on_both_feet_wants_legs_alone():
    robot = synthetic("six, waist and arms")
    changes = {"speed": 0.5, "duration": 0.5, "double_support": 0.1, "touch_down": "impact"}
    with pytest.raises(InputError, match="leave out --move"):
        WalkProblem(robot, preset_task("humanoid", robot, **changes))


def test_waist_and_arms_move_while_both_feet_stand():
    robot = synthetic("six, waist and arms")
    task = preset_task("humanoid", robot, speed=0.5, duration=0.5, double_support=0.05)
    found = design(robot, task, DesignOptions(refine=False, diagnose=False))
    assert found.certificate.optimal
    assert found.certificate.refereed
    assert second_engine(found.gait, instants=31).largest < 1e-9
    late = found.gait.time > found.gait.knots[-1]
    moved = np.ptp(found.gait.q[late], axis=0)[12:]
    assert moved.size == 7
    assert moved.max() > 1e-3  # rad


def test_what_cannot_be_told_of_it_is_refused(found):
    with pytest.raises(InputError, match="leave out --double-support"):
        Envelope(found.problem, found.solution.x, np.zeros(found.problem.rows.lower.size))


def test_certificate_is_the_same_from_the_parameters(found):
    again = certify(found.problem, found.solution.x)
    assert again.certified
    assert again.cost == pytest.approx(found.certificate.cost, rel=1e-12)


def test_guess_is_a_walk_of_two_phases(robot):
    problem = WalkProblem(robot, preset_task(duration=0.5, double_support=0.1))
    told = {problem.describe(row) for row in range(problem.rows.lower.size)}
    assert "right_knee torque at 80.0 % of the step (flat)" in told
    assert "front foot, friction cone margin at 100.0 % of the step (both feet)" in told
    gait = gait_at(problem, first_guess(problem), {})
    assert gait.closing
    assert gait.phases[0].end == pytest.approx(0.4)


def test_with_a_free_duration_it_keeps_its_share(robot):
    task = preset_task(duration=0.5, double_support=0.05)
    free = set_geometry(task.geometry, {"duration": {"free": True}})
    options = DesignOptions(diagnose=False)
    found = design(robot, task.with_changes(geometry=free), options)
    assert found.certificate.verdict == "certified"
    _, both = found.gait.phases
    assert both.end == pytest.approx(found.gait.duration)
    assert both.end - both.begin == pytest.approx(0.1 * found.gait.duration)
    assert 0.3 < found.gait.duration < 0.45
    assert found.solution.cost < 0.95 * design(robot, task, options).solution.cost
