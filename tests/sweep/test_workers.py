"""Processes on this machine: they find what one process finds, and die without harm."""

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Future, ProcessPoolExecutor
from importlib.util import module_from_spec, spec_from_file_location
from types import SimpleNamespace

import pytest
from sweeps import QUICK, SPEEDS, costs, gaits, quick_task

from gaitopt.design import starts
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import shut_down, without_ctrl_c
from gaitopt.design.starts import many_starts
from gaitopt.errors import PLUGIN, GaitoptError, InputError
from gaitopt.sweep import executor as workers_module
from gaitopt.sweep.executor import FINISH, LocalWorkers, local_workers, run_job
from gaitopt.sweep.scheduler import sweep

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals are POSIX")


def killed(number):
    """End the process that runs this, in a way it cannot see."""
    os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_two_workers_one_of_them_killed_find_what_one_process_finds(robot, swept, tmp_path):
    before, pids = {*multiprocessing.active_children()}, set()

    def kill_one(progress):
        new = {*multiprocessing.active_children()} - before
        if not pids:
            os.kill(next(iter(new)).pid, signal.SIGKILL)
        pids.update(process.pid for process in new)

    with local_workers(2) as executor:
        library = sweep(
            robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK,
            executor=executor, on_progress=kill_one,
        )  # fmt: skip
    assert len(pids) > 2  # others took their place
    assert gaits(library.directory) == gaits(swept.directory)


def test_started_afresh_they_find_the_same(robot, swept, tmp_path, monkeypatch):
    spawn = multiprocessing.get_context("spawn")
    monkeypatch.setattr(workers_module, "worker_context", lambda: spawn)
    with local_workers(1) as executor:
        library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, executor=executor)
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)


class AtOnce(LocalWorkers):
    """Eight workers, most of which wait: each job is done as it comes, and listed."""

    def __init__(self):
        super().__init__(8)
        self.jobs = []

    def submit(self, fn, job, /):
        self.jobs.append(job)
        future = Future()
        future.set_result(fn(job))
        return future


def test_walks_are_finished_while_others_are_compared_and_none_twice(robot, swept, tmp_path):
    executor = AtOnce()
    library = sweep(robot, quick_task(), [SPEEDS], tmp_path / "l", QUICK, executor=executor)
    assert costs(library) == pytest.approx(costs(swept), rel=1e-9)
    finishing = [job.kind == FINISH for job in executor.jobs]
    assert finishing != sorted(finishing)  # some before others are compared
    finished = [(job.point, job.walk.cost) for job in executor.jobs if job.kind == FINISH]
    assert len(finished) == len(set(finished)) >= len(SPEEDS.values)


def test_a_job_that_kills_every_worker_is_told():
    with local_workers(2) as executor:
        with pytest.raises(BrokenExecutor, match="death of every worker that took it"):
            executor.submit(killed, 1).result()
        assert executor.submit(abs, -1).result() == 1


class Dead(ProcessPoolExecutor):
    """A pool whose worker dies with every job."""

    def submit(self, *_):
        job = Future()
        job.set_exception(BrokenExecutor())
        return job


def test_without_further_processes_it_is_told(robot, monkeypatch):
    def none(*_, **__):
        raise OSError(24, "Too many open files")

    said = "no worker can be started: too many open files; ask for fewer workers"
    monkeypatch.setattr("concurrent.futures.ProcessPoolExecutor", none)
    with pytest.raises(GaitoptError, match=said):
        many_starts(robot, count=2, workers=2)
    pools = iter([Dead, none])
    monkeypatch.setattr(workers_module, "ProcessPoolExecutor", lambda *a, **k: next(pools)(*a, **k))
    with LocalWorkers(1) as workers:
        with pytest.raises(GaitoptError, match=said):  # when the job is given to another one
            workers.submit(print).result(timeout=60)
        monkeypatch.setattr(workers_module, "ProcessPoolExecutor", none)
        with pytest.raises(GaitoptError, match=said):
            workers.submit(print)


