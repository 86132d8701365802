import pytest
from sweeps import QUICK, SPEEDS, quick_task

from gaitopt.sweep.library import Library
from gaitopt.sweep.scheduler import sweep


@pytest.fixture(scope="session")
def swept(robot, tmp_path_factory) -> Library:
    """A library of four speeds, made without interruption."""
    return sweep(robot, quick_task(), [SPEEDS], tmp_path_factory.mktemp("lib") / "swept", QUICK)
