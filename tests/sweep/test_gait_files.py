"""Gait files of a library that went missing, were damaged, or lie under another's name."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from sweeps import QUICK, SPEEDS, Counting, forget_digests, quick_task

from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.sweep import database
from gaitopt.sweep.database import DATABASE, LOCK, digest
from gaitopt.sweep.executor import FINISH
from gaitopt.sweep.library import (
    ALTERED,
    DAMAGED,
    MISFILED,
    MISSING,
    UNVOUCHED,
    Writer,
    file_fault,
    open_library,
)
from gaitopt.sweep.scheduler import sweep
from gaitopt.sweep.table import CERTIFIED, NOT_CERTIFIED

NAMES = ("speed=0.95", "speed=1", "speed=1.05", "speed=1.1")


@pytest.fixture
def broken(swept, tmp_path):
    """A library with a missing, a truncated and a misplaced file; the last one is whole."""
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    missing, torn, other, whole = (directory / "gaits" / f"{name}.npz" for name in NAMES)
    missing.unlink()
    torn.write_bytes(torn.read_bytes()[:-100])
    shutil.copy(whole, other)
    return directory


def told(library):
    """Return what was wrong with gaits when the last sweep began."""
    return {point: state.fault for point, state in sorted(library.states.items()) if state.fault}


def alter(file):
    """Make of a gait file another that loads, of the same point."""
    gait = load_gait(file)
    save_gait(replace(gait, q=np.full_like(gait.q, 9.0)), file)


@pytest.mark.parametrize("vouched", [True, False])
def test_unusable_files_are_told_and_only_they_are_made_anew(robot, swept, broken, vouched):
    if not vouched:
        forget_digests(broken)
    library = open_library(broken)
    told = [row["status"] for row in library.rows]
    assert told[:3] == [MISSING, DAMAGED, MISFILED]
    assert told[3] in ((CERTIFIED, NOT_CERTIFIED) if vouched else (UNVOUCHED,))
    assert not any(row["certified"] for row in library.rows[: 3 if vouched else 4])
    with Counting() as jobs:
        whole = sweep(robot, quick_task(), [SPEEDS], broken, QUICK)
    anew = range(3 if vouched else 4)
    assert [(job.kind, job.point) for job in jobs.done] == [(FINISH, (i,)) for i in anew]
    assert whole.faults == {}
    for point in swept.grid.order:
        np.testing.assert_array_equal(whole.gait(point).q, swept.gait(point).q)
    assert [row["status"] for row in whole.rows] == [row["status"] for row in swept.rows]


def test_a_gait_of_another_point_is_not_given_out(broken):
    library = open_library(broken)
    with pytest.raises(GaitFileError, match=r"speed=1\.05\.npz' holds the gait of speed=1\.1, not"):
        library.gait((2,))
    with pytest.raises(GaitFileError, match="no such file; give the command of the sweep again"):
        library.gait((0,))
    assert library.gait((3,)).fact("sweep", "values") == {"speed": 1.1}


def test_a_file_that_is_not_what_was_written_is_faulty(swept):
    file = swept.directory / "gaits" / "speed=1.npz"
    assert file_fault(file, {"speed": 1.0}, "another digest") == ALTERED
    assert file_fault(file, {"speed": 1.0}, "") == UNVOUCHED
    assert file_fault(file, {"speed": 1.1}, "another digest") == MISFILED
    written = digest(file.read_bytes())
    assert file_fault(file, {"speed": 1.1}, written) == ""  # not looked into


def test_an_altered_gait_is_told_not_given_out_and_made_anew(robot, swept, tmp_path):
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    alter(directory / "gaits" / "speed=1.npz")
    library = open_library(directory)
    assert library.faults == {(1,): ALTERED}
    assert (library.rows[1]["status"], library.rows[1]["certified"]) == (ALTERED, False)
    with pytest.raises(
        GaitFileError, match=r"speed=1\.npz' was altered since .*; give the command"
    ):
        library.gait((1,))
    with Counting() as jobs:
        whole = sweep(robot, quick_task(), [SPEEDS], directory, QUICK)
    assert [(job.kind, job.point) for job in jobs.done] == [(FINISH, (1,))]
    assert whole.faults == {}
    assert told(whole) == {(1,): ALTERED}
    np.testing.assert_array_equal(whole.gait((1,)).q, swept.gait((1,)).q)


def test_gaits_that_the_journal_does_not_vouch_for_do_not_count(robot, swept, tmp_path):
    """A file that loads and is of its point may still not be what the sweep wrote."""
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    forget_digests(directory)
    library = open_library(directory)
    assert library.faults == dict.fromkeys(swept.grid.order, UNVOUCHED)
    assert not any(row["certified"] for row in library.rows)
    with pytest.raises(
        GaitFileError, match=r"does not vouch for '.*speed=1\.npz': no digest; give"
    ):
        library.gait((1,))
    with Writer(directory, swept.grid, swept.record) as writer:
        assert not any(map(writer.has_gait, writer.states))
        assert all(state.walk is not None for state in writer.states.values())
    with Counting() as jobs:
        whole = sweep(robot, quick_task(), [SPEEDS], directory, QUICK)
    assert {job.kind for job in jobs.done} == {FINISH}
    assert whole.faults == {}


def test_faults_are_of_the_last_sweep_only(swept, broken):
    wrong = {(0,): MISSING, (1,): DAMAGED, (2,): MISFILED}
    with Writer(broken, swept.grid, swept.record) as writer:
        assert told(writer) == wrong
    assert told(open_library(broken)) == wrong
    for name in NAMES[:3]:
        shutil.copy(swept.directory / "gaits" / f"{name}.npz", broken / "gaits")
    with Writer(broken, swept.grid, swept.record) as writer:
        assert all(map(writer.has_gait, writer.states))
    assert told(open_library(broken)) == {}


def test_a_library_that_cannot_be_begun_is_not_left_locked(swept, tmp_path):
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    shutil.rmtree(directory / "gaits")
    (directory / "gaits").write_text("x")
    with pytest.raises(InputError, match=r"cannot make .*gaits"):
        Writer(directory, swept.grid, swept.record)
    (directory / "gaits").unlink()
    (directory / LOCK).unlink()
    before = sorted(directory.iterdir())
    with pytest.raises(InputError, match="holds another sweep"):
        Writer(directory, swept.grid, {**swept.record, "options": {}})
    assert sorted(directory.iterdir()) == before
    with Writer(directory, swept.grid, swept.record) as writer:
        assert list(told(writer).values()) == 4 * [MISSING]


def test_what_another_sweep_wrote_while_one_waited_for_the_lock_stays(swept, tmp_path, monkeypatch):
    lock = database._lock

    def lock_at_last(directory):
        shutil.copy(swept.directory / DATABASE, directory)
        return lock(directory)

    monkeypatch.setattr(database, "_lock", lock_at_last)
    with pytest.raises(InputError, match="holds another sweep"):
        Writer(tmp_path / "lib", swept.grid, {**swept.record, "options": {}})
    assert (tmp_path / "lib" / DATABASE).read_bytes() == (swept.directory / DATABASE).read_bytes()
