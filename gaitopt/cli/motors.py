"""`gaitopt requirements` and `size`: what motors must deliver over gaits, and which serve them.

Requirements are printed and written as a table (.csv, .xlsx) or a record (.toml); the suffix
decides. The table has a line per motor and gait, then a line per motor over all of them with the
gaits that decide. Torques are in N·m, speeds in rad/s and rpm, powers in W; motors that slide have
columns of their own, forces in N and speeds in m/s.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import fields
from os.path import isdir
from pathlib import Path
from typing import Any

import tomli_w
from rich.console import Console
from rich.table import Table

from gaitopt.actuators.motors import Motor, MotorTable, motors_of, read_motors
from gaitopt.atomic import make_directory, write_atomically
from gaitopt.bounds import percentage
from gaitopt.cli.command_options import RequirementsOptions, SizeOptions
from gaitopt.cli.display import ABSENT, NARROW, fixed, new_table, screen, warn
from gaitopt.cli.process import stop_on_interrupt
from gaitopt.cli.report import print_findings_of
from gaitopt.cli.results import keep_files, require_files, require_writable
from gaitopt.design.options import DesignOptions
from gaitopt.design.process import small_matrices
from gaitopt.design.requirements import (
    FIGURES,
    UNITS,
    USES,
    MotorLoop,
    MotorRequirement,
    MotorUse,
    Requirement,
    motor_uses,
    own_motor_loops,
    requirements_of,
    worst_case,
)
from gaitopt.design.sizing import Choice, read_catalogue, size
from gaitopt.errors import GaitFileError, InputError, MissingExtraError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.result import Gait
from gaitopt.sweep.library import open_library
from gaitopt.sweep.table import csv_bytes
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


def _write(
    each: Sequence[Requirement],
    worst: Sequence[MotorRequirement],
    path: Path,
    uses: Sequence[MotorUse],
) -> Path:
    """Write requirements in the form that the suffix names, atomically."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return write_atomically(path, csv_bytes(_table(each, worst, uses)))
    if suffix == ".toml":
        return write_atomically(path, tomli_w.dumps(_record(each, worst, uses)).encode())
    return write_atomically(path, _xlsx(each, worst, uses))


def _check_suffix(path: Path) -> None:
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


_HEADERS = {
    "peak_torque": "peak\nN·m",
    "speed_at_peak_torque": "at\nrpm",
    "peak_speed": "peak\nrpm",
    "torque_at_peak_speed": "at\nN·m",
    "rms_torque": "RMS\nN·m",
    "peak_power": "power\nW",
    "regenerated_power": "regen.\nW",
    "duty": "duty\n%",
}
_USES = {
    "ratio": "gear\nratio",
    "peak_torque": "peak\nN·m",
    "peak_share": "of peak\n%",
    "rms_torque": "RMS\nN·m",
    "rms_share": "of cont.\n%",
    "peak_speed": "peak\nrpm",
    "voltage_share": "voltage\n%",
    "copper_loss": "loss\nW",
}
_SCALES = {"speed_at_peak_torque": RPM, "peak_speed": RPM, "duty": 0.01}
_COMPARED = tuple(name for name in FIGURES if not name.startswith(("speed_at", "torque_at")))
"""What a change of is told: not what happens to go with a peak."""
_SHARES = {
    "peak_share": "its motor's peak torque",
    "rms_share": "its motor's continuous torque: too hot",
    "voltage_share": "its motor's voltage",
}
_FULL = 1.0 + 1e-6  # of a limit: what is certified may lie on it
_TITLE = "What each motor must deliver over a stride, at its joint or at the crank that it turns"


def run_requirements(asked: RequirementsOptions) -> None:
    """Print requirements on motors, compare those of two designs, write and draw them."""
    output, figure = asked.output, asked.figure
    require_files((output, "--output"), (figure, "--figure"))
    if output is not None:
        _check_suffix(output)
    if figure is not None:
        from gaitopt.view.figure_style import kind_of, write_figure

        kind_of(figure)
    table = None if asked.motors is None else read_motors(asked.motors)
    loops, other = _loops(asked.gait, table), _loops(asked.against, table)
    out = screen()
    width = min(out.width, NARROW)
    each = requirements_of(loops)
    worst = worst_case(each)
    _print_requirements(out, worst, _TITLE)
    uses = [] if table is None else motor_uses(loops, table)
    if uses:
        used = worst_case(uses, USES)
        out.print(use_table(used), width=width)
        out.print()
        beyond = overloads(used)
        for line in beyond:
            warn(out, "too much", line)
        if beyond:
            out.print()
    if len(loops) > 1:
        numbers = {label: str(number) for number, label in enumerate(loops, 1)}
        out.print(deciding_table(worst, numbers), width=width)
        out.print()
        for label, number in numbers.items():
            out.print(f"{number}: {label}")
    if other:
        theirs = worst_case(requirements_of(other))
        _print_requirements(out, theirs, "The other design")
        out.print(difference_table(worst, theirs), width=width)
        out.print()
    if output is not None:
        out.print(f"wrote {_write(each, worst, output, uses)}")
    if figure is not None:
        from gaitopt.view.comparison_figures import torque_speed_figure

        written = write_figure(figure, lambda: torque_speed_figure(loops, table))
        out.print(f"wrote {written}")


