"""The gait file: one .npz that `numpy.load` reads; format 2 is documented in docs/gait-file.md."""

from __future__ import annotations

import hashlib
import io
import json
import math
import stat
import zipfile
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from os.path import isdir, isfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitopt.atomic import write_atomically
from gaitopt.bounds import GAIT, NUMBER, too_large
from gaitopt.contact import FlatFoot, LegExchange, PhaseEnd
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitFileError, InputError, RobotError, reason_of
from gaitopt.gait.result import OF_TURN, OPTIONAL, SHAPES, Gait, array_names
from gaitopt.gait.trajectory import TrajectoryPhase, TrajectorySamples
from gaitopt.importers.physics import MOST_POWER
from gaitopt.model.multibody import Multibody, checked_multibody
from gaitopt.settings import checked_arguments
from gaitopt.tolerances import SAME
from gaitopt.version import __version__

FORMAT = 2  # raised when a reader of the older format would misread the file
GROUND_NORMAL = (0.0, 0.0, 1.0)
WRITTEN_BY = "version"  # key of `meta`: the gaitopt that wrote the file
TEXTS = ("urdf", "stance_sole", "swing_sole_frame")
_NAMES = ("parameter_names", "joint_names")
_OLD = (*(n for n in SHAPES if n != "coefficients"), *TEXTS, *_NAMES, "meta")  # of format 1
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
_LEVEL = 3  # of compression: 7 % longer than by zlib's usual 6, in half the time
_EPOCH = (1980, 1, 1, 0, 0, 0)  # equal gaits give equal files: no time of writing inside
Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Member:
    """One array of the file, in the words of docs/gait-file.md.

    Attributes:
        name: key in `numpy.load`.
        kind: "float64", "int64", "bool" or "str" (NumPy's Unicode text).
        shape: sizes as numbers or letters, each letter the same everywhere.
        unit: "" where there is none.
        frame: in which it is expressed, "" where there is none.
    """

    name: str
    kind: str
    shape: tuple[int | str, ...]
    unit: str = ""
    frame: str = ""


_SOLE, _FIRST, _LANDING = "standing sole", "sole that stands first", "landing sole"
MEMBERS = (
    Member("time", "float64", ("N",), "s"),
    Member("q", "float64", ("N", "J"), "rad", "joint"),
    Member("dq", "float64", ("N", "J"), "rad/s", "joint"),
    Member("ddq", "float64", ("N", "J"), "rad/s²", "joint"),
    Member("torque", "float64", ("N", "J"), "N·m", "joint"),
    Member("ground_wrench", "float64", ("N", 6), "N, N·m", _SOLE),
    Member("cop", "float64", ("N", 2), "m", _SOLE),
    Member("swing_sole", "float64", ("N", 4, 3), "m", _SOLE),
    Member("base_position", "float64", ("N", 3), "m", "world"),
    Member("base_quaternion", "float64", ("N", 4), "", "world"),
    Member("base_twist", "float64", ("N", 6), "m/s, rad/s", "base"),
    Member("base_acceleration", "float64", ("N", 6), "m/s², rad/s²", "base"),
    Member("knots_0", "float64", ("m",), "s"),
    Member("coefficients_0", "float64", ("m + 2", "J"), "rad, rad/s", "joint"),
    Member("schedule", "str", ()),
    Member("mirror", "float64", ("J", "J")),
    Member("impulse", "float64", (6,), "N·s, N·m·s", _LANDING),
    Member("rate_before", "float64", ("J",), "rad/s", "joint"),
    Member("rate_after", "float64", ("J",), "rad/s", "joint"),
    Member("ground_normal", "float64", (3,), "", "world"),
    Member("gravity", "float64", (3,), "m/s²", "world"),
    Member("parameters", "float64", ("P",), "as named"),
    Member("parameter_names", "str", ("P",)),
    Member("multipliers", "float64", ("R",), "scaled"),
    Member("bound_multipliers", "float64", ("B",), "scaled"),
    Member("joint_names", "str", ("J",)),
    Member("stance_sole", "str", ()),
    Member("swing_sole_frame", "str", ()),
    Member("robot_name", "str", ()),
    Member("robot_base", "str", ()),
    Member("robot_joint_names", "str", ("M",)),
    Member("robot_parent", "int64", ("M",)),
    Member("robot_revolute", "bool", ("M",)),
    Member("robot_placement", "float64", ("M", 4, 4), "m", "body before the joint"),
    Member("robot_axis", "float64", ("M", 3), "", "joint"),
    Member("robot_posture", "float64", ("M",), "rad or m", "joint"),
    Member("robot_moving", "int64", ("J",)),
    Member("robot_mass", "float64", ("M + 1",), "kg"),
    Member("robot_centre", "float64", ("M + 1", 3), "m", "body"),
    Member("robot_inertia", "float64", ("M + 1", 3, 3), "kg·m²", "body"),
    Member("robot_armature", "float64", ("M",), "kg·m²", "joint"),
    Member("robot_friction", "float64", ("M",), "N·m", "joint"),
    Member("robot_damping", "float64", ("M", "D"), "N·m·s/rad, ...", "joint"),
    Member("robot_stiffness", "float64", ("M", "S"), "N·m/rad, ...", "joint"),
    Member("robot_rest", "float64", ("M",), "rad", "joint"),
    Member("robot_carried_mass", "float64", ("M + 1",), "kg"),
    Member("robot_carried_moment", "float64", ("M + 1", 3), "kg·m", "body"),
    Member("robot_sole_joint", "int64", (2,)),
    Member("robot_sole_placement", "float64", (2, 4, 4), "m", "body of the foot"),
    Member("robot_sole_rectangle", "float64", (2, 4), "m", "sole"),
    Member("robot_heading", "float64", (3, 3), "", "base"),
    Member("urdf", "str", ()),
    Member("meta", "str", ()),
    Member("digest", "str", ()),
)
"""Every array of a gait file of format 2, in the order in which they are written."""

