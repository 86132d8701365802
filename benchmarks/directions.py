"""G1's walks forward, backward, sideways and in turns as one library, exported and read back.

python benchmarks/directions.py [--quick] --library DIR

The library is kept in DIR and goes on from there if it was interrupted; the seconds are all those
of processor that went into it (docs/directions.md).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save

from gaitopt.errors import GaitFileError
from gaitopt.motions.export import export_library
from gaitopt.sweep.library import Library, open_library

GRID = {
    "speed": "-0.4,-0.2,0,0.3,0.6,0.9,1.2",
    "lateral_speed": "-0.3,-0.15,0,0.15,0.3",
    "turn_rate": "-0.6,-0.3,0,0.3,0.6",
}
"""Speeds forward and to the left [m/s], rates of the turn to the left [rad/s]."""
QUICK = {"speed": "0.3,0.6", "lateral_speed": "0,0.15", "turn_rate": "0"}
SAME = 1e-9
"""Relative difference between what was asked of a walk and what the file of its motion says."""


def swept(folder: Path, grid: dict[str, str]) -> Library:
    """Sweep by the command, as a person does; it goes on where it was interrupted."""
    axes = [part for name, values in grid.items() for part in ("--grid", f"{name}={values}")]
    command = [sys.executable, "-m", "gaitopt", "sweep", "--robot", "g1", *axes]
    subprocess.run([*command, "--output", str(folder)], check=False)  # not all may be certified
    return open_library(folder)


def read_back(library: Library) -> dict[str, int]:
    """Export every walk as a motion and read both again: how many walks, motions, and misfits."""
    found = {"gaits": 0, "motions": 0, "other": 0}
    names = [axis.name for axis in library.grid.axes]
    with tempfile.TemporaryDirectory() as folder:
        export_library(library, Path(folder) / "motions", format="motion")
        for point in sorted(library.states):
            try:
                gait = library.gait(point)
            except GaitFileError:
                continue
            found["gaits"] += 1
            asked = library.grid.values(point)
            told = [getattr(gait, name) for name in names]
            if not np.allclose(told, [asked[name] for name in names], rtol=SAME, atol=SAME):
                found["other"] += 1
        for path in sorted((Path(folder) / "motions").glob("*.npz")):
            with np.load(path) as content:
                arrays = [content[name] for name in content.files]
            numbers = [one for one in arrays if one.dtype.kind == "f"]
            found["motions"] += bool(numbers) and all(np.isfinite(one).all() for one in numbers)
    return found


def main() -> None:
    """Make the library, or go on with it, and save what became of it."""
    parser = arguments(__doc__)
    parser.add_argument("--library", metavar="DIR", help="where it is kept")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        grid = QUICK if asked.quick else GRID
        library = swept(Path(asked.library or Path(folder) / "library"), grid)
        rows = library.rows
        data: dict[str, Any] = {
            "grid": grid,
            "cpu seconds": library.seconds,
            "verdicts": dict(Counter(str(row["status"]) for row in rows)),
            "not certified": [
                {**{name: row[name] for name in grid}, "status": row["status"]}
                for row in rows
                if not row.get("certified")
            ],
            "read back": read_back(library),
        }
    print(data["cpu seconds"], data["verdicts"], data["read back"])
    save("directions", data, asked.quick)


if __name__ == "__main__":
    main()
