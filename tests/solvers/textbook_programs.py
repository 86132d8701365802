"""Textbook nonlinear programs with known solutions and multipliers.

HSn: W. Hock, K. Schittkowski, "Test Examples for Nonlinear Programming Codes" (1981), problem n.
NW: J. Nocedal, S. Wright, "Numerical Optimization", 2nd edition (2006).
Multipliers follow gaitopt.nlp: positive at an upper limit, negative at a lower one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gaitopt.errors import EvaluationError
from gaitopt.nlp import NLP, Array, Point, Rows, Values, Variables

INF = np.inf


@dataclass(frozen=True)
class Textbook(NLP):
    """A program given by functions, with its start and its solution."""

    title: str
    start: Array
    cost: Callable[[Array], float]
    gradient: Callable[[Array], Array]
    curvature: Callable[[Array], Array]
    value: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]
    row_curvatures: Callable[[Array], list[Array]]
    variables: Variables
    rows: Rows
    solution: Array
    best: float
    multipliers: Array
    bound_multipliers: Array
    cost_scale: float = 1.0
    has_hessian: bool = True

    def values(self, x: Array) -> Values:
        return Values(x, float(self.cost(x)), np.asarray(self.value(x), float))

    def point(self, x: Array) -> Point:
        values = self.values(x)
        jacobian = np.asarray(self.jacobian(x), float).reshape(values.rows.size, x.size)
        gradient = np.asarray(self.gradient(x), float)
        return Point(x, values.cost, values.rows, gradient, jacobian)

    def hessian(self, x: Array, multipliers: Array, cost_weight: float) -> Array:
        if not self.has_hessian:
            raise NotImplementedError
        matrix = cost_weight * np.asarray(self.curvature(x), float)
        for y, curvature in zip(multipliers, self.row_curvatures(x), strict=True):
            matrix = matrix + y * np.asarray(curvature, float)
        return matrix

    def describe(self, row: int) -> str:
        return f"row {row} of {self.title}"


def box(lower: list[float], upper: list[float], scale: list[float] | None = None) -> Variables:
    n = len(lower)
    return Variables(
        tuple(f"x{i + 1}" for i in range(n)),
        np.array(lower, float),
        np.array(upper, float),
        np.ones(n) if scale is None else np.array(scale, float),
    )


def free(n: int, scale: list[float] | None = None) -> Variables:
    return box([-INF] * n, [INF] * n, scale)


def limits(lower: list[float], upper: list[float]) -> Rows:
    return Rows(np.array(lower, float), np.array(upper, float))


def array(*numbers: float) -> Array:
    return np.array(numbers, float)


def hs7() -> Textbook:
    """One curved equality."""
    return Textbook(
        title="HS7",
        start=array(2, 2),
        cost=lambda x: np.log1p(x[0] ** 2) - x[1],
        gradient=lambda x: array(2 * x[0] / (1 + x[0] ** 2), -1),
        curvature=lambda x: np.diag([2 * (1 - x[0] ** 2) / (1 + x[0] ** 2) ** 2, 0]),
        value=lambda x: array((1 + x[0] ** 2) ** 2 + x[1] ** 2),
        jacobian=lambda x: array(4 * x[0] * (1 + x[0] ** 2), 2 * x[1]),
        row_curvatures=lambda x: [np.diag([4 + 12 * x[0] ** 2, 2])],
        variables=free(2),
        rows=limits([4], [4]),
        solution=array(0, 3**0.5),
        best=-(3**0.5),
        multipliers=array(0.5 / 3**0.5),
        bound_multipliers=np.zeros(2),
    )


def hs15(cost_scale: float = 1.0) -> Textbook:
    """Rosenbrock's function and a hyperbola; the multipliers add to 2451.

    Not from HS's start (-2, 1), which lies nearer to the other branch of the hyperbola and the
    local minimum of 360.4 there.
    """
    return Textbook(
        title=f"HS15, cost times {cost_scale:g}",
        start=array(0.2, 3),
        cost=lambda x: 100 * (x[1] - x[0] ** 2) ** 2 + (1 - x[0]) ** 2,
        gradient=lambda x: array(
            -400 * x[0] * (x[1] - x[0] ** 2) - 2 * (1 - x[0]), 200 * (x[1] - x[0] ** 2)
        ),
        curvature=lambda x: np.array(
            [[1200 * x[0] ** 2 - 400 * x[1] + 2, -400 * x[0]], [-400 * x[0], 200]]
        ),
        value=lambda x: array(x[0] * x[1], x[0] + x[1] ** 2),
        jacobian=lambda x: np.array([[x[1], x[0]], [1, 2 * x[1]]]),
        row_curvatures=lambda x: [np.array([[0, 1], [1, 0]]), np.diag([0, 2])],
        variables=box([-INF, -INF], [0.5, INF]),
        rows=limits([1, 0], [INF, INF]),
        solution=array(0.5, 2),
        best=306.5,
        multipliers=cost_scale * array(-700, 0),
        bound_multipliers=cost_scale * array(1751, 0),
        cost_scale=cost_scale,
    )


def hs26() -> Textbook:
    """One equality; the Hessian is singular at the solution and the multiplier vanishes."""
    a = np.array([[1, -1, 0], [-1, 1, 0], [0, 0, 0]], float)
    b = np.array([[0, 0, 0], [0, 1, -1], [0, -1, 1]], float)
    return Textbook(
        title="HS26",
        start=array(-2.6, 2, 2),
        cost=lambda x: (x[0] - x[1]) ** 2 + (x[1] - x[2]) ** 4,
        gradient=lambda x: (
            2 * (x[0] - x[1]) * array(1, -1, 0) + 4 * (x[1] - x[2]) ** 3 * array(0, 1, -1)
        ),
        curvature=lambda x: 2 * a + 12 * (x[1] - x[2]) ** 2 * b,
        value=lambda x: array((1 + x[1] ** 2) * x[0] + x[2] ** 4),
        jacobian=lambda x: array(1 + x[1] ** 2, 2 * x[0] * x[1], 4 * x[2] ** 3),
        row_curvatures=lambda x: [
            np.array([[0, 2 * x[1], 0], [2 * x[1], 2 * x[0], 0], [0, 0, 12 * x[2] ** 2]])
        ],
        variables=free(3),
        rows=limits([3], [3]),
        solution=array(1, 1, 1),
        best=0.0,
        multipliers=array(0),
        bound_multipliers=np.zeros(3),
    )


def hs43() -> Textbook:
    """Rosen and Suzuki: three convex quadratic rows."""
    forms = np.array([[1, 1, 1, 1], [1, 2, 1, 2], [2, 1, 1, 0]], float)
    lines = np.array([[1, -1, 1, -1], [-1, 0, 0, -1], [2, -1, 0, -1]], float)
    weights, slope = array(1, 1, 2, 1), array(-5, -5, -21, 7)
    return Textbook(
        title="HS43",
        start=np.zeros(4),
        cost=lambda x: weights @ x**2 + slope @ x,
        gradient=lambda x: 2 * weights * x + slope,
        curvature=lambda x: 2 * np.diag(weights),
        value=lambda x: forms @ x**2 + lines @ x,
        jacobian=lambda x: 2 * forms * x + lines,
        row_curvatures=lambda x: [2 * np.diag(form) for form in forms],
        variables=free(4, [1, 0.5, 2, 1]),
        rows=limits([-INF] * 3, [8, 10, 5]),
        solution=array(0, 1, 2, -1),
        best=-44.0,
        multipliers=array(1, 0, 2),
        bound_multipliers=np.zeros(4),
    )


def hs71() -> Textbook:
    """A product, a sphere as equality, and bounds, one of them active."""

    def product_curvature(x: Array) -> Array:
        H = np.prod(x) / np.outer(x, x)
        np.fill_diagonal(H, 0)
        return H

    def cost_curvature(x: Array) -> Array:
        H = np.zeros((4, 4))
        H[0, :] = H[:, 0] = [0, x[3], x[3], 2 * x[0] + x[1] + x[2]]
        H[0, 0] = 2 * x[3]
        H[1, 3] = H[3, 1] = H[2, 3] = H[3, 2] = x[0]
        return H

    return Textbook(
        title="HS71",
        start=array(1, 5, 5, 1),
        cost=lambda x: x[0] * x[3] * (x[0] + x[1] + x[2]) + x[2],
        gradient=lambda x: array(
            x[3] * (2 * x[0] + x[1] + x[2]),
            x[0] * x[3],
            x[0] * x[3] + 1,
            x[0] * (x[0] + x[1] + x[2]),
        ),
        curvature=cost_curvature,
        value=lambda x: array(np.prod(x), x @ x),
        jacobian=lambda x: np.array([np.prod(x) / x, 2 * x]),
        row_curvatures=lambda x: [product_curvature(x), 2 * np.eye(4)],
        variables=box([1] * 4, [5] * 4),
        rows=limits([25, 40], [INF, 40]),
        solution=array(1, 4.74299963, 3.82114998, 1.37940829),
        best=17.0140173,
        multipliers=array(-0.55229366, 0.16146857),
        bound_multipliers=array(-1.08787121, 0, 0, 0),
    )


def hs76() -> Textbook:
    """A convex quadratic program."""
    H = np.array([[2, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 2, 1], [0, 0, 1, 1]], float)
    c = array(-1, -3, 1, -1)
    A = np.array([[1, 2, 1, 1], [3, 1, 2, -1], [0, 1, 4, 0]], float)
    return Textbook(
        title="HS76",
        start=array(0.5, 0.5, 0.5, 0.5),
        cost=lambda x: 0.5 * x @ H @ x + c @ x,
        gradient=lambda x: H @ x + c,
        curvature=lambda x: H,
        value=lambda x: A @ x,
        jacobian=lambda x: A,
        row_curvatures=lambda x: [np.zeros((4, 4))] * 3,
        variables=box([0] * 4, [INF] * 4, [1, 2, 0.5, 1]),
        rows=limits([-INF, -INF, 1.5], [5, 4, INF]),
        solution=array(3, 23, 0, 6) / 11,
        best=-4.681818181818182,
        multipliers=array(5, 0, 0) / 11,
        bound_multipliers=array(0, 0, -19, 0) / 11,
    )


def hs100() -> Textbook:
    """Seven variables, sixth powers, four rows of which two are active."""

    def cost_H(x):
        return np.diag([2, 10, 12 * x[2] ** 2, 6, 300 * x[4] ** 4, 14, 12 * x[6] ** 2]) + np.array(
            [[0.0] * 7] * 5 + [[0] * 6 + [-4], [0] * 5 + [-4, 0]]
        )

    quarter = np.zeros((7, 7))
    quarter[0, 1] = quarter[1, 0] = -3
    return Textbook(
        title="HS100",
        start=array(1, 2, 0, 4, 0, 1, 1),
        cost=lambda x: (
            (x[0] - 10) ** 2
            + 5 * (x[1] - 12) ** 2
            + x[2] ** 4
            + 3 * (x[3] - 11) ** 2
            + 10 * x[4] ** 6
            + 7 * x[5] ** 2
            + x[6] ** 4
            - 4 * x[5] * x[6]
            - 10 * x[5]
            - 8 * x[6]
        ),
        gradient=lambda x: array(
            2 * (x[0] - 10),
            10 * (x[1] - 12),
            4 * x[2] ** 3,
            6 * (x[3] - 11),
            60 * x[4] ** 5,
            14 * x[5] - 4 * x[6] - 10,
            4 * x[6] ** 3 - 4 * x[5] - 8,
        ),
        curvature=cost_H,
        value=lambda x: array(
            2 * x[0] ** 2 + 3 * x[1] ** 4 + x[2] + 4 * x[3] ** 2 + 5 * x[4],
            7 * x[0] + 3 * x[1] + 10 * x[2] ** 2 + x[3] - x[4],
            23 * x[0] + x[1] ** 2 + 6 * x[5] ** 2 - 8 * x[6],
            4 * x[0] ** 2 + x[1] ** 2 - 3 * x[0] * x[1] + 2 * x[2] ** 2 + 5 * x[5] - 11 * x[6],
        ),
        jacobian=lambda x: np.array(
            [
                [4 * x[0], 12 * x[1] ** 3, 1, 8 * x[3], 5, 0, 0],
                [7, 3, 20 * x[2], 1, -1, 0, 0],
                [23, 2 * x[1], 0, 0, 0, 12 * x[5], -8],
                [8 * x[0] - 3 * x[1], 2 * x[1] - 3 * x[0], 4 * x[2], 0, 0, 5, -11],
            ]
        ),
        row_curvatures=lambda x: [
            np.diag([4, 36 * x[1] ** 2, 0, 8, 0, 0, 0]),
            np.diag([0, 0, 20, 0, 0, 0, 0]),
            np.diag([0, 2, 0, 0, 0, 12, 0]),
            np.diag([8, 2, 4, 0, 0, 0, 0]) + quarter,
        ],
        variables=free(7),
        rows=limits([-INF] * 4, [127, 282, 196, 0]),
        solution=array(2.330499, 1.951372, -0.4775414, 4.365726, -0.6244870, 1.038131, 1.594227),
        best=680.6300573,
        multipliers=0.1 * array(1.139725, 0, 0, 0.3686155),
        bound_multipliers=np.zeros(7),
        cost_scale=0.1,
    )


def maratos() -> Textbook:
    """NW Example 15.4: full steps worsen both cost and violation unless corrected."""
    angle = 0.9
    return Textbook(
        title="Maratos",
        start=array(np.cos(angle), np.sin(angle)),
        cost=lambda x: 2 * (x @ x - 1) - x[0],
        gradient=lambda x: 4 * x - array(1, 0),
        curvature=lambda x: 4 * np.eye(2),
        value=lambda x: array(x @ x),
        jacobian=lambda x: 2 * x,
        row_curvatures=lambda x: [2 * np.eye(2)],
        variables=free(2),
        rows=limits([1], [1]),
        solution=array(1, 0),
        best=-1.0,
        multipliers=array(-1.5),
        bound_multipliers=np.zeros(2),
    )


def rosenbrock_in_disk() -> Textbook:
    """Rosenbrock's valley cut by the unit disk; solution to ten digits by Newton's method."""
    valley = hs15()
    return Textbook(
        title="Rosenbrock in a disk",
        start=array(-0.5, 0.3),
        cost=valley.cost,
        gradient=valley.gradient,
        curvature=valley.curvature,
        value=lambda x: array(x @ x),
        jacobian=lambda x: 2 * x,
        row_curvatures=lambda x: [2 * np.eye(2)],
        variables=free(2, [0.5, 1]),
        rows=limits([-INF], [1]),
        solution=array(0.7864151542, 0.6176983125),
        best=0.0456748087,
        multipliers=array(0.1214940),
        bound_multipliers=np.zeros(2),
    )


def two_sided() -> Textbook:
    """Nearest point to (2, 1, -3) in a slab and a box: each side of a limit by hand."""
    target = array(2, 1, -3)
    return Textbook(
        title="slab and box",
        start=array(-3, 1, 4),
        cost=lambda x: 10 * (x - target) @ (x - target),
        gradient=lambda x: 20 * (x - target),
        curvature=lambda x: 20 * np.eye(3),
        value=lambda x: array(x[0] + x[1], x[0] - x[2] ** 2),
        jacobian=lambda x: np.array([[1, 1, 0], [1, 0, -2 * x[2]]]),
        row_curvatures=lambda x: [np.zeros((3, 3)), np.diag([0, 0, -2])],
        variables=box([-5, -5, -2], [5, 5, 5]),
        rows=limits([-1, -50], [1, 50]),
        solution=array(1, 0, -2),
        best=30.0,
        multipliers=array(2, 0),
        bound_multipliers=array(0, 0, -2),
        cost_scale=0.1,
    )


def waechter_biegler() -> Textbook:
    """Waechter & Biegler (2000): methods that only shorten linearised steps never arrive.

    From this start the least largest violation nearby is sqrt(3)/2, where 1/2 - x = 1 - x^2.
    """
    return Textbook(
        title="Waechter and Biegler",
        start=array(-2, 3, 1),
        cost=lambda x: x[0],
        gradient=lambda x: array(1, 0, 0),
        curvature=lambda x: np.zeros((3, 3)),
        value=lambda x: array(x[0] ** 2 - x[1] - 1, x[0] - x[2] - 0.5),
        jacobian=lambda x: np.array([[2 * x[0], -1, 0], [1, 0, -1]]),
        row_curvatures=lambda x: [np.diag([2, 0, 0]), np.zeros((3, 3))],
        variables=box([-INF, 0, 0], [INF, INF, INF]),
        rows=limits([0, 0], [0, 0]),
        solution=array(1, 0, 0.5),
        best=1.0,
        multipliers=array(-0.5, 0),
        bound_multipliers=array(0, -0.5, 0),
    )


def undefined_region() -> Textbook:
    """Square roots, undefined off the positive quadrant; the start is at its edge."""

    def roots(x: Array) -> Array:
        if np.any(x <= 0):
            raise EvaluationError("root of a negative number")
        return np.sqrt(x)

    return Textbook(
        title="square roots",
        start=array(2.9, 0.01),
        cost=lambda x: -roots(x).sum(),
        gradient=lambda x: -0.5 / roots(x),
        curvature=lambda x: np.diag(0.25 / roots(x) ** 3),
        value=lambda x: array(x[0] + 2 * x[1]),
        jacobian=lambda x: array(1, 2),
        row_curvatures=lambda x: [np.zeros((2, 2))],
        variables=free(2),
        rows=limits([-INF], [3]),
        solution=array(2, 0.5),
        best=-1.5 * 2**0.5,
        multipliers=array(0.125**0.5),
        bound_multipliers=np.zeros(2),
    )


def degenerate() -> Textbook:
    """The same disk three times, once as its tangent: multipliers are not unique."""
    return Textbook(
        title="disk thrice",
        start=array(-0.5, 2),
        cost=lambda x: -3 * x[0] + x[1] ** 2,
        gradient=lambda x: array(-3, 2 * x[1]),
        curvature=lambda x: np.diag([0, 2]),
        value=lambda x: array(x @ x, 2 * x @ x, x[0]),
        jacobian=lambda x: np.array([2 * x, 4 * x, [1, 0]]),
        row_curvatures=lambda x: [2 * np.eye(2), 4 * np.eye(2), np.zeros((2, 2))],
        variables=free(2),
        rows=limits([-INF] * 3, [4, 8, 2]),
        solution=array(2, 0),
        best=-6.0,
        multipliers=array(np.nan, np.nan, np.nan),
        bound_multipliers=np.zeros(2),
    )


def cusp() -> Textbook:
    """Two curves that meet in a cusp, the optimum, at which they have no multipliers."""
    return Textbook(
        title="cusp",
        start=array(1, 0.5),
        cost=lambda x: 1000 + x[0],
        gradient=lambda x: array(1, 0),
        curvature=lambda x: np.zeros((2, 2)),
        value=lambda x: array(x[1] - x[0] ** 3, x[1] + x[0] ** 3),
        jacobian=lambda x: np.array([[-3 * x[0] ** 2, 1], [3 * x[0] ** 2, 1]]),
        row_curvatures=lambda x: [np.diag([-6 * x[0], 0]), np.diag([6 * x[0], 0])],
        variables=free(2),
        rows=limits([-INF, 0], [0, INF]),
        solution=array(0, 0),
        best=1000.0,
        multipliers=array(np.nan, np.nan),
        bound_multipliers=np.zeros(2),
    )


def infeasible() -> Textbook:
    """A disk and a half plane that do not meet; least largest violation 1, at (1, 1)."""
    return Textbook(
        title="disk and half plane",
        start=array(2, -1),
        cost=lambda x: x[0] ** 2 + 0.5 * x[1],
        gradient=lambda x: array(2 * x[0], 0.5),
        curvature=lambda x: np.diag([2, 0]),
        value=lambda x: array(x @ x, x[0] + x[1]),
        jacobian=lambda x: np.array([2 * x, [1, 1]]),
        row_curvatures=lambda x: [2 * np.eye(2), np.zeros((2, 2))],
        variables=free(2),
        rows=limits([-INF, 3], [1, INF]),
        solution=array(1, 1),
        best=np.nan,
        multipliers=array(np.nan, np.nan),
        bound_multipliers=np.zeros(2),
    )


SOLVABLE = (
    hs7(),
    hs15(0.01),
    hs43(),
    hs71(),
    hs76(),
    hs100(),
    maratos(),
    rosenbrock_in_disk(),
    two_sided(),
    undefined_region(),
)
"""Programs with one solution and unique multipliers, both nonzero."""