_RENAMED = {"knots": "knots_0", "coefficients": "coefficients_0"}
_OF_ROBOT = {
    "gravity": "gravity",
    **{f.name: f"robot_{f.name}" for f in fields(Multibody) if f.name != "gravity"},
}


def _splines(phase: int) -> tuple[Member, ...]:
    """Return the arrays of the joints' splines in a phase after the first."""
    m = f"m{phase}"
    return (
        Member(f"knots_{phase}", "float64", (m,), "s"),
        Member(f"coefficients_{phase}", "float64", (f"{m} + 2", "J"), "rad, rad/s", "joint"),
    )


def _turn(phase: int) -> tuple[Member, ...]:
    """Return the arrays of the turn of the stance foot in a phase."""
    k = f"k{phase}"
    return (
        Member(f"foot_hinge_{phase}", "float64", (6,), "m, 1", _SOLE),
        Member(f"foot_knots_{phase}", "float64", (k,), "s"),
        Member(f"foot_coefficients_{phase}", "float64", (f"{k} + 2",), "rad, rad/s"),
    )


_MOST = 3  # phases: the foot turns having landed, stands flat, turns before it leaves


_REAR = (Member("rear_impulse_0", "float64", (6,), "N·s, N·m·s", _SOLE),)
PHASES = (
    *(part for k in range(_MOST) for part in (_splines(k) if k else (), _turn(k)) if part),
    *(
        (Member(f"front_wrench_{k}", "float64", (4, 6), "N, N·m", "front sole"),)
        for k in range(1, _MOST)
    ),
    _REAR,
)
"""Groups of further arrays, each of which is in the file as a whole or not at all: those of the
splines of a second and a third phase, of the phases in which the stance foot turns, of a second one
in which both feet stand, and of an impact that ends the first: both feet take it, or the standing
one as it comes to lie flat."""

