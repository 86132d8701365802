"""Exact Hessians of the cost and of every constraint against differences of exact gradients."""

import functools

import numpy as np
import pytest
from numerics import check_differences, steps
from walks import AT_IMPACT, NAMES, OF_TURN, PAIRS, SOFT, WALKS, walk

from gaitopt.gait import quantities
from gaitopt.gait.step_hessian import StepWeights

STEPS = steps(4e-4, 6)  # of variables.scale; friction cones need small ones, impacts large ones
DIRECTIONS = ("joints", "geometry", "all")
LINEAR = ("walking speed", "front load", "front cop")
BOTH = "upright, double support after an impact on both"
OF_PUSH = ("impulse", "impulse cop", "landing impulse")  # which is a parameter there


def is_linear(name: str, constraint: str) -> bool:
    if "double support" in name and "free" not in name and constraint in OF_TURN:
        return True  # its duration is fixed
    return constraint in LINEAR or (name.startswith(BOTH) and constraint in OF_PUSH)


def parts(name: str, constraint: str) -> tuple[str, ...]:
    """Directions on which a constraint's gradient depends."""
    if constraint == "leg length":
        return ("geometry",)
    if constraint in OF_TURN:
        return ("geometry", "all")  # with them the duration; else they are linear
    lifted = "lifted" in name and constraint in (*AT_IMPACT, *SOFT)
    return ("joints", "all") if lifted else DIRECTIONS


@functools.cache
def direction(name: str, part: str) -> np.ndarray:
    """A random direction in scaled parameters."""
    problem = walk(name).problem
    d = np.random.default_rng(9).normal(size=problem.layout.size)
    if part == "joints":
        d[problem.layout.shape] = 0.0
    if part == "geometry":
        d[: problem.layout.shape.start] = 0.0
    return d * problem.variables.scale


@functools.cache
def slope_differences(name: str, part: str) -> list[np.ndarray]:
    """Change of the gradients of cost (first) and rows along a direction, at two steps."""
    problem, x = walk(name).problem, walk(name).x

    def slopes(at):
        point = problem.point(at)
        return np.vstack([point.gradient, point.jacobian])

    moves = [(h, h * direction(name, part)) for h in STEPS]
    return [(slopes(x + move) - slopes(x - move)) / (2.0 * h) for h, move in moves]


@functools.cache
def weights(name: str, constraint: str) -> np.ndarray:
    """Random multipliers of the rows of one constraint, zero elsewhere."""
    problem = walk(name).problem
    y = np.zeros(problem.rows.lower.size)
    rows = problem.rows_of(constraint)
    y[rows] = np.random.default_rng(11).normal(size=rows.stop - rows.start)
    return y


@functools.cache
def constraint_hessian(name: str, constraint: str) -> np.ndarray:
    return walk(name).problem.hessian(walk(name).x, weights(name, constraint), 0.0)


def check(name: str, part: str, H: np.ndarray, w: np.ndarray) -> None:
    """Compare H d with the differences of w . slopes, both in scaled parameters."""
    scale = walk(name).problem.variables.scale
    found = [(w @ d) * scale for d in slope_differences(name, part)]
    check_differences(scale * (H @ direction(name, part)), found)


@pytest.mark.parametrize("part", DIRECTIONS)
@pytest.mark.parametrize("name", WALKS)
def test_hessian_of_the_cost(name, part):
    problem, x = walk(name).problem, walk(name).x
    m = problem.rows.lower.size
    check(name, part, problem.hessian(x, np.zeros(m), 1.0), np.eye(1, m + 1)[0])


@pytest.mark.parametrize(("name", "constraint"), [p for p in PAIRS if not is_linear(*p)])
def test_hessian_of_every_constraint(name, constraint):
    weight = np.concatenate([[0.0], weights(name, constraint)])
    for part in parts(name, constraint):
        check(name, part, constraint_hessian(name, constraint), weight)


ELSEWHERE = (
    quantities.PEAK,
    quantities.FRONT_WRENCH,
    quantities.REAR_IMPULSE,
    quantities.ADVANCE,
    quantities.ARM_GAPS,
)  # no entries in most walks
CURVED = [
    ("upright, everything free", what)
    for what in quantities.ALL
    if what not in (quantities.GAPS, quantities.FOOT_TURN, *ELSEWHERE)
]
CURVED += [
    ("upright, toe off, everything free", what)
    for what in quantities.ALL
    if what not in (quantities.GAPS, *ELSEWHERE)
]
CURVED += [
    ("upright, double support", what)
    for what in quantities.ALL
    if what not in (
        quantities.GAPS, quantities.FOOT_TURN, quantities.IMPULSE, quantities.SOLE_TWIST,
        quantities.PEAK, quantities.ADVANCE, quantities.REAR_IMPULSE, quantities.ARM_GAPS,
    )
]  # fmt: skip
CURVED += [("upright, lifted, seven joints, waist, arms", quantities.ARM_GAPS)]
CURVED += [(BOTH, what) for what in (quantities.IMPULSE, quantities.REAR_IMPULSE, quantities.RATES)]


@pytest.mark.parametrize(("name", "what"), [*CURVED, ("lifted, everything free", quantities.GAPS)])
def test_hessian_of_a_curved_function_of_every_quantity(name, what):
    """Half the sum of w v^2: constraints of one's own may be curved in any quantity."""
    problem, x = walk(name).problem, walk(name).x
    step = problem.step(x)
    v = step.read(what)
    w = np.random.default_rng(5).uniform(0.5, 1.5, v.shape)
    weights = StepWeights.zero(step)
    weights.first[what] += w * v
    weights.add_second((what, what), slice(None), w[:, :, None] * np.eye(v.shape[1]))

    def gradient(at):
        step, slope = problem.derivatives(at)
        return np.einsum("ke,kep->p", w * step.read(what), slope.jacobians[what])

    H, scale = problem.curvature(x, weights), problem.variables.scale
    moves = [(h, h * direction(name, "all")) for h in STEPS]
    found = [(gradient(x + m) - gradient(x - m)) * scale / (2.0 * h) for h, m in moves]
    check_differences(scale * (H @ direction(name, "all")), found)


@pytest.mark.parametrize(
    ("name", "constraint"),
    [
        ("guess", "walking speed"),
        ("everything free", "walking speed"),
        ("upright, double support", "front load"),
        ("upright, double support", "front cop"),
        *((BOTH, constraint) for constraint in OF_PUSH),
        *(("upright, double support, toe off", constraint) for constraint in OF_TURN),
    ],
)
def test_what_is_linear_bends_nothing(name, constraint):
    problem, x = walk(name).problem, walk(name).x
    assert np.abs(weights(name, constraint)).max() > 0.0
    assert np.abs(constraint_hessian(name, constraint)).max() == 0.0
    slope = np.abs(problem.point(x).jacobian[problem.rows_of(constraint)]).max()
    assert slope == 1.0 if constraint == "walking speed" else slope > 0.0


@pytest.mark.parametrize("name", WALKS)
def test_hessians_add_up_and_are_symmetric(name):
    """That of the Lagrangian is the weighted sum of the parts."""
    problem, x = walk(name).problem, walk(name).x
    constraints = [f for f in NAMES if (name, f) in PAIRS]
    total = sum(weights(name, f) for f in constraints)
    H = problem.hessian(x, total, 3.0)
    parts = [constraint_hessian(name, f) for f in constraints]
    expected = 3.0 * problem.hessian(x, np.zeros_like(total), 1.0) + sum(parts)
    np.testing.assert_allclose(H, expected, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_array_equal(H, H.T)
