"""Requirements on motors as files: a table (.csv, .xlsx) or a record (.toml); the suffix decides.

The table has a line per motor and gait, then a line per motor over all of them with the gaits that
decide. Torques are in N·m, speeds in rad/s and rpm, powers in W; motors that slide have columns of
their own, forces in N and speeds in m/s.
"""

from __future__ import annotations

import csv
import io
import tempfile
from collections.abc import Mapping, Sequence
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
from gaitopt.units import RPM, motion_words

ALL = "all"
"""In place of a gait: over all of them."""
SUFFIXES = (".csv", ".toml", ".xlsx")

Cell = str | float


def _columns(name: str, *, slides: bool) -> dict[str, float]:
    """Return the columns of a figure with the sizes of their units; a turning speed has two."""
    unit, told = (motion_words(words, slides=slides) for words in (UNITS[name], name))
    units = {"rad/s": 1.0, "rpm": RPM} if unit == "rad/s" else {unit: 1.0}
    return {f"{told} [{unit}]" if unit else told: size for unit, size in units.items()}


def _line(motor: str, gait: str, values: Mapping[str, float], *, slides: bool) -> dict[str, Cell]:
    """Return a line by its columns."""
    return {"motor": motor, "gait": gait} | {
        column: values[name] / size
        for name in FIGURES
        for column, size in _columns(name, slides=slides).items()
    }


def _table(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> list[list[Cell]]:
    """Return header and lines; figures before the gear at the end of each, where there are any."""
    lines = [_line(o.motor, o.gait, _values(o), slides=o.slides) for o in each]
    whole = [_line(o.motor, ALL, o.values, slides=o.slides) for o in worst]
    decided: list[dict[str, Cell]] = [
        {
            f"{motion_words(name, slides=one.slides)} in gait": gait
            for name, gait in one.gaits.items()
        }
        for one in worst
    ]
    header = list(dict.fromkeys(c for of in (whole, decided) for line in of for c in line))
    lines += [line | gaits for line, gaits in zip(whole, decided, strict=True)]
    rows: list[list[Cell]] = [[*header], *([line.get(c, "") for c in header] for line in lines)]
    if not uses:
        return rows
    known = {(one.motor, one.gait): [float(getattr(one, n)) for n in USES] for one in uses}
    known |= {(o.motor, ALL): [o.values[n] for n in USES] for o in worst_case(uses, USES)}
    rows[0] += [
        f"{name} before gear" + (f" [{unit}]" if unit else "") for name, unit in USES.items()
    ]
    for row in rows[1:]:
        row += known.get((str(row[0]), str(row[1])), [""] * len(USES))
    return rows


def _values(of: Requirement) -> dict[str, float]:
    return {name: float(getattr(of, name)) for name in FIGURES}


def write_requirements(
    each: Sequence[Requirement],
    worst: Sequence[MotorRequirement],
    path: Path,
    uses: Sequence[MotorUse] = (),
) -> Path:
    """Write requirements, atomically.

    Raises:
        InputError: the suffix is unknown, or the path cannot be written.
        MissingExtraError: it is .xlsx, and openpyxl is not installed.
    """
    check_suffix(path)
    suffix = path.suffix.lower()
    if suffix == ".csv":
        buffer = io.StringIO()
        csv.writer(buffer, lineterminator="\n").writerows(_table(each, worst, uses))
        return write_atomically(path, buffer.getvalue().encode())
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


def _record(
    each: Sequence[Requirement], worst: Sequence[MotorRequirement], uses: Sequence[MotorUse]
) -> dict[str, dict[str, Any]]:
    record: dict[str, dict[str, Any]] = {}
    for motor in worst:
        told = {name: motion_words(name, slides=motor.slides) for name in FIGURES}
        record[motor.motor] = {
            **{told[name]: value for name, value in motor.values.items()},
            "decided_by": {told[name]: gait for name, gait in motor.gaits.items()},
            "gaits": {
                one.gait: {told[name]: value for name, value in _values(one).items()}
                for one in each
                if one.motor == motor.motor
            },
        }
        if motor.slides:
            record[motor.motor]["units"] = {
                told[name]: motion_words(unit, slides=True) or "1" for name, unit in UNITS.items()
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
