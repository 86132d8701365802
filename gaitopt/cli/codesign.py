"""`gaitopt codesign`: lengths, masses, gears and walks of a robot chosen together."""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os.path import exists
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console

from gaitopt.actuators.motors import MOTORS, MotorTable, read_motors
from gaitopt.atomic import cannot_go_on, make_directory, write_atomically
from gaitopt.bounds import JOURNAL, read_bounded
from gaitopt.catalogue.biped_spec import BipedSpec
from gaitopt.catalogue.parameters import PARAMETERS, changed, parameter_name, write_spec
from gaitopt.cli.command_options import CodesignOptions
from gaitopt.cli.config import SCHEMA, Settings
from gaitopt.cli.display import screen
from gaitopt.cli.idle import refuse_idle
from gaitopt.cli.motors import MOTOR_FILE, motors_text
from gaitopt.cli.process import ExitCode, StopRequest, print_error, stop_on_interrupt
from gaitopt.cli.request import (
    Request,
    biped_spec,
    choices_text,
    make_request,
    make_robot,
    make_task,
)
from gaitopt.cli.results import keep_files, require_writable
from gaitopt.design.codesign import (
    RATIO,
    CoDesign,
    DesignTrial,
    Study,
    Variable,
    WalkCase,
    codesign,
    first_walks,
    geared_joints,
    own_ratio,
    own_values,
    with_proportions,
)
from gaitopt.design.process import small_matrices
from gaitopt.design.requirements import UNITS, requirements, worst_case
from gaitopt.errors import GaitFileError, InputError, StoppedError, did_you_mean, there_are
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.result import Gait
from gaitopt.gait.task import Task, task_record
from gaitopt.model.import_options import choices_record
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.sweep.grid import parse_axis
from gaitopt.units import motion_words, read_number, read_quantity
from gaitopt.view.codesign_page import write_codesign_page

TRIALS, REPORT, SUMMARY = "trials.jsonl", "report.html", "codesign.json"
SPEC, CHOICES = "spec.toml", "choices.toml"
MOST_WALKS = 100
_ANOTHER_ROBOT = ("robot", "urdf", "spec", "set", "choices", "motors")
"""Options that a walk cannot have of its own: all are of one robot."""
_FORMAT = 1


def run(given: Settings, asked: CodesignOptions) -> None:
    """Choose numbers of the robot, and write robot, walks and report."""
    directory, quiet = asked.output, asked.quiet
    require_writable(directory)
    names = (TRIALS, SPEC, CHOICES, MOTOR_FILE)
    keep_files(directory, names, (asked.config, *given.values()))
    study, base = _study_of(given, asked)
    options, starts = base.options, base.starts
    out = screen()
    record = {"format": _FORMAT, **study_record(study)}
    earlier = earlier_trials(directory / TRIALS, record)
    started = time.monotonic()
    with stop_on_interrupt() as stop, small_matrices():
        before = _first(study, base, directory, earlier is not None, stop)
        if earlier is None:
            _append(directory / TRIALS, record)
        elif not quiet:
            many = "" if len(earlier) == 1 else "s"
            out.print(f"goes on after {len(earlier)} design{many} of {directory / TRIALS}")
        best = np.inf

        def told(trial: DesignTrial) -> None:
            nonlocal best
            _append(directory / TRIALS, trial_record(trial))
            if not quiet:
                _print_trial(out, study, trial, best, time.monotonic() - started)
            best = min(best, trial.cost)

        try:
            found = codesign(
                study, options, earlier=earlier or (), before=before, starts=starts,
                on_trial=told, stop=stop,
            )  # fmt: skip
        except StoppedError:
            kept = f"the designs tried are kept in '{directory / TRIALS}'"
            print_error(f"interrupted; {kept}, and the same command goes on")
            raise typer.Exit(ExitCode.INTERRUPTED) from None
    for name, gaits in (("before", found.before), ("after", found.after)):
        _save(directory / name, gaits)
    written = ", ".join(_write_robot(study, found.values, directory))
    summary = summary_of(study, found)
    text = json.dumps(summary, indent=1, ensure_ascii=False)
    write_atomically(directory / SUMMARY, text.encode())
    page = write_codesign_page(summary, directory / REPORT)
    if not quiet:
        _print_result(out, summary)
        out.print(f"wrote {page}, and with it {written}, {SUMMARY}, before/, after/")