TIED = (
    Member("robot_tied", "int64", ("t",)),
    Member("robot_tied_to", "int64", ("t",)),
    Member("robot_tie", "float64", ("t", 2), "1, rad", "joint"),
)
"""Further arrays, of a robot with joints that follow others."""
_HIGHER = MOST_POWER - 1  # powers beyond the first
BENT = (Member("robot_tie_bend", "float64", ("t", _HIGHER), "1/rad, 1/rad², 1/rad³", "joint"),)
"""Further array, of one with joints that follow others by a polynomial."""
_TIED = tuple(member.name for member in TIED)
_BASE_TRACK = ("base_position", "base_quaternion", "base_twist", "base_acceleration")
OF_STEP = (
    "time", "q", "dq", "ddq", "torque", "ground_wrench", "cop", "swing_sole", *_BASE_TRACK,
    "knots_0", "coefficients_0", "impulse", "rate_before", "rate_after",
)  # fmt: skip
STEP_MARK = "step_1_time"
"""Array that tells the file of a transition (`gaitopt.gait.transition`) from a gait's."""
_SECOND, _STRIDE = "second_", "stride"
STRIDE = tuple(replace(m, name=f"{_SECOND}{m.name}") for m in MEMBERS if m.name in OF_STEP)
"""Further arrays, of a gait whose second step is no mirror image of the first: as those of the
first, of the second's mirror image; where its base is, as it is."""
SECOND_PHASES = tuple(tuple(replace(m, name=f"{_SECOND}{m.name}") for m in part) for part in PHASES)
"""The same of `PHASES`: of the second step where it has several, as the first."""

GROUPS = (*PHASES, STRIDE, *SECOND_PHASES, TIED, BENT)
"""All groups of arrays that not every file has."""


@checked_arguments
def save_gait(gait: Gait, path: str | Path) -> Path:
    """Write a gait file, atomically; equal gaits give equal bytes.

    Args:
        path: file name, used as it is; `.npz` is the custom.

    Raises:
        InputError: the path cannot be written.
        RobotError: the gait has no `multibody`, and its URDF is not its robot.
    """
    return write_atomically(path, gait_bytes(gait))


def gait_bytes(gait: Gait, facts: Mapping[str, object] | None = None) -> bytes:
    """Return the content of a gait file.

    Args:
        facts: to be recorded beside those of `Gait.meta`, JSON-able.

    Raises:
        RobotError: the gait has no `multibody`, and its URDF is not its robot.
    """
    return archive_bytes(gait_members(gait, facts))


