"""Write a gait, or every gait of a library, in a form that other programs read.

A table of the samples of the gait file (.csv) has one row per sample; a record of them (.json,
.yaml) has names and numbers, nested: samples, splines, impact and origin. docs/motions.md tells
arrays, units and frames of motions, and who reads them.
"""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from itertools import pairwise
from os.path import realpath
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.polynomial import Polynomial
from scipy.spatial.transform import Rotation

from gaitopt.atomic import make_directory, write_atomically
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, did_you_mean
from gaitopt.gait.result import Gait
from gaitopt.gait.spline import bernstein
from gaitopt.gait.trajectory import MIRRORED_WRENCH, TrajectoryPhase
from gaitopt.gait.transition import Transition
from gaitopt.mechanics.spatial import upright
from gaitopt.motions.motion import SCALAR_FIRST, Motion, motion
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.sweep.grid import Index
from gaitopt.sweep.library import Library, open_library
from gaitopt.sweep.table import Row, csv_bytes
from gaitopt.units import motion_words

_JOINTS = ("q", "dq", "ddq", "torque")
_GROUND = {  # mirror images; a moment is an axial vector
    "ground_wrench": np.diag(MIRRORED_WRENCH),
    "cop": np.diag([1.0, -1.0]),
}
_AXES = ("x", "y", "z")
_WRENCH = tuple(f"{part}_{axis}" for part in ("force", "moment") for axis in _AXES)
_IMPULSE = ("linear_x", "linear_y", "linear_z", "angular_x", "angular_y", "angular_z")
_TEXT_OR_EXPONENT = re.compile(r'"(?:[^"\\]|\\.)*"|(?P<digits>(?<![\d.])\d+)(?P<power>e[+-]?\d+)')


def stride_samples(gait: Gait, both_legs: bool = False) -> dict[str, Array]:
    """Return the samples of a step, or of it and its mirror image after it (Eq. 26).

    Of a stride of two steps that are no mirror images it is always both.

    At the change of step the instant is there twice, before and after the impact.

    Returns:
        `time`, `step` (0 or 1), `q`, `dq`, `ddq`, `torque`, and `ground_wrench` and `cop` in the
        sole frame of the standing foot; shapes and units as in `Gait`, the joints those of
        `joint_names`.
    """
    mirrors = dict.fromkeys(_JOINTS, gait.mirror) | _GROUND
    each = (gait, gait.following) if both_legs or gait.second is not None else (gait,)
    steps = [
        {
            "time": one.time + k * gait.duration,
            "step": np.full(len(one.time), k),
            **{n: getattr(one, n) @ (np.eye(len(E)), E.T)[k] for n, E in mirrors.items()},
        }
        for k, one in enumerate(each)
    ]
    found = {name: np.concatenate([step[name] for step in steps]) for name in steps[0]}
    body = gait.multibody
    if body is None or not body.tied.size:
        return found
    q, dq, ddq = (found[name] for name in _JOINTS[:3])
    value, slope, second = body.followers(q[:, body.led])
    led = dq[:, body.led]
    more = value, slope * led, slope * ddq[:, body.led] + second * led**2, np.zeros(value.shape)
    for name, columns in zip(_JOINTS, more, strict=True):  # the motors have all of the torque
        found[name] = np.hstack([found[name], columns])
    return found


def joint_names(gait: Gait) -> tuple[str, ...]:
    """Return the names of the joints of a gait, then of those that follow them."""
    body = gait.multibody
    return gait.joint_names if body is None else body.driven_names


def with_followers(gait: Gait, rates: Array, angles: Array) -> Array:
    """Return rates of a gait's joints (J,), then of those that follow them, (J + t,).

    Args:
        rates, angles: of its joints at an instant [rad/s, rad], shape (J,).
    """
    body = gait.multibody
    return rates if body is None or not body.tied.size else body.coupling(angles) @ rates


