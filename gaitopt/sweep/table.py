"""The table of a gait library: one line per point, its files, and conditions on it."""

from __future__ import annotations

import csv
import io
import operator
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from gaitopt.atomic import write_atomically
from gaitopt.design.pipeline import Design
from gaitopt.design.summary import motor_summaries, of_walk
from gaitopt.errors import InputError, did_you_mean
from gaitopt.gait.costs import TorqueCost
from gaitopt.sweep.continuation import WarmStart
from gaitopt.sweep.grid import quantity_unit
from gaitopt.units import in_si, read_number

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
    "peak_torque_Nm": ("peak_torque", "N·m"),
    "rms_torque_Nm": ("rms_torque", "N·m"),
    "peak_speed_rad_per_s": ("peak_speed", "rad/s"),
    "peak_force_N": ("peak_force", "N"),
    "rms_force_N": ("rms_force", "N"),
    "peak_speed_m_per_s": ("peak_linear_speed", "m/s"),
    "peak_power_W": ("peak_power", "W"),
}
MOTOR_UNITS = dict(_MOTOR.values())
"""Of the columns that motors have, as "peak_torque.knee"; those that slide have the linear ones."""
_UNITS = {
    **MOTOR_UNITS,
    "speed": "m/s",
    "duration": "s",
    "step_length": "m",
    "cop_to_edge": "m",
    "vertical_impulse": "N·s",
    "seconds": "s",
}
_DIGITS = 4  # of figures for people


def unit_of(column: str, cost: str = TorqueCost().unit) -> str:
    """Return the unit of a column, empty where it has none.

    Args:
        column: its name; a slope has the unit of the cost over that of its quantity.
        cost: unit of the cost.
    """
    if column.startswith("slope."):
        unit = unit_of(column.removeprefix("slope."))
        return f"{cost} per {unit}" if unit else cost
    if column in ("cost", "penalty_weight"):
        return cost if column == "cost" else f"{cost}/m²"
    name = column.split(".")[0] if column.split(".")[0] in MOTOR_UNITS else column
    return _UNITS.get(name) or quantity_unit(name)


def cell(value: Value) -> str:
    """Return a value as text for people: figures with four digits, nothing as a dash."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.{_DIGITS}g}"
    return "-" if value is None else str(value)


def gait_row(found: Design, walk: WarmStart, values: Mapping[str, float], seconds: float) -> Row:
    """Return the line of a gait; SI units.

    Args:
        walk: from which it was finished; its work is counted, its cost gradient is given.
        seconds: of processor, for everything.
    """
    facts: Any = of_walk(found.gait)
    step, contact, impact = facts["walk"], facts["contact"], facts["impact"]
    certificate, solution = found.certificate, found.solution
    edges = contact["cop_to_edge_mm"]
    row: Row = {
        "speed": step["speed_m_per_s"],
        "duration": step["step_duration_s"],
        "step_length": step["step_length_m"],
        **values,
        "status": CERTIFIED if certificate.certified else NOT_CERTIFIED,
        "cost": solution.cost,
        "certified": certificate.certified,
        "verdict": certificate.verdict,
        "worst_violation": certificate.worst.violation,
        "kkt": certificate.kkt.worst,
        "cost_of_transport": step["mechanical_cost_of_transport"],
        "cop_to_edge": None if edges is None else 1e-3 * min(edges.values()),
        "friction_used": contact["friction_used"],
        "vertical_impulse": impact["vertical_impulse_Ns"],
        "impulse_friction_used": impact["friction_used"],
        "iterations": walk.iterations + solution.iterations,
        "evaluations": walk.evaluations + solution.evaluations,
        "seconds": seconds,
        "origin": walk.origin,
    }
    row |= {f"slope.{k}": s for k, s in zip(values, walk.cost_gradient, strict=True)}
    return row | motor_columns(motor_summaries(found.gait))


def motor_columns(motors: Iterable[Mapping[str, Any]]) -> Row:
    """Return the columns of `motor_summaries`, as "peak_torque.knee" and "peak_force.inner"."""
    return {
        f"{column}.{motor['joint'].replace(' ', '_')}": motor[key]
        for motor in motors
        for key, (column, _) in _MOTOR.items()
        if key in motor
    }


def faulty_row(row: Row, fault: str, sentence: str) -> Row:
    """Return the line of a gait whose file cannot be used."""
    return {**row, "status": fault, "certified": False, "verdict": sentence}


def bare_row(values: Mapping[str, float], status: str, verdict: str) -> Row:
    """Return a line without figures, which has their columns all the same."""
    slopes = (f"slope.{name}" for name in values)
    names = (*_PLACE, *values, "status", *_FIGURES, *slopes)
    row: Row = dict.fromkeys(names)
    return {**row, **values, "status": status, "certified": False, "verdict": verdict}


def fits_column(name: str, value: object) -> bool:
    """Whether a value is one that a column of the table can hold beside those of other lines."""
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


def csv_bytes(rows: Iterable[Iterable[object]]) -> bytes:
    """Return rows as comma-separated values, None as nothing between commas."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


