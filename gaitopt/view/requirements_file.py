"""Requirements on motors as files: a table (.csv, .xlsx) or a record (.toml); the suffix decides.

The table has a line per motor and gait, then a line per motor over all of them with the gaits that
decide. Torques are in N·m, speeds in rad/s and rpm, powers in W.
"""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from gaitopt.atomic import write_atomically
from gaitopt.design.requirements import (
    FIGURES,
    UNITS,
    USES,
    MotorRequirement,
    MotorUse,
    Requirement,
    worst_case,
)
from gaitopt.errors import InputError, MissingExtraError
from gaitopt.units import UNITS as KNOWN_UNITS

RPM = KNOWN_UNITS["rad/s"]["rpm"]
"""One turn a minute [rad/s]."""
ALL = "all"
"""In place of a gait: over all of them."""
_UNIT_OF_USE = {
    "ratio": "",
    "peak_torque": "N·m",
    "peak_share": "",
    "rms_torque": "N·m",
    "rms_share": "",
    "peak_speed": "rad/s",
    "voltage_share": "",
    "copper_loss": "W",
}
SUFFIXES = (".csv", ".toml", ".xlsx")

Cell = str | float


def column_names() -> list[str]:
    """Return the header of the table, with units; figures that are speeds come twice."""
    names = ["motor", "gait"]
    for name in FIGURES:
        units = ("rad/s", "rpm") if UNITS[name] == "rad/s" else (UNITS[name],)
        names += [f"{name} [{unit}]" if unit else name for unit in units]
    return [*names, *(f"{name} in gait" for name in FIGURES)]


def table_rows(each: Sequence[Requirement], worst: Sequence[MotorRequirement]) -> list[list[Cell]]:
    """Return the lines of the table under its header."""
    rows: list[list[Cell]] = []
    for one in each:
        values = [float(getattr(one, name)) for name in FIGURES]
        rows.append([one.motor, one.gait, *_with_rpm(values), *([""] * len(FIGURES))])
    for motor in worst:
        values = [motor.values[name] for name in FIGURES]
        deciding = [motor.gaits[name] for name in FIGURES]
        rows.append([motor.motor, ALL, *_with_rpm(values), *deciding])
    return rows


def _table(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> list[list[Cell]]:
    """Return header and lines; figures before the gear at the end of each, where there are any."""
    rows: list[list[Cell]] = [[*column_names()], *table_rows(each, worst)]
    if not uses:
        return rows
    known = {(one.motor, one.gait): [float(getattr(one, n)) for n in USES] for one in uses}
    known |= {(o.motor, ALL): [o.values[n] for n in USES] for o in worst_case(uses, USES)}
    header = [f"{name} before gear" for name in _UNIT_OF_USE]
    rows[0] += [
        f"{name} [{unit}]" if unit else name
        for name, unit in zip(header, _UNIT_OF_USE.values(), strict=True)
    ]
    for row in rows[1:]:
        row += known.get((str(row[0]), str(row[1])), [""] * len(USES))
    return rows


def _with_rpm(values: Sequence[float]) -> list[Cell]:
    cells: list[Cell] = []
    for name, value in zip(FIGURES, values, strict=True):
        cells += [value, value / RPM] if UNITS[name] == "rad/s" else [value]
    return cells


def write_requirements(
    each: Sequence[Requirement],
    worst: Sequence[MotorRequirement],
    path: Path,
    uses: Sequence[MotorUse] = (),
) -> Path:
    """Write requirements, atomically.

    Args:
        each: of every motor in every gait.
        worst: of every motor over all gaits.
        path: file; its suffix chooses the form.
        uses: what every gait asks of every motor before its gear.

    Returns:
        The path written.

    Raises:
        InputError: the suffix is unknown, or the path cannot be written.
        MissingExtraError: it is .xlsx, and openpyxl is not installed.
    """
    check_suffix(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return write_atomically(path, _csv(each, worst, uses).encode())
    if suffix == ".toml":
        return write_atomically(path, tomli_w.dumps(_record(each, worst, uses)).encode())
    return write_atomically(path, _xlsx(each, worst, uses))


def check_suffix(path: Path) -> None:
    """Check that requirements can be written in the form that a file's suffix names.

    Raises:
        InputError: they cannot.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(
            f"cannot write requirements to '{path}': the suffix must be one of "
            f"{', '.join(SUFFIXES)}"
        )


def _csv(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerows(_table(each, worst, uses))
    return buffer.getvalue()


def _record(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> dict[str, dict[str, Any]]:
    record: dict[str, dict[str, Any]] = {}
    for motor in worst:
        record[motor.motor] = {
            **motor.values,
            "decided_by": dict(motor.gaits),
            "gaits": {
                one.gait: {name: getattr(one, name) for name in FIGURES}
                for one in each
                if one.motor == motor.motor
            },
        }
        before = [use for use in uses if use.motor == motor.motor]
        if before:
            record[motor.motor]["before_gear"] = {
                use.gait: {name: getattr(use, name) for name in USES} for use in before
            }
    return {"units": {name: unit or "1" for name, unit in UNITS.items()}, "motors": record}


def _xlsx(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> bytes:
    try:
        from openpyxl import Workbook
    except ImportError as error:
        raise MissingExtraError("writing .xlsx", "tables") from error
    book = Workbook()
    sheet = book.active
    sheet.title = "requirements"
    for row in _table(each, worst, uses):
        sheet.append([_text(cell) for cell in row])
    sheet.freeze_panes = "C2"
    buffer = io.BytesIO()
    try:
        book.save(buffer)
    except Exception as error:  # lxml, where openpyxl has it, has an error of its own
        raise InputError(
            f"cannot make the table: {str(error) or type(error).__name__}; make room for files in "
            f"'{tempfile.gettempdir()}', or write .csv"
        ) from error
    return buffer.getvalue()


def _text(cell: Cell) -> Cell:
    """Return a cell; a text that a spreadsheet would take for a formula with a quote before it."""
    return f"'{cell}" if isinstance(cell, str) and cell[:1] in ("=", "+", "-", "@") else cell
