"""Figures of the contact: ground force and friction (Fig. 5), centre of pressure (Fig. 6)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from gaitopt.gait.result import Gait
from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.model.physics_report import GRAVITY_KEY
from gaitopt.nlp import Array
from gaitopt.view.body import walking_model
from gaitopt.view.figure_style import (
    INSIDE,
    LIMIT,
    MEAN,
    SECOND,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    new_figure,
)
from gaitopt.view.skeleton import sole_corners

_AROUND = 0.012  # m, shown around the sole
_COP_WIDTH, _COP_INSIDE, _COP_TEXT = 6.4, 4.95, 0.9  # inch: figure, panel; text above and below
_COP_HEIGHTS = (1.2, 5.0)  # inch, of the panel


def force_figure(gait: Gait) -> Figure:
    """Draw the force of the ground on the stance foot, its mean and the weight (Fig. 5).

    Below it, how much of the friction is used: the tangential over the normal force.
    """
    figure = new_figure(6.4, 5.2)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
    _draw_force(above, gait)
    _draw_friction(below, gait)
    figure.suptitle("Force of the ground on the stance foot")
    return figure


def cop_figure(gait: Gait) -> Figure:
    """Draw the path of the centre of pressure in the stance sole (Fig. 6)."""
    corners = sole_corners(gait, walking_model(gait))
    long, wide = np.ptp(corners, axis=0)[:2] + 2.0 * _AROUND
    height = _COP_INSIDE * wide / long  # as high as the sole needs, else a band stays empty
    figure = new_figure(_COP_WIDTH, float(np.clip(height, *_COP_HEIGHTS)) + _COP_TEXT)
    axes = figure.subplots()
    _draw_sole(axes, corners)
    path = _draw_path(axes, gait)
    colours = figure.colorbar(path, ax=axes, pad=0.02)
    colours.set_label("time [s]")
    colours.outline.set_visible(False)
    margin = _margin(gait.cop, corners)
    label_axes(axes, "forward x [m]", "left y [m]")
    axes.set_aspect("equal")
    axes.grid(False)
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(f"Centre of pressure in the stance sole; nearest edge {1000.0 * margin:.1f} mm")
    return figure


def _draw_force(axes: Axes, gait: Gait) -> None:
    fx, fy, fz = gait.ground_wrench[:, :3].T
    axes.plot(gait.time, fz, color=STANCE, label="normal $f_z$")
    axes.plot(gait.time, fx, color=SWING, linewidth=1.2, label="forward $f_x$")
    axes.plot(gait.time, fy, color=SECOND, linewidth=1.2, label="sideways $f_y$")
    mean = float(np.diff(gait.time) @ (fz[:-1] + fz[1:])) / (2.0 * gait.duration)  # trapezoids
    axes.axhline(mean, color=MEAN, linewidth=1.2, linestyle="-.", label=f"mean $f_z$ {mean:.1f} N")
    mass = gait.number("mass")
    if mass is not None:
        gravity = gait.number("physics", GRAVITY_KEY) or STANDARD_GRAVITY
        weight = mass * gravity - (gait.number("physics", "carried_weight_N") or 0.0)
        axes.axhline(
            weight, color=TRUNK, linewidth=1.0, linestyle=":", label=f"weight {weight:.1f} N"
        )
    label_axes(axes, "", "force [N]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _draw_friction(axes: Axes, gait: Gait) -> None:
    force = gait.ground_wrench
    used = np.hypot(force[:, 0], force[:, 1]) / np.where(force[:, 2] > 0.0, force[:, 2], np.nan)
    axes.plot(gait.time, used, color=TRUNK, label="used")
    limit = gait.number("task", "margins", "friction")
    if limit is not None:
        axes.axhline(limit, color=LIMIT, linestyle="--", linewidth=1.0, label=f"allowed {limit:g}")
    axes.set_ylim(bottom=0.0)
    label_axes(axes, "time [s]", "friction [-]")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))


def _draw_sole(axes: Axes, corners: Array) -> None:
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    size = high - low
    axes.add_patch(
        Rectangle(
            (low[0], low[1]), size[0], size[1], facecolor=INSIDE, edgecolor=TRUNK, label="sole"
        )
    )
    axes.set_xlim(low[0] - _AROUND, high[0] + _AROUND)
    axes.set_ylim(low[1] - _AROUND, high[1] + _AROUND)
    axes.annotate("toe", (high[0], high[1]), (-2, 3), textcoords="offset points", ha="right")
    axes.annotate("heel", (low[0], high[1]), (2, 3), textcoords="offset points", ha="left")


def _draw_path(axes: Axes, gait: Gait) -> LineCollection:
    """Draw the path coloured by time, with its start and end."""
    segments = np.stack([gait.cop[:-1], gait.cop[1:]], axis=1)
    middle = (gait.time[:-1] + gait.time[1:]) / 2.0
    path = LineCollection(list(segments), array=middle, cmap="viridis", linewidth=2.2)
    path.set_clim(0.0, gait.duration)
    axes.add_collection(path)
    axes.plot(*gait.cop[0], "o", color=SECOND, markersize=7, label="start", clip_on=False)
    axes.plot(*gait.cop[-1], "s", color=SWING, markersize=7, label="end", clip_on=False)
    return path


def _margin(cop: Array, corners: Array) -> float:
    """Return the smallest distance of the path from the edge of the sole [m]."""
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    return float(min((cop - low).min(), (high - cop).min()))