def write_table(rows: Sequence[Row], directory: Path) -> list[Path]:
    """Write the table as CSV, and as Parquet if pyarrow is installed; return what was written.

    Raises:
        InputError: the directory cannot be written.
    """
    names = columns(rows)
    data = csv_bytes([names, *([row.get(name) for name in names] for row in rows)])
    written = [write_atomically(directory / CSV, data)]
    table = _parquet(data, {name: [row.get(name) for row in rows] for name in names})
    if table is not None:
        written.append(write_atomically(directory / PARQUET, table))
    return written


def _parquet(data: bytes, values: Mapping[str, Sequence[Value]]) -> bytes | None:
    """Return a table of CSV as Parquet; pyarrow makes columns of lists only with pandas at hand."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
        from pyarrow import csv as pc
    except ImportError:  # the extra "tables" is not installed: CSV must do
        return None
    kinds = {name: _kind(pa, name, column) for name, column in values.items()}
    how = pc.ConvertOptions(column_types=kinds, null_values=[""], strings_can_be_null=True)
    whole = pc.ReadOptions(use_threads=False)
    parts = pc.ParseOptions(newlines_in_values=True)
    table = pc.read_csv(io.BytesIO(data), whole, parts, how)
    buffer = io.BytesIO()
    pq.write_table(table, buffer)
    return buffer.getvalue()


def _kind(pa: Any, name: str, values: Sequence[Value]) -> Any:
    """Return the type of a column, also of one that has no values yet."""
    if name in _WORDS or name in _ANSWERS:
        return pa.string() if name in _WORDS else pa.bool_()
    known = [value for value in values if value is not None]
    return pa.int64() if known and all(isinstance(v, int) for v in known) else pa.float64()


_CONDITION = re.compile(r"\s*([\w.]+)\s*(<=|>=|==|!=|<|>|=)\s*(.+?)\s*")
_COMPARE: dict[str, Callable[[Any, Any], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "=": operator.eq,
    "==": operator.eq,
    "!=": operator.ne,
}
_TRUTH = {"true": True, "false": False}
_JOIN = re.compile(r"(?:^|\s+)and(?:\s+|$)")
_STRAY = re.compile(r"[<>=!&|]|\bor\b")  # in a value without quotes: part of another condition
_FORM = (
    'give a column, one of < <= > >= = !=, and a value, as "speed>0.8" or "status=certified"; '
    "several are joined by 'and' only"
)


def selected(rows: Iterable[Row], conditions: Iterable[str]) -> list[Row]:
    """Return the lines that meet every condition; one without the quantity meets none of it.

    Args:
        rows: of a table.
        conditions: each a column, one of < <= > >= = !=, and a number or a word; several joined by
            "and" are several.

    Raises:
        InputError: a condition cannot be understood, or there is no such column.
    """
    every = list(rows)
    kept = every
    for text in conditions:
        for condition in _JOIN.split(text.strip()):
            name, sign, value = _parsed(condition, text, every)
            kept = [row for row in kept if _meets(row.get(name), sign, value)]
    return kept


def _parsed(condition: str, whole: str, rows: list[Row]) -> tuple[str, str, Value]:
    """Return column, sign and value of one condition of a text, which may hold several."""
    found = _CONDITION.fullmatch(condition)
    if found is None or (found[3][0] not in "'\"" and _STRAY.search(found[3])):
        raise InputError(f"'{condition or whole}' is no condition; {_FORM}")
    name, sign, text = found.groups()
    names = columns(rows)
    if names and name not in names:
        raise InputError(unknown_column(name, names))
    value = _value(in_si(text.strip("'\""), unit_of(name)))
    there = [row[name] for row in rows if row.get(name) is not None]
    if there and value != value:
        raise InputError(f"'{condition}' compares with no number; {_FORM}")
    if there and not any(isinstance(v, str) == isinstance(value, str) for v in there):
        kind = "numbers" if isinstance(value, str) else f"words, as '{there[0]}'"
        raise InputError(f"'{condition}' is no condition: {name} holds {kind}; {_FORM}")
    return name, sign, value


def unknown_column(name: str, names: list[str]) -> str:
    """Return the sentence that there is no such column, with the names nearest to it."""
    hint = did_you_mean(name, names)
    return f"there is no column '{name}'; {hint}'gaitopt library DIR --columns list' lists all"


def _value(word: object) -> Value:
    try:
        return read_number(str(word))
    except ValueError:
        return _TRUTH.get(str(word).lower(), str(word))


def _meets(there: Value, sign: str, value: Value) -> bool:
    if there is None:
        return False
    if isinstance(there, str) != isinstance(value, str):
        return sign == "!="
    return bool(_COMPARE[sign](there, value))
