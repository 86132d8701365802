"""What `inspect` knows about a robot is said by every command, in summary.json and on the page."""

import json
from dataclasses import replace

import pytest
from example_robots import needs_example_robots
from places import CASES
from rich.console import Console

from gaitopt import Robot, load_gait, summarise
from gaitopt.catalogue.entries import robot_by_name
from gaitopt.cli.report import inspect_command, print_findings
from gaitopt.importers.report import Finding, findings_of

CASE = CASES / "urdf_warnings_not_in_optimise.urdf"
WARNED = "torque limit 0 N·m is a placeholder"


@pytest.fixture(scope="module")
def walk(tmp_path_factory, quick):
    """A directory with a walk of the robot, and what was said on the way."""
    directory = tmp_path_factory.mktemp("known") / "walk"
    words = ("--solver", "sqp", "--starts", "1", "--no-refine", "--no-figures")
    result = quick("--urdf", CASE, *words, "--page", "-o", directory)
    assert result.exit_code == 0, result.stderr
    return directory, result


def test_optimise_says_it_first(walk):
    _, result = walk
    said = result.stderr.partition("round 1")[0]
    assert f"warning: all joints: {WARNED}" in said
    assert "joint 'left_hip_yaw': the effort limit is '0'" in said
    assert said.count("the effort limit is '0'") == 1  # the others are named by their lines
    assert "the same at line 36, line 50" in said
    assert f"gaitopt inspect --urdf {CASE}" in said
    assert "walks at" in result.stdout


def test_margins_of_the_biped_for_another_robot_are_warned_of(quick):
    said = quick("--urdf", CASE, "--preset", "standard", "--samples", "15").stderr
    assert "warning: the margins of this task are those of the thirteen-link biped" in said
    assert "; --preset humanoid sizes them by the robot\n" in said
    assert "the margins of this task" not in quick("--samples", "15").stderr


def test_a_sweep_warns_of_the_margins_too(cli, tmp_path):
    asked = ("--preset", "standard", "--speeds", "0.5", "--samples", "15", "--no-refine")
    said = cli("sweep", "--urdf", str(CASE), *asked, "--solver", "sqp", "-o", str(tmp_path / "s"))
    assert "the margins of this task are those of the thirteen-link biped" in said.stderr


def test_summary_page_and_python_have_it(walk):
    directory, _ = walk
    summary = json.loads((directory / "summary.json").read_text())
    findings = summary["findings"]
    assert findings == summarise(load_gait(directory / "gait.npz"))["findings"]
    assert all(set(f) == {"topic", "subject", "how", "text"} for f in findings)
    warned = [f for f in findings if f["how"] == "warning"]
    assert any(WARNED in f["text"] for f in warned)
    assert sum(f["topic"] == "file" for f in warned) == 24
    known = Robot.from_urdf(CASE).findings
    assert [f.record() for f in known] == findings
    assert findings_of(findings) == known
    page = (directory / "gait.html").read_text()
    assert f"<summary>about the robot: warnings: {len(warned)}, guesses: " in page
    assert WARNED in page


@pytest.mark.parametrize(
    "words",
    [
        ("check",),
        ("export", "--output", "out.json"),
        ("play", "--html", "out.html"),
    ],
)
def test_commands_that_take_a_gait_say_it(cli, walk, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    result = cli(words[0], walk[0] / "gait.npz", *words[1:])
    assert result.exit_code in (0, 1)
    assert f"warning: all joints: {WARNED}" in result.stderr
    assert "the record 'findings' of the gait has them" in result.stderr


def test_sweeps_and_libraries_say_it(cli, tmp_path):
    words = ("--urdf", CASE, "--speeds", "0.6", "--no-refine", "--solver", "sqp")
    result = cli("sweep", *words, "-o", tmp_path / "gaits")
    assert f"warning: all joints: {WARNED}" in result.stderr
    (gait,) = map(load_gait, (tmp_path / "gaits" / "gaits").iterdir())
    assert findings_of(gait.fact("findings")) == Robot.from_urdf(CASE).findings
    result = cli("library", tmp_path / "gaits")
    assert result.exit_code == 0
    assert f"warning: all joints: {WARNED}" in result.stderr
    assert WARNED not in cli("sweep", *words, "-q", "-o", tmp_path / "gaits").stderr


@needs_example_robots
@pytest.mark.parametrize("name", ["g1", "human", "icub", "romeo", "simple_humanoid"])
def test_what_was_guessed_is_not_given_when_a_robot_is_read_again(name):
    """Sweeps, motors and gait files read it with every choice made explicit."""
    robot = robot_by_name(name)
    assert {"guessed", "found"} <= {one.how for one in robot.findings}
    again = Robot.from_urdf(robot.urdf, choices=robot.choices)
    assert set(again.findings) != set(robot.findings)
    assert set(again.as_before(robot.findings).findings) == set(robot.findings)
    nearly = replace(robot.sole, toe=robot.sole.toe + 0.01)  # another fact, and that is given
    other = Robot.from_urdf(robot.urdf, choices=robot.choices.over(sole=nearly))
    (sole,) = (f for f in other.as_before(robot.findings).findings if f.topic == "sole")
    assert (sole.how, f"{1e3 * nearly.toe:.1f} mm forward" in sole.text) == ("given", True)


def test_inspect_shows_odd_lines_once(cli):
    assert cli("inspect", "--urdf", CASE).stdout.count("'left_hip_yaw': the effort limit") == 1


def test_a_sound_robot_needs_no_words(designed):
    said = (designed / "stdout.txt").read_text()
    assert "warning" not in said
    assert "guessed" not in said


def test_what_is_told_and_how(capsys):
    console = Console(width=200)
    names = ("a", "b\x1b[2J", "c")
    findings = [Finding("limits", n, f"joint '{n}': odd", "warning") for n in names]
    findings += [
        Finding("symmetry", "trunk", "averaged [bold]", "changed"),
        Finding("sole", "robot", "a guess", "guessed"),
        Finding("sole", "robot", "another", "guessed"),
        Finding("legs", "robot", "plain fact", "found"),
    ]
    print_findings(console, findings, inspect_command({"robot": "g1", "package_dir": ["a b", "c"]}))
    assert capsys.readouterr().out.splitlines() == [
        "warning: a: joint 'a': odd; the same at b\\x1b[2J, c",
        "changed: trunk: averaged [bold]",
        "guessed: 2 facts were, about sole; all of it: gaitopt inspect --robot g1 "
        "--package-dir 'a b' --package-dir c",
    ]
    assert findings_of([{"how": "sure"}, 3, None]) == ()
    assert findings_of("none") == ()
