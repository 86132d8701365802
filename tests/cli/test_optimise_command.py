"""`gaitopt optimise`, end to end."""

import json
import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer

from gaitopt import load_gait
from gaitopt.cli import optimise as optimise_command
from gaitopt.cli import results
from gaitopt.cli.config import read_config
from gaitopt.cli.display import ProgressDisplay, screen
from gaitopt.cli.process import STOPPING, errors_reported, stop_on_interrupt
from gaitopt.cli.results import require_writable
from gaitopt.design import diagnosis
from gaitopt.errors import InputError
from gaitopt.nlp import Progress


def test_writes_the_whole_story(designed):
    names = {path.name for path in designed.iterdir()}
    assert names >= {"gait.npz", "gait.html", "figures", "summary.json", "task.toml", "robot.urdf"}
    assert {p.stem for p in (designed / "figures").glob("*.png")} >= {"step", "torques", "walk"}
    assert not list(designed.glob(".*"))  # no temporary file is left


def test_summary_is_that_of_the_gait(designed):
    summary = json.loads((designed / "summary.json").read_text())
    gait = load_gait(designed / "gait.npz")
    assert summary["walk"]["cost_N2ms"] == gait.cost
    assert summary["walk"]["speed_m_per_s"] == pytest.approx(1.0, abs=1e-12)
    assert summary["certificate"]["certified"] is True
    assert summary["robot"]["mass_kg"] == pytest.approx(56.87)


def test_table_says_what_a_roboticist_asks(designed):
    text = (designed / "stdout.txt").read_text()
    gait = load_gait(designed / "gait.npz")
    peak = np.abs(gait.torque).max()
    for word in ("biped13 walks at 1.000 m/s", "certified", "N²·m·s", "hip pitch", "ankle roll",
                 f"{peak:.1f}", "of 150", "ground 223.158 = weight 223.158 N·s"):  # fmt: skip
        assert word in text
    assert max(map(len, text.splitlines()[:-2])) <= 100  # the last line names the files


def test_recorded_task_reproduces_the_gait(designed, cli, tmp_path):
    again = tmp_path / "again"
    config = designed / "task.toml"
    result = cli("optimize", "--config", config, "-o", again, "--no-page", "--no-figures", "-q")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")
    first, second = load_gait(designed / "gait.npz"), load_gait(again / "gait.npz")
    assert np.array_equal(first.parameters, second.parameters)
    assert not (again / "gait.html").exists()


def test_command_line_wins_over_the_file(quick, tmp_path):
    config = tmp_path / "c.toml"
    config.write_text("[task]\nspeed = 0.5\nduration = 0.45\n[margins]\nfriction = 0.6\n")
    result = quick("--config", config, "--speed", "0.8", "-q", "-o", tmp_path / "out")
    assert result.exit_code == 0
    gait = load_gait(tmp_path / "out" / "gait.npz")
    assert gait.speed == pytest.approx(0.8)
    assert gait.duration == pytest.approx(0.45)
    assert gait.number("task", "margins", "friction") == 0.6


def test_starts_from_a_gait(quick, designed, tmp_path):
    result = quick("--start", designed / "gait.npz", "-o", tmp_path, "-q")
    assert result.exit_code == 0
    found, begun = load_gait(tmp_path / "gait.npz"), load_gait(designed / "gait.npz")
    assert found.number("solver", "iterations") == 0  # it is the optimum of this very walk
    assert begun.number("solver", "iterations") > 10
    assert found.cost == pytest.approx(begun.cost, rel=1e-9)
    assert read_config(tmp_path / "task.toml")["start"].resolve() == designed / "gait.npz"


def test_start_of_another_kind_is_refused(quick, designed):
    result = quick("--start", designed / "gait.npz", "--postures", "1")
    assert result.exit_code == 2
    assert "number of intermediate postures" in result.stderr


def test_seed_decides_the_first_guess(quick, tmp_path):
    found = []
    for run, seed in enumerate("112"):
        where = tmp_path / str(run)
        assert quick("--seed", seed, "--sigma", "0.02", "-q", "-o", where).exit_code == 0
        found.append(load_gait(where / "gait.npz").parameters)
    assert np.array_equal(found[0], found[1])
    assert not np.array_equal(found[0], found[2])


@pytest.mark.parametrize(
    ("words", "free"),
    [
        (("--preset", "paper"), 42),
        (("--free", "pelvis_roll"), 44),
        (("--fix", "pelvis_yaw=0.05"), 42),
        (("--postures", "1"), 31),
    ],
)
def test_parameters_asked_for(quick, tmp_path, words, free):
    assert quick(*words, "-q", "-o", tmp_path).exit_code == 0
    gait = load_gait(tmp_path / "gait.npz")
    assert len(gait.parameters) == free


