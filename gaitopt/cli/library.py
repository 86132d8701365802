"""`gaitopt library`: what gait libraries hold, compared, drawn, and a gait between their gaits."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

import typer
from rich.table import Table

from gaitopt.bounds import percentage
from gaitopt.cli.command_options import LibraryOptions
from gaitopt.cli.display import ABSENT, NARROW, new_table, screen
from gaitopt.cli.process import ExitCode, refuse_options
from gaitopt.cli.report import print_findings_of, print_gait
from gaitopt.cli.results import require_files
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitFileError, InputError
from gaitopt.escape import printable
from gaitopt.gait.gait_file import save_gait
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.result import Gait
from gaitopt.settings import named_values
from gaitopt.sweep.grid import read_named
from gaitopt.sweep.interpolation import interpolate, stored_point
from gaitopt.sweep.library import Library, open_library
from gaitopt.sweep.table import (
    NOT_COMPUTED,
    Row,
    Value,
    cell,
    columns,
    selected,
    unit_of,
    unknown_column,
)

LIST = "list"  # in place of columns: what there is
_MOTORS = "peak_torque."
_MORE = ("peak_power.", "friction_used", "cop_to_edge", "step_length")
_LINE = 6  # characters of a line of a header that are not broken further
_GAP = 2  # between two columns


def run(asked: LibraryOptions) -> None:
    """Show libraries, or design a gait between those of one."""
    if asked.at:
        shows = {"--where": asked.where, "--columns": asked.columns, "--plot": asked.plot}
        refuse_options(shows, "without --at, which designs one gait")
        _design(asked)
        return
    writes = {"--output": asked.output, "--plugin": asked.plugin}
    refuse_options(writes, "with --at NAME=VALUE, which designs a gait")
    if asked.plot is not None:
        refuse_options({"--columns": asked.columns}, "without --plot")
    _show(asked)


def _show(asked: LibraryOptions) -> None:
    """Show the table of a library or draw it; or of two, compared."""
    directories, names, plot = asked.directory, asked.columns, asked.plot
    libraries = [open_library(directory) for directory in directories]
    axes = _common_axes(libraries)
    for library in libraries:
        _print_robot_findings(library)
    out = screen()
    if names == LIST:
        for name in columns(row for library in libraries for row in library.rows):
            unit = unit_of(name, libraries[0].cost[1])
            out.print(f"{printable(name)} [{unit}]" if unit else printable(name))
        return
    rows = [selected(library.rows, asked.where) for library in libraries]
    if plot is not None:
        from gaitopt.view.comparison_figures import library_figure
        from gaitopt.view.figure_style import write_figure

        labels = [""] if len(libraries) == 1 else [str(directory) for directory in directories]
        if libraries[0].cost != libraries[-1].cost:
            raise InputError("the libraries are of different costs; draw them one by one")
        drawn = dict(zip(labels, rows, strict=True))
        write_figure(plot, lambda: library_figure(drawn, axes, libraries[0].cost))
        out.print(f"wrote {plot}")
    elif len(libraries) == 1:
        out.print(library_table(libraries[0], rows[0], names, out.width))
    else:
        units = libraries[0].cost[1], libraries[1].cost[1]
        table = _table_of_libraries((rows[0], rows[1]), axes, units, names, out.width)
        for letter, directory in zip("AB", directories, strict=True):
            out.print(f"{letter}: {directory}")
        out.print(table)
    if plot is None:
        letters = [""] if len(libraries) == 1 else ["A: ", "B: "]
        for letter, library, shown in zip(letters, libraries, rows, strict=True):
            _count(letter, library, shown)


def _design(asked: LibraryOptions) -> None:
    """Design a gait between those of a library, show it, write it."""
    directories, output = asked.directory, asked.output
    require_files((output, "--output"))
    if len(directories) > 1:
        raise InputError("--at is a place in one library; give one directory")
    values = named_values(asked.at, "--at", read_named)
    gait, said = _gait_at(open_library(directories[0]), values, asked.plugin)
    print_findings_of(gait)
    out = screen()
    print_gait(out, gait)
    out.print(said)
    if output is not None:
        save_gait(gait, output)
        out.print(f"wrote {output}")
    if not gait.certified:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


def library_table(library: Library, rows: list[Row], names: str | None, width: int) -> Table:
    """Return the table of a library: what was swept, the motors, the cost, the status.

    Args:
        names: of columns to show instead, joined by commas.
        width: that there is; columns that are of less interest are left out until it fits.

    Raises:
        InputError: there is no such column.
    """
    known, axes = columns(library.rows), [axis.name for axis in library.grid.axes]
    cost = library.cost[1]

    def column(name: str, header: list[str]) -> _Column:
        return _Column(header, [row.get(name) for row in rows])

    if names is not None:
        chosen = _chosen(names, known)
        shown = [*(axis for axis in axes if axis not in chosen), *chosen]
        return _table("", [column(name, _header(name, unit_of(name, cost))) for name in shown])
    must = [*axes, "cost", "status"]
    motors = [name for name in known if name.startswith(_MOTORS)]
    more = [[name for name in known if name.startswith(start)] for start in _MORE]
    wanted = dict.fromkeys([*axes, *motors, "cost", *chain(*more), "status"])
    found = {n: column(n, _header(n.removeprefix(_MOTORS), unit_of(n, cost))) for n in wanted}
    room = min(width, NARROW) + _GAP - sum(found[name].width for name in must)
    fitting = set(must)
    for names_together in [*([name] for name in motors), *more]:
        left_out = set(names_together) - fitting
        needed = sum(found[name].width for name in left_out)
        if needed <= room:
            fitting |= left_out
            room -= needed
    title = "motors: peak torque over a stance and a swing phase" if motors else ""
    return _table(title, [found[name] for name in wanted if name in fitting])


def _table_of_libraries(
    rows: tuple[list[Row], list[Row]],
    axes: list[str],
    costs: tuple[str, str],
    names: str | None,
    width: int,
) -> Table:
    """Return a table of two libraries: their costs, and how much more B takes of a motor."""
    places = [{tuple(row[axis] for axis in axes): row for row in one} for one in rows]
    order = sorted({*places[0], *places[1]}, key=lambda place: [float(str(v)) for v in place])
    pairs = [(places[0].get(place, {}), places[1].get(place, {})) for place in order]
    known = columns([*rows[0], *rows[1]])
    compared = ["cost"] if names is None else _chosen(names, known)
    found = [
        _Column(_header(axis, unit_of(axis)), [place[k] for place in order])
        for k, axis in enumerate(axes)
    ]
    for name in compared:
        for letter, k in (("A", 0), ("B", 1)):
            header = [letter, *_header(name, unit_of(name, costs[k]))]
            found.append(_Column(header, [pair[k].get(name) for pair in pairs]))
        if unit_of(name, costs[0]) == unit_of(name, costs[1]):
            found.append(_Column(["B-A", "%"], [_change(pair, name) for pair in pairs]))
    room = min(width, NARROW) + _GAP - sum(column.width for column in found)
    motors = [name for name in known if name.startswith(_MOTORS)] if names is None else []
    for name in motors:
        header = [*_header(name.removeprefix(_MOTORS), ""), "%"]
        column = _Column(header, [_change(pair, name) for pair in pairs])
        if column.width <= room:
            found.append(column)
            room -= column.width
    title = "motors: peak torque of B over that of A" if motors else ""
    return _table(title, found)


@dataclass(frozen=True)
class _Column:
    """Lines of a header, and what stands below."""

    header: list[str]
    values: Sequence[Value]

    @property
    def width(self) -> int:
        """In characters, with the gap to the next."""
        return _GAP + max(map(len, [*self.header, *(printable(cell(v)) for v in self.values)]))

    @property
    def numeric(self) -> bool:
        """Whether it holds figures only."""
        return all(not isinstance(v, str) or v[:1] in (*ABSENT, "+") for v in self.values)


def _change(pair: tuple[Row, Row], name: str) -> str:
    """Return how much more the second has, in per cent."""
    a, b = (row.get(name) for row in pair)
    figures = isinstance(a, float | int) and isinstance(b, float | int)
    if not figures:
        return ABSENT
    a, b = float(str(a)), float(str(b))
    change = percentage(a, b, max(abs(a), abs(b)))
    return ABSENT if change is None else f"{change:+.1f}"


def _header(name: str, unit: str) -> list[str]:
    """Return the lines of a header: the words of a name, then its unit."""
    lines: list[str] = []
    for word in printable(name).replace(".", " ").replace("_", " ").split():
        if lines and len(lines[-1]) + 1 + len(word) <= _LINE:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return [*lines, unit]


def _table(title: str, found: Sequence[_Column]) -> Table:
    most = max(len(column.header) for column in found)
    heads = ["\n" * (most - len(column.header)) + "\n".join(column.header) for column in found]
    rights = [">" if column.numeric else "" for column in found]
    table = new_table(title, *(right + head for right, head in zip(rights, heads, strict=True)))
    table.expand, table.collapse_padding = False, True
    for values in zip(*(column.values for column in found), strict=True):
        table.add_row(*(printable(cell(value)) for value in values))
    return table


def _common_axes(libraries: Sequence[Library]) -> list[str]:
    """Return the quantities over which libraries are."""
    if len(libraries) > 2:
        raise InputError(f"{len(libraries)} libraries cannot be compared; give one or two")
    axes = [[axis.name for axis in library.grid.axes] for library in libraries]
    if axes[0] != axes[-1]:
        raise InputError(
            f"the libraries are over different quantities, {', '.join(axes[0])} and "
            f"{', '.join(axes[-1])}; give two that were swept over the same"
        )
    return axes[0]


def _print_robot_findings(library: Library) -> None:
    """Tell what is odd about the robot, as the first gait that is there records it."""
    for point, state in library.states.items():
        if state.row is not None:
            with suppress(GaitFileError):
                print_findings_of(library.gait(point))
                return


def _gait_at(library: Library, values: dict[str, float], plugin: Path | None) -> tuple[Gait, str]:
    """Return the gait at a place, and where it comes from."""
    point = stored_point(library, values)
    if point is not None and (stored := library.gait(point)).certified:
        return stored, f"the stored gait of {library.grid.name(point)}; nothing was interpolated"
    known = () if plugin is None else load_plugin(plugin).extensions
    found = interpolate(library, values, known=known)
    if point is None:
        first, *_, last = found.sources  # opposite corners of the cell
        return found.design.gait, f"between {first} and {last}; {found.sentence}"
    return found.design.gait, (
        f"the stored gait of {found.sources[0]} is not certified; designed again from there"
    )


def _chosen(names: str, known: list[str]) -> list[str]:
    """Return the names of columns in a text."""
    chosen = [name.strip() for name in names.split(",") if name.strip()]
    for name in chosen:
        if name not in known:
            raise InputError(unknown_column(name, known))
    return chosen


def _count(letter: str, library: Library, rows: list[Row]) -> None:
    """Tell how many gaits are shown, are there, are to come, and cannot be used."""
    out = screen()
    total, there = len(library.grid.order), _computed(library.rows)
    left = "" if there == total else f"; {total - there} of {total} points are not computed yet"
    out.print(f"{letter}{_computed(rows)} of {there} gaits{left}")
    if broken := len(library.faults):
        told = "1 gait has" if broken == 1 else f"{broken} gaits have"
        out.print(
            f"{told} no usable file, see status; give the command of the sweep again to have what "
            "is missing made anew")  # fmt: skip


def _computed(rows: list[Row]) -> int:
    return sum(row["status"] != NOT_COMPUTED for row in rows)
