import errno

import pytest

from gaitopt.errors import InputError
from gaitopt.sweep import library as journal_module
from gaitopt.sweep.library import Journal, read_journal


def test_what_is_appended_is_read_and_a_torn_line_is_not(tmp_path):
    with Journal(tmp_path) as journal:
        journal.append({"point": [3], "cost": 1.5})
        journal.append({"point": [4], "cost": 2.5})
    whole = journal.path.read_bytes()
    journal.path.write_bytes(whole[:-7])  # as kill -9 may leave it
    assert [e["point"] for e in read_journal(journal.path)] == [[3]]
    with Journal(tmp_path) as again:
        assert [e["cost"] for e in again.entries] == [1.5]
        again.append({"point": [5]})
    assert [e["point"] for e in read_journal(journal.path)] == [[3], [5]]


def test_damage_in_the_middle_is_told(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"point": [1]}\n{"po\n{"point": [2]}\n')
    with pytest.raises(InputError, match="line 2 of"):
        list(read_journal(path))


def test_one_writer_at_a_time(tmp_path):
    with Journal(tmp_path), pytest.raises(InputError, match="in use by another sweep"):
        Journal(tmp_path)
    with Journal(tmp_path) as free:
        free.append({"point": [7]})
    assert len(list(read_journal(free.path))) == 1


def test_what_another_writer_appended_before_the_lock_was_ours_is_kept(tmp_path, monkeypatch):
    with Journal(tmp_path) as first:
        first.append({"point": [1]})
    lock = journal_module._lock

    def lock_late(descriptor, path):
        with path.open("ab") as other:
            other.write(b'{"point": [2]}\n')
        lock(descriptor, path)

    monkeypatch.setattr(journal_module, "_lock", lock_late)
    with Journal(tmp_path) as late:
        assert [e["point"] for e in late.entries] == [[1], [2]]
    assert [e["point"] for e in read_journal(late.path)] == [[1], [2]]


def test_a_full_disk_leaves_the_journal_as_it_was(tmp_path, monkeypatch):
    with Journal(tmp_path) as journal:
        journal.append({"point": [1]})
        before = journal.path.read_bytes()

        class Full:
            def __init__(self, file):
                self.file = file

            def write(self, data):
                if len(data) > 6:
                    return self.file.write(data[:6])  # the last bytes that fit
                raise OSError(errno.ENOSPC, "No space left on device")

            def __getattr__(self, name):
                return getattr(self.file, name)

        monkeypatch.setattr(journal, "_file", Full(journal._file))
        with pytest.raises(InputError, match="no space left on device"):
            journal.append({"point": [2], "x": [0.5] * 9})
        assert journal.path.read_bytes() == before
