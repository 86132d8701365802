"""The figures of the paper's section 6, drawn again beside what it prints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.view.figure_style import (
    GREY,
    INSIDE,
    LIMIT,
    SECOND,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    new_figure,
    styled,
)
from gaitopt.view.figures import step_figure, walking_figure
from reproduction.curve import GROUPS
from reproduction.gradients import COST_ONLY, DIFFERENCES, EXACT, Run
from reproduction.paper import printed
from reproduction.results import Reproduction
from reproduction.tables import weight

BAND = "#DFE6EC"  # of what is allowed, seen through a grid

_GRADIENTS = {
    EXACT: ("exact derivatives", STANCE, "-"),
    COST_ONLY: ("exact for the cost only", SECOND, "--"),
    DIFFERENCES: ("finite differences", SWING, "-."),
}
_GROUPS = {"ankle": (SECOND, "-."), "knee": (STANCE, "-"), "hip": (SWING, ":")}


def convergence_figure(result: Reproduction) -> Figure:
    """Draw cost and violation against the iterations at 1.0 m/s (Fig. 3)."""
    figure = new_figure(7.4, 5.0)
    above, below = figure.subplots(2, 1, sharex=True)
    comparison = result.comparison(printed().speed)
    best = min(run.cost for run in comparison.runs)
    for run in comparison.runs:
        _draw_run(above, below, run, best)
    _draw_printed_ends(above, below)
    above.set_xscale("symlog", linthresh=1.0)
    above.set_xlim(left=0.0)
    above.set_yscale("log")
    below.set_yscale("log")
    label_axes(above, "", "|J - best J| / best J [-]", "distance of the cost")
    label_axes(below, "iteration", "worst violation [-]", "violation of the constraints, scaled")
    figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    figure.suptitle(f"Convergence at {printed().speed:.1f} m/s from the same first guess (Fig. 3)")
    return figure


def ground_force_figure(result: Reproduction) -> Figure:
    """Draw the force of the ground on the stance foot beside the printed mean (Fig. 5)."""
    figure = new_figure(7.4, 5.0)
    axes, means = figure.subplots(2, 1, sharex=True, height_ratios=[2.5, 1.0])
    gait, mean = result.gait, result.reference.mean_vertical_force
    fx, fy, fz = gait.ground_wrench[:, :3].T
    axes.plot(gait.time, fz, color=STANCE, label="normal")
    axes.plot(gait.time, fx, "--", color=SWING, linewidth=1.2, label="forward")
    axes.plot(gait.time, fy, "-.", color=SECOND, linewidth=1.2, label="to the left")
    there = printed().mean_vertical_force
    for value, line, name in (
        (mean, "-", f"normal, mean: {mean:.2f} N"),
        (there, "--", f"normal, mean, paper: {there:.2f} N"),
        (weight(result), ":", f"weight: {weight(result):.2f} N"),
    ):
        axes.axhline(value, color=GREY, linestyle=line, linewidth=0.8)
        means.axhline(value, color=TRUNK, linestyle=line, linewidth=1.2, label=name)
    label_axes(axes, "", "force [N]")
    label_axes(means, "time [s]", "force [N]", "means of the normal force, enlarged")
    means.margins(y=0.2)
    for panel in (axes, means):
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.suptitle(f"Force of the ground on the stance foot at {printed().speed:.1f} m/s (Fig. 5)")
    return figure


def cop_figure(result: Reproduction) -> Figure:
    """Draw the centre of pressure with one and with two intermediate postures (Fig. 6)."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    corners = result.gait.trajectory.body.sole_corners[0]
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    axes.fill_between([low[0], high[0]], low[1], high[1], facecolor=INSIDE, edgecolor=TRUNK)
    for gait, name, line, there in (
        (result.gait_one_posture, "one", ":", printed().cost_one_posture),
        (result.gait, "two", "-", printed().cost_two_postures),
    ):
        words = f"{name} between: J = {gait.cost:.2f} N²·m·s (paper: {there:.2f})"
        axes.plot(*gait.cop.T, line, color=STANCE, label=words)
        axes.plot(*gait.cop[0], "o", color=SECOND, markersize=5)
        axes.plot(*gait.cop[-1], "s", color=SWING, markersize=5)
    axes.plot([], [], "o", color=SECOND, markersize=5, label="start")
    axes.plot([], [], "s", color=SWING, markersize=5, label="end")
    axes.set_aspect("equal")
    axes.grid(False)
    label_axes(axes, "forward x [m]", "left y [m]")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    figure.suptitle("Centre of pressure in the stance sole at 1.0 m/s (Fig. 6)")
    return figure


