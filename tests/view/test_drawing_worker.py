import os
import re
import signal
import sys
import time
from contextlib import closing
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from page_scene import unpacked
from sample_gait import sample_gait

from gaitopt.cli.request import make_request
from gaitopt.cli.results import write_results
from gaitopt.design import process as processes
from gaitopt.errors import InputError
from gaitopt.view import drawing_worker as module
from gaitopt.view.drawing_worker import (
    DrawingWorker,
    draw_figures,
    draw_page,
    mesh_files,
    spare_cores,
)
from gaitopt.view.figures import FIGURES
from gaitopt.view.robot_shapes import capsule

NAMES = [f"{name}.png" for name in FIGURES]


def test_another_process_draws_and_if_it_dies_this_one_does(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    (tmp_path / "file").write_text("")
    with closing(DrawingWorker()) as worker:
        worker.get_ready(figures=True)
        files = worker.begin(draw_figures, sample_gait(), tmp_path / "a")()
        with pytest.raises(InputError, match="cannot make the directory"):
            worker.begin(draw_figures, sample_gait(), tmp_path / "file" / "x")()
        for process in list(worker.pool._processes):
            os.kill(process, signal.SIGKILL)
        again = worker.begin(draw_figures, sample_gait(), tmp_path / "b")()
    assert [f.name for f in files] == [f.name for f in again] == NAMES
    assert [f.read_bytes() for f in files] == [f.read_bytes() for f in again]


def test_a_copy_draws_half_and_if_it_dies_the_worker_does_all(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    with closing(DrawingWorker()) as worker:
        worker.get_ready(figures=True)
        ended = worker.begin(exit_codes)()
    copied = sys.platform.startswith("linux")
    assert ended == ([0, 1, -signal.SIGKILL] if copied else [None] * 3)
    assert capfd.readouterr().err == ""
    monkeypatch.setattr(processes, "_work", lambda _: kill_myself())
    with closing(DrawingWorker()) as worker:
        worker.get_ready(figures=True)
        files = worker.begin(draw_figures, sample_gait(), tmp_path)()
    assert [f.name for f in files] == NAMES == [f.name for f in files if f.stat().st_size]


def exit_codes():
    """Of copies that do what they are to, fail, and are killed."""
    works = (os.getpid, partial(int, "no number"), kill_myself)
    copies = [processes.copy_that_does(work) if module._is_worker() else None for work in works]
    for copy in filter(None, copies):
        copy.join()
    return [copy and copy.exitcode for copy in copies]


def kill_myself():
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_process_that_is_no_worker_is_not_copied():
    assert not module._is_worker()


@pytest.mark.parametrize("begun", [0, 1, 5])
def test_a_page_with_meshes_is_the_same_from_two_processes(begun, tmp_path, monkeypatch):
    """But for the names of objects, which MeshCat draws by lot; whoever simplified the meshes."""
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    corners, faces = capsule(0.05, 0.1)
    records = np.zeros(len(faces), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("", "<u2")])
    gait = sample_gait()
    drawn = r"(<visual>(?:(?!</visual>).)*?)<geometry>.*?</geometry>"
    parts = re.split(drawn, gait.urdf, flags=re.DOTALL)
    for number, place in enumerate(range(1, len(parts), 2)):
        path = tmp_path / f"{number}.stl"
        records["corners"] = (1.0 + 0.1 * number) * corners[faces]
        head = bytes(80) + len(faces).to_bytes(4, "little")
        path.write_bytes(head + records.tobytes() + bytes(number))
        parts[place] += f'<geometry><mesh filename="{path}"/></geometry>'
    gait = replace(gait, urdf="".join(parts))
    files = mesh_files(gait.urdf, ())
    assert files == [str(tmp_path / f"{n}.stl") for n in reversed(range(len(files)))]
    assert len(files) > 5
    with closing(DrawingWorker()) as worker:
        worker.get_ready(meshes=files)
        for job in list(worker._meshes.values())[:begun]:
            job.result()
        own = worker.simplify_rest()
        assert set(own) <= set(files[begun:])
        there = worker.begin(draw_page, gait, own)()
    assert b"normal" in lots_apart(there)  # of simplified meshes
    assert lots_apart(there) == lots_apart(draw_page(gait))


def test_meshes_and_the_page_are_made_here_if_the_process_dies(monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    with closing(DrawingWorker()) as worker:
        worker.get_ready(meshes=["no such file"])
        for process in list(worker.pool._processes):
            os.kill(process, signal.SIGKILL)
        assert worker.simplify_rest() in ({}, {"no such file": None})
        page = worker.begin(draw_page, sample_gait(), {})()
    assert lots_apart(page) == lots_apart(draw_page(sample_gait()))


@pytest.mark.parametrize(
    ("figures", "mesh", "begun"),
    [
        (False, "", ["draw_page"]),
        (False, "<!--<mesh-->", ["draw_page"]),
        (True, "", ["draw_page", "draw_figures"]),
        (True, "<!--<mesh-->", ["draw_figures"]),  # that of the page would be waited for
    ],
)
def test_a_worker_draws_the_page_first_but_no_meshes_beside_figures(
    figures, mesh, begun, tmp_path, monkeypatch
):
    asked = []

    def begin(worker, draw, *facts):
        asked.extend([draw.__name__] if worker is given else [])
        return partial(draw, *facts)

    monkeypatch.setattr(DrawingWorker, "begin", begin)
    gait, given = replace(sample_gait(), urdf=sample_gait().urdf + mesh), DrawingWorker()
    request = make_request({}, None)
    written = [*write_results(gait, request, tmp_path, page=True, figures=figures, worker=given)]
    assert asked == begun
    assert all(path.exists() for path in written)
    assert {"gait.html", *(["figures"] if figures else [])} <= {path.name for path in written}


def lots_apart(page):
    scene = unpacked(re.search(r'PACKED_SCENE = "([^"]*)";', page)[1])
    return re.sub(rb"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}", b"", scene)


def sleep_long():
    time.sleep(3600.0)


def test_what_is_not_wanted_any_more_is_not_waited_for(monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    began = time.monotonic()
    monkeypatch.setattr(module, "ready_for_figures", sleep_long)
    with closing(DrawingWorker()) as worker:
        worker.get_ready(figures=True)
        assert worker.pool is not None
    assert time.monotonic() - began < 1800.0


@pytest.mark.parametrize(("figures", "spare"), [(False, 1.0), (True, 0.8)])
def test_no_process_is_started_for_nothing(figures, spare, monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: spare)
    with closing(DrawingWorker()) as worker:
        worker.get_ready(figures=figures)
        assert worker.pool is None


@pytest.mark.parametrize(
    ("cores", "load", "running", "spare"),
    [
        (2, 0.3, 1, 1.0),
        (2, 1.5, 1, 1.0),  # of commands that have ended
        (2, 1.5, 3, 0.5),
        (2, 0.3, 4, 1.0),  # for a moment
        (2, 1.5, None, 0.5),  # where nothing tells what runs
        (8, 2.5, 9, 5.5),
        (1, 0.0, 1, 0.0),
    ],
)
def test_cores_that_others_use_are_not_spare(cores, load, running, spare, monkeypatch, tmp_path):
    told = tmp_path / "loadavg"
    if running is not None:
        told.write_text(f"{load} 0.0 0.0 {running}/512 4711\n", encoding="ascii")
    monkeypatch.setattr(module, "_LOAD", told)
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr("os.getloadavg", lambda: (load, 0.0, 0.0), raising=False)
    assert spare_cores() == spare
