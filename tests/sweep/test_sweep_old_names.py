"""What docs of version 0.1 tell to import."""

import importlib
import sys

import pytest

from gaitopt.sweep import grid, scheduler


def test_the_old_package_leads_to_the_new_one_with_a_warning():
    for name in [n for n in sys.modules if n.split(".")[:2] == ["gaitopt", "study"]]:
        del sys.modules[name]
    with pytest.warns(DeprecationWarning, match=r"gaitopt\.study is now gaitopt\.sweep"):
        assert importlib.import_module("gaitopt.study.axes").parse_axis is grid.parse_axis
    assert importlib.import_module("gaitopt.study.sweep").sweep is scheduler.sweep
