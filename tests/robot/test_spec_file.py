"""TOML files: what is written reads back equal, and what cannot be read says why."""

import os
import stat
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from robot.strategies import biped_specs

from gaitopt.catalogue.biped_spec import BipedSpec, biped13
from gaitopt.catalogue.parameters import changed, read_spec, spec_text, write_spec
from gaitopt.errors import InputError, SpecError


@given(biped_specs())
@settings(
    derandomize=True,
    deadline=None,
    max_examples=40,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_round_trip_is_exact(tmp_path: Path, spec: BipedSpec) -> None:
    path = tmp_path / "biped.toml"
    write_spec(spec, path)
    assert read_spec(path) == spec
    assert path.read_text(encoding="utf-8") == spec_text(spec)


def test_partial_file_takes_the_rest_from_the_preset(tmp_path: Path) -> None:
    path = tmp_path / "taller.toml"
    path.write_text("[geometry]\nd3 = 0.35\n\n[links.torso]\nmass = 45\n", encoding="utf-8")
    expected = changed(biped13(), {"geometry.d3": 0.35, "links.torso.mass": 45.0})
    assert read_spec(path) == expected
    assert read_spec(str(path)).total_mass == pytest.approx(biped13().total_mass + 4.45)


def test_every_value_is_written_with_its_unit() -> None:
    text = spec_text(changed(biped13(), {"links.shin.inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}))
    assert "d3 = 0.3  # m\n" in text
    assert "inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]  # kg·m²\n" in text
    values = [line for line in text.splitlines() if " = " in line and not line.startswith("name")]
    assert len(values) == 8 + 7 * 3 + 1 + 6 * 4
    assert all("  # " in line for line in values)


REFUSED = [
    (" \n", "the file is empty"),
    ("[geometry\n", "not TOML"),
    ("name = 'a'\nname = 'b'\n", "not TOML"),
    ("[geometri]\nd3 = 0.3\n", "unknown entry geometri; did you mean 'geometry'"),
    ("[links.shn]\nmass = 1\n", r"unknown entry links\.shn; did you mean 'shin'"),
    ("[links.shin]\nweight = 1\n", "unknown entry .*; allowed here: mass, size, com, inertia"),
    ("[links.shin]\nmass = nan\n", r"links\.shin\.mass = nan kg is not allowed"),
    ("[links.shin]\nmass = 'heavy'\n", r"links\.shin\.mass must be a number in kg, got 'heavy'"),
    ("[links.shin]\nmass = 2026-01-01\n", r"links\.shin\.mass must be a number in kg"),
    ("[[links]]\nmass = 1\n", "links must be a table"),
    ("[joints.knee]\nlower = 3.0\n", r"joints\.knee\.lower = 3 rad is not below"),
    ("a = " + "[" * 5000, "not TOML"),
    ("x = 1" + "0" * 5000, "not TOML|unknown entry"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_bad_files_are_refused_by_name(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=message) as caught:
        read_spec(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read_are_refused(tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b"name = 'caf\xe9'")
    with pytest.raises(SpecError, match=r"cannot read .*none\.toml': no such file"):
        read_spec(tmp_path / "none.toml")
    with pytest.raises(SpecError, match=r"cannot read .*directory"):
        read_spec(tmp_path)
    with pytest.raises(SpecError, match=r"latin\.toml': it is not UTF-8 text"):
        read_spec(tmp_path / "latin.toml")


def test_a_byte_order_mark_is_no_damage(tmp_path: Path) -> None:
    (tmp_path / "marked.toml").write_bytes(b'\xef\xbb\xbfname = "marked"')
    assert read_spec(tmp_path / "marked.toml").name == "marked"


def test_writing_replaces_all_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "biped.toml"
    write_spec(biped13(), path)
    before = path.read_bytes()

    def full_disk(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full_disk)
    with pytest.raises(InputError, match=r"cannot write .*no space left.*give a file"):
        write_spec(changed(biped13(), {"name": "other"}), path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["biped.toml"]


def test_writing_to_a_missing_directory_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*no such file"):
        write_spec(biped13(), tmp_path / "none" / "biped.toml")
    with pytest.raises(InputError, match="cannot write"):
        write_spec(biped13(), tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="file modes are POSIX")
def test_written_file_is_as_readable_as_any_other(tmp_path: Path) -> None:
    plain, written = tmp_path / "plain", tmp_path / "biped.toml"
    plain.touch()
    write_spec(biped13(), written)
    assert stat.S_IMODE(written.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
