import json
import re
from dataclasses import replace

import numpy as np
import pytest
from numerics import relative_error
from reference_cases import biped, reference_case
from walks import walk

from gaitopt.design.certificate import certify, on_fine_grid, worst_rows
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.gait import quantities
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Residual
from gaitopt.solvers.sqp import SQP
from gaitopt.tolerances import LIMITS, OPTIMALITY


def test_a_refined_optimum_is_certified(refined_design):
    certificate = refined_design.certificate
    assert certificate.certified
    assert certificate.verdict == "certified"
    assert certificate.kkt.worst < OPTIMALITY
    assert certificate.worst.violation <= LIMITS
    assert certificate.rear_foot_lifts


def test_an_optimum_at_the_samples_is_called_just_that(sampled_design):
    certificate = sampled_design.certificate
    assert certificate.optimal
    assert certificate.refereed
    assert not certificate.certified
    assert certificate.verdict.startswith("optimal at the given samples only; between them ")
    assert certificate.worst.sentence in certificate.verdict
    assert certificate.worst.violation > 100.0 * LIMITS


def test_their_optimum_does_not_hold_between_the_samples():
    case = reference_case("p43_v1.0_optimum")
    certificate = certify(case.problem(biped()), case.x)
    assert certificate.refereed
    assert not certificate.certified
    assert certificate.kkt.feasibility < 1e-6  # at the samples
    assert certificate.worst.violation > 1e-3  # between them


def test_an_infeasible_point_is_told_by_its_worst_row():
    case = reference_case("p43_v1.0_infeasible")
    certificate = certify(case.problem(biped()), case.x)
    assert not certificate.optimal
    assert certificate.verdict.startswith("not certified: KKT residual")
    assert certificate.worst.constraint == "cop"
    assert certificate.worst.violation >= -case["slack"].min()
    assert not certificate.rear_foot_lifts  # its lift-off rows are negative


def test_a_rear_foot_that_may_sink_is_told():
    """A negative lift-off speed relaxes section 2.4.1; the proof must not say that it lifts."""
    task = preset_task(speed=1.0, liftoff_speed=-0.05)
    certificate = design(biped(), task, DesignOptions(solver=SQP())).certificate
    assert certificate.certified
    assert not certificate.rear_foot_lifts
    assert -0.05 <= certificate.rear_foot_speed < -1e-3
    assert certificate.verdict == (
        f"certified, but the rear foot sinks at {-certificate.rear_foot_speed:.3g} m/s after the "
        "impact, as the task allows; liftoff_speed 0 forbids it"
    )


@pytest.mark.parametrize("index", [3, 30, 40])
def test_tampering_with_the_parameters_is_found(refined_design, index):
    x = refined_design.solution.x.copy()
    x[index] += 1e-3
    certificate = certify(refined_design.problem, x)
    assert not certificate.optimal
    assert not certificate.certified
    assert certificate.refereed  # a step it still is, only not the optimal one


def test_both_outcomes_of_the_impact_are_told(rng):
    """Some rates before the impact leave both feet on the ground, others do not."""
    problem, x = walk("guess").problem, walk("guess").x.copy()
    points = {}
    while set(points) != {True, False}:
        x[problem.layout.rates] = rng.normal(0.0, 2.0, 12)
        step = problem.step(x)
        locked = problem.model.impact.locked(step.q_end, step.rate_before)
        points[locked.valid] = x.copy()
    for valid, point in points.items():
        assert certify(problem, point).both_feet_stay is valid


@pytest.mark.parametrize("samples", [5, 31, 101])
def test_the_proof_does_not_depend_on_the_samples(refined_design, samples):
    """The same parameters, designed on however many samples, are proven at the same instants."""
    problem = refined_design.problem
    other = WalkProblem(problem.robot, replace(problem.task, samples=samples))
    one, two = (
        certify(problem, refined_design.solution.x),
        certify(other, refined_design.solution.x),
    )
    np.testing.assert_array_equal(
        on_fine_grid(problem).grid.instants, on_fine_grid(other).grid.instants
    )
    assert (one.constraints, one.resolution, one.cost) == (
        two.constraints,
        two.resolution,
        two.cost,
    )


