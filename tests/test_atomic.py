"""Files are written whole or not at all; what a killed process leaves is swept away."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from places import ROOT

from gaitopt.atomic import is_leftover, write_atomically
from gaitopt.errors import InputError

LEFT = ".0a1b2c3d4e5f.tmp"


def test_the_content_is_there_and_nothing_else(tmp_path):
    path = write_atomically(tmp_path / "a", b"one")
    write_atomically(path, b"two")
    assert path.read_bytes() == b"two"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(InputError, match="it is a directory"):
        write_atomically(tmp_path, b"three")


def test_leftovers_go_and_what_only_looks_like_them_stays(tmp_path):
    (tmp_path / LEFT).touch()
    others = {".0a1b2c3d4e5f.tmp.txt", "0a1b2c3d4e5f.tmp", ".abc.tmp", ".0A1B2C3D4E5F.tmp"}
    for name in others:
        (tmp_path / name).touch()
    (tmp_path / ".000000000000.tmp").mkdir()
    write_atomically(tmp_path / "a", b"one")
    assert {p.name for p in tmp_path.iterdir()} == {*others, "a", ".000000000000.tmp"}
    assert is_leftover(tmp_path / LEFT)


def test_what_another_process_writes_is_left_to_it(tmp_path):
    fcntl = pytest.importorskip("fcntl")
    with (tmp_path / LEFT).open("wb") as writing:
        fcntl.flock(writing, fcntl.LOCK_EX)
        write_atomically(tmp_path / "a", b"one")
        assert (tmp_path / LEFT).exists()
    write_atomically(tmp_path / "a", b"two")
    assert not (tmp_path / LEFT).exists()


def test_a_killed_write_leaves_what_the_next_sweeps_away(tmp_path):
    code = (
        "import os, signal, sys; from gaitopt import atomic; "
        "atomic.os.fsync = lambda _: os.kill(os.getpid(), signal.SIGKILL); "
        "atomic.write_atomically(sys.argv[1], b'x' * 100)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    killed = subprocess.run(
        [sys.executable, "-c", code, tmp_path / "a"], env=environment, check=False
    )
    assert killed.returncode == -signal.SIGKILL
    assert [is_leftover(p) for p in tmp_path.iterdir()] == [True]
    write_atomically(tmp_path / "b", b"one")
    assert [p.name for p in tmp_path.iterdir()] == ["b"]


def test_an_interrupt_at_the_opening_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(path, *how):
        open(path, *how).close()
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "open", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_atomically(tmp_path / "a", b"new")
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_leaves_nothing(tmp_path, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    (tmp_path / "a").write_bytes(b"old")
    monkeypatch.setattr("gaitopt.atomic.os.fsync", full)
    with pytest.raises(InputError, match="no space left on device; make room, or give"):
        write_atomically(tmp_path / "a", b"new")
    assert [p.name for p in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_bytes() == b"old"