def cubic_pieces(gait: Gait) -> Array:
    """Return the spline of each joint as polynomials, shape (m - 1, J, 4), Eq. (40).

    In piece k the angle is a0 + a1 s + a2 s² + a3 s³, s the time since the knot before it.
    """
    whole = TrajectoryPhase(0, gait.knots, gait.coefficients)
    parts = whole.split(gait.flat_from, gait.flat_rates) if gait.slapping else (whole,)
    pieces = []
    for part in parts:
        q, dq, ddq = part.motion(part.knots)
        jerk = np.diff(ddq, axis=0) / np.diff(part.knots)[:, None]
        pieces.append(np.stack([q[:-1], dq[:-1], ddq[:-1] / 2.0, jerk / 6.0], axis=-1))
    return np.concatenate(pieces)


def csv_text(gait: Gait, samples: Mapping[str, Array]) -> str:
    """Return the samples (N, ...) of a stride as comma-separated values under names and units.

    Columns: time, step, then angle, rate, acceleration and torque of each joint, the ground wrench
    and the centre of pressure in the standing foot's sole frame.
    """
    blocks = [samples["time"][:, None], samples["step"][:, None]]
    header = ["time [s]", "step"]
    for name, unit in (("q", "rad"), ("dq", "rad/s"), ("ddq", "rad/s2"), ("torque", "N.m")):
        header += [f"{joint} {name} [{unit}]" for joint in joint_names(gait)]
        blocks.append(samples[name])
    header += [f"{name} [{'N' if 'force' in name else 'N.m'}]" for name in _WRENCH]
    header += ["cop_x [m]", "cop_y [m]"]
    rows = np.hstack([*blocks, samples["ground_wrench"], samples["cop"]])
    # 17 significant digits: reading the text gives the same number
    return _table_text(header, rows, 17).decode()


def json_text(gait: Gait, samples: Mapping[str, Array]) -> str:
    """Return the `stride_record` of a gait as JSON, which is YAML too."""
    text = json.dumps(stride_record(gait, samples), indent=1, ensure_ascii=False)
    return with_points(f"{text}\n")


def with_points(text: str) -> str:
    """Return JSON with 1.0e-05 for 1e-05: readers of YAML 1.1 take the latter for a text."""
    return _TEXT_OR_EXPONENT.sub(
        lambda one: f"{one['digits']}.0{one['power']}" if one["digits"] else one[0], text
    )


def stride_record(gait: Gait, samples: Mapping[str, Array]) -> dict[str, object]:
    """Return samples (N, ...), splines, impact and origin of a gait for a controller."""
    joints = joint_names(gait)
    return {
        "units": "SI: s, m, kg, rad, N, N.m; signs of the joints as in the URDF",
        "duration": gait.duration,
        "step_length": gait.step_length,
        "speed": gait.speed,
        "lateral_speed": gait.lateral_speed,
        "turn_rate": gait.turn_rate,
        "joint_names": list(joints),
        "standing_foot_of_step": _standing(gait, samples),
        "time": samples["time"].tolist(),
        "step": samples["step"].tolist(),
        "joints": {
            name: {n: samples[n][:, i].tolist() for n in _JOINTS} for i, name in enumerate(joints)
        },
        "ground_wrench_in_standing_sole": _columns(samples["ground_wrench"], _WRENCH),
        "cop_in_standing_sole": _columns(samples["cop"], ("x", "y")),
        "splines": _splines(gait, samples),
        "standing_foot_turn": _foot_turns(gait, "foot") if gait.turning else None,
        "landed_foot_turn": _foot_turns(gait, "landing") if gait.lands_on_line else None,
        "double_support": _of_steps([_double(s) for s in gait.steps]) if gait.closing else None,
        "impact": _impact(gait),
        "parameters": dict(zip(gait.parameter_names, gait.parameters.tolist(), strict=True)),
        "meta": dict(gait.meta),
    }


# Every JSON text is a YAML text (YAML 1.2, section 1.3), so YAML needs no package of its own.
WRITERS: dict[str, Callable[[Gait, Mapping[str, Array]], str]] = {
    ".csv": csv_text,
    ".json": json_text,
    ".yaml": json_text,
    ".yml": json_text,
}