def cost_figure(result: Reproduction) -> Figure:
    """Draw the cost against the speed beside both columns of Table 3 (Fig. 7)."""
    figure = new_figure(8.4, 4.4)
    near, far = figure.subplots(1, 2)
    for axes in (near, far):
        _draw_costs(axes, result)
    speeds, costs = printed().speeds, printed().costs
    near.set_xlim(speeds[0] - 0.03, speeds[-1] + 0.03)
    near.set_ylim(0.9 * float(costs.min()), 1.1 * float(costs.max()))
    far.axvline(
        printed().fastest, color=LIMIT, linewidth=1.0, linestyle="--",
        label="paper: no faster walk is possible",
    )  # fmt: skip
    label_axes(near, "walking speed [m/s]", "J [N²·m·s]", "speeds of Table 3")
    label_axes(far, "walking speed [m/s]", "J [N²·m·s]", "all")
    figure.legend(*far.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle("Optimal cost against speed (Fig. 7, Table 3)")
    return figure


def _draw_costs(axes: Axes, result: Reproduction) -> None:
    speeds, costs = printed().speeds, printed().costs
    axes.fill_between(speeds, 0.95 * costs, 1.05 * costs, color=BAND, label="printed ± 5 %")
    found = [walk.cost for walk in result.curve.values()]
    axes.plot(list(result.curve), found, "o-", color=STANCE, label="gaitopt")
    axes.plot(speeds, costs, "s--", color=TRUNK, label="paper, analytical")
    axes.plot(
        speeds, [row.differences.cost for row in printed().table3], "^:", color=GREY,
        label="paper, finite differences",
    )  # fmt: skip


def joint_cost_figure(result: Reproduction) -> Figure:
    """Draw what ankle, knee and hip of each leg contribute to the cost (Fig. 8)."""
    figure = new_figure(8.4, 3.8)
    panels = figure.subplots(1, 2)
    speeds = [v for v in result.curve if v <= printed().fastest]
    costs = [result.joint_costs[v] for v in speeds]
    for axes, leg in zip(panels, ("stance", "swing"), strict=True):
        for group in GROUPS:
            colour, line = _GROUPS[group]
            values = [getattr(cost, leg)[group] for cost in costs]
            axes.plot(speeds, values, line, color=colour, marker="o", markersize=3, label=group)
        axes.set_ylim(bottom=0.0)
        label_axes(axes, "walking speed [m/s]", "share of J [N²·m·s]", f"{leg} leg")
        axes.legend()
    figure.suptitle("Cost of the joint torques by group (Fig. 8)")
    return figure


def error_figure(result: Reproduction) -> Figure:
    """Draw the relative errors at the speeds of Table 3, of the fit and of its alternatives."""
    figure = new_figure(7.6, 3.4)
    axes = figure.subplots()
    for other in result.alternatives:
        axes.plot(printed().speeds, 100.0 * other.errors, color=GREY, linewidth=0.9)
    axes.plot([], [], color=GREY, linewidth=0.9, label="other values (table below)")
    axes.plot(printed().speeds, 100.0 * result.errors, "o-", color=STANCE, label="as shipped")
    axes.axhline(-5.0, color=LIMIT, linestyle="--", linewidth=1.0, label="± 5 %")
    axes.axhline(5.0, color=LIMIT, linestyle="--", linewidth=1.0)
    label_axes(axes, "walking speed [m/s]", "J over the printed J, minus 1 [%]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.suptitle("The identification: errors at the eight speeds")
    return figure


REPRODUCTION_FIGURES: dict[str, Callable[[Reproduction], Figure]] = {
    "convergence": convergence_figure,
    "step": lambda result: step_figure(result.gait),
    "ground_force": ground_force_figure,
    "cop": cop_figure,
    "cost": cost_figure,
    "joint_costs": joint_cost_figure,
    "walk": lambda result: walking_figure(result.gait),
    "errors": error_figure,
}
"""By the name of their files: Figs. 3 to 9, and the errors of the identification."""


def reproduction_figure(result: Reproduction, name: str) -> Figure:
    """Return one of `REPRODUCTION_FIGURES`."""
    with styled():
        return REPRODUCTION_FIGURES[name](result)


def _draw_printed_ends(above: Axes, below: Axes) -> None:
    """Mark after how many iterations the runs of the paper ended."""
    row = printed().at(printed().speed)
    if row is None:
        return
    for run, name, line in (
        (row.analytical, "analytical", ":"),
        (row.differences, "differences", "--"),
    ):
        words = f"paper, {name}: {run.iterations} iterations, J = {run.cost:.2f}"
        above.axvline(run.iterations, color=TRUNK, linestyle=line, linewidth=1.0, label=words)
        below.axvline(run.iterations, color=TRUNK, linestyle=line, linewidth=1.0)


def _draw_run(above: Axes, below: Axes, run: Run, best: float) -> None:
    words, colour, line = _GRADIENTS[run.gradient]
    label = f"{words}: {run.iterations} iterations, J = {run.cost:.2f}"
    _, cost, violation = run.history.T
    iterations = np.arange(len(cost))
    above.plot(iterations, np.abs(cost / best - 1.0) + 1e-12, line, color=colour, label=label)
    below.plot(iterations, violation + 1e-16, line, color=colour)
