"""The figures of the paper's section 6, drawn again beside what it prints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.study.reproduce.gradients import COST_ONLY, DIFFERENCES, EXACT, Run
from gaitopt.study.reproduce.joint_costs import GROUPS, joint_costs
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.results import Reproduction
from gaitopt.view.body import walking_model
from gaitopt.view.figure_style import (
    GREY,
    INSIDE,
    LIMIT,
    MEAN,
    SECOND,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    new_figure,
    styled,
)
from gaitopt.view.ground_figures import force_figure
from gaitopt.view.skeleton import sole_corners
from gaitopt.view.stick_figures import step_figure, walking_figure

_GRADIENTS = {
    EXACT: ("exact derivatives", STANCE, "-"),
    COST_ONLY: ("exact for the cost, differences for the constraints", SECOND, "--"),
    DIFFERENCES: ("finite differences", SWING, "-."),
}
_GROUPS = {"ankle": (SECOND, "-."), "knee": (STANCE, "-"), "hip": (SWING, ":")}


def convergence_figure(result: Reproduction) -> Figure:
    """Draw cost and violation against the iterations at 1.0 m/s (Fig. 3)."""
    figure = new_figure(7.4, 4.6)
    above, below = figure.subplots(2, 1, sharex=True)
    comparison = next(c for c in result.comparisons if c.speed == printed().speed)
    best = min(run.cost for run in comparison.runs)
    for run in comparison.runs:
        _draw_run(above, below, run, best)
    above.set_xscale("symlog", linthresh=1.0)
    above.set_yscale("log")
    below.set_yscale("log")
    label_axes(above, "", "|J - best J| / best J [-]", "distance of the cost")
    label_axes(below, "iteration", "worst violation [-]", "violation of the constraints, scaled")
    above.legend(loc="lower left")
    figure.suptitle(f"Convergence at {printed().speed:g} m/s from the same first guess (Fig. 3)")
    return figure


def cop_figure(result: Reproduction) -> Figure:
    """Draw the centre of pressure with one and with two intermediate postures (Fig. 6)."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    corners = sole_corners(result.gait, walking_model(result.gait))
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    axes.fill_between([low[0], high[0]], low[1], high[1], facecolor=INSIDE, edgecolor=TRUNK)
    for gait, name, line in (
        (result.gait_one_posture, "one intermediate posture", ":"),
        (result.gait, "two intermediate postures", "-"),
    ):
        axes.plot(*gait.cop.T, line, color=STANCE, label=f"{name}, J = {gait.cost:.1f}")
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
    figure = new_figure(6.8, 4.2)
    axes = figure.subplots()
    speeds = np.array(list(result.curve))
    costs = np.array([walk.cost for walk in result.curve.values()])
    axes.fill_between(
        printed().speeds, 0.95 * printed().costs, 1.05 * printed().costs, color=INSIDE,
        label="printed ± 5 %",
    )  # fmt: skip
    axes.plot(speeds, costs, "o-", color=STANCE, label="gaitopt")
    axes.plot(printed().speeds, printed().costs, "s--", color=TRUNK, label="paper, analytical")
    axes.plot(
        printed().speeds, [row.differences.cost for row in printed().table3], "^:", color=GREY,
        label="paper, finite differences",
    )  # fmt: skip
    axes.axvline(printed().fastest, color=LIMIT, linewidth=1.0, linestyle="--")
    axes.annotate(
        "the paper's\nfastest", (printed().fastest, 1.0), (3, -26), color=LIMIT, fontsize=8.0,
        xycoords=("data", "axes fraction"), textcoords="offset points",
    )  # fmt: skip
    axes.set_ylim(4000.0, 1.5 * float(printed().costs.max()))
    label_axes(axes, "walking speed [m/s]", "J [N²·m·s]")
    axes.legend(loc="upper center")
    figure.suptitle("Optimal cost against speed (Fig. 7, Table 3)")
    return figure


def joint_cost_figure(result: Reproduction) -> Figure:
    """Draw what ankle, knee and hip of each leg contribute to the cost (Fig. 8)."""
    figure = new_figure(8.4, 3.8)
    panels = figure.subplots(1, 2)
    speeds = [v for v in result.curve if v <= printed().fastest]
    costs = [joint_costs(result.curve[v]) for v in speeds]
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
    figure = new_figure(6.8, 3.4)
    axes = figure.subplots()
    for other in result.alternatives:
        axes.plot(printed().speeds, 100.0 * other.errors, color=GREY, linewidth=0.9)
    axes.plot([], [], color=GREY, linewidth=0.9, label="other values")
    axes.plot(printed().speeds, 100.0 * result.errors, "o-", color=STANCE, label="as shipped")
    for limit in (-5.0, 5.0):
        axes.axhline(limit, color=MEAN, linestyle="--", linewidth=1.0)
    label_axes(axes, "walking speed [m/s]", "J over the printed J, minus 1 [%]")
    axes.legend()
    figure.suptitle("The identification: errors at the eight speeds")
    return figure


REPRODUCTION_FIGURES: dict[str, Callable[[Reproduction], Figure]] = {
    "convergence": convergence_figure,
    "step": lambda result: step_figure(result.gait),
    "ground_force": lambda result: force_figure(result.gait),
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


def _draw_run(above: Axes, below: Axes, run: Run, best: float) -> None:
    label, colour, line = _GRADIENTS[run.gradient]
    _, cost, violation = run.history.T
    iterations = np.arange(len(cost))
    above.plot(iterations, np.abs(cost / best - 1.0) + 1e-12, line, color=colour, label=label)
    below.plot(iterations, violation + 1e-16, line, color=colour)