def export_step(gait: Gait, path: str | Path, *, both_legs: bool = False) -> Path:
    """Write a gait for a spreadsheet (.csv) or a controller (.json, .yaml, .yml), atomically.

    Args:
        both_legs: whether to add the mirror image of the step, for a whole stride.

    Raises:
        InputError: the suffix is unknown, or the path cannot be written.
    """
    writer = WRITERS.get(Path(path).suffix.lower())
    if writer is None:
        raise InputError(
            f"cannot export to '{path}': the suffix must be one of {', '.join(WRITERS)}"
        )
    return write_atomically(path, writer(gait, stride_samples(gait, both_legs)).encode("utf-8"))


def _standing(gait: Gait, samples: Mapping[str, Array]) -> list[str]:
    """Return the sole frame of the standing foot, one for each step."""
    return [gait.stance_sole, gait.swing_sole_frame][: len(np.unique(samples["step"]))]


def _columns(values: Array, names: tuple[str, ...]) -> dict[str, list[float]]:
    return {name: values[:, i].tolist() for i, name in enumerate(names)}


def _splines(gait: Gait, samples: Mapping[str, Array]) -> dict[str, object]:
    """Return for each joint, step and piece the coefficients a0 to a3 of Eq. (40)."""
    pieces, later = cubic_pieces(gait), cubic_pieces(gait.following)
    own = [pieces, np.einsum("ij,kjc->kic", gait.mirror, later)]
    steps = own[: len(_standing(gait, samples))]
    told = {
        name: [step[:, i].tolist() for step in steps] for i, name in enumerate(gait.joint_names)
    }
    return {
        "formula": "angle = a0 + a1 s + a2 s^2 + a3 s^3, s = time in the step - knots[piece]; "
        "of a joint that follows another by a polynomial, with as many powers as it has",
        "order": "[step][piece][a0, a1, a2, a3]",
        "knots": gait.knots.tolist(),
        "coefficients": told | _followers(gait, steps),
    }


def _followers(gait: Gait, steps: list[Array]) -> dict[str, list[list[list[float]]]]:
    """Return the same of the joints that follow others: their polynomials of the others'."""
    body = gait.multibody
    if body is None:
        return {}
    ties = [
        Polynomial(np.array([c, k, *bend])).trim()
        for (k, c), bend in zip(body.tie, body.tie_bend, strict=True)
    ]
    return {
        body.joint_names[joint]: [
            [tie(Polynomial(piece[led])).coef.tolist() for piece in step] for step in steps
        ]
        for joint, led, tie in zip(body.tied, body.led, ties, strict=True)
    }


def _foot_turns(gait: Gait, part: str) -> object:
    """Return the turn of the standing foot; of a stride of two steps that of each."""
    return _of_steps([_foot_turn(step, part) for step in gait.steps])


def _of_steps(each: list[dict[str, object]]) -> object:
    """Return what is told of a step, or of each of a stride."""
    return each[0] if len(each) == 1 else each


def _foot_turn(gait: Gait, part: str) -> dict[str, object]:
    """Return how the standing foot turns, "foot" before it leaves, "landing" after it landed."""
    slaps = gait.slapping and part == "landing"
    return {
        "contact": getattr(gait, f"{part}_contact"),
        "hinge": getattr(gait, f"{part}_hinge").tolist(),
        "formula": "clamped cubic spline: angles at the knots, then rates at both ends",
        "knots": getattr(gait, f"{part}_knots").tolist(),
        "coefficients": getattr(gait, f"{part}_coefficients").tolist(),
        **({"impulse_at_the_end": _named(gait.rear_impulse)} if slaps else {}),
    }


def _double(gait: Gait) -> dict[str, object]:
    """Return what the splines do after touch-down, and how the feet share the load."""
    return {
        "note": "both feet stand; the leg that has landed is where its sole stays, near its spline",
        "formula": "clamped cubic spline: angles at the knots, then rates at both ends",
        "knots": gait.double_knots.tolist(),
        "coefficients": {
            name: gait.double_coefficients[:, i].tolist() for i, name in enumerate(gait.joint_names)
        },
        "front_wrench": gait.front_wrench.tolist(),
        "front_wrench_formula": "cubic of the share of the double support, Bernstein's form",
    }


