"""Figures of the joints: torques and rates of the twelve motors against their limits."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.figure_style import (
    LIMIT,
    STANCE,
    SWING,
    draw_limits,
    label_axes,
    new_figure,
)

_FROM_HIP = [5, 4, 3, 2, 1, 0]  # stance joints are stored from the ankle up
# Six panels are laid out by measuring each of their labels twice, which takes longer than drawing.
_PLACE = {
    "left": 0.075, "right": 0.99, "bottom": 0.18, "top": 0.905, "wspace": 0.06, "hspace": 0.17,
}  # fmt: skip
_FAR = 5.0  # a limit this many times the largest value is not drawn: it would flatten the curves


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
    """Draw six panels from hip to ankle, in each the joint of both legs."""
    figure = new_figure(9.0, 5.0, layout=None)
    panels = figure.subplots(2, 3, sharex=True, sharey=True, gridspec_kw=_PLACE)
    largest = float(np.abs(values).max())
    for panel, (axes, stance) in enumerate(zip(panels.flat, _FROM_HIP, strict=True)):
        swing = 11 - stance
        axes.axhline(0.0, color="#C8C8C8", linewidth=0.8)
        axes.plot(gait.time, values[:, stance], color=STANCE, label="stance leg")
        axes.plot(gait.time, values[:, swing], color=SWING, label="swing leg")
        if limits is not None:
            _draw_joint_limits(axes, values[:, [stance, swing]], limits[[stance, swing]], largest)
        label_axes(
            axes,
            "time [s]" if panel >= 3 else "",
            unit if panel % 3 == 0 else "",
            _joint_title(gait.joint_names[stance], gait.joint_names[swing]),
        )
    _share_legend(figure, panels.flat[0], limits)
    return figure


def _draw_joint_limits(axes: Axes, values: Array, limits: Array, largest: float) -> None:
    limit = float(np.min(limits))
    if not np.isfinite(limit) or limit <= 0.0:
        return
    used = np.abs(values).max(axis=0) / limits
    colour = LIMIT if used.max() >= 0.999 else "#555555"
    share = f"{100.0 * used[0]:.0f} % / {100.0 * used[1]:.0f} %"
    axes.set_title(share, loc="right", fontsize=7.5, color=colour)
    if limit < _FAR * largest:
        draw_limits(axes, -limit, limit, "limit")


def _share_legend(figure: Figure, axes: Axes, limits: Array | None) -> None:
    handles, labels = axes.get_legend_handles_labels()
    title = (
        None if limits is None else "at the right of each panel: share of the limit used, both legs"
    )
    figure.legend(handles, labels, loc="lower center", ncols=3, title=title, title_fontsize=8.0)


def _joint_title(stance: str, swing: str) -> str:
    """Return what the names of a joint pair have in common: right_hip_yaw, left_hip_yaw."""
    words = [w for w in stance.replace("-", "_").split("_") if w in swing]
    return " ".join(words) if words else f"{stance} / {swing}"
