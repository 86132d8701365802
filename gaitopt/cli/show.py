"""`gaitopt play` and `plot`: a gait or a transition for people."""

from __future__ import annotations

import sys
from pathlib import Path

import typer

from gaitopt.cli.command_options import PlayOptions, PlotOptions
from gaitopt.cli.report import print_findings_of
from gaitopt.cli.request import require_directories
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition, load
from gaitopt.view.animation import DEFAULT_STEPS


def run_play(asked: PlayOptions) -> None:
    """Show a gait or a transition in the browser until Ctrl-C, or write it as a page.

    Raises:
        InputError: a page and an address are both asked for.
    """
    from gaitopt.view.page import write_page
    from gaitopt.view.scene_server import LOCAL, is_local, play

    path, html, steps, host = asked.gait, asked.html, asked.steps, asked.host
    if html is not None and (host is not None or asked.port is not None):
        raise InputError("a page is a file: --html goes with neither --host nor --port")
    require_directories(asked.package_dir)
    package_dirs = tuple(map(str, asked.package_dir))
    gait = loaded_motion(path)
    if steps is not None and isinstance(gait, Transition):
        raise InputError(
            f"'{path}' is a transition, all of whose steps are shown: leave --steps out"
        )
    count = DEFAULT_STEPS if steps is None else steps
    if html is not None:
        typer.echo(f"wrote {write_page(gait, html, count, package_dirs)}")
        return
    host = LOCAL if host is None else host
    with play(gait, count, package_dirs=package_dirs, host=host, port=asked.port) as player:
        if not is_local(host):
            typer.echo("note: other machines can reach this page too", err=True)
        if player.note:
            typer.echo(f"note: {player.note}", err=True)
        typer.echo(f"{path} walks at {player.url} (Ctrl-C stops)")
        sys.stdout.flush()
        player.wait()


def run_plot(asked: PlotOptions) -> None:
    """Draw the figures of a gait or a transition."""
    from gaitopt.view.figures import write_figures

    directory = asked.gait.parent / "figures" if asked.output is None else asked.output
    for figure in write_figures(loaded_motion(asked.gait), directory, asked.format or ("png",)):
        typer.echo(f"wrote {figure}")


def loaded(path: Path) -> Gait:
    """Return a gait, its robot's oddities told."""
    gait = load_gait(path)
    print_findings_of(gait)
    return gait


def loaded_motion(path: Path) -> Gait | Transition:
    """Return a gait or a transition, its robot's oddities told."""
    found = load(path)
    print_findings_of(found)
    return found
