"""The figures of gaits and of transitions: motion, forces of the ground, joints.

Motion as stick figures (Figs. 4 and 9), ground force and friction (Fig. 5), centre of pressure
(Fig. 6), torques and rates of the motors against their limits; of a transition over all of it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike

from gaitopt.atomic import make_directory, write_atomically
from gaitopt.bounds import fixed
from gaitopt.design.summary import group_name, joint_groups
from gaitopt.errors import InputError, did_you_mean
from gaitopt.gait.assemble import GRAVITY_KEY
from gaitopt.gait.result import Gait, Recorded, ground_of
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.view.figure_style import (
    GREY,
    GROUND,
    INSIDE,
    KINDS,
    LIMIT,
    MEAN,
    RULE,
    SECOND,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    leg_names,
    legend_below,
    legends_beside,
    name_on_figure,
    panelled,
    rendered,
    styled,
)
from gaitopt.view.stick_figures import (
    StickFigures,
    contact_colour,
    contact_words,
    contacts,
    flat_contact,
    stick_figures,
    trunk_top,
)

SIDE, FRONT = 0, 1  # the horizontal axis of each view: x forward, y left
_GROUND_DEPTH = 0.02  # m, drawn
_BESIDE = 0.1  # m of ground ahead and behind
_EDGES = ([[0, 1], [2, 3]], [[0, 2], [1, 3]])  # ends of a sole seen from the side: toe, heel; front
_LAYER, _ABOVE_OTHERS = 2.0, 3.0  # of a foot that rests: the same foot swings off from there
_LEG, _SOLE, _HIPS, _BACK, _JOINT = 1.6, 1.1, 1.7, 2.2, 2.4  # points: widths of lines, joints
_FAR = 1.5  # a limit this many times the panel's own largest value would flatten its curves
_FLAT = 0.02  # of the figure's largest value: a panel shows no less, lest rounding looks like waves
_SPACE = 0.08  # free above and below the curves, in their heights
_HEIGHTS = (2.0, 1.0)  # of force and friction, to each other
_ROW, COLUMNS = 2.5, 3  # panels of joints: inch, number
_BESIDE_LIMIT, _ALONE, _TITLE = 17, 34, 70  # characters of names over a panel, and over a figure

Standing = tuple[tuple[int, ...], str]
"""The feet that stand, and the colour of their contact; empty where that never changes."""


def _draw_sticks(
    axes: Axes, sticks: StickFigures, view: int, opacity: ArrayLike, standing: Sequence[Standing]
) -> None:
    """Draw stick figures one after the other, in each: far leg, near leg, hips and trunk.

    All lines are of one object, or of two: as objects of their own they take ten times as long.
    """
    lines: list[tuple[float, float, Any, Array]] = []  # layer, width, colour, points
    for index, alpha in enumerate(np.broadcast_to(opacity, len(standing))):
        feet, contact = standing[index]
        for leg, colour in ((1, SWING), (0, STANCE)):
            points = sticks.legs[index, leg]
            lines.append((_LAYER, _LEG, to_rgba(colour, alpha), points))
            rests = bool(contact) and leg in feet
            shown, layer = (contact, _ABOVE_OTHERS) if rests else (colour, _LAYER)
            foot = _foot(points[0], sticks.soles[index, leg], view)
            lines.append((layer, _SOLE, to_rgba(shown, alpha), foot))
        trunk = to_rgba(TRUNK, alpha)
        lines.append((_LAYER, _HIPS, trunk, sticks.legs[index, :, -1]))
        lines.append((_LAYER, _BACK, trunk, sticks.trunk[index]))
    for layer in sorted({line[0] for line in lines}):
        _, widths, colours, points = zip(*(line for line in lines if line[0] == layer), strict=True)
        collection = LineCollection(
            [one[:, [view, 2]] for one in points], linewidths=widths, colors=colours, zorder=layer,
            capstyle="projecting", joinstyle="round",
        )  # fmt: skip
        axes.add_collection(collection)
    joints = [(colour, one) for _, width, colour, one in lines if width == _LEG]
    places = np.concatenate([one for _, one in joints])
    shades = np.repeat([colour for colour, _ in joints], [len(one) for _, one in joints], axis=0)
    axes.scatter(places[:, view], places[:, 2], _JOINT**2, shades, linewidths=1.0, zorder=_LAYER)


def _foot(ankle: Array, sole: Array, view: int) -> Array:
    """Return the sole's middle line in a view and its ends to the ankle, as points (4, 3)."""
    first, second = (sole[pair].mean(axis=0) for pair in _EDGES[view])
    return np.array([ankle, first, second, ankle])


