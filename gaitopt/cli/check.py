"""`gaitopt check`: a gait or a transition computed again, from its parameters alone."""

from __future__ import annotations

import typer

from gaitopt.cli.command_options import CheckOptions
from gaitopt.cli.display import WIDTH, screen
from gaitopt.cli.process import ExitCode, print_error
from gaitopt.cli.report import certificate_table, print_findings_of
from gaitopt.design.audit import Audit, audit
from gaitopt.design.transition import audit_transition
from gaitopt.escape import printable
from gaitopt.gait.gait_file import altered_members
from gaitopt.gait.plugin import load_plugin
from gaitopt.gait.result import ground_of
from gaitopt.gait.transition import Transition, load
from gaitopt.tolerances import SAME


def run(asked: CheckOptions) -> None:
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
    out.print(
        f"{path}: {gait.text('robot')} {what}, computed again from its parameters", soft_wrap=True
    )
    no_solver = {"name": None}
    record = found.certificate.record()
    out.print(certificate_table(no_solver, record), width=min(out.width, WIDTH))
    if found.imposed:
        out.print("the file itself brings:")
        for line in found.imposed:
            out.print(f"  {printable(line)}", soft_wrap=True)
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
