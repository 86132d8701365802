import functools
import json
import re
import time
from dataclasses import replace

import numpy as np
import pytest
from reference_cases import biped, reference_task

from gaitopt.design import design as search
from gaitopt.design import diagnosis as diagnosing
from gaitopt.design.active_set import violated_rows
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.conflict import contradictions
from gaitopt.design.design import design
from gaitopt.design.diagnosis import diagnose
from gaitopt.design.options import DesignOptions, Search
from gaitopt.design.pipeline import attempt
from gaitopt.errors import NoGaitFoundError, UnreachableError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.robot import JointLimits
from gaitopt.nlp import violations
from gaitopt.solvers import solver_by_name
from gaitopt.units import digits

QUICK = DesignOptions(solver=solver_by_name("sqp", max_iterations=60), refine=False)
COARSE = {"samples": 21}  # for speed
INFEASIBLE = {
    "weak motors": ({"torque_limit": 25.0}, "torque", "torque_limit"),
    "slow motors": ({"speed_limit": 2.0, **COARSE}, "speed", "speed_limit"),
    "margin wider than the foot": ({"cop_margin": 0.07, **COARSE}, "cop", "cop_margin"),
    "step longer than the legs": ({"speed": 3.2, **COARSE}, "walking speed", "speed"),
    "ice": ({"friction": 0.02, "torque_limit": 45.0, **COARSE}, "friction", "friction"),
    "a leap": ({"liftoff_speed": 1.0, **COARSE}, "lift-off", "liftoff_speed"),
    "knees bent too far": ({"knee_flexion": 2.5, **COARSE}, "knee", "knee_flexion"),
    "feet in one line": ({"step_width": 0.1, **COARSE}, "lateral", "step_width"),
}
BETWEEN = "weak motors"  # the one whose suggestions must hold between the samples too


@functools.cache
def refusal(name):
    """The error that an infeasible task ends with; computed only where it is asked for."""
    changes, _, _ = INFEASIBLE[name]
    caught_by = pytest.raises((NoGaitFoundError, UnreachableError))
    with pytest.MonkeyPatch.context() as patch, caught_by as caught:
        patch.setattr(diagnosing, "ENOUGH", 2)  # for speed
        design(biped(), reference_task(**changes), replace(QUICK, refine=name == BETWEEN))
    return caught.value


@pytest.fixture(params=INFEASIBLE, scope="module")
def case(request):
    """One infeasible task; the scope makes pytest run all its tests in one go."""
    changes, constraint, setting = INFEASIBLE[request.param]
    return reference_task(**changes), constraint, setting, refusal(request.param).diagnosis


def changed_problem(robot, task, suggestion):
    """The walk with a suggestion followed, put together without the code that made it."""
    name, value = suggestion.setting, suggestion.after
    if name in ("speed", "duration"):
        return WalkProblem(robot, replace(task, **{name: value}))
    if name == "robot joint ranges":
        lower, upper = robot.limits.lower - value, robot.limits.upper + value
        limits = JointLimits(robot.limits.torque, robot.limits.speed, lower, upper)
        return WalkProblem(replace(robot, limits=limits), task)
    margins = replace(task.margins, **{name: bool(value) if name == "impulse_cop" else value})
    return WalkProblem(robot, replace(task, margins=margins))


def test_the_constraint_in_the_way_is_named(case):
    _, constraint, _, diagnosis = case
    assert constraint in diagnosis.constraints
    named = {c.constraint: c for c in diagnosis.conflict}
    assert named[constraint].amount > 0.0
    assert named[constraint].row
    assert diagnosis.violation > 1e-4
    assert sum(c.share for c in diagnosis.conflict) <= 1.0 + 1e-9


def test_its_own_knob_is_suggested(case):
    task, _, setting, diagnosis = case
    found = {s.setting: s for s in diagnosis.suggestions}
    assert setting in found
    before = task.speed if setting == "speed" else getattr(task.margins, setting)
    assert found[setting].before == before
    grows = setting in ("torque_limit", "speed_limit", "friction", "step_width")
    assert (found[setting].after > before) == grows


def test_every_suggestion_has_a_walk(robot, case):
    """Each is followed, and the walk that comes with it judged by the changed task itself."""
    task, _, _, diagnosis = case
    for suggestion in diagnosis.suggestions:
        problem = changed_problem(robot, task, suggestion)
        values = problem.values(suggestion.gait)
        excess = violations(problem.rows.lower, problem.rows.upper, values.rows)
        assert excess.max() <= 1e-6, suggestion.sentence
        assert values.cost == pytest.approx(suggestion.cost)


def test_a_suggestion_holds_between_the_samples(robot):
    task = reference_task(**INFEASIBLE[BETWEEN][0])
    for suggestion in refusal(BETWEEN).diagnosis.suggestions:
        problem = changed_problem(robot, task, suggestion)
        assert not violated_rows(on_fine_grid(problem), suggestion.gait)


