"""What a gait asks of its joints: peaks, effective values, and how much of the limits they use."""

from __future__ import annotations

import numpy as np
from scipy.integrate import trapezoid

from gaitopt.design.joint_pairs import brace, shared_name
from gaitopt.gait.result import Gait

_FROM_HIP = (5, 4, 3, 2, 1, 0)  # stance joints are stored from the ankle up


def joint_summaries(gait: Gait) -> list[dict[str, object]]:
    """Return one record per joint and leg, from hip to ankle, the stance leg before the swing leg.

    Each holds `joint` (the name both legs share), `name` (in the URDF) and `leg`, then peak and
    effective torque [N·m], peak speed [rad/s] and power [W], limits, and the share used.
    """
    return [
        {"joint": pair_name(gait, i), "name": gait.joint_names[i], "leg": leg} | _demand(gait, [i])
        for stance in _FROM_HIP
        for i, leg in ((stance, "stance"), (partner(gait, stance), "swing"))
    ]


def motor_summaries(gait: Gait) -> list[dict[str, object]]:
    """Return one record per motor of a leg, from hip to ankle, over a stance and a swing phase."""
    return [{"joint": pair_name(gait, i)} | _demand(gait, [i, partner(gait, i)]) for i in _FROM_HIP]


def partner(gait: Gait, joint: int) -> int:
    """Return the joint of the other leg that the leg exchange E pairs with a joint."""
    return int(np.argmax(np.abs(gait.mirror[:, joint])))


def pair_name(gait: Gait, joint: int) -> str:
    """Return what the names of a joint and its partner share: right_knee, left_knee -> "knee".

    Where they share nothing, or two pairs share the same, both names as a shell would write them.
    """
    pairs = [(gait.joint_names[i], gait.joint_names[partner(gait, i)]) for i in _FROM_HIP]
    shared = [shared_name(*pair) for pair in pairs]
    own = (gait.joint_names[joint], gait.joint_names[partner(gait, joint)])
    name = shared_name(*own)
    return name if name and shared.count(name) == 1 else brace(*sorted(own))


def _demand(gait: Gait, joints: list[int]) -> dict[str, object]:
    """Return peaks over the joints, and effective torque over as many steps."""
    torque, rate = gait.torque[:, joints], gait.dq[:, joints]
    mean_square = trapezoid((torque**2).mean(axis=1), gait.time) / gait.duration
    peak_torque, peak_speed = float(np.abs(torque).max()), float(np.abs(rate).max())
    torque_limit, speed_limit = (_limit(gait, kind, joints) for kind in ("torque", "speed"))
    return {
        "peak_torque_Nm": peak_torque,
        "rms_torque_Nm": float(np.sqrt(mean_square)),
        "torque_limit_Nm": torque_limit,
        "torque_used": None if torque_limit is None else peak_torque / torque_limit,
        "peak_speed_rad_per_s": peak_speed,
        "speed_limit_rad_per_s": speed_limit,
        "speed_used": None if speed_limit is None else peak_speed / speed_limit,
        "peak_power_W": float(np.abs(torque * rate).max()),
    }


def _limit(gait: Gait, kind: str, joints: list[int]) -> float | None:
    limits = gait.joint_limit(kind)
    if limits is None:
        return None
    least = float(limits[joints].min())
    return least if np.isfinite(least) and least > 0.0 else None
