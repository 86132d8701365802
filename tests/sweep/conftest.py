import pytest
from sweeps import QUICK, SPEEDS, Counting, quick_task

from gaitopt.sweep.executor import Job
from gaitopt.sweep.library import Library
from gaitopt.sweep.scheduler import sweep


@pytest.fixture(scope="session")
def swept_and_jobs(robot, tmp_path_factory) -> tuple[Library, list[Job]]:
    directory = tmp_path_factory.mktemp("lib") / "swept"
    with Counting() as jobs:
        return sweep(robot, quick_task(), [SPEEDS], directory, QUICK), jobs.done


@pytest.fixture(scope="session")
def swept(swept_and_jobs) -> Library:
    """A library of four speeds, made without interruption."""
    return swept_and_jobs[0]


@pytest.fixture(scope="session")
def swept_jobs(swept_and_jobs) -> list[Job]:
    """The jobs that made it, in their order."""
    return swept_and_jobs[1]