def test_the_fine_cost_is_close_to_that_of_the_samples(refined_design):
    certificate = refined_design.certificate
    assert relative_error(certificate.cost, refined_design.solution.cost) < 2e-3
    assert certificate.cost != refined_design.solution.cost


def test_worst_rows_are_in_order_and_of_every_constraint(refined_design):
    rows = refined_design.certificate.constraints
    margins = [row.margin for row in rows]
    assert margins == sorted(margins)
    assert {r.constraint for r in rows} == {f.name for f in refined_design.problem.blocks}
    assert all(row.violation == pytest.approx(max(0.0, -row.margin)) for row in rows)


def test_a_worst_row_says_what_where_and_when(sampled_design):
    problem, x = sampled_design.problem, sampled_design.solution.x
    torque = next(r for r in worst_rows(problem, x) if r.constraint == "torque")
    sampled = np.abs(problem.step(x).read(quantities.TORQUE))
    instant, joint = np.unravel_index(np.argmax(sampled), sampled.shape)
    assert torque.row == f"{problem.robot.joint_names[joint]} torque"
    assert torque.time == pytest.approx(problem.grid.instants[instant] * 0.4)
    assert abs(torque.value) == pytest.approx(sampled.max())
    assert (abs(torque.limit), torque.unit, torque.equation) == (150.0, "N·m", "(28)")
    assert torque.sentence == (
        f"{torque.row} at t = {torque.time:.4f} s: {torque.value:.5g} N·m, "
        f"allowed {torque.limit:.5g}"
    )


def test_a_row_without_an_instant_has_no_time(sampled_design):
    rows = worst_rows(sampled_design.problem, sampled_design.solution.x)
    lift = next(r for r in rows if r.constraint == "lift-off")
    assert lift.time is None
    assert "t =" not in lift.sentence


def test_a_point_that_is_not_stationary_is_refused(refined_design):
    residual = Residual(2e-3, 1e-9, 1e-9)
    certificate = replace(refined_design.certificate, kkt=residual)
    assert not certificate.certified
    assert certificate.verdict.startswith("not certified: KKT residual 2.00e-03, allowed")


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("torque", "not certified: the referee disagrees by 1.00e-02"),
        ("impulse", "not certified: the referee disagrees by 1.00e-02"),
        ("posture", "not certified: the referee disagrees by 1.00e-02"),
        ("momentum", "not certified: momentum is off by 1.00e-02 of m g T"),
    ],
)
def test_the_referee_can_refuse(refined_design, name, verdict):
    referee = replace(refined_design.certificate.referee, **{name: 0.01})
    certificate = replace(refined_design.certificate, referee=referee)
    assert not certificate.refereed
    assert not certificate.certified
    assert certificate.verdict == verdict


def test_the_record_is_plain_data(refined_design):
    record = json.loads(json.dumps(refined_design.certificate.record(), allow_nan=False))
    assert record["certified"] is True
    assert record["fine_samples"] == refined_design.certificate.samples
    assert record["kkt"]["stationarity"] == refined_design.certificate.kkt.stationarity
    assert record["worst"] == record["constraints"][0]
    assert record["referee"]["weight"] == pytest.approx(56.87 * 9.81 * 0.4)


def test_limits_that_are_not_known_well_enough_are_told_so(refined_design):
    certificate = replace(refined_design.certificate, resolution=2e-6)
    assert not certificate.certified
    assert re.fullmatch(
        r"not certified: limits hold to \d\.\de-\d+, but between the samples that is known to "
        r"2\.0e-06 only, together more than 1e-06",
        certificate.verdict,
    )