def _named(impulse: Array) -> dict[str, float]:
    return dict(zip(_IMPULSE, impulse.tolist(), strict=True))


def _impact(gait: Gait) -> dict[str, object]:
    """Return what happens at the landing in step 0, at its end or as both feet come to stand."""
    rates = {"before": gait.rate_before, "after": gait.rate_after}
    rates["jump"] = gait.rate_after - gait.rate_before
    q = gait.q[-1]
    return {
        "impulse_in_landing_sole": _named(gait.impulse),
        "impulse_in_rear_sole": _named(gait.rear_impulse) if gait.striking else None,
        "rates": {
            name: dict(
                zip(joint_names(gait), with_followers(gait, values, q).tolist(), strict=True)
            )
            for name, values in rates.items()
        },
    }


_DEGREE = 7  # of Bezier curves: that of published gait libraries
_AT_ONCE = 1000  # rows of a table that are written at once
_FITTED = 101  # instants of a step to which a Bezier curve is fitted


@dataclass(frozen=True)
class MotionFormat:
    """A form of motions.

    Attributes:
        name: for people.
        suffix: of its files.
        rate: samples a second unless asked otherwise [Hz].
        joints: order of joints unless asked otherwise, one of `ORDERS`.
        content: returns that of a file.
        sampled: whether it has samples; otherwise rate and strides mean nothing.
    """

    name: str
    suffix: str
    rate: float
    joints: str
    content: Callable[[Motion], bytes]
    sampled: bool = True


def format_named(name: str, *others: str) -> MotionFormat:
    """Return a form of motions by its name.

    Args:
        others: names that could be given too, which are no forms of motions alone.

    Raises:
        InputError: there is none.
    """
    if name not in FORMATS:
        known = (*FORMATS, *others)
        raise InputError(
            f"no format of motions is named '{name}'; {did_you_mean(name, known)}choose "
            f"{', '.join(known)}"
        )
    return FORMATS[name]


def tracker_arrays(motion: Motion) -> dict[str, Array]:
    """Return the arrays of a motion npz; their shapes are in `docs/motions.md`."""
    samples, bodies = motion.samples, motion.body_motion
    single = {
        "joint_pos": samples.q,
        "joint_vel": samples.dq,
        "body_pos_w": bodies.position,
        "body_quat_w": bodies.quaternion[..., SCALAR_FIRST],
        "body_lin_vel_w": bodies.linear,
        "body_ang_vel_w": bodies.angular,
        "joint_torque": samples.torque,
        "foot_wrench_w": motion.foot_wrench,
    }
    whole = motion.rate == int(motion.rate)
    return {
        "fps": np.array([int(motion.rate) if whole else motion.rate]),
        **{name: values.astype(np.float32) for name, values in single.items()},
        "foot_contact": samples.contact,
        "joint_names": np.array(motion.joint_names),
        "body_names": np.array(motion.body_names),
        "foot_names": np.array(motion.foot_names),
    }


def mujoco_arrays(motion: Motion) -> dict[str, Array]:
    """Return positions, velocities and torques as MuJoCo has them; shapes: `docs/motions.md`."""
    samples = motion.samples
    rate, change = motion.base_velocity[:, :3], motion.base_acceleration[:, :3]
    quaternion = samples.base_quaternion[:, SCALAR_FIRST]
    return {
        "time": samples.time,
        "qpos": np.hstack([samples.base_position, quaternion, samples.q]),
        "qvel": np.hstack([rate, samples.base_twist[:, 3:], samples.dq]),
        "qacc": np.hstack([change, samples.base_acceleration[:, 3:], samples.ddq]),
        "torque": samples.torque,
        "foot_contact": samples.contact,
        "foot_wrench": motion.foot_wrench,
        "joint_names": np.array(motion.joint_names),
        "foot_names": np.array(motion.foot_names),
    }


def pinocchio_arrays(motion: Motion) -> dict[str, Array]:
    """Return configurations and torques as Pinocchio has them; shapes: `docs/motions.md`."""
    samples = motion.samples
    return {
        "time": samples.time,
        "q": samples.configuration,
        "v": samples.velocity,
        "a": samples.acceleration,
        "tau": samples.torque,
        "foot_contact": samples.contact,
        "foot_wrench": samples.wrench,
        "joint_names": np.array(motion.joint_names),
        "foot_names": np.array(motion.foot_names),
    }


