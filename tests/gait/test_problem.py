import functools
import pickle
from copy import deepcopy

import numpy as np
import pytest
from numerics import check_differences, jacobian_difference, relative_error, steps
from walks import NAMES, PAIRS, WALKS, walk

from gaitopt.errors import EvaluationError, UnreachableError
from gaitopt.gait import quantities
from gaitopt.gait.grid import uniform_grid
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem

STEP = 1e-5  # of variables.scale; the optima have nearly straight knees, which need small steps


@functools.cache
def differences(name: str) -> list[np.ndarray]:
    """Differences of cost (first) and rows by every parameter, (1 + m, n) at two steps."""
    problem, x = walk(name).problem, walk(name).x

    def values(point):
        at = problem.values(point)
        return np.concatenate([[at.cost], at.rows])

    # The speeds with which a foot leaves depend little on anything: their differences are small.
    large = "toe off" in name or "upstairs" in name
    step = STEP * (10.0 if large else 2.0 if "seven joints" in name else 1.0)
    return [jacobian_difference(values, x, problem.variables.scale, h) for h in steps(step)]


@pytest.mark.parametrize("name", WALKS)
def test_gradient_of_the_cost(name):
    problem, x = walk(name).problem, walk(name).x
    exact = problem.point(x).gradient * problem.variables.scale
    check_differences(exact, [d[0] for d in differences(name)])


@pytest.mark.parametrize(("name", "constraint"), PAIRS)
def test_jacobian_of_every_constraint(name, constraint):
    problem, x = walk(name).problem, walk(name).x
    rows = problem.rows_of(constraint)
    exact = problem.point(x).jacobian[rows] * problem.variables.scale
    check_differences(exact, [d[1:][rows] for d in differences(name)])


@pytest.mark.parametrize("name", WALKS)
def test_every_constraint_is_checked(name):
    names = [f.name for f in walk(name).problem.blocks]
    assert names == [f for f in NAMES if (name, f) in PAIRS]


@pytest.mark.parametrize("name", WALKS)
def test_values_are_those_of_the_point(name):
    problem, x = walk(name).problem, walk(name).x
    fresh = WalkProblem(problem.robot, problem.task, problem.grid)
    values, point = fresh.values(x), problem.point(x)
    assert relative_error(values.cost, point.cost) < 1e-12
    assert relative_error(values.rows, point.rows) < 1e-12
    np.testing.assert_array_equal(values.x, x)


@pytest.fixture(scope="module")
def problem(robot):
    return WalkProblem(robot, preset_task())


@pytest.fixture(scope="module")
def guess(problem):
    return first_guess(problem)


def test_results_do_not_depend_on_what_came_before(robot, problem, guess):
    other = guess + 0.01
    weights = np.linspace(-1.0, 1.0, problem.rows.lower.size)
    first = problem.point(guess)
    H = problem.hessian(guess, weights, 0.5)
    problem.point(other), problem.hessian(other, weights, 2.0), problem.values(other)
    again = problem.point(guess)
    np.testing.assert_array_equal(again.rows, first.rows)
    np.testing.assert_array_equal(again.jacobian, first.jacobian)
    np.testing.assert_array_equal(again.gradient, first.gradient)
    np.testing.assert_array_equal(problem.hessian(guess, weights, 0.5), H)


@pytest.mark.parametrize("method", ["values", "point"])
def test_changing_the_array_that_was_given_changes_nothing(robot, guess, method):
    evaluate = getattr(WalkProblem(robot, preset_task()), method)
    x = guess.copy()
    before = evaluate(x)
    rows = before.rows.copy()
    x += 0.02
    np.testing.assert_array_equal(before.x, guess)
    assert relative_error(evaluate(x).rows, rows) > 1e-3
    np.testing.assert_array_equal(evaluate(guess).rows, rows)


