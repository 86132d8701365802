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

from gaitopt.errors import InputError
from gaitopt.sweep.scheduler import sweep

pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")
pytestmark = pytest.mark.filterwarnings("ignore")  # what Dask says while workers die is its own

from gaitopt.sweep import executor as cluster  # noqa: E402
from gaitopt.sweep.executor import LaterCrew, joined_crew, local_crew  # noqa: E402


def costs(library):
    return {row["speed"]: row["cost"] for row in library.rows}


def test_two_workers_one_of_them_killed_find_what_one_process_finds(robot, swept, tmp_path):
    crew = local_crew(2)
    pids = list(crew.client.run(os.getpid).values())
    advances = []

    def kill_one(advance):
        advances.append(advance)
        if len(advances) == 2:
            os.kill(pids[0], signal.SIGKILL)

    library = sweep(
        robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, crew=crew, on_advance=kill_one
    )
    assert len(set(pids)) == 2
    assert len(advances) > 2
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

        deadline = time.monotonic() + 60.0
        while not file.exists() and time.monotonic() < deadline:
            time.sleep(0.1)
        with Client(scheduler_file=str(file), timeout=30) as client:
            client.wait_for_workers(1, timeout=60)
            yield client.scheduler.address
    finally:
        for process in processes:
            process.kill()  # asked politely, a worker would wait for its scheduler to come back
            process.wait()


def test_an_external_scheduler_finds_the_same(robot, swept, scheduler, tmp_path):
    library = sweep(
        robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, crew=joined_crew(scheduler)
    )
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


def test_an_address_where_nobody_answers_is_refused_soon(monkeypatch):
    monkeypatch.setattr(cluster, "REACH", 0.5)
    with pytest.raises(InputError, match=r"answers at 'tcp://127.0.0.1:9' within 0.5 s; start one"):
        joined_crew("tcp://127.0.0.1:9")


@pytest.mark.filterwarnings("error:Port 8787")
def test_local_workers_take_no_port_for_a_dashboard():
    with socket.socket() as taken:
        with suppress(OSError):  # somebody else has it: as good
            taken.bind(("127.0.0.1", 8787))
            taken.listen()
        crew = local_crew(1)
        assert len(crew.client.nthreads()) == 1
        crew.close()


def test_workers_are_started_for_the_first_job_only(robot, swept, tmp_path):
    begun = []
    crew = LaterCrew(1, lambda: begun.append(1))
    assert crew.room >= 1
    directory = shutil.copytree(swept.directory, tmp_path / "lib")
    sweep(robot, quick_task(), [SPEEDS], directory, QUICK, crew=crew)
    assert begun == []
    (directory / "gaits" / "speed=1.npz").unlink()
    sweep(robot, quick_task(), [SPEEDS], directory, QUICK, crew=crew)
    assert begun == [1]
    assert (directory / "gaits" / "speed=1.npz").exists()


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
    out, said = process.communicate(timeout=90)
    assert first.startswith("starting workers: ")
    assert process.returncode == 130
    assert said.startswith("error: interrupted; 0 gaits")
    assert (len(said.splitlines()), out) == (1, "")


def test_no_workers_are_too_few():
    with pytest.raises(InputError, match="0 workers are too few"):
        local_crew(0)
    with pytest.raises(InputError, match="-1 workers are too few"):
        LaterCrew(-1, lambda: None)