def table_columns(motion: Motion) -> dict[str, Array]:
    """Return the columns of a table with a header, shape (T,) each."""
    samples = motion.samples
    columns = {
        "time [s]": samples.time,
        "step": samples.step.astype(np.float64),
        "phase": motion.step_phase,
    }
    groups: Iterable[tuple[str, Sequence[str], str, Array]] = (
        ("base_", _AXES, "m", samples.base_position),
        ("base_q", (*_AXES, "w"), "", samples.base_quaternion),
        ("base_v", _AXES, "m/s", motion.base_velocity[:, :3]),
        ("base_w", _AXES, "rad/s", motion.base_velocity[:, 3:]),
    )
    for name, parts, unit, values in groups:
        for part, column in zip(parts, values.T, strict=True):
            columns[f"{name}{part} [{unit}]" if unit else f"{name}{part}"] = column
    turns = motion.body.revolute[list(motion.rows)]
    for quantity, per in (("q", ""), ("dq", "/s"), ("ddq", "/s2"), ("torque", "")):
        for name, turn, column in zip(
            motion.joint_names, turns, getattr(samples, quantity).T, strict=True
        ):
            unit = "N.m" if quantity == "torque" else f"rad{per}"
            columns[f"{name} {quantity} [{motion_words(unit, slides=not turn)}]"] = column
    for foot, name in enumerate(motion.foot_names):
        columns[f"{name} contact"] = samples.contact[:, foot].astype(np.float64)
        for part, column in zip(_WRENCH, motion.foot_wrench[:, foot].T, strict=True):
            columns[f"{name} {part} [{'N' if part.startswith('force') else 'N.m'}]"] = column
    return columns


def motion_record(motion: Motion) -> dict[str, object]:
    """Return everything of a motion by name: texts, numbers, lists of names and arrays."""
    samples, gait = motion.samples, motion.gait
    return {
        "units": "SI: s, m, rad, N, N.m; sliding joints in m and N",
        "frames": "world: z against gravity, x along the walk; quaternions x y z w",
        "robot": motion.body.name,
        "speed": gait.speed,
        "lateral_speed": gait.lateral_speed,
        "turn_rate": gait.turn_rate,
        "step_duration": gait.trajectory.step_duration,
        "step_length": gait.step_length,
        "rate": motion.rate,
        "joint_names": list(motion.joint_names),
        "foot_names": list(motion.foot_names),
        "time": samples.time,
        "step": samples.step,
        "phase": motion.step_phase,
        "base_position": samples.base_position,
        "base_quaternion": samples.base_quaternion,
        "base_velocity": motion.base_velocity,
        "base_acceleration": motion.base_acceleration,
        "q": samples.q,
        "dq": samples.dq,
        "ddq": samples.ddq,
        "torque": samples.torque,
        "foot_contact": samples.contact,
        "foot_wrench": motion.foot_wrench,
    }


