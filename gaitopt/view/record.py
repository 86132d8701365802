"""A gait as nested names and numbers: what JSON and YAML files hold."""

from __future__ import annotations

import json
import re

import numpy as np

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.pieces import cubic_pieces
from gaitopt.view.stride import Stride

_WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
_TEXT_OR_EXPONENT = re.compile(r'"(?:[^"\\]|\\.)*"|(?P<digits>(?<![\d.])\d+)(?P<power>e[+-]?\d+)')
_IMPULSE = ("linear_x", "linear_y", "linear_z", "angular_x", "angular_y", "angular_z")


def json_text(gait: Gait, stride: Stride) -> str:
    """Return the record of a gait as JSON, which is YAML too.

    Raises:
        InputError: there are too few samples between two knots to tell the spline.
    """
    text = json.dumps(record(gait, stride), indent=1, ensure_ascii=False) + "\n"
    return _TEXT_OR_EXPONENT.sub(_with_point, text)


def _with_point(token: re.Match[str]) -> str:
    """Write 1e-05 as 1.0e-05: readers of YAML 1.1 take the first for a text."""
    return f"{token['digits']}.0{token['power']}" if token["digits"] else token[0]


def record(gait: Gait, stride: Stride) -> dict[str, object]:
    """Return samples, splines, impact and origin of a gait for a controller.

    Raises:
        InputError: there are too few samples between two knots to tell the spline.
    """
    joints = gait.joint_names
    return {
        "units": "SI: s, m, kg, rad, N, N.m; signs of the joints as in the URDF",
        "duration": gait.duration,
        "step_length": gait.step_length,
        "speed": gait.speed,
        "joint_names": list(joints),
        "standing_foot_of_step": list(stride.standing),
        "time": stride.time.tolist(),
        "step": stride.step.tolist(),
        "joints": {name: _joint(stride, i) for i, name in enumerate(joints)},
        "ground_wrench_in_standing_sole": _columns(stride.ground_wrench, _WRENCH),
        "cop_in_standing_sole": _columns(stride.cop, ("x", "y")),
        "splines": _splines(gait, stride),
        "impact": _impact(gait),
        "parameters": dict(zip(gait.parameter_names, gait.parameters.tolist(), strict=True)),
        "meta": dict(gait.meta),
    }


def _joint(stride: Stride, index: int) -> dict[str, list[float]]:
    names = ("q", "dq", "ddq", "torque")
    return {name: getattr(stride, name)[:, index].tolist() for name in names}


def _columns(values: Array, names: tuple[str, ...]) -> dict[str, list[float]]:
    return {name: values[:, i].tolist() for i, name in enumerate(names)}


def _splines(gait: Gait, stride: Stride) -> dict[str, object]:
    """Return for each joint, step and piece the coefficients a0 to a3 of Eq. (40)."""
    pieces = cubic_pieces(gait)
    steps = [pieces, np.einsum("ij,kjc->kic", gait.mirror, pieces)][: len(stride.standing)]
    return {
        "formula": "angle = a0 + a1 s + a2 s^2 + a3 s^3, s = time in the step - knots[piece]",
        "order": "[step][piece][a0, a1, a2, a3]",
        "knots": gait.knots.tolist(),
        "coefficients": {
            name: [step[:, i].tolist() for step in steps] for i, name in enumerate(gait.joint_names)
        },
    }


def _impact(gait: Gait) -> dict[str, object]:
    """Return what happens at the landing that ends step 0."""
    rates = {"before": gait.rate_before, "after": gait.rate_after}
    rates["jump"] = gait.rate_after - gait.rate_before
    return {
        "impulse_in_landing_sole": dict(zip(_IMPULSE, gait.impulse.tolist(), strict=True)),
        "rates": {
            name: dict(zip(gait.joint_names, values.tolist(), strict=True))
            for name, values in rates.items()
        },
    }
