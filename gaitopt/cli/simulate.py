"""`gaitopt simulate`: a gait walked in MuJoCo under feedback, as tables, a page and a film."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np
import typer
from rich.table import Table

from gaitopt.atomic import make_directory, taken_by, write_atomically
from gaitopt.cli.command_options import SimulateOptions
from gaitopt.cli.display import ABSENT, new_table, screen, warn
from gaitopt.cli.process import ExitCode
from gaitopt.cli.results import SUMMARY, require_writable, write_record
from gaitopt.cli.show import loaded
from gaitopt.dataclass import dataclass
from gaitopt.design.summary import summarise
from gaitopt.design.walkability import WeakPoint, weak_points
from gaitopt.errors import InputError, did_you_mean
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.simulate.battery import PUSHED, Battery, Checked, battery, directions, suspect
from gaitopt.simulate.disturbance import Push, StartError
from gaitopt.simulate.mujoco_model import CONTACT_TIME, TIMESTEP, SimulatedRobot, simulated_robot
from gaitopt.simulate.reference import JointPD, both_feet
from gaitopt.simulate.second_engine import SecondEngine, second_engine
from gaitopt.simulate.stability import Stability, stability
from gaitopt.simulate.walk import MakeController, SimulatedWalk, WalkOptions, simulate
from gaitopt.simulate.whole_body import whole_body_walks
from gaitopt.view.animation import Replay, ShownPush
from gaitopt.view.page import simulated_page
from gaitopt.view.page_parts import Section

FRAMES = 30.0  # Hz, of the postures that are kept for them


def _require_views(page: Path | None, video: Path | None) -> None:
    """Check, before any work, that a page and a video can be written, where they are wanted."""
    for path, option in ((page, "--page"), (video, "--video")):
        if path is not None:
            if reason := taken_by(path):
                raise InputError(f"{option} {path}: {reason}; give the name of a file")
            require_writable(path.absolute().parent, option)
    if video is not None:
        from gaitopt.view.video import require_ffmpeg

        require_ffmpeg(video)


def replays(gait: Gait, walk: SimulatedWalk, tried: Battery | None) -> list[Replay]:
    """Return what can be shown: the undisturbed walk, the disturbed ones, the hardest pushes."""
    robot = simulated_robot(gait.trajectory.body)
    found = [_replay(robot, "undisturbed", walk)]
    if tried is not None:
        found += [_replay(robot, one.check.name, one.walk) for one in tried.checks]
        along = directions(gait)
        for limit in tried.pushes:
            if limit.walk is not None:
                x, y, z = (limit.impulse * along[limit.direction]).tolist()
                push = Push((x, y, z), step=PUSHED)
                landed = float(limit.walk.times[:PUSHED].sum()) - both_feet(gait.trajectory)
                shown = ShownPush(landed + push.phase * gait.duration, push.impulse)
                name = f"pushed {limit.direction}, {limit.impulse:.0f} N·s"
                found.append(_replay(robot, name, limit.walk, shown))
    return found


def _replay(robot: SimulatedRobot, name: str, walk: SimulatedWalk, *pushes: ShownPush) -> Replay:
    ending = walk.ending.value if walk.walked else f"{walk.ending.value} in step {walk.steps + 1}"
    configuration = robot.configuration(walk.motion[:, 1:])
    return Replay(name, ending, walk.motion[:, 0], configuration, pushes)


def _write_views(
    gait: Gait,
    shown: list[Replay],
    tables: Iterable[Table],
    page: Path | None,
    video: Path | None,
) -> Iterator[Path]:
    """Write the page and the video that are wanted; each path is told as it is written."""
    if page is not None:
        text = simulated_page(gait, shown, map(_section, tables))
        yield write_atomically(page, text.encode())
    if video is not None:
        from gaitopt.view.video import write_video

        yield write_video(gait, [one for one in shown if one.pushes or one is shown[0]], video)


def _section(table: Table) -> Section:
    """Return a table of the terminal as one of the page."""
    heads = [f"{'>' if c.justify == 'right' else ''}{c.header}" for c in table.columns]
    rows = zip(*([str(cell) for cell in column.cells] for column in table.columns), strict=True)
    return Section(str(table.title), tuple(heads), tuple(rows))


_DECIMALS = 4  # of what is told in SI units: what is nothing is told as 0
CONTROLLERS: dict[str, Callable[[], MakeController]] = {
    "whole-body": whole_body_walks,
    "joint-pd": lambda: lambda robot, trajectory, _: JointPD(robot, trajectory),
}
"""What returns the makers of the controllers that can be asked for, by name."""


def run(asked: SimulateOptions) -> None:
    """Walk a gait, print the report, write its numbers.

    Raises:
        typer.Exit: the robot fell, or the second engine differs.
        InputError: an unknown controller, or a number out of range.
    """
    output, page, video, controller = asked.output, asked.page, asked.video, asked.controller
    if output is not None:
        require_writable(output)
    _require_views(page, video)
    if controller not in CONTROLLERS:
        raise InputError(
            f"--controller {controller} is unknown; {did_you_mean(controller, CONTROLLERS)}choose "
            f"one of {', '.join(CONTROLLERS)}"
        )
    seen = page is not None or video is not None
    options = WalkOptions(
        steps=asked.steps, friction=asked.friction, frames=FRAMES if seen else 0.0
    )
    gait = loaded(asked.gait)
    make = CONTROLLERS[controller]()
    tell = _progress(asked.quiet)
    tell("undisturbed")
    walk = simulate(gait, options, make)
    tell("small disturbances")
    engine, points = second_engine(gait), weak_points(gait)
    try:
        orbit = stability(gait)
    except InputError:  # legs that do not take turns have no step-to-step map
        orbit = None
    tried = None
    if walk.walked:
        tried = battery(gait, options, make, thorough=asked.thorough, on_progress=tell)
    tell("")
    report = Report(gait, walk, engine, points, orbit, tried, controller, options)
    if output is not None:
        make_directory(output)
        record = {**summarise(gait), "simulation": simulation_record(report)}
        write_record(record, output / SUMMARY)
    if not asked.quiet:
        _print_report(report)
        if output is not None:
            typer.echo(f"wrote {output / SUMMARY}")
    if seen:
        for path in _write_views(gait, replays(gait, walk, tried), _tables(report), page, video):
            if not asked.quiet:
                typer.echo(f"wrote {path}")
    if not walk.walked or not engine.agrees:
        raise typer.Exit(ExitCode.NOT_CERTIFIED)


@dataclass(frozen=True, eq=False)
class Report:
    """Everything that was found out about a gait in simulation.

    Attributes:
        gait: what was walked.
        walk: undisturbed.
        engine: the second one's opinion of the gait.
        points: what was measured of its design.
        orbit: its stability to small disturbances; None where its legs do not take turns.
        tried: disturbed walks; None if it fell undisturbed.
        controller: name of the controller.
        options: of the walk.
    """

    gait: Gait
    walk: SimulatedWalk
    engine: SecondEngine
    points: tuple[WeakPoint, ...]
    orbit: Stability | None
    tried: Battery | None
    controller: str
    options: WalkOptions


def _progress(quiet: bool) -> Callable[[str], None]:
    """Return what shows the name of what is tried: in one line of a terminal, or a line each."""
    console = screen(stderr=True)
    if quiet:
        return lambda _: None
    if console.is_terminal:
        return lambda name: console.print(f"{name:40}", end="\r")
    return lambda name: console.print(f"walking: {name}") if name else None


def simulation_record(report: Report) -> dict[str, object]:
    """Return what was found out as JSON-able data, None where there is no number."""
    gait, walk, engine, options = report.gait, report.walk, report.engine, report.options
    lengths, times = walk.settled
    return {
        "ending": walk.ending.value,
        "steps": walk.steps,
        "asked_steps": walk.asked,
        "controller": report.controller,
        "contact": {
            "friction": options.friction,
            "stiffness_time_s": CONTACT_TIME,
            "timestep_s": TIMESTEP,
        },
        "speed_m_s": _finite(walk.speed),
        "designed_speed_m_s": walk.designed_speed,
        "step_length_m": {"mean": _mean(lengths), "sd": _spread(lengths)},
        "designed_step_length_m": walk.designed_speed * gait.duration,
        "step_time_s": {"mean": _mean(times), "sd": _spread(times)},
        "designed_step_time_s": gait.duration,
        "drift_m": walk.drift,
        "turn_rate_rad_s": _finite(walk.turn_rate),
        "designed_turn_rate_rad_s": walk.designed_turn_rate,
        "cost_N2ms": _per_metre(walk, walk.cost),
        "designed_cost_N2ms": _per_metre(walk, walk.designed_cost),
        "cost_over_designed": _finite(walk.cost / walk.designed_cost),
        "joints": {
            name: {"torque_Nm": float(torque), "speed_rad_s": float(rate)}
            for name, torque, rate in zip(gait.joint_names, walk.torque, walk.rate, strict=True)
        },
        "contact_force_N": walk.force,
        "simulated_s": walk.simulated,
        "seconds": walk.seconds,
        "second_engine": {**asdict(engine), "agrees": engine.agrees},
        "weak_points": [{**asdict(point), "weak": point.weak} for point in report.points],
        "stability": None if report.orbit is None else _stability_record(report.orbit),
        **({} if report.tried is None else _battery_record(report.tried, report.points)),
    }


def _stability_record(orbit: Stability) -> dict[str, object]:
    return {
        **{
            name: {
                "multiplier": feedback.multiplier,
                "linear_region_rad": feedback.region,
                "contraction_predicted": feedback.predicted,
                "contraction_measured": feedback.measured,
            }
            for name, feedback in (("joint_pd", orbit.joint_pd), ("lqr", orbit.lqr))
        },
        "landing_time_s_rad": {name: _finite(value) for name, value in orbit.landing.items()},
        "growth_at_the_edge": orbit.growth,
    }


def _battery_record(tried: Battery, points: tuple[WeakPoint, ...]) -> dict[str, object]:
    return {
        "checks": [_checked_record(one, points) for one in tried.checks],
        "pushes": [
            {
                "direction": push.direction,
                "impulse_Ns": push.impulse,
                "impulse_over_mass_m_s": push.over_mass,
                "speed_after_m_s": _finite(push.speed),
                "harder_not_tried": push.unbounded,
            }
            for push in tried.pushes
        ],
        "starts": [_checked_record(one, points) for one in tried.starts],
    }


def _checked_record(one: Checked, points: tuple[WeakPoint, ...]) -> dict[str, object]:
    walk = one.walk
    record: dict[str, object] = {
        "name": one.check.name,
        "passed": one.passed,
        "ending": walk.ending.value,
        "steps": walk.steps,
        "asked_steps": walk.asked,
        "speed_after_m_s": _finite(walk.last_speed),
        "cost_N2ms": _per_metre(walk, walk.cost),
        "cost_over_designed": _finite(walk.cost / walk.designed_cost),
    }
    if not one.passed:
        cause = suspect(one.check.tries, points)
        record |= {"cause": cause.name, "option": cause.option}
    return record


def _per_metre(walk: SimulatedWalk, cost: float) -> float | None:
    return None if walk.in_place else _finite(cost)


def _tables(report: Report) -> list[Table]:
    """Return everything that was measured."""
    found = [_table(report.gait, report.walk, report.options)]
    if report.tried is not None:
        found.append(_battery_table(report.tried, report.walk.designed_cost))
    if report.orbit is not None:
        found.append(_stability_table(report.orbit))
    return found


def _print_report(report: Report) -> None:
    walk, points, out = report.walk, report.points, screen()
    for table in _tables(report):
        out.print(table)
        out.print()
    out.print(f"second engine: {report.engine}")
    out.print(
        f"controller {report.controller}; {walk.simulated:.1f} s simulated in {walk.seconds:.1f} s"
    )
    weak = [point for point in points if point.weak]
    if walk.walked:
        for point in weak:
            warn(out, "fragile", str(point))
    if report.tried is not None:
        for cause, names in _causes(report.tried, points).items():
            warn(out, "cause", f"{', '.join(names)}: {cause}")
        return
    warn(out, "fell", f"{walk.ending.value} in step {walk.steps + 1} of {walk.asked}")
    for point in weak[:1]:
        warn(out, "cause", f"most likely the {point}")
    for point in weak[1:]:
        warn(out, "also", str(point))
    if not weak:
        warn(out, "cause", "none that is known in the gait; try another --controller or --friction")


def _causes(tried: Battery, points: tuple[WeakPoint, ...]) -> dict[str, list[str]]:
    """Return the names of the checks that failed by what in the gait they point to."""
    causes: dict[str, list[str]] = {}
    for one in (*tried.checks, *tried.starts):
        if not one.passed:
            point = suspect(one.check.tries, points)
            known = "most likely" if point.weak else "nothing that it tries is too weak; nearest is"
            names = causes.setdefault(f"{known} the {point}", [])
            if one.check.name not in names:
                names.append(one.check.name)
    return causes


def _stability_table(orbit: Stability) -> Table:
    """Return what small disturbances do."""
    table = new_table("Small disturbances", "per step", ">joint PD", ">LQR")
    both = orbit.joint_pd, orbit.lqr
    table.add_row("largest multiplier", *(f"{one.multiplier:.3f}" for one in both))
    table.add_row("contraction measured", *(f"{one.measured:.3f}" for one in both))
    table.add_row("sole stays flat up to", *(f"{1000.0 * one.region:.2g} mrad" for one in both))
    table.add_row("once its edge is reached", *[f"grows {orbit.growth:.1f} times"] * 2)
    corner = max(orbit.landing, key=lambda name: orbit.landing[name])
    for name in dict.fromkeys(("middle", corner)):
        row = f"{orbit.landing[name]:.2g} s/rad"
        table.add_row(f"landing moves, {name} of the sole", row, row)
    return table


def _battery_table(tried: Battery, designed_cost: float) -> Table:
    """Return what was survived."""
    table = new_table("Disturbed, without the controller's knowledge", "disturbance", ">result",
                      ">speed afterwards", ">cost / designed")  # fmt: skip
    for one in tried.checks:
        walk = one.walk
        result = f"{walk.steps} steps" if walk.walked else f"fell in step {walk.steps + 1}"
        slow = " (stumbles)" if walk.walked and not one.passed else ""
        cost = f"{walk.cost / designed_cost:.2f}" if one.passed else ABSENT
        speed = _number(walk.last_speed if walk.walked else None, "m/s")
        table.add_row(one.check.name, result + slow, speed, cost)
    for push in tried.pushes:
        more = "at least " if push.unbounded else ""
        size = f"{more}{push.impulse:.0f} N·s, {push.over_mass:.2f} m/s"
        table.add_row(f"push {push.direction}", size, _number(push.speed, "m/s"), ABSENT)
    if tried.starts:
        error = StartError()
        name = f"starts, sd {error.angle:g} rad, {error.rate:g} rad/s"
        table.add_row(name, f"{tried.starts_walked} of {len(tried.starts)}", ABSENT, ABSENT)
    return table


def _table(gait: Gait, walk: SimulatedWalk, options: WalkOptions) -> Table:
    """Return what was measured beside what was designed."""
    title = f"Walked in MuJoCo, friction {options.friction:g}"
    table = new_table(title, "quantity", ">simulated", ">designed")
    lengths, times = walk.settled
    table.add_row("steps", f"{walk.steps}", f"{walk.asked}")
    table.add_row("speed", _number(walk.speed, "m/s"), _number(walk.designed_speed, "m/s"))
    for name, values, design, unit in (
        ("step length", lengths, walk.designed_speed * gait.duration, "m"),
        ("step time", times, gait.duration, "s"),
    ):
        found = _number(_mean(values), unit)
        found += f" ± {1000.0 * values.std():.1f} m{unit}" if len(values) > 1 else ""
        table.add_row(name, found, _number(design, unit))
    if walk.designed_turn_rate:
        rates = (_number(one, "rad/s") for one in (walk.turn_rate, walk.designed_turn_rate))
        table.add_row("turning to the left", *rates)
    per, unit = ("second", "N²·m²") if walk.in_place else ("metre", "N²·m·s")
    table.add_row(
        f"squared torque per {per}", _number(walk.cost, unit), _number(walk.designed_cost, unit)
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
    if value is None or not math.isfinite(value):
        return ABSENT
    return f"{round(value, _DECIMALS) + 0.0:.4g} {unit}"


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _mean(values: Array) -> float | None:
    return float(values.mean()) if len(values) else None


def _spread(values: Array) -> float | None:
    return float(values.std()) if len(values) else None