@pytest.mark.parametrize("changes", [{}, {"toe_off": 0.8}, {"double_support": 0.05}])
@pytest.mark.parametrize("copied", [deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_copy_of_a_walk_is_that_walk(robot, changes, copied):
    problem = WalkProblem(robot, preset_task(speed=0.7, **changes))
    x = first_guess(problem)
    problem.point(x)
    again, other = copied(problem), x + 1e-3
    np.testing.assert_array_equal(again.values(other).rows, problem.values(other).rows)
    np.testing.assert_array_equal(again.point(other).jacobian, problem.point(other).jacobian)


@pytest.mark.parametrize("name", ["x", "rows", "gradient"])
def test_what_is_kept_cannot_be_written_into(robot, guess, name):
    problem = WalkProblem(robot, preset_task())
    given = [problem.point(guess)] if name == "gradient" else [problem.values(guess)]
    given.append(problem.point(guess))
    for one in given:
        with pytest.raises(ValueError, match="read-only"):
            getattr(one, name)[0] = 0.0


def test_variables_are_those_of_the_layout(problem):
    assert problem.variables.names == problem.layout.names
    assert len(problem.variables.names) == 43
    yaw = problem.variables.names.index("pelvis_yaw")
    assert (problem.variables.lower[yaw], problem.variables.upper[yaw]) == (-0.2, 0.2)
    assert (problem.variables.scale > 0.0).all()


def test_rows_are_the_constraints_one_after_another(problem, guess):
    stops = [problem.rows_of(f.name).stop for f in problem.blocks]
    starts = [problem.rows_of(f.name).start for f in problem.blocks]
    assert starts == [0, *stops[:-1]]
    assert stops[-1] == problem.rows.lower.size == problem.values(guess).rows.size
    assert all(f.size == b - a for f, a, b in zip(problem.blocks, starts, stops, strict=True))


def test_limits_are_scaled_like_the_rows(problem):
    knee = problem.robot.joint_names.index("left_knee")
    torque = problem.rows_of("torque").start + knee
    assert problem.rows.upper[torque] == 1.0 == -problem.rows.lower[torque]
    load = problem.rows_of("load").start
    assert problem.rows.lower[load] == pytest.approx(25.0 / 500.0)
    speed = problem.rows_of("walking speed")
    assert problem.rows.lower[speed] == problem.rows.upper[speed] == [0.0]


def test_walking_speed_row_is_the_gap_of_the_step_length(problem, guess):
    x = guess.copy()
    x[problem.layout.index("step_length")] = 0.35
    row = problem.values(x).rows[problem.rows_of("walking speed")]
    assert row == pytest.approx([1.0 * 0.4 - 0.35])


def test_rows_are_named_to_people(problem):
    def named(constraint, instant, entry):
        width = next(f for f in problem.blocks if f.name == constraint).lower.shape[1]
        return problem.describe(problem.rows_of(constraint).start + instant * width + entry)

    knee = problem.robot.joint_names.index("left_knee")
    assert named("torque", 24, knee) == "left_knee torque at 80.0 % of the step"
    assert named("lift-off", 0, 2) == "rear foot heel left lift-off speed"
    assert named("leg length", 1, 0) == "swing leg hip-ankle distance"
    # The first instant that the clearance looks at is the second one of the grid.
    assert named("clearance", 0, 1) == "swing foot toe right height at 3.3 % of the step"
    assert len({problem.describe(i) for i in range(problem.rows.lower.size)}) == (
        problem.rows.lower.size
    )


def test_address_leads_back_to_the_constraint(problem):
    row = problem.rows_of("cop").start + 4 * 7 + 3
    at = problem.address(row)
    assert (at.block.name, at.instant, at.entry) == ("cop", 7, 3)
    with pytest.raises(IndexError):
        problem.address(problem.rows.lower.size)


def test_scaled_cost_is_of_order_one(problem, sampled_design):
    assert 0.1 < problem.cost_scale * sampled_design.solution.cost < 100.0


def test_another_grid_is_the_same_walk(problem, guess):
    fine = problem.with_grid(uniform_grid(61))
    coarse_torque = problem.step(guess).read(quantities.TORQUE)
    fine_torque = fine.step(guess).read(quantities.TORQUE)
    assert relative_error(fine_torque[::2], coarse_torque) < 1e-12
    assert fine.layout == problem.layout
    # Simpson's rule on a smooth integrand hardly changes.
    assert relative_error(fine.values(guess).cost, problem.values(guess).cost) < 0.02


@pytest.mark.parametrize("method", ["values", "point", "step", "derivatives"])
def test_a_parameter_that_is_no_number_has_no_value(problem, guess, method):
    x = guess.copy()
    x[5] = np.nan
    with pytest.raises(EvaluationError, match="not finite"):
        getattr(problem, method)(x)


def test_a_pelvis_out_of_reach_has_no_value(problem, guess):
    x = guess.copy()
    x[problem.layout.index("pelvis_height")] = 0.9
    with pytest.raises(UnreachableError, match=r"pelvis height 0\.9000 m.*step length 0\.4000 m"):
        problem.values(x)
    assert np.isfinite(problem.values(guess).cost)


def test_a_neighbours_step_is_taken_over_where_it_is_the_same(robot):
    here = WalkProblem(robot, preset_task(speed=1.0))
    x = first_guess(here)
    here.point(x)
    multipliers = np.linspace(-1.0, 1.0, here.rows.lower.size)
    for changes, same in (
        ({"speed": 1.1}, True),
        ({"speed": 1.1, "friction": 0.5}, True),
        ({"speed": 1.0, "duration": 0.6}, False),
        ({"speed": 1.0, "samples": 21}, False),
    ):
        task = preset_task(**changes)
        alone, beside = WalkProblem(robot, task), WalkProblem(robot, task, neighbour=here)
        assert (beside.whole(x) is here.whole(x)) == same
        for name in ("rows", "jacobian", "gradient"):
            one, other = (getattr(problem.point(x), name) for problem in (alone, beside))
            np.testing.assert_array_equal(one, other)
        if alone.rows.lower.size == multipliers.size:
            one, other = (p.hessian(x, multipliers, 1.0) for p in (alone, beside))
            np.testing.assert_array_equal(one, other)
