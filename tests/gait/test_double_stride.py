"""Strides of two steps, sideways and in turns, each of which ends with both feet on the ground."""

import functools
import json

import numpy as np
import pytest
from numerics import relative_error
from reference_cases import biped

from gaitopt.design.audit import audit
from gaitopt.design.options import DesignOptions
from gaitopt.design.starts import design_gait
from gaitopt.design.summary import summarise
from gaitopt.gait.assemble import gait_at
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.initial_guess import first_guess, perturbed
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.motions.export import stride_record, stride_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.view.page import page_text

BOTH = {"duration": 0.5, "double_support": 0.05}


@functools.cache
def found(**changes):
    task = preset_task(**{"speed": 0.8, **BOTH, **changes})
    return design_gait(biped(), task, DesignOptions(diagnose=False))


@pytest.fixture(scope="module")
def gait():
    """A guess that turns and goes aside, whose rear foot turns about its toe, disturbed."""
    task = preset_task(
        speed=0.5, lateral_speed=0.1, turn_rate=0.3, duration=0.5, double_support=0.1, toe_off=0.6
    )
    problem = WalkProblem(biped(), task)
    return gait_at(problem, perturbed(problem, first_guess(problem), 0.02, 3), {})


def test_a_straight_stride_solved_is_the_walk_of_one_step():
    one, two = found(), found(stride=True)
    assert two.certificate.verdict == "certified"
    assert two.solution.cost == pytest.approx(one.solution.cost, rel=1e-8)
    for step in two.gait.steps:
        assert relative_error(step.q, one.gait.q) < 1e-5
        assert relative_error(step.torque, one.gait.torque) < 1e-4


def test_turns_to_either_side_are_mirror_images():
    left, right = found(turn_rate=0.4), found(turn_rate=-0.4)
    assert left.certificate.verdict == right.certificate.verdict == "certified"
    assert left.solution.cost == pytest.approx(right.solution.cost, rel=1e-8)
    for one, other in zip(left.gait.steps, reversed(right.gait.steps), strict=True):
        assert relative_error(one.q, other.q) < 1e-6
        assert relative_error(one.torque, other.torque) < 1e-6
        assert relative_error(one.front_wrench, other.front_wrench) < 1e-5
    assert left.gait.turn_rate == pytest.approx(0.4)


@pytest.mark.parametrize(
    "way",
    [
        {"speed": 0.5, "lateral_speed": 0.1},
        {"speed": -0.4, "stride": True},
        {"speed": 0.0, "lateral_speed": 0.1},
        {"speed": 0.5, "cross_slope": 0.05},
    ],
)
def test_walks_of_every_way_are_certified_by_both_engines(way):
    one = found(**way)
    assert one.certificate.verdict == "certified"
    assert second_engine(one.gait, instants=31).largest < 1e-9
    assert audit(one.gait).passed


def test_both_feet_bear_where_the_wrench_is_shared(gait):
    signed = second_engine(gait, instants=61)
    assert 0.0 < signed.largest < 1e-9
    trajectory, T = gait.trajectory, gait.duration
    for time in (0.9 * T, 1.9 * T):
        at = trajectory.at([time])
        assert at.contact.all()
        soles = at.sole[0, :, :3, 3]
        later = trajectory.at([time + 0.03 * T]).sole[0, :, :3, 3]
        front = 1 - int(at.standing[0])
        assert later[front] == pytest.approx(soles[front], abs=1e-9)  # the rear one turns


def test_nothing_jumps_from_step_to_step(gait):
    trajectory, T = gait.trajectory, gait.duration
    for time in (0.8 * T, T, 1.8 * T, 2.0 * T):
        before, after = trajectory.at([time], before=True), trajectory.at([time])
        assert after.q == pytest.approx(before.q, abs=1e-9)
        assert after.dq == pytest.approx(before.dq, abs=1e-8)
        assert after.sole == pytest.approx(before.sole, abs=1e-9)


def test_the_file_keeps_both_steps(gait, tmp_path):
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    for one, other in zip(again.steps, gait.steps, strict=True):
        assert one.phases == other.phases
        assert one.front_wrench == pytest.approx(other.front_wrench)
        assert one.foot_coefficients == pytest.approx(other.foot_coefficients, abs=1e-12)
    t = np.linspace(0.0, 4.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-9
    with np.load(path) as content:
        schedule = json.loads(str(content["schedule"]))
    assert [one["contacts"] for one in schedule["phases"]] == [
        {"right_sole": "flat"}, {"right_sole": "toe line"},
        {"right_sole": "toe line", "left_sole": "flat"},
        {"left_sole": "flat"}, {"left_sole": "toe line"},
        {"left_sole": "toe line", "right_sole": "flat"},
    ]  # fmt: skip


def test_summary_page_and_export_are_made(gait):
    assert summarise(gait)["contact"]["front_foot"] is not None
    assert "toe line" in page_text(gait, 1)
    told = stride_record(gait, stride_samples(gait))["double_support"]
    assert [one["front_wrench"] for one in told] == [
        step.front_wrench.tolist() for step in gait.steps
    ]
