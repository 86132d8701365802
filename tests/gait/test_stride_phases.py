"""Strides of two steps whose feet turn about their toes and land on their heels."""

import json
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from reference_cases import biped
from strides import point_of

from gaitopt.design.audit import audit
from gaitopt.design.certificate import certify
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.phase_times import _without_turns
from gaitopt.design.summary import summarise
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.motions.export import stride_record, stride_samples
from gaitopt.simulate.second_engine import second_engine
from gaitopt.view.page import page_text

GIVEN = DesignOptions(diagnose=False, toe_begin="given")
ROUGH = replace(GIVEN, refine=False)


@pytest.fixture(scope="module")
def found():
    """A walk to the left, in a turn, whose stance feet turn about their toes."""
    task = preset_task(speed=1.0, turn_rate=0.3, lateral_speed=0.05, duration=0.5, toe_off=0.7)
    return design(biped(), task, GIVEN)


@pytest.fixture(scope="module")
def gait(found):
    return found.gait


def test_it_is_certified_and_its_feet_turn_differently(found, gait):
    assert found.certificate.verdict == "certified"
    first, second = (step.foot_angle for step in gait.steps)
    assert min(first, second) > 0.1
    assert abs(first - second) > 0.01
    assert (gait.lateral_speed, gait.turn_rate) == pytest.approx((0.05, 0.3))


def test_a_second_engine_signs_both_steps(gait):
    engine = second_engine(gait, 61)
    assert engine.instants == 122
    assert 0.0 < engine.largest < 1e-9


@pytest.mark.parametrize("more", [{}, {"heel_strike": 0.15}])
def test_the_step_of_a_straight_walk_is_an_optimal_stride(more):
    """Same cost, same motion, KKT conditions of the stride, without solving it."""
    task = preset_task(speed=1.0, duration=0.5, toe_off=0.7, **more)
    one = design(biped(), task, ROUGH)
    problem = WalkProblem(biped(), replace(task, stride=True))
    x = problem.layout.pack([one.solution.x, one.solution.x])
    certificate = certify(problem, x)
    assert problem.values(x).cost == pytest.approx(one.solution.cost, rel=1e-10)
    assert certificate.optimal, certificate.kkt
    assert certificate.refereed, certificate.referee
    own = one.problem.step(one.solution.x)
    for step in problem.steps(x):
        assert relative_error(step.whole_motion, own.whole_motion) < 1e-10


def test_each_step_begins_on_the_foot_that_the_other_has_turned():
    problem, x = point_of("every way, heel strike, toe off, everything free")
    x = x.copy()
    x[problem.layout.names.index("second_step_foot_angle_at_end")] += 0.05
    x[problem.layout.names.index("second_step_landing_angle")] -= 0.03
    first, second = problem.steps(x)
    assert second.turn.angle == pytest.approx(first.turn.angle + 0.05)
    for step, before in ((first, second), (second, first)):
        E = problem.models[0].exchange
        assert step.posture.q_start == pytest.approx(E @ before.q_end, abs=1e-12)
        assert step.foot_motion[0, -1].max() == pytest.approx(step.turn.angle)
        assert step.foot_motion[0, 0, 0] == pytest.approx(before.landed.angle)
        assert step.foot_motion[1, 0, 0] == pytest.approx(before.impact.turn_rate)


def test_both_sides_of_every_change_are_instants_of_either_step():
    problem, _ = point_of("every way, heel strike, toe off, everything free")
    changes = problem.schedule.changes
    for model in problem.models:
        instants = model.grid.instants
        for change in changes:
            assert (instants == change).sum() == 1
            assert ((instants > change) & (instants < change + 1e-10)).sum() == 1
    assert len(problem.changes) == 2 * len(changes) + 1
    told = {problem.describe(row) for row in range(problem.rows.lower.size)}
    assert any(one.endswith("of the stride (toe line)") for one in told)


def test_the_file_keeps_both_steps(gait, tmp_path):
    path = save_gait(gait, tmp_path / "gait.npz")
    again = load_gait(path)
    for one, other in zip(again.steps, gait.steps, strict=True):
        assert one.phases == other.phases
        assert one.foot_coefficients == pytest.approx(other.foot_coefficients, abs=1e-15)
    t = np.linspace(0.0, 4.0 * gait.duration, 41)
    assert relative_error(again.trajectory.at(t).torque, gait.trajectory.at(t).torque) < 1e-9
    assert audit(again).passed
    with np.load(path) as content:
        schedule = json.loads(str(content["schedule"]))
        kept = {key: content[key] for key in content.files if key != "second_foot_knots_1"}
    contacts = [next(iter(one["contacts"].items())) for one in schedule["phases"]]
    assert contacts == [
        ("right_sole", "flat"), ("right_sole", "toe line"),
        ("left_sole", "flat"), ("left_sole", "toe line"),
    ]  # fmt: skip
    np.savez(path, **kept)
    with pytest.raises(GaitFileError):
        load_gait(path)


def test_trajectory_goes_on_from_stride_to_stride(gait):
    trajectory, T = gait.trajectory, gait.duration
    for time in (T, 2.0 * T, 3.0 * T):
        before, after = trajectory.at([time], before=True), trajectory.at([time])
        assert after.q == pytest.approx(before.q, abs=1e-9)
        assert after.sole == pytest.approx(before.sole, abs=1e-9)
    for time in (0.7 * T, 1.7 * T):
        before, after = trajectory.at([time], before=True), trajectory.at([time])
        assert after.dq == pytest.approx(before.dq, abs=1e-9)


def test_summary_page_and_export_are_made(gait):
    assert summarise(gait)["contact"]["foot_turns_from_s"] == pytest.approx(0.35)
    assert "toe line" in page_text(gait, 1)
    told = stride_record(gait, stride_samples(gait))["standing_foot_turn"]
    assert [one["coefficients"] for one in told] == [
        step.foot_coefficients.tolist() for step in gait.steps
    ]


def test_a_second_step_with_other_contacts_is_refused(gait):
    flat = {f"foot_{name}": np.zeros(0) for name in ("hinge", "knots", "coefficients")}
    with pytest.raises(InputError, match="with the contacts of its first"):
        replace(gait, second=replace(gait.second, **flat, foot_contact=""))


def test_the_flat_walk_begins_with_what_it_has_of_the_turning_one(found):
    problem, x = found.problem, found.solution.x
    flat = replace(problem.task, toe_off=None)
    kept = _without_turns(problem, flat, x)
    names = WalkProblem(problem.robot, flat).layout.names
    assert kept.size == len(names)
    at = problem.layout.names.index("second_step_right_knee_at_knot_1")
    assert kept[names.index("second_step_right_knee_at_knot_1")] == x[at]