def _study_of(given: Settings, asked: CodesignOptions) -> tuple[Study, Request]:
    """Return the study that is asked for, and the request behind it."""
    walks, vary = _asked_walks(asked.speeds, asked.walk), asked.vary
    base = make_request(given, asked.config, {name for _, _, own in walks for name in own})
    spec = biped_spec(base.settings) or base.robot
    robots: dict[str, tuple[Robot, Callable[[Mapping[str, float]], Robot]]] = {}
    cases = []
    for label, weight, own in walks:
        settings = {**base.settings, **own}
        of_robot = repr(sorted((k, v) for k, v in own.items() if k in SCHEMA["robot"]))
        if of_robot not in robots:
            robot = make_robot(settings)
            made = _file_robot_maker(robot) if spec is base.robot else _robot_maker(settings)
            robots[of_robot] = robot, made
        robot, made = robots[of_robot]
        task = make_task(settings, robot)
        refuse_idle(own, task, robot)
        cases.append(WalkCase(label, weight, task, made))
    if not vary:
        raise InputError("a co-design needs numbers to choose: --vary shin=25cm:35cm, repeatable")
    motors = _motors(base, vary)
    variables = tuple(_variable(text, spec, motors) for text in vary)
    return Study(spec, variables, tuple(cases), asked.keep_leg, motors), base


def _motors(base: Request, vary: Sequence[str]) -> MotorTable | None:
    """Return the table of motors, a drive of its own for all joints whose ratio is chosen."""
    if (path := base.settings.get("motors")) is None:
        return None
    table = read_motors(path)
    for text in vary:
        if joints := geared_joints(text.partition("=")[0].strip()):
            table = table.apart(joints, base.robot.joint_names)
    return table


def _file_robot_maker(robot: Robot) -> Callable[[Mapping[str, float]], Robot]:
    """Return what makes a robot of a file, as a walk has it, in other proportions."""
    own = own_values(robot)

    def made(values: Mapping[str, float]) -> Robot:
        again = Robot.from_urdf(robot.urdf, choices=with_proportions(robot, own, values))
        return again.as_before(robot.findings)

    return made


def _robot_maker(settings: Settings) -> Callable[[Mapping[str, float]], Robot]:
    own = dict(settings.get("set", {}))
    return lambda values: make_robot({**settings, "set": {**own, **values}})


def _asked_walks(
    speeds: str | None, walks: Sequence[str]
) -> list[tuple[str, float, dict[str, Any]]]:
    """Return label, weight and settings of each walk."""
    found: list[tuple[str, float, dict[str, Any]]] = []
    if speeds is not None:
        found += [(f"{v:g} m/s", 1.0, {"speed": v}) for v in parse_axis("speed", speeds).values]
    known = {
        name: one
        for part in ("task", "margins", "robot")
        for name, one in SCHEMA[part].items()
        if name not in _ANOTHER_ROBOT
    }
    for text in walks:
        own, weight = {}, 1.0
        if not text.strip():
            raise InputError("--walk is empty; give NAME=VALUE words, as in --walk 'speed=0.8'")
        for word in text.split():
            name, equals, value = word.partition("=")
            name = name.replace("-", "_")
            try:
                if name == "weight" and equals:
                    weight = read_number(value)
                elif name in known and equals:
                    read = known[name].read(value)
                    own[name] = (read,) if known[name].repeatable else read
                else:
                    why = "; the robot is the same for all walks" if name in _ANOTHER_ROBOT else ""
                    raise ValueError(
                        f"give NAME=VALUE words, of options of optimise, or weight=2{why}"
                    )
            except ValueError as error:
                raise InputError(f"--walk '{text[:80]}': {word[:40]}: {error}") from None
        if not 0.0 < weight < np.inf:
            raise InputError(
                f"--walk '{text[:80]}': the weight must be above 0; give weight=1, or leave it out"
            )
        found.append((text, weight, own))
    if not found:
        raise InputError(
            "give the walks that the robot is designed for: --speeds 0.5:1.2:0.1, or --walk "
            "'speed=0.8 slope=10% weight=2', repeatable"
        )
    if len(found) > MOST_WALKS:
        raise InputError(f"{len(found)} walks are too many; give at most {MOST_WALKS}")
    labels = [label for label, _, _ in found]
    if twice := {label for label in labels if labels.count(label) > 1}:
        raise InputError(f"the walk '{min(twice)}' is given twice; give it once, with a weight")
    return found


