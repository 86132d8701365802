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


def walks(data: Record) -> str:
    """A hundred steps of many robots, every way, defaults, a library, and what is survived."""
    titles = {
        "robust": "Preset `robust`", "ways": "Every way, 20 steps",
        "default": "Without further options, 20 steps",
        "library": f"A library of the biped, `robust`: {100.0 * data['share']:.0f} % walk",
    }  # fmt: skip
    parts = [f"{title}:\n\n{walk_table(data[name])}" for name, title in titles.items()]
    checks = data["checks"]
    passed = sum(one["passed"] for one in checks)
    pushes = ", ".join(f"{size:.0f} N·s {way}" for way, size in data["pushes_Ns"].items())
    parts.append(
        f"The robust biped at 1.0 m/s passes {passed} of {len(checks)} checks, survives "
        f"pushes of {pushes}, and walks from {data['starts']} starts. Costs are in "
        "N²·m·s, in place per second, N²·m²; times are of the processor, and left out where rows "
        "were renewed on a machine that others used too."
    )
    disturbed = [
        [one["name"], "walks on" if one["passed"] else "falls or stumbles",
         *_numbers(one, ("speed_ratio", "cost_ratio"))]
        for one in checks
    ]  # fmt: skip
    parts.append(
        table(("disturbed by", "ends", "last speed / designed", "cost / designed"), disturbed)
    )
    return "\n\n".join(parts)


def walk_table(rows: list[Record]) -> str:
    """Simulated walks, a line each."""
    head = ("gait", "steps", "speed / designed", "cost / designed", "designed cost",
            "times real time", "second engine", "cause of a fall")  # fmt: skip
    return table(head, map(_walk, rows))


def _walk(row: Record) -> list[str]:
    name = f"{row['robot']} {row['speed']:.2f} m/s"
    if "steps" not in row:
        return [name, "no walk", *[""] * 5, row["verdict"]]
    shown = _numbers(row, ("speed_ratio", "cost_ratio", "designed_cost", "real_time"))
    steps = f"{row['steps']} of {row['asked']}"
    return [name, steps, *shown, f"{row['second_engine']:.0e}", row["cause"]]


def _numbers(row: Record, keys: tuple[str, ...]) -> list[str]:
    return ["-" if row[key] is None else f"{row[key]:.4g}" for key in keys]