def archive_bytes(members: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a file of arrays with the digest of each."""
    parts = {name: _bytes(array) for name, array in members.items()}
    digest = {name: hashlib.sha256(data).hexdigest() for name, data in parts.items()}
    parts["digest"] = _bytes(np.array(json.dumps(digest)))
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in parts.items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=_EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data, compresslevel=_LEVEL)
    return buffer.getvalue()


@checked_arguments
def load_gait(path: str | Path, *, verify: bool = True) -> Gait:
    """Read and validate a gait file.

    Args:
        path: of a file of format 2 or 1.
        verify: whether a file that was changed after it was written is refused.

    Raises:
        GaitFileError: the file is missing, truncated, not a gait file, of a newer format, changed,
            or what it holds is not a gait (missing arrays, kinds, shapes, NaN, times, E, JSON).
    """
    source = Path(path)
    return read_gait(source, *read_members(source), verify)


def read_gait(source: Path, members: Arrays, digests: Mapping[str, str], verify: bool) -> Gait:
    """Validate the arrays of a gait file and return its gait; errors as of `load_gait`.

    Args:
        members, digests: as of `read_members`.
        verify: whether a file that was changed after it was written is refused.
    """
    version, meta = read_meta(source, members)
    if STEP_MARK in members:
        raise bad_file(source, "it is a transition, and this is for the gait of a walk")
    wanted = _OLD if version == 1 else tuple(member.name for member in _of_format_2(members))
    if missing := [name for name in wanted if name not in members]:
        raise bad_file(source, f"it is not a complete gait file, '{missing[0]}' is missing")
    try:
        if version == 1:
            return _gait(members, meta, {})
        if verify:
            refuse_altered(altered(members, digests))
        return _new_gait(members, meta)
    except (InputError, RobotError) as error:
        raise bad_file(source, str(error)) from error


def altered_members(path: str | Path) -> tuple[str, ...]:
    """Return the arrays of a file that were changed after it was written, by its digest.

    Files of format 1 have none: nothing is known of them.

    Raises:
        GaitFileError: the file cannot be read.
    """
    source = Path(path)
    members, digests = read_members(source)
    if read_meta(source, members)[0] == 1:
        return ()
    return altered(members, digests)


def refuse_altered(names: Sequence[str]) -> None:
    """Refuse a file some of whose arrays were changed after it was written.

    Raises:
        InputError: there are any.
    """
    if names:
        raise InputError(
            f"'{names[0]}' was changed after the file was written, its digest is another; "
            "gaitopt check says what follows from the parameters"
        )


def gait_members(gait: Gait, facts: Mapping[str, object] | None = None) -> Arrays:
    """Return the arrays of a gait's file by name, all but the digest.

    Args:
        facts: as of `gait_bytes`.

    Raises:
        RobotError: the gait has no `multibody`, and its URDF is not its robot.
    """
    trajectory = gait.trajectory
    at = trajectory.at(gait.time, before=_ends_phase(gait))
    found = arrays_of_step(gait, at) | {"mirror": gait.mirror, "parameters": gait.parameters}
    found |= _of_phases(trajectory.phases)
    found |= _of_standing_impact(gait)
    found |= {name: getattr(gait, name) for name in (*TEXTS, *_NAMES)}
    found |= {key: getattr(trajectory.body, name) for name, key in _OF_ROBOT.items()}
    if gait.second is not None:
        times = gait.duration + gait.second.time
        at = trajectory.at(times, before=_ends_phase(gait.second))
        phases = _of_phases(trajectory.second or ()) | _of_standing_impact(gait.second)
        later = arrays_of_step(gait.second, at) | phases
        found |= {f"{_SECOND}{name}": later[name] for name in (*OF_STEP, *phases)}
    for name in ("multipliers", "bound_multipliers"):
        values = getattr(gait, name)
        found[name] = np.zeros(0) if values is None else values
    found["ground_normal"] = np.array(GROUND_NORMAL)
    found["schedule"] = record_text(_schedule(gait))
    meta = {**gait.meta, **(facts or {}), "format": FORMAT, WRITTEN_BY: __version__}
    found["meta"] = record_text(meta)
    if not trajectory.body.bends:
        found.pop(BENT[0].name)
    if not len(trajectory.body.tied):
        found = {name: value for name, value in found.items() if name not in _TIED}
    return typed(found, _of_format_2(found))


def arrays_of_step(step: Gait, at: TrajectorySamples) -> dict[str, object]:
    """Return the arrays `OF_STEP` of a step, by name.

    Args:
        step: of one phase, or of several whose splines are those of the whole.
        at: the motion at its times.
    """
    found: dict[str, object] = {name: getattr(at, name) for name in _BASE_TRACK}
    return found | {_RENAMED.get(name, name): getattr(step, name) for name in _names_of_step()}


def typed(found: Mapping[str, object], members: Iterable[Member]) -> Arrays:
    """Return the arrays of a file, the digest apart, in their kinds and their order."""
    return {
        m.name: np.array(found[m.name], np.str_ if m.kind == "str" else m.kind)
        for m in members
        if m.name != "digest"
    }


def _of_phases(phases: Sequence[TrajectoryPhase]) -> dict[str, object]:
    """Return the arrays of the phases of a step."""
    found: dict[str, object] = {}
    for number, phase in enumerate(phases):
        found |= {f"knots_{number}": phase.knots, f"coefficients_{number}": phase.coefficients}
        if phase.front is not None:
            found[f"front_wrench_{number}"] = phase.front
        if phase.turning is not None:
            found |= {f"foot_{n}_{number}": getattr(phase.turning, n) for n in OF_TURN}
    return found


def _of_standing_impact(gait: Gait) -> dict[str, object]:
    """Return the impulse on a foot that stands then, if there is one."""
    return {_REAR[0].name: gait.rear_impulse} if gait.rear_impulse.size else {}


def _of_format_2(names: Container[str]) -> tuple[Member, ...]:
    """Return the arrays that a file of format 2 has, given those of it, or some of them."""
    parts = (part for part in GROUPS if any(member.name in names for member in part))
    return (*MEMBERS, *(member for part in parts for member in part))


def _ends_phase(gait: Gait) -> NDArray[np.bool_]:
    """Return which samples belong to what ends at their instant, shape (N,)."""
    if len(gait.phases) == 1:
        return np.asarray(gait.time > gait.duration / 2.0)
    ends = gait.time > 0.0
    for phase in gait.phases[1:]:
        begun = gait.time - phase.begin
        ends &= ~((begun > 0.0) & (begun < SAME * gait.duration))
    return np.asarray(ends)


def _schedule(gait: Gait) -> dict[str, object]:
    """Return what happens when: the phases of a step, and how the next one follows."""
    feet: list[dict[str, str]] = [{gait.stance_sole: phase.contact} for phase in gait.phases]
    ends = [PhaseEnd.SMOOTH] * (len(feet) - 1) + [PhaseEnd.IMPACT]
    if gait.closing:
        rear = gait.foot_contact or FlatFoot.name
        feet[-1] = {gait.stance_sole: rear, gait.swing_sole_frame: FlatFoot.name}
        begin = PhaseEnd.IMPACT if gait.striking else PhaseEnd.TOUCH_DOWN
        ends = [*ends[:-2], begin, PhaseEnd.LIFT_OFF]
    if gait.slapping:
        ends[0] = PhaseEnd.FOOT_FLAT
    steps = [(feet, gait.trajectory.phases)]
    if gait.second is not None:
        other = {gait.stance_sole: gait.swing_sole_frame, gait.swing_sole_frame: gait.stance_sole}
        exchanged = [{other[sole]: contact for sole, contact in one.items()} for one in feet]
        steps.append((exchanged, gait.trajectory.second or ()))
    phases = [
        {"contacts": contacts, "duration": phase.duration, "end": end.value}
        for on, parts in steps
        for contacts, phase, end in zip(on, parts, ends, strict=True)
    ]
    return {"phases": phases, "symmetry": LegExchange.name if gait.second is None else _STRIDE}


def record_text(record: Mapping[str, object]) -> str:
    """Return a record as text, the same for equal records."""
    return json.dumps(record, sort_keys=True, ensure_ascii=False)


def _bytes(array: NDArray[Any]) -> bytes:
    buffer = io.BytesIO()
    np.lib.format.write_array(buffer, array, version=(1, 0), allow_pickle=False)
    return buffer.getvalue()


def _gait(members: Arrays, meta: Mapping[str, object], more: Mapping[str, Any]) -> Gait:
    names = (*array_names(), *OPTIONAL)
    arrays: dict[str, Any] = {n: members[n] for n in names if n in members}
    return Gait(
        **arrays,
        urdf=str(members["urdf"]),
        stance_sole=str(members["stance_sole"]),
        swing_sole_frame=str(members["swing_sole_frame"]),
        parameter_names=tuple(members["parameter_names"].reshape(-1).tolist()),
        joint_names=tuple(members["joint_names"].reshape(-1).tolist()),
        meta=meta,
        **more,
    )


def _new_gait(members: Arrays, meta: dict[str, object]) -> Gait:
    """Return the gait of a file of format 2."""
    check_members(members, _of_format_2(members))
    meta.pop(WRITTEN_BY, None)
    body = read_body(members)
    named: Arrays = {}
    contacts: dict[str, Any] = {}
    strides = STRIDE[0].name in members
    if _has_phases(members):
        named = _joined(members)
        first, last = _contacts(members)
        if "landing_hinge" in named:
            contacts["landing_contact"] = first
        if "foot_hinge" in named:
            contacts["foot_contact"] = last
    gait = gait_of({**members, **named}, meta, body, contacts)
    if strides:
        own = {n[len(_SECOND) :]: a for n, a in members.items() if n.startswith(_SECOND)}
        later: dict[str, Any] = {n: own[_RENAMED.get(n, n)] for n in _names_of_step()}
        if _has_phases(own):
            later |= _joined(own)
        gait = replace(gait, second=replace(gait, **later))
    _check_statements(gait, members)
    return gait


def gait_of(
    members: Arrays,
    meta: Mapping[str, object],
    body: Multibody,
    more: Mapping[str, Any] | None = None,
) -> Gait:
    """Return the gait of the arrays of a file of format 2, those of one phase alone.

    Raises:
        InputError: they make none.
    """
    multipliers = ("multipliers", "bound_multipliers")
    known = {n: members[n] for n in multipliers if n in members and members[n].size}
    named = {name: members[key] for name, key in _RENAMED.items() if name not in members}
    return _gait({**members, **named}, meta, {**known, **(more or {}), "multibody": body})


def read_body(members: Arrays) -> Multibody:
    """Return the robot of a file.

    Raises:
        InputError: it is none.
    """
    robot: dict[str, Any] = {n: members[k] for n, k in _OF_ROBOT.items() if k in members}
    robot |= {name: str(robot[name]) for name in ("name", "base")}
    robot["joint_names"] = tuple(map(str, robot["joint_names"]))
    robot["sole_names"] = (str(members["stance_sole"]), str(members["swing_sole_frame"]))
    robot.setdefault("tie_bend", np.zeros((len(robot.get("tied", ())), _HIGHER)))
    return checked_multibody(Multibody(**robot))


def _has_phases(members: Arrays) -> bool:
    """Whether a file has arrays of several phases, or of a foot that turns."""
    return any(member.name in members for part in PHASES for member in part)


def _names_of_step() -> list[str]:
    """Return the names of a gait's arrays that are of one step."""
    return [name for name in array_names() if _RENAMED.get(name, name) in OF_STEP]


def _contacts(members: Arrays) -> tuple[str, str]:
    """Return those of the first and the last phase, "?" where the schedule names none."""
    try:
        schedule, standing = json.loads(str(members["schedule"])), str(members["stance_sole"])
        phases = schedule["phases"]
        if schedule["symmetry"] == _STRIDE:
            phases = phases[: len(phases) // 2]
        own = [one["contacts"][standing] for one in phases]
        return str(own[0]), str(own[-1])
    except (ValueError, RecursionError, LookupError, TypeError, AttributeError, StopIteration):
        return "?", "?"


def _joined(members: Arrays) -> Arrays:
    """Return the splines over a step of several phases, and the turns of the foot in it."""
    whole = sum(f"knots_{k}" in members for k in range(_MOST))
    if whole > 1 and "knots_1" not in members:
        raise InputError("its 'knots_1' is missing")
    closing = f"front_wrench_{whole - 1}" in members
    count = whole - closing
    splines = [members[f"coefficients_{k}"] for k in range(count)]
    pieces = [members[f"knots_{k}"] for k in range(count)]
    begins = np.concatenate([[0.0], np.cumsum([knots[-1] for knots in pieces])])
    inner = [begin + knots[1:] for begin, knots in zip(begins, pieces, strict=False)]
    values = [splines[0][:1], *(part[1:-2] for part in splines)]
    found = {
        "knots": np.concatenate([[0.0], *inner]),
        "coefficients": np.concatenate([*values, splines[0][-2:-1], splines[-1][-1:]]),
    }
    for k in range(count):
        if f"foot_hinge_{k}" in members:
            part = "foot" if k else "landing"
            found |= {f"{part}_{name}": members[f"foot_{name}_{k}"] for name in OF_TURN}
            found[f"{part}_knots"] = begins[k] + found[f"{part}_knots"]
    if closing:
        found |= _closed(members, count, float(begins[-1]), found)
    elif _REAR[0].name in members and count > 1:
        found["flat_rates"] = np.array([splines[0][-1], splines[1][-2]])
        found["rear_impulse"] = members[_REAR[0].name]
    return found


def _closed(members: Arrays, last: int, touch: float, before: Arrays) -> Arrays:
    """Return the arrays of the double support, and of a turn of the rear foot that goes on in it.

    Args:
        touch: time at which it begins [s].
    """
    found = {
        "double_knots": touch + members[f"knots_{last}"],
        "double_coefficients": members[f"coefficients_{last}"],
        "front_wrench": members[f"front_wrench_{last}"],
        "rear_impulse": members.get(_REAR[0].name, np.zeros(0)),
    }
    if f"foot_knots_{last}" in members and "foot_knots" in before:
        knots, values = (members[f"foot_{name}_{last}"] for name in ("knots", "coefficients"))
        first = before["foot_coefficients"]
        ends = [first[-2:-1], values[-1:]]
        found["foot_knots"] = np.concatenate([before["foot_knots"], touch + knots[1:]])
        found["foot_coefficients"] = np.concatenate([first[:-2], values[1:-2], *ends])
    return found


def check_members(members: Arrays, kinds: Iterable[Member]) -> None:
    """Refuse arrays of another kind or shape than their own.

    Raises:
        InputError: one is.
    """
    sizes: dict[int | str, int] = {}
    for member in kinds:
        array = members[member.name]
        kind = "U" if member.kind == "str" else np.dtype(member.kind).kind
        if array.dtype.kind != kind:
            raise InputError(f"its '{member.name}' is of {array.dtype}, not {member.kind}")
        known = dict(sizes)
        for letter in [size for size in sizes if isinstance(size, str)]:
            known |= {f"{letter} + {more}": sizes[letter] + more for more in (1, 2)}
        if array.ndim == len(member.shape):
            for size, found in zip(member.shape, array.shape, strict=True):
                if isinstance(size, str) and size not in known:
                    sizes[size] = known[size] = found
        wanted = tuple(known.get(size, size) for size in member.shape)
        if array.shape != wanted:
            raise InputError(f"its '{member.name}' has shape {array.shape}; it must be {wanted}")
        if kind == "f" and not np.isfinite(array).all():
            raise InputError(f"its '{member.name}' holds NaN or infinity")
        if kind == "f" and float(np.abs(array).max(initial=0.0)) > NUMBER:
            raise InputError(f"its '{member.name}' holds a number that is no SI value")


def _check_statements(gait: Gait, members: Arrays) -> None:
    """Refuse a base track, a schedule or a ground that are not those of the gait itself."""
    found = gait_members(gait)
    groups = (*PHASES, STRIDE, *SECOND_PHASES)
    splines = [m.name for part in groups for m in part if m.name in members]
    if splines and found.keys() != {*members} - {"digest"}:
        raise InputError("its arrays of several phases or steps are not those of a gait")
    for name in (*_BASE_TRACK, *splines, *(_RENAMED.values() if splines else ())):
        if not same_numbers(found[name], members[name]):
            raise InputError(f"its '{name}' is not that of its splines and its robot")
    if not np.array_equal(members["ground_normal"], found["ground_normal"]):
        raise InputError("its ground is not level; this gaitopt reads gaits on level ground")
    if read_json(members, "schedule") != _schedule(gait):
        raise InputError(
            "its 'schedule' is not that of its arrays: a phase on the flat foot that stands, at "
            "most one before and one after it in which it turns about a line, ended by the impact "
            "of the other, or by one in which both feet stand; or two such steps of a stride; this "
            "gaitopt reads no other"
        )


def same_numbers(computed: NDArray[Any], stored: NDArray[Any]) -> bool:
    """Whether an array of a file is that which was computed, to rounding."""
    if computed.shape != stored.shape:
        return False
    size = max(1.0, float(np.abs(computed).max(initial=0.0)))
    return bool(np.abs(computed - stored).max(initial=0.0) <= SAME * size)


_WIDTHS = {"f": np.float64, "i": np.int64}
"""Numbers in memory, by their kind: Pinocchio takes these alone, files may be of other programs."""


def read_members(source: Path) -> tuple[Arrays, dict[str, str]]:
    """Return the arrays of a file, and the digest of each."""
    if isdir(source):
        raise bad_file(source, f"it is a directory{gait_inside(source)}")
    try:
        regular = stat.S_ISREG(source.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError) as error:
        raise bad_file(source, "there is no such file") from error
    except (OSError, ValueError) as error:
        raise bad_file(source, reason_of(error)) from error
    if not regular:
        raise bad_file(source, "it is no regular file")
    # Damaged archives raise a dozen unrelated exceptions: zip, zlib, header parser, decoder.
    try:
        if large := too_large(source.stat().st_size, GAIT):
            raise ValueError(large)
        with zipfile.ZipFile(source) as archive:
            entries = [e for e in archive.infolist() if e.filename.endswith(".npy")]
            if large := too_large(sum(entry.file_size for entry in entries), GAIT):
                raise ValueError(f"unpacked, {large}")
            data = {e.filename.removesuffix(".npy"): archive.read(e) for e in entries}
        arrays = {name: _array(name, part) for name, part in data.items()}
    except zipfile.BadZipFile as error:
        raise bad_file(source, "it is truncated, or not a gait file") from error
    except Exception as error:
        raise bad_file(source, f"it is damaged, or not a gait file ({error})") from error
    return arrays, {name: hashlib.sha256(part).hexdigest() for name, part in data.items()}


def _array(name: str, data: bytes) -> NDArray[Any]:
    """Return an array, its header believed only as far as there are bytes for it.

    Raises:
        ValueError: the header promises another size, or objects.
    """
    stream = io.BytesIO(data)
    version = np.lib.format.read_magic(stream)
    if version not in _HEADERS:
        raise ValueError(f"{name} is of version {version}")
    shape, _, kind = _HEADERS[version](stream)
    if kind.hasobject or math.prod(shape) * kind.itemsize != len(data) - stream.tell():
        raise ValueError(f"{name} holds no array of the size in its header")
    stream.seek(0)
    array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    if array.dtype.kind not in _WIDTHS:
        return array
    with np.errstate(over="ignore"):  # what is then infinite is refused as such
        return array.astype(_WIDTHS[array.dtype.kind], copy=False)


def altered(members: Arrays, digests: Mapping[str, str]) -> tuple[str, ...]:
    """Return the arrays of a file whose digests are not those recorded."""
    try:
        recorded = json.loads(str(members.get("digest")))
    except (ValueError, RecursionError):
        recorded = None
    if not isinstance(recorded, dict):
        return ("digest",)
    names = [name for name in dict.fromkeys([*members, *recorded]) if name != "digest"]
    return tuple(n for n in names if n not in digests or recorded.get(n) != digests[n])


def read_json(members: Arrays, name: str) -> object:
    """Return what a text of a file says.

    Raises:
        InputError: it is not JSON.
    """
    try:
        return json.loads(str(members[name]))
    except (ValueError, RecursionError) as error:
        raise InputError(f"its '{name}' is not JSON") from error


def read_record(members: Arrays, name: str) -> dict[str, object]:
    """Return a record of a file.

    Raises:
        InputError: it is not JSON, or no object.
    """
    record = read_json(members, name)
    if not isinstance(record, dict):
        raise InputError(f"its '{name}' is not a JSON object")
    return record


def read_meta(source: Path, members: Arrays) -> tuple[object, dict[str, object]]:
    """Return the number of a file's format, and its record.

    Raises:
        GaitFileError: it has no record, or is of a newer format.
    """
    if "meta" not in members:
        reason = "it is not a complete gait file, 'meta' is missing"
        if "joint_names" in members and "parameters" not in members:
            reason += " (it is a motion that gaitopt export wrote)"
        raise bad_file(source, reason)
    try:
        meta = read_record(members, "meta")
    except InputError as error:
        raise bad_file(source, str(error)) from error
    version = meta.pop("format", 1)
    if version not in (1, FORMAT):
        raise bad_file(
            source, f"its format is {version}, this gaitopt reads {FORMAT}; install a newer gaitopt"
        )
    return version, meta


def gait_inside(directory: Path) -> str:
    """Return words that name the gait in a directory of `gaitopt optimise`; none if it is none."""
    path = directory / "gait.npz"
    return f"; there is the gait '{path}'" if isfile(path) else ""


def bad_file(source: Path, reason: str) -> GaitFileError:
    """Return the error of a file that is no gait's."""
    return GaitFileError(
        f"cannot read the gait file '{source}': {reason}; give one that gaitopt optimise "
        "--output wrote (in Python, save_gait)"
    )
