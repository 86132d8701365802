from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numerics import check_jacobian, relative_error
from reference_cases import reference_task
from walks import walk

from gaitopt.design.conflict import easier_guess
from gaitopt.design.diagnosis import _outward
from gaitopt.design.relaxation import (
    Relaxation,
    RelaxedProgram,
    duration_adjustment,
    limit_adjustments,
    step_width_adjustment,
    usual_value,
)
from gaitopt.gait import quantities
from gaitopt.gait.constraint import Constraint, margin
from gaitopt.gait.functions import FrictionCone
from gaitopt.gait.parameters import GEOMETRY, set_geometry
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.model.import_options import ImportOptions, LimitOverride
from gaitopt.model.robot import Robot
from gaitopt.nlp import Start, Status
from gaitopt.solvers import SQP

SETTINGS_TRIED = (
    "torque_limit",
    "speed_limit",
    "friction",
    "minimum_load",
    "cop_margin",
    "clearance",
    "lateral_gap",
    "knee_flexion",
    "leg_extension",
    "liftoff_speed",
    "robot joint ranges",
    "speed",
)
SWITCHED = (
    "trunk_roll", "trunk_pitch", "trunk_yaw", "torsional_friction", "leg_gap", "swing_tilt",
    "swing_height", "landing_speed", "landing_impulse",
)  # fmt: skip


def setting_of(problem, name):
    return next(k for k in limit_adjustments(problem) if k.name == name)


def room(program, x):
    """Signed distance of every row to its two limits, infinite where there is none, (2, m)."""
    rows = program.values(x).rows
    lower, upper = program.rows.lower, program.rows.upper
    low, high = np.isfinite(lower), np.isfinite(upper)
    distance = np.full((2, rows.size), np.inf)
    distance[0, low] = rows[low] - lower[low]
    distance[1, high] = upper[high] - rows[high]
    return distance


def per_row(problem, values):
    """Scaled values, shape (2, m), in the units of the constraints."""
    scales = [np.tile(f.scale, len(f.instants)) for f in problem.blocks]
    return values * np.concatenate(scales)


def test_every_knob_is_there():
    problem, upright = walk("guess").problem, walk("upright").problem
    assert tuple(k.name for k in limit_adjustments(problem)) == SETTINGS_TRIED
    assert {k.name for k in limit_adjustments(upright)} == {*SETTINGS_TRIED, *SWITCHED}


def test_a_robot_without_limits_has_no_motor_to_make_stronger(robot):
    boundless = replace(robot, limits=replace(robot.limits, speed=np.full(12, np.inf)))
    names = {k.name for k in limit_adjustments(WalkProblem(boundless, reference_task()))}
    assert names == {*SETTINGS_TRIED} - {"speed_limit"}


@pytest.mark.parametrize("name", SETTINGS_TRIED + SWITCHED)
def test_a_relaxed_row_has_the_room_that_the_changed_task_gives_it(name):
    walked = walk("upright" if name in SWITCHED else "guess")
    check_room(walked.problem, walked.x, name)


def test_a_margin_of_the_sole_gives_no_room_at_the_ends_of_a_strip():
    """While a foot turns about an edge, only the sides of its strip move with the margin."""
    walked = walk("upright, heel strike, toe off, everything free")
    check_room(walked.problem, walked.x, "cop_margin")


def test_a_free_duration_tells_what_the_speed_gives():
    walked = walk("upright, everything free")
    problem = walked.problem
    assert walked.x[problem.layout.index("duration")] != problem.task.duration
    check_room(problem, walked.x, "speed")


@dataclass(frozen=True)
class Grip(Constraint):
    """A friction cone of one's own, and a limit that moves with its margin in another way."""

    name, unit, words = "grip", "N", "grip of the ground"
    reads, couplings = (quantities.WRENCH,), {"grip": ("load", 1.0)}
    grip: float = margin(0.6, "Coefficient.", "the grip of the ground", relax=(2.0, 0.1))
    push: float = margin(-30.0, "Least margin.", "the least margin", "N", relax=(-90.0, -20.0))

    def block(self, context):
        cone = FrictionCone(self.grip, 0.05)
        return self.over_step(context, cone, ("grip",), lower=self.push, scale=400.0)