def test_what_a_plugin_does_in_a_worker_is_told(tmp_path, monkeypatch):
    """An exception from another process has lost its lines, and need not come at all."""
    (tmp_path / "mine.py").write_text("def fail(job):\n    raise SystemExit(3)\n")
    spec = spec_from_file_location(f"{PLUGIN}1", tmp_path / "mine.py")
    plugin = module_from_spec(spec)
    spec.loader.exec_module(plugin)
    monkeypatch.setitem(workers_module._WORK, "fail", plugin.fail)
    job = SimpleNamespace(kind="fail", run=lambda *_: plugin.fail(job))
    monkeypatch.setattr(starts, "_stopped", threading.Event())
    for work in (lambda: run_job(job), lambda: starts._run_in_worker(job, DesignOptions(), 0)):
        with pytest.raises(InputError, match=r"SystemExit: 3 \(line 2 of mine.py\); correct it"):
            work()


@pytest.mark.parametrize("end", ["by itself", "at once"])
def test_a_job_that_nobody_read_is_not_waited_for(end):
    """A pipe holds 64 KB; Python before 3.11.5 goes on writing what no process will read."""
    pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
    pool.submit(time.sleep, 3600.0)
    unread = pool.submit(len, bytes(2**22))
    (process,) = pool._processes.values()
    if end == "by itself":
        process.kill()
        with pytest.raises(BrokenExecutor):
            unread.result()
    shut_down(pool, at_once=end == "at once")
    assert not process.is_alive()


def test_workers_that_die_before_they_read_a_job_are_not_waited_for():
    with LocalWorkers(1) as workers:
        first, unread = workers.submit(killed, 0), workers.submit(len, bytes(2**22))
        for future in (first, unread):
            with pytest.raises(BrokenExecutor, match="is there enough memory"):
                future.result()


def test_ctrl_c_waits_for_the_end_of_a_block_where_other_threads_take_signals():
    done, end = [], threading.Event()
    thread = threading.Thread(target=end.wait)
    thread.start()

    def block():
        with without_ctrl_c():
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.1)
            done.append(True)

    try:
        with pytest.raises(KeyboardInterrupt):
            block()
    finally:
        end.set()
        thread.join()
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_error_of_a_job_is_its_own():
    with local_workers(1) as executor, pytest.raises(ZeroDivisionError):
        executor.submit(divmod, 1, 0).result()


def test_workers_are_started_for_the_first_job_only(tmp_path):
    begun = []
    with local_workers(1, lambda: begun.append(1)) as executor:
        assert begun == []
        assert [executor.submit(abs, -n).result() for n in range(3)] == [0, 1, 2]
    assert begun == [1]


def test_none_is_left_afterwards():
    before = {*multiprocessing.active_children()}
    with local_workers(2) as executor:
        executor.submit(abs, -1).result()
        new = {*multiprocessing.active_children()} - before
        executor.submit(time.sleep, 3600.0)
    for process in new:
        process.join(300.0)
    assert new
    assert not {*multiprocessing.active_children()} - before


@pytest.mark.parametrize("everybody", [False, True])
def test_ctrl_c_while_they_work_is_one_message(tmp_path, everybody):
    command = "from gaitopt.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, "sweep", "--speeds", "0.6:1.3:0.05", "--workers", "2",
         "-o", str(tmp_path / "lib")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    first = process.stderr.readline()
    (os.killpg if everybody else os.kill)(process.pid, signal.SIGINT)
    out, said = process.communicate(timeout=300)
    assert first.startswith("starting workers: ")
    assert process.returncode == 130
    assert said.startswith("error: interrupted; 0 gaits")
    assert (len(said.splitlines()), out) == (1, "")


def test_a_process_with_workers_ends_without_a_word():
    script = (
        "from gaitopt.sweep import local_workers\n"
        "with local_workers(2) as executor:\n"
        "    print(executor.submit(abs, -1).result())\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert (run.stdout, run.stderr) == ("1\n", "")


def test_no_workers_are_too_few():
    with pytest.raises(InputError, match="0 workers are too few"):
        local_workers(0)
    with pytest.raises(InputError, match="-1 workers are too few"):
        local_workers(-1)
