"""A library's gaits in one form, with a table of them; and the command."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml
from places import LIBRARY_0_1
from typer.testing import CliRunner

import gaitopt
from gaitopt.cli.app import app
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.motions.export import FORMATS


@pytest.fixture
def library(tmp_path):
    return Path(shutil.copytree(LIBRARY_0_1, tmp_path / "lib"))


def command(*words):
    return CliRunner().invoke(app, ["export", *map(str, words)])


def lines(index):
    with index.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_every_gait_is_written_and_listed(library, tmp_path):
    index = gaitopt.export_library(library, tmp_path / "out", format="mujoco", rate=50.0)
    found = lines(index)
    assert [row["file"] for row in found] == [
        "speed=0.95.npz", "speed=1.npz", "speed=1.05.npz",
    ]  # fmt: skip
    for row in found:
        with np.load(index.parent / row["file"]) as content:
            moved = np.ptp(content["qpos"][:, 0]) / content["time"][-1]
        gait = load_gait(library / "gaits" / row["file"])
        assert moved == pytest.approx(float(row["speed"]), rel=0.1)
        assert float(row["speed"]) == pytest.approx(gait.speed)
        assert row["file"] == f"speed={float(row['speed'])!r}.npz".replace(".0.npz", ".npz")
        assert float(row["duration"]) == pytest.approx(0.4)
        assert row["status"] == "not certified"


def test_gaits_that_cannot_be_used_are_listed_without_a_file(library, tmp_path):
    (library / "gaits" / "speed=1.npz").write_bytes(b"gone")
    index = gaitopt.export_library(library, tmp_path / "out", format="csv")
    assert [(row["file"], row["status"]) for row in lines(index)] == [
        ("speed=0.95.csv", "not certified"),
        ("", "file damaged"),
        ("speed=1.05.csv", "not certified"),
    ]
    for gait in (library / "gaits").iterdir():
        gait.unlink()
    with pytest.raises(InputError, match="has no gait that can be exported"):
        gaitopt.export_library(library, tmp_path / "none", format="csv")
    assert not (tmp_path / "none").exists()


def test_curves_are_numbered_by_speed(library, tmp_path):
    index = gaitopt.export_library(library, tmp_path / "out", format="bezier")
    speeds = []
    for k in (1, 2, 3):
        content = yaml.safe_load((tmp_path / "out" / f"v_{k}_1.yaml").read_text())
        speeds.append(content["vd_x"])
    assert speeds == pytest.approx([0.95, 1.0, 1.05])
    assert [row["file"] for row in lines(index)] == [f"v_{k}_1.yaml" for k in (1, 2, 3)]


@pytest.mark.parametrize("asked", [{"joints": "nosuch"}, {"rate": -1.0}, {"strides": 0.0}], ids=str)
def test_what_cannot_be_had_leaves_no_directory(library, tmp_path, asked):
    with pytest.raises(InputError):
        gaitopt.export_library(library, tmp_path / "none", format="motion", **asked)
    assert not (tmp_path / "none").exists()


def test_what_is_no_library_or_itself_is_refused(library, tmp_path):
    with pytest.raises(InputError, match="is the library itself"):
        gaitopt.export_library(library, library, format="csv")
    with pytest.raises(GaitFileError, match="is no gait library"):
        gaitopt.export_library(tmp_path, tmp_path / "out", format="csv")
    with pytest.raises(InputError, match="no format of motions"):
        gaitopt.export_library(library, tmp_path / "out", format="bvh")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the directory"):
        gaitopt.export_library(library, tmp_path / "file", format="csv")


@pytest.mark.parametrize("name", [name for name in FORMATS if name != "g1-csv"])
def test_the_command_writes_every_form_beside_the_gait(library, name):
    gait = library / "gaits" / "speed=1.npz"
    before = gait.read_bytes()
    result = command(gait, "--format", name)
    target = gait.with_name(f"speed=1-{name}{FORMATS[name].suffix}")
    assert (result.exit_code, result.stdout) == (0, f"wrote {target}\n")
    assert target.stat().st_size > 1000
    assert gait.read_bytes() == before


def test_the_command_takes_rate_strides_and_order(library, tmp_path):
    gait = library / "gaits" / "speed=1.npz"
    names = ",".join(reversed(load_gait(gait).joint_names))
    asked = ("--rate", "25", "--strides", "2.5", "--joints", names, "-o", tmp_path / "m.npz")
    assert command(gait, "--format", "motion", *asked).exit_code == 0
    with np.load(tmp_path / "m.npz") as content:
        assert content["joint_pos"].shape == (50, 12)
        assert ",".join(content["joint_names"]) == names


def test_the_command_writes_a_library(library):
    result = command(library, "--format", "json")
    folder = library.with_name("lib-json")
    assert result.exit_code == 0
    assert result.stdout == f"wrote 3 motions and index.csv in {folder}\n"
    assert len(list(folder.iterdir())) == 4


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["lib"], "Missing option '--output'"),
        (["lib", "-o", "x.csv"], "'lib' is a directory; name a --format"),
        (["lib", "--format", "csv", "--both-legs"], "--both-legs goes without --format"),
        (
            ["gait.npz", "--format", "motion", "-o", "gait.npz"],
            "--output gait.npz: it is the gait itself",
        ),
        (["gait.npz", "--format", "bvh"], "no format of motions is named 'bvh'"),
        (["gait.npz", "--format", "mjfc"], "did you mean 'mjcf'? choose motion, mujoco"),
        (["gait.npz", "--format", "motion", "--rate", "0"], "a motion has 0 Hz"),
        (["gait.npz", "-o", "x.csv", "--strides", "2"], "strides: only motions of a named format"),
        (["gait.npz", "--format", "g1-csv"], "'g1' has 'left_hip_pitch_joint'"),
    ],
)
def test_the_command_refuses(library, monkeypatch, words, message):
    monkeypatch.chdir(library.parent)
    shutil.copy(library / "gaits" / "speed=1.npz", "gait.npz")
    result = command(*words)
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())
    assert {path.name for path in Path().iterdir()} == {"lib", "gait.npz"}