def test_a_suggestion_is_the_least_that_helps(robot):
    """Half of the change does not do: motors of 33 N.m are too weak as well."""
    task = reference_task(**INFEASIBLE[BETWEEN][0])
    weak = next(s for s in refusal(BETWEEN).diagnosis.suggestions if s.setting == "torque_limit")
    half = (weak.before + weak.after) / 2.0
    task = replace(task, margins=replace(task.margins, torque_limit=half))
    with pytest.raises(NoGaitFoundError):
        design(robot, task, replace(QUICK, diagnose=False))


def test_a_suggestion_can_be_designed(robot):
    task = reference_task(**INFEASIBLE[BETWEEN][0])
    weak = next(s for s in refusal(BETWEEN).diagnosis.suggestions if s.setting == "torque_limit")
    task = replace(task, margins=replace(task.margins, torque_limit=weak.after))
    found = design(robot, task, QUICK, start=weak.gait)
    assert 1000.0 < found.gait.cost <= weak.cost * (1.0 + 1e-9)
    assert weak.before < np.abs(found.gait.torque).max() <= weak.after * (1.0 + 1e-6)


def test_following_a_suggestion_leads_to_the_walk_that_it_names(robot):
    for suggestion in refusal(BETWEEN).diagnosis.suggestions:
        again = design(
            suggestion.robot, suggestion.task, suggestion.options, start=suggestion.start
        )
        assert again.certificate.certified
        assert again.gait.cost == pytest.approx(suggestion.cost, rel=1e-6)
        assert robot.mass == suggestion.robot.mass


def test_a_suggestion_changes_more_than_its_digits_hide(case):
    *_, diagnosis = case
    for suggestion in diagnosis.suggestions:
        if suggestion.setting != "impulse_cop":
            before, after = f"{suggestion.before:g}", digits(suggestion.after)
            assert before != after
            assert float(after) == suggestion.after
            assert f" to {after}" in suggestion.sentence


@pytest.mark.parametrize(
    "value", [150.0, 0.1, 1.0 / 3.0, 1e-9, 123456789.125, -0.00986, 9.999999999999998]
)
def test_a_number_is_printed_with_the_digits_it_has(value):
    assert float(digits(value)) == value


def test_the_usual_solver_is_suggested_where_another_gives_up(robot, monkeypatch):
    """A solver that leads nowhere, even from the walk that the diagnosis finds."""
    problem = WalkProblem(robot, preset_task(samples=21))
    hopeless = replace(QUICK, solver=solver_by_name("sqp", max_iterations=1))
    nowhere = attempt(problem, Search(hopeless), first_guess(problem))
    monkeypatch.setattr(search, "attempt", lambda *_: nowhere)
    with pytest.raises(NoGaitFoundError) as caught:
        design(robot, problem.task, hopeless)
    diagnosis = caught.value.diagnosis
    assert diagnosis.gait is not None
    (suggestion,) = diagnosis.suggestions
    assert suggestion.setting == ""
    assert suggestion.options.solver == DesignOptions().solver
    assert "the default solver" in diagnosis.sentences[-1]


def test_without_a_relaxation_the_usual_values_are_suggested(robot):
    task = preset_task(torque_limit=5.0, liftoff_speed=1.0, **COARSE)
    problem = WalkProblem(robot, task)
    found, tried = diagnosing.find_suggestions(problem, None, Search(QUICK))
    assert tried  # alone neither suffices
    (suggestion,) = found
    assert {change.setting for change in suggestion.changes} == {"torque_limit", "liftoff_speed"}
    assert suggestion.task.margins.liftoff_speed == preset_task().margins.liftoff_speed
    assert suggestion.found.certificate.optimal


def test_two_limits_that_are_both_hopeless_are_changed_together(robot):
    """Feet in one line and motors too weak: neither change alone does, and both are told."""
    task = preset_task(step_width=0.1, torque_limit=20.0, **COARSE)
    with pytest.raises(NoGaitFoundError) as caught:
        design(robot, task, QUICK)
    (suggestion,) = caught.value.diagnosis.suggestions
    changes = {change.setting: change for change in suggestion.changes}
    assert {"step_width", "torque_limit"} == {*changes}
    again = design(suggestion.robot, suggestion.task, suggestion.options, start=suggestion.start)
    assert again.proven
    assert again.gait.cost == pytest.approx(suggestion.cost, rel=1e-6)
    expected = {k: getattr(suggestion.task.margins, k) for k in changes}
    assert {k: c.after for k, c in changes.items()} == expected
    assert all(c.sentence in suggestion.sentence for c in suggestion.changes)
    record = json.loads(json.dumps(suggestion.record(), allow_nan=False))
    assert [record["setting"], *(c["setting"] for c in record["also"])] == [*changes]


def test_people_can_read_it(case):
    task, _, setting, diagnosis = case
    text = "\n".join(diagnosis.sentences)
    assert "the least violation found leaves" in text
    assert "the smallest relaxation found that admits a walk: " in text
    suggestion = next(s for s in diagnosis.suggestions if s.setting == setting)
    assert f"({setting}) from {suggestion.before:g} to {suggestion.after:g}" in text
    assert "nan" not in text
    assert task.speed > 0.0


