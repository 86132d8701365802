import numpy as np
import pytest

from gaitopt.nlp import (
    NLP,
    Point,
    Residual,
    Rows,
    Values,
    Variables,
    kkt_residual,
    violations,
    worst_violation,
)

INF = np.inf


class Example(NLP):
    """min 3 x0² + 2 x1² - x0  subject to  2 <= x0 + 2 x1 <= inf,  x1 <= 0.8.

    At x = (0.4, 0.8): slope (1.4, 3.2) = 1.4 (1, 2) + 0.4 (0, 1), so that with the cost scaled by
    10 the multipliers are -14 of the row (at its lower limit) and -4 of x1. That sign belongs to a
    lower bound: the point is optimal for 0.8 <= x1 only.
    """

    def __init__(self, lower: float, upper: float) -> None:
        self.variables = Variables(
            ("x0", "x1"), np.array([-INF, lower]), np.array([INF, upper]), np.ones(2)
        )
        self.rows = Rows(np.array([2.0]), np.array([INF]))
        self.cost_scale = 10.0
        self.has_hessian = True

    def values(self, x):
        cost = float(3.0 * x[0] ** 2 + 2.0 * x[1] ** 2 - x[0])
        return Values(x, cost, np.array([x[0] + 2.0 * x[1]]))

    def point(self, x):
        values = self.values(x)
        gradient = np.array([6.0 * x[0] - 1.0, 4.0 * x[1]])
        return Point(x, values.cost, values.rows, gradient, np.array([[1.0, 2.0]]))

    def hessian(self, x, multipliers, cost_weight):
        return cost_weight * np.diag([6.0, 4.0])

    def describe(self, row):
        return f"row {row}"


X = np.array([0.4, 0.8])
ROW, BOUND = np.array([-14.0]), np.array([0.0, -4.0])


def test_violations_are_distances_outside():
    lower, upper = np.array([-1.0, -INF, 2.0, -INF]), np.array([1.0, 3.0, 2.0, INF])
    values = np.array([-1.5, 3.25, 1.0, 9.0])
    np.testing.assert_array_equal(violations(lower, upper, values), [0.5, 0.25, 1.0, 0.0])
    np.testing.assert_array_equal(violations(lower, upper, np.array([0.0, 3.0, 2.5, 0.0]))[2], 0.5)


def test_worst_violation_names_the_row_and_sees_the_bounds():
    nlp = Example(lower=0.8, upper=1.0)
    assert worst_violation(nlp, nlp.values(np.array([0.2, 0.85]))) == (pytest.approx(0.1), 0)
    # The row holds; the bound is exceeded by 0.7.
    assert worst_violation(nlp, nlp.values(np.array([1.0, 1.7])))[0] == pytest.approx(0.7)


def test_worst_violation_finds_the_worst_of_many():
    nlp = Example(lower=0.8, upper=1.0)
    nlp.rows = Rows(np.array([0.0, 0.0, 0.0]), np.array([1.0, 1.0, 1.0]))
    values = Values(np.array([0.0, 0.9]), 0.0, np.array([1.5, -0.75, 0.2]))
    assert worst_violation(nlp, values) == (0.75, 1)


def test_the_optimum_satisfies_the_conditions():
    nlp = Example(lower=0.8, upper=2.0)
    residual = kkt_residual(nlp, nlp.point(X), ROW, BOUND)
    assert residual.worst < 1e-13


def test_each_condition_is_seen_when_it_fails():
    nlp = Example(lower=0.8, upper=2.0)
    point = nlp.point(X)
    slope = kkt_residual(nlp, point, np.array([-13.0]), BOUND)
    assert slope.stationarity == pytest.approx(2.0)  # J' times the missing multiplier
    inside = nlp.point(np.array([0.4, 0.9]))
    assert kkt_residual(nlp, inside, ROW, BOUND).complementarity == pytest.approx(14.0 * 0.2)
    assert kkt_residual(nlp, inside, 0.0 * ROW, BOUND).complementarity == pytest.approx(0.4)
    outside = nlp.point(np.array([0.1, 0.8]))
    assert kkt_residual(nlp, outside, ROW, BOUND).feasibility == pytest.approx(0.3)


def test_the_sign_of_a_multiplier_tells_its_limit():
    """With the bound above instead of below, a negative multiplier belongs to no limit."""
    nlp = Example(lower=-INF, upper=0.8)
    assert kkt_residual(nlp, nlp.point(X), ROW, BOUND).complementarity == np.inf
    assert kkt_residual(nlp, nlp.point(X), -ROW, 0.0 * BOUND).complementarity == np.inf


def test_the_cost_is_scaled():
    nlp = Example(lower=0.8, upper=2.0)
    nlp.cost_scale = 1.0
    residual = kkt_residual(nlp, nlp.point(X), ROW / 10.0, BOUND / 10.0)
    assert residual.worst < 1e-14
    assert kkt_residual(nlp, nlp.point(X), ROW, BOUND).stationarity == pytest.approx(28.8)


def test_worst_is_the_largest():
    assert Residual(1e-3, 4e-2, 2e-5).worst == 4e-2
    assert Residual(1e-3, 4e-4, 2e-2).worst == 2e-2
    assert Residual(5e-3, 4e-4, 2e-5).worst == 5e-3
