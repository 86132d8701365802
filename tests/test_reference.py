"""Agreement with an independent solution of the reference problem (tests/data).

It shares no code with gaitopt and has other conventions: chain angles, and one-sided rows
`slack` >= 0 in units of its own (see `slack_rows`).
"""

import functools
from dataclasses import dataclass

import numpy as np
import pytest
from numerics import relative_error
from reference_cases import CASES, OPTIMA, URDF_SIGNS, biped, reference_case

from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.gait import quantities
from gaitopt.nlp import Start
from gaitopt.solvers import solver_by_name

VALUES = 1e-8  # relative to the largest entry of an array
SLOPES = 1e-6
at_cases = pytest.mark.parametrize("name", CASES)


@dataclass(frozen=True)
class Slack:
    """One-sided rows with their Jacobian in our parameters."""

    value: np.ndarray
    jacobian: np.ndarray


@functools.cache
def evaluated(name: str):
    """The case, its problem, its step and its point."""
    case = reference_case(name)
    problem = case.problem(biped())
    return case, problem, problem.step(case.x), problem.point(case.x)


@functools.cache
def slack_rows(name: str) -> Slack:
    """Our scaled two-sided rows as the file's one-sided ones, in the file's order.

    Both use 500 N, 100 N.m, 50 N.s and 0.1 m as units, so only sides and order differ; a stance
    joint's upper limit in the chain is its lower limit in the URDF.
    """
    _, problem, _, point = evaluated(name)

    def side(family: str, upper: bool, entries: slice | list[int] = slice(None)) -> Slack:
        rows = problem.rows_of(family)
        width = next(f for f in problem.blocks if f.name == family).lower.shape[1]
        limit = (problem.rows.upper if upper else problem.rows.lower)[rows]
        sign = -1.0 if upper else 1.0
        value = (sign * (point.rows[rows] - limit)).reshape(-1, width)[:, entries]
        jacobian = (sign * point.jacobian[rows]).reshape(-1, width, point.x.size)[:, entries]
        return Slack(value.ravel(), jacobian.reshape(value.size, -1))

    def chain_sides(family: str) -> list[Slack]:
        upper, lower = side(family, True), side(family, False)
        swing = np.tile(URDF_SIGNS > 0.0, problem.grid.count)
        return [
            Slack(
                np.where(swing, a.value, b.value), np.where(swing[:, None], a.jacobian, b.jacobian)
            )
            for a, b in ((upper, lower), (lower, upper))
        ]

    parts = [
        *chain_sides("torque"),
        *chain_sides("speed"),
        side("load", False),
        side("friction", False),
        *(side("cop", False, [edge]) for edge in (0, 1, 3, 2)),  # front, rear, right, left
        *(side(f, False) for f in ("impulse", "impulse friction", "lift-off")),
        *(side(f, False) for f in ("clearance", "lateral")),
        *(side("knee", False, [leg]) for leg in (0, 1)),
    ]
    yaw = problem.layout.index("pelvis_yaw")
    if yaw is not None:
        one = np.eye(point.x.size)[yaw]
        bound = 0.2 - np.array([1.0, -1.0]) * point.x[yaw]
        parts.append(Slack(bound, np.stack([-one, one])))
    return Slack(
        np.concatenate([p.value for p in parts]), np.concatenate([p.jacobian for p in parts])
    )


@at_cases
def test_the_number_of_parameters(name):
    case, problem, _, _ = evaluated(name)
    assert problem.layout.size == case["parameters"].size == int(name[1:3])


@at_cases
def test_motion(name):
    case, _, step, _ = evaluated(name)
    for ours, theirs in zip(step.motion, ("q", "dq", "ddq"), strict=True):
        assert relative_error(ours * URDF_SIGNS, case[theirs]) < VALUES


@at_cases
def test_ends_of_the_step(robot, name):
    case, _, step, _ = evaluated(name)
    rate_start = robot.mirror @ step.impact.rate_after
    for ours, theirs in (
        (step.posture.q_start, "q_start"),
        (step.q_end, "q_end"),
        (step.rate_before, "rate_before"),
        (rate_start, "rate_start"),
    ):
        assert relative_error(ours * URDF_SIGNS, case[theirs]) < VALUES