def bezier_record(motion: Motion) -> dict[str, object]:
    """Return both steps as Bezier curves over the share of the step that is over.

    Ends and rates at the ends are exact; between them the curves are the nearest of their degree,
    and `largest_error` says how far the joints' are off.

    Raises:
        InputError: it is the motion of a transition.
    """
    gait, trajectory = motion.gait, motion.gait.trajectory
    if isinstance(gait, Transition):
        raise InputError("a transition has samples; choose another format than 'bezier'")
    turn = upright(motion.body.gravity)
    ahead = turn @ trajectory.advance(2).translation / trajectory.period
    if gait.second is not None:  # a turn goes on along its circle
        ahead = np.array([gait.speed, gait.lateral_speed, 0.0])
    found: dict[str, object] = {}
    first, other = trajectory.at(0.0).sole[0]
    left = (np.linalg.inv(first) @ other)[1, 3] > 0.0  # where the other foot stands
    sides = ("RightSS", "LeftSS") if left else ("LeftSS", "RightSS")
    worst = 0.0
    for step, side in enumerate(sides):
        T = trajectory.step_duration
        share = np.linspace(0.0, 1.0, _FITTED)
        at = trajectory.at(T * (step + share), before=share == 1.0)
        foot = int(np.flatnonzero(at.contact[0])[0])
        stance = at.sole[0, foot]
        base = (at.base_position - stance[:3, 3]) @ turn.T
        attitude = Rotation.from_matrix(turn) * Rotation.from_quat(at.base_quaternion)
        euler = np.unwrap(attitude.as_euler("ZYX")[:, ::-1], axis=0)
        joints = at.q[:, motion.rows]
        dq = at.dq[:, motion.rows]
        curve = _bezier(joints, dq[[0, -1]] * T)
        worst = max(worst, float(np.abs(bernstein(share, _DEGREE) @ curve - joints).max()))
        velocity = attitude.apply(at.base_twist[:, :3])
        rates = [
            np.append(velocity[end], pin.rpy.computeRpyJacobianInverse(euler[end], pin.LOCAL) @ own)
            for end, own in ((0, at.base_twist[0, 3:]), (-1, at.base_twist[-1, 3:]))
        ]
        track = _bezier(np.hstack([base, euler]), np.array(rates) * T)
        landing = (at.sole[-1, 1 - foot, :3, 3] - stance[:3, 3]) @ turn.T
        found[side] = {
            "coeff_jt": curve.ravel().tolist(),
            "coeff_b": track.ravel().tolist(),
            "step_dur": T,
            "step_len": landing.tolist(),
        }
    return {
        "vd_x": float(ahead[0]),
        "vd_y": float(ahead[1]),
        "joint_names": list(motion.joint_names),
        "degree": _DEGREE,
        "largest_error": worst,
        "robot": motion.body.name,
        "speed": gait.speed,
        **found,
    }


def _bezier(values: Array, rates: Array) -> Array:
    """Return control points of the curves nearest to samples, shape (degree + 1, n).

    Args:
        values: at `_FITTED` equidistant shares, shape (N, n).
        rates: per share, at the start and at the end, shape (2, n).
    """
    basis = bernstein(np.linspace(0.0, 1.0, len(values)), _DEGREE)
    ends = [0, 1, _DEGREE - 1, _DEGREE]
    points = np.zeros((_DEGREE + 1, values.shape[1]))
    points[0], points[-1] = values[0], values[-1]
    points[1], points[-2] = values[0] + rates[0] / _DEGREE, values[-1] - rates[1] / _DEGREE
    inner = np.setdiff1d(np.arange(_DEGREE + 1), ends)
    left = values - basis[:, ends] @ points[ends]
    points[inner] = np.linalg.lstsq(basis[:, inner], left, rcond=None)[0]
    return points


def _npz(arrays: Callable[[Motion], Mapping[str, Array]]) -> Callable[[Motion], bytes]:
    def content(motion: Motion) -> bytes:
        buffer = io.BytesIO()
        np.savez(buffer, **arrays(motion))  # type: ignore[arg-type]  # no array is "allow_pickle"
        return buffer.getvalue()

    return content


def _table_text(header: Sequence[str], rows: Array, digits: int) -> bytes:
    """Return a table as comma-separated values, with a header unless it is empty."""
    form = ",".join([f"%.{digits}g"] * rows.shape[1]) + "\n"
    parts = [csv_bytes([header] if header else [])]
    for begin in range(0, len(rows), _AT_ONCE):  # as floats of Python rows take four times as much
        block = rows[begin : begin + _AT_ONCE].tolist()
        parts.append("".join(form % tuple(row) for row in block).encode())
    return b"".join(parts)


def _table(motion: Motion) -> bytes:
    columns = table_columns(motion)
    return _table_text(list(columns), np.stack([*columns.values()], axis=1), 12)


def _json(motion: Motion) -> bytes:
    entries = []
    for name, value in motion_record(motion).items():
        rows = _json_rows(value) if isinstance(value, np.ndarray) else json.dumps(value)
        entries.append(f"{json.dumps(name)}: {rows}")
    return ("{\n" + ",\n".join(entries) + "\n}\n").encode()


