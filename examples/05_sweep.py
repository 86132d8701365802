"""Fill a library with walks at several speeds, each from its neighbours; find the cheapest."""

from pathlib import Path

from gaitopt import Robot, biped13, preset_task, urdf_text
from gaitopt.sweep import parse_axis, sweep

RESULTS = Path(__file__).parent / "results"

robot = Robot.from_urdf(urdf_text(biped13()))
task = preset_task("standard", robot)
library = sweep(robot, task, [parse_axis("speed", "0.7:0.9:0.1")], RESULTS / "speeds")

print("speed      cost")
for row in library.rows:
    print(f"{row['speed']:.1f} m/s {row['cost']:8.1f} N²·m·s, {row['status']}")
best = min(library.rows, key=lambda row: row["cost"])
print(f"cheapest per metre: {best['speed']:.1f} m/s")
