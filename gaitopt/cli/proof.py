"""The proof of a gait as a table: what was checked, what came out, what is allowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table
from rich.text import Text

from gaitopt.cli.cells import ABSENT, new_table, rounded
from gaitopt.solvers.certified import UNCONFIRMED
from gaitopt.tolerances import LIMITS, MOMENTUM, OPTIMALITY, REFEREE
from gaitopt.view.visible import visible

_NOT_NEEDED = "the second solver did not reach the same; the certificate does not need it"
_DAMAGED = "the file's record of them is damaged; gaitopt check computes them again"
_REFEREE = ("torque", "wrench", "impulse", "rate_after", "sole_twist", "posture", "rate")


def proof_table(solver: Mapping[str, Any], certificate: Mapping[str, Any]) -> Table:
    """Return the table of a gait's solver and certificate records (of `summarise`)."""
    table = new_table("Proof", "check", "result", ">allowed")
    try:
        rows = [("solver", _solver(solver), "")] if solver["name"] is not None else []
        rows += _checks(certificate) if certificate["kkt"] is not None else []
    except (KeyError, TypeError, ValueError, OverflowError):  # a file says whatever it likes
        rows = [("checks", _DAMAGED, "")]
    for row in rows:
        table.add_row(*row)
    table.add_row("verdict", _verdict(certificate), "")
    return table


def _solver(solver: Mapping[str, Any]) -> str:
    text = (
        f"{solver['name']}: {solver['iterations']} iterations, "
        f"{solver['evaluations']} evaluations, {solver['seconds']:.2f} s in the solver\n"
        f"{solver['sentence']}"
    )
    return f"{text}\n{_NOT_NEEDED}" if solver["name"] == UNCONFIRMED else text


def _checks(certificate: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return what was checked, what came out, and what is allowed."""
    kkt, referee, worst = certificate["kkt"], certificate["referee"], certificate["worst"]
    speed = certificate["rear_foot_speed"]
    sinks = ABSENT if speed is None else f"sinks at {-speed:.3g} m/s"
    return [
        (
            "optimal at the samples (KKT)",
            f"gradient {kkt['stationarity']:.1e}, limits {kkt['feasibility']:.1e}, "
            f"complementarity {kkt['complementarity']:.1e}",
            f"{OPTIMALITY:.0e}",
        ),
        (
            "limits at every instant",
            f"worst violation {certificate['fine_violation']:.1e}\nworst row: {_named(worst)}",
            f"{LIMITS:.0e}",
        ),
        (
            "Newton-Euler referee",
            f"disagrees by {max(referee[name] for name in _REFEREE):.1e}",
            f"{REFEREE:.0e}",
        ),
        (
            "momentum over a step",
            f"ground {referee['vertical']:.3f} N·s = m g T {referee['weight']:.3f} N·s, "
            f"apart by {referee['momentum']:.1e}",
            f"{MOMENTUM:.0e}",
        ),
        (
            "rear foot after the impact",
            "lifts off" if certificate["rear_foot_lifts"] else sinks,
            "lifts off",
        ),
    ]


def _named(row: Mapping[str, Any]) -> str:
    """Return a row of the certificate in words."""
    when = "" if row["time"] is None else f" at {row['time']:.4f} s"
    value, limit = rounded(row["value"]), rounded(row["limit"])
    return f"{visible(row['row'])}{when}: {value} {row['unit']}, limit {limit}"


def _verdict(certificate: Mapping[str, Any]) -> Text:
    style = "bold green" if certificate["certified"] else "bold yellow"
    return Text(visible(str(certificate["verdict"] or ABSENT)), style=style)
