"""`gaitopt optimise --starts`: several first guesses, one report, the best walk."""

from __future__ import annotations

import inspect
import json
import os
import re
import signal
import sys
import threading
from multiprocessing import active_children
from pathlib import Path
from types import SimpleNamespace

import pytest
from places import DOCS
from typer.testing import CliRunner

from gaitopt.cli import optimise as optimise_command
from gaitopt.cli.app import app
from gaitopt.cli.config import SCHEMA
from gaitopt.cli.request import make_request
from gaitopt.design.starts import many_starts
from gaitopt.gait.gait_file import load_gait

copied = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="processes are not copied")
QUICK = ["--no-refine", "--no-figures", "--no-page", "--solver", "sqp"]


def test_several_starts_report_their_optima(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, ["optimise", "--starts", "2", "--output", str(tmp_path), *QUICK]
    )
    assert result.exit_code == 0
    assert "2 of 2 starts led to a walk" in result.output
    assert "optimum 1 of cost 3239.0" in result.output
    assert "optimum 2 of cost 3351.2" in result.output
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert "3239.0" in json.dumps(summary)


def test_the_noise_is_that_of_many_starts() -> None:
    usual = inspect.signature(many_starts).parameters["sigma"].default
    request = make_request({"robot": "biped13", "starts": 3}, None)
    assert request.noise == (usual, 0)
    assert SCHEMA["solver"]["sigma"].default == usual
    said = (DOCS / "cli.md").read_text(encoding="utf-8")
    assert f"of standard deviation {usual:g} rad" in said


def test_ctrl_c_writes_the_best_start_so_far(tmp_path: Path, monkeypatch) -> None:
    search = optimise_command.many_starts

    def interrupted(*args, **options):
        def press(_) -> None:
            os.kill(os.getpid(), signal.SIGINT)

        return search(*args, **{**options, "workers": 1, "on_outcome": press})

    monkeypatch.setattr(optimise_command, "many_starts", interrupted)
    result = CliRunner().invoke(
        app, ["optimise", "--starts", "9", "--output", str(tmp_path), *QUICK]
    )
    assert result.exit_code == 130
    assert "1 of 1 starts led to a walk; 9 were asked for" in result.output
    assert "interrupted: this is the best gait so far" in result.output
    assert load_gait(tmp_path / "gait.npz").cost > 3000.0


def test_no_start_is_none() -> None:
    result = CliRunner().invoke(app, ["optimise", "--starts", "0"])
    assert result.exit_code == 2
    assert "0 starts are too few" in result.output


@pytest.fixture
def begun(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """Second starts that were begun beside the first, on a machine with a core for them."""
    begin, found = optimise_command.SecondStart, []

    def noted(*args, **options):
        found.append(begin(*args, **options))
        return found[-1]

    monkeypatch.setattr(optimise_command, "SecondStart", noted)
    monkeypatch.setattr(optimise_command, "spare_cores", lambda: 1.0)
    monkeypatch.setattr(threading, "active_count", lambda: 1)  # tests may be run by threads
    return found


def test_without_a_pipe_the_second_start_comes_after_the_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_pipe(*_: object, **__: object) -> None:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(optimise_command, "SecondStart", no_pipe)
    monkeypatch.setattr(optimise_command, "can_be_copied", lambda: True)
    monkeypatch.setattr(optimise_command, "spare_cores", lambda: 1.0)
    result = CliRunner().invoke(app, ["optimise", *QUICK, "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output


@copied
@pytest.mark.parametrize("words", [(), ("--quiet",), ("--starts", "3")])
def test_a_second_start_beside_the_first_shows_and_writes_the_same(
    words: tuple[str, ...], begun: list[object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = ["optimise", *QUICK, *words, "--speed", "0.6", "--output"]
    beside = CliRunner().invoke(app, [*asked, str(tmp_path / "a")])
    assert len(begun) == 1
    monkeypatch.setattr(optimise_command, "spare_cores", lambda: 0.9)
    alone = CliRunner().invoke(app, [*asked, str(tmp_path / "b")])
    assert len(begun) == 1
    assert beside.exit_code == alone.exit_code == 0
    written = [_facts(one.stdout.replace(str(tmp_path), "")) for one in (beside, alone)]
    assert [word.replace("/a:", "/b:") for word in written[0]] == written[1]
    assert _facts(beside.stderr) == _facts(alone.stderr)
    if not words:
        assert "3 rounds, " in beside.stderr
    gaits = [load_gait(tmp_path / name / "gait.npz") for name in "ab"]
    assert gaits[0].parameters.tobytes() == gaits[1].parameters.tobytes()


def _facts(said: str) -> list[str]:
    """Return the words of what was said, without times and the lines that depend on them."""
    lines = [line for line in said.splitlines() if not line.startswith("round ")]
    return re.sub(r"[\d.]+ s\b", "", "\n".join(lines)).split()


@pytest.mark.skipif(not hasattr(os, "sched_getaffinity"), reason="no such limit on this system")
def test_no_more_processes_than_processors_that_may_be_used(monkeypatch) -> None:
    request = SimpleNamespace(starts=8)
    for count in (1, 3):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, n=count: set(range(n)))
        assert optimise_command._workers(request) == count


@copied
@pytest.mark.parametrize(
    ("words", "threads", "count"),
    [
        ((), 1, 1),
        (("--starts", "3", "--robot", "g1"), 1, 1),
        ((), 2, 0),
        (("--starts", "1"), 1, 0),
        (("--seed", "2"), 1, 0),
        (("--starts", "4"), 1, 0),
        (("--fastest",), 1, 0),
        (("--double-support", "0.1", "--phase-times", "best"), 1, 0),
        (("--plugin", "own.py"), 1, 0),
    ],
)
def test_a_second_start_is_begun_where_it_is_sure_to_be_made_next(
    words, threads, count, begun, tmp_path, monkeypatch
) -> None:
    def interrupt(*_):
        raise KeyboardInterrupt

    own = (
        "from gaitopt import TorqueCost, WeightedSum\ncost = WeightedSum(((TorqueCost(), 2.0),))\n"
    )
    (tmp_path / "own.py").write_text(own, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(optimise_command, "processors", lambda: 2)
    monkeypatch.setattr(threading, "active_count", lambda: threads)
    monkeypatch.setattr(optimise_command, "_search", interrupt)
    monkeypatch.setattr("gaitopt.cli.optimise._fastest_walk", interrupt)
    result = CliRunner().invoke(app, ["optimise", *words])
    assert result.exit_code == 130, result.stderr
    assert len(begun) == count
    assert active_children() == []
