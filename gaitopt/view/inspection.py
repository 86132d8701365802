"""How far gaitopt gets with a robot: its description, what was found in it, or why it stops.

What is known about a robot as tables of texts, for a terminal and for a page, on which it stands at
its reference posture with the axes of its leg joints and its soles.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pinocchio as pin

from gaitopt.atomic import write_atomically
from gaitopt.dataclass import dataclass
from gaitopt.design.summary import brace
from gaitopt.errors import RobotError
from gaitopt.escape import filled_template, html_text
from gaitopt.gait.presets import stroll
from gaitopt.importers.reader import read_source
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source
from gaitopt.model.import_options import SIDES, ImportOptions
from gaitopt.model.importer import ImportedRobot, import_robot
from gaitopt.model.legs.joint_limits import JointLimits
from gaitopt.model.legs.kinematic_tree import pose_model
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array
from gaitopt.view.page_parts import Page, Section, table_text
from gaitopt.view.robot_shapes import draw_shape, unloaded
from gaitopt.view.viewer import Node, RecordingWindow, geometry, packed_viewer, page_file


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
        rows.append(("mass", f"{mass:.2f} kg"))
        rows += _mesh_rows(inspection)
    if robot is not None:
        rows += _size(robot)
    elif inspection.reading is None and model is not None:
        rows.append(("joints", ", ".join(str(n) for n in list(model.names)[2:])))
    return Section("Robot", ("", ""), tuple(rows))


def _mesh_rows(inspection: Inspection) -> Iterator[Row]:
    lost = [] if inspection.source is None else inspection.source.mesh_problems()
    if lost:
        more = f"; {len(lost) - 1} more like it" if len(lost) > 1 else ""
        yield ("meshes", f"{lost[0]}{more}")


def _size(robot: Robot) -> Iterator[Row]:
    legs = robot.legs
    apart = abs(legs.spacing)
    yield ("hips", f"{legs.height:.3f} m above the ground with straight legs, {apart:.3f} m apart")
    yield ("leg", f"{legs.reach:.3f} m from hip to ankle when straight")
    speed = stroll(robot)
    step = legs.natural_step(speed)
    yield ("an easy walk", f"{speed:.2f} m/s: {step:.2f} m in {step / speed:.2f} s")
    yield ("knees", _knees(robot))


def _knees(robot: Robot) -> str:
    row, straight = robot.legs.knees[0], float(robot.legs.straight[0])
    side = "increasing" if robot.legs.flexion[0] > 0.0 else "decreasing"
    low, high = robot.coupling.reach(row, robot.limits)
    end = (low - straight) if robot.legs.flexion[0] > 0.0 else (straight - high)
    note = ""
    if end > _STRAIGHT:
        note = f"; its range keeps it {end:.3f} rad from straight"
    elif np.isfinite(end) and end < -_STRAIGHT:
        note = f"; its range goes {-end:.3f} rad beyond straight, the walk does not"
    name = robot.coupling.names[row]
    return f"'{name}' is straight at {_tidy(straight):+.3f} rad and bends with {side} angle{note}"


def _tidy(angle: float) -> float:
    return round(angle, 3) + 0.0  # no -0


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
    spread = f"{limits.lower[row]:.2f} to {limits.upper[row]:.2f}"
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


_ARROW = 0.14  # length of an axis, in heights of the robot
_THICK = 0.006  # its radius, likewise
_CAMERA = (1.15, 0.25, 0.75)  # ahead, up, right; likewise
_PLATE = 0.004  # m: thickness of a sole
_SOLE = 0x2E9E5B
_SIDES = (0xD55E00, 0x0072B2)  # right, left: the colours of the figures


def draw_inspection(viewer: Node, inspection: Inspection) -> None:
    """Draw what is known of a robot: its meshes, and axes and soles if they were found."""
    viewer["/Background"].set_property("top_color", [0.97, 0.98, 1.0])
    viewer["/Background"].set_property("bottom_color", [0.86, 0.89, 0.92])
    viewer["/Axes"].set_property("visible", False)
    viewer["/Grid"].set_property("visible", False)
    if inspection.source is None or inspection.model is None:
        return
    reading = inspection.reading
    model = inspection.model if reading is None else reading.model
    q = np.array(pin.neutral(model)) if reading is None else _standing(reading)
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    draw_still(viewer["world/robot"], model, data, _shapes(inspection))
    if reading is not None:
        _draw_joints(viewer["world/axes"], reading, q, data)
        _draw_soles(viewer["world/soles"], reading, data)
    _look_at(viewer, data)


def draw_still(robot: Node, model: pin.Model, data: pin.Data, shapes: pin.GeometryModel) -> None:
    """Put a robot into a viewer, with its joints where `data` has them."""
    for item in shapes.geometryObjects:
        joint = item.parentJoint
        group = str(model.names[joint]).replace("/", "_")
        draw_shape(robot, group, item, data.oMi[joint] * item.placement)


def _shapes(inspection: Inspection) -> pin.GeometryModel:
    """Return the visual shapes that are there; a mesh that cannot be read leaves none."""
    source = inspection.source
    try:
        found = None if source is None else source.geometry(pin.GeometryType.VISUAL, load=unloaded)
    except RobotError:
        found = None
    return found or pin.GeometryModel()


def _standing(reading: ImportedRobot) -> Array:
    """Return the configuration (nq,) in which the robot stands on z = 0 and looks along x."""
    model, data = reading.model, reading.model.createData()
    pin.framesForwardKinematics(model, data, reading.q)
    soles = [data.oMf[model.getFrameId(name)].translation for name in reading.soles.names]
    upright = pin.SE3(np.array(reading.rotation), np.mean(soles, axis=0))
    q = reading.q.copy()
    q[:7] = pin.SE3ToXYZQUAT(upright.inverse())
    return np.asarray(q)


def _middle_and_size(data: pin.Data) -> tuple[Array, float]:
    """Return the middle of the robot and its height, from its joints."""
    points = np.array([place.translation for place in list(data.oMi)[1:]])
    low, high = points.min(axis=0), points.max(axis=0)
    return (low + high) / 2.0, float(max(*(high - low), 0.1))


def _draw_joints(node: Node, reading: ImportedRobot, q: Array, data: pin.Data) -> None:
    model, (_, size) = reading.model, _middle_and_size(data)
    axes = pose_model(model, q).axes
    for side, leg in enumerate(reading.legs):
        for joint, axis in zip(leg, axes[list(leg)], strict=True):
            arrow = node[str(model.names[joint]).replace("/", "_")]
            _draw_arrow(arrow, data.oMi[joint].translation, axis, size, _SIDES[side])


def _draw_arrow(node: Node, start: Array, axis: Array, size: float, colour: int) -> None:
    length, radius = _ARROW * size, _THICK * size
    material = geometry.MeshBasicMaterial(color=colour, depthTest=False, transparent=True)
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 1.0, 0.0]), axis).matrix()
    placed = pin.SE3(turn, start.copy())
    # MeshCat's cylinders stand along y
    node["shaft"].set_object(geometry.Cylinder(length, radius), material)
    node["shaft"].set_transform((placed * _along(length / 2.0)).homogeneous)
    head = geometry.Cylinder(4.0 * radius, radiusTop=0.0, radiusBottom=2.2 * radius)
    node["head"].set_object(head, material)
    node["head"].set_transform((placed * _along(length + 2.0 * radius)).homogeneous)


def _along(distance: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array([0.0, distance, 0.0]))


def _draw_soles(node: Node, reading: ImportedRobot, data: pin.Data) -> None:
    sole = reading.soles.sole
    material = geometry.MeshBasicMaterial(
        color=_SOLE, opacity=0.5, transparent=True, depthTest=False, depthWrite=False
    )
    for side, name in enumerate(reading.soles.names):
        sign = 1.0 if side == reading.stance else -1.0  # the rectangle is the standing foot's
        middle = [(sole.toe + sole.heel) / 2.0, sign * (sole.left + sole.right) / 2.0, 0.0]
        plate = geometry.Box([sole.length, sole.width, _PLATE])
        node[str(side)].set_object(plate, material)
        place = data.oMf[reading.model.getFrameId(name)] * pin.SE3(np.eye(3), np.array(middle))
        node[str(side)].set_transform(place.homogeneous)


def _look_at(viewer: Node, data: pin.Data) -> None:
    """Put the middle of the robot at the origin, about which the camera turns."""
    middle, size = _middle_and_size(data)
    shift = np.eye(4)
    shift[:3, 3] = -middle
    viewer["world"].set_transform(shift)
    position = [size * c for c in _CAMERA]
    viewer["/Cameras/default/rotated/<object>"].set_property("position", position)


def write_inspection(inspection: Inspection, path: str | Path) -> Path:
    """Write a page with the robot and everything known about it, complete in one file.

    Args:
        inspection: of the robot, which may be refused.
        path: the .html file.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    return write_atomically(path, inspection_text(inspection).encode("utf-8"))


def inspection_text(inspection: Inspection) -> Page:
    """Return the text of the page of `write_inspection`; a notebook shows it."""
    recorder = RecordingWindow()
    draw_inspection(Node(recorder), inspection)
    refusal = html_text(inspection.refusal)
    parts = {
        "@TITLE@": html_text(inspection.title),
        "@REFUSAL@": f'<p class="refusal">{refusal}</p>' if refusal else "",
        "@TABLES@": "".join(map(table_text, inspection_tables(inspection))),
        "@FIT@": page_file("fit.js"),
        "@LOAD@": page_file("load.js"),
        "@COMMANDS@": recorder.text(),
        "@MESHCAT@": packed_viewer(),
    }
    return Page(filled_template(page_file("inspection.html"), parts))
