"""The same walk for the least of each cost: what every other figure of it is then.

python benchmarks/costs.py [--quick]

The table and the picture of docs/motors.md are made of it: it prints the one and draws the other.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from common import arguments, save
from tables import table

from gaitopt.cli.request import make_request
from gaitopt.design.certificate import on_fine_grid
from gaitopt.design.process import small_matrices
from gaitopt.design.starts import design_gait
from gaitopt.design.summary import energies_per_step, summarise
from gaitopt.gait import quantities
from gaitopt.gait.costs import CostContext, TorqueCost, TorqueRate
from gaitopt.view.figure_style import label_axes, new_figure, rendered, styled

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "images" / "costs.png"
MOTORS = str(ROOT / "examples" / "motors.toml")
ROBOTS = {"biped13": 0.9, "g1": 0.6}
COSTS = ("torque", "peak-torque", "energy", "work", "torque-rate")
COLUMNS = {
    "torque": "squared torque N²·m·s", "peak-torque": "peak torque N·m", "energy": "energy J/m",
    "work": "work J/m", "torque-rate": "torque rate N²·m/s",
}  # fmt: skip


def walk(robot: str, cost: str) -> dict[str, Any]:
    """Design a walk, and take every figure of it."""
    asked = {"robot": robot, "speed": ROBOTS[robot], "motors": MOTORS, "cost": cost}
    request = make_request(asked, None)
    with small_matrices():
        found = design_gait(request.robot, request.task, options=request.options)
    gait, problem = found.gait, found.problem
    step = problem.step(found.solution.x)
    context = CostContext(problem.robot, problem.grid, problem.task.speed)
    fine = on_fine_grid(problem).step(found.solution.x)
    peak = float(np.abs(fine.read(quantities.TORQUE)).max())
    energies, metres = energies_per_step(gait), gait.step_length
    return {
        "robot": robot, "cost": cost, "verdict": found.certificate.verdict,
        "figures": {
            "torque": TorqueCost().function(context).value(step),
            "peak-torque": peak,
            "energy": float(energies["electrical"] or np.nan) / metres,
            "work": float(energies["absolute_work"] or np.nan) / metres,
            "torque-rate": TorqueRate().function(context).value(step),
        },
        "transport": summarise(gait)["walk"]["costs_of_transport"],
    }  # fmt: skip


def picture(rows: list[dict[str, Any]]) -> bytes:
    """Return bars of every figure over the least of its column, one panel for each robot."""
    with styled():
        figure = new_figure(8.4, 3.0 * len(ROBOTS))
        for panel, robot in zip(figure.subplots(len(ROBOTS), 1, squeeze=False)[:, 0], ROBOTS,
                                strict=True):  # fmt: skip
            own = [row for row in rows if row["robot"] == robot]
            width = 0.8 / len(own)
            for k, row in enumerate(own):
                least = {c: min(other["figures"][c] for other in own) for c in COSTS}
                share = [row["figures"][c] / least[c] for c in COSTS]
                at = np.arange(len(COSTS)) + (k - (len(own) - 1) / 2.0) * width
                panel.bar(at, share, width, label=f"least {row['cost']}")
            panel.set_yscale("log")
            panel.set_xticks(np.arange(len(COSTS)), [COLUMNS[c].rsplit(" ", 1)[0] for c in COSTS])
            label_axes(panel, "", "over the least", f"{robot}, {ROBOTS[robot]} m/s")
        handles, labels = panel.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(COSTS))
        return rendered(figure, "png")


def main() -> None:
    quick = arguments(__doc__).parse_args().quick
    robots = list(ROBOTS)[: 1 if quick else None]
    rows = [walk(robot, cost) for robot in robots for cost in COSTS[: 2 if quick else None]]
    lines = [
        [row["robot"], row["cost"], *(f"{row['figures'][c]:.4g}" for c in COSTS)] for row in rows
    ]
    print(table(("robot", "least", *COLUMNS.values()), lines))
    if not quick:
        PICTURE.write_bytes(picture(rows))
    save("costs", rows, quick)


if __name__ == "__main__":
    main()
