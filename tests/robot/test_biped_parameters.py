"""Parameters of a biped by words: what follows a length, and what does not."""

from __future__ import annotations

from dataclasses import astuple, replace

import numpy as np
import pytest
from places import DOCS

from gaitopt.catalogue.biped_spec import BipedSpec, biped13, box_inertia
from gaitopt.catalogue.parameters import (
    PARAMETERS,
    changed,
    merged,
    parameter_name,
    parameter_unit,
    read_spec,
)
from gaitopt.errors import SpecError

SPEC = biped13()


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_parameter_is_what_it_was_set_to(name: str) -> None:
    parameter = PARAMETERS[name]
    new = 1.13 * parameter.value(SPEC)
    longer = changed(SPEC, {name: new})
    assert parameter.value(longer) == pytest.approx(new, rel=1e-14)
    assert longer != SPEC
    back = changed(longer, {name: parameter.value(SPEC)})
    assert spec_numbers(back) == pytest.approx(spec_numbers(SPEC), rel=1e-12, abs=1e-15)
    if not name.endswith("mass"):
        assert longer.total_mass == SPEC.total_mass
    else:
        assert longer.geometry == SPEC.geometry


def spec_numbers(spec: BipedSpec) -> list[float]:
    parts = (spec.geometry, *spec.links.leg, spec.links.torso)
    return [x for part in parts for value in astuple(part) if value is not None
            for x in np.ravel(value)]  # fmt: skip


def test_boxes_and_centres_of_mass_follow_a_length() -> None:
    long = changed(SPEC, {"shin": 0.42})
    assert long.links.shin.size == pytest.approx((0.08, 0.08, 0.42))
    assert long.links.shin.com == pytest.approx((0.0, 0.0, -0.21))
    assert replace(long.links, shin=SPEC.links.shin) == SPEC.links
    wide = changed(SPEC, {"hip width": 0.2, "foot-width": 0.15})
    assert (wide.geometry.d7, wide.links.foot.size[1]) == (0.2, pytest.approx(0.15))
    feet = changed(SPEC, {"foot_length": 0.3})
    assert feet.geometry.l1 / SPEC.geometry.l1 == pytest.approx(0.3 / 0.214)
    assert feet.links.foot.com[0] / SPEC.links.foot.com[0] == pytest.approx(0.3 / 0.214)
    high = changed(SPEC, {"ankle_height": 0.125})
    bottom = high.links.foot.com[2] - high.links.foot.size[2] / 2.0
    assert bottom == pytest.approx(-0.125)
    assert changed(SPEC, {"leg": 0.72}).geometry.hip_height == pytest.approx(0.105 + 0.72)


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.int64])
def test_numbers_of_numpy_are_numbers(kind: type) -> None:
    for name in ("trunk mass", "links.torso.mass"):
        assert changed(SPEC, {name: kind(45)}) == changed(SPEC, {name: 45.0})


def test_a_given_inertia_follows_as_that_of_the_body_stretched() -> None:
    shin = SPEC.links.shin
    given = replace(shin, inertia=box_inertia(shin.mass, shin.size))
    spec = replace(SPEC, links=replace(SPEC.links, shin=given))
    found = changed(spec, {"shin": 0.42, "shin mass": 2.5}).links.shin
    np.testing.assert_allclose(found.inertia, box_inertia(2.5, (0.08, 0.08, 0.42)), rtol=1e-12)


def test_an_entry_of_the_table_stands_for_itself() -> None:
    plain = changed(SPEC, {"geometry.d3": 0.42})
    assert plain.links == SPEC.links
    both = changed(SPEC, {"links.shin.mass": 3.0, "shin": 0.42})
    assert (both.links.shin.mass, both.links.shin.size[2]) == (3.0, pytest.approx(0.42))


def test_units_and_names() -> None:
    assert parameter_name("Hip width") == parameter_name("hip-width") == "hip_width"
    assert parameter_name("hips") is None
    names = ("hip width", "mass", "joints.knee.torque", "links.shin", "name")
    assert [parameter_unit(n) for n in names] == ["m", "kg", "N·m", "", ""]
    for wrong in ("geometry.d3.x", "shinn"):
        with pytest.raises(SpecError, match=f"unknown entry {wrong}"):
            parameter_unit(wrong)
    assert changed(SPEC, {"shin": "42cm", "joints.knee.speed": "60rpm"}) == changed(
        SPEC, {"shin": 0.42, "joints.knee.speed": 2.0 * np.pi}
    )


def test_tables_that_undo_a_parameter_are_refused() -> None:
    written = {"shin": 0.42, "geometry": {"d3": 0.3}, "links": {"shin": {"size": [0.1, 0.1, 0.3]}}}
    with pytest.raises(SpecError, match=r"shin is 0\.42 m, but the tables make it 0\.3 m; take "
                       r"geometry\.d3, links\.shin\.size out of them"):  # fmt: skip
        merged(SPEC, written)
    with pytest.raises(SpecError, match=r"mass is 20 kg.*take links\.torso\.mass out"):
        changed(SPEC, {"mass": 20.0, "links.torso.mass": 12.0})
    own = changed(SPEC, {"shin": 0.42, "links.shin.com": (0.0, 0.0, -0.2)})
    assert own.links.shin.com == (0.0, 0.0, -0.2)  # the length is the one asked for
    assert changed(SPEC, {"leg": 0.7, "shin": 0.3}).geometry.d3 == 0.3  # names go in order


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("42kg", "shin = '42kg' is wrong; give a number in m"),
        (-0.1, r"shin = -0.1 m is wrong; it must be above 0"),
        (np.nan, r"shin = nan m is wrong"),
        (300.0, r"geometry\.d3 = 300 m is not allowed"),
        (None, r"shin = 'None' is wrong; give a number in m"),
    ],
)
def test_what_is_no_length_is_refused(value: object, said: str) -> None:
    with pytest.raises(SpecError, match=said):
        changed(SPEC, {"shin": value})


def test_a_file_takes_words_and_units(tmp_path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(
        'shin = 0.42\n"hip width" = "20cm"\n[links.torso]\nmass = "45kg"\n'
        '[joints.knee]\nupper = "120deg"\ntorque = "90Nm"\n'
    )
    spec = read_spec(path)
    expected = {
        "shin": 0.42,
        "hip_width": 0.2,
        "links.torso.mass": 45.0,
        "joints.knee.torque": 90.0,
    }
    assert replace(spec, joints=SPEC.joints) == replace(changed(SPEC, expected), joints=SPEC.joints)
    assert spec.joints.knee.upper == pytest.approx(np.radians(120.0))


def test_the_documentation_names_every_parameter() -> None:
    said = (DOCS / "cli.md").read_text(encoding="utf-8")
    assert [name for name in PARAMETERS if f"`{name}`" not in said] == []
