"""Finding solvers by name, multipliers from a point alone, differences, missing packages."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import textbook_programs as bank

from gaitopt import solvers
from gaitopt.errors import EvaluationError, InputError, MissingExtraError
from gaitopt.nlp import (
    NLP,
    Point,
    Progress,
    Rows,
    Start,
    Status,
    Values,
    Variables,
    kkt_residual,
)
from gaitopt.solvers import (
    SOLVERS,
    FiniteDifferenceNLP,
    Ipopt,
    least_squares_multipliers,
    solver_by_name,
)
from gaitopt.solvers.solver import SingleStage


@pytest.mark.parametrize("name", SOLVERS)
def test_every_name_makes_its_solver(name: str) -> None:
    solver = solver_by_name(name)
    assert solver.name == ("sqp+newton" if name == "default" else name)


@pytest.mark.parametrize(
    ("own", "told"),
    [
        (
            {"name": "mine", "_solved": lambda *_: {}["x"]},
            r"'mine': KeyError: 'x' \(line \d+ of test_",
        ),
        (
            {"name": "mine", "_solved": lambda *_: None},
            "'mine' returns None; return what recorder.so",
        ),
        ({"_solved": lambda *_: None}, "the solver Mine has no name; give its class a text"),
    ],
)
def test_a_mistake_in_a_solver_of_ones_own_is_told_with_its_line(own: dict, told: str) -> None:
    program = bank.SOLVABLE[0]
    solver = type("Mine", (SingleStage,), {"__module__": __name__, **own})()
    with pytest.raises(InputError, match=told):
        solver.solve(program, Start(program.start))


def test_options_reach_the_solver() -> None:
    assert solver_by_name("sqp", tolerance=3e-5, qp_solver="proxqp").tolerance == 3e-5


def test_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"no solver 'spq'.*sqp, trust-constr, slsqp, ipopt"):
        solver_by_name("spq")


def test_unknown_option_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"sqp has no option 'tol'; it has tolerance, .*penalty"):
        solver_by_name("sqp", tol=1e-3)


def test_all_names_exist() -> None:
    assert all(hasattr(solvers, name) for name in solvers.__all__)


def test_import_is_light() -> None:
    code = "import sys, gaitopt.solvers; print(sorted({'scipy', 'qpsolvers'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_ipopt_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cyipopt", None)
    program = bank.hs71()
    with pytest.raises(MissingExtraError, match=r"gaitopt\[ipopt\]"):
        Ipopt().solve(program, Start(program.start))


@pytest.mark.skipif(importlib.util.find_spec("cyipopt") is None, reason="needs cyipopt")
@pytest.mark.parametrize("program", bank.SOLVABLE, ids=lambda program: program.title)
def test_ipopt_solves(program: bank.Textbook) -> None:
    solution = Ipopt().solve(program, Start(program.start))
    assert solution.status.name == "OPTIMAL"
    np.testing.assert_allclose(solution.x, program.solution, atol=1e-5)
    np.testing.assert_allclose(solution.multipliers, program.multipliers, rtol=1e-4, atol=1e-5)
    last = solution.history[-1]  # the records are IPOPT's own iterates, judged like all others
    assert last.cost == solution.cost
    assert last.optimality == pytest.approx(solution.optimality, abs=1e-9)


@pytest.mark.skipif(importlib.util.find_spec("cyipopt") is None, reason="needs cyipopt")
def test_ipopt_can_be_stopped() -> None:
    program, seen = bank.hs100(), []

    def stop(record: Progress) -> bool:
        seen.append(record)
        return len(seen) == 3

    solution = Ipopt().solve(program, Start(program.start), stop=stop)
    assert solution.status is Status.INTERRUPTED
    assert solution.history == tuple(seen)


@pytest.mark.parametrize("program", bank.SOLVABLE, ids=lambda program: program.title)
def test_multipliers_from_the_point_alone(program: bank.Textbook) -> None:
    point = program.point(program.solution)
    multipliers, bound_multipliers = least_squares_multipliers(program, point, 1e-4)
    size = max(1.0, np.abs(program.multipliers).max())
    np.testing.assert_allclose(multipliers, program.multipliers, atol=2e-5 * size)
    np.testing.assert_allclose(bound_multipliers, program.bound_multipliers, atol=2e-5 * size)


def test_multipliers_never_pull_the_wrong_way() -> None:
    program = bank.two_sided()
    # On the upper limit of the slab, but on the far side of the target: nothing to hold.
    point = program.point(np.array([4.0, -3.0, -2.0]))
    multipliers, bound_multipliers = least_squares_multipliers(program, point)
    assert multipliers.min() >= 0.0
    assert bound_multipliers[2] == pytest.approx(-2.0)


def test_differences_match_derivatives() -> None:
    program = bank.hs100()
    differences = FiniteDifferenceNLP(program)
    x = np.linspace(0.3, 1.4, 7)
    rough, exact = differences.point(x), program.point(x)
    np.testing.assert_allclose(rough.gradient, exact.gradient, rtol=1e-6, atol=1e-4)
    np.testing.assert_allclose(rough.jacobian, exact.jacobian, rtol=1e-6, atol=1e-4)
    assert not np.array_equal(rough.gradient, exact.gradient)
    assert differences.evaluations == 8
    assert not differences.has_hessian
    assert differences.describe(2) == program.describe(2)
    with pytest.raises(EvaluationError, match="no second derivatives"):
        differences.hessian(x, np.zeros(4), 1.0)


def test_differences_keep_an_exact_cost_gradient() -> None:
    program = bank.hs100()
    x = np.linspace(0.3, 1.4, 7)
    point = FiniteDifferenceNLP(program, cost_gradient_only=True).point(x)
    np.testing.assert_array_equal(point.gradient, program.point(x).gradient)
    assert not np.array_equal(point.jacobian, program.point(x).jacobian)


def test_differences_stay_inside_bounds_and_domain() -> None:
    program = bank.hs71()
    x = np.array([1.0, 5.0, 5.0, 1.0])  # the second and third at their upper bounds
    seen: list[np.ndarray] = []
    inner = replace(program, cost=lambda x: seen.append(x.copy()) or program.cost(x))
    point = FiniteDifferenceNLP(inner, step=1e-6).point(x)
    assert np.max(seen) <= 5.0
    np.testing.assert_allclose(point.gradient, program.point(x).gradient, atol=1e-4)
    edge = bank.undefined_region()
    mirrored = replace(
        edge,
        cost=lambda x: edge.cost(-x),
        gradient=lambda x: -edge.gradient(-x),
    )
    at_edge = np.array([-2.0, -1e-9])  # a forward step would leave the domain
    slope = FiniteDifferenceNLP(mirrored, step=1e-10).point(at_edge).gradient
    assert slope[1] == pytest.approx(0.5e9**0.5 * np.sqrt(0.5), rel=0.1)


class Falling(NLP):
    """A cost that falls without end along the first variable."""

    def __init__(self, power: int) -> None:
        self.power = power
        free = np.full(2, np.inf)
        self.variables = Variables(("x", "y"), -free, free, np.ones(2))
        self.rows = Rows(np.array([-1.0]), np.array([1.0]))
        self.cost_scale, self.has_hessian = 1.0, True

    def values(self, x):
        return Values(x, -(x[0] ** self.power) + x[1] ** 2, x[1:])

    def point(self, x):
        k = self.power
        values = self.values(x)
        gradient = np.array([-k * x[0] ** (k - 1), 2.0 * x[1]])
        return Point(x, values.cost, values.rows, gradient, np.array([[0.0, 1.0]]))

    def hessian(self, x, multipliers, cost_weight):
        k = self.power
        bend = -k * (k - 1) * x[0] ** max(k - 2, 0)
        return cost_weight * np.diag([bend, 2.0])

    def describe(self, row):
        return "y"


@pytest.mark.parametrize("power", [1, 2])
@pytest.mark.parametrize("name", ["default", "sqp", "slsqp"])
def test_a_cost_without_a_least_value_is_called_unbounded(name, power):
    solution = solver_by_name(name).solve(Falling(power), Start(np.array([1.0, 0.5])))
    assert solution.status is Status.UNBOUNDED


def test_a_multiplier_of_a_missing_limit_is_never_optimal():
    program = Falling(2)
    program.rows = Rows(np.array([-np.inf]), np.array([1.0]))
    point = program.point(np.array([0.0, 0.0]))
    residual = kkt_residual(program, point, np.array([-1e-3]), np.zeros(2))
    assert residual.complementarity == np.inf
    started = solver_by_name("default").solve(
        program, Start(np.array([1.0, 0.5]), np.array([-3.0]))
    )
    assert started.status is Status.UNBOUNDED
