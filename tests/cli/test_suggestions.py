"""Where there is no gait, commands are printed; run as printed they lead to a certified one."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from places import ROOT

from gaitopt.cli import suggestions
from gaitopt.cli.command_options import OptimiseOptions
from gaitopt.cli.suggestions import Asked
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.task import Task


@pytest.fixture(autouse=True)
def started_as_a_module(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/somewhere/gaitopt/__main__.py"])


def advised(stderr: str) -> list[str]:
    return [line.strip() for line in stderr.splitlines() if line.startswith("    ")]


def run_as_printed(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": paths}
    return subprocess.run(
        command, shell=True, cwd=folder, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("hard", "setting"),
    [(("--torque-limit", "25"), "torque_limit"), (("--friction=0.01", "--speed=1.5"), "friction")],
)
def test_a_suggestion_run_as_printed_gives_a_certified_walk(
    cli, tmp_path, monkeypatch, hard, setting
):
    monkeypatch.chdir(tmp_path)
    config = tmp_path / "a task.toml"
    config.write_text("[solver]\nstarts = 1\nseed = 0\nsigma = 0.0\n[task]\nsamples = 21\n")
    asked = (*hard, "--config", config.name, "--output", "my walk")
    result = cli("optimise", *asked, "--no-figures", "--no-page")
    assert result.exit_code == 3
    command, *_ = advised(result.stderr)
    assert "--output 'my walk'" in command
    assert f"--start 'my walk/suggestions/{setting}.npz'" in command
    assert "--torsional-friction" not in command  # it follows friction
    done = run_as_printed(command, tmp_path)
    assert done.returncode == 0, done.stderr
    kept = load_gait(tmp_path / "my walk" / "suggestions" / f"{setting}.npz")
    found = load_gait(tmp_path / "my walk" / "gait.npz")
    assert found.cost == pytest.approx(kept.cost, rel=1e-9)
    assert found.meta["instants"] == kept.meta["instants"]  # it was gone on from, not found anew
    assert found.meta["solver"]["iterations"] <= kept.meta["solver"]["iterations"]
    record = json.loads((tmp_path / "my walk" / "suggestions" / "diagnosis.json").read_text())
    assert record["commands"] == advised(result.stderr)


def test_without_a_directory_for_results_the_walk_is_kept_among_own_files(
    cli, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    result = cli("optimise", "--liftoff-speed", "1", "--samples", "21", "--starts", "1")
    assert result.exit_code == 3
    command, *_ = advised(result.stderr)
    start = Path(shlex.split(command)[shlex.split(command).index("--start") + 1])
    assert start.is_file()
    assert start.is_relative_to(tmp_path / "cache" / "gaitopt" / "suggestions")
    assert [path.name for path in tmp_path.iterdir()] == ["cache"]


def test_a_user_without_a_home_has_a_place_too(monkeypatch, tmp_path, robot):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    folder = suggestions._folder(SimpleNamespace(robot=robot, task=Task()), None)
    assert folder.is_dir()
    assert folder.is_relative_to(tmp_path)


def test_a_command_is_the_one_that_was_typed_with_changes(monkeypatch):
    typed = {"speed": 0.696034, "free": ["duration", "foot_yaw"], "refine": False, "starts": 4}
    asked = Asked(
        typed,
        OptimiseOptions(config=Path("it's mine.toml"), output=Path("out"), page=False, quiet=True),
    )
    monkeypatch.setattr(sys, "argv", ["gaitopt"])
    command = asked.command({"speed": 0.65, "starts": None, "impulse_cop": False})
    assert shlex.split(command) == [
        "gaitopt", "optimise", "--speed", "0.65", "--free", "duration", "--free", "foot_yaw",
        "--no-refine", "--no-impulse-cop", "--config", "it's mine.toml", "--output", "out",
        "--no-page", "--quiet",
    ]  # fmt: skip


def test_a_robot_with_unequal_motors_gets_its_new_limits_by_a_file(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "weak.toml").write_text(
        '[[limits]]\njoints = "*"\ntorque = 28.0\n[[limits]]\njoints = "*yaw"\ntorque = 30.0\n'
    )
    cli("urdf", "--output", "robot.urdf")
    asked = ("--urdf", "robot.urdf", "--choices", "weak.toml", "--preset", "standard")
    result = cli("optimise", *asked, "--samples", "21", "--starts", "1", "--output", "w",
                 "--no-page", "--no-figures")  # fmt: skip
    assert result.exit_code == 3, result.stdout
    (command,) = [line for line in advised(result.stderr) if "--choices" in line][:1]
    assert "--choices w/suggestions/robot_torque_limits.toml" in command
    done = run_as_printed(command, tmp_path)
    assert done.returncode == 0, done.stderr


def test_nothing_is_said_where_nothing_was_diagnosed():
    assert list(suggestions.suggestion_lines(None, None, Asked({}, OptimiseOptions()))) == []  # type: ignore[arg-type]
