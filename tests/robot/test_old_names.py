"""What docs of version 0.1 tell to import of robots."""

import importlib
import sys

import pytest

import gaitopt
from gaitopt.model import import_options


def test_the_old_package_leads_to_the_new_ones_with_a_warning():
    for name in [n for n in sys.modules if n.split(".")[:2] == ["gaitopt", "robot"]]:
        del sys.modules[name]
    with pytest.warns(DeprecationWarning, match=r"gaitopt\.robot is now gaitopt\.importers"):
        old = importlib.import_module("gaitopt.robot.choices_file")
    assert old.choices_from_toml is import_options.choices_from_toml
    robot = sys.modules["gaitopt.robot"]
    assert robot.biped13 is gaitopt.biped13
    assert all(hasattr(robot, name) for name in robot.__all__)
