"""Sizes beyond their bounds are refused by their number, from every entrance, before any work."""

import io
import math
import shutil
import time
import tracemalloc
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from places import CASES

from gaitopt import bounds
from gaitopt.bounds import read_bounded, shown
from gaitopt.design.audit import audit
from gaitopt.design.starts import many_starts
from gaitopt.errors import GaitFileError, GaitoptError, InputError, RobotError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.presets import preset_task
from gaitopt.gait.task import Task, task_from_record, task_record
from gaitopt.importers.meshes import MeshPaths
from gaitopt.importers.reader import read_source
from gaitopt.importers.text_files import parse_toml
from gaitopt.sweep.executor import local_workers
from gaitopt.sweep.grid import Axis, TaskGrid, parse_axis
from gaitopt.view.page import page_text

MANY = 10**9 + 1


@pytest.fixture(autouse=True)
def at_once():
    """Whatever is refused takes no time."""
    began = time.process_time()
    yield
    assert time.process_time() - began < 5.0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--samples", MANY), "1000000001 samples are too many; give at most 1001"),
        (("--samples", 10**40), "more than 1e15 samples are too many"),
        (("--postures", 10**6), "1000000 postures are too many; give at most 20\n"),
        (("--postures", 40), "40 postures are too many; give at most 20\n"),
        (("--postures", 10, "--samples", 11), "10 postures are more than 11 samples can tell "
                                              "apart; give at most 9, or 13 samples\n"),
        (("--postures", 40, "--samples", 11), "give at most 9\n"),
        (("--starts", MANY), "1000000001 starts are too many; give at most 1000"),
    ],
)  # fmt: skip
def test_options(cli, words, said):
    result = cli("optimise", *words)
    assert result.exit_code == 2
    assert said in result.stderr


def test_advice_about_postures_holds():
    assert Task(postures=9, samples=11).postures == 9
    assert Task(postures=10, samples=13).postures == 10
    assert Task(postures=20).postures == 20


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"[task]\nsamples = {MANY}\n", "1000000001 samples are too many"),
        (f"[task]\npostures = {MANY}\n", "1000000001 postures are too many"),
        (f"[solver]\nstarts = {MANY}\n", "1000000001 starts are too many"),
        (f"[task]\nspeed = 1{'0' * 400}\n", "speed is inf m/s"),
        ("# " + "x" * 1_000_001, "larger than 1 million bytes"),
    ],
)
def test_configuration(cli, tmp_path, text, said):
    (tmp_path / "c.toml").write_text(text)
    result = cli("optimise", "--config", tmp_path / "c.toml")
    assert result.exit_code == 2
    assert said in result.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("--grid", "friction=0:1:1e-5", "--grid", "clearance=0:0.08:1e-4"),
        ("--speeds", "0.4:1.4:1e-8"),
        ("--speeds", "1", "--workers", MANY),
    ],
)
def test_sweep(cli, tmp_path, words):
    result = cli("sweep", "--output", tmp_path / "gaits", *words)
    assert result.exit_code == 2
    assert "too many; give at most" in result.stderr
    assert not (tmp_path / "gaits").exists()


def test_film(cli, designed, tmp_path):
    page = tmp_path / "out.html"
    result = cli("play", designed / "gait.npz", "--steps", MANY, "--html", page)
    assert result.exit_code == 2
    assert "1000000001 steps are too many; give at most 200" in result.stderr
    assert not page.exists()
    gait = load_gait(designed / "gait.npz")
    fine = np.linspace(0.0, gait.duration, 201)
    arrays = {n: np.repeat(getattr(gait, n)[:1], 201, axis=0) for n in
              ("q", "dq", "ddq", "torque", "ground_wrench", "cop", "swing_sole")}  # fmt: skip
    with pytest.raises(InputError, match="40200 frames are too many; give at most 20000; 99 steps"):
        page_text(replace(gait, time=fine, **arrays), 200)


def test_gait_of_a_billion_samples():
    gait = load_gait(CASES / "samples_1e9.npz")
    with pytest.raises(GaitFileError, match="1000000001 samples are too many"):
        audit(gait)