def test_machines_can_read_it(case):
    *_, diagnosis = case
    record = json.loads(json.dumps(diagnosis.record(), allow_nan=False))
    assert record["sentences"] == list(diagnosis.sentences)
    assert [s["after"] for s in record["suggestions"]] == [s.after for s in diagnosis.suggestions]
    assert [c["constraint"] for c in record["conflict"]] == list(diagnosis.constraints)
    assert len(record["suggestions"][0]["gait"]) == 43


def test_the_error_carries_what_is_known():
    error = refusal("weak motors")
    assert isinstance(error, NoGaitFoundError)
    assert error.exit_code == 3
    assert error.solution.violation >= error.diagnosis.violation > 0.01
    long_step = refusal("step longer than the legs")
    assert isinstance(long_step, UnreachableError)
    assert "at most 1.164 m" in long_step.diagnosis.sentences[0]
    assert re.search(r"leaves a step that is 0\.2\d* m too short", long_step.diagnosis.sentences[1])


@pytest.mark.parametrize(
    ("changes", "constraint", "sentence"),
    [
        ({"cop_margin": 0.07}, "cop", "0.07 m from every edge .* sole 0.136 m wide"),
        ({"minimum_load": 600.0}, "load", "600 N .* weight of the robot, 557.9 N"),
        ({"knee_flexion": 2.7}, "knee", "_knee bends by at most 2.6 rad; .* at least 2.7 rad"),
        ({"step_width": 0.14}, "lateral", "at most 0.14 m apart .* at least 0.146 m are needed"),
        ({"speed": 3.0}, "leg length", r"a step of 1.200 m .* at most 1.164 m"),
        ({"speed": 1e9}, "leg length", r"a step of 4e\+08 m \(1e\+09 m/s for"),
        ({"speed": 2.5, "leg_extension": 0.5}, "leg length", r"1.000 m .*leg_extension.* most 0"),
        ({"clearance": 0.9}, "clearance", r"clearance of 0.9 m .* to where the hips are, 0\.\d+ m"),
    ],
)
def test_what_no_motion_can_meet_is_seen_at_once(robot, changes, constraint, sentence):
    found = contradictions(WalkProblem(robot, reference_task(**changes)))
    assert {name for name, _ in found} == {constraint}
    assert all(re.search(sentence, said) for _, said in found)


@pytest.mark.parametrize(
    ("fixed", "margins", "sentence"),
    [
        ({"trunk_pitch": 0.3}, {"trunk_pitch": 0.2}, "trunk_pitch is fixed at 0.3 .* most 0.2 rad"),
        ({"pelvis_yaw": -0.1}, {"trunk_yaw": 0.05}, "pelvis_yaw is fixed at -0.1 .* trunk_yaw"),
        ({"foot_spacing": 0.1}, {}, r"fixed at 0.1 m apart \(foot_spacing\) leave no gap"),
    ],
)
def test_what_is_held_and_what_is_allowed_must_agree(robot, fixed, margins, sentence):
    values = {name: {"free": False, "value": value} for name, value in fixed.items()}
    task = preset_task(geometry=set_geometry(GEOMETRY, values), **margins)
    ((_, said),) = contradictions(WalkProblem(robot, task))
    assert re.search(sentence, said)


def test_a_walk_that_can_be_walked_contradicts_nothing(robot):
    limits = {"cop_margin": 0.067, "minimum_load": 557.0, "knee_flexion": 2.59, "speed": 2.9}
    assert contradictions(WalkProblem(robot, preset_task(**limits, step_width=0.147))) == ()


def test_a_walk_found_after_all_is_handed_over(robot, standard_task):
    problem = WalkProblem(robot, standard_task)
    diagnosis = diagnose(problem)
    assert diagnosis.gait is not None
    excess = violations(problem.rows.lower, problem.rows.upper, problem.values(diagnosis.gait).rows)
    assert excess.max() <= 1e-6
    assert diagnosis.sentences == (
        "a walk that keeps every limit at its samples exists; from there no proven one was found",
    )
    assert diagnosis.suggestions == ()


def test_a_diagnosis_can_be_done_without(robot):
    with pytest.raises(UnreachableError) as caught:
        design(robot, preset_task(speed=3.2), replace(QUICK, diagnose=False))
    assert caught.value.diagnosis is None


ABSURD = {
    "speed": 1e18, "clearance": 1e18, "knee_flexion": 1e12, "minimum_load": 1e18,
    "lateral_gap": 1e12, "torque_limit": 1e-18, "liftoff_speed": 1e18, "cop_margin": 1e15,
}  # fmt: skip


@pytest.mark.parametrize("name", ABSURD)
def test_what_is_absurd_ends_soon_with_words(name, monkeypatch):
    """Of the search and the first tries of its diagnosis; they did not end in a minute."""
    monkeypatch.setattr(diagnosing, "ENOUGH", 1)
    began = time.process_time()
    with pytest.raises((NoGaitFoundError, UnreachableError)) as caught:
        design(biped(), reference_task(**{name: ABSURD[name]}, samples=11), QUICK)
    assert caught.value.diagnosis.reasons
    assert time.process_time() - began < 20.0  # s, of the processor