def _variable(text: str, spec: BipedSpec | Robot, motors: MotorTable | None) -> Variable:
    name, equals, rest = (part.strip() for part in text.partition("="))
    known = parameter_name(name) if geared_joints(name) is None else name
    if known is None or not equals:
        raise InputError(
            f"--vary {text[:80]}: {did_you_mean(name, own_values(spec))}give NAME=LOWER:UPPER, as "
            f"in --vary shin=25cm:35cm; there are {', '.join(own_values(spec))}, and with "
            f"--motors the ratios of gears, {MOTORS}{RATIO} or {MOTORS}JOINTS.{RATIO}"
        )
    unit = "" if known == name and geared_joints(name) is not None else PARAMETERS[known].unit
    given = rest.split(":")
    if len(given) not in (2, 3):
        raise InputError(f"--vary {text[:80]}: give NAME=LOWER:UPPER or NAME=LOWER:UPPER:START")
    try:
        lower, upper, *start = (read_quantity(one.strip(), unit) for one in given)
    except ValueError as error:
        raise InputError(
            f"--vary {text[:80]}: {error}; give NAME=LOWER:UPPER or NAME=LOWER:UPPER:START"
        ) from None
    own = own_values(spec).get(known) if unit else own_ratio(motors, known)
    if own is None:
        of = " of a robot of a file" if isinstance(spec, Robot) else ""
        raise InputError(
            f"--vary {text[:80]}: '{known}'{of} cannot be chosen; "
            f"{there_are(own_values(spec), known)}"
        )
    return Variable(known, lower, upper, start[0] if start else float(np.clip(own, lower, upper)))


def study_record(study: Study) -> dict[str, Any]:
    """Return what a study asks, JSON-able: trials belong to one."""
    return {
        "variables": [[v.name, v.lower, v.upper, v.start] for v in study.variables],
        "walks": [
            [case.label, case.weight, _print_of(*walk)]
            for case, walk in zip(study.walks, study.each(study.begun), strict=True)
        ],
        "keep_leg": study.keep_leg,
    }


def _print_of(robot: Robot, task: Task) -> str:
    """Return a text by which a walk's robot and task are known again."""
    asked = {
        "urdf": robot.urdf,
        "choices": choices_record(robot.choices),
        "task": task_record(task),
    }
    return hashlib.sha256(json.dumps(asked, sort_keys=True).encode()).hexdigest()[:16]


def trial_record(trial: DesignTrial) -> dict[str, Any]:
    """Return a trial as JSON-able data."""
    return {
        "values": trial.values.tolist(),
        "cost": trial.cost,
        "gradient": trial.gradient.tolist(),
        "costs": trial.costs.tolist(),
        "evaluations": trial.evaluations,
        "seconds": trial.seconds,
        "round": trial.round,
        "points": [
            [x.tolist(), [[int(k), float(y[k])] for k in np.flatnonzero(y)], int(y.size)]
            for x, y in trial.points
        ],
    }


def trial_of(record: Mapping[str, Any]) -> DesignTrial:
    """Return the trial of a record made by `trial_record`."""
    points = []
    for x, pairs, size in record["points"]:
        y: Array = np.zeros(int(size))
        for k, value in pairs:
            y[int(k)] = float(value)
        points.append((np.array(x, dtype=np.float64), y))
    return DesignTrial(
        values=np.array(record["values"], dtype=np.float64),
        cost=float(record["cost"]),
        gradient=np.array(record["gradient"], dtype=np.float64),
        costs=np.array(record["costs"], dtype=np.float64),
        evaluations=int(record["evaluations"]),
        seconds=float(record["seconds"]),
        points=tuple(points),
        round=int(record["round"]),
    )


