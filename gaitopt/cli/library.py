"""`gaitopt library`: what a gait library holds, drawn, and a gait between its gaits."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import typer

from gaitopt.cli.cells import new_table
from gaitopt.cli.display import screen
from gaitopt.cli.paths import require_files
from gaitopt.cli.process import ExitCode
from gaitopt.cli.report import print_findings_of, print_gait
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.gait_file import save_gait
from gaitopt.gait.plugin import extension_record
from gaitopt.gait.result import Gait
from gaitopt.settings import named_values
from gaitopt.sweep.interpolate import interpolate, stored_point
from gaitopt.sweep.library import Library, open_library
from gaitopt.sweep.table import NOT_COMPUTED, Row, Value, columns, selected, unknown_column
from gaitopt.view.visible import visible

LIST = "list"  # in place of columns: what there is
SHOWN = ("status", "cost", "step_length", "cop_to_edge", "friction_used", "vertical_impulse")


def run_list(directory: Path, where: list[str], names: str | None, plot: Path | None) -> None:
    """Show the index, or draw it.

    Raises:
        GaitFileError: the directory is no gait library.
        InputError: a condition or a column cannot be used, or the figure cannot be written.
    """
    library = open_library(directory)
    _tell_robot(library)
    if names == LIST:
        for name in columns(library.rows):
            screen().print(visible(name), soft_wrap=True)
        return
    rows = selected(library.rows, where)
    if plot is not None:
        from gaitopt.view.library_figures import write_library_figure

        write_library_figure(
            rows, [axis.name for axis in library.points.axes], plot, _cost(library)
        )
        screen().print(f"wrote {plot}")
        return
    _show(library, rows, _columns(library, names))


def _cost(library: Library) -> tuple[str, str]:
    """Return words and unit of the cost of a library; those of version 0.1 do not say it."""
    task = library.record["first task"]
    cost = task.get("cost") if isinstance(task, Mapping) else None
    record = cost if isinstance(cost, Mapping) else extension_record(TorqueCost())
    return str(record.get("words")), str(record.get("unit"))


def run_at(directory: Path, at: list[str], output: Path | None) -> None:
    """Design a gait between those of the library, show it, write it.

    Raises:
        GaitoptError: it is outside the library, or there is none.
        typer.Exit: it is not certified.
    """
    require_files((output, "--output"))
    gait, said = _gait_at(open_library(directory), named_values(at, "--at"))
    print_findings_of(screen(stderr=True), gait)
    out = screen()
    print_gait(out, gait)
    out.print(said, soft_wrap=True)
    if output is not None:
        save_gait(gait, output)
        out.print(f"wrote {output}")
    if not _certified(gait):
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


def _tell_robot(library: Library) -> None:
    """Tell what is odd about the robot, as the first gait that is there records it."""
    for point in library.state.rows:
        with suppress(GaitFileError):
            print_findings_of(screen(stderr=True), library.gait(point))
            return


def _gait_at(library: Library, values: dict[str, float]) -> tuple[Gait, str]:
    """Return the gait at a place, and where it comes from."""
    point = stored_point(library, values)
    if point is not None and _certified(stored := library.gait(point)):
        return stored, f"the stored gait of {library.points.name(point)}; nothing was interpolated"
    found = interpolate(library, values)
    if point is None:
        return found.design.gait, f"between {' and '.join(found.sources)}; {found.sentence}"
    return found.design.gait, (
        f"the stored gait of {found.sources[0]} is not certified; designed again from there"
    )


def _certified(gait: Gait) -> bool:
    return gait.fact("certificate", "certified") is True


def _columns(library: Library, names: str | None) -> list[str]:
    """Return what to show: first what was swept over."""
    known = columns(library.rows)
    axes = [axis.name for axis in library.points.axes]
    if names is None:
        return [n for n in dict.fromkeys((*axes, *SHOWN)) if n in known]
    chosen = [name.strip() for name in names.split(",") if name.strip()]
    for name in chosen:
        if name not in known:
            raise InputError(unknown_column(name, known))
    return [*(axis for axis in axes if axis not in chosen), *chosen]


def _show(library: Library, rows: list[Row], names: list[str]) -> None:
    table = new_table("", *(f">{visible(name)}" for name in names))
    table.expand = False
    for row in rows:
        table.add_row(*(_cell(row.get(name)) for name in names))
    out = screen()
    out.print(table)
    total, there = len(library.points.order), _computed(library.rows)
    left = "" if there == total else f"; {total - there} of {total} points are not computed yet"
    out.print(f"{_computed(rows)} of {there} gaits{left}")
    if broken := len(library.faults):
        told = "1 gait has" if broken == 1 else f"{broken} gaits have"
        out.print(
            f"{told} no usable file, see status; give the command of the sweep again to have what "
            "is missing made anew",
            soft_wrap=True,
        )  # fmt: skip


def _computed(rows: list[Row]) -> int:
    return sum(row["status"] != NOT_COMPUTED for row in rows)


def _cell(value: Value) -> str:
    if isinstance(value, float):
        return f"{value:.6g}"
    return "-" if value is None else visible(str(value))
