"""What the figures of gaits and of transitions are drawn with: stick figures, panels of joints."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.design.summary import joint_groups
from gaitopt.gait.recorded import Recorded, ground_of
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.view.figure_style import (
    GROUND,
    LIMIT,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    name_on_figure,
    new_figure,
)
from gaitopt.view.stick_figures import StickFigures

SIDE, FRONT = 0, 1  # the horizontal axis of each view: x forward, y left
_GROUND_DEPTH = 0.02  # m, drawn
_BESIDE = 0.1  # m of ground ahead and behind
_EDGES = ([[0, 1], [2, 3]], [[0, 2], [1, 3]])  # ends of a sole seen from the side: toe, heel; front
_ABOVE_OTHERS = 3.0  # layer of a foot that rests: the same foot swings off from there
_FAR = 1.5  # a limit this many times the panel's own largest value would flatten its curves
_FLAT = 0.02  # of the figure's largest value: a panel shows no less, lest rounding looks like waves
_SPACE = 0.08  # free above and below the curves, in their heights
_ROW, COLUMNS = 2.5, 3  # panels of joints: inch, number
_PLACE = {"left": 0.075, "right": 0.99, "wspace": 0.16, "hspace": 0.17}
_BELOW, _ABOVE, _TITLE = 0.9, 0.475, 0.1  # inch: legend; title with its space, and above it
_LEGEND_ROW = 0.2  # inch
# Six panels are laid out by measuring each of their labels twice, which takes longer than drawing.

Standing = tuple[tuple[int, ...], str]
"""The feet that stand, and the colour of their contact; empty where that never changes."""


def draw_sticks(
    axes: Axes, sticks: StickFigures, index: int, view: int, opacity: float, standing: Standing
) -> None:
    """Draw one stick figure: far leg, trunk, near leg."""
    feet, contact = standing
    for leg, colour in ((1, SWING), (0, STANCE)):
        points = sticks.legs[index, leg]
        axes.plot(points[:, view], points[:, 2], "o-", markersize=2.4, color=colour, alpha=opacity)
        rests = bool(contact) and leg in feet
        own, above = (contact, _ABOVE_OTHERS) if rests else (colour, None)
        _draw_foot(axes, points[0], sticks.soles[index, leg], view, own, opacity, above)
    hips = sticks.legs[index, :, -1]
    axes.plot(hips[:, view], hips[:, 2], color=TRUNK, alpha=opacity, linewidth=1.7)
    trunk = sticks.trunk[index]
    axes.plot(trunk[:, view], trunk[:, 2], color=TRUNK, alpha=opacity, linewidth=2.2)


def _draw_foot(
    axes: Axes,
    ankle: Array,
    sole: Array,
    view: int,
    colour: str,
    opacity: float,
    above: float | None,
) -> None:
    """Draw the sole's middle line in this view and its ends to the ankle."""
    first, second = (sole[pair].mean(axis=0) for pair in _EDGES[view])
    outline = np.array([ankle, first, second, ankle])
    axes.plot(
        outline[:, view], outline[:, 2], linewidth=1.1, color=colour, alpha=opacity, zorder=above
    )


def ground_words(gait: Recorded) -> str:
    """Return the words of the ground, in which a dollar begins no formula."""
    return ground_of(gait).words.replace("$", r"\$")


def draw_ground(axes: Axes, sticks: StickFigures, view: int, gait: Gait | Transition) -> None:
    """Draw the ground: from the side with its slope or its shape."""
    x = reach(sticks, view)
    z = np.zeros(2)
    if view == SIDE:
        step = gait.step_length or float(np.ptp(x))  # in place any will do
        ends = np.sort(x / step)  # backward the steps go the other way
        first, last = (int(k) for k in np.floor(ends) + np.array([-1.0, 2.0]))
        along, height = ground_of(gait).along(first, last + 1, step).T
        R = upright(gait.trajectory.body.gravity)
        along, height = R[[0, 2]][:, [0, 2]] @ np.stack([along, height])
        order = np.argsort(along, kind="stable")
        along, height = along[order], height[order]
        inside = (along > x[0]) & (along < x[1])
        z = np.interp(x, along, height)
        x, z = np.r_[x[0], along[inside], x[1]], np.r_[z[0], height[inside], z[1]]
    axes.fill_between(x, z - _GROUND_DEPTH, z, color=GROUND, linewidth=0)
    axes.set_aspect("equal", adjustable="box")
    axes.grid(False)


def reach(sticks: StickFigures, view: int) -> Array:
    """Return the ends (2,) of the ground that a view shows [m]."""
    points = (sticks.soles, sticks.trunk, sticks.legs)
    along = np.concatenate([part[..., view].ravel() for part in points])
    return np.array([along.min() - _BESIDE, along.max() + _BESIDE])


def panel_joints(gait: Recorded) -> list[int]:
    """Return one joint of each pair: the stance leg's from the hip down, then all others."""
    return [group[0] for group in joint_groups(gait)]


def joint_panels(count: int, title: str, more: bool = False) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels for the joints, in rows, and space for a legend below.

    Args:
        count: of the panels.
        title: of the figure.
        more: whether the legend has a row more.
    """
    rows = -(-count // COLUMNS)
    height = rows * _ROW
    figure = new_figure(9.0, height, layout=None)
    below = _BELOW + (_LEGEND_ROW if more else 0.0)
    place = {**_PLACE, "bottom": below / height, "top": 1.0 - _ABOVE / height}
    axes = figure.subplots(rows, COLUMNS, sharex=True, squeeze=False, gridspec_kw=place).ravel()
    for one in axes[count:]:
        one.set_visible(False)
    figure.suptitle(title, y=1.0 - _TITLE / height)
    return figure, list(axes[:count])


def name_panel(axes: Axes, number: int, count: int, unit: str, name: str) -> None:
    """Name a panel of `joint_panels`, and its axes where they are at the edge."""
    last = number >= count - COLUMNS
    axes.xaxis.set_tick_params(labelbottom=last)
    x, y = "time [s]" if last else "", unit if number % COLUMNS == 0 else ""
    label_axes(axes, x, y, name_on_figure(name))


def draw_limit(axes: Axes, values: Array, limits: Array) -> list[float]:
    """Write the limit of both joints and the share used; draw it where their curves come near.

    Args:
        axes: the panel.
        values: of one joint or two, shape (N, 1 or 2).
        limits: of each, shape (1,) or (2,).

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


def scale(axes: Axes, shown: Array, largest: float) -> None:
    """Make a panel hold its own values (N,), zero, and something of the figure's largest value."""
    least = _FLAT * largest
    low, high = min(float(shown.min()), -least), max(float(shown.max()), least)
    space = _SPACE * (high - low)
    axes.set_ylim(low - space, high + space)


def share_legend(figure: Figure, panels: list[Axes], legs: str = "stance / swing leg") -> None:
    """Write one legend of whatever is drawn in any panel."""
    found = {
        label: handle
        for axes in panels
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    told = f"above each panel: the limit, and its share used by {legs}"
    title = told if any(axes.get_title(loc="right") for axes in panels) else None
    figure.legend(
        list(found.values()), list(found), loc="lower center", ncols=3, title=title,
        title_fontsize=8.0,
    )  # fmt: skip
