"""Figures of the motion: stick animation of one step and of several (Figs. 4 and 9)."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.body import walking_model
from gaitopt.view.figure_style import GROUND, STANCE, SWING, TRUNK, label_axes, new_figure
from gaitopt.view.skeleton import StickFigures, stick_figures
from gaitopt.view.walk import walk

_SIDE, _FRONT = 0, 1  # the horizontal axis of each view: x forward, y left
_FAINT = 0.22  # opacity of the first of the superposed figures; the last is solid
_BESIDE = 0.1  # m of ground ahead and behind
_EDGES = ([[0, 1], [2, 3]], [[0, 2], [1, 3]])  # ends of a sole seen from the side: toe, heel; front


def step_figure(gait: Gait, count: int = 9) -> Figure:
    """Draw one step as superposed stick figures, side and front view (Fig. 4).

    Args:
        gait: one step.
        count: number of stick figures, at equal times.
    """
    model = walking_model(gait)
    indices = np.linspace(0, len(gait.time) - 1, count).round().astype(int)
    film = walk(gait, model, 1)
    sticks = stick_figures(gait, model, film.q[indices])
    figure = new_figure(6.6, 4.9)
    spans = [np.ptp(_reach(sticks, view)) for view in (_SIDE, _FRONT)]  # for both to one scale
    side, front = figure.subplots(1, 2, sharey=True, width_ratios=spans)
    opacity = np.linspace(_FAINT, 1.0, count)
    for axes, view in ((side, _SIDE), (front, _FRONT)):
        _draw_ground(axes, sticks, view)
        for index in range(count):
            _draw(axes, sticks, index, view, float(opacity[index]))
    toes = gait.swing_sole[:, :2, ::2].mean(axis=1)
    side.plot(*toes.T, color=SWING, linewidth=0.9, linestyle=":", label="path of the swing toes")
    label_axes(side, "forward x [m]", "height z [m]", "from the right")
    label_axes(front, "left y [m]", "", "from behind")
    front.invert_xaxis()
    _name_legs(figure, side)
    figure.suptitle(f"One step: {gait.step_length:.3f} m in {gait.duration:.3f} s")
    return figure


def walking_figure(gait: Gait, steps: int = 3, per_step: int = 6) -> Figure:
    """Draw several steps as a row of stick figures (Fig. 9).

    Args:
        gait: one step.
        steps: number of steps.
        per_step: number of stick figures in each step.
    """
    model = walking_model(gait)
    film = walk(gait, model, steps)
    count = len(gait.time)
    inside = np.linspace(0, count - 1, per_step + 1).round().astype(int)[:-1]
    indices = np.concatenate([inside + k * count for k in range(steps)] + [[steps * count - 1]])
    sticks = stick_figures(gait, model, film.q[indices])
    figure = new_figure(7.4, 5.2)
    axes = figure.subplots()
    _draw_ground(axes, sticks, _SIDE)
    for index in range(len(indices)):
        _draw(axes, sticks, index, _SIDE, 0.95 if index % per_step == 0 else 0.4)
    label_axes(axes, "forward x [m]", "height z [m]")
    _name_legs(figure, axes, (gait.stance_sole, gait.swing_sole_frame))
    figure.suptitle(f"{steps} steps at {gait.speed:.3g} m/s; solid: the landings")
    return figure


def _draw(axes: Axes, sticks: StickFigures, index: int, view: int, opacity: float) -> None:
    """Draw one stick figure: far leg, trunk, near leg."""
    for leg, colour in ((1, SWING), (0, STANCE)):
        points = sticks.legs[index, leg]
        axes.plot(points[:, view], points[:, 2], "o-", markersize=2.4, color=colour, alpha=opacity)
        _draw_foot(axes, points[0], sticks.soles[index, leg], view, colour, opacity)
    hips = sticks.legs[index, :, -1]
    axes.plot(hips[:, view], hips[:, 2], color=TRUNK, alpha=opacity, linewidth=1.7)
    trunk = sticks.trunk[index]
    axes.plot(trunk[:, view], trunk[:, 2], color=TRUNK, alpha=opacity, linewidth=2.2)


def _draw_foot(
    axes: Axes, ankle: Array, sole: Array, view: int, colour: str, opacity: float
) -> None:
    """Draw the sole's middle line in this view and its ends to the ankle."""
    first, second = (sole[pair].mean(axis=0) for pair in _EDGES[view])
    outline = np.array([ankle, first, second, ankle])
    axes.plot(outline[:, view], outline[:, 2], linewidth=1.1, color=colour, alpha=opacity)


def _draw_ground(axes: Axes, sticks: StickFigures, view: int) -> None:
    axes.fill_between(_reach(sticks, view), -0.02, 0.0, color=GROUND, linewidth=0)
    axes.set_aspect("equal", adjustable="box")
    axes.grid(False)


def _reach(sticks: StickFigures, view: int) -> Array:
    """Return the ends (2,) of the ground that a view shows [m]."""
    points = (sticks.soles, sticks.trunk, sticks.legs)
    along = np.concatenate([part[..., view].ravel() for part in points])
    return np.array([along.min() - _BESIDE, along.max() + _BESIDE])


def _name_legs(
    figure: Figure, axes: Axes, names: tuple[str, str] = ("stance leg", "swing leg")
) -> None:
    for name, colour in zip((*names, "trunk"), (STANCE, SWING, TRUNK), strict=True):
        axes.plot([], [], color=colour, label=name.replace("_sole", " leg").replace("_", " "))
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
