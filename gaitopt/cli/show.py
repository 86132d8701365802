"""`gaitopt check`, `play` and `plot`: a gait or a transition computed again, and for people."""

from __future__ import annotations

import sys
from pathlib import Path

import typer

from gaitopt.cli.command_options import CheckOptions, PlayOptions, PlotOptions
from gaitopt.cli.display import WIDTH, screen
from gaitopt.cli.process import ExitCode, print_error
from gaitopt.cli.report import certificate_table, print_findings_of
from gaitopt.cli.request import require_directories
from gaitopt.design.audit import Audit, audit
from gaitopt.design.transition import audit_transition
from gaitopt.errors import InputError
from gaitopt.escape import printable
from gaitopt.gait.gait_file import altered_members, load_gait
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.result import Gait, ground_of
from gaitopt.gait.transition import Transition, load
from gaitopt.tolerances import SAME
from gaitopt.view.animation import DEFAULT_STEPS


def run_check(asked: CheckOptions) -> None:
    """Check the file of a gait or a transition and print what came out.

    Raises:
        typer.Exit: it was altered, or is not certified.
    """
    path, plugin = asked.gait, asked.plugin
    gait, rewritten = load(path, verify=False), altered_members(path)
    print_findings_of(gait)
    known = () if plugin is None else load_plugin(plugin).extensions
    if isinstance(gait, Transition):
        found, what = audit_transition(gait, known), f"{gait.words} in {len(gait.steps)} steps"
    else:
        where = f" {words}" if (words := ground_of(gait).words) else ""
        found, what = audit(gait, known), f"at {gait.way}{where}"
    out = screen()
    out.print(f"{path}: {gait.text('robot')} {what}, computed again from its parameters")
    no_solver = {"name": None}
    record = found.certificate.record()
    out.print(certificate_table(no_solver, record), width=min(out.width, WIDTH))
    if found.imposed:
        out.print("the file itself brings:")
        for line in found.imposed:
            out.print(f"  {printable(line)}")
    if found.altered:
        print_error(altered_message(found))
    else:
        worst = max(found.differences.values())
        out.print(f"stored arrays agree with it to {worst:.1e} (allowed {SAME:.0e})")
    if rewritten:
        print_error(
            f"changed after gaitopt wrote the file: {', '.join(rewritten)}; their digests are "
            "others than the file records"
        )
    if found.claimed and not found.certificate.certified:
        print_error("its certificate says certified; computed now, the walk is not")
    if rewritten or not found.passed:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


def altered_message(found: Audit) -> str:
    """Say which arrays and records do not follow from the parameters."""
    parts = [
        f"{name} (by {found.differences[name]:.1e})" if name in found.differences else name
        for name in found.altered
    ]
    return (
        "the file has been altered: computed from its parameters, these differ: "
        f"{', '.join(parts)}; relative {SAME:.0e} is allowed. Design the gait again"
    )


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
