"""`gaitopt` as a process: closed pipes, full disks, signals, exit codes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from places import ROOT

from gaitopt import load_gait
from gaitopt.cli import results

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and descriptors are POSIX")

QUICK = ("--solver", "sqp", "--starts", "1", "--no-refine", "--no-figures", "--no-page")
SLOW = ("--solver", "trust-constr", "--starts", "1", "--no-refine", "--tolerance", "1e-14")
FULL = Path("/dev/full")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "gaitopt", *map(str, words)]


def begin(*words: object, **how) -> "subprocess.Popen[str]":
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command(*words), env=ENVIRONMENT, **{**options, **how})


def test_a_reader_that_leaves_loses_nothing(tmp_path):
    read, write = os.pipe()
    os.close(read)
    with begin("optimise", *QUICK, "-o", tmp_path, stdout=write, stderr=write) as process:
        os.close(write)
    assert process.returncode == 0
    assert load_gait(tmp_path / "gait.npz").speed == pytest.approx(1.0)
    assert (tmp_path / "summary.json").exists()


def test_closed_descriptors_do_no_harm(tmp_path):
    line = " ".join(command("optimise", *QUICK, "-o", tmp_path))
    found = subprocess.run(["sh", "-c", f"{line} >&- 2>&- <&-"], env=ENVIRONMENT, check=False)
    assert found.returncode == 0
    assert load_gait(tmp_path / "gait.npz").speed == pytest.approx(1.0)


@pytest.mark.skipif(not FULL.exists(), reason="there is no /dev/full")
def test_output_that_cannot_be_written_is_told(tmp_path):
    with FULL.open("w") as full, begin("optimise", *QUICK, "-o", tmp_path, stdout=full) as process:
        _, said = process.communicate()
    assert process.returncode == 2
    assert "error: cannot write the output: no space left on device" in said
    assert "Traceback" not in said
    assert load_gait(tmp_path / "gait.npz").speed == pytest.approx(1.0)
    with FULL.open("w") as full, begin("robots", stdout=full) as process:
        assert "no space left on device" in process.communicate()[1]
    assert process.returncode == 2


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_keeps_the_best_walk(designed, tmp_path, name):
    words = ("--start", designed / "gait.npz", "--samples", "61", *SLOW, "-o", tmp_path)
    with begin("optimise", *words, "--no-figures", "--no-page") as process:
        _await_line(process.stderr, "round 1")
        process.send_signal(getattr(signal, name))
        out, said = process.communicate(timeout=300)
    assert process.returncode == 130, said
    assert "stopping" in said
    assert "interrupted: this is the best gait so far" in said
    assert "walks at" in out
    assert load_gait(tmp_path / "gait.npz").cost > 3000.0


def test_a_signal_before_anything_walks(tmp_path):
    with begin("optimise", *SLOW, "--speed", "1.3", "-o", tmp_path / "out") as process:
        _await_line(process.stderr, "round 1")
        process.send_signal(signal.SIGTERM)
        out, said = process.communicate(timeout=300)
    assert process.returncode == 130, said
    assert "interrupted before there was a result; nothing was written" in said
    assert out == ""
    assert not (tmp_path / "out").exists()


def test_an_interrupt_of_code_that_was_a_text_keeps_the_exit_code(tmp_path):
    """As of imports that make dataclasses: Python would kill itself by SIGINT at its end."""
    (tmp_path / "interrupted.py").write_text(
        "from gaitopt.cli.process import exit_code_kept\n"
        "with exit_code_kept():\n"
        "    try:\n"
        "        exec('raise KeyboardInterrupt')\n"
        "    except KeyboardInterrupt:\n"
        "        raise SystemExit(130) from None\n"
    )
    ended = subprocess.run(
        [sys.executable, "-m", "interrupted"], cwd=tmp_path, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ended.returncode == 130


def test_a_signal_amid_imports_ends_it_at_once(designed, rng):
    """Each signal a seeded number of modules after the first own one."""
    words = [sys.executable, "-X", "importtime", "-m", "gaitopt", "check", designed / "gait.npz"]
    for name in ("SIGINT", "SIGTERM", "SIGHUP") * 2:
        with subprocess.Popen(
            [*map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        ) as process:  # fmt: skip
            _await_line(process.stderr, "gaitopt.cli")
            for _ in range(rng.integers(20, 300)):
                process.stderr.readline()
            process.send_signal(getattr(signal, name))
            out, said = process.communicate(timeout=300)
        assert process.returncode == 130, said
        assert "Traceback" not in said
        assert out == ""


def test_a_signal_after_the_answer_changes_no_exit_code(tmp_path):
    """It comes while Python takes the process down."""
    late = (
        "import atexit, os, signal, sys; from gaitopt.cli import main; "
        "again = lambda: [os.kill(os.getpid(), n) for n in (signal.SIGTERM, signal.SIGINT)]; "
        "class Last:\n    def __del__(self): again()\n"
    )
    late = late.replace("; class", "\nclass")
    for when in ("atexit.register(again)", "sys.last_of_all = Last()"):
        for words, code in ((["--version"], 0), (["check", tmp_path / "none.npz"], 2)):
            run = f"{late}{when}\nsys.argv = ['gaitopt', *sys.argv[1:]]\nmain()"
            done = subprocess.run(
                [sys.executable, "-c", run, *map(str, words)], capture_output=True, text=True,
                check=False, env={**os.environ, "PYTHONPATH": str(ROOT)},
            )  # fmt: skip
            assert done.returncode == code, done.stderr
            assert "Traceback" not in done.stderr


def test_a_signal_amid_text_that_is_run_changes_no_exit_code():
    """As where a module makes functions from text; Python then ends by the signal, though told."""
    run = (
        "import sys\nfrom gaitopt.cli import main, robots\n"
        "robots.list_robots = lambda *_: exec('raise KeyboardInterrupt')\n"
        "sys.argv = ['gaitopt', 'robots']\n"
        "try: main()\nexcept SystemExit as error: print(error.code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", run], env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, "130\n"), done.stderr


def _await_line(stream, text):
    for line in stream:
        if text in line:
            return
    raise AssertionError(f"no line with {text!r}")


def test_a_gait_that_cannot_be_written_is_kept_elsewhere(quick, tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.setattr(results.tempfile, "gettempdir", lambda: str(elsewhere))
    whole = results.save_gait

    def full(gait, path):
        if path.name == "gait.npz":
            raise OSError(28, "No space left on device")
        return whole(gait, path)

    monkeypatch.setattr(results, "save_gait", full)
    result = quick("-o", tmp_path / "out")
    assert result.exit_code == 2
    (kept,) = elsewhere.iterdir()
    assert f"it is kept in '{kept}'" in result.stderr
    assert "biped13 walks at" in result.stdout
    assert load_gait(kept).speed == pytest.approx(1.0)


def test_what_fails_after_the_gait_tells_what_is_there(quick, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(results, "write_record", full)
    result = quick("-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "there is: gait.npz\n" in result.stderr
    assert load_gait(tmp_path / "out" / "gait.npz").speed == pytest.approx(1.0)


def test_exit_codes(cli, quick, designed, tmp_path):
    """Those of docs/cli.md, one by one; 130 is above."""
    table = (ROOT / "docs" / "cli.md").read_text().split("## Exit codes")[1]
    said = {int(row.split("|")[1]) for row in table.splitlines() if row.startswith("| ") and
            row.split("|")[1].strip().isdigit()}  # fmt: skip
    assert said == {0, 1, 2, 3, 130}
    gait = designed / "gait.npz"
    assert cli("check", gait).exit_code == 0
    assert quick("--max-iterations", "1", "--start", gait, "--samples", "61").exit_code == 1
    assert cli("check", tmp_path / "absent.npz").exit_code == 2
    assert cli("optimise", "--bogus").exit_code == 2
    assert quick("--torque-limit", "20").exit_code == 3
    assert quick("--speed", "9").exit_code == 3
    assert cli("--version").exit_code == 0


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
def test_processes_end_with_the_command(designed):
    with begin("play", designed / "gait.npz", start_new_session=True) as process:
        _await_line(process.stdout, "walks at http://127.0.0.1:")
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=300)
    assert _alive_in_session(process.pid) == []
    with begin("optimise", *SLOW, "--starts", "4", start_new_session=True) as process:
        deadline = time.monotonic() + 300.0
        while len(_alive_in_session(process.pid)) < 3 and time.monotonic() < deadline:
            time.sleep(0.1)
        os.killpg(process.pid, signal.SIGTERM)
        time.sleep(0.3)
        os.killpg(process.pid, signal.SIGTERM)
        process.communicate(timeout=300)
    deadline = time.monotonic() + 300.0
    while _alive_in_session(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert _alive_in_session(process.pid) == []


BESIDE = """
from gaitopt.view import drawing_worker
drawing_worker.spare_cores = lambda: 1.0
from gaitopt.cli import main
main()
"""
"""Runs the command line as on a machine with a core for the second start."""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are not copied")
@pytest.mark.parametrize(
    ("numbers", "code"),
    [
        ((signal.SIGINT,), 130),
        ((signal.SIGTERM,), 130),
        ((signal.SIGINT, signal.SIGINT), 130),
        ((signal.SIGKILL,), -signal.SIGKILL),
    ],
)
@pytest.mark.parametrize("all_of_them", [True, False])
def test_a_second_start_ends_with_the_command(tmp_path, numbers, code, all_of_them):
    """Signals go to the command, or to all of its session as those of a terminal."""
    words = ["optimise", *SLOW, "--starts", "2", "-o", str(tmp_path / "out")]
    with subprocess.Popen(
        [sys.executable, "-c", BESIDE, *words], env=ENVIRONMENT, stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    ) as process:  # fmt: skip
        _await_line(process.stderr, "round 1")
        assert len(_alive_in_session(process.pid)) == 2
        for number in numbers:
            (os.killpg if all_of_them and code == 130 else os.kill)(process.pid, number)
            time.sleep(0.2)
        out, said = process.communicate(timeout=300)
    assert process.returncode == code, said
    assert "Traceback" not in said
    assert said.count("stopping") == (code == 130)
    assert out == ""
    deadline = time.monotonic() + 60.0
    while _alive_in_session(process.pid) and time.monotonic() < deadline:
        time.sleep(0.1)
    assert _alive_in_session(process.pid) == []
    assert not (tmp_path / "out").exists()


def _alive_in_session(session: int) -> list[int]:
    found = []
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = place.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            found.append(int(place.parent.name))
    return found


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("optimise", "--help-all"), 0),
        (("sweep", "--help"), 0),
        (("optimise", "--nonsense"), 2),
        (("compare", "--speed", "fast"), 2),
        (("inspect", "--help"), 0),
    ],
)
def test_helping_and_refusing_need_no_robot(words, code):
    """Pinocchio and SciPy take longer to import than all the rest."""
    run = (
        "import sys; from gaitopt.cli.app import app\n"
        "try: app(sys.argv[1:])\n"
        "finally: print({'pinocchio', 'coal', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", run, *words], capture_output=True, text=True, check=False
    )
    assert done.returncode == code, done.stderr
    assert done.stdout.splitlines()[-1] == "set()"


WIDTHS = ("0", "1", "-3", "\u00b2", "wide", "9" * 12, "9" * 5000)


@pytest.mark.parametrize("width", WIDTHS, ids=lambda text: text[:12])
def test_a_width_that_no_terminal_has_counts_as_none(width):
    widths = dict.fromkeys(("COLUMNS", "LINES", "TERMINAL_WIDTH"), width)
    found = subprocess.run(
        command("--help"), env=ENVIRONMENT | widths, capture_output=True, text=True, check=False,
        timeout=60,
    )  # fmt: skip
    assert (found.returncode, found.stderr) == (0, "")
    assert "Usage: gaitopt [OPTIONS] COMMAND [ARGS]..." in found.stdout
    assert len(found.stdout) < 20_000
