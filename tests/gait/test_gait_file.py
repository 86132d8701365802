import io
import json
import os
import stat
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sample_gait import bare_gait, sample_gait

from gaitopt.atomic import write_atomically
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.result import SHAPES, array_names


@pytest.fixture
def path(tmp_path):
    return save_gait(sample_gait(), tmp_path / "gait.npz")


def rewritten(path, **changes):
    """The file with some members replaced, or left out where the value is None."""
    with np.load(path) as content:
        members = {k: content[k] for k in content.files} | changes
    np.savez(path, **{k: v for k, v in members.items() if v is not None})
    return path


@pytest.mark.parametrize("gait", [sample_gait(), bare_gait()])
def test_a_gait_comes_back_as_it_was(gait, tmp_path):
    again = load_gait(save_gait(gait, tmp_path / "x.npz"))
    for name in array_names():
        assert np.array_equal(getattr(again, name), getattr(gait, name)), name
    for name in (
        "parameter_names", "joint_names", "urdf", "stance_sole", "swing_sole_frame", "meta"
    ):  # fmt: skip
        assert getattr(again, name) == getattr(gait, name), name


def test_numpy_alone_reads_the_file(path):
    with np.load(path, allow_pickle=False) as content:
        assert set(SHAPES) < set(content.files)
        assert content["torque"].shape == (31, 12)
        assert list(content["joint_names"])[2] == "right_knee"
        assert str(content["urdf"]).lstrip().startswith("<")
        assert json.loads(str(content["meta"]))["task"]["speed"] == 1.0


def test_equal_gaits_give_equal_bytes(path, tmp_path):
    other = save_gait(load_gait(path), tmp_path / "other.npz")
    assert other.read_bytes() == path.read_bytes()
    changed = save_gait(replace(sample_gait(), meta={"cost": 1.5}), tmp_path / "changed.npz")
    assert changed.read_bytes() != path.read_bytes()


def test_the_name_is_used_as_given_and_an_old_file_is_replaced(tmp_path):
    target = tmp_path / "walk.gait"
    target.write_text("old")
    save_gait(sample_gait(), target)
    assert os.listdir(tmp_path) == ["walk.gait"]  # and no temporary file is left
    assert load_gait(target).speed == pytest.approx(1.0)


def test_a_new_file_gets_the_permissions_of_the_umask(tmp_path):
    old = os.umask(0o027)
    try:
        path = write_atomically(tmp_path / "f", b"x")
    finally:
        os.umask(old)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    target = tmp_path / "f"
    target.write_bytes(b"old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no space left on device"):
        write_atomically(target, b"new")
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["f"]


@pytest.mark.parametrize("where", ["missing/gait.npz", ".", "x" * 300, "a\0b"])
def test_an_unwritable_path_is_refused(tmp_path, where):
    with pytest.raises(InputError, match="cannot write"):
        save_gait(sample_gait(), tmp_path / where)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "truncated, or not a gait file"),
        (b"hello", "truncated, or not a gait file"),
        (b"\x93NUMPY" + bytes(90), "truncated, or not a gait file"),
    ],
)
def test_a_foreign_file_is_refused(tmp_path, content, reason):
    path = tmp_path / "foreign.npz"
    path.write_bytes(content)
    with pytest.raises(GaitFileError, match=reason):
        load_gait(path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(GaitFileError, match="there is no such file"):
        load_gait(tmp_path / "nothing.npz")
    with pytest.raises(GaitFileError, match="there is no such file"):
        load_gait(tmp_path)


def test_another_zip_is_refused(tmp_path):
    path = tmp_path / "other.npz"
    np.savez(path, a=np.arange(3))
    with pytest.raises(GaitFileError, match="'time' is missing"):
        load_gait(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(GaitFileError, match="'time' is missing"):
        load_gait(path)


def test_pickled_content_is_refused(path):
    buffer = io.BytesIO()
    np.save(buffer, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("extra.npy", buffer.getvalue())
    with pytest.raises(GaitFileError, match="damaged, or not a gait file"):
        load_gait(path)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"torque": None}, "'torque' is missing"),
        ({"urdf": None}, "'urdf' is missing"),
        ({"meta": None}, "'meta' is missing"),
        ({"meta": np.array("{")}, "'meta' is not JSON"),
        ({"meta": np.array("[1]")}, "'meta' is not a JSON object"),
        ({"meta": np.array('{"format": 2}')}, "its format is 2, this gaitopt reads 1"),
        ({"q": np.full((31, 12), np.inf)}, "'q' holds NaN or infinity"),
        ({"cop": np.zeros((31, 3))}, "'cop' has shape"),
        ({"joint_names": np.arange(12)}, "'joint_names' must be different texts"),
        ({"parameters": np.array(["a"] * 43)}, "'parameters' is not an array of numbers"),
    ],
)
def test_a_file_that_holds_no_gait_is_refused(path, changes, reason):
    with pytest.raises(GaitFileError, match=reason) as caught:
        load_gait(rewritten(path, **changes))
    assert str(path) in str(caught.value)


@pytest.fixture(scope="module")
def content(tmp_path_factory):
    path = save_gait(sample_gait(), tmp_path_factory.mktemp("file") / "gait.npz")
    return path, path.read_bytes()


@settings(derandomize=True, deadline=None, max_examples=60)
@given(where=st.floats(0.0, 1.0), flip=st.integers(1, 255), cut=st.booleans())
def test_a_damaged_file_is_read_whole_or_refused(content, where, flip, cut):
    path, data = content
    place = int(where * (len(data) - 1))
    damaged = (
        data[:place] if cut else data[:place] + bytes([data[place] ^ flip]) + data[place + 1 :]
    )
    other = path.with_name("damaged.npz")
    other.write_bytes(damaged)
    try:
        gait = load_gait(other)
    except GaitFileError:
        return
    assert not cut
    # a flip that is not noticed hit the zip's own records, not a number
    assert np.array_equal(gait.torque, sample_gait().torque)