@pytest.mark.parametrize("name", ["grip", "push"])
def test_margins_of_ones_own_are_turned_like_the_others(robot, name):
    problem = WalkProblem(robot, preset_task(constraints=(Grip(),)))
    setting = setting_of(problem, name)
    assert setting.constraints == ("grip",)
    assert setting.words in ("the grip of the ground", "the least margin")
    check_room(problem, walk("guess").x, name)


@pytest.mark.parametrize(
    ("changes", "after"),
    [
        ({}, {"friction": 0.5, "torsional_friction": 0.034}),
        ({"torsional_friction": 0.01}, {"friction": 0.5, "torsional_friction": 0.01}),
        ({"torsional_friction": None}, {"friction": 0.5, "torsional_friction": None}),
    ],
)
def test_torsional_friction_follows_friction_where_the_preset_derived_it(robot, changes, after):
    problem = WalkProblem(robot, preset_task(robot=robot, friction=0.3, **changes))
    setting = setting_of(problem, "friction")
    _, task = setting.changed(robot, problem.task, 0.5)
    assert {name: getattr(task.margins, name) for name in after} == after
    follows = after["torsional_friction"] == 0.034
    assert ("torsion" in setting.constraints, "torsional" in setting.words) == (follows, follows)
    check_room(problem, walk("guess").x, "friction", 1.0)  # at whose bound nothing is rounded
    (price,) = (k for k in limit_adjustments(problem, alone=True) if k.name == "friction")
    kept = price.changed(robot, problem.task, 0.5)[1].margins
    assert kept.torsional_friction == problem.task.margins.torsional_friction


def check_room(problem, x, name, part=0.3):
    """The same limits, reached through t and through the task: two roads to one number."""
    setting = setting_of(problem, name)
    z = setting.start(x, part * (setting.bound - setting.before) / setting.step)
    program = setting.program(problem, z)
    robot, task = setting.changed(problem.robot, problem.task, setting.value(z))
    changed = WalkProblem(robot, task, problem.grid)
    expected, before = per_row(changed, room(changed, x)), per_row(problem, room(problem, x))
    found = np.full(expected.shape, np.inf)
    for side, distance in enumerate(room(program, z)):
        np.minimum.at(found[side], program.source, distance)
    found = per_row(problem, found)
    there = np.isfinite(expected)
    np.testing.assert_array_equal(there, np.isfinite(found))
    np.testing.assert_allclose(found[there], expected[there], atol=1e-8)
    assert np.abs(expected[there] - before[there]).max() > 1e-5


@pytest.mark.parametrize(
    "name", ["friction", "cop_margin", "torque_limit", "speed", "torsional_friction"]
)
def test_derivatives_of_the_relaxed_program(name, rng):
    walked = walk("upright" if name in SWITCHED else "guess")
    problem, x = walked.problem, walked.x
    z = setting_of(problem, name).start(x, 0.37)
    program = setting_of(problem, name).program(problem, z + 0.1)
    weights = rng.normal(size=program.rows.lower.size)
    point, scale = program.point(z), program.variables.scale

    def lagrangian_slope(at):
        there = program.point(at)
        return there.gradient * 0.7 + there.jacobian.T @ weights

    def sums(at):
        there = program.values(at)
        return np.array([there.cost, weights @ there.rows])

    check_jacobian(
        sums, np.vstack([point.gradient, weights @ point.jacobian]), z, scale=scale, tolerance=1e-5
    )
    check_jacobian(
        lagrangian_slope, program.hessian(z, weights, 0.7), z, scale=scale, tolerance=1e-4
    )