def _ground_words(gait: Recorded) -> str:
    """Return the words of the ground, in which a dollar begins no formula."""
    return ground_of(gait).words.replace("$", r"\$")


def _draw_ground(axes: Axes, sticks: StickFigures, view: int, gait: Gait | Transition) -> None:
    """Draw the ground: from the side with its slope or its shape."""
    x, z, aside = reach(sticks, view), np.zeros(2), 0.0
    if view == SIDE:
        step = gait.step_length or float(np.ptp(x))  # in place any will do
        ends = np.sort(x / step)
        first, last = (int(k) for k in np.floor(ends) + np.array([-1.0, 2.0]))
        ground = ground_of(gait)
        along, height = ground.along(first, last + 1, step).T
        R = upright(gait.trajectory.body.gravity)
        along, height = R[[0, 2]][:, [0, 2]] @ np.stack([along, height])
        if step < 0.0:  # backward the steps go the other way
            along, height = along[::-1], height[::-1]
        along = np.maximum.accumulate(along)  # a riser's ends are at one place but for rounding
        inside = (along > x[0]) & (along < x[1])
        z = np.interp(x, along, height)
        x, z = np.r_[x[0], along[inside], x[1]], np.r_[z[0], height[inside], z[1]]
        aside = _GROUND_DEPTH * np.sign(z[-1] - z[0]) if ground.shaped else 0.0  # under risers, too
    top, under = np.stack([x, z]), np.stack([x + aside, z - _GROUND_DEPTH])
    band = np.concatenate([top, under[:, ::-1]], axis=1).T
    axes.add_collection(PolyCollection([band], facecolor=GROUND))
    axes.set_aspect("equal", adjustable="box")
    axes.grid(False)


def reach(sticks: StickFigures, view: int) -> Array:
    """Return the ends (2,) of the ground that a view shows [m]."""
    points = (sticks.soles, sticks.trunk, sticks.legs)
    along = np.concatenate([part[..., view].ravel() for part in points])
    return np.array([along.min() - _BESIDE, along.max() + _BESIDE])


