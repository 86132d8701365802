"""The specification: the paper's numbers, and everything that is refused."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot.strategies import link_specs

from gaitopt.catalogue.biped_spec import (
    BipedSpec,
    LinkSpec,
    biped13,
    checked_inertia,
    mirrored_inertia,
)
from gaitopt.catalogue.parameters import changed
from gaitopt.errors import SpecError

SPEC = biped13()


def test_preset_has_the_mass_and_height_of_the_paper() -> None:
    # Table 2 adds up to 56.87 kg; the text below it says 56.86 kg and 1.30 m.
    leg = 2.04 + 2.08 + 1.75 + 0.65 + 1.64
    assert SPEC.total_mass == pytest.approx(40.55 + 2 * leg, rel=1e-15)
    assert SPEC.total_mass == pytest.approx(56.87, rel=1e-12)
    assert SPEC.standing_height == pytest.approx(1.30, rel=1e-12)


@given(link_specs().filter(lambda link: link.inertia is None), st.integers(0, 2))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_box_inertia_is_the_integral_over_the_box(link: LinkSpec, axis: int) -> None:
    # Two-point Gauss quadrature is exact for the quadratics in the integral of r² dm.
    gauss = np.array([-1.0, 1.0]) / np.sqrt(3.0) / 2.0
    points = np.stack(np.meshgrid(*(gauss * edge for edge in link.size)), axis=-1).reshape(-1, 3)
    squares = np.delete(points, axis, axis=1) ** 2
    expected = link.mass * squares.sum(axis=1).mean()
    assert link.com_inertia[axis][axis] == pytest.approx(expected, rel=1e-12)


@given(link_specs().filter(lambda link: link.inertia is not None))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_given_inertia_is_kept_and_mirrors_as_a_tensor(link: LinkSpec) -> None:
    flip = np.diag([1.0, -1.0, 1.0])
    mirrored = np.array(mirrored_inertia(link.com_inertia))
    assert link.com_inertia == link.inertia
    np.testing.assert_array_equal(mirrored, flip @ np.array(link.inertia) @ flip)


def test_integers_and_numpy_values_become_plain_floats() -> None:
    com = np.array([0.0, 0.01, -0.2])
    spec = changed(SPEC, {"links.shin.mass": np.float32(2), "links.shin.com": com})
    assert type(spec.links.shin.mass) is float
    assert spec.links.shin.com == (0.0, 0.01, -0.2)
    assert {type(value) for value in spec.links.shin.com} == {float}
    assert hash(spec) == hash(changed(SPEC, {"links.shin.mass": 2, "links.shin.com": list(com)}))


def test_negative_zero_becomes_zero() -> None:
    spec = changed(SPEC, {"geometry.l4": -0.0})
    assert repr(spec) == repr(SPEC)


def test_nothing_can_be_assigned() -> None:
    with pytest.raises(FrozenInstanceError):
        SPEC.geometry.d3 = 0.4  # type: ignore[misc]


REFUSED = [
    ("links.shin.mass", -1.0, r"links\.shin\.mass = -1 kg .*allowed: 0\.0001 to 10000 kg"),
    ("links.shin.mass", float("nan"), r"links\.shin\.mass = nan kg"),
    ("links.torso.mass", float("inf"), r"links\.torso\.mass = inf kg"),
    ("links.torso.mass", 10**400, r"links\.torso\.mass = inf kg"),
    ("geometry.d3", 0, r"geometry\.d3 = 0 m .*allowed: 0\.0001 to 10 m; check the value and its"),
    ("geometry.d3", 300.0, r"geometry\.d3 = 300 m is not allowed"),
    ("geometry.d3", "0.3", r"geometry\.d3 must be a number in m, got '0\.3'"),
    ("geometry.d3", True, r"geometry\.d3 must be a number in m, got True"),
    ("geometry.d3", None, r"geometry\.d3 must be a number in m, got None"),
    ("geometry.l1", 0.137, r"geometry\.l1 = 0\.137 m puts the ankle off the sole"),
    ("geometry.l1", -0.3, r"allowed: -0\.214 m .* to 0 m"),
    ("links.foot.size", (0.2, 0.1), r"links\.foot\.size must be a list of 3 numbers in m"),
    ("links.foot.size", 0.2, r"links\.foot\.size must be a list of 3 numbers"),
    ("links.foot.size", "abc", r"links\.foot\.size must be a list of 3 numbers"),
    ("links.foot.size", (0.2, -0.1, 0.04), r"links\.foot\.size\[1\] = -0\.1 m"),
    ("links.foot.com", {"x": 1}, r"links\.foot\.com must be a list of 3 numbers"),
    ("joints.knee.lower", 2.6, r"knee\.lower = 2\.6 rad is not below joints\.knee\.upper"),
    ("joints.knee.upper", 150.0, r"joints\.knee\.upper = 150 rad is not allowed"),
    ("joints.knee.torque", 0.0, r"joints\.knee\.torque = 0 N·m"),
    ("joints.knee.speed", -10.0, r"joints\.knee\.speed = -10 rad/s"),
    ("name", "", r"name = '' is not allowed; allowed: a letter"),
    ("name", '"><evil/>', "name = .* is not allowed"),
    ("name", 13, "name = '13' is not allowed"),
    ("geometry", 3, "geometry must be a table of named values, got 3"),
    ("geometry.d33", 0.3, r"unknown entry geometry\.d33; did you mean 'd3'\? allowed here: l1, d1"),
    ("link.shin.mass", 1.0, r"unknown entry link; did you mean 'links'\?"),
    ("geometry.d3.x", 1.0, r"geometry\.d3 must be a number in m, got \{'x': 1\.0\}"),
    ("links.shin.inertia", ((1, 0, 0), (0, 1, 0)), r"must be a list of 3 x 3 numbers in kg·m²"),
    ("links.shin.inertia", np.diag([1, 1, 2.5]), r"shin\.inertia cannot belong to a body"),
    ("links.shin.inertia", np.diag([1, -1, 1.5]), r"shin\.inertia is not positive definite"),
    ("links.shin.inertia", np.array([[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]), "is not symmetric"),
    ("links.shin.inertia", np.ones((3, 3)) + 0.1 * np.eye(3), "cannot belong to a body"),
]


@pytest.mark.parametrize(("path", "value", "message"), REFUSED)
def test_refusals_name_field_value_and_range(path: str, value: object, message: str) -> None:
    with pytest.raises(SpecError, match=message):
        changed(SPEC, {path: value})


@pytest.mark.parametrize("part", ["geometry", "links", "joints"])
def test_parts_of_the_wrong_class_are_refused(part: str) -> None:
    with pytest.raises(SpecError, match=f"{part} must be a "):
        replace(SPEC, **{part: None})
    with pytest.raises(SpecError, match=r"links\.shin must be a LinkSpec"):
        BipedSpec(SPEC.name, SPEC.geometry, replace(SPEC.links, shin=SPEC.joints.knee), SPEC.joints)  # type: ignore[arg-type]


def test_conflicting_paths_are_refused() -> None:
    with pytest.raises(SpecError, match="must be a table"):
        changed(SPEC, {"geometry": 1.0, "geometry.d3": 0.3})


def test_drawing_accuracy_is_accepted_and_made_symmetric() -> None:
    # A thin plate lies on the triangle inequality; its entries come rounded from a drawing.
    entry, noise = 0.1, 1e-12
    plate = ((1.0, entry, 0.0), (entry + noise, 2.0, 0.0), (0.0, 0.0, 3.0))
    kept = changed(SPEC, {"links.torso.inertia": plate}).links.torso.com_inertia
    assert kept[0][1] == kept[1][0] == pytest.approx(entry, abs=noise)
    assert checked_inertia(kept, "again") == kept
