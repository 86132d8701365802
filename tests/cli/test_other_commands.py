"""`gaitopt urdf`, `play`, `plot`, `export`, and the program itself."""

import csv
import os
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest

from gaitopt import Margins, Robot, Task, biped13, read_spec, urdf_text
from gaitopt.catalogue.parameters import changed
from gaitopt.cli.config import SCHEMA
from gaitopt.gait.presets import PRESETS
from gaitopt.mechanics import compiled
from gaitopt.solvers import SOLVERS
from gaitopt.version import __version__

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def program(*words, **options):
    return subprocess.run(
        [sys.executable, "-m", "gaitopt", *map(str, words)], capture_output=True, text=True,
        check=False, **options,
    )  # fmt: skip


def test_urdf_of_the_preset(cli):
    result = cli("urdf")
    assert result.exit_code == 0
    assert result.stdout == urdf_text(biped13())


def test_specification_to_start_from(cli, tmp_path):
    spec, urdf = tmp_path / "mine.toml", tmp_path / "mine.urdf"
    assert cli("urdf", "--write-spec", spec).exit_code == 0
    assert read_spec(spec) == biped13()
    assert tomllib.loads(spec.read_text())["geometry"]["d3"] == 0.3
    spec.write_text(spec.read_text().replace("mass = 40.55", "mass = 45.0"))
    assert cli("urdf", "--spec", spec, "-o", urdf).exit_code == 0
    assert Robot.from_urdf(urdf).mass == pytest.approx(56.87 + 4.45)


def test_specification_changed_by_words(cli, tmp_path):
    spec = tmp_path / "long.toml"
    assert cli("urdf", "--set", "shin=42cm", "--write-spec", spec).exit_code == 0
    assert read_spec(spec) == changed(biped13(), {"shin": 0.42})


def test_page_of_a_gait(cli, designed, tmp_path):
    result = cli("play", designed / "gait.npz", "--html", tmp_path / "a.html", "--steps", "2")
    assert result.exit_code == 0
    assert "<html" in (tmp_path / "a.html").read_text()


def test_figures_of_a_gait(cli, designed, tmp_path):
    gait = designed / "gait.npz"
    result = cli("plot", gait, "-o", tmp_path / "f", "--format", "svg")
    assert result.exit_code == 0
    written = sorted((tmp_path / "f").iterdir())
    assert [f"wrote {path}" for path in written] == sorted(result.stdout.splitlines())


def test_export_of_both_legs(cli, designed, tmp_path):
    lengths = []
    for words in ((), ("--both-legs",)):
        assert cli("export", designed / "gait.npz", "-o", tmp_path / "a.csv", *words).exit_code == 0
        with (tmp_path / "a.csv").open() as stream:
            lengths.append(len(list(csv.reader(stream))))
    assert lengths == [32, 63]


def test_version(cli, monkeypatch):
    result = cli("--version")
    first, second = result.stdout.splitlines()
    assert (result.exit_code, first) == (0, f"gaitopt {__version__}")
    assert second.startswith("kernels: compiled") == compiled.BUILT
    for built in (True, False):
        monkeypatch.setattr(compiled, "BUILT", built)
        monkeypatch.setattr(compiled, "WANTED", False)
        assert ("but GAITOPT_COMPILED=0 leaves them aside" in cli("--version").stdout) == built
    assert "install gaitopt again where there is a C++ compiler" in cli("--version").stdout


def test_help_shows_defaults_and_does_not_set_them(cli, quick):
    text = cli("optimise", "--help").stdout
    assert f"[default: {Task().speed}]" in text
    assert f"[default: {Margins().friction}]" in text
    assert "[default: page]" in text
    assert all("bool" not in said for said in (text, cli("--help").stdout))
    assert "optimize" not in cli("--help").stdout


def test_the_short_help_names_the_long_one_and_all_names(cli):
    short, full = (" ".join(cli("optimise", how).stdout.split()) for how in ("-h", "--help-all"))
    assert "more options: gaitopt optimise --help-all" in short.replace("root", "gaitopt")
    assert "--help-all." not in full
    for option in ("--torque-limit", "--robot", "--speed", "--config", "--output"):
        assert option in short
        assert option in full
    for name in (*SCHEMA["task"], *SCHEMA["margins"], *SCHEMA["robot"], *SCHEMA["solver"]):
        assert f"--{name.replace('_', '-')} " in full
    assert "--penalty-weight" not in short
    for names in (PRESETS, tuple(SOLVERS), ("biped13", "talos", "menagerie:NAME")):
        assert [name for name in names if name not in short] == []
    assert "Defaults are" not in cli("inspect", "--help").stdout


def test_every_task_and_margin_field_is_an_option():
    given_otherwise = {"margins", "geometry", "cost", "constraints", "terrain"}
    assert set(SCHEMA["task"]) - {"preset"} == {f.name for f in fields(Task)} - given_otherwise
    assert set(SCHEMA["margins"]) == {f.name for f in fields(Margins)}


def test_defaults_are_those_of_the_method():
    shown = {**SCHEMA["task"], **SCHEMA["margins"]}
    assert shown["speed"].default == Task().speed
    assert shown["clearance"].default == Margins().clearance
    assert shown["torque_limit"].default is None  # that is the robot's
    assert shown["preset"].names == PRESETS


def test_reader_that_goes_away(tmp_path):
    head = subprocess.run(
        f"'{sys.executable}' -m gaitopt urdf | head -n 1; echo ${{PIPESTATUS[0]}}",
        shell=True, executable="/bin/bash", capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert head.stdout.startswith("<?xml")
    assert "Traceback" not in head.stderr


def test_terminal_without_unicode(designed):
    env = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONWARNINGS": "default"}
    result = program("check", designed / "gait.npz", env=env)
    assert result.returncode == 0, result.stderr
    assert "N?s" in result.stdout


def test_error_in_a_process(tmp_path):
    result = program("check", "absent.npz", cwd=tmp_path)
    assert result.returncode == 2
    assert result.stderr.startswith("error: cannot read the gait file 'absent.npz'")
    assert list(Path(tmp_path).iterdir()) == []


def test_sweep_refuses_what_is_for_one_gait_only(cli, tmp_path):
    for words in (("--fastest",), ("--no-page",), ("--starts", "2")):
        result = cli("sweep", "--speeds", "1.0", "--output", tmp_path / "lib", *words)
        assert result.exit_code == 2
        assert "No such option" in result.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("optimise", "--html"), "--html, which is one of gaitopt inspect, play"),
        (("check", "x.npz", "--speeds"), "--speeds, which is one of gaitopt sweep, codesign"),
        (("optimise", "--sped", "1"), "--sped (Possible options: --seed, --spec, --speed)"),
        (("robots", "--bogus"), "--bogus"),
    ],
)
def test_an_option_of_another_command_is_told_as_that(cli, words, said):
    result = cli(*words)
    assert result.exit_code == 2
    told = " ".join(result.stderr.replace("│", "").split())
    assert f"No such option: {said}" in told
    assert "--help)" not in told


def test_an_option_without_its_value_is_told_as_that_alone(cli):
    result = cli("optimise", "--output")
    assert result.exit_code == 2
    assert "requires an argument" in result.stderr
    assert "which is one of" not in result.stderr


def test_help_says_whose_defaults_it_shows(cli):
    for command in ("optimise", "sweep"):
        shown = " ".join(cli(command, "--help").stdout.split())
        assert "Defaults are those of the thirteen-link biped" in shown