def earlier_trials(path: Path, record: Mapping[str, Any]) -> list[DesignTrial] | None:
    """Return the trials of a run that was interrupted, None where there was none.

    A last line that was cut short is left out.

    Raises:
        InputError: the file is of another study, or cannot be read.
    """
    if not exists(path):
        return None
    try:
        lines = read_bounded(path, JOURNAL).decode().splitlines()
        head = json.loads(lines[0]) if lines else {}
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"'{path}' cannot be read: {error}; remove it to begin anew") from error
    if head != json.loads(json.dumps(record)):
        raise InputError(
            f"'{path}' holds trials of another study; give another directory, or remove the file"
        )
    trials = []
    for number, line in enumerate(lines[1:], 2):
        try:
            trials.append(trial_of(json.loads(line)))
        except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
            if number == len(lines):
                break
            raise InputError(
                f"line {number} of '{path}' is no trial: {error}; remove the file to begin anew"
            ) from error
    return trials


def _append(path: Path, record: Mapping[str, Any]) -> None:
    """Append a line, all of it on the disk before the next trial begins."""
    try:
        whole = path.read_bytes() if exists(path) else b""
        if whole and not whole.endswith(b"\n"):  # of a process that was killed while it wrote
            whole = whole[: whole.rfind(b"\n") + 1]
            write_atomically(path, whole)
        with path.open("ab") as stream:
            stream.write(json.dumps(record).encode() + b"\n")
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as error:
        raise cannot_go_on(path, error) from error


def _first(
    study: Study, base: Request, directory: Path, goes_on: bool, stop: StopRequest
) -> list[Gait]:
    """Return the walks of the robot as it is: of the directory, if they are there."""
    folder = directory / "before"
    if goes_on and len(list(folder.glob("*.npz"))) == len(study.walks):
        try:
            return [load_gait(folder / f"{k + 1}.npz") for k in range(len(study.walks))]
        except GaitFileError:
            pass  # they are made again
    gaits = list(first_walks(study, base.options, stop, base.starts))
    _save(folder, gaits)
    return gaits


def _write_robot(study: Study, values: Mapping[str, float], directory: Path) -> list[str]:
    """Write the robot that was found, and its motors if chosen; return the names of the files."""
    names, drives = [SPEC if isinstance(study.spec, BipedSpec) else CHOICES], study.drives(values)
    own = {name: value for name, value in values.items() if geared_joints(name) is None}
    if isinstance(study.spec, BipedSpec):
        write_spec(replace(changed(study.spec, own), name=study.spec.name), directory / SPEC)
    else:
        choices = with_proportions(study.spec, study.own, own)
        write_atomically(directory / CHOICES, choices_text(choices).encode())
    if drives is not None:
        write_atomically(directory / MOTOR_FILE, motors_text(drives, "codesign").encode())
        names.append(MOTOR_FILE)
    return names


def _save(folder: Path, gaits: Sequence[Gait]) -> None:
    make_directory(folder)
    for number, gait in enumerate(gaits, 1):
        save_gait(gait, folder / f"{number}.npz")