def test_multipliers_tell_how_much_turning_a_knob_brings(robot):
    """The relief of a setting is the slope of the least relaxation along its value."""
    gap = 0.45
    task = preset_task(lateral_gap=gap, knee_flexion=2.0)
    problem = WalkProblem(robot, task)
    x = easier_guess(problem)
    found = problem.values(x)
    setting = setting_of(problem, "lateral_gap")
    relaxation = setting.relaxation(problem, x)
    y = np.zeros(problem.rows.lower.size)
    y[problem.rows_of("lateral")] = -0.25
    count = y[y != 0.0].size
    assert relaxation.relief(found.rows, y) == pytest.approx(0.25 * count)  # 0.1 m is one unit


def test_the_smallest_relaxation_of_two_planes():
    """min t1 + t2: x >= 1 - t1, x <= -1 + 2 t2; the cheap one gives: x = 1, t2 = 1."""
    from textbook_relaxation import Line

    relaxations = (
        Relaxation("left", np.array([1.0, 0.0]), np.zeros(2)),
        Relaxation("right", np.zeros(2), np.array([0.0, 2.0])),
    )
    program = RelaxedProgram(Line(), relaxations, np.zeros(1))
    start = program.needed(np.array([0.25]))
    np.testing.assert_allclose(start, [0.25, 0.75, 0.625])
    solution = SQP(tolerance=1e-8).solve(program, Start(start))
    assert solution.status is Status.OPTIMAL
    np.testing.assert_allclose(solution.x, [1.0, 0.0, 1.0], atol=1e-6)
    assert solution.cost == pytest.approx(1.0 + 0.5e-3, rel=1e-6)


@pytest.mark.parametrize(("shorter", "value"), [(True, 0.34), (False, 0.52)])
def test_the_duration_knob_pulls_towards_the_duration_asked_for(shorter, value):
    problem, x = walk("guess").problem, walk("guess").x
    setting = duration_adjustment(problem, shorter)
    amount = (value - setting.before) / (setting.bound - setting.before)
    z = setting.start(x, amount)
    program = setting.program(problem, z)
    assert setting.value(z) == pytest.approx(value)
    assert program.values(z).cost - program.values(setting.start(x, 0.0)).cost == pytest.approx(
        amount, rel=0.1
    )
    _, task = setting.changed(problem.robot, problem.task, value)
    changed = WalkProblem(problem.robot, task, problem.grid)
    assert relative_error(program.base.values(z).rows, changed.values(x).rows) < 1e-12


@pytest.mark.parametrize("stance", ["left", "right"])
def test_the_step_width_is_turned_by_the_foot_spacing(robot, stance):
    """Its program allows just the widths beyond the one asked for, and asks for little of it."""
    robot = Robot.from_urdf(robot.urdf, choices=ImportOptions(stance=stance))
    problem = WalkProblem(robot, preset_task(step_width=0.1))
    x, setting = easier_guess(problem), step_width_adjustment(problem)
    assert setting is not None
    assert setting.before == 0.1 < setting.bound
    z = setting.start(x, (0.18 - setting.before) / (setting.bound - setting.before))
    program = setting.program(problem, z)
    assert setting.value(z) == pytest.approx(0.18)
    np.testing.assert_array_equal(setting.walk(z), z)
    held = [side[setting.index] for side in (program.variables.lower, program.variables.upper)]
    wanted = [0.1, setting.bound] if robot.legs.side > 0.0 else [-setting.bound, -0.1]
    assert held == pytest.approx(wanted)
    slope = program.point(z).gradient * robot.legs.side
    assert slope[setting.index] == pytest.approx(1.0 / (setting.bound - setting.before))
    _, task = setting.changed(robot, problem.task, 0.18)
    changed = WalkProblem(robot, task, problem.grid)
    held = [side[setting.index] for side in (changed.variables.lower, changed.variables.upper)]
    assert 0.18 * robot.legs.side in held
    assert relative_error(program.base.values(z).rows, changed.values(z).rows) < 1e-12


def test_only_a_step_width_that_bounds_the_walk_can_be_turned(robot):
    def fixed(**field):
        return set_geometry(GEOMETRY, {"foot_spacing": field})

    tasks = (
        preset_task(),
        preset_task(step_width=0.2, geometry=fixed(free=False, value=0.15)),
        preset_task(step_width=0.2, geometry=fixed(lower=-0.18, upper=0.18)),
    )
    assert [step_width_adjustment(WalkProblem(robot, task)) for task in tasks] == [None] * 3


