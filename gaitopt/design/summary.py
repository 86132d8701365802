"""What a gait asks of its robot, in the figures a roboticist looks for; units are in the keys."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.integrate import trapezoid

from gaitopt.design.joint_summary import joint_summaries, motor_summaries
from gaitopt.gait.result import Gait
from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.importers.report import findings_of
from gaitopt.model.physics_record import GRAVITY_KEY
from gaitopt.nlp import Array

Facts = dict[str, object]


def summarise(gait: Gait) -> Facts:
    """Return the figures of a gait as JSON-able data, None where they were not recorded.

    Keys of the result: robot, findings (about it, each with topic, subject, how and text), physics
    (see `physics_record`), walk, joints (of stance and swing leg), motors (of one leg over
    stance and swing), contact, impact, solver, certificate, versions.
    """
    return {
        "robot": {
            "name": gait.text("robot"),
            "mass_kg": gait.number("mass"),
            "leg_length_m": gait.number("leg_length"),
        },
        "findings": [finding.record() for finding in findings_of(gait.fact("findings"))],
        "physics": gait.fact("physics"),
        "walk": _walk(gait),
        "joints": joint_summaries(gait),
        "motors": motor_summaries(gait),
        "contact": _contact(gait),
        "impact": _impact(gait),
        "solver": _solver(gait),
        "certificate": _certificate(gait),
        "versions": gait.fact("versions"),
    }


def _walk(gait: Gait) -> Facts:
    """Speed, step and cost; the cost of transport is that of |torque * rate|, Eq. (46) is J."""
    power = np.abs(gait.torque * gait.dq).sum(axis=1)
    work = float(trapezoid(power, gait.time))
    mass = gait.number("mass")
    gravity = gait.number("physics", GRAVITY_KEY) or STANDARD_GRAVITY
    transport = None if mass is None else work / (mass * gravity * gait.step_length)
    return {
        "cost_N2ms": gait.cost,
        "speed_m_per_s": gait.speed,
        "step_length_m": gait.step_length,
        "step_duration_s": gait.duration,
        "steps_per_minute": 60.0 / gait.duration,
        "mechanical_work_per_step_J": work,
        "mechanical_cost_of_transport": transport,
    }


def _contact(gait: Gait) -> Facts:
    force = gait.ground_wrench[:, :3]
    return {
        "cop_to_edge_mm": _edge_distances(gait, gait.cop),
        "friction_used": _friction(force),
        "friction_limit": gait.number("task", "margins", "friction"),
        "least_vertical_force_N": float(force[:, 2].min()),
        "largest_vertical_force_N": float(force[:, 2].max()),
        "highest_swing_toe_mm": 1e3 * float(gait.swing_sole[:, :2, 2].max()),
    }


def _impact(gait: Gait) -> Facts:
    """The landing: how hard, and how near to slipping and tipping."""
    impulse = gait.impulse[None]
    pushes = bool(impulse[0, 2] > 0.0)
    return {
        "vertical_impulse_Ns": float(impulse[0, 2]),
        "horizontal_impulse_Ns": float(np.hypot(impulse[0, 0], impulse[0, 1])),
        "friction_used": _friction(impulse[:, :3]),
        "friction_limit": gait.number("task", "margins", "friction"),
        "cop_to_edge_mm": _edge_distances(gait, centre_of_pressure(impulse)) if pushes else None,
        "largest_rate_jump_rad_per_s": float(np.abs(gait.rate_after - gait.rate_before).max()),
    }


def _solver(gait: Gait) -> Facts:
    keys = ("name", "status", "iterations", "evaluations", "hessians", "seconds")
    record: Facts = {key: gait.fact("solver", key) for key in keys}
    return {**record, "sentence": gait.fact("status"), "refined": gait.fact("refined")}


def _certificate(gait: Gait) -> Facts:
    """What matters of the certificate; the whole of it is in the gait file."""
    record = gait.fact("certificate")
    whole: Mapping[str, object] = record if isinstance(record, Mapping) else {}
    names = ("certified", "verdict", "optimal", "kkt", "kkt_tolerance", "fine_samples")
    more = ("fine_violation", "fine_tolerance", "worst", "referee", "rear_foot_lifts")
    return {name: whole.get(name) for name in (*names, *more, "rear_foot_speed")}


def centre_of_pressure(wrench: Array) -> Array:
    """Return where wrenches (K, 6) press on the sole, Eqs. (37)-(38) [m], shape (K, 2)."""
    return np.stack([-wrench[:, 4], wrench[:, 3]], axis=1) / wrench[:, 2:3]


def _friction(force: Array) -> float | None:
    """Return the largest tangential over normal force of rows (K, 3), None if one does not push."""
    if not (force[:, 2] > 0.0).all():
        return None
    return float((np.hypot(force[:, 0], force[:, 1]) / force[:, 2]).max())


def _edge_distances(gait: Gait, points: Array) -> Facts | None:
    """Return the least distance of points (K, 2) from each edge of the sole [mm]."""
    sole = {name: gait.number("sole", name) for name in ("toe", "heel", "left", "right")}
    if any(edge is None for edge in sole.values()):
        return None
    toe, heel, left, right = (float(edge or 0.0) for edge in sole.values())
    (x_min, y_min), (x_max, y_max) = points.min(axis=0), points.max(axis=0)
    inside = {"front": toe - x_max, "rear": x_min - heel, "left": left - y_max}
    inside["right"] = y_min - right
    return {name: 1e3 * float(distance) for name, distance in inside.items()}
