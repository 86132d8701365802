"""The index of a gait library: one line per point, for spreadsheets and data frames."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gaitopt.atomic import write_atomically
from gaitopt.design.design import Design
from gaitopt.design.summary import summarise
from gaitopt.study.footing import Footing

CSV, PARQUET = "index.csv", "index.parquet"
CERTIFIED, NOT_CERTIFIED, INFEASIBLE = "certified", "not certified", "infeasible"

Value = float | int | bool | str | None
Row = dict[str, Value]

_MOTOR = {
    "peak_torque_Nm": "peak_torque",
    "rms_torque_Nm": "rms_torque",
    "peak_speed_rad_per_s": "peak_speed",
    "peak_power_W": "peak_power",
}


def index_row(found: Design, footing: Footing, values: Mapping[str, float], seconds: float) -> Row:
    """Return the line of a gait; SI units.

    Args:
        found: the gait.
        footing: where it came from; its work is counted, its slopes are given.
        values: of the swept quantities.
        seconds: of processor, for everything.
    """
    facts: Any = summarise(found.gait)
    walk, contact, impact = facts["walk"], facts["contact"], facts["impact"]
    certificate, solution = found.certificate, found.solution
    edges = contact["cop_to_edge_mm"]
    row: Row = {
        "speed": walk["speed_m_per_s"],
        "duration": walk["step_duration_s"],
        "step_length": walk["step_length_m"],
        **values,
        "status": CERTIFIED if certificate.certified else NOT_CERTIFIED,
        "cost": solution.cost,
        "certified": certificate.certified,
        "verdict": certificate.verdict,
        "worst_violation": certificate.worst.violation,
        "kkt": certificate.kkt.worst,
        "cost_of_transport": walk["mechanical_cost_of_transport"],
        "cop_to_edge": None if edges is None else 1e-3 * min(edges.values()),
        "friction_used": contact["friction_used"],
        "vertical_impulse": impact["vertical_impulse_Ns"],
        "impulse_friction_used": impact["friction_used"],
        "iterations": footing.iterations + solution.iterations,
        "evaluations": footing.evaluations + solution.evaluations,
        "seconds": seconds,
        "origin": footing.origin,
    }
    row |= {f"slope.{k}": s for k, s in zip(values, footing.slopes, strict=True)}
    for motor in facts["motors"]:
        joint = str(motor["joint"]).replace(" ", "_")
        row |= {f"{column}.{joint}": motor[key] for key, column in _MOTOR.items()}
    return row


def refused_row(values: Mapping[str, float], sentence: str) -> Row:
    """Return the line of a point where no gait was found."""
    return {**values, "status": INFEASIBLE, "certified": False, "verdict": sentence}


def columns(rows: Iterable[Row]) -> list[str]:
    """Return the columns of all rows, in the order of the first that has each."""
    return list(dict.fromkeys(name for row in rows for name in row))


def write_index(rows: Sequence[Row], directory: Path) -> list[Path]:
    """Write the index as CSV, and as Parquet if pyarrow is installed; return what was written.

    Raises:
        InputError: the directory cannot be written.
    """
    names = columns(rows)
    text = io.StringIO()
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    written = [write_atomically(directory / CSV, text.getvalue().encode())]
    table = _parquet(rows, names)
    if table is not None:
        written.append(write_atomically(directory / PARQUET, table))
    return written


def _parquet(rows: Sequence[Row], names: list[str]) -> bytes | None:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:  # the extra "tables" is not installed: CSV must do
        return None
    table = pa.table({name: [row.get(name) for row in rows] for name in names})
    buffer = io.BytesIO()
    pq.write_table(table, buffer)
    return buffer.getvalue()
