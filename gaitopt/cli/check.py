"""`gaitopt check`: compute a gait file again and say whether to believe it."""

from __future__ import annotations

from pathlib import Path

import typer

from gaitopt.cli.failures import ExitCode, complain
from gaitopt.cli.known import tell_robot_of
from gaitopt.cli.proof import proof_table
from gaitopt.cli.screen import WIDTH, screen
from gaitopt.design.audit import Audit, audit
from gaitopt.gait.result_file import load_gait
from gaitopt.tolerances import SAME
from gaitopt.view.visible import visible


def run(path: Path) -> None:
    """Check a gait file and print what came out.

    Raises:
        GaitoptError: the file cannot be read or checked.
        typer.Exit: it was altered, or is not certified.
    """
    gait = load_gait(path)
    tell_robot_of(screen(stderr=True), gait)
    found = audit(gait)
    out = screen()
    out.print(
        f"{path}: {gait.text('robot')} at {gait.speed:.3g} m/s, computed again from its parameters",
        soft_wrap=True,
    )
    no_solver = {"name": None}
    record = found.certificate.record()
    out.print(proof_table(no_solver, record), width=min(out.width, WIDTH))
    if found.imposed:
        out.print("the file itself brings:")
        for line in found.imposed:
            out.print(f"  {visible(line)}", soft_wrap=True)
    if found.altered:
        complain(altered_message(found))
    else:
        worst = max(found.differences.values())
        out.print(f"stored arrays agree with it to {worst:.1e} (allowed {SAME:.0e})")
    if found.claimed and not found.certificate.certified:
        complain("its certificate says certified; computed now, the walk is not")
    if not found.passed:
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
