"""Sweeps over grids of two quantities, fine and coarse, against as many single designs."""

from __future__ import annotations

import itertools
import tempfile
import time
from pathlib import Path
from typing import Any

from common import arguments, reference_task, robot_of, save

from gaitopt import biped13
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import many_starts
from gaitopt.sweep.grid import TaskGrid, parse_axis, with_values
from gaitopt.sweep.scheduler import Scenarios, sweep

GRIDS = (
    {"speed": "0.4:1.2:0.2", "duration": "0.3:0.6:0.1"},
    {"speed": "0.9,1.2,1.6", "duration": "0.3:0.6:0.1"},
    {"speed": "0.7:1.1:0.1", "friction": "0.3,0.5,0.7"},
    {"speed": "0.6:1.0:0.2", "links.torso.mass": "30,40,50"},
    {"speed": "0.9", "geometry.d4": "0.24:0.36:0.02"},
    {"speed": "0.8:1.2:0.1", "geometry.d4": "0.26:0.34:0.02"},
)
QUICK = ({"speed": "0.9", "geometry.d4": "0.28:0.32:0.02"},)
OPTIONS = DesignOptions(diagnose=False)


def grid(quantities: dict[str, str]) -> dict[str, Any]:
    """Sweep a grid, and design each of its points by itself."""
    spec, robot, task = biped13(), robot_of(), reference_task()
    axes = [parse_axis(name, text) for name, text in quantities.items()]
    points = TaskGrid(tuple(axes))
    started = time.process_time()
    with small_matrices(), tempfile.TemporaryDirectory() as folder:
        library = sweep(robot, task, axes, Path(folder) / "library", OPTIONS, spec=spec)
        rows = library.rows
    between = time.process_time()
    scenarios = Scenarios(robot, spec, points, lambda v: with_values(task, v.items()))
    singles = []
    with small_matrices():
        for point in sorted(itertools.product(*(range(len(a.values)) for a in axes))):
            scenario = scenarios.at(point)
            found = many_starts(scenario.robot.build(), scenario.task, OPTIONS).design
            singles.append(found.solution.cost)
    return {
        "quantities": quantities,
        "cpu seconds": {"sweep": between - started, "single": time.process_time() - between},
        "gaits": [
            {"values": points.values(point), "cost": row["cost"], "single": single,
             "certified": row["certified"]}
            for point, row, single in zip(sorted(points.order), rows, singles, strict=True)
        ],
    }  # fmt: skip


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    save("grids", [grid(quantities) for quantities in (QUICK if quick else GRIDS)], quick)


if __name__ == "__main__":
    main()
