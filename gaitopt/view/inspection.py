"""How far gaitopt gets with a robot: its description, what was found in it, or why it stops.

What is known about a robot as tables of texts, for a terminal and for a page.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass
from gaitopt.design.summary import brace
from gaitopt.errors import RobotError
from gaitopt.gait.presets import stroll
from gaitopt.importers.reader import read_source
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source
from gaitopt.model.import_options import SIDES, ImportOptions
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.joint_limits import JointLimits
from gaitopt.model.kinematic_tree import pose_model
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.view.page_parts import Section


@dataclass(frozen=True, eq=False)
class Inspection:
    """What is known about a robot; what could not be reached is None.

    Attributes:
        title: name of the robot, or of its file.
        origin: where the description is from.
        source: the description.
        model: the whole robot, its root on a free-flyer.
        reading: legs, heading and soles found in it.
        robot: as gaits are designed for.
        refusal: why it cannot be used, empty if it can.
    """

    title: str
    origin: str
    source: Source | None = None
    model: pin.Model | None = None
    reading: ImportedRobot | None = None
    robot: Robot | None = None
    refusal: str = ""

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was found, guessed and changed."""
        if self.robot is not None:
            return self.robot.findings
        return () if self.reading is None else self.reading.findings

    @property
    def choices(self) -> ImportOptions | None:
        """Every guess made explicit, None if not even the legs were found."""
        return None if self.reading is None else self.reading.choices


def inspect_robot(urdf: str | Path, choices: ImportOptions, origin: str = "") -> Inspection:
    """Read a robot as far as possible; whatever is wrong with it is part of the result.

    Args:
        urdf: path of a URDF or MJCF file, or its text.
        choices: what was chosen about it.
        origin: where it is from, by default the path.
    """
    origin = origin or (str(urdf) if isinstance(urdf, Path) else "made by gaitopt")
    source = model = reading = robot = None
    refusal = ""
    try:
        source = read_source(urdf, choices.package_dirs)
        model = source.model()
        reading = import_robot(source, choices)
        robot = Robot.from_reading(source, reading)
    except RobotError as error:
        refusal = str(error)
    title = Path(origin).name if model is None else str(model.name)
    return Inspection(title, origin, source, model, reading, robot, refusal)


Row = tuple[str, ...]

_IN_THE_TABLE = ("legs", "pairs")  # topics whose plain facts the table of the legs shows
_STRAIGHT = 1e-3  # rad


def inspection_tables(inspection: Inspection) -> tuple[Section, ...]:
    """Return all tables of an inspection that have a row."""
    tables = [
        _overview(inspection),
        _legs(inspection),
        _findings(inspection.findings),
        _remedies(inspection.findings),
        _problems(inspection),
    ]
    return tuple(table for table in tables if table.rows)


def _overview(inspection: Inspection) -> Section:
    rows: list[Row] = [("file", inspection.origin)]
    source, model, robot = inspection.source, inspection.model, inspection.robot
    if source is not None and model is not None:
        links = sum(frame.type.name == "BODY" for frame in model.frames)
        joints = model.njoints - 2
        rows.append(("format", f"{source.format.upper()}, {links} links, {joints} joints"))
        mass = sum(inertia.mass for inertia in model.inertias)
        rows.append(("mass", f"{fixed(mass, 2)} kg"))
        if lost := source.mesh_problems():
            more = f"; {len(lost) - 1} more like it" if len(lost) > 1 else ""
            rows.append(("meshes", f"{lost[0]}{more}"))
    if robot is not None:
        rows += _size(robot)
    elif inspection.reading is None and model is not None:
        rows.append(("joints", ", ".join(str(n) for n in list(model.names)[2:])))
    return Section("Robot", ("", ""), tuple(rows))


def _size(robot: Robot) -> Iterator[Row]:
    legs = robot.legs
    apart = abs(legs.spacing)
    yield (
        "hips",
        f"{fixed(legs.height, 3)} m above the ground with straight legs, {fixed(apart, 3)} m apart",
    )
    yield ("leg", f"{fixed(legs.reach, 3)} m from hip to ankle when straight")
    speed = stroll(robot)
    step = legs.natural_step(speed)
    yield (
        "an easy walk",
        f"{fixed(speed, 2)} m/s: {fixed(step, 2)} m in {fixed(step / speed, 2)} s",
    )
    yield ("knees", _knees(robot))


def _knees(robot: Robot) -> str:
    row, straight = robot.legs.knees[0], float(robot.legs.straight[0])
    side = "increasing" if robot.legs.flexion[0] > 0.0 else "decreasing"
    low, high = robot.coupling.reach(row, robot.limits)
    end = (low - straight) if robot.legs.flexion[0] > 0.0 else (straight - high)
    note = ""
    if end > _STRAIGHT:
        note = f"; its range keeps it {fixed(end, 3)} rad from straight"
    elif np.isfinite(end) and end < -_STRAIGHT:
        note = f"; its range goes {-end:.3f} rad beyond straight, the walk does not"
    name, straight = robot.coupling.names[row], round(straight, 3) + 0.0  # no -0
    return f"'{name}' is straight at {straight:+.3f} rad and bends with {side} angle{note}"


