"""Gait files of a library that went missing, were damaged, or lie under another's name."""

import json
import shutil

import numpy as np
import pytest
from sweeps import QUICK, SPEEDS, Counting, quick_task

from gaitopt.errors import GaitFileError
from gaitopt.study.index import CERTIFIED, NOT_CERTIFIED
from gaitopt.study.jobs import FINISH
from gaitopt.study.library import open_library
from gaitopt.study.stored import DAMAGED, MISFILED, MISSING, digest, fault
from gaitopt.study.sweep import sweep

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


def forget_digests(directory):
    """Make a journal as it was before files had digests."""
    journal = directory / "journal.jsonl"
    entries = [json.loads(line) for line in journal.read_text().splitlines()]
    kept = [{k: v for k, v in entry.items() if k != "digest"} for entry in entries]
    journal.write_text("".join(json.dumps(entry) + "\n" for entry in kept))


@pytest.mark.parametrize("old", [False, True])
def test_unusable_files_are_told_and_only_they_are_made_anew(robot, swept, broken, old):
    if old:
        forget_digests(broken)
    library = open_library(broken)
    told = [row["status"] for row in library.rows]
    assert told[:3] == [MISSING, DAMAGED, MISFILED]
    assert told[3] in (CERTIFIED, NOT_CERTIFIED)
    assert not any(row["certified"] for row in library.rows[:3])
    crew = Counting()
    whole = sweep(robot, quick_task(), [SPEEDS], broken, QUICK, crew=crew)
    assert [(job.kind, job.point) for job in crew.done] == [(FINISH, (i,)) for i in range(3)]
    assert whole.faults == {}
    for point in swept.points.order:
        np.testing.assert_array_equal(whole.gait(point).q, swept.gait(point).q)
    assert [row["status"] for row in whole.rows] == [row["status"] for row in swept.rows]


def test_a_gait_of_another_point_is_not_given_out(broken):
    library = open_library(broken)
    with pytest.raises(GaitFileError, match=r"speed=1\.05\.npz' holds the gait of speed=1\.1, not"):
        library.gait((2,))
    with pytest.raises(GaitFileError, match="no such file; give the command of the sweep again"):
        library.gait((0,))
    assert library.gait((3,)).fact("sweep", "values") == {"speed": 1.1}


def test_a_file_that_was_saved_again_by_somebody_is_looked_into(swept):
    file = swept.directory / "gaits" / "speed=1.npz"
    assert fault(file, {"speed": 1.0}, "another digest") is None
    assert fault(file, {"speed": 1.1}, "another digest") == MISFILED
    assert fault(file, {"speed": 1.1}, digest(file)) is None  # as it was written: not looked into
