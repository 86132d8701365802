import subprocess
import sys
import time

import pytest
from sweeps import QUICK, SPEEDS, costs, quick_task

from gaitopt.errors import GaitoptError, InputError
from gaitopt.sweep.scheduler import sweep

pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.filterwarnings("ignore")  # what Dask says while workers die is its own

from gaitopt.sweep import executor as cluster  # noqa: E402
from gaitopt.sweep.executor import joined_scheduler  # noqa: E402


@pytest.fixture
def scheduler(tmp_path):
    """A scheduler of its own with one worker, as on a cluster."""
    file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    where = ["--scheduler-file", str(file)]
    commands = (
        ["scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", *where],
        ["worker", "--nthreads", "1", "--no-dashboard", "--no-nanny", *where],
    )
    processes = [subprocess.Popen([*dask, *command], **quiet) for command in commands]
    try:
        from distributed import Client

        deadline = time.monotonic() + 300.0
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        with Client(scheduler_file=str(file), timeout=300) as client:
            client.wait_for_workers(1, timeout=300)
            yield client.scheduler.address
    finally:
        for process in processes:
            process.kill()  # asked politely, a worker would wait for its scheduler to come back
            process.wait()


def test_an_external_scheduler_finds_the_same(robot, swept, scheduler, tmp_path):
    with joined_scheduler(scheduler) as executor:
        library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, executor=executor)
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


def test_an_address_where_nobody_answers_is_refused_soon(monkeypatch):
    monkeypatch.setattr(cluster, "REACH_SECONDS", 0.5)
    with pytest.raises(InputError, match=r"answers at 'tcp://127.0.0.1:9' within 0.5 s; start one"):
        joined_scheduler("tcp://127.0.0.1:9")


def test_a_server_that_is_no_scheduler_is_refused(monkeypatch):
    def answered(*_, **__):
        raise RuntimeError("it speaks otherwise")

    monkeypatch.setattr("distributed.Client", answered)
    with pytest.raises(InputError, match=r"no Dask scheduler answers at 'tcp://127.0.0.1:9'"):
        joined_scheduler("tcp://127.0.0.1:9")


def test_a_scheduler_that_goes_away_is_told(robot, scheduler, tmp_path):
    from distributed import Client

    def stop(progress):
        with Client(scheduler) as client:
            client.shutdown()

    with (
        joined_scheduler(scheduler) as executor,
        pytest.raises(GaitoptError, match="what was finished is kept, and the same command goes"),
    ):
        sweep(
            robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK,
            executor=executor, on_progress=stop,
        )  # fmt: skip
