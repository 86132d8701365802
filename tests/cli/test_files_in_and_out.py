"""Files that are read are kept; pipes and devices are read to their end, and never replaced."""

import itertools
import os
import shutil
import threading
import time
from pathlib import Path

import pytest
import typer.main
from places import EXAMPLES
from sample_gait import sample_gait

from gaitopt import bounds
from gaitopt.atomic import write_atomically
from gaitopt.bounds import read_bounded
from gaitopt.cli import command_options
from gaitopt.cli.app import app
from gaitopt.cli.results import keep_files, require_files
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import save_gait
from gaitopt.settings import FILE, FILES, declared
from gaitopt.sweep.library import DAMAGED, file_fault

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
COMMANDS = typer.main.get_command(app).commands


def settings_of(name):
    """Settings of all options of a command that are files."""
    own = getattr(command_options, f"{name.capitalize()}Options", None)
    command = COMMANDS[name].complete([])
    known = [*command.settings.values(), *(() if own is None else declared(own))]
    return [one for one in known if one.kind in (FILE, FILES)]


def words_for(name, values):
    """Words of a command that give files to some of its options, and to those that it needs."""
    words, values = [name], {one.name: path for one, path in values}
    for one in settings_of(name):
        path = values.get(one.name, "needed" if one.required else None)
        if path is not None:
            words += [str(path)] if one.argument else [one.option, str(path)]
    return words


PAIRS = [
    (name, target, source)
    for name in COMMANDS
    if name not in ("optimize", "robots")
    for target, source in itertools.product(settings_of(name), settings_of(name))
    if target.written and not source.written
]


@pytest.mark.parametrize(
    ("name", "target", "source"), PAIRS, ids=[f"{n}-{a.name}-{b.name}" for n, a, b in PAIRS]
)
def test_no_command_writes_what_it_reads(cli, tmp_path, monkeypatch, name, target, source):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / f"file{(*target.suffixes, '')[0]}"
    file.write_text("kept")
    other = tmp_path / "folder" / ".." / file.name  # the same by another name
    (tmp_path / "folder").mkdir()
    result = cli(*words_for(name, [(target, file), (source, other)]))
    assert result.exit_code == 2
    assert file.read_text() == "kept"
    if source.name != "plugin":  # which is read first, for the options that it brings
        assert f"{target.option} {file}: it is " in result.stderr
        assert "which is kept as it is; give another name to write" in result.stderr


@pytest.mark.parametrize(
    ("name", "target", "source"), PAIRS, ids=[f"{n}-{a.name}-{b.name}" for n, a, b in PAIRS]
)
def test_nothing_is_written_where_what_is_read_is_missing_or_no_such_file(
    cli, tmp_path, monkeypatch, name, target, source
):
    monkeypatch.chdir(tmp_path)
    save_gait(sample_gait(), "needed")
    Path("junk").write_bytes(b"\xff junk \x00")
    new = f"new{(*target.suffixes, '.csv')[0]}"
    for given in ("missing", "junk"):
        result = cli(*words_for(name, [(target, new), (source, given)]))
        assert result.exit_code == 2
        assert f"wrote {new}" not in result.stdout
        assert {path.name for path in tmp_path.iterdir()} == {"needed", "junk"}


EVERY = [(n, one) for n in COMMANDS if n not in ("optimize", "robots") for one in settings_of(n)]


@pytest.mark.parametrize(("name", "one"), EVERY, ids=[f"{n}-{one.name}" for n, one in EVERY])
def test_names_that_no_file_can_have_are_told(cli, tmp_path, monkeypatch, name, one):
    monkeypatch.chdir(tmp_path)
    save_gait(sample_gait(), "needed")
    Path("loop").symlink_to("loop")
    for odd in (300 * "a", "loop"):
        result = cli(*words_for(name, [(one, odd)]))
        assert result.exit_code == 2
        assert "Errno" not in result.stderr


