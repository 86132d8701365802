"""Co-design: the outer gradient, the search, resuming, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from example_robots import needs_example_robots
from one_motor import ONE_MOTOR

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.entries import description, entry_by_name
from gaitopt.catalogue.parameters import PARAMETERS, changed
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.design.codesign import (
    DESIGN,
    DesignTrial,
    Study,
    Variable,
    WalkCase,
    WarmWalks,
    box_step,
    codesign,
    first_walks,
    minimised,
    own_ratio,
    own_values,
    with_proportions,
)
from gaitopt.design.options import DesignOptions
from gaitopt.errors import InputError
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import cost_of_text
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.capsules import capsule_rows, leg_capsules
from gaitopt.model.import_options import PartChange
from gaitopt.model.robot import Robot
from gaitopt.solvers import solver_by_name
from gaitopt.solvers.hessian import damped_bfgs

QUICK = DesignOptions(solver=solver_by_name("sqp", tolerance=1e-9))


def robot(values):
    return Robot.from_urdf(urdf_text(changed(biped13(), values)))


def walks(*speeds):
    return tuple(
        WalkCase(f"{v:g} m/s", weight, preset_task(speed=v, samples=21), robot)
        for weight, v in enumerate(speeds, 1)
    )


LEGS = Study(
    biped13(),
    (Variable("shin", 0.29, 0.31, 0.3), Variable("hip_width", 0.11, 0.13, 0.12)),
    walks(0.7), keep_leg=True,
)  # fmt: skip


@pytest.fixture(scope="module")
def first():
    return list(first_walks(LEGS, QUICK, starts=1))


def test_the_outer_gradient_is_that_of_walks_solved_again(first):
    held = WarmWalks(LEGS, first, QUICK)
    at = np.array([0.302, 0.118])
    trial = held.trial(at, None)
    twice = WarmWalks(replace(LEGS, walks=walks(0.7, 0.7)), [*first, *first], QUICK)
    both = twice.trial(at, None)
    assert both.cost == pytest.approx(3.0 * trial.cost)
    np.testing.assert_allclose(both.gradient, 3.0 * trial.gradient, rtol=1e-6)
    for k, h in enumerate((2e-5, 2e-5)):
        move = h * np.eye(2)[k]
        ends = [held.trial(at + side * move, trial).cost for side in (1.0, -1.0)]
        assert trial.gradient[k] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), rel=1e-5)


TABLE = ONE_MOTOR.apart("knee", ["right_knee", "left_knee", "right_ankle_roll"])


def geared(*variables, robot=robot, **task):
    """The study of walks of the least sum of squared torques and electrical energy."""
    motors = TABLE.at_joints
    cost = cost_of_text("torque + 3 energy", motors=motors)
    own = preset_task(speed=0.8, samples=21, cost=cost, constraints=[MotorEnvelope(motors)], **task)
    return Study(biped13(), variables, (WalkCase("0.8 m/s", 1.0, own, robot),), motors=TABLE)


@pytest.mark.parametrize("names", [("motors.knee.ratio", "shin"), ("motors.ratio", "hip_width")])
def test_the_outer_gradient_in_gear_ratios(names):
    limited = geared(
        *(Variable(n, 0.5 * v, 2.0 * v, v)
          for n, v in zip(names, (10.0, 0.3 if "shin" in names else 0.12), strict=True)),
    )  # fmt: skip
    held = WarmWalks(limited, list(first_walks(limited, QUICK, starts=1)), QUICK)
    at = np.array([v.start * more for v, more in zip(limited.variables, (1.02, 1.01), strict=True)])
    trial = held.trial(at, None)
    rotors = limited.each(limited.parameters(at))[0][0].multibody.armature
    assert rotors[rotors > 0.0].max() == pytest.approx(10.2**2 * 1e-4)
    for k, h in enumerate((1e-3, 1e-5)):
        move = h * np.eye(2)[k]
        ends = [held.trial(at + side * move, trial).cost for side in (1.0, -1.0)]
        assert trial.gradient[k] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), rel=1e-5)


def test_gear_ratios_that_cannot_be_chosen_are_refused():
    knee, every = (Variable(f"motors.{n}ratio", 5.0, 20.0, 10.0) for n in ("knee.", ""))
    with pytest.raises(InputError, match=r"'knee' is chosen twice, by motors.knee.ratio and by"):
        geared(knee, every)
    with pytest.raises(InputError, match=r"nothing is known; give a table of them: --motors"):
        Study(biped13(), (knee,), walks(0.7))
    with pytest.raises(InputError, match=r"no drive has the joints 'wrist'; there are \*, knee"):
        geared(Variable("motors.wrist.ratio", 5.0, 20.0, 10.0))
    with pytest.raises(InputError, match=r"of this robot it is 10: give 1 to 100 at most$"):
        geared(Variable("motors.ratio", 5.0, 200.0, 10.0))
    with pytest.raises(InputError, match=r"have 10 of '\*', 12 of 'knee'; choose them each, by mo"):
        own_ratio(TABLE.changed({"knee.ratio": 12.0}), "motors.ratio")
    with pytest.raises(InputError, match=r"and ratios of gears, motors.ratio or motors.JOINTS"):
        Variable("motors.knee.inertia", 1e-5, 1e-3, 1e-4)
    with pytest.raises(
        InputError, match=r"'wrist' are no joints; the table has drives of \*, knee"
    ):
        TABLE.apart("wrist", ["right_knee"])
    with pytest.raises(InputError, match=r"'right' have different drives or none; the table has"):
        TABLE.changed({"knee.ratio": 12.0}).apart("right", ["right_knee", "right_hip"])


@needs_example_robots
def test_the_outer_gradient_of_a_robot_of_a_file():
    source, choices = description(entry_by_name("g1"))
    g1 = Robot.from_urdf(source, choices=choices)
    own = own_values(g1)
    assert own["shin"] == pytest.approx(0.30001)  # from knee to ankle in the file
    assert own["foot_mass"] == pytest.approx(0.608)

    def other(values):
        return Robot.from_urdf(g1.urdf, choices=with_proportions(g1, own, values))

    task = preset_task("humanoid", g1, speed=0.6, samples=21, leg_gap=None)
    variables = tuple(
        Variable(name, 0.9 * own[name], 1.1 * own[name], own[name])
        for name in ("shin", "hip_width", "foot_mass", "trunk_mass", "foot_length", "ankle_height")
    )
    study = Study(g1, variables, (WalkCase("0.6 m/s", 1.0, task, other),), keep_leg=True)
    held = WarmWalks(study, list(first_walks(study, QUICK, starts=1)), QUICK)
    at = np.array([1.01 * v.start for v in variables])
    trial = held.trial(at, None)
    assert study.parameters(at)["thigh"] == pytest.approx(own["leg"] - at[0])
    for k, h in enumerate((1e-5, 1e-5, 1e-5, 1e-4, 1e-5, 1e-5)):
        move = h * np.eye(6)[k]
        ends = [held.trial(at + side * move, trial).cost for side in (1.0, -1.0)]
        assert trial.gradient[k] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), rel=1e-5)
    with pytest.raises(InputError, match="of a robot of a file cannot be chosen"):
        Study(g1, (Variable("foot_width", 0.05, 0.07, 0.06),), study.walks)


def test_walks_are_followed_to_legs_so_near_that_other_bodies_count():
    task = preset_task(speed=0.7, samples=21, leg_gap=0.01)
    case = WalkCase("0.7 m/s", 1.0, task, robot)
    study = Study(biped13(), (Variable("hip_width", 0.09, 0.14, 0.13),), (case,))
    walks = WarmWalks(study, list(first_walks(study, QUICK, starts=1)), QUICK)
    wide, near = np.array([0.13]), np.array([0.09])
    rows = [WalkProblem(*study.each(study.parameters(w))[0]).rows.lower.size for w in (wide, near)]
    assert rows[0] > rows[1]
    begun = walks.trial(wide, None)
    walks.trial(near, begun)  # a design with whose gaps the search cannot go on may be none
    assert walks.solved == 2


def test_proportions_add_up_to_those_a_file_is_read_with():
    plain = Robot.from_urdf(urdf_text(biped13()))
    choices = plain.choices.over(proportions=(PartChange("shin", 0.02), PartChange("foot", 0, 0.1)))
    longer = Robot.from_urdf(plain.urdf, choices=choices)
    own = own_values(longer)
    assert own["shin"] == pytest.approx(0.32)
    found = with_proportions(longer, own, {"leg": 0.682, "foot_mass": own["foot_mass"] - 0.1})
    parts = {one.part: (one.longer, one.heavier) for one in found.proportions}
    assert parts["shin"] == pytest.approx((0.052, 0.0))
    assert parts["thigh"] == pytest.approx((0.03, 0.0))
    assert abs(parts.get("foot", (0.0, 0.0))[1]) < 1e-12
    again = own_values(Robot.from_urdf(plain.urdf, choices=found))
    assert again["leg"] == pytest.approx(0.682)


def test_capsules_that_were_kept_are_of_the_lengths_they_were_found_at():
    plain = Robot.from_urdf(urdf_text(biped13()))
    kept = plain.choices.over(capsules=capsule_rows(leg_capsules(plain)))
    recorded = Robot.from_urdf(plain.urdf, choices=kept)
    own = own_values(recorded)
    heavier = with_proportions(recorded, own, {"shin_mass": own["shin_mass"] + 0.1})
    assert heavier.capsules == kept.capsules
    longer, fresh = (
        Robot.from_urdf(plain.urdf, choices=with_proportions(one, own, {"shin": 0.35}))
        for one in (recorded, plain)
    )
    rows = capsule_rows(leg_capsules(longer))
    assert rows == capsule_rows(leg_capsules(fresh)) != kept.capsules


@pytest.mark.parametrize("name", [n for n in DESIGN if not n.startswith("foot_l")])
def test_every_parameter_has_its_derivative(name, first):
    value = PARAMETERS[name].value(biped13())
    study = Study(biped13(), (Variable(name, 0.9 * value, 1.1 * value, value),), walks(0.7))
    held = WarmWalks(study, first, QUICK)
    trial = held.trial(np.array([value]), None)
    h = 1e-3 * value if name == "foot_width" else 1e-4 * value
    ends = [held.trial(np.array([value + side * h]), trial).cost for side in (1.0, -1.0)]
    # what a parameter is made of; how exact derivatives are is seen in test_sensitivity.py
    assert trial.gradient[0] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), rel=3e-3)


def test_a_search_that_is_interrupted_goes_on_to_the_same_end(first):
    told: list[DesignTrial] = []
    whole = codesign(LEGS, QUICK, before=first, starts=1, on_trial=told.append)
    assert len(told) == len(whole.trials) > 3
    more: list[DesignTrial] = []
    again = codesign(LEGS, QUICK, before=first, earlier=told[:3], starts=1, on_trial=more.append)
    assert len(more) == len(told) - 3
    np.testing.assert_array_equal(again.trials[-1].values, whole.trials[-1].values)
    assert [g.cost for g in again.after] == [g.cost for g in whole.after]
    before, after = (sum(g.cost for g in gaits) for gaits in (whole.before, whole.after))
    assert after < 0.97 * before
    assert all(gait.fact("certificate", "certified") for gait in whole.after)
    assert whole.values["shin"] + whole.values["thigh"] == pytest.approx(0.6)
    assert any(text.startswith("shin is at the largest") for text in whole.held)


def trial_of(function):
    """A function of shares with its gradient as what a search evaluates."""

    def evaluate(x, near):
        del near
        value, slope = function(x)
        return DesignTrial(x, value, slope, np.array([value]), 1, 0.0, ())

    return evaluate


def test_the_search_finds_minima_inside_and_at_the_edge():
    centre, bent = np.array([0.3, 0.8, 1.4]), np.array([[3.0, 1.0, 0.0], [1.0, 2.0, 0.5],
                                                        [0.0, 0.5, 1.0]])  # fmt: skip
    count = [0]

    def function(x):
        count[0] += 1
        away = x - centre
        return 100.0 + 50.0 * away @ bent @ away, 100.0 * bent @ away

    best = minimised(trial_of(function), np.array([0.9, 0.1, 0.2]), np.ones(3))
    inside = np.linalg.solve(bent[:2, :2], bent[:2, 2] * 0.4)
    np.testing.assert_allclose(best.values, [*(centre[:2] + inside), 1.0], atol=2e-3)
    assert count[0] < 20


def test_a_point_that_cannot_be_is_left():
    def evaluate(x, near):
        if near is not None and x[0] > 0.6:
            return None
        return DesignTrial(
            x, 10.0 + (x[0] - 0.9) ** 2, np.array([2.0 * (x[0] - 0.9)]), x, 1, 0.0, ()
        )

    best = minimised(evaluate, np.array([0.1]), np.ones(1))
    assert 0.55 < best.values[0] <= 0.6
    with pytest.raises(InputError, match="begin where the robot is"):
        minimised(lambda x, near: None, np.array([0.1]), np.ones(1))


def test_the_steps_of_the_search():
    B, g = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([-1.0, 3.0])
    wide = box_step(B, g, np.full(2, -9.0), np.full(2, 9.0))
    np.testing.assert_allclose(wide, -np.linalg.solve(B, g), rtol=1e-10)
    narrow = box_step(B, g, np.array([-1.0, 0.0]), np.array([1.0, 0.0]))
    np.testing.assert_allclose(narrow, [0.5, 0.0], atol=1e-12)
    s, y = np.array([0.3, -0.2]), np.array([0.8, 0.1])
    np.testing.assert_allclose(damped_bfgs(B, s, y) @ s, y, rtol=1e-12)
    curved_down = damped_bfgs(B, s, -y)
    assert np.linalg.eigvalsh(curved_down).min() > 0.0


def test_what_cannot_be_studied_is_refused():
    shin, thigh = Variable("shin", 0.2, 0.4, 0.3), Variable("thigh", 0.2, 0.4, 0.3)
    leg, one = Variable("leg", 0.5, 0.7, 0.6), walks(0.7)
    for variables, cases, keep, told in (
        ((), one, False, "needs numbers"), ((shin,), (), False, "and walks"),
        ((shin, shin), one, False, "given twice"), ((shin, thigh), one, True, "the other follows"),
        ((leg, shin), one, False, "choose it or these"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=told):
            Study(biped13(), variables, cases, keep)
    for name, lower, upper, start, told in (
        ("nose", 0.1, 0.2, 0.1, "cannot be chosen"), ("shin", 0.3, 0.2, 0.25, "empty"),
        ("shin", 0.3, 0.4, 0.25, "outside its range"), ("shin", -0.3, 0.4, 0.3, "finite numbers"),
        ("shin", 0.3, np.inf, 0.3, "finite numbers"), ("shin", np.nan, 0.4, 0.3, "finite numbers"),
        ("shin", 0.0, 0.4, 0.3, "above 0"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=told):
            Variable(name, lower, upper, start)
    far = Variable("shin", 25.0, 35.0, 30.0)
    with pytest.raises(InputError, match=r"beyond what can be.* give 0.03 to 3 m at most"):
        Study(biped13(), (far,), one)
    with pytest.raises(InputError, match=r"leaves too little .* give at most 0.57 m"):
        Study(biped13(), (Variable("shin", 0.2, 0.59, 0.3),), one, keep_leg=True)
    for changes in ({"turn_rate": 0.3}, {"double_support": 0.1}):
        task = preset_task(speed=0.5, **changes)
        with pytest.raises(InputError, match="a stride of two steps, has a double"):
            Study(biped13(), (shin,), (replace(one[0], task=task),))
    with pytest.raises(InputError, match=r"weight is 1e\+300; it must be from 1e-06 to 1e\+06"):
        Study(biped13(), (shin,), (replace(one[0], weight=1e300),))
