import os
import signal

import pytest
from sample_gait import sample_gait

from gaitopt.errors import InputError
from gaitopt.view import figure_worker as module
from gaitopt.view.figure_worker import figure_worker, spare_cores
from gaitopt.view.figures import FIGURES

NAMES = [f"{name}.png" for name in FIGURES]


def test_another_process_draws_and_if_it_dies_this_one_does(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: 1.0)
    (tmp_path / "file").write_text("")
    with figure_worker() as worker:
        files = worker.begin(sample_gait(), tmp_path / "a")()
        with pytest.raises(InputError, match="cannot make the directory"):
            worker.begin(sample_gait(), tmp_path / "file" / "x")()
        for process in list(worker.pool._processes):
            os.kill(process, signal.SIGTERM)
        again = worker.begin(sample_gait(), tmp_path / "b")()
    assert [f.name for f in files] == [f.name for f in again] == NAMES
    assert [f.read_bytes() for f in files] == [f.read_bytes() for f in again]


@pytest.mark.parametrize(("wanted", "spare"), [(False, 1.0), (True, 0.8)])
def test_no_process_is_started_for_nothing(wanted, spare, monkeypatch):
    monkeypatch.setattr(module, "spare_cores", lambda: spare)
    with figure_worker(wanted) as worker:
        assert worker.pool is None


@pytest.mark.parametrize(
    ("cores", "load", "spare"), [(2, 0.3, 1.0), (2, 1.5, 0.5), (8, 2.5, 5.5), (1, 0.0, 0.0)]
)
def test_cores_that_others_use_are_not_spare(cores, load, spare, monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr("os.getloadavg", lambda: (load, 0.0, 0.0), raising=False)
    assert spare_cores() == spare