def _loops(paths: Sequence[Path], table: MotorTable | None) -> dict[str, list[MotorLoop]]:
    """Return the loops of all gaits in files and libraries, by label."""
    gaits = gaits_of(paths)
    for gait in list(gaits.values())[:1]:
        print_findings_of(gait)
    return {label: own_motor_loops(gait, table) for label, gait in gaits.items()}


def gaits_of(paths: Sequence[Path]) -> dict[str, Gait]:
    """Return all gaits of files and libraries, by label.

    Raises:
        GaitFileError: a path is neither, a gait is damaged, or a library has none.
        InputError: a gait is given twice.
    """
    gaits: dict[str, Gait] = {}
    for path in paths:
        for label, gait in _gaits_in(path).items():
            if label in gaits:
                raise InputError(f"the gait '{label}' is given twice; give it once")
            gaits[label] = gait
    return gaits


def _gaits_in(path: Path) -> dict[str, Gait]:
    if not isdir(path):
        return {str(path): load_gait(path)}
    library = open_library(path)
    done = [point for point in library.grid.order if library.states[point].row is not None]
    if not done:
        raise GaitFileError(f"'{path}' holds no gait yet; give its gaitopt sweep again")
    return {f"{path}: {library.grid.name(point)}": library.gait(point) for point in sorted(done)}


def _print_requirements(out: Console, worst: Sequence[MotorRequirement], title: str) -> None:
    """Print what motors must deliver, a line each: those that turn, then those that slide."""
    for slides in (False, True):
        own = [one for one in worst if one.slides == slides]
        heads = [motion_words(_HEADERS[name], slides=slides) for name in FIGURES]
        if slides:
            title, heads = "Linear motors", [head.replace("rpm", "m/s") for head in heads]
        table = new_table(title, "motor", *(f">{head}" for head in heads))
        for one in own:
            cells = (_cell(name, one.values[name], slides=slides) for name in FIGURES)
            table.add_row(one.motor, *cells)
        if own:
            out.print(table, width=min(out.width, NARROW))
            out.print()


def use_table(worst: Sequence[MotorRequirement]) -> Table:
    """Return the table of what motors must deliver before their gears, and of their limits."""
    table = new_table(
        "Before the gear, and shares of the motor's limits", "motor",
        *(f">{header}" for header in _USES.values()),
    )  # fmt: skip
    sizes = {"peak_speed": RPM, **{name: 0.01 for name in _USES if name.endswith("_share")}}
    for one in worst:
        cells = (
            fixed(one.values[n] / sizes[n], 0) if n in sizes else f"{one.values[n]:.3g}"
            for n in _USES
        )
        table.add_row(one.motor, *cells)
    return table


def overloads(worst: Sequence[MotorRequirement]) -> list[str]:
    """Return a sentence for every limit of a motor that the gaits are beyond."""
    return [
        f"{one.motor} takes {fixed(100.0 * one.values[name], 0)} % of {what}"
        for one in worst
        for name, what in _SHARES.items()
        if one.values[name] > _FULL
    ]


def deciding_table(worst: Sequence[MotorRequirement], numbers: Mapping[str, str]) -> Table:
    """Return the table of the gaits that decide, by their numbers."""
    table = new_table(
        "In which gait", "motor", *(f">{_HEADERS[name].split()[0]}" for name in FIGURES)
    )
    for one in worst:
        table.add_row(one.motor, *(numbers[one.gaits[name]] for name in FIGURES))
    return table


