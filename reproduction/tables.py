"""The tables of docs/reproduction.md."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite

import numpy as np

from gaitopt.design.pipeline import versions
from gaitopt.gait.result import Gait
from reproduction.curve import GROUPS
from reproduction.gradients import DIFFERENCES, EXACT, NEAR
from reproduction.identification import UNKNOWNS
from reproduction.paper import printed
from reproduction.results import FASTER, Alternative, Reproduction


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


_FORCE = 1.0  # N
_IMPULSE = 0.5  # N·s
_SHARE = 0.01  # of J

Claim = tuple[str, str, str, bool]


def claims_table(result: Reproduction) -> str:
    """Return a table of claims: what the paper prints, what was found, whether they agree."""
    rows = [(*words, "yes" if holds else "**no**") for *words, holds in _claims(result)]
    return markdown(("what", "in the paper", "here", "agrees"), rows)


def printed_impulse(result: Reproduction) -> float:
    """Return the vertical impulse that follows from the printed mean force [N·s]."""
    return (weight(result) - printed().mean_vertical_force) * printed().duration


def weight(result: Reproduction) -> float:
    """Return the weight of the biped [N]."""
    robot = result.reference.problem.robot
    return float(robot.mass * np.linalg.norm(robot.model.gravity.linear))


def _claims(result: Reproduction) -> Iterator[Claim]:
    yield from _force(result)
    yield from _legs(result)
    yield _cop_inside(result)
    yield _cop_amplitude(result)
    yield _postures(result)
    yield _end(result)
    yield _differences(result)


def _force(result: Reproduction) -> Iterator[Claim]:
    there, here = printed().mean_vertical_force, result.reference.mean_vertical_force
    yield (
        f"mean vertical force at {printed().speed:g} m/s (Fig. 5)", f"{there:.2f} N",
        f"{here:.2f} N", abs(here - there) <= _FORCE,
    )  # fmt: skip
    impulse = result.reference.impulse
    yield (
        "hence the vertical impulse of the impact", f"{printed_impulse(result):.2f} N·s",
        f"{impulse:.2f} N·s", abs(impulse - printed_impulse(result)) <= _IMPULSE,
    )  # fmt: skip


def _legs(result: Reproduction) -> Iterator[Claim]:
    costs = {v: result.joint_costs[v] for v in printed().speeds}
    shares = [sum(c.swing.values()) / sum(c.stance.values()) for c in costs.values()]
    yield (
        "cost of the swing leg over that of the stance leg (Fig. 8)", "less",
        f"{min(shares):.2f} to {max(shares):.2f}", max(shares) < 1.0,
    )  # fmt: skip
    hip = {v: c.stance["hip"] for v, c in costs.items()}
    slow, fast, last = printed().slow_hip, printed().fast_hip, printed().speeds[-1]
    low = max(hip[v] / result.curve[v].cost for v in hip if v <= slow)
    yield (
        f"stance hip up to {slow:g} m/s, as a share of J (Fig. 8)", "less important",
        f"at most {low:.2f}", low < 0.5,
    )  # fmt: skip
    yield (
        f"stance hip from {fast:g} to {last:g} m/s (Fig. 8)", "increases considerably",
        f"{hip[fast]:.0f} to {hip[last]:.0f}", hip[last] > 1.25 * hip[fast],
    )  # fmt: skip


def _cop_inside(result: Reproduction) -> Claim:
    corners = result.gait.trajectory.body.sole_corners[0]
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    least = min(
        float(np.minimum(gait.cop - low, high - gait.cop).min())
        for gait in (result.gait, result.gait_one_posture)
    )
    return (
        "centre of pressure inside the sole, one and two postures (Fig. 6)", "always",
        f"nearest edge {1000.0 * least:.0f} mm", least >= 0.0,
    )  # fmt: skip


def _cop_amplitude(result: Reproduction) -> Claim:
    one, two = _amplitude(result.gait_one_posture), _amplitude(result.gait)
    return (
        "its amplitude with two postures against one (Fig. 6)", "lower",
        f"{1000.0 * two:.0f} against {1000.0 * one:.0f} mm (diagonal of its rectangle)", two < one,
    )  # fmt: skip


def _postures(result: Reproduction) -> Claim:
    there = printed().cost_one_posture / printed().cost_two_postures - 1.0
    here = result.one_posture[printed().speed].cost / result.reference.cost - 1.0
    return (
        "one posture dearer than two (Fig. 6)", f"{100.0 * there:.1f} %", f"{100.0 * here:.1f} %",
        abs(here - there) <= _SHARE,
    )  # fmt: skip


def _end(result: Reproduction) -> Claim:
    fastest = max(result.curve)
    tried = f"; none was found at {FASTER[-1]:g} m/s" if fastest < FASTER[-1] else ""
    ratio = result.curve[fastest].cost / result.curve[printed().speeds[-1]].cost
    return (
        "no faster walk is possible (Fig. 7)", f"beyond {printed().fastest:g} m/s",
        f"found at {fastest:g} m/s, {ratio:.1f} times the cost at {printed().speeds[-1]:g}{tried}",
        abs(fastest - printed().fastest) < 0.05,
    )  # fmt: skip


def _differences(result: Reproduction) -> Claim:
    there = max(row.differences.cost / row.analytical.cost - 1.0 for row in printed().table3)
    here = max(c.run(DIFFERENCES).cost / c.runs[0].cost - 1.0 for c in result.comparisons)
    return (
        "runs with finite differences dearer by up to (Table 3)", f"{100.0 * there:.0f} %",
        f"{100.0 * here:.2g} %", abs(here - there) <= _SHARE,
    )  # fmt: skip


def _amplitude(gait: Gait) -> float:
    return float(np.linalg.norm(np.ptp(gait.cop, axis=0)))
