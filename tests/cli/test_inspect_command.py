"""`gaitopt inspect` and `robots`: what a robot is taken for, said before anything is computed."""

import re

import pytest
from example_robots import example_robot, needs_example_robots
from places import CASES

from gaitopt import Robot, biped13, urdf_text
from gaitopt.model.chain_physics import NO_ROTORS
from gaitopt.model.import_options import choices_from_toml

LEGS = "{left,right}_"


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(urdf_text(biped13()))
    return path


def test_everything_about_the_biped_is_on_one_screen(cli, urdf):
    result = cli("inspect", "--urdf", urdf)
    assert result.exit_code == 0, result.stderr
    text = result.stdout
    assert "biped13  can be used" in text
    assert "URDF, 15 links, 12 joints" in text
    assert "56.87 kg" in text
    assert "0.600 m from hip to ankle" in text
    said = " ".join(text.split())
    assert "'right_knee' is straight at +0.000 rad and bends with increasing angle" in said
    rows = [line.split() for line in text.splitlines() if line.startswith(LEGS)]
    assert [row[0].removeprefix(LEGS) for row in rows] == [
        "hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll"
    ]  # fmt: skip
    assert rows[3][1:] == ["equal", "+y", "0.00", "to", "2.60", "150", "10", "0"]
    assert rows[0][1:3] == ["opposite", "+z"]
    assert "forward is +x" in text
    assert len(text.splitlines()) < 50
    assert max(map(len, text.splitlines())) <= 80


def test_choices_written_and_edited_change_the_robot(cli, urdf, tmp_path):
    choices = tmp_path / "choices.toml"
    assert cli("inspect", "--urdf", urdf, "--write-choices", choices).exit_code == 0
    assert choices_from_toml(choices) == Robot.from_urdf(urdf).choices
    choices.write_text(choices.read_text().replace("heel = -0.214", "heel = -0.2"))
    result = cli("inspect", "--urdf", urdf, "--choices", choices)
    assert result.exit_code == 0
    assert "0.0 mm forward, 200.0 mm back" in result.stdout


def test_one_choice_on_the_command_line(cli, urdf):
    result = cli("inspect", "--urdf", urdf, "--sole", "0.01,-0.2,0.05,-0.05")
    assert "10.0 mm forward, 200.0 mm back, 50.0 mm left" in " ".join(result.stdout.split())


def test_a_warning_is_said_to_its_end(cli):
    """What to do stands there."""
    result = cli("inspect", "--urdf", CASES / "base_mini.urdf")
    assert " ".join(NO_ROTORS.split()) in " ".join(re.sub(r" {2,}", " ", result.stdout).split())


def test_placeholders_are_marked(cli, urdf):
    urdf.write_text(urdf.read_text().replace('velocity="10"', 'velocity="100"'))
    assert "none (100)" in cli("inspect", "--urdf", urdf).stdout


def test_refused_robot_is_told_as_far_as_it_goes(cli, urdf):
    urdf.write_text(urdf.read_text().replace('effort="150"', 'effort="80"', 1))
    result = cli("inspect", "--urdf", urdf)
    assert result.exit_code == 2
    assert "biped13  cannot be used" in result.stdout
    assert "56.87 kg" in result.stdout
    assert f"{LEGS}knee" in result.stdout
    assert "torque limits of" in result.stderr
    assert "Traceback" not in result.stderr


def test_file_that_is_no_robot(cli, tmp_path):
    path = tmp_path / "odd.urdf"
    path.write_text('<robot name="odd"><link name="a"/><joint name="j"/></robot>')
    result = cli("inspect", "--urdf", path)
    assert result.exit_code == 2
    assert "odd.urdf  cannot be used" in result.stdout
    assert "line 1: joint 'j'" in result.stderr


def test_page_of_a_robot_and_of_a_refused_one(cli, urdf, tmp_path):
    page = tmp_path / "robot.html"
    assert cli("inspect", "--urdf", urdf, "--html", page).exit_code == 0
    assert "{left,right}_knee" in page.read_text()
    urdf.write_text(urdf.read_text().replace('effort="150"', 'effort="80"', 1))
    assert cli("inspect", "--urdf", urdf, "--html", page).exit_code == 2
    assert '<p class="refusal">the limits of the two legs differ' in page.read_text()
    urdf.write_text("<robot")
    kept = page.read_text()
    for path in (urdf, tmp_path / "missing.urdf"):
        result = cli("inspect", "--urdf", path, "--html", page)
        assert result.exit_code == 2
        assert "wrote" not in result.stdout
        assert page.read_text() == kept


@needs_example_robots
def test_a_robot_of_another_maker(cli):
    path = example_robot("g1_description/urdf/g1_29dof_rev_1_0.urdf")
    result = cli("inspect", "--urdf", path)
    assert result.exit_code == 0
    assert re.search(r"^\{left,right\}_hip_roll .*\n_joint ", result.stdout, re.MULTILINE)
    assert "+x 10°" in result.stdout
    assert "guessed" in result.stdout


def test_list_of_robots(cli):
    result = cli("robots")
    assert result.exit_code == 0
    assert [w for w in ("biped13", "talos", "g1") if w not in result.stdout] == []
    assert "part of gaitopt" in result.stdout