def difference_table(worst: Sequence[MotorRequirement], other: Sequence[MotorRequirement]) -> Table:
    """Return the table of how much more the other design asks of each motor [%]."""
    own, theirs = ({(one.motor, one.slides): one.values for one in of} for of in (worst, other))
    headers = (f">{_HEADERS[name].split()[0]}\n%" for name in _COMPARED)
    table = new_table("How much more the other design asks", "motor", *headers)
    for motor, slides in dict.fromkeys([*own, *theirs]):
        a, b = own.get((motor, slides)), theirs.get((motor, slides))
        alike = [one.values for one in (*worst, *other) if one.slides == slides]
        changes = (
            percentage(a[name], b[name], max(one[name] for one in alike)) if a and b else None
            for name in _COMPARED
        )
        table.add_row(motor, *(ABSENT if one is None else f"{one:+.1f}" for one in changes))
    return table


def _cell(name: str, value: float, *, slides: bool) -> str:
    if slides and "rad" in UNITS[name]:
        return fixed(value, 3)
    shown = value / _SCALES.get(name, 1.0)
    return fixed(shown, 1) if shown < 100.0 else fixed(shown, 0)


MOTOR_FILE = "motors.toml"
_MOST_RESERVE = 10.0


def run_size(asked: SizeOptions) -> None:
    """Choose motors, design the gaits again with them, and write both.

    Raises:
        InputError: bad input, no motor serves, or a file cannot be written.
    """
    directory, reserve = asked.output, asked.reserve
    if not 1.0 <= reserve <= _MOST_RESERVE:
        raise InputError(f"--reserve is {reserve:g}; give 1 (none) to {_MOST_RESERVE:g}")
    require_writable(directory)
    known = read_catalogue(asked.catalogue)
    gaits = gaits_of(asked.gait)
    names = [f"{number}.npz" for number in range(1, len(gaits) + 1)]
    keep_files(directory, (MOTOR_FILE, *names), (*asked.gait, asked.catalogue), _head("size"))
    out = screen()

    def told(choices: tuple[Choice, ...]) -> None:
        names = ", ".join(
            f"{one.motor} {one.drive.motor.name} {one.drive.ratio:.3g}" for one in choices
        )
        out.print(f"chosen: {names}")

    with stop_on_interrupt() as stop, small_matrices():
        found = size(
            gaits, known, DesignOptions(), aim=asked.aim, reserve=reserve, on_round=told, stop=stop
        )
    table = new_table(
        "Motors and gears that serve all gaits", "joints", "motor", ">ratio", ">peak\n%",
        ">RMS\n%", ">voltage\n%", ">loss\nW",
    )  # fmt: skip
    for one in found.choices:
        shares = (one.peak_share, one.rms_share, one.voltage_share)
        table.add_row(
            one.motor, one.drive.motor.name, f"{one.drive.ratio:.4g}",
            *(f"{100.0 * share:.0f}" for share in shares), f"{one.loss:.1f}",
        )  # fmt: skip
    out.print(table, width=min(out.width, NARROW))
    loss = sum(len(one.joints) * one.loss for one in found.choices)
    out.print(f"motors of both sides: {found.mass:.3g} kg, {loss:.3g} W copper loss in the mean")
    if not found.settled:
        out.print(
            f"after {found.rounds} rounds the gaits would still choose other motors; those in the "
            "table serve the gaits written"
        )
    make_directory(directory)
    text = motors_text(found.table, "size")
    motors_of(text)
    written = write_atomically(directory / MOTOR_FILE, text.encode())  # first: it marks the others
    for name, (label, gait) in zip(names, found.gaits.items(), strict=True):
        verdict = "certified" if gait.certified else "not certified"
        path = save_gait(gait, directory / name)
        out.print(f"{path}: {label}, {gait.cost:.6g} {gait.cost_unit}, {verdict}")
    out.print(f"wrote {written}")


def motors_text(table: MotorTable, command: str) -> str:
    """Return drives as a table of motors, `motors.toml`.

    Args:
        command: that chose them.
    """
    used = {one.motor.name: one.motor for one in table.drives}
    motors = {
        name: {part.name: getattr(motor, part.name) for part in fields(Motor)
               if part.name != "name"}
        for name, motor in used.items()
    }  # fmt: skip
    drives: list[dict[str, Any]] = [
        {
            "joints": one.joints, "motor": one.motor.name, "ratio": one.ratio,
            "efficiency": one.efficiency, "friction": one.friction,
        }
        for one in table.drives
    ]  # fmt: skip
    return _head(command) + tomli_w.dumps({"motors": motors, "drives": drives})


def _head(command: str) -> str:
    return f"# Motors and gears that gaitopt {command} chose; for --motors. SI units.\n\n"
