"""What the paper says of its gaits and was not fitted: does it hold here?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gaitopt.gait.result import Gait
from gaitopt.study.reproduce.gradients import DIFFERENCES
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.results import FASTER, Reproduction
from gaitopt.view.body import walking_model
from gaitopt.view.reproduction_tables import markdown
from gaitopt.view.skeleton import sole_corners

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
    corners = sole_corners(result.gait, walking_model(result.gait))
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
