"""The tables of docs/reproduction.md."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Sequence
from math import isfinite

from gaitopt.design.design import versions
from gaitopt.study.reproduce.gradients import EXACT, NEAR
from gaitopt.study.reproduce.joint_costs import GROUPS
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.results import Alternative, Reproduction
from gaitopt.study.reproduce.unknowns import UNKNOWNS


def markdown(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table of Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def environment() -> str:
    """Return one sentence about the machine and the versions."""
    packages = ", ".join(f"{name} {version}" for name, version in versions().items())
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} CPUs, {packages}."


def unknowns_table(result: Reproduction) -> str:
    """The five values, their ranges, and how well they are determined."""
    fit = result.sensitivity
    rows = [
        (
            u.name, f"{value:.4g}", u.unit, f"{u.lower:g} to {u.upper:g}",
            f"{low:.3g} to {high:.3g}", u.meaning,
        )
        for u, value, (low, high) in zip(UNKNOWNS, fit.values, fit.play, strict=True)
    ]  # fmt: skip
    return markdown(("unknown", "value", "unit", "sought in", "play", "what it is"), rows)


def errors_table(result: Reproduction) -> str:
    """Costs at the speeds of Table 3 and beyond."""
    rows = []
    for speed, walk in result.curve.items():
        row, certificate = printed().at(speed), result.certificates[speed]
        there = None if row is None else row.analytical.cost
        rows.append(
            (
                f"{speed:g}", "" if there is None else f"{there:.2f}", f"{walk.cost:.2f}",
                "" if there is None else f"{100.0 * (walk.cost / there - 1.0):+.2f} %",
                f"{walk.impulse:.2f}", f"{walk.mean_vertical_force:.2f}",
                f"{certificate.kkt.worst:.0e}", f"{certificate.referee.worst:.0e}",
            )
        )  # fmt: skip
    return markdown(
        ("speed m/s", "J printed", "J here", "error", "vertical impulse N·s",
         "mean vertical force N", "KKT residual", "referee"), rows,
    )  # fmt: skip


def singular_table(result: Reproduction) -> str:
    """Singular values of the dependence of the errors on the unknowns."""
    values, directions = result.sensitivity.singular
    rows = [
        (f"{value:.3g}", f"{reach:.2g}", *(f"{part:+.2f}" for part in direction))
        for value, reach, direction in zip(
            values, result.sensitivity.reach, directions, strict=True
        )
    ]
    return markdown(("singular value", "reach", *(u.name for u in UNKNOWNS)), rows)


def alternatives_table(result: Reproduction) -> str:
    """Errors of other values of the unknowns."""
    fit = result.sensitivity
    shipped = Alternative("as shipped", fit.values, fit.errors, result.reference.impulse)
    rows = [
        (
            one.note,
            *(f"{value:.4g}" for value in one.values),
            " ".join(f"{100.0 * error:+.1f}" for error in one.errors),
            f"{100.0 * abs(one.errors).max():.1f}",
            f"{one.impulse:.2f}",
        )
        for one in (shipped, *result.alternatives)
    ]
    header = (
        "values", *(u.name for u in UNKNOWNS), "errors at the eight speeds %", "largest %",
        f"vertical impulse at {printed().speed:g} m/s N·s",
    )  # fmt: skip
    return markdown(header, rows)


def gradient_table(result: Reproduction) -> str:
    """The kinds of gradients at the eight speeds."""
    rows = []
    for comparison in result.comparisons:
        for run in comparison.runs:
            exact = run.gradient == EXACT
            near = comparison.near_ratio(run.gradient)
            seconds = run.seconds_to(min(r.cost for r in comparison.runs) * (1.0 + NEAR))
            rows.append(
                (
                    f"{run.speed:g}" if exact else "", run.gradient, str(run.iterations),
                    str(run.evaluations), f"{run.cost:.2f}",
                    run.status.name.lower().replace("_", " "),
                    f"{run.seconds:.3g}", "1" if exact else f"{comparison.ratio(run.gradient):.0f}",
                    _or_never(seconds, ".3g"), "1" if exact else _or_never(near, ".0f"),
                )
            )  # fmt: skip
    return markdown(
        ("speed m/s", "gradients", "iterations", "evaluations", "optimum", "ended as", "s",
         "times longer", "s to J + 0.1 %", "times longer"), rows,
    )  # fmt: skip


def printed_table() -> str:
    """Table 3 as printed."""
    rows = []
    for row in printed().table3:
        for name, run in (("analytical", row.analytical), ("differences", row.differences)):
            rows.append(
                (
                    f"{row.speed:g}" if name == "analytical" else "", name, str(run.iterations),
                    str(run.evaluations), f"{run.cost:.2f}", f"{run.seconds:.2f}",
                    f"{run.evaluations_per_iteration:.1f}",
                )
            )  # fmt: skip
    return markdown(
        ("speed m/s", "gradient", "iterations", "evaluations", "optimum", "s",
         "evaluations per iteration"), rows,
    )  # fmt: skip


def posture_table(result: Reproduction) -> str:
    """Costs with one and two intermediate postures."""
    at = printed().speed
    rows = []
    for speed, one in result.one_posture.items():
        two = result.curve[speed].cost
        there = printed().cost_one_posture, printed().cost_two_postures
        rows.append(
            (
                f"{speed:g}", *(f"{c:.2f}" if speed == at else "" for c in there),
                f"{100.0 * (there[0] / there[1] - 1.0):.1f} %" if speed == at else "",
                f"{one.cost:.2f}", f"{two:.2f}", f"{100.0 * (one.cost / two - 1.0):.1f} %",
            )
        )  # fmt: skip
    return markdown(
        ("speed m/s", "one, printed", "two, printed", "difference", "one, here", "two, here",
         "difference"), rows,
    )  # fmt: skip


def joint_table(result: Reproduction) -> str:
    """Shares of the cost by group of joints."""
    header = ("speed m/s", *(f"{leg} {g}" for leg in ("stance", "swing") for g in GROUPS), "J")
    rows = []
    for speed, walk in result.curve.items():
        costs = result.joint_costs[speed]
        shares = [costs.stance[g] for g in GROUPS] + [costs.swing[g] for g in GROUPS]
        rows.append((f"{speed:g}", *(f"{share:.0f}" for share in shares), f"{walk.cost:.0f}"))
    return markdown(header, rows)


def _or_never(value: float, form: str) -> str:
    return f"{value:{form}}" if isfinite(value) else "never"
