"""Figures of the joints: torques and rates of the twelve motors against their limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.design.summary import pair_name, partner
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.figure_style import (
    LIMIT,
    STANCE,
    SWING,
    label_axes,
    name_on_figure,
    new_figure,
)

_FROM_HIP = [5, 4, 3, 2, 1, 0]  # stance joints are stored from the ankle up
# Six panels are laid out by measuring each of their labels twice, which takes longer than drawing.
_PLACE = {
    "left": 0.075, "right": 0.99, "bottom": 0.18, "top": 0.905, "wspace": 0.16, "hspace": 0.17,
}  # fmt: skip
_FAR = 1.5  # a limit this many times the panel's own largest value would flatten its curves
_FLAT = 0.02  # of the figure's largest value: a panel shows no less, lest rounding looks like waves
_SPACE = 0.08  # free above and below the curves, in their heights


def torque_figure(gait: Gait) -> Figure:
    """Draw the torques of the twelve joints against their limits, stance leg on swing leg."""
    figure = _grid(gait, gait.torque, gait.joint_limit("torque"), "torque [N·m]")
    figure.suptitle("Joint torques")
    return figure


def rate_figure(gait: Gait) -> Figure:
    """Draw the rates of the twelve joints against their limits, stance leg on swing leg."""
    figure = _grid(gait, gait.dq, gait.joint_limit("speed"), "rate [rad/s]")
    figure.suptitle("Joint rates")
    return figure


def angle_figure(gait: Gait) -> Figure:
    """Draw the angles of the twelve joints, stance leg on swing leg."""
    figure = _grid(gait, gait.q, None, "angle [rad]")
    figure.suptitle("Joint angles")
    return figure


def _grid(gait: Gait, values: Array, limits: Array | None, unit: str) -> Figure:
    """Draw six panels from hip to ankle, in each the joint of both legs, in its own scale."""
    figure = new_figure(9.0, 5.0, layout=None)
    panels = figure.subplots(2, 3, sharex=True, gridspec_kw=_PLACE)
    least = _FLAT * float(np.abs(values).max())
    for panel, (axes, stance) in enumerate(zip(panels.flat, _FROM_HIP, strict=True)):
        both = [stance, partner(gait, stance)]
        axes.axhline(0.0, color="#C8C8C8", linewidth=0.8)
        axes.plot(gait.time, values[:, both[0]], color=STANCE, label="stance leg")
        axes.plot(gait.time, values[:, both[1]], color=SWING, label="swing leg")
        drawn = [] if limits is None else _draw_limit(axes, values[:, both], limits[both])
        _scale(axes, np.append(values[:, both], drawn), least)
        label_axes(
            axes,
            "time [s]" if panel >= 3 else "",
            unit if panel % 3 == 0 else "",
            name_on_figure(pair_name(gait, stance)),
        )
    _share_legend(figure, list(panels.flat))
    return figure


def _draw_limit(axes: Axes, values: Array, limits: Array) -> list[float]:
    """Write the limit of both joints and the share used; draw it where their curves come near.

    Returns:
        The values at which there is a line.
    """
    limit = float(np.min(limits))
    if not np.isfinite(limit) or limit <= 0.0:
        return []
    used = np.abs(values).max(axis=0) / limits
    colour = LIMIT if used.max() >= 0.999 else "#555555"
    share = f"limit {limit:.4g}: {100.0 * used[0]:.0f} % / {100.0 * used[1]:.0f} %"
    near = [side * limit for side in (-1, 1) if limit < _FAR * (side * values).max()]
    axes.set_title(share, loc="right", fontsize=7.5, color=colour)
    for line in near:
        axes.axhline(line, color=LIMIT, linestyle="--", linewidth=1.0, label="limit")
    return near


def _scale(axes: Axes, shown: Array, least: float) -> None:
    """Make a panel hold its own values, zero, and at least so much on either side of it."""
    low, high = min(float(shown.min()), -least), max(float(shown.max()), least)
    space = _SPACE * (high - low)
    axes.set_ylim(low - space, high + space)


def _share_legend(figure: Figure, panels: list[Axes]) -> None:
    """Write one legend of whatever is drawn in any panel."""
    found = {
        label: handle
        for axes in panels
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    told = "above each panel: the limit, and its share used by stance / swing leg"
    title = told if any(axes.get_title(loc="right") for axes in panels) else None
    figure.legend(
        list(found.values()), list(found), loc="lower center", ncols=3, title=title,
        title_fontsize=8.0,
    )  # fmt: skip
