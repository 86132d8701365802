from dataclasses import dataclass

import numpy as np
import pytest
from numerics import check_jacobian, relative_error

from gaitopt.errors import InputError
from gaitopt.gait import quantities
from gaitopt.gait.constraint import ConstraintBlock
from gaitopt.gait.functions import (
    ComplexStep,
    Entries,
    FrictionCone,
    Length,
    Linear,
    SquaredNorm,
    Torsion,
    check_function,
)

FORCES = np.array([[30.0, -40.0, 200.0, 1.0, 2.0, 3.0], [-3.0, 5.0, 80.0, 0.0, 1.0, 4.0]])
LEGS = np.array([[0.1, -0.06, 0.55], [-0.2, 0.07, 0.5]])
MAPS = (
    (Linear(np.array([[1.0, 0.0, 2.0, 0.0, -1.0, 0.0], [0.0, 3.0, 0.0, 0.5, 0.0, 1.0]])), FORCES),
    (FrictionCone(0.7, 0.05), FORCES),
    (Length(), LEGS),
    (Entries(slice(1, 6, 2), 6, -1.0), FORCES),
    (Torsion(0.05, 20.0), FORCES),
    (SquaredNorm(np.array([1.0, 2.0, 0.5, 0.0, 3.0, 1.0])), FORCES),
    (ComplexStep(lambda v: np.sqrt(v[:, :1] ** 2 + v[:, 2:3] ** 2) * [1.0, 2.0]), FORCES),
)
maps = pytest.mark.parametrize(
    ("rows", "quantity"),
    MAPS,
    ids=["linear", "cone", "length", "entries", "torsion", "squares", "complex"],
)
curved = pytest.mark.parametrize(
    ("rows", "quantity"),
    [*MAPS[1:3], *MAPS[4:]],
    ids=["cone", "length", "torsion", "squares", "complex"],
)


@maps
def test_slope(rows, quantity):
    """Instants do not see each other, so both may move at once."""
    move = np.zeros(quantity.shape[1])
    slope = np.broadcast_to(
        rows.jacobian(quantity), (len(quantity), rows.value(quantity).shape[1], move.size)
    )
    check_jacobian(lambda d: rows.value(quantity + d), slope, move, step=1e-3)


@maps
def test_jacobian_is_slope_after_slope(rows, quantity, rng):
    slopes = rng.normal(size=(*quantity.shape, 4))
    expected = rows.jacobian(quantity) @ slopes
    assert relative_error(rows.chained(quantity, slopes), expected) < 1e-14


@curved
def test_curvature(rows, quantity):
    weights = np.array([[0.7, 0.2], [-1.3, 0.9]])[:, : rows.value(quantity).shape[1]]
    H = rows.hessian(quantity, weights)

    def slope(d):
        return (weights[:, None] @ rows.jacobian(quantity + d))[:, 0]

    check_jacobian(slope, H, np.zeros(quantity.shape[1]), step=1e-3)
    np.testing.assert_allclose(H, H.swapaxes(1, 2), atol=1e-15)


def test_linear_rows_do_not_bend():
    rows, quantity = MAPS[0]
    assert rows.hessian(quantity, np.ones((2, 2))) is None
    np.testing.assert_allclose(rows.value(quantity)[0], [30.0 + 400.0 - 2.0, -120.0 + 0.5 + 3.0])


def test_entries_are_picked_with_a_sign():
    rows, quantity = MAPS[3]
    np.testing.assert_array_equal(rows.value(quantity), -quantity[:, [1, 3, 5]])
    assert rows.hessian(quantity, np.ones((2, 3))) is None


def test_the_cone_is_coulombs():
    sharp = FrictionCone(0.7, 1e-9)
    np.testing.assert_allclose(sharp.value(FORCES)[0], [0.7 * 200.0 - 50.0])