def test_gait_of_many_instants(designed):
    gait = load_gait(designed / "gait.npz")
    with pytest.raises(InputError, match="20001 instants in the gait's 'time' are too many"):
        replace(gait, time=np.linspace(0.0, 1.0, 20001))
    with pytest.raises(GaitFileError, match="20001 recorded instants are too many"):
        audit(replace(gait, meta={**gait.meta, "instants": [0.5] * 20001}))


def test_header_that_promises_more_than_the_file_holds(designed, tmp_path):
    path, lie = tmp_path / "gait.npz", io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": (10**12,)}
    np.lib.format.write_array_header_1_0(lie, header)
    with zipfile.ZipFile(designed / "gait.npz") as old, zipfile.ZipFile(path, "w") as new:
        for entry in old.infolist():
            new.writestr(entry, lie.getvalue() if entry.filename == "time.npy" else old.read(entry))
    with pytest.raises(GaitFileError, match="holds no array of the size in its header"):
        load_gait(path)


def test_python_entrances(robot):
    for build in (
        lambda: Task(samples=MANY),
        lambda: preset_task(postures=MANY),
        lambda: task_from_record({**task_record(Task()), "samples": MANY}),
        lambda: many_starts(robot, count=MANY),
        lambda: many_starts(robot, workers=MANY),
        lambda: Axis("speed", range(1, MANY)),
        lambda: Axis("speed", iter(range(1, MANY))),
        lambda: parse_axis("speed", "0:1:1e-9"),
        lambda: TaskGrid((Axis("speed", range(1, 10**4)), Axis("duration", range(1, 10**4)))),
        lambda: local_workers(MANY),
    ):
        with pytest.raises(InputError, match="too many"):
            build()


@pytest.mark.parametrize("number", [10**400, -(10**400), 10**5000], ids=["400", "-400", "5000"])
def test_numbers_of_hundreds_of_digits(number):
    for name in ("speed", "duration", "samples", "postures"):
        with pytest.raises(InputError, match=name):
            Task(**{name: number})
    assert "1e15" in shown(number)


def test_a_number_is_shown_with_as_many_digits_as_a_person_reads():
    assert [shown(value) for value in (1.5, 0.0, math.atan(4.0), 1e-300, math.nan)] == [
        "1.5", "0.0", "1.325817664", "1e-300", "nan",
    ]  # fmt: skip


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there is no /dev/zero")
def test_files_without_an_end_are_read_to_their_bound():
    with pytest.raises(RobotError, match="larger than 32 million bytes"):
        read_source(Path("/dev/zero"))


def test_large_files(tmp_path, monkeypatch, designed):
    path = tmp_path / "large"
    path.write_bytes(b"x" * 1000)
    assert read_bounded(path, 1000) == b"x" * 1000
    with pytest.raises(ValueError, match="larger than"):
        read_bounded(path, 999)
    monkeypatch.setattr("gaitopt.importers.meshes.MESH", 999)
    monkeypatch.setattr("gaitopt.gait.gait_file.GAIT", 9999)
    assert "larger than" in MeshPaths(tmp_path).problem("large")
    with pytest.raises(GaitFileError, match="larger than"):
        load_gait(shutil.copy(designed / "gait.npz", tmp_path))
    with pytest.raises(GaitoptError, match="at most 1 MB of TOML"):
        parse_toml("#" * 1_000_001, "here")
    assert bounds.TEXT < bounds.GAIT


def test_a_gait_survives_its_file(designed, tmp_path):
    gait = load_gait(designed / "gait.npz")
    save_gait(gait, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (designed / "gait.npz").read_bytes()


def test_a_small_file_takes_little_memory_however_large_its_bound(tmp_path):
    path = tmp_path / "small"
    path.write_bytes(b"x" * 10_000_000)
    tracemalloc.start()
    try:
        assert len(read_bounded(path, 10**12)) == 10_000_000
        assert tracemalloc.get_traced_memory()[1] < 40_000_000
    finally:
        tracemalloc.stop()
    with pytest.raises(ValueError, match="larger than 9 million"):
        read_bounded(path, 9_999_999)
