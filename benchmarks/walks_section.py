"""The tables on simulated walks and on the second engine."""

from __future__ import annotations

from tables import Record, table

_BESIDE = ("torque", "wrench", "impact")


def second_engine(data: list[Record]) -> str:
    """Both engines, robot by robot."""
    rows = [
        (
            row["robot"], str(row["joints"]), *(f"{row[name]:.0e}" for name in _BESIDE),
            row["own_inertias"],
        )
        for row in data
        if "refused" not in row
    ]  # fmt: skip
    worst = max(row[name] for row in data if "refused" not in row for name in _BESIDE)
    head = ("robot", "joints", "torque", "force and moment of the ground", "impact",
            "the file's own inertias")  # fmt: skip
    return (
        "MuJoCo's `mj_inverse` along the first guess of each robot's default walk, at 61 instants, "
        f"differs from the gait's own numbers by at most {worst:.0e} of the largest of their kind "
        "(1e-9 is what agrees). Both have the robot with left and right averaged; the last column "
        "says by how much that changed what the file has, over the range of the legs.\n\n"
        + table(head, rows)
    )
