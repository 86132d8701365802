"""The figure of torque over speed: the loop that each motor runs through in a stride."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.actuators.motors import JointMotor, MotorTable
from gaitopt.design.requirements import MotorLoop
from gaitopt.units import RPM, motion_words
from gaitopt.view.figure_style import (
    GREY,
    LIMIT,
    label_axes,
    name_on_figure,
    new_figure,
    write_figure,
)

MOST = 8  # gaits that are told apart in a legend
_COLUMNS = 3
_WIDTH, _HEIGHT = 3.2, 2.6  # inch, of a panel
_LINE = 201  # points of a line of the envelope


def write_torque_speed_figure(
    loops: Mapping[str, Sequence[MotorLoop]], path: Path, table: MotorTable | None = None
) -> Path:
    """Draw the loops of every motor, a panel each, a line for each gait.

    Args:
        loops: of the motors, by label of the gait; the same motors in each.
        path: of the figure; its suffix chooses the form.
        table: motors whose envelopes are drawn around the loops.

    Returns:
        The path written.

    Raises:
        InputError: the file cannot be written.
    """
    return write_figure(path, lambda: torque_speed_figure(loops, table))


def torque_speed_figure(
    loops: Mapping[str, Sequence[MotorLoop]], table: MotorTable | None = None
) -> Figure:
    """Return the figure; see `write_torque_speed_figure`."""
    first = next(iter(loops.values()))
    motors = [one.motor for one in first]
    columns = min(_COLUMNS, len(motors))
    rows = -(-len(motors) // columns)
    figure = new_figure(_WIDTH * columns, _HEIGHT * rows + 0.3)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, (motor, panel) in enumerate(zip(motors, panels, strict=False)):
        slides = first[k].slides
        unit, size = ("m/s", 1.0) if slides else ("rpm", RPM)
        for label, of in loops.items():
            closed = np.append(np.arange(len(of[k].time)), 0)  # the stride repeats itself
            panel.plot(
                of[k].rate[closed] / size, of[k].torque[closed], linewidth=1.1,
                label=name_on_figure(label),
            )  # fmt: skip
        drive = None if table is None else first[k].drive(table)
        if drive is not None:
            _draw_envelope(panel, drive.at_joint())
        _draw_limits(panel, first[k], size)
        panel.axhline(0.0, color=GREY, linewidth=0.6)
        panel.axvline(0.0, color=GREY, linewidth=0.6)
        torque = motion_words("torque [N·m]", slides=slides)
        label_axes(panel, f"speed [{unit}]", torque, name_on_figure(motor))
    for panel in panels[len(motors) :]:
        panel.set_axis_off()
    if 1 < len(loops) <= MOST or (table is not None and len(loops) <= MOST):
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_limits(panel: Axes, loop: MotorLoop, size: float) -> None:
    """Draw the limits of a motor's torque and speed, that in units of a size [rad/s; m/s]."""
    for sign in (-1.0, 1.0):
        if loop.torque_limit is not None:
            panel.axhline(sign * loop.torque_limit, color=LIMIT, linewidth=1.0)
        if loop.speed_limit is not None:
            panel.axvline(sign * loop.speed_limit / size, color=LIMIT, linewidth=1.0)


def _draw_envelope(panel: Axes, motor: JointMotor) -> None:
    """Draw peak torque and voltage line in all quadrants, and the continuous torque."""
    drives = np.linspace(0.0, motor.no_load_speed, _LINE)
    brakes = np.full(_LINE, motor.peak_torque)
    speed = np.concatenate([-drives[::-1], drives]) / RPM
    torque = np.concatenate([brakes, motor.torque_at(drives)])
    panel.plot(speed, torque, color=LIMIT, linewidth=1.0, label="envelope of the motor")
    panel.plot(-speed, -torque, color=LIMIT, linewidth=1.0)
    for sign in (-1.0, 1.0):
        panel.axhline(sign * motor.continuous_torque, color=LIMIT, linestyle=":", linewidth=1.0)
