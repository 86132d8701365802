import pytest
from sweeps import QUICK, SPEEDS, quick_task

from gaitopt.study.library import Library
from gaitopt.study.sweep import sweep


@pytest.fixture(scope="session")
def swept(robot, tmp_path_factory) -> Library:
    """A library of four speeds, made without interruption."""
    return sweep(robot, quick_task(), [SPEEDS], tmp_path_factory.mktemp("lib") / "swept", QUICK)