def _json_rows(values: Array) -> str:
    """Return an array as JSON, numbers with twelve digits."""
    if values.dtype == bool:
        return json.dumps(values.tolist())
    form = "%.12g"
    for size in reversed(values.shape[1:]):
        form = "[" + ", ".join([form] * size) + "]"
    rows = values.reshape(len(values), -1).tolist()
    return "[" + ", ".join([form % tuple(row) for row in rows]) + "]"


def _yaml(motion: Motion) -> bytes:
    """Return Bezier curves as YAML: a key a line, lists within it as JSON, which YAML reads."""
    lines = []
    for key, value in bezier_record(motion).items():
        if isinstance(value, dict):
            lines.append(f"{key}:")
            lines += [f"  {name}: {json.dumps(one)}" for name, one in value.items()]
        else:
            lines.append(f"{key}: {json.dumps(value)}")
    return with_points("\n".join(lines) + "\n").encode()


FORMATS: dict[str, MotionFormat] = {
    form.name: form
    for form in (
        MotionFormat("motion", ".npz", 50.0, "mujoco", _npz(tracker_arrays)),
        MotionFormat("mujoco", ".npz", 100.0, "mujoco", _npz(mujoco_arrays)),
        MotionFormat("pinocchio", ".npz", 100.0, "gait", _npz(pinocchio_arrays)),
        MotionFormat("csv", ".csv", 100.0, "gait", _table),
        MotionFormat(
            "g1-csv", ".csv", 30.0, "g1", lambda one: _table_text([], one.samples.configuration, 9)
        ),
        MotionFormat("bezier", ".yaml", 100.0, "gait", _yaml, sampled=False),
        MotionFormat("json", ".json", 100.0, "gait", _json),
    )
}
"""Forms of motions by name."""


INDEX = "index.csv"
"""Table of the motions of a library."""

_SAME_SPEED = 1e-6  # m/s: gaits of a library of Bezier curves differ by more


@checked_arguments
def export(
    gait: Gait,
    path: str | Path,
    *,
    both_legs: bool = False,
    format: str | None = None,  # noqa: A002  # as on the command line
    rate: float | None = None,
    strides: float | None = None,
    joints: str | Collection[str] | None = None,
) -> Path:
    """Write a gait for a controller, an engine or a learner, atomically.

    Args:
        path: file; without a format its suffix chooses the form: .csv, .json, .yaml or .yml with
            the samples of the gait file.
        both_legs: whether those are of a whole stride, not of one step; only without a format.
        format: name of a form of motions, a key of `FORMATS`.
        rate: samples a second [Hz]; by default that of the format.
        strides: number of strides of two steps, 1 by default; halves are steps.
        joints: order of the joints: "gait", "mujoco", "isaac", "g1", "mjcf", or names; by default
            that of the format.

    Raises:
        InputError: the form is unknown, what is asked does not go with it, or the path cannot be
            written.
        RobotError: the gait holds no robot, and its URDF is not one.
    """
    asked = {"rate": rate, "strides": strides, "joints": joints}
    given = [name for name, value in asked.items() if value is not None]
    if format is None:
        if given:
            raise InputError(
                f"{' and '.join(given)}: only motions of a named format take that; name one, as "
                "format 'mujoco'"
            )
        return export_step(gait, path, both_legs=both_legs)
    form = form_for(path, format)
    if both_legs:
        raise InputError(
            f"both legs are in every motion; leave that out with format '{format}', or ask for "
            "strides"
        )
    return write_atomically(path, _content(gait, form, rate, strides, joints))


def form_for(path: str | Path, format: str) -> MotionFormat:  # noqa: A002
    """Return the form of motions of a name, for a file.

    Raises:
        InputError: there is none, or the name of the file ends otherwise.
    """
    form = format_named(format)
    if Path(path).suffix.lower() != form.suffix:
        raise InputError(f"cannot write '{path}': files of format '{format}' end in {form.suffix}")
    return form


