"""Requirements on motors as files: a table (.csv, .xlsx) or a record (.toml); the suffix decides.

The table has a line per motor and gait, then a line per motor over all of them with the gaits that
decide. Torques are in N·m, speeds in rad/s and rpm, powers in W.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from gaitopt.atomic import write_atomically
from gaitopt.design.requirements import FIGURES, UNITS, MotorRequirement, Requirement
from gaitopt.errors import InputError, MissingExtraError
from gaitopt.units import UNITS as KNOWN_UNITS

RPM = KNOWN_UNITS["rad/s"]["rpm"]
"""One turn a minute [rad/s]."""
ALL = "all"
"""In place of a gait: over all of them."""
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


def _with_rpm(values: Sequence[float]) -> list[Cell]:
    cells: list[Cell] = []
    for name, value in zip(FIGURES, values, strict=True):
        cells += [value, value / RPM] if UNITS[name] == "rad/s" else [value]
    return cells


def write_requirements(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], path: Path
) -> Path:
    """Write requirements, atomically.

    Args:
        each: of every motor in every gait.
        worst: of every motor over all gaits.
        path: file; its suffix chooses the form.

    Returns:
        The path written.

    Raises:
        InputError: the suffix is unknown, or the path cannot be written.
        MissingExtraError: it is .xlsx, and openpyxl is not installed.
    """
    check_suffix(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return write_atomically(path, _csv(each, worst).encode())
    if suffix == ".toml":
        return write_atomically(path, tomli_w.dumps(_record(each, worst)).encode())
    return write_atomically(path, _xlsx(each, worst))


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


def _csv(each: Sequence[Requirement], worst: Sequence[MotorRequirement]) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(column_names())
    writer.writerows(table_rows(each, worst))
    return buffer.getvalue()


def _record(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement]
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
    return {"units": {name: unit or "1" for name, unit in UNITS.items()}, "motors": record}


def _xlsx(each: Sequence[Requirement], worst: Sequence[MotorRequirement]) -> bytes:
    try:
        from openpyxl import Workbook
    except ImportError as error:
        raise MissingExtraError("writing .xlsx", "tables") from error
    book = Workbook()
    sheet = book.active
    sheet.title = "requirements"
    rows: list[Sequence[Cell]] = [column_names(), *table_rows(each, worst)]
    for row in rows:
        sheet.append([_text(cell) for cell in row])
    sheet.freeze_panes = "C2"
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def _text(cell: Cell) -> Cell:
    """Return a cell; a text that a spreadsheet would take for a formula with a quote before it."""
    return f"'{cell}" if isinstance(cell, str) and cell[:1] in ("=", "+", "-", "@") else cell
