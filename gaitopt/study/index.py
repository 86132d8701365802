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
NOT_COMPUTED = "not computed"

Value = float | int | bool | str | None
Row = dict[str, Value]

_PLACE = ("speed", "duration", "step_length")
_FIGURES = (
    "cost",
    "certified",
    "verdict",
    "worst_violation",
    "kkt",
    "cost_of_transport",
    "cop_to_edge",
    "friction_used",
    "vertical_impulse",
    "impulse_friction_used",
    "iterations",
    "evaluations",
    "seconds",
    "origin",
)
_WORDS = ("status", "verdict", "origin", "file")
_ANSWERS = ("certified",)
_GREATEST = 2**53  # a column of figures holds whole numbers up to this one exactly
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
    return _bare(values, INFEASIBLE, sentence)


def awaited_row(values: Mapping[str, float]) -> Row:
    """Return the line of a point that the sweep has not come to."""
    return _bare(values, NOT_COMPUTED, "the sweep has not come to it; its command goes on")


def faulty_row(row: Row, fault: str, sentence: str) -> Row:
    """Return the line of a gait whose file cannot be used."""
    return {**row, "status": fault, "certified": False, "verdict": sentence}


def _bare(values: Mapping[str, float], status: str, verdict: str) -> Row:
    """Return a line without figures, which has their columns all the same."""
    slopes = (f"slope.{name}" for name in values)
    names = (*_PLACE, *values, "status", *_FIGURES, *slopes)
    row: Row = dict.fromkeys(names)
    return {**row, **values, "status": status, "certified": False, "verdict": verdict}


def fits_column(name: str, value: object) -> bool:
    """Whether a value is one that a column of the index can hold beside those of other lines."""
    if value is None:
        return True
    if name in _WORDS or name in _ANSWERS:
        return isinstance(value, str if name in _WORDS else bool)
    figure = isinstance(value, int | float) and not isinstance(value, bool)
    return figure and (isinstance(value, float) or abs(value) <= _GREATEST)  # type: ignore[arg-type]


def columns(rows: Iterable[Row]) -> list[str]:
    """Return the columns of all rows, those of the fullest first and in its order."""
    fullest_first = sorted(rows, key=len, reverse=True)
    return list(dict.fromkeys(name for row in fullest_first for name in row))


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
    table = pa.table({name: _column(pa, name, [row.get(name) for row in rows]) for name in names})
    buffer = io.BytesIO()
    pq.write_table(table, buffer)
    return buffer.getvalue()


def _column(pa: Any, name: str, values: list[Value]) -> Any:
    """Return a column, with a type even if it has no values yet."""
    if any(value is not None for value in values):
        return pa.array(values)
    return pa.nulls(len(values), pa.string() if name in _WORDS else pa.float64())