@checked_arguments
def export_transition(
    transition: Transition,
    path: str | Path,
    *,
    format: str,  # noqa: A002
    rate: float | None = None,
    joints: str | Collection[str] | None = None,
) -> Path:
    """Write a transition as a motion, with what it leads from and to, atomically.

    A stride of the walk before, or half a second of rest; the steps; the same after them.

    Args:
        format, rate, joints: as in `export`.

    Raises:
        InputError: as in `export`, or the form has no samples.
    """
    form = form_for(path, format)
    return write_atomically(path, _content(transition, form, rate, None, joints))


@checked_arguments
def export_library(
    library: Library | str | Path,
    directory: str | Path,
    *,
    format: str,  # noqa: A002
    rate: float | None = None,
    strides: float | None = None,
    joints: str | Collection[str] | None = None,
) -> Path:
    """Write every gait of a library in one form, and a table of what is where.

    Points without a gait, or whose file cannot be used, are lines without a file.

    Args:
        directory: where to write; made if it does not exist.
        format, rate, strides, joints: as in `export`.

    Returns:
        The path of the table: file, the quantities swept, speed [m/s], step duration [s], step
        length [m], cost, status.

    Raises:
        GaitFileError: it is no gait library.
        InputError: as in `export`, or the library has no gait.
    """
    form = format_named(format)
    folder = Path(directory)
    found = library if isinstance(library, Library) else open_library(library)
    if realpath(folder) == realpath(found.directory):
        raise InputError(f"'{folder}' is the library itself; give another directory")
    axes = [axis.name for axis in found.grid.axes]
    there = {
        point: found.gait(point)
        for point, state in sorted(found.states.items())
        if state.row is not None and point not in found.faults
    }
    if not there:
        raise InputError(f"the library '{found.directory}' has no gait that can be exported")
    names = _file_names(form, {point: gait.speed for point, gait in there.items()}, found)
    rows = []
    for point, row in zip(sorted(found.states), found.rows, strict=True):
        line: Row = {"file": None, **{axis: row.get(axis) for axis in axes}}
        if point in there:
            gait = there[point]
            content = _content(gait, form, rate, strides, joints)
            make_directory(folder)  # not before it is known that what is asked for can be had
            line["file"] = write_atomically(folder / names[point], content).name
            told: Row = {"speed": gait.speed, "duration": gait.duration}
            told |= {"lateral_speed": gait.lateral_speed, "turn_rate": gait.turn_rate}
            told |= {"step_length": gait.step_length, "cost": gait.cost}
            line = {**told, **line}  # what was swept over to the digit that was asked for
        rows.append({**line, "status": row.get("status")})
    known = ["speed", "lateral_speed", "turn_rate", "duration", "step_length", "cost", "status"]
    columns = dict.fromkeys(["file", *axes, *known])
    table = csv_bytes([columns, *([row.get(name) for name in columns] for row in rows)])
    return write_atomically(folder / INDEX, table)


def _content(
    gait: Gait | Transition,
    form: MotionFormat,
    rate: float | None,
    strides: float | None,
    joints: str | Collection[str] | None,
) -> bytes:
    if not form.sampled and (rate is not None or strides is not None):
        raise InputError(
            f"format '{form.name}' has curves, not samples; leave rate and strides out"
        )
    return form.content(
        motion(
            gait,
            form.rate if rate is None else rate,
            1.0 if strides is None else strides,
            form.joints if joints is None else joints,
        )
    )


def _file_names(
    form: MotionFormat, speeds: Mapping[Index, float], library: Library
) -> dict[Index, str]:
    """Return names of files by point; learners on Bezier libraries want them numbered by speed."""
    if form.name != "bezier":
        return {point: f"{library.grid.name(point)}{form.suffix}" for point in speeds}
    order = sorted(speeds, key=lambda point: speeds[point])
    for one, other in pairwise(order):
        if speeds[other] - speeds[one] < _SAME_SPEED:
            raise InputError(
                f"{library.grid.name(one)} and {library.grid.name(other)} walk at the same speed; "
                "a library of Bezier curves has one gait a velocity: sweep the speed alone"
            )
    return {point: f"v_{k + 1}_1{form.suffix}" for k, point in enumerate(order)}