@pytest.mark.parametrize(
    ("words", "name", "earlier"),
    [
        (("optimise",), "task.toml", "gait.npz"),
        (("optimise", "--robot", "paper"), "robot.urdf", "gait.npz"),
        (("codesign", "--vary", "shin=25cm:35cm"), "spec.toml", "trials.jsonl"),
        (("size", "--catalogue", "catalogue.toml"), "motors.toml", "1.npz"),
        (("size", "--catalogue", "catalogue.toml"), "1.npz", "motors.toml"),
    ],
)
def test_files_of_the_user_are_not_replaced_by_results(
    cli, tmp_path, monkeypatch, words, name, earlier
):
    monkeypatch.chdir(tmp_path)
    if words[0] == "size":
        save_gait(sample_gait(), "gait.npz")
        shutil.copy(EXAMPLES / "catalogue.toml", "catalogue.toml")
        words = (*words, "gait.npz")
    before = "of the user"
    Path(name).write_text(before)
    refused = cli(*words, "-o", ".")
    assert refused.exit_code == 2
    assert f"a result would replace '{name}', which no earlier run wrote" in refused.stderr
    assert "give another directory, or move the file" in refused.stderr
    assert Path(name).read_text() == before
    keep_files(tmp_path / "new", (earlier, name), ())
    Path(earlier).touch()
    keep_files(tmp_path, (earlier, name), ())
    with pytest.raises(InputError, match=f"would replace '.*{name}', which is read"):
        keep_files(
            tmp_path,
            (earlier, name),
            (None, 1.0, Path("none"), tmp_path / ".." / tmp_path.name / name),
        )


def test_every_file_that_is_written_is_known_as_such():
    pairs = {(name, target.name) for name, target, _ in PAIRS}
    assert len(PAIRS) > 40
    assert {("inspect", "write_choices"), ("urdf", "output"), ("play", "html")} <= pairs
    assert {("requirements", "figure"), ("simulate", "page"), ("sweep", "output")} <= pairs


def test_pipes_and_devices_are_never_replaced(tmp_path):
    pipe = tmp_path / "pipe.html"
    os.mkfifo(pipe)
    link = tmp_path / "link.html"
    link.symlink_to(pipe)
    for path in (pipe, link, os.devnull):
        with pytest.raises(InputError, match=r"cannot write .*: it is a device or a pipe; give"):
            write_atomically(path, b"data")
    with pytest.raises(InputError, match=r"--html .*pipe\.html: .* it is a device or a pipe"):
        require_files((pipe, "--html"))
    assert pipe.is_fifo()


def test_a_link_into_nowhere_is_told_before_any_work(tmp_path):
    link = tmp_path / "link.csv"
    link.symlink_to("nowhere/table.csv")
    with pytest.raises(InputError, match=r"there is no directory '.*nowhere'"):
        require_files((link, "--output"))


READ = [
    (name, one)
    for name in ("optimise", "sweep", "inspect", "play", "requirements", "sensitivity")
    for one in settings_of(name)
    if not one.written and one.name not in ("package_dir", "against")
    if name == "optimise" or one.name != "plugin"
]


@pytest.mark.parametrize(("name", "one"), READ, ids=[f"{n}-{one.name}" for n, one in READ])
def test_a_pipe_without_a_writer_is_refused(cli, tmp_path, monkeypatch, name, one):
    monkeypatch.setattr(bounds, "SILENCE", 0.05)
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    begin = time.monotonic()
    words = words_for(name, [(one, tmp_path / "pipe")])
    more = ["--speeds", "1"] if name == "sweep" else []
    result = cli(*words, *more, *(["--posture", "x"] if one.name == "srdf" else []))
    assert result.exit_code == 2
    assert "pipe" in result.stderr
    assert time.monotonic() - begin < 10.0


def test_a_pipe_in_a_library_is_a_damaged_gait(tmp_path):
    os.mkfifo(tmp_path / "speed=1.npz")
    assert file_fault(tmp_path / "speed=1.npz", {"speed": 1.0}, "0" * 32) == DAMAGED


def test_pipes_are_read_to_their_end(tmp_path, rng):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    for pauses in ([0.0], [0.1, 0.0], [0.05, 0.1, 0.0, 0.02]):
        parts = [rng.bytes(int(rng.integers(1, 200_000))) for _ in pauses]

        def write(parts=parts, pauses=pauses):
            time.sleep(pauses[0])
            with path.open("wb", buffering=0) as stream:
                for part, pause in zip(parts, pauses, strict=True):
                    time.sleep(pause)
                    stream.write(part)

        writer = threading.Thread(target=write)
        writer.start()
        assert read_bounded(path, 10**6) == b"".join(parts)
        writer.join()


def test_a_pipe_whose_writer_has_gone_still_has_what_it_wrote(monkeypatch):
    monkeypatch.setattr(bounds, "SILENCE", 0.05)
    read, write = os.pipe()
    os.write(write, b"left behind")
    os.close(write)
    path = Path(f"/dev/fd/{read}")
    if not path.exists():
        pytest.skip("there is no /dev/fd")
    assert read_bounded(path, 100) == b"left behind"
    os.close(read)