def test_smoothing_moves_the_cone_inwards_by_no_more_than_itself():
    smooth, sharp = FrictionCone(0.7, 0.05).value(FORCES), FrictionCone(0.7, 0.0).value(FORCES)
    assert (smooth < sharp).all()
    vertical = np.array([[0.0, 0.0, 100.0]])
    assert FrictionCone(0.7, 0.05).value(vertical)[0, 0] == pytest.approx(70.0 - 0.05)
    assert np.isfinite(FrictionCone(0.7, 0.05).jacobian(vertical)).all()


def test_torsion_is_the_moment_through_the_centre_of_pressure():
    f, m = FORCES[0, :3], FORCES[0, 3:]
    pressure = np.array([-m[1] / f[2], m[0] / f[2], 0.0])
    moment = (m - np.cross(pressure, f))[2]
    left, right = Torsion(0.05, 1e-9).value(FORCES)[0]
    assert (left + right) / 2.0 == pytest.approx(0.05 * 200.0)
    assert (right - left) / 2.0 == pytest.approx(moment)


def test_torsion_has_a_value_where_the_load_vanishes():
    rows, unloaded = Torsion(0.05, 1.0), np.array([[3.0, 2.0, 0.0, 0.5, -0.4, 0.7]])
    np.testing.assert_allclose(rows.value(unloaded), [[-0.7, 0.7]])  # about the origin
    assert np.isfinite(rows.hessian(unloaded, np.array([[1.0, 2.0]]))).all()
    loaded = np.array([[3.0, 2.0, 25.0, 0.5, -0.4, 0.7]])
    np.testing.assert_allclose(rows.value(loaded), Torsion(0.05, 0.0).value(loaded), rtol=1e-3)


def test_lengths():
    assert relative_error(Length().value(LEGS)[:, 0], np.sqrt((LEGS**2).sum(axis=1))) < 1e-15


def constraint(instants: np.ndarray) -> ConstraintBlock:
    shape = (instants.size, 2)
    return ConstraintBlock(
        name="example", equation="(1)", unit="N", words="an example", change=1.0,
        reads=(quantities.WRENCH,), function=MAPS[0][0], labels=("a", "b"),
        lower=np.zeros(shape), upper=np.ones(shape), scale=np.ones(2),
        instants=instants, times=None,
    )  # fmt: skip


def test_a_constraint_takes_its_instants():
    quantity = np.arange(15.0).reshape(5, 3)
    values = {quantities.WRENCH: quantity}
    np.testing.assert_array_equal(constraint(np.array([1, 4])).take(values), quantity[[1, 4]])
    np.testing.assert_array_equal(constraint(np.arange(5)).take(values), quantity)
    assert constraint(np.array([1, 4])).size == 4


def test_complex_steps_are_as_good_as_formulas():
    """The smoothed friction cone by its value alone."""
    cone = FrictionCone(0.7, 0.05)
    by_value = ComplexStep(
        lambda v: 0.7 * v[:, 2:3] - np.sqrt(v[:, :1] ** 2 + v[:, 1:2] ** 2 + 0.05**2)
    )
    weights = np.array([[0.7], [-1.3]])
    assert relative_error(by_value.jacobian(FORCES), cone.jacobian(FORCES)) < 1e-14
    assert relative_error(by_value.hessian(FORCES, weights), cone.hessian(FORCES, weights)) < 1e-8


def test_a_function_that_does_not_extend_to_complex_numbers_is_refused():
    function = ComplexStep(lambda v: np.abs(v[:, :1]))
    with pytest.raises(InputError, match=r"jacobian of the function of it disagrees .*not abs"):
        check_function(function, FORCES[0], 1, "it")


@dataclass(frozen=True)
class Bent(SquaredNorm):
    """Squares whose second derivative is wrong."""

    def hessian(self, quantity, weights):
        """Return half of it."""
        return 0.5 * super().hessian(quantity, weights)


def test_wrong_derivatives_are_found():
    with pytest.raises(InputError, match="hessian of the function of it disagrees with differ"):
        check_function(Bent(np.ones(6)), np.ones(6), 1, "it")
    for function, quantity in MAPS:
        rows = function.value(quantity).shape[1]
        check_function(function, quantity[0], rows, "it")