@settings(derandomize=True, deadline=None)
@given(
    before=st.floats(0.01, 300.0),
    share=st.floats(0.01, 0.99),
    room=st.floats(0.1, 10.0),
    up=st.booleans(),
)
def test_suggestions_are_rounded_away_from_the_value_before(before, share, room, up):
    bound = before + room if up else before - room
    exact, step = before + share * (bound - before), 0.1 * room
    values = list(_outward(before, exact, bound, step))
    sign = 1.0 if up else -1.0
    change = max(abs(exact - before), 0.05 * step)
    assert values
    assert all(sign * (v - exact) >= -1e-8 * change for v in values)
    assert all(sign * (bound - v) >= -1e-12 * abs(bound) for v in values)
    assert sign * (values[0] - before) <= 1.44 * change + 1e-9
    assert [sign * v for v in values] == sorted({sign * v for v in values})
    assert all(len(f"{v:.9f}".rstrip("0")) <= 12 for v in values if v != bound)


def test_a_change_too_small_to_see_is_made_larger():
    """150 N.m and next to nothing, as a search ends at the edge of what can be walked."""
    (first, *_) = _outward(150.0, 150.0 + 1e-7, 1500.0, 150.0)
    assert first == pytest.approx(159.0)


def test_stronger_motors_are_told_by_the_choices_about_the_robot(robot):
    """As a file of choices tells them: read with these, the robot has the new limits."""
    given = LimitOverride("*knee", torque=50.0)
    uneven = Robot.from_urdf(robot.urdf, choices=replace(robot.choices, limits=(given,)))
    problem = WalkProblem(uneven, preset_task())
    for name in ("robot torque limits", "robot joint ranges"):
        changed, _ = setting_of(problem, name).changed(uneven, problem.task, 1.3)
        again = Robot.from_urdf(robot.urdf, choices=changed.choices)
        for kind in ("torque", "speed", "lower", "upper"):
            expected, found = getattr(changed.limits, kind), getattr(again.limits, kind)
            np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert (changed.limits.upper > uneven.limits.upper).all()


def test_what_is_asked_beyond_the_usual_is_known(robot):
    asked = {"torque_limit": 25.0, "clearance": 0.3, "trunk_yaw": 0.05, "speed": 1.4}
    problem = WalkProblem(robot, preset_task(**asked))
    found = {k.name: usual_value(problem, k) for k in limit_adjustments(problem)}
    assert {n: v for n, v in found.items() if v is not None} == {
        "torque_limit": 150.0, "clearance": 0.03, "trunk_yaw": 1.0, "speed": 1.0,
    }  # fmt: skip


def test_the_own_motors_of_a_robot_are_never_too_strong_for_it(robot):
    """A limit of 8 N.m is less than a tenth of what they can do."""
    problem = WalkProblem(robot, preset_task(torque_limit=8.0))
    assert usual_value(problem, setting_of(problem, "torque_limit")) == 150.0


def test_multipliers_go_to_the_limit_they_push():
    problem, x = walk("guess").problem, walk("guess").x
    relaxation = setting_of(problem, "torque_limit").relaxation(problem, x)
    program = RelaxedProgram(problem, (relaxation,), np.zeros(problem.layout.size))
    rng = np.random.default_rng(0)
    lower, upper = np.isfinite(problem.rows.lower), np.isfinite(problem.rows.upper)
    y = rng.normal(size=lower.size)
    y = np.where(lower, np.minimum(y, 0.0), 0.0) + np.where(upper, np.maximum(y, 0.0), 0.0)
    own = program.own_multipliers(y)
    np.testing.assert_array_equal(program.base_multipliers(own), y)
    assert not own[(own < 0.0) & ~np.isfinite(program.rows.lower)].any()
    assert not own[(own > 0.0) & ~np.isfinite(program.rows.upper)].any()
    assert own.size > y.size