def _joint_panels(count: int, title: str) -> tuple[Figure, list[Axes]]:
    """Return a figure with panels for the joints, in rows."""
    rows = -(-count // COLUMNS)
    size = (9.0, rows * _ROW)
    figure, axes = panelled(size, title, rows, COLUMNS, titles=True, hspace=0.17, sharex=True)
    for one in axes[count:]:
        one.set_visible(False)
    return figure, axes[:count]


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
    share = f"limit {limit:.4g}: {' / '.join(map(_percent, used))}"
    near = [side * limit for side in (-1, 1) if limit < _FAR * (side * values).max()]
    axes.set_title(share, loc="right", fontsize=7.5, color=colour)
    for line in near:
        axes.axhline(line, color=LIMIT, linestyle="--", linewidth=1.0, label="limit")
    return near


def _percent(share: float) -> str:
    """Return a share in few characters: there is not much room beside the name of a joint."""
    return f"{100.0 * share:.0f} %" if share < 9.995 else ">999 %"


def scale(axes: Axes, shown: Array, largest: float) -> None:
    """Make a panel hold its own values (N,), zero, and something of the figure's largest value."""
    least = _FLAT * largest
    low, high = min(float(shown.min()), -least), max(float(shown.max()), least)
    space = _SPACE * (high - low)
    axes.set_ylim(low - space, high + space)


def _share_legend(figure: Figure, panels: list[Axes], legs: str) -> None:
    """Write one legend of whatever is drawn in any panel."""
    found = {
        label: handle
        for axes in panels
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    told = f"above each panel: the limit, and its share used by {legs}"
    title = told if any(axes.get_title(loc="right") for axes in panels) else ""
    legend_below(figure, list(found.values()), list(found), COLUMNS, title)


_POINTS = 60  # of a phase, both ends among them
_STICKS_PER_STEP = 6  # stick figures
_BANDS = ((0.0, 0.02), (0.022, 0.042))  # of a panel's height: when each foot stands


def _transition_walk(transition: Transition) -> Figure:
    """Draw what a transition leads from, its steps, and what it leads to, as stick figures."""
    trajectory = transition.trajectory
    ends = trajectory.breaks
    still = [phase.still for phase in trajectory.phases]
    times = [
        np.linspace(begin, end, 1 if rests else _STICKS_PER_STEP, endpoint=False)
        for begin, end, rests in zip(ends, ends[1:], still, strict=False)
    ]
    whole = np.append(np.concatenate(times), trajectory.period)
    samples = trajectory.at(whole)
    body = trajectory.body
    sticks = stick_figures(body, samples.configuration, trunk_top(transition))
    sticks = sticks.turned(upright(body.gravity))
    figure, (axes,) = panelled((9.0, 4.6), f"{_title(transition)}; solid: the landings")
    _draw_ground(axes, sticks, SIDE, transition)
    landing = np.abs(whole[:, None] - ends).min(axis=1) < 1e-9
    standing = [
        (tuple(np.flatnonzero(stands).tolist()), contact_colour(flat_contact(stands)))
        for stands in samples.contact
    ]
    _draw_sticks(axes, sticks, SIDE, np.where(landing, 0.95, 0.35), standing)
    label_axes(axes, "forward x [m]", "height z [m]")
    _name_legs(figure, axes, transition, leg_names(transition))
    return figure


def _transition_forces(transition: Transition) -> Figure:
    """Draw the force of the ground on either foot, and how much of the friction is used."""
    times, samples = _samples(transition)
    title = f"{_title(transition)}: force of the ground on the feet"
    figure, (above, below) = panelled((9.0, 5.2), title, 2, sharex=True, height_ratios=_HEIGHTS)
    normal = samples.wrench[..., 2]
    tangential = np.hypot(samples.wrench[..., 0], samples.wrench[..., 1])
    names = zip(leg_names(transition), (STANCE, SWING), strict=True)
    for foot, (name, colour) in enumerate(names):
        stands = samples.contact[:, foot]
        above.plot(times, np.where(stands, normal[:, foot], np.nan), color=colour, label=name)
        presses = stands & (normal[:, foot] > 0.0)
        used = tangential[:, foot] / np.where(presses, normal[:, foot], np.nan)
        below.plot(times, used, color=colour, label=name)
    above.plot(times, normal.sum(axis=1), ":", color=TRUNK, linewidth=1.0, label="both together")
    limit = transition.number("task", "margins", "friction")
    if limit is not None:
        below.axhline(limit, color=LIMIT, linestyle="--", linewidth=1.0, label=f"allowed {limit:g}")
    for axes in (above, below):
        axes.set_ylim(bottom=0.0)
        _mark(axes, transition)
    label_axes(above, "", "normal force [N]")
    label_axes(below, "time [s]", "friction [-]")
    legends_beside(figure)
    return figure


def _samples(transition: Transition) -> tuple[Array, TrajectorySamples]:
    """Return instants of all phases, two where one follows another, and the motion at them."""
    trajectory = transition.trajectory
    ends = trajectory.breaks
    times = np.concatenate([np.linspace(begin, end, _POINTS) for begin, end in pairwise(ends)])
    before = np.tile(np.arange(_POINTS) == _POINTS - 1, len(ends) - 1)
    return times, trajectory.at(times, before=before)


def _mark(axes: Axes, transition: Transition) -> None:
    """Draw when the transition begins and ends, and below when each foot stands."""
    trajectory = transition.trajectory
    ends = trajectory.breaks
    contact = trajectory.at(0.5 * (ends[1:] + ends[:-1])).contact
    for begin, end, stands in zip(ends, ends[1:], contact, strict=False):
        colour = contact_colour(flat_contact(stands))
        for foot in np.flatnonzero(stands):
            low, high = _BANDS[foot]
            axes.axvspan(begin, end, low, high, color=colour, linewidth=0)
    for time in (transition.begins, transition.begins + transition.duration):
        axes.axvline(time, color=RULE, linewidth=0.8, linestyle=":")


def _title(transition: Transition) -> str:
    return name_on_figure(f"{transition.words[0].upper()}{transition.words[1:]}", _TITLE)


_SUPERPOSED = 9  # stick figures of one step
_IN_A_ROW, _PER_STEP = 3, 6  # steps of a walk, and stick figures in each
_FAINT = 0.22  # opacity of the first of the superposed figures; the last is solid
_AROUND = 0.012  # m, shown around the sole
_COP_WIDTH, _COP_INSIDE, _COP_TEXT = 6.4, 4.85, 1.0  # inch: figure, panel; text above and below
_COP_BAR = (1.015, 0.0, 0.035, 1.0)  # of the panel: the bar of its colours
_COP_RIGHT = 0.85  # inch, for the bar
_COP_HEIGHTS = (1.2, 5.0)  # inch, of the panel
_PHASES = 0.035  # of a panel's height: the band of the phases at its foot


FORCES = ("normal $f_z$", "forward $f_x$", "sideways $f_y$")
"""Names of the ground's forces; formulas take long to set."""
_LINES = ("-", "--")  # of a step, and of the second of a stride
_STEPS = ("", ", 2nd step mirrored")


def step_figure(gait: Gait) -> Figure:
    """Draw one step as superposed stick figures at equal times, side and front view (Fig. 4)."""
    indices = np.linspace(0, len(gait.time) - 1, _SUPERPOSED).round().astype(int)
    along, standing = _sticks(gait, gait.time, before=gait.time > 0.0)
    whole = along.turned(upright(gait.trajectory.body.gravity))
    seen = {SIDE: whole.at(indices), FRONT: along.at(indices)}  # along the ground from behind
    spans = [np.ptp(reach(sticks, view)) for view, sticks in seen.items()]  # for both to one scale
    where = f", {words}" if (words := _ground_words(gait)) else ""
    which = "One step" if gait.second is None else "First step of a stride"
    which += f": {fixed(gait.step_length, 3)} m in {fixed(gait.duration, 3)} s"
    figure, (side, front) = panelled(
        (6.6, 4.9), f"{which}{where}", 1, 2,
        titles=True, sharey=True, width_ratios=spans,
    )  # fmt: skip
    opacity = np.linspace(_FAINT, 1.0, _SUPERPOSED)
    for axes, view in ((side, SIDE), (front, FRONT)):
        _draw_ground(axes, seen[view], view, gait)
        _draw_sticks(axes, seen[view], view, opacity, [standing[index] for index in indices])
    toes = whole.soles[:, 1, :2].mean(axis=1)
    side.plot(
        toes[:, 0], toes[:, 2], color=SWING, linewidth=0.9, linestyle=":",
        label="path of the swing toes",
    )  # fmt: skip
    label_axes(side, "forward x [m]", "height z [m]", "from the right")
    label_axes(front, "left y [m]", "", "from behind")
    front.invert_xaxis()
    _name_legs(figure, side, gait, ("stance leg", "swing leg", "trunk"))
    return figure


def walking_figure(gait: Gait) -> Figure:
    """Draw several steps as a row of stick figures (Fig. 9)."""
    inside = np.linspace(0, len(gait.time) - 1, _PER_STEP + 1).round().astype(int)[:-1]
    times = [gait.time[inside] + k * gait.duration for k in range(_IN_A_ROW)]
    along, standing = _sticks(gait, np.append(np.concatenate(times), _IN_A_ROW * gait.duration))
    sticks = along.turned(upright(gait.trajectory.body.gravity))
    where = f" {words}" if (words := _ground_words(gait)) else ""
    title = f"{_IN_A_ROW} steps at {gait.way}{where}; solid: the landings"
    figure, (axes,) = panelled((7.4, 5.2), title)
    _draw_ground(axes, sticks, SIDE, gait)
    landing = np.arange(len(standing)) % _PER_STEP == 0
    _draw_sticks(axes, sticks, SIDE, np.where(landing, 0.95, 0.4), standing)
    label_axes(axes, "forward x [m]", "height z [m]")
    _name_legs(figure, axes, gait, (*leg_names(gait), "trunk"))
    return figure


def _sticks(
    gait: Gait, times: Array, before: ArrayLike = False
) -> tuple[StickFigures, list[Standing]]:
    """Return stick figures of a walk at times [s], and how it stands in each."""
    samples = gait.trajectory.at(times, before=before)
    sticks = stick_figures(gait.trajectory.body, samples.configuration, trunk_top(gait))
    several = len(gait.phases) > 1
    standing = [
        (
            tuple(np.flatnonzero(feet).tolist()),
            contact_colour(gait.phases[phase].contact) if several else "",
        )
        for feet, phase in zip(samples.contact, samples.phase, strict=True)
    ]
    return sticks, standing


def _name_legs(figure: Figure, axes: Axes, gait: Gait | Transition, names: tuple[str, ...]) -> None:
    for name, colour in zip(names, (STANCE, SWING, TRUNK), strict=False):
        axes.plot([], [], color=colour, label=name)
    if isinstance(gait, Transition) or len(gait.phases) > 1:
        for contact in contacts(gait):
            axes.plot([], [], color=contact_colour(contact), label=f"foot {_words(contact)}")
    legend_below(figure, *axes.get_legend_handles_labels(), 4)


def _words(contact: str) -> str:
    """Return how a foot stands: "on the toe line"."""
    return name_on_figure(contact_words(contact))


def _mark_phases(axes: Axes, gait: Gait) -> None:
    """Draw the phases of a step of several at the foot of a panel over time."""
    if len(gait.phases) == 1:
        return
    for phase in gait.phases:
        axes.axvspan(
            phase.begin, phase.end, ymax=_PHASES, color=contact_colour(phase.contact), linewidth=0,
            label=f"foot {_words(phase.contact)}",
        )  # fmt: skip
    for phase in gait.phases[1:]:
        axes.axvline(phase.begin, color=RULE, linewidth=0.8, linestyle=":")


def _joint_figure(
    gait: Gait | Transition, name: str, limit: str | None, unit: str, title: str
) -> Figure:
    """Draw panels from hip to ankle, in each the joint of both legs, in its own scale.

    Args:
        gait: what is drawn.
        name: of an array of gaits and of samples.
        limit: kind of its limits, as of `Recorded.joint_limit`.
        unit: of the axis, with what it shows.
        title: what all panels show.
    """
    curves, groups = _curves(gait, name), joint_groups(gait)
    limits = None if limit is None else gait.joint_limit(limit)
    whole = np.concatenate([values for _, values, _, _ in curves])
    title = f"{_title(gait)}: joint {title}" if isinstance(gait, Transition) else f"Joint {title}"
    figure, panels = _joint_panels(len(groups), title)
    for panel, (axes, group) in enumerate(zip(panels, groups, strict=True)):
        axes.axhline(0.0, color=RULE, linewidth=0.8)
        for times, values, line, legs in curves:
            both = tuple(zip(legs, (STANCE, SWING), strict=True))
            names = both if len(group) > 1 else (("middle", GREY),)
            for joint, (leg, colour) in zip(group, names, strict=True):
                axes.plot(times, values[:, joint], line, color=colour, label=leg)
        own = list(group)
        drawn = [] if limits is None else draw_limit(axes, whole[:, own], limits[own])
        scale(axes, np.append(whole[:, own], drawn), float(np.abs(whole).max()))
        _mark(axes, gait) if isinstance(gait, Transition) else _mark_phases(axes, gait)
        last = panel >= len(groups) - COLUMNS
        axes.xaxis.set_tick_params(labelbottom=last)
        x, y = "time [s]" if last else "", unit if panel % COLUMNS == 0 else ""
        room = _BESIDE_LIMIT if axes.get_title(loc="right") else _ALONE
        label_axes(axes, x, y, name_on_figure(group_name(gait, group[0]), room))
    legs = leg_names(gait) if isinstance(gait, Transition) else ("stance", "swing leg")
    _share_legend(figure, panels, " / ".join(legs))
    return figure


def _curves(gait: Gait | Transition, name: str) -> list[tuple[Array, Array, str, tuple[str, str]]]:
    """Return times (N,), values of the joints (N, J), style and names of both legs, by curve."""
    if isinstance(gait, Transition):
        times, samples = _samples(gait)
        names = gait.trajectory.joint_names
        values = getattr(samples, name)[:, [names.index(one) for one in gait.joint_names]]
        return [(times, values, "-", leg_names(gait))]
    return [
        (own.time, getattr(own, name), line, (f"stance leg{words}", f"swing leg{words}"))
        for own, line, words in zip(gait.steps, _LINES, _STEPS, strict=False)
    ]


def force_figure(gait: Gait) -> Figure:
    """Draw the force of the ground on the stance foot, its mean and the weight (Fig. 5).

    Below it, how much of the friction is used: the tangential over the normal force.
    """
    title = "Force of the ground on the stance foot"
    figure, (above, below) = panelled((6.4, 5.2), title, 2, sharex=True, height_ratios=_HEIGHTS)
    _draw_force(above, gait)
    _draw_friction(below, gait)
    legends_beside(figure)
    return figure


def cop_figure(gait: Gait) -> Figure:
    """Draw the path of the centre of pressure in the stance sole (Fig. 6).

    Of a stride that of the second step's mirror image is drawn too, thin.
    """
    corners = gait.trajectory.body.sole_corners[0]
    long, wide = np.ptp(corners, axis=0)[:2] + 2.0 * _AROUND
    flat = np.concatenate([own.cop[own.flat] for own in gait.steps])
    low, high = corners.min(axis=0)[:2], corners.max(axis=0)[:2]
    margin = min((flat - low).min(), (high - flat).min())  # beyond, it is at an edge by intent
    title = f"Centre of pressure in the stance sole; nearest edge {fixed(1000.0 * margin, 1)} mm"
    height = _COP_INSIDE * wide / long  # as high as the sole needs, else a band stays empty
    size = (_COP_WIDTH, float(np.clip(height, *_COP_HEIGHTS)) + _COP_TEXT)
    figure, (axes,) = panelled(size, title, right=_COP_RIGHT)
    _draw_sole(axes, corners)
    paths = [_draw_path(axes, own, line) for own, line in zip(gait.steps, _LINES, strict=False)]
    path = paths[0]
    colours = figure.colorbar(path, cax=axes.inset_axes(_COP_BAR))
    colours.set_label("time [s]")
    colours.outline.set_visible(False)
    label_axes(axes, "forward x [m]", "left y [m]")
    axes.set_aspect("equal")
    axes.grid(False)
    legend_below(figure, *axes.get_legend_handles_labels(), 3)
    return figure


def _draw_force(axes: Axes, gait: Gait) -> None:
    mean = 0.0
    for own, line, words in zip(gait.steps, _LINES, _STEPS, strict=False):
        (fx, fy, fz), later = own.ground_wrench[:, :3].T, words if gait.second is not None else ""
        for force, words, colour, width in zip(
            (fz, fx, fy), FORCES, (STANCE, SWING, SECOND), (1.6, 1.2, 1.2), strict=True
        ):
            axes.plot(own.time, force, line, color=colour, linewidth=width, label=words + later)
        total = float(np.diff(own.time) @ (fz[:-1] + fz[1:])) / 2.0  # trapezoids
        mean += total / (own.duration * len(gait.steps))
        if own.closing:
            late = own.time[own.time > own.knots[-1]]
            both = own.front_wrench_at(late)[:, 2]
            axes.plot(late, both, color=STANCE, linestyle="--", label=f"front foot $f_z${later}")
    told = f"mean $f_z$ {fixed(mean, 1)} N"
    axes.axhline(mean, color=MEAN, linewidth=1.2, linestyle="-.", label=told)
    mass = gait.number("mass")
    if mass is not None:
        gravity = gait.number("physics", GRAVITY_KEY) or STANDARD_GRAVITY
        weight = mass * gravity - (gait.number("physics", "carried_weight_N") or 0.0)
        axes.axhline(
            weight, color=TRUNK, linewidth=1.0, linestyle=":", label=f"weight {fixed(weight, 1)} N"
        )
    label_axes(axes, "", "force [N]")
    _mark_phases(axes, gait)


def _draw_friction(axes: Axes, gait: Gait) -> None:
    for own, line, words in zip(gait.steps, _LINES, _STEPS, strict=False):
        force, later = own.ground_wrench, words if gait.second is not None else ""
        used = np.hypot(force[:, 0], force[:, 1]) / np.where(force[:, 2] > 0.0, force[:, 2], np.nan)
        axes.plot(own.time, used, line, color=TRUNK, label=f"used{later}")
    limit = gait.number("task", "margins", "friction")
    if limit is not None:
        axes.axhline(limit, color=LIMIT, linestyle="--", linewidth=1.0, label=f"allowed {limit:g}")
    axes.set_ylim(bottom=0.0)
    label_axes(axes, "time [s]", "friction [-]")


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


def _draw_path(axes: Axes, gait: Gait, line: str) -> LineCollection:
    """Draw the path coloured by time, with its start and end; thin of a second step."""
    segments = np.stack([gait.cop[:-1], gait.cop[1:]], axis=1)
    middle = (gait.time[:-1] + gait.time[1:]) / 2.0
    width = 2.2 if line == _LINES[0] else 1.0
    path = LineCollection(list(segments), array=middle, cmap="viridis", linewidth=width)
    path.set_clim(0.0, gait.duration)
    axes.add_collection(path)
    for point, mark, colour, label in ((0, "o", SECOND, "start"), (-1, "s", SWING, "end")):
        (end,) = axes.plot(
            *gait.cop[point], mark, color=colour, markersize=7, clip_on=False,
            label=label if line == _LINES[0] else "",
        )  # fmt: skip
        end.set_in_layout(False)  # of a walk that is none it may be far outside
    return path


_OF_JOINTS: dict[str, Callable[[Any], Figure]] = {
    "torques": partial(
        _joint_figure, name="torque", limit="torque", unit="torque [N·m]", title="torques"
    ),
    "rates": partial(_joint_figure, name="dq", limit="speed", unit="rate [rad/s]", title="rates"),
    "angles": partial(_joint_figure, name="q", limit=None, unit="angle [rad]", title="angles"),
}
TRANSITION_FIGURES: dict[str, Callable[[Any], Figure]] = {
    "ground_force": _transition_forces,
    **_OF_JOINTS,
    "walk": _transition_walk,
}
FIGURES: dict[str, Callable[[Any], Figure]] = {
    "step": step_figure,
    "ground_force": force_figure,
    "cop": cop_figure,
    **_OF_JOINTS,
    "walk": walking_figure,
}


@checked_arguments
def make_figure(gait: Gait | Transition, name: str) -> Figure:
    """Return one of the figures named in `FIGURES`, of a transition in `TRANSITION_FIGURES`.

    Raises:
        InputError: there is no figure of that name.
        RobotError: the gait's URDF cannot be drawn.
    """
    drawings = _drawings(gait)
    if name not in drawings:
        hint = did_you_mean(name, drawings)
        raise InputError(f"there is no figure '{name}'; {hint}choose from {', '.join(drawings)}")
    with styled():
        return drawings[name](gait)


def _drawings(gait: Gait | Transition) -> dict[str, Callable[[Any], Figure]]:
    return TRANSITION_FIGURES if isinstance(gait, Transition) else FIGURES


@checked_arguments
def write_figures(
    gait: Gait | Transition,
    directory: str | Path,
    formats: Collection[str] = ("png",),
    names: Collection[str] | None = None,
) -> list[Path]:
    """Write figures of a gait or a transition to a directory, made if it does not exist.

    Args:
        gait: what to draw.
        directory: where to.
        formats: any of "png" (150 dots per inch), "svg" and "pdf".
        names: which, as of `make_figure`; None for all.

    Returns:
        The files written.

    Raises:
        InputError: a format or a name is unknown, or the directory cannot be written.
        RobotError: the gait's URDF cannot be drawn.
    """
    unknown = set(formats) - set(KINDS)
    if unknown:
        raise InputError(
            f"figures cannot be written as {sorted(unknown)}; {did_you_mean(min(unknown), KINDS)}"
            f"choose {', '.join(KINDS)}"
        )
    folder = make_directory(Path(directory))
    written = []
    for name in _drawings(gait) if names is None else names:
        figure = make_figure(gait, name)
        for kind in formats:
            written.append(write_atomically(folder / f"{name}.{kind}", rendered(figure, kind)))
    return written