def _legs(inspection: Inspection) -> Section:
    reading, robot = inspection.reading, inspection.robot
    columns = (
        "from hip to ankle", "mirror", "axis", ">range\nrad", ">torque\nN·m",
        ">speed\nrad/s", ">armature\nkg·m²",
    )  # fmt: skip
    if reading is None:
        return Section("Joints", columns, ())
    axes, rows = _axes(reading), []
    names = [[str(reading.model.names[j]) for j in leg] for leg in reading.legs]
    for place, pair in enumerate(zip(*names, strict=True)):
        own = pair[reading.stance]
        row = len(names[0]) - 1 - place  # limits begin at the ankle of the standing leg
        armature = reading.model.armature[reading.model.joints[reading.model.getJointId(own)].idx_v]
        rows.append(
            (
                brace(*sorted(pair)), _sign(robot, own), axes[own],
                *_limits(reading.limits, row, inspection, own), f"{armature:.3g}",
            )
        )  # fmt: skip
    side = SIDES[reading.stance]
    return Section(f"Joints; axis and range of the {side} leg", columns, tuple(rows))


def _sign(robot: Robot | None, name: str) -> str:
    """Return how the angle of a joint and that of its partner go together."""
    if robot is None:
        return ""
    if name not in robot.joint_names:
        row = robot.coupling.names.index(name)
        return f"follows {robot.joint_names[robot.coupling.motor[row]]}"
    row = robot.mirror[robot.joint_names.index(name)]
    return "equal" if row.sum() > 0.0 else "opposite"


def _limits(limits: JointLimits, row: int, inspection: Inspection, name: str) -> Row:
    spread = f"{fixed(limits.lower[row], 2)} to {fixed(limits.upper[row], 2)}"
    if np.isinf(limits.lower[row]) and np.isinf(limits.upper[row]):
        spread = "none"
    raw = (np.nan, np.nan)
    if inspection.model is not None:
        at = inspection.model.joints[inspection.model.getJointId(name)].idx_v
        raw = (inspection.model.effortLimit[at], inspection.model.velocityLimit[at])
    torque = _limit(float(limits.torque[row]), float(raw[0]))
    return spread, torque, _limit(float(limits.speed[row]), float(raw[1]))


def _limit(value: float, stated: float) -> str:
    """Return a limit; one that the file states but that stands for none is told with it."""
    if np.isfinite(value):
        return f"{value:.4g}"
    return "none" if not np.isfinite(stated) or stated == 0.0 else f"none ({stated:g})"


def _axes(reading: ImportedRobot) -> dict[str, str]:
    """Return the axis of each leg joint at the reference posture, in the robot's axes."""
    joints = [j for leg in reading.legs for j in leg]
    axes = pose_model(reading.model, reading.q).axes[joints] @ reading.rotation
    names = [str(reading.model.names[j]) for j in joints]
    return {name: axis_words(axis) for name, axis in zip(names, axes, strict=True)}


def axis_words(axis: Array) -> str:
    """Return the nearest of the axes forward x, left y, up z to one (3,), and the angle to it."""
    near = int(np.abs(axis).argmax())
    sign = "-" if axis[near] < 0.0 else "+"
    angle = float(np.degrees(np.arccos(np.clip(abs(axis[near]), 0.0, 1.0))))
    return f"{sign}{'xyz'[near]}" + (f" {angle:.0f}°" if angle >= 0.5 else "")


def _findings(findings: tuple[Finding, ...]) -> Section:
    told = [
        f
        for f in findings
        if f.topic != "file" and (f.topic not in _IN_THE_TABLE or f.how not in ("found", "given"))
    ]
    rows = tuple((f.topic, f.how, f"{f.subject}: {f.text}") for f in told)
    columns = ("about", "how sure", "what")
    return Section("Found, guessed and changed", columns, rows, tuple(f.how for f in told))


_REMEDIES = {
    "posture": 'posture = "POSE", srdf = "FILE"; or [posture] with JOINT = ANGLE in rad',
    "sole": "[sole] with toe, heel, left, right in m; sole_drop = height of the ankle above it",
    "heading": 'forward = "x" (or "-x", "y", ...); up = "z" (or three numbers)',
    "limits": '[[limits]] with joints = "*knee*" and torque, speed, lower, upper',
    "legs": 'feet = ["RIGHT FOOT", "LEFT FOOT"]: links, joints or frames',
    "armature": '[[limits]] with joints = "*" and armature in kg·m²',
    "symmetry": "asymmetry = by how much averaging left and right may change the robot at most",
}


def _remedies(findings: tuple[Finding, ...]) -> Section:
    topics = dict.fromkeys(f.topic for f in findings if f.how in ("guessed", "warning"))
    rows = tuple((t, _REMEDIES[t]) for t in topics if t in _REMEDIES)
    return Section("If that is wrong, write in the file for --choices", ("about", "TOML"), rows)


def _problems(inspection: Inspection) -> Section:
    found = inspection.reading or inspection.source
    problems = () if found is None else found.problems
    rows = tuple((str(p.line), p.text) for p in problems)
    return Section("Odd in the file", (">line", "what"), rows, ("warning",) * len(rows))
