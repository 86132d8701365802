"""A library over the ways a robot can go, exported and read back."""

import csv

import numpy as np
import pytest

from gaitopt.design.audit import audit
from gaitopt.design.options import DesignOptions
from gaitopt.gait.presets import preset_task
from gaitopt.motions.export import INDEX, export_library
from gaitopt.sweep import Axis, sweep


@pytest.fixture(scope="module")
def library(robot, tmp_path_factory):
    task = preset_task(speed=0.5, samples=15)
    axes = [Axis("lateral_speed", (0.0, 0.1)), Axis("turn_rate", (-0.2, 0.2))]
    folder = tmp_path_factory.mktemp("ways")
    return sweep(robot, task, axes, folder, DesignOptions(refine=False))


def test_every_point_is_a_stride(library):
    for point in library.grid.order:
        gait, wanted = library.gait(point), library.grid.values(point)
        assert gait.second is not None
        assert gait.lateral_speed == pytest.approx(wanted["lateral_speed"], abs=1e-9)
        assert gait.turn_rate == wanted["turn_rate"]
        assert audit(gait).altered == ()


def test_turns_to_either_side_cost_the_same(library):
    left, right = (library.gait((0, side)).cost for side in (0, 1))
    assert left == pytest.approx(right, rel=1e-4)  # as nearly as its walks are solved


def test_library_is_exported_with_its_ways(library, tmp_path):
    index = export_library(library, tmp_path / "out", format="motion", rate=50.0)
    with open(index, newline="") as file:
        rows = list(csv.DictReader(file))
    assert index.name == INDEX
    assert len(rows) == 4
    for row in rows:
        with np.load(tmp_path / "out" / row["file"]) as motion:
            assert np.isfinite(motion["joint_pos"]).all()
        assert float(row["turn_rate"]) in (-0.2, 0.2)
        assert float(row["speed"]) == pytest.approx(0.5)
