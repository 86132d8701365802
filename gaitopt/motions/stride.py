"""Write a gait in a form that other programs read, chosen by the suffix of the file.

A table (.csv) has one row per sample; a record (.json, .yaml) has names and numbers, nested:
samples, splines, impact and origin.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.polynomial import Polynomial

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import MIRRORED_WRENCH, TrajectoryPhase
from gaitopt.nlp import Array

_JOINTS = ("q", "dq", "ddq", "torque")
_GROUND = {  # mirror images; a moment is an axial vector
    "ground_wrench": np.diag(MIRRORED_WRENCH),
    "cop": np.diag([1.0, -1.0]),
}
_WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
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
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(header)
    # 17 significant digits: reading the text gives the same number
    rows = np.hstack([*blocks, samples["ground_wrench"], samples["cop"]])
    writer.writerows([[f"{value:.17g}" for value in row] for row in rows])
    return buffer.getvalue()


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
