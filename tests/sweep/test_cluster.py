import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress

import pytest
from sweeps import QUICK, SPEEDS, quick_task

from gaitopt.errors import GaitoptError, InputError
from gaitopt.sweep.scheduler import sweep

pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.filterwarnings("ignore")  # what Dask says while workers die is its own

from gaitopt.sweep import executor as cluster  # noqa: E402
from gaitopt.sweep.executor import joined_scheduler, local_workers  # noqa: E402


def costs(library):
    return {row["speed"]: row["cost"] for row in library.rows}


def test_two_workers_one_of_them_killed_find_what_one_process_finds(robot, swept, tmp_path):
    told = []
    with local_workers(2) as executor:
        pids = list(executor.client().run(os.getpid).values())

        def kill_one(progress):
            told.append(progress)
            if len(told) == 2:
                os.kill(pids[0], signal.SIGKILL)

        library = sweep(
            robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK,
            executor=executor, on_progress=kill_one,
        )  # fmt: skip
    assert len(set(pids)) == 2
    assert len(told) > 2
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


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


@pytest.mark.filterwarnings("error:Port 8787")
def test_local_workers_take_no_port_for_a_dashboard():
    with socket.socket() as taken:
        with suppress(OSError):  # somebody else has it: as good
            taken.bind(("127.0.0.1", 8787))
            taken.listen()
        with local_workers(1) as executor:
            assert len(executor.client().nthreads()) == 1


def test_workers_are_started_for_the_first_job_only(robot, swept, tmp_path):
    begun = []
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    with local_workers(1, lambda: begun.append(1)) as executor:
        sweep(robot, quick_task(), [SPEEDS], directory, QUICK, executor=executor)
        assert begun == []
        (directory / "gaits" / "speed=1.npz").unlink()
        sweep(robot, quick_task(), [SPEEDS], directory, QUICK, executor=executor)
    assert begun == [1]
    assert (directory / "gaits" / "speed=1.npz").exists()


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


@pytest.mark.skipif(os.name != "posix", reason="process groups are POSIX")
@pytest.mark.parametrize("everybody", [False, True])
def test_ctrl_c_while_workers_start_is_one_message(tmp_path, everybody):
    command = "from gaitopt.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, "sweep", "--speeds", "0.6:1.3:0.05", "--workers", "2",
         "-o", str(tmp_path / "lib")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    first = process.stderr.readline()
    time.sleep(0.5)  # amid the start, which takes longer
    (os.killpg if everybody else os.kill)(process.pid, signal.SIGINT)
    out, said = process.communicate(timeout=300)
    assert first.startswith("starting workers: ")
    assert process.returncode == 130
    assert said.startswith("error: interrupted; 0 gaits")
    assert (len(said.splitlines()), out) == (1, "")


def test_no_workers_are_too_few():
    with pytest.raises(InputError, match="0 workers are too few"):
        local_workers(0)
    with pytest.raises(InputError, match="-1 workers are too few"):
        local_workers(-1)