@at_cases
def test_loads(name):
    case, _, step, _ = evaluated(name)
    wrench = step.read(quantities.WRENCH)
    assert relative_error(step.read(quantities.TORQUE) * URDF_SIGNS, case["torque"]) < VALUES
    assert relative_error(wrench, case["ground_wrench"]) < VALUES
    cop = np.stack([-wrench[:, 4], wrench[:, 3]], axis=1) / wrench[:, 2:3]
    assert relative_error(cop, case["cop"]) < VALUES


@at_cases
def test_swing_foot(name):
    case, _, step, _ = evaluated(name)
    assert relative_error(step.support.corners, case["swing_sole"]) < VALUES


@at_cases
def test_impact(name):
    case, _, step, _ = evaluated(name)
    signs = np.concatenate([np.ones(6), URDF_SIGNS])
    assert relative_error(step.impact.impulse, case["impulse"]) < VALUES
    assert relative_error(step.impact.velocity * signs, case["velocity_after"]) < VALUES


@at_cases
def test_cost_and_its_gradient(name):
    case, _, _, point = evaluated(name)
    assert relative_error(point.cost, case["cost"]) < VALUES
    assert relative_error(point.gradient * case.parameter_signs, case["cost_gradient"]) < SLOPES


@at_cases
def test_gauss_newton_part_of_the_cost(name):
    """J is the sum of squares of r = sqrt(w T / d) torque; this is 2 r' r with slopes r'."""
    case, problem, step, _ = evaluated(name)
    slopes = problem.derivatives(case.x)[1].jacobians[quantities.TORQUE].copy()
    column = problem.layout.index("step_length")
    slopes[:, :, column] -= step.read(quantities.TORQUE) / (2.0 * step.step_length)
    weights = step.duration / step.step_length * problem.grid.weights
    J = (np.sqrt(weights)[:, None, None] * slopes * case.parameter_signs).reshape(-1, case.x.size)
    assert relative_error(2.0 * J.T @ J, case["cost_gauss_newton_hessian"]) < SLOPES


@at_cases
def test_constraints(name):
    assert relative_error(slack_rows(name).value, reference_case(name)["slack"]) < VALUES


@at_cases
def test_constraints_one_by_one(name):
    """Each row in its own size, so that small rows are seen too."""
    ours, theirs = slack_rows(name).value, reference_case(name)["slack"]
    np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-9)


@at_cases
def test_jacobian_transposed_times_weights(name):
    case = reference_case(name)
    ours = slack_rows(name).jacobian.T @ case["slack_adjoint_weights"]
    assert relative_error(ours * case.parameter_signs, case["slack_adjoint"]) < SLOPES


@at_cases
def test_jacobian_row_norms(name):
    ours = np.linalg.norm(slack_rows(name).jacobian, axis=1)
    theirs = reference_case(name)["slack_jacobian_norms"]
    assert relative_error(ours, theirs) < SLOPES
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("name", OPTIMA)
def test_started_at_their_optima_the_cost_does_not_rise(name):
    """Five of the six stay where they are to four digits; the slowest with 42 parameters gains."""
    case = reference_case(name)
    problem = case.problem(biped())
    solution = solver_by_name("sqp", max_iterations=60).solve(problem, Start(case.x))
    cost, theirs = solution.cost, float(case["cost"])
    assert solution.violation < 1e-7
    assert cost < theirs * (1.0 + 2e-4)
    assert cost > theirs * (1.0 - (6e-3 if name == "p42_v0.8_optimum" else 2e-4))


def test_started_from_scratch_the_cost_is_theirs(sampled_design):
    assert sampled_design.solution.cost == pytest.approx(3346.4, rel=5e-3)
    # SNOPT's answer to the same problem.
    assert sampled_design.solution.cost < 3346.33 * (1.0 + 1e-4)


def test_the_paper_preset_finds_their_cost_too(robot):
    case = reference_case("p42_v1.0_optimum")
    task = case.problem(robot).task
    options = DesignOptions(solver=solver_by_name("sqp"), refine=False)
    found = design(robot, task, options).solution.cost
    assert found < float(case["cost"]) * (1.0 + 1e-4)