def test_unrefined_gait_says_so(quick):
    result = quick()
    assert result.exit_code == 0
    assert "optimal at the given samples only" in result.stdout


def test_no_gait_found(quick, tmp_path):
    result = quick("--torque-limit", "20", "-o", tmp_path / "none")
    assert result.exit_code == 3
    assert "no feasible gait was found" in result.stderr
    assert "torque at" in result.stderr
    assert "allowed" in result.stderr
    assert not (tmp_path / "none" / "gait.npz").exists()  # suggestions are there, no gait


def test_step_longer_than_the_legs_is_no_gait(quick, tmp_path):
    result = quick("--speed", "5", "-o", tmp_path / "none")
    assert result.exit_code == 3
    assert "a step of 2.000 m" in result.stderr
    assert "longer than the legs can span: at most 1.164 m" in result.stderr
    assert not (tmp_path / "none" / "gait.npz").exists()


def test_interrupt_while_writing_tells_what_is_there(designed, quick, monkeypatch, tmp_path):
    def interrupted(*_):
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(results, "task_text", interrupted)
    result = quick("--start", designed / "gait.npz", "-o", tmp_path / "out")
    assert result.exit_code == 130
    there = ["gait.npz", "summary.json", "robot.urdf", "choices.toml"]
    assert f"there is: {', '.join(there)}\n" in result.stderr
    assert {path.name for path in (tmp_path / "out").iterdir()} == set(there)


def _interrupted_twice(capsys):
    with (
        errors_reported(robots=False),
        stop_on_interrupt() as stop,
        ProgressDisplay(screen(stderr=True), stop, quiet=False) as progress,
    ):
        os.kill(os.getpid(), signal.SIGINT)
        assert stop.asked
        assert capsys.readouterr().err == f"{STOPPING}\n"
        progress(SimpleNamespace(describe=str))(Progress(0, 1.5, 0.2, 7, 0.3, 1.0, 0.1, 1))
        os.kill(os.getpid(), signal.SIGINT)


def test_first_ctrl_c_is_answered_at_once_and_the_second_after_the_progress(capsys):
    with pytest.raises(typer.Exit):
        _interrupted_twice(capsys)
    *_, line, last = capsys.readouterr().err.splitlines()
    assert line.startswith("round 1, iteration 0: cost 1.5")
    assert last.startswith("error: interrupted before it was done")


def test_interrupt_before_a_gait_stops_at_the_next_iteration(quick, monkeypatch):
    search = optimise_command.design

    def design_interrupted(*args, on_progress, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return search(*args, on_progress=on_progress, **options)

    monkeypatch.setattr(optimise_command, "design", design_interrupted)
    result = quick()
    assert result.exit_code == 130
    assert "interrupted before there was a result" in result.stderr


def test_interrupt_during_a_diagnosis_ends_it(quick, monkeypatch):
    diagnose, begun = diagnosis.find_suggestions, []

    def diagnose_interrupted(*args):
        os.kill(os.getpid(), signal.SIGINT)
        begun.append(time.process_time())
        return diagnose(*args)

    monkeypatch.setattr(diagnosis, "find_suggestions", diagnose_interrupted)
    result = quick("--torque-limit", "10")
    assert time.process_time() - begun[0] < 2.0
    assert result.exit_code == 130
    assert "interrupted before there was a result" in result.stderr


def test_interrupt_with_a_gait_writes_it(quick, designed, monkeypatch, tmp_path):
    search = optimise_command.design

    def design_interrupted(*args, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return search(*args, **options)

    monkeypatch.setattr(optimise_command, "design", design_interrupted)
    # tolerances that the start does not meet, so that it is feasible and not yet optimal
    result = quick("--start", designed / "gait.npz", "--samples", "61", "--tolerance", "1e-14",
                   "-o", tmp_path)  # fmt: skip
    assert result.exit_code == 130
    assert "interrupted" in result.stderr
    assert load_gait(tmp_path / "gait.npz").cost > 3000.0


def test_writability_is_checked_without_leaving_a_trace(tmp_path):
    require_writable(tmp_path / "a" / "b")
    assert not (tmp_path / "a").exists()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is a file"):
        require_writable(tmp_path / "file" / "b")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="there is no /proc")
def test_a_place_that_only_looks_like_a_directory_is_refused():
    with pytest.raises(InputError, match="cannot write to '/proc/sub': in '/proc': "):
        require_writable(Path("/proc/sub"))
