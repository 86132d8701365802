from dataclasses import replace

import pytest
from sweeps import QUICK

from gaitopt.design.audit import audit
from gaitopt.design.options import DesignOptions
from gaitopt.errors import GaitFileError, InputError
from gaitopt.solvers import solver_by_name
from gaitopt.sweep.interpolation import interpolate, stored_point
from gaitopt.sweep.library import open_library


def test_a_gait_between_is_certified_and_what_interpolation_lacks_is_said(swept):
    options = DesignOptions(solver=solver_by_name("sqp"))
    found = interpolate(swept, {"speed": 0.98}, options)
    assert found.design.certificate.certified
    assert audit(found.design.gait).passed
    assert found.design.gait.speed == pytest.approx(0.98, rel=1e-9)
    assert found.sources == ("speed=0.95", "speed=1")
    assert found.plain is not None
    assert found.plain.violation > 1e-6
    assert "violates" in found.sentence


def test_at_a_point_it_is_the_gait_of_the_library(swept):
    found = interpolate(swept, {"speed": 1.05}, QUICK)
    cost = next(row["cost"] for row in swept.rows if row["speed"] == 1.05)
    assert found.design.solution.cost == pytest.approx(cost, rel=1e-8)
    assert found.sources == ("speed=1.05",)


def test_a_stored_point_is_known_and_not_called_interpolated(swept):
    assert stored_point(swept, {"speed": 1.05}) == (2,)
    assert stored_point(swept, {"speed": 1.06}) is None
    found = interpolate(swept, {"speed": 1.05}, QUICK)
    assert found.plain is not None
    assert found.sentence.startswith("the stored gait ")


def test_rounding_is_no_violation(swept):
    found = interpolate(swept, {"speed": 0.98}, QUICK)
    exact = replace(found, plain=replace(found.plain, violation=1e-11))
    assert exact.sentence == "plain interpolation of the parameters keeps every limit"


@pytest.mark.parametrize(
    ("values", "said"),
    [({"speed": 1.4}, "outside the library"), ({"friction": 0.5}, "give a value of each of speed")],
)
def test_what_is_not_between_is_refused(swept, values, said):
    with pytest.raises(InputError, match=said):
        interpolate(swept, values)


def test_another_directory_is_no_library(tmp_path):
    with pytest.raises(GaitFileError, match="is no gait library"):
        open_library(tmp_path)
