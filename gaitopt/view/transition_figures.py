"""The figures of a transition: its motion, the ground's forces, and its joints, over all of it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.design.summary import group_name, joint_groups
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.mechanics.spatial import upright
from gaitopt.nlp import Array
from gaitopt.view.contacts import contact_colour, contact_words, contacts, flat_contact
from gaitopt.view.figure_parts import (
    SIDE,
    draw_ground,
    draw_limit,
    draw_sticks,
    joint_panels,
    name_panel,
    scale,
    share_legend,
)
from gaitopt.view.figure_style import (
    LIMIT,
    RULE,
    STANCE,
    SWING,
    TRUNK,
    label_axes,
    name_on_figure,
    new_figure,
)
from gaitopt.view.stick_figures import stick_figures, trunk_top

_POINTS = 60  # of a phase, both ends among them
_PER_STEP = 6  # stick figures
_BANDS = ((0.0, 0.02), (0.022, 0.042))  # of a panel's height: when each foot stands


def walking_figure(transition: Transition) -> Figure:
    """Draw what a transition leads from, its steps, and what it leads to, as stick figures."""
    trajectory = transition.trajectory
    ends = trajectory.breaks
    still = [phase.still for phase in trajectory.phases]
    times = [
        np.linspace(begin, end, 1 if rests else _PER_STEP, endpoint=False)
        for begin, end, rests in zip(ends, ends[1:], still, strict=False)
    ]
    whole = np.append(np.concatenate(times), trajectory.period)
    samples = trajectory.at(whole)
    body = trajectory.body
    sticks = stick_figures(body, samples.configuration, trunk_top(transition))
    sticks = sticks.turned(upright(body.gravity))
    figure = new_figure(9.0, 4.6)
    axes = figure.subplots()
    draw_ground(axes, sticks, SIDE, transition)
    for index, time in enumerate(whole):
        landing = np.abs(ends - time).min() < 1e-9
        stands = samples.contact[index]
        standing = tuple(np.flatnonzero(stands).tolist()), contact_colour(flat_contact(stands))
        draw_sticks(axes, sticks, index, SIDE, 0.95 if landing else 0.35, standing)
    label_axes(axes, "forward x [m]", "height z [m]")
    for name, colour in zip(_sides(transition), (STANCE, SWING), strict=True):
        axes.plot([], [], color=colour, label=name)
    for contact in contacts(transition):
        words = name_on_figure(contact_words(contact))
        axes.plot([], [], color=contact_colour(contact), label=f"foot {words}")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    figure.suptitle(f"{_title(transition)}; solid: the landings")
    return figure


def force_figure(transition: Transition) -> Figure:
    """Draw the force of the ground on either foot, and how much of the friction is used."""
    times, samples = _samples(transition)
    figure = new_figure(9.0, 5.2)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2.0, 1.0])
    normal = samples.wrench[..., 2]
    tangential = np.hypot(samples.wrench[..., 0], samples.wrench[..., 1])
    names = zip(_sides(transition), (STANCE, SWING), strict=True)
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
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    label_axes(above, "", "normal force [N]")
    label_axes(below, "time [s]", "friction [-]")
    figure.suptitle(f"{_title(transition)}: force of the ground on the feet")
    return figure


def torque_figure(transition: Transition) -> Figure:
    """Draw the torques of the joints of either leg against their limits."""
    limits = transition.joint_limit("torque")
    return _grid(transition, "torque", limits, "torque [N·m]", "joint torques")


def rate_figure(transition: Transition) -> Figure:
    """Draw the rates of the joints of either leg against their limits."""
    limits = transition.joint_limit("speed")
    return _grid(transition, "dq", limits, "rate [rad/s]", "joint rates")


def angle_figure(transition: Transition) -> Figure:
    """Draw the angles of the joints of either leg."""
    return _grid(transition, "q", None, "angle [rad]", "joint angles")


TRANSITION_FIGURES: dict[str, Callable[[Transition], Figure]] = {
    "ground_force": force_figure,
    "torques": torque_figure,
    "rates": rate_figure,
    "angles": angle_figure,
    "walk": walking_figure,
}


def _grid(transition: Transition, name: str, limits: Array | None, unit: str, title: str) -> Figure:
    """Draw panels from hip to ankle, in each the joint of both legs, in its own scale."""
    times, samples = _samples(transition)
    names = transition.trajectory.joint_names
    values = getattr(samples, name)[:, [names.index(one) for one in transition.joint_names]]
    groups = joint_groups(transition)
    figure, panels = joint_panels(len(groups), f"{_title(transition)}: {title}")
    for panel, (axes, group) in enumerate(zip(panels, groups, strict=True)):
        axes.axhline(0.0, color=RULE, linewidth=0.8)
        sides = _sides(transition) if len(group) > 1 else ("middle",)
        for joint, side, colour in zip(group, sides, (STANCE, SWING), strict=False):
            axes.plot(times, values[:, joint], color=colour, linewidth=1.2, label=side)
        own = list(group)
        drawn = [] if limits is None else draw_limit(axes, values[:, own], limits[own])
        scale(axes, np.append(values[:, own], drawn), float(np.abs(values).max()))
        _mark(axes, transition)
        name_panel(axes, panel, len(groups), unit, group_name(transition, group[0]))
    share_legend(figure, panels, " / ".join(_sides(transition)))
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


def _sides(transition: Transition) -> tuple[str, str]:
    """Return what the legs are called, as the feet in the order of contacts."""
    names = (transition.stance_sole, transition.swing_sole_frame)
    first, second = (name_on_figure(n.replace("_sole", " leg").replace("_", " ")) for n in names)
    return first, second


def _title(transition: Transition) -> str:
    return name_on_figure(f"{transition.words[0].upper()}{transition.words[1:]}")
