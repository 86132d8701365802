"""The database: whole whenever its writer ends, read by many, written by one."""

import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing

import pytest

from gaitopt.errors import GaitFileError, InputError
from gaitopt.sweep.database import DATABASE, Database, read_database


@pytest.fixture
def two(tmp_path):
    """A database of two points."""
    with Database(tmp_path) as database:
        database.write({}, {"format": 3})
        database.write({"speed=1": {"cost": 1.5}, "speed=1.1": {"cost": 2.5}})
    return tmp_path


def test_what_was_written_is_read(two):
    manifest, points = read_database(two)
    assert manifest == {"format": 3}
    assert points == {"speed=1": {"cost": 1.5}, "speed=1.1": {"cost": 2.5}}
    with Database(two) as database:
        database.write({"speed=1": {"cost": 1.25}})
    assert read_database(two)[1]["speed=1"] == {"cost": 1.25}
    assert read_database(two.parent / "nowhere") is None


def test_a_record_without_its_digest_does_not_count(two):
    with closing(sqlite3.connect(two / DATABASE)) as connection, connection:
        connection.execute(
            "UPDATE points SET record = replace(record, '1.5', '1.4') WHERE name = 'speed=1'"
        )
    assert read_database(two)[1] == {"speed=1": None, "speed=1.1": {"cost": 2.5}}
    with closing(sqlite3.connect(two / DATABASE)) as connection, connection:
        connection.execute("UPDATE manifest SET digest = ''")
    with pytest.raises(GaitFileError, match=r"the manifest of .* is damaged"):
        read_database(two)


def test_a_record_of_another_point_does_not_count(two):
    with closing(sqlite3.connect(two / DATABASE)) as connection, connection:
        connection.execute("DELETE FROM points WHERE name = 'speed=1.1'")
        connection.execute("UPDATE points SET name = 'speed=1.1'")
    assert read_database(two)[1] == {"speed=1.1": None}


def test_all_of_a_transaction_is_written_or_nothing(two):
    with Database(two) as database, pytest.raises(ValueError, match="JSON"):
        database.write({"speed=1": {"cost": 7.0}, "speed=1.1": {"cost": float("nan")}})
    assert read_database(two)[1]["speed=1"] == {"cost": 1.5}


def test_one_writer_at_a_time_and_readers_meanwhile(two):
    with Database(two) as database:
        with pytest.raises(InputError, match="in use by another sweep"):
            Database(two)
        database.write({"speed=1.2": {"cost": 3.5}})
        assert len(read_database(two)[1]) == 3
    with Database(two) as free:
        free.write({"speed=1.3": {"cost": 4.5}})
    assert len(read_database(two)[1]) == 4


def test_another_process_is_kept_out_too(two):
    code = (
        "import sys; from pathlib import Path; from gaitopt.sweep.database import Database\n"
        "try: Database(Path(sys.argv[1]))\nexcept Exception as error: print(error)"
    )
    command = [sys.executable, "-c", code, str(two)]
    with Database(two):
        held = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "in use by another sweep" in held.stdout
    free = subprocess.run(command, capture_output=True, text=True, check=True)
    assert free.stdout == ""


def test_a_transaction_that_a_killed_process_left_is_rolled_back(two, tmp_path):
    """A copy in the midst of a transaction is what kill -9 leaves behind."""
    other = tmp_path / "copy"
    with closing(sqlite3.connect(two / DATABASE, isolation_level=None)) as connection:
        connection.execute("PRAGMA cache_size = 1")  # pages go to the file before the end
        connection.execute("BEGIN IMMEDIATE")
        for k in range(400):
            connection.execute("INSERT INTO points VALUES (?, ?, '')", (f"p{k}", "x" * 4000))
        other.mkdir()
        for file in two.glob(f"{DATABASE}*"):
            shutil.copy(file, other)
        connection.execute("ROLLBACK")
    assert (other / f"{DATABASE}-journal").exists()
    assert read_database(other)[1] == {"speed=1": {"cost": 1.5}, "speed=1.1": {"cost": 2.5}}


@pytest.mark.parametrize("content", [b"", b"no database at all, but a text of some length" * 99])
def test_what_is_no_database(tmp_path, content):
    (tmp_path / DATABASE).write_bytes(content)
    if not content:  # killed before it had begun
        assert read_database(tmp_path) is None
        return
    with pytest.raises(GaitFileError, match=r"cannot read .*not a database; make the"):
        read_database(tmp_path)
    with pytest.raises(InputError, match=r"cannot write .*not a database"):
        Database(tmp_path)


@pytest.mark.parametrize("new", [True, False])
def test_a_writer_that_was_refused_leaves_no_new_file(two, tmp_path, monkeypatch, new):
    directory = tmp_path / "new" if new else two
    directory.mkdir(exist_ok=True)
    monkeypatch.setattr(
        "gaitopt.sweep.database._SCHEMA", "CREATE TABLE manifest ("
    )  # as on a full disk
    with pytest.raises(InputError, match="cannot write"):
        Database(directory)
    assert (directory / DATABASE).exists() is not new


def test_a_directory_in_place_of_the_file(tmp_path):
    (tmp_path / DATABASE).mkdir()
    with pytest.raises(GaitFileError, match="it is no file"):
        read_database(tmp_path)