def summary_of(study: Study, found: CoDesign) -> dict[str, Any]:
    """Return what was found, JSON-able."""
    weights = [case.weight for case in study.walks]
    costs = [[float(gait.cost or 0.0) for gait in gaits] for gaits in (found.before, found.after)]
    whole = [float(np.dot(weights, each)) for each in costs]
    own = {name: study.own[name] for name in found.values}
    units = {one.name: one.unit for one in study.variables}
    return {
        "robot": study.spec.name,
        "cost_unit": found.before[0].cost_unit,
        "parameters": {
            name: {
                "unit": units.get(name, "m"), "of_the_robot": own[name],
                "begun_at": study.begun[name], "found": value,
            }
            for name, value in found.values.items()
        },
        "walks": [
            {
                "walk": case.label, "weight": case.weight, "before": a.cost, "after": b.cost,
                "certified": b.certified,
            }
            for case, a, b in zip(study.walks, found.before, found.after, strict=True)
        ],
        "motors": _motors_of(found),
        "before": whole[0],
        "after": whole[1],
        "trials": [
            {"values": t.values.tolist(), "cost": t.cost, "round": t.round} for t in found.trials
        ],
        "variables": [v.name for v in study.variables],
        "evaluations": found.evaluations,
        "seconds": sum(t.seconds for t in found.trials),
        "held": list(found.held),
    }  # fmt: skip


_ASKED = ("peak_torque", "peak_speed", "rms_torque", "peak_power")
"""Figures of a motor that are told before and after."""
_MORE = 0.01  # of the largest of its kind, by which a figure grows for its motor to be told of


def _motors_of(found: CoDesign) -> dict[str, dict[str, Any]]:
    """Return what each motor must deliver before and after, the most over all walks.

    With it the largest of each figure among all motors of its units, before or after: a designer
    measures changes by it.
    """
    told: dict[str, dict[str, Any]] = {}
    for name, gaits in (("before", found.before), ("after", found.after)):
        # A walk may move other joints than the next, so that each is asked by itself.
        asked = [one for gait in gaits for one in requirements({"": gait})]
        for one in worst_case(asked, _ASKED):
            own = told.setdefault(one.motor, {})
            own[name] = {figure: one.values[figure] for figure in _ASKED}
            own["units"] = {k: motion_words(UNITS[k], slides=one.slides) for k in _ASKED}
    for own in told.values():
        alike = [one for one in told.values() if one["units"] == own["units"]]
        own["largest"] = {
            k: max(one[name][k] for one in alike for name in ("before", "after")) for k in _ASKED
        }
    return told


def _print_trial(
    out: Console, study: Study, trial: DesignTrial, best: float, seconds: float
) -> None:
    values = ", ".join(
        f"{v.name.replace('_', ' ')} {value:.4f} {v.unit}".rstrip()
        for v, value in zip(study.variables, trial.values, strict=True)
    )
    mark = "" if trial.cost < best else ", no better"
    out.print(f"{seconds:6.1f} s  {values}: {trial.cost:.6g}{mark}")


def _print_result(out: Console, summary: Mapping[str, Any]) -> None:
    for name, one in summary["parameters"].items():
        out.print(
            f"{name.replace('_', ' ')}: {one['begun_at']:.4g} -> {one['found']:.4g} "
            f"{one['unit']}".rstrip()
        )
    share = summary["after"] / summary["before"] - 1.0
    out.print(
        f"cost of all walks: {summary['before']:.6g} -> {summary['after']:.6g} "
        f"{summary['cost_unit']} ({100.0 * share:+.2f} %), {len(summary['trials'])} designs, "
        f"{summary['evaluations']} evaluations of walks"
    )
    certified = sum(walk["certified"] for walk in summary["walks"])
    out.print(f"{certified} of {len(summary['walks'])} walks are certified")
    for text in summary["held"]:
        out.print(text)
    if more := most_more(summary["motors"]):
        out.print(f"what a motor must deliver more: {more}; all of them are in {REPORT}")


def most_more(motors: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the figure of a motor that grows most, over the largest of its kind; empty: none."""
    grown = {
        (motor, figure): (one["after"][figure] - before) / one["largest"][figure]
        for motor, one in motors.items()
        for figure, before in one["before"].items()
        if one["largest"][figure] > 0.0
    }
    motor, figure = max(grown, key=lambda one: grown[one], default=("", ""))
    if not grown or grown[motor, figure] < _MORE:
        return ""
    one = motors[motor]
    before, after, unit = one["before"][figure], one["after"][figure], one["units"][figure]
    return f"{motor}, {figure.replace('_', ' ')} {before:.3g} -> {after:.3g} {unit}"
