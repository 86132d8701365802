"""Double supports in which the rear foot turns about its toe, before and while both feet stand."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from walk_checks import (
    check_base_moves_as_its_twist_says,
    check_ground_holds,
    check_referee_agrees,
    everywhere,
    refereed,
)
from walks import walk

from gaitopt.contact import FlatFoot, Phase, PhaseEnd, Schedule, ToeLine
from gaitopt.design.audit import audit
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.phase_times import _after
from gaitopt.design.summary import summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait import quantities
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.presets import preset_task
from gaitopt.simulate.second_engine import second_engine
from gaitopt.tolerances import REFEREE
from gaitopt.view.page import page_text

NAME = "upright, double support, toe off"
OPTIONS = DesignOptions(diagnose=False, toe_begin="given")
TOUCH = 0.4  # s


@pytest.fixture(scope="module")
def found(robot):
    """The best walk at 1 m/s whose rear foot turns from 0.6 of the step on, the last fifth both."""
    task = preset_task(duration=0.5, double_support=0.1, toe_off=0.6)
    return design(robot, task, OPTIONS)


@pytest.fixture(scope="module")
def gait(found):
    return found.gait


def test_it_is_certified_and_costs_less_than_on_flat_feet(found):
    assert found.certificate.verdict == "certified"
    problem = found.problem
    names = [phase.name for phase in problem.schedule.phases]
    assert names == ["flat", "toe line", "both feet"]
    flat = replace(problem.task, toe_off=None)
    softly = design(problem.robot, flat, DesignOptions(refine=False, diagnose=False))
    assert found.solution.cost < 0.7 * softly.solution.cost
    assert found.gait.foot_angle > 0.3


def test_the_feet_keep_their_contacts_at_5001_instants(found):
    """The rear foot's pressure is in the strip while it turns, the front one's in its sole."""
    problem, instants = found.problem, np.linspace(0.0, 1.0, 5001)
    step, sole = everywhere(problem, found.solution.x), problem.robot.sole
    turning, late = instants > 0.6, instants > 0.8
    check_ground_holds(problem, step.read(quantities.WRENCH))
    check_ground_holds(problem, step.read(quantities.FRONT_WRENCH)[late])
    wrench = step.read(quantities.WRENCH)[turning]
    x = -wrench[:, 4] / wrench[:, 2]
    assert x.max() < sole.toe + 1e-4
    assert x.min() > sole.toe - problem.task.toe_strip - 1e-4
    front = step.read(quantities.FRONT_WRENCH)[late]
    x = -front[:, 4] / front[:, 2]
    assert x.min() > sole.heel + problem.task.margins.cop_margin - 1e-4
    assert np.ptp(x) > 0.05  # it is not held to a strip
    assert step.foot_motion[0, turning].min() > -1e-6
    corners = step.support.corners[late]
    assert np.abs(corners[:, :, 2]).max() < 1e-12
    assert np.ptp(corners, axis=0).max() < 1e-12


def test_the_rear_foot_turns_on_while_both_stand_and_leaves_as_it_turns(gait):
    trajectory, T = gait.trajectory, gait.duration
    for time in (TOUCH, T):
        before, after = trajectory.at([time], before=True), trajectory.at([time])
        assert after.q == pytest.approx(before.q, abs=1e-12)
        assert after.dq == pytest.approx(before.dq, abs=1e-9)
        assert after.sole == pytest.approx(before.sole, abs=1e-12)
        assert after.base_twist == pytest.approx(before.base_twist, abs=1e-9)
    times = np.array([0.3, TOUCH, 0.45, 0.5])
    tilts = -trajectory.at(times, before=np.full(4, True)).sole[:, 0, 2, 0]
    assert np.diff(tilts).min() > 0.05
    assert tilts[-1] == pytest.approx(np.sin(gait.foot_angle))


def test_base_moves_as_its_twist_says(gait):
    times = np.array([0.35, 0.43, 0.46, gait.duration + 0.38, gait.duration + 0.47])
    check_base_moves_as_its_twist_says(gait.trajectory, times)


def test_trajectory_is_the_step(found, gait):
    problem, x, T = found.problem, found.solution.x, gait.duration
    step, trajectory = problem.step(x), gait.trajectory
    times = problem.grid.instants * T
    begun = (times > 0.3) & (times < 0.3 + 1e-9) | (times > TOUCH) & (times < TOUCH + 1e-9)
    at, moving = (
        trajectory.at(times, before=(times > 0.0) & ~begun), problem.robot.multibody.moving,
    )  # fmt: skip
    motion = np.stack([at.q, at.dq, at.ddq])[:, :, moving]
    assert relative_error(motion, step.motion) < 1e-9
    assert relative_error(at.torque[:, moving], step.read(quantities.TORQUE)) < 1e-9
    assert relative_error(at.wrench[:, 1], step.read(quantities.FRONT_WRENCH)) < 1e-9


def test_a_second_engine_signs_with_the_forces_of_both_feet(gait):
    assert 0.0 < second_engine(gait).largest < 1e-9


def test_the_referee_agrees_and_sees_a_wrong_turn():
    problem, step = check_referee_agrees(walk(NAME).problem, walk(NAME).x)
    turned = step.foot_motion.copy()
    turned[2] *= 1.001
    wrong = replace(step, foot_motion=turned)
    verdict = refereed(problem, wrong)
    assert min(verdict.torque, verdict.wrench) > REFEREE


def test_the_file_keeps_three_phases(gait, tmp_path):
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    assert again.phases == gait.phases
    assert [one.contact for one in again.phases] == ["flat", "toe line", "both feet"]
    assert again.foot_knots == pytest.approx(gait.foot_knots, abs=1e-15)
    t = np.linspace(0.0, 2.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-9
    assert audit(again).passed
    with np.load(path) as content:
        schedule = json.loads(str(content["schedule"]))
        kept = {key: content[key] for key in content.files if key != "foot_knots_2"}
    assert [one["end"] for one in schedule["phases"]] == ["smooth", "touch-down", "lift-off"]
    assert schedule["phases"][2]["contacts"] == {"right_sole": "toe line", "left_sole": "flat"}
    np.savez(path, **kept)
    with pytest.raises(GaitFileError):
        load_gait(path)


def test_summary_and_page_tell_the_phases(gait):
    contact = summarise(gait)["contact"]
    begins = [phase["begin_s"] for phase in contact["phases"]]
    assert begins == pytest.approx([0.0, 0.3, TOUCH])
    assert contact["front_foot"]["least_vertical_force_N"] > 0.9
    assert contact["foot_turns_from_s"] == pytest.approx(0.3)
    page = page_text(gait, 1)
    assert re.search(r'"both": ?true', page)
    assert "° as it leaves" in page


def test_the_search_ends_before_the_touch_down():
    task = preset_task(duration=0.5, double_support=0.1, toe_off=0.6)
    assert _after(task, "toe_off", 0.15).toe_off == pytest.approx(0.75)
    assert _after(task, "toe_off", 0.16) is None
    assert _after(replace(task, double_support=None), "toe_off", 0.35).toe_off == 0.95


def test_a_rear_foot_that_changes_its_contact_at_touch_down_is_refused():
    toe, flat = ToeLine(0.01), FlatFoot()
    ends = Phase(toe, 0.8, PhaseEnd.TOUCH_DOWN), Phase(flat, 1.0, PhaseEnd.LIFT_OFF, both=True)
    with pytest.raises(InputError, match="let it stand flat between"):
        Schedule((Phase(flat, 0.6, PhaseEnd.SMOOTH), *ends))
