"""`gaitopt simulate`: a gait walked in MuJoCo under feedback."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import typer
from rich.table import Table

from gaitopt.atomic import write_atomically
from gaitopt.cli.display import ABSENT, new_table, screen, warn
from gaitopt.cli.process import ExitCode
from gaitopt.cli.report import print_findings_of
from gaitopt.cli.results import require_files
from gaitopt.errors import InputError
from gaitopt.gait.gait_file import load_gait
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import Trajectory
from gaitopt.nlp import Array
from gaitopt.simulate.controller import Controller, JointPD
from gaitopt.simulate.mujoco_model import ContactOptions, SimulatedRobot
from gaitopt.simulate.second_engine import SecondEngine, second_engine
from gaitopt.simulate.walk import Ending, SimulatedWalk, WalkOptions, simulate
from gaitopt.simulate.walkability import WeakPoint, weak_points
from gaitopt.simulate.whole_body import WholeBodyController

CONTROLLERS: dict[str, Callable[[SimulatedRobot, Trajectory, Array | None], Controller]] = {
    "whole-body": WholeBodyController,
    "joint-pd": lambda robot, trajectory, _: JointPD(robot, trajectory),
}
"""Makers of the controllers that can be asked for, by name."""


def run(
    path: Path, steps: int, controller: str, friction: float, output: Path | None, quiet: bool
) -> None:
    """Walk a gait, print the report, write its numbers.

    Args:
        path: gait file.
        steps: how many to walk.
        controller: one of `CONTROLLERS`.
        friction: coefficient of the ground.
        output: file for the numbers as JSON, if any.
        quiet: whether to print errors only.

    Raises:
        GaitoptError: the gait cannot be read or simulated, or the file not be written.
        typer.Exit: the robot fell, or the second engine differs.
    """
    require_files((output, "--output"))
    if controller not in CONTROLLERS:
        raise InputError(
            f"--controller {controller} is unknown; choose one of {', '.join(CONTROLLERS)}"
        )
    if not 0.0 < friction < math.inf:
        raise InputError(f"--friction {friction:g}: it must be above 0")
    gait = load_gait(path)
    print_findings_of(screen(stderr=True), gait)
    options = WalkOptions(steps=steps, contact=ContactOptions(friction=friction))
    walk = simulate(gait, options, CONTROLLERS[controller])
    engine, points = second_engine(gait), weak_points(gait)
    if output is not None:
        record = simulation_record(gait, walk, engine, points, controller, options)
        text = json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        write_atomically(output, text.encode())
    if not quiet:
        _print_report(gait, walk, engine, points, controller, options)
        if output is not None:
            typer.echo(f"wrote {output}")
    if walk.ending is not Ending.WALKED or not engine.agrees:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


def simulation_record(
    gait: Gait,
    walk: SimulatedWalk,
    engine: SecondEngine,
    points: tuple[WeakPoint, ...],
    controller: str,
    options: WalkOptions,
) -> dict[str, object]:
    """Return a simulated walk as JSON-able data, None where there is no number."""
    lengths, times = walk.settled
    return {
        "ending": walk.ending.value,
        "steps": walk.steps,
        "asked_steps": walk.asked,
        "controller": controller,
        "contact": {
            "friction": options.contact.friction,
            "stiffness_time_s": options.contact.stiffness_time,
            "timestep_s": options.contact.timestep,
        },
        "speed_m_s": _finite(walk.speed),
        "designed_speed_m_s": gait.speed,
        "step_length_m": {"mean": _mean(lengths), "sd": _spread(lengths)},
        "designed_step_length_m": gait.step_length,
        "step_time_s": {"mean": _mean(times), "sd": _spread(times)},
        "designed_step_time_s": gait.duration,
        "drift_m": walk.drift,
        "cost_N2ms": _finite(walk.cost),
        "designed_cost_N2ms": _finite(walk.designed_cost),
        "joints": {
            name: {"torque_Nm": float(torque), "speed_rad_s": float(rate)}
            for name, torque, rate in zip(gait.joint_names, walk.torque, walk.rate, strict=True)
        },
        "contact_force_N": walk.force,
        "simulated_s": walk.simulated,
        "seconds": walk.seconds,
        "second_engine": {
            "engine": engine.engine,
            "instants": engine.instants,
            "agrees": engine.agrees,
            "torque": engine.torque,
            "force": engine.force,
            "moment": engine.moment,
            "rate_after": engine.rate_after,
            "impulse": engine.impulse,
        },
        "weak_points": [
            {
                "name": point.name,
                "value": point.value,
                "bound": point.bound,
                "unit": point.unit,
                "weak": point.weak,
                "option": point.option,
            }
            for point in points
        ],
    }


def _print_report(
    gait: Gait,
    walk: SimulatedWalk,
    engine: SecondEngine,
    points: tuple[WeakPoint, ...],
    controller: str,
    options: WalkOptions,
) -> None:
    out = screen()
    out.print(_table(gait, walk, options))
    out.print(f"second engine: {engine}", soft_wrap=True)
    out.print(
        f"controller {controller}; {walk.simulated:.1f} s simulated in {walk.seconds:.1f} s",
        soft_wrap=True,
    )
    weak = [point for point in points if point.weak]
    if walk.ending is Ending.WALKED:
        for point in weak:
            warn(out, "fragile", str(point))
        return
    warn(out, "fell", f"{walk.ending.value} in step {walk.steps + 1} of {walk.asked}")
    for point in weak[:1]:
        warn(out, "cause", f"most likely the {point}")
    for point in weak[1:]:
        warn(out, "also", str(point))
    if not weak:
        warn(out, "cause", "none that is known in the gait; try another --controller or --friction")


def _table(gait: Gait, walk: SimulatedWalk, options: WalkOptions) -> Table:
    """Return what was measured beside what was designed."""
    title = f"Walked in MuJoCo, friction {options.contact.friction:g}"
    table = new_table(title, "quantity", ">simulated", ">designed")
    lengths, times = walk.settled
    table.add_row("steps", f"{walk.steps}", f"{walk.asked}")
    table.add_row("speed", _number(walk.speed, "m/s"), _number(gait.speed, "m/s"))
    for name, values, design, unit in (
        ("step length", lengths, gait.step_length, "m"),
        ("step time", times, gait.duration, "s"),
    ):
        found = _number(_mean(values), unit)
        found += f" ± {1000.0 * values.std():.1f} m{unit}" if len(values) > 1 else ""
        table.add_row(name, found, _number(design, unit))
    table.add_row(
        "squared torque per metre",
        _number(walk.cost, "N²·m·s"),
        _number(walk.designed_cost, "N²·m·s"),
    )
    if math.isfinite(walk.cost):
        table.add_row("closed loop / designed", f"{walk.cost / walk.designed_cost:.2f}", "1")
    for name, values, kind, unit in (
        ("peak torque", walk.torque, "torque", "N·m"),
        ("peak speed", walk.rate, "speed", "rad/s"),
    ):
        table.add_row(*_peak(gait, name, values, kind, unit))
    table.add_row("peak force of the ground", _number(walk.force, "N"), "")
    return table


def _peak(gait: Gait, name: str, values: Array, kind: str, unit: str) -> tuple[str, str, str]:
    """Return the row of the joint nearest to its limit, or of the largest where there is none."""
    limit = gait.joint_limit(kind)
    bounded = limit is not None and bool(np.isfinite(limit).any())
    share = values if limit is None or not bounded else np.nan_to_num(values / limit)
    joint = int(np.argmax(share))
    most = ABSENT if limit is None or not bounded else f"limit {_number(limit[joint], unit)}"
    return f"{name}, {gait.joint_names[joint]}", _number(values[joint], unit), most


def _number(value: float | None, unit: str) -> str:
    return ABSENT if value is None or not math.isfinite(value) else f"{value:.4g} {unit}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _mean(values: Array) -> float | None:
    return float(values.mean()) if len(values) else None


def _spread(values: Array) -> float | None:
    return float(values.std()) if len(values) else None
