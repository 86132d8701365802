"""`gaitopt inspect`, `robots` and `urdf`: what a robot is, which there are, and their files."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from gaitopt.actuators.linkages import read_linkages
from gaitopt.atomic import write_atomically
from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.entries import EXTRA, PACKAGE, PREFIX, catalogue, humanoids
from gaitopt.catalogue.parameters import write_spec
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.cli.command_options import InspectOptions, RobotsOptions, UrdfOptions
from gaitopt.cli.config import Settings
from gaitopt.cli.display import NARROW, WIDTH, headline, new_table, screen
from gaitopt.cli.process import ExitCode, print_error
from gaitopt.cli.request import biped_spec, choices_text, robot_origin, robot_source
from gaitopt.cli.results import require_files
from gaitopt.escape import printable
from gaitopt.gait.motor_space import driven_joints
from gaitopt.model.reference_posture import read_srdf
from gaitopt.model.robot import Robot
from gaitopt.view.inspection import Inspection, inspect_robot, inspection_tables
from gaitopt.view.page_parts import Section

_STYLES = {"guessed": "yellow", "warning": "bold yellow", "changed": "cyan", "given": "green"}
_MOST = 4  # rows about one thing on the screen; a page shows all
_LONGEST = 300  # characters of a text on the screen
_LEAST = 12  # columns of a name
_GAP = 2  # columns between two cells


def inspect(settings: Settings, asked: InspectOptions) -> None:
    """Inspect a robot, print what came out, and write it if asked.

    Raises:
        typer.Exit: the robot cannot be used.
    """
    html, write_choices = asked.html, asked.write_choices
    require_files((html, "--html"), (write_choices, "--write-choices"))
    table = settings.get("linkages")
    linkages = () if table is None else read_linkages(table)
    source, choices = robot_source(settings)
    if choices.srdf is not None:  # a file that is missing is told before any page is written
        read_srdf(choices, source.parent if isinstance(source, Path) else Path())
    found = inspect_robot(source, choices, robot_origin(settings))
    driven = driven_joints(found.robot, linkages) if linkages and found.robot is not None else []
    out = screen()
    print_inspection(out, found)
    for one in driven:
        if one.linkage in linkages:
            out.print(f"{table}: motors turn {', '.join(one.names)}")
    if html is not None and found.model is not None:  # else there is nothing to show
        from gaitopt.view.inspection_page import inspection_text

        written = write_atomically(html, inspection_text(found).encode())
        out.print(f"wrote {written}")
    if write_choices is not None and found.choices is not None:
        write_atomically(write_choices, choices_text(found.choices).encode())
        out.print(
            f"wrote {write_choices}; edit it, then: --choices {write_choices}")  # fmt: skip
    if found.refusal:
        print_error(found.refusal)
        raise typer.Exit(ExitCode.BAD_INPUT)


def print_inspection(out: Console, found: Inspection) -> None:
    """Print the tables of an inspection."""
    width = min(out.width, WIDTH)
    verdict = ("cannot be used", "bold red") if found.refusal else ("can be used", "bold green")
    out.print(headline(found.title, verdict, width), width=width)
    for section in inspection_tables(found):
        out.print(_table(section, width), width=width)
        out.print()


def _table(section: Section, width: int) -> Table:
    if not any(section.columns):
        table = Table.grid(padding=(0, 2))
        table.add_column(style="dim")
        table.add_column(overflow="fold")
    else:
        table = new_table(section.title, *section.columns)
    how = section.how or ("",) * len(section.rows)
    wide = [max(map(len, cells)) for cells in zip(*section.rows, strict=True)]
    heads = [max(map(len, head.lstrip(">").split("\n"))) for head in section.columns]
    taken = sum(_GAP + max(pair) for pair in zip(wide[1:], heads[1:], strict=False))
    room = max(width - taken, _LEAST) if width >= NARROW else width  # there it comes in parts
    seen: Counter[str] = Counter()
    for row, sure in zip(section.rows, how, strict=True):
        topic = row[0] if section.how and len(row) > 2 else ""
        seen[topic] += 1
        if not section.how or seen[topic] <= (_MOST if topic else 3 * _MOST):
            # the other commands say a warning in full: what to do stands at its end
            shown = (printable(cell) for cell in row)
            first, *others = shown if sure == "warning" else map(_short, shown)
            cells = (first if section.how else _in_lines(first, room), *others)
            table.add_row(*(Text(text, style=_STYLES.get(sure, "")) for text in cells))
    for topic, count in seen.items() if section.how else ():
        more = count - (_MOST if topic else 3 * _MOST)
        if more > 0:
            blank = [""] * (len(section.columns) - 2)
            table.add_row(topic, *blank, Text(f"and {more} more: --html FILE"))
    return table


def _in_lines(name: str, room: int) -> str:
    """Return a long name of joints in lines that end where one of its words does."""
    if len(name) <= room:
        return name
    cut = name.rfind("_", 1, room + 1)
    cut = room if cut < 1 else cut
    return f"{name[:cut]}\n{_in_lines(name[cut:], room)}"


def _short(text: str) -> str:
    """Return a text that is not too long: whole names of a list, or whole words."""
    if len(text) <= _LONGEST:
        return text
    kept = text[: _LONGEST - 4]
    names, comma, _ = kept.rpartition(", ")
    rest = text[len(names) :].removeprefix(", ").split(", ")
    if comma and len(names) > _LONGEST // 2 and not any(" " in name for name in rest):
        return f"{names} and {len(rest)} more"
    return f"{kept.rpartition(' ')[0] or kept} ..."


def list_robots(_: RobotsOptions) -> None:
    """Print the catalogue."""
    table = new_table("Robots", "name", "what it is", ">mass\nkg", ">walks at\nm/s", "description")
    entries = catalogue()
    for entry in entries:
        speed = entry.task.get("speed")
        table.add_row(
            entry.name,
            f"{entry.title}\n{entry.remark}" if entry.remark else entry.title,
            f"{entry.mass:.1f}",
            "" if speed is None else f"{speed:g}",
            Text(entry.package or "part of gaitopt")
            if entry.installed
            else Text(f"{entry.package}, not installed", style="yellow"),
        )
    out = screen()
    out.print(table, width=min(out.width, WIDTH))
    out.print()
    out.print("gaitopt optimise --robot NAME, or any other robot: --urdf FILE")
    if known := humanoids():
        names = ", ".join(known)
        out.print(f"{PACKAGE} is installed: --robot {PREFIX}NAME, as {names}")
    if not all(entry.installed for entry in entries):
        out.print(f"to install the others: pip install 'gaitopt[{EXTRA}]'")


def write_biped(settings: Settings, asked: UrdfOptions) -> None:
    """Write the URDF of a specification, or the specification itself."""
    new_spec, output = asked.write_spec, asked.output
    require_files((new_spec, "--write-spec"), (output, "--output"))
    spec = biped_spec(settings) or biped13()
    text = urdf_text(spec)
    Robot.from_urdf(text)  # refuse what could not be used afterwards
    if new_spec is not None:
        write_spec(spec, new_spec)
        typer.echo(f"wrote {new_spec}; edit it, then: gaitopt optimise --spec {new_spec}")
    if output is not None:
        typer.echo(f"wrote {write_atomically(output, text.encode())}")
    elif new_spec is None:
        typer.echo(text, nl=False)
