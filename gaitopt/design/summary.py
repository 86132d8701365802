"""What a gait asks of its robot, in the figures a roboticist looks for; units are in the keys."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import takewhile
from typing import Any

import numpy as np

from gaitopt.actuators.motors import JointMotor, joint_motors, joint_motors_of
from gaitopt.bounds import fixed, rounded
from gaitopt.errors import SpecError
from gaitopt.escape import printable
from gaitopt.gait.assemble import GRAVITY_KEY
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import ElectricalEnergy, TorqueCost
from gaitopt.gait.motor_space import DrivenJoints
from gaitopt.gait.result import (
    ContactPhase,
    Gait,
    Recorded,
    ground_of,
    recorded_choices,
    recorded_linkages,
)
from gaitopt.gait.transition import Transition
from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.importers.report import findings_of
from gaitopt.model.sole import centre_of_pressure
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments
from gaitopt.solvers.two_stage import UNCONFIRMED
from gaitopt.tolerances import LIMITS, MOMENTUM, OPTIMALITY, REFEREE, SAME
from gaitopt.units import motion_words

Facts = dict[str, object]
_ENVELOPE, _ENERGY = MotorEnvelope.name, ElectricalEnergy.name
_BETWEEN = r"([_\-./ ])"  # what separates the words of a name
_LEAST = 3  # letters: a shorter common end of two words belongs to both
_SIDE = re.compile("left|right", re.IGNORECASE)
_NOT_NEEDED = "the second solver did not reach the same; the certificate does not need it"
_DAMAGED = "the file's record of them is damaged; gaitopt check computes them again"
_REFEREE = ("torque", "wrench", "impulse", "rate_after", "sole_twist", "posture", "rate")


def trapezoid(values: Array, time: Array) -> float:
    """Return the integral of values (N,) over their instants (N,) [s], by the trapezoidal rule."""
    return 0.5 * float(np.diff(time) @ (values[1:] + values[:-1]))


@checked_arguments
def summarise(gait: Gait | Transition) -> Facts:
    """Return the figures of a gait or a transition as JSON-able data, None where not recorded.

    Keys of the result: robot, findings (about it, each with topic, subject, how and text), physics
    (see `physics_record`), walk, joints (of stance and swing leg), motors (of one leg over
    stance and swing, those of linkages last), linkages (their motors in stance and swing leg, as
    joints), contact, impact, solver, certificate, shadow_prices (what one unit of a limit
    is worth), optima (that other starts found, with their motors' peak torques), versions. A
    transition has `transition` in place of walk, contact, impact, shadow_prices and optima: what it
    leads from and to, and each step with its contact and its impact.
    """
    own: Facts
    if isinstance(gait, Transition):
        own = {"transition": _transition(gait)}
    else:
        own = {
            **of_walk(gait),
            "shadow_prices": gait.fact("shadow_prices"),
            "optima": gait.fact("optima"),
        }
    return {
        "robot": {
            "name": gait.text("robot"),
            "mass_kg": gait.number("mass"),
            "leg_length_m": gait.number("leg_length"),
        },
        "findings": [finding.record() for finding in findings_of(gait.fact("findings"))],
        "physics": gait.fact("physics"),
        "joints": joint_summaries(gait),
        "linkages": linkage_summaries(gait),
        "motors": motor_summaries(gait),
        "solver": _solver(gait),
        "certificate": _certificate(gait),
        "versions": gait.fact("versions"),
        **own,
    }


def of_walk(gait: Gait) -> Facts:
    """Return what `summarise` tells of a walk under walk, contact and impact."""
    return {"walk": _walk(gait), "contact": _contact(gait), "impact": _impact(gait)}


def _transition(transition: Transition) -> Facts:
    """Return what a transition leads from and to, what it costs, and each of its steps."""
    return {
        "words": transition.words,
        "from": transition.ends[0],
        "to": transition.ends[1],
        "duration_s": transition.duration,
        "cost": transition.cost,
        "cost_unit": transition.cost_unit,
        "steps": [
            {
                "duration_s": step.duration,
                "step_length_m": length,
                "peak_torque_Nm": float(np.abs(step.torque).max()),
                "peak_speed_rad_per_s": float(np.abs(step.dq).max()),
                "contact": _contact(step),
                "impact": _impact(step),
            }
            for step, length in zip(transition.steps, transition.step_lengths, strict=True)
        ],
    }


def payload_words(gait: Recorded) -> str:
    """Return what the robot of a gait carries in words, empty if nothing."""
    loads = recorded_choices(gait).payloads
    return ", ".join(f"{load.mass:g} kg on {load.link}" for load in loads)


def _walk(gait: Gait) -> Facts:
    """Speed, step and cost; the cost of transport is that of |torque * rate|, Eq. (46) is J."""
    energies = energies_per_step(gait)
    work, mass = energies["absolute_work"], gait.number("mass")
    gravity = gait.number("physics", GRAVITY_KEY) or STANDARD_GRAVITY
    path = abs(gait.step_length)
    if gait.second is not None:
        path = float(np.hypot(gait.speed, gait.lateral_speed)) * gait.duration
    lift = None if mass is None or gait.in_place else mass * gravity * path
    transport = {
        name: None if not lift or energy is None else energy / lift
        for name, energy in energies.items()
    }
    return {
        "cost": gait.cost,
        "cost_unit": gait.cost_unit,
        "cost_words": gait.cost_words,
        "cost_N2ms": gait.cost if gait.cost_unit == TorqueCost().unit else None,
        "speed_m_per_s": gait.speed,
        "lateral_speed_m_per_s": gait.lateral_speed,
        "turn_rate_rad_per_s": gait.turn_rate,
        "step_length_m": gait.step_length,
        "step_duration_s": gait.duration,
        "steps_per_minute": 60.0 / gait.duration,
        "slope_rad": gait.number("task", "slope") or 0.0,
        "cross_slope_rad": gait.number("task", "cross_slope") or 0.0,
        "stairs_m": gait.number("task", "stairs") or 0.0,
        "ground": ground_of(gait).words or "level",
        "load": payload_words(gait) or "none",
        "mechanical_work_per_step_J": work,
        "mechanical_cost_of_transport": transport["absolute_work"],
        "costs_of_transport": transport,
    }


def energies_per_step(gait: Gait) -> dict[str, float | None]:
    """Return what the motors take in a step [J], whatever was minimised, by what is counted.

    In a stride of two steps on the average.

    Absolute and positive mechanical work; electrical energy, without regeneration and with that of
    all braking power, None where the gait has no motors or a joint has none.
    """
    each = [_energies(one) for one in gait.steps]
    found: dict[str, float | None] = {}
    for name in each[0]:
        known = [value for one in each if (value := one[name]) is not None]
        found[name] = sum(known) / len(known) if len(known) == len(each) else None
    return found


def _energies(gait: Gait) -> dict[str, float | None]:
    """Return what the motors take in one step [J], its second apart."""
    power = gait.torque * gait.dq
    found: dict[str, float | None] = {
        "absolute_work": trapezoid(np.abs(power).sum(axis=1), gait.time),
        "positive_work": trapezoid(np.maximum(power, 0.0).sum(axis=1), gait.time),
        "electrical": None,
        "electrical_regenerated": None,
    }
    motors = joint_motors(recorded_motors(gait), gait.joint_names, gait.mirror)
    if all(one is not None for one in motors):
        loss, efficiency, friction = (
            np.array([getattr(one, name) for one in motors])
            for name in ("loss", "efficiency", "friction")
        )
        drawn = loss * gait.torque**2 + np.maximum(power, 0.0) / efficiency
        drawn += friction * np.abs(gait.dq)
        back = efficiency * np.maximum(-power, 0.0)
        found["electrical"] = trapezoid(drawn.sum(axis=1), gait.time)
        found["electrical_regenerated"] = trapezoid((drawn - back).sum(axis=1), gait.time)
    return found


def recorded_motors(gait: Gait) -> tuple[JointMotor, ...]:
    """Return the motors that a gait was designed with; none where it records none."""
    constraints = gait.fact("task", "constraints")
    records = [gait.fact("task", "cost"), *(constraints if isinstance(constraints, list) else ())]
    for record in records:
        fields = record.get("fields") if isinstance(record, Mapping) else None
        rows = fields.get("motors") if isinstance(fields, Mapping) else None
        if rows and isinstance(record, Mapping) and record.get("name") in (_ENVELOPE, _ENERGY):
            with suppress(SpecError):
                return joint_motors_of(rows)
    return ()


def _contact(gait: Gait) -> Facts:
    force = np.concatenate([one.ground_wrench[:, :3] for one in gait.steps])
    pressure = np.concatenate([one.cop[one.flat] for one in gait.steps])
    return {
        **_borne(gait, pressure, force),
        "phases": [_phase(gait, phase) for phase in gait.phases],
        "front_foot": _front_foot(gait) if gait.closing else None,
        "foot_turns_from_s": gait.turns_at if gait.turning else None,
        "foot_angle_rad": gait.foot_angle,
        "flat_from_s": gait.flat_from if gait.lands_on_line else None,
        "landing_angle_rad": gait.landing_angle,
        "highest_swing_toe_mm": 1e3
        * max(float(one.swing_sole[:, :2, 2].max()) for one in gait.steps),
    }


def _front_foot(gait: Gait) -> Facts:
    """Return what the front foot bears while both stand."""
    wrench = np.concatenate(
        [one.front_wrench_at(one.time[one.time > one.knots[-1]]) for one in gait.steps]
    )
    return _borne(gait, centre_of_pressure(wrench), wrench[:, :3])


def _borne(gait: Gait, pressure: Array, force: Array) -> Facts:
    """Return what a foot bears, by its centres of pressure (M, 2) and its forces (N, 3)."""
    return {
        "cop_to_edge_mm": _edge_distances(gait, pressure),
        "friction_used": _friction(force),
        "friction_limit": gait.number("task", "margins", "friction"),
        "least_vertical_force_N": float(force[:, 2].min()),
        "largest_vertical_force_N": float(force[:, 2].max()),
    }


def _phase(gait: Gait, phase: ContactPhase) -> Facts:
    """Return what the stance foot does in a phase of the step, from one change to the next."""
    inside = (gait.time >= phase.begin - SAME * gait.duration) & (gait.time <= phase.end)
    force = gait.ground_wrench[inside, :3]
    return {
        "contact": phase.contact,
        "begin_s": phase.begin,
        "end_s": phase.end,
        "share_of_step": (phase.end - phase.begin) / gait.duration,
        "friction_used": _friction(force),
        "least_vertical_force_N": float(force[:, 2].min()),
        "largest_vertical_force_N": float(force[:, 2].max()),
    }


def _impact(gait: Gait) -> Facts:
    """The landing: how hard, and how near to slipping and tipping; the worse one of a stride's."""
    impulse = np.stack([one.impulse for one in gait.steps])
    soft = bool(gait.fact("task", "margins", "soft_landing"))
    at_zero_speed = soft or (gait.closing and not gait.striking)
    # what is left of the impulse is rounding then: its direction and place say nothing
    pushes = not at_zero_speed and bool((impulse[:, 2] > 0.0).all())
    return {
        "vertical_impulse_Ns": float(impulse[:, 2].max()),
        "horizontal_impulse_Ns": float(np.hypot(impulse[:, 0], impulse[:, 1]).max()),
        "friction_used": None if at_zero_speed else _friction(impulse[:, :3]),
        "friction_limit": gait.number("task", "margins", "friction"),
        "at_zero_speed": at_zero_speed,
        "rear_foot": _of_standing(gait) if gait.striking else None,
        "foot_flat": _of_standing(gait) if gait.slapping else None,
        "cop_to_edge_mm": _edge_distances(gait, centre_of_pressure(impulse)) if pushes else None,
        "largest_rate_jump_rad_per_s": max(
            float(np.abs(one.rate_after - one.rate_before).max()) for one in gait.steps
        ),
    }


def _of_standing(gait: Gait) -> Facts:
    """Return what a foot bears of an impact that stands then; the worse one of a stride's."""
    impulse = np.stack([one.rear_impulse for one in gait.steps])
    pushes = bool((impulse[:, 2] > 0.0).all())
    return {
        "vertical_impulse_Ns": float(impulse[:, 2].max()),
        "friction_used": _friction(impulse[:, :3]),
        "friction_limit": gait.number("task", "margins", "friction"),
        "cop_to_edge_mm": _edge_distances(gait, centre_of_pressure(impulse)) if pushes else None,
    }


def _solver(gait: Recorded) -> Facts:
    keys = ("name", "status", "iterations", "evaluations", "hessians", "seconds")
    record: Facts = {key: gait.fact("solver", key) for key in keys}
    return {**record, "sentence": gait.fact("status"), "refined": gait.fact("refined")}


def _certificate(gait: Recorded) -> Facts:
    """What matters of the certificate; the whole of it is in the gait file."""
    record = gait.fact("certificate")
    whole: Mapping[str, object] = record if isinstance(record, Mapping) else {}
    names = ("certified", "verdict", "optimal", "kkt", "kkt_tolerance", "fine_samples")
    more = ("fine_violation", "fine_tolerance", "worst", "referee", "rear_foot_lifts")
    return {name: whole.get(name) for name in (*names, *more, "rear_foot_speed")}


def proof_rows(
    solver: Mapping[str, Any], certificate: Mapping[str, Any]
) -> list[tuple[str, str, str]]:
    """Return what was checked, what came out, what is allowed, by two records of `summarise`."""
    try:
        rows = [("solver", _solver_words(solver), "")] if solver["name"] is not None else []
        return rows + (_checks(certificate) if certificate["kkt"] is not None else [])
    except (KeyError, TypeError, ValueError, OverflowError):  # a file says whatever it likes
        return [("checks", _DAMAGED, "")]


def _solver_words(solver: Mapping[str, Any]) -> str:
    text = (
        f"{solver['name']}: {solver['iterations']} iterations, "
        f"{solver['evaluations']} evaluations, {solver['seconds']:.2f} s in the solver\n"
        f"{solver['sentence']}"
    )
    return f"{text}\n{_NOT_NEEDED}" if solver["name"] == UNCONFIRMED else text


def _checks(certificate: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return what was checked, what came out, and what is allowed."""
    kkt, referee, worst = certificate["kkt"], certificate["referee"], certificate["worst"]
    speed = certificate["rear_foot_speed"]
    sinks = "-" if speed is None else f"sinks at {-speed:.3g} m/s"
    leaves = "stays, and leaves at rest" if speed == 0.0 else "lifts off"
    return [
        (
            "optimal at the samples (KKT)",
            f"gradient {kkt['stationarity']:.1e}, limits {kkt['feasibility']:.1e}, "
            f"complementarity {kkt['complementarity']:.1e}",
            f"{OPTIMALITY:.0e}",
        ),
        (
            "limits at every instant",
            f"worst violation {certificate['fine_violation']:.1e}\nworst row: {_named(worst)}",
            f"{LIMITS:.0e}",
        ),
        (
            "Newton-Euler referee",
            f"disagrees by {max(referee[name] for name in _REFEREE):.1e}",
            f"{REFEREE:.0e}",
        ),
        (
            "momentum over a step",
            f"{_momentum(referee)}, apart by {referee['momentum']:.1e}",
            f"{MOMENTUM:.0e}",
        ),
        (
            "rear foot after the impact",
            leaves if certificate["rear_foot_lifts"] else sinks,
            "lifts off",
        ),
    ]


def _momentum(referee: Mapping[str, float]) -> str:
    """Return the vertical balance; a walk gains nothing, a transition may."""
    vertical, weight = referee["vertical"], referee["weight"]
    gained = vertical - weight
    change = f" {'+ gain' if gained > 0.0 else '- loss'} {fixed(abs(gained), 3)}"
    # Of a walk, what the sides differ by is within the disagreement, on a slope nearly so.
    changes = abs(gained) > max(2.0 * referee["momentum"], MOMENTUM) * weight
    return f"ground {fixed(vertical, 3)} = weight {fixed(weight, 3)}{change if changes else ''} N·s"


def _named(row: Mapping[str, Any]) -> str:
    """Return a row of the certificate in words."""
    when = "" if row["time"] is None else f" at {fixed(row['time'], 4)} s"
    value, limit = rounded(row["value"]), rounded(row["limit"])
    return f"{printable(str(row['row']))}{when}: {value} {row['unit']}, limit {limit}"


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


def joint_summaries(gait: Gait | Transition) -> list[dict[str, object]]:
    """Return one record per joint, in the order of `joint_groups`, stance before swing side.

    Each holds `joint` (the name both sides share), `name` (in the URDF) and `leg` ("stance" or
    "swing" side, empty for a joint that is its own mirror image), then peak and effective torque
    [N·m], peak speed [rad/s] and power [W], limits, and the share used.
    """
    return [
        {"joint": name, "name": gait.joint_names[i], "leg": leg} | _demand(gait, [i])
        for name, group in named_groups(gait)
        for i, leg in zip(group, ("stance", "swing") if len(group) > 1 else ("",), strict=True)
    ]


def motor_summaries(gait: Gait | Transition) -> list[dict[str, object]]:
    """Return one record per motor of a side, over a stance and a swing phase.

    A joint that motors turn through a linkage has one too; these motors come after it.
    """
    joints: list[dict[str, object]] = [
        {"joint": name} | _demand(gait, list(group)) for name, group in named_groups(gait)
    ]
    return joints + [
        {"joint": name} | _motor_demand(gait, pair, k) for name, pair, k in linkage_motors(gait)
    ]


def linkage_summaries(gait: Gait | Transition) -> list[dict[str, object]]:
    """Return two records for each motor of a linkage, in the stance and in the swing leg.

    They are those of `joint_summaries`: of the motor's torque and speed, and its limits. Motors
    that slide have others of force and speed: `peak_force_N` for `peak_torque_Nm`, and so on.
    """
    return [
        {"joint": name, "name": group.linkage.motors[k], "leg": leg, "turns": list(group.names)}
        | _motor_demand(gait, [group], k)
        for name, pair, k in linkage_motors(gait)
        for group, leg in zip(pair, ("stance", "swing"), strict=True)
    ]


def by_motion(
    records: Iterable[Mapping[str, Any]],
) -> Iterator[tuple[bool, list[Mapping[str, Any]]]]:
    """Yield the records of joints and motors that turn, then of those that slide, if there are any.

    Each with whether these slide: keys and units of them are the `motion_words` of those that turn.
    """
    known = list(records)
    for slides in (False, True):
        key = motion_words("peak_torque_Nm", slides=slides)
        if own := [one for one in known if key in one]:
            yield slides, own


def linkage_motors(gait: Recorded) -> list[tuple[str, list[DrivenJoints], int]]:
    """Return the motors of linkages: name, joints in the stance and swing leg, and its number."""
    groups = recorded_linkages(gait)
    pairs = [
        sorted(pair, key=lambda g: g.rows) for pair in zip(groups[::2], groups[1::2], strict=True)
    ]
    found = [(pair, k) for pair in pairs for k in range(len(pair[0].linkage.motors))]
    full = [pair[0].linkage.motors[k] for pair, k in found]
    words = [re.split(_BETWEEN, _SIDE.sub("", name))[::2] for name in full]
    plain = [" ".join(w for w in each if w and w.lower() != "joint") for each in words]
    taken = [*plain, *(name for name, _ in named_groups(gait))]
    names = [p if p and taken.count(p) == 1 else n for p, n in zip(plain, full, strict=True)]
    return [(name, pair, k) for name, (pair, k) in zip(names, found, strict=True)]


def peak_torques(gait: Gait | Transition) -> dict[str, float]:
    """Return the largest torque of each motor of a side [N·m], by the name both sides share."""
    return {
        name: max(float(np.abs(one.torque[:, list(group)]).max()) for one in gait.steps)
        for name, group in named_groups(gait)
    }


def joint_groups(gait: Recorded) -> list[tuple[int, ...]]:
    """Return joints with their partners of the other side: legs from hip to ankle, then the others.

    A joint that is its own mirror image, as of a waist, has no partner. Joints are stored from the
    stance ankle up, so that the stance leg's come first and in reverse.
    """
    firsts = [i for i in range(len(gait.joint_names)) if i <= partner(gait, i)]
    leg = next((n for n, i in enumerate(firsts) if n != i or partner(gait, i) == i), len(firsts))
    ordered = [*reversed(firsts[:leg]), *firsts[leg:]]
    return [tuple(dict.fromkeys((i, partner(gait, i)))) for i in ordered]


def partner(gait: Recorded, joint: int) -> int:
    """Return the joint of the other side that the exchange E pairs with a joint, or itself."""
    return int(np.argmax(np.abs(gait.mirror[:, joint])))


def named_groups(gait: Recorded) -> list[tuple[str, tuple[int, ...]]]:
    """Return the groups of `joint_groups`, each with what the names of its joints share.

    right_knee, left_knee -> "knee". Where they share nothing, or two pairs share the same, both
    names as a shell would write them.
    """
    groups = joint_groups(gait)
    names = [[gait.joint_names[i] for i in group] for group in groups]
    shared = [shared_name(*pair) if len(pair) > 1 else "" for pair in names]
    found = []
    for pair, name, group in zip(names, shared, groups, strict=True):
        if len(pair) == 1:
            name = pair[0]
        elif not name or shared.count(name) > 1:
            name = brace(*sorted(pair))
        found.append((name, group))
    return found


def group_name(gait: Recorded, joint: int) -> str:
    """Return what the names of a joint and its partner share; see `named_groups`."""
    return next(name for name, group in named_groups(gait) if joint in group)


def _demand(gait: Gait | Transition, joints: list[int]) -> dict[str, object]:
    """Return peaks over the joints, and effective torque over as many steps."""
    each = [(one.torque[:, joints], one.dq[:, joints]) for one in gait.steps]
    limits = (_limit(gait, kind, joints) for kind in ("torque", "speed"))
    return _figures(gait, each, *limits, slides=False)


def _motor_demand(
    gait: Gait | Transition, groups: list[DrivenJoints], motor: int
) -> dict[str, object]:
    """Return the same of a motor of a linkage, over the legs of some groups."""
    values = [[g.values(one.torque, one.dq, one.q) for g in groups] for one in gait.steps]
    each = [
        (
            np.stack([of["torque"][:, motor] for of in step], axis=1),
            np.stack([of["speed"][:, motor] for of in step], axis=1),
        )
        for step in values
    ]
    linkage = groups[0].linkage
    limits = linkage.torque[motor], linkage.speed[motor]
    return _figures(gait, each, *limits, slides=linkage.slides(motor))


def _figures(
    gait: Gait | Transition,
    each: list[tuple[Array, Array]],
    torque_limit: float | None,
    speed_limit: float | None,
    *,
    slides: bool,
) -> dict[str, object]:
    """Return peaks and effective torque of torques and rates (N, c) of each step."""
    squares = [
        trapezoid((torque**2).mean(axis=1), one.time)
        for (torque, _), one in zip(each, gait.steps, strict=True)
    ]
    mean_square = sum(squares) / sum(one.duration for one in gait.steps)
    torque, rate = (np.concatenate(parts) for parts in zip(*each, strict=True))
    peak_torque, peak_speed = float(np.abs(torque).max()), float(np.abs(rate).max())
    figures = {
        "peak_torque_Nm": peak_torque,
        "rms_torque_Nm": float(np.sqrt(mean_square)),
        "torque_limit_Nm": torque_limit,
        "torque_used": None if torque_limit is None else peak_torque / torque_limit,
        "peak_speed_rad_per_s": peak_speed,
        "speed_limit_rad_per_s": speed_limit,
        "speed_used": None if speed_limit is None else peak_speed / speed_limit,
        "peak_power_W": float(np.abs(torque * rate).max()),
    }
    return {motion_words(key, slides=slides): value for key, value in figures.items()}


def _limit(gait: Recorded, kind: str, joints: list[int]) -> float | None:
    limits = gait.joint_limit(kind)
    if limits is None:
        return None
    least = float(limits[joints].min())
    return least if np.isfinite(least) and least > 0.0 else None


def shared_name(first: str, second: str) -> str:
    """Return the words two names share, or their common ends; empty if there is none.

    right_hip_yaw_joint, left_hip_yaw_joint -> "hip yaw"; RHipYaw, LHipYaw -> "HipYaw".
    """
    words, others = (re.split(_BETWEEN, name)[::2] for name in (first, second))
    if len(words) == len(others):
        kept = [_shared_word(a, b) for a, b in zip(words, others, strict=True)]
    else:
        kept = [word for word in words if word in others]
    return " ".join(word for word in kept if word and word.lower() != "joint")


def brace(first: str, second: str) -> str:
    """Return two names as a shell would write them: {left,right}_knee."""
    parts = [re.split(_BETWEEN, name) for name in (first, second)]
    if len(parts[0]) != len(parts[1]):
        return f"{first}, {second}"
    return "".join(a if a == b else _braced(a, b) for a, b in zip(*parts, strict=True))


def _shared_word(first: str, second: str) -> str:
    """Return a word both have, or the longer of its common ends: LHipYaw, RHipYaw -> HipYaw."""
    if first == second:
        return first
    first, second = (_SIDE.sub("", word) for word in (first, second))  # both end in t
    ends = _start(first, second), _end(first, second)
    longest = max(ends, key=len)
    return longest if len(longest) >= _LEAST else ""


def _braced(first: str, second: str) -> str:
    shared = len(_end(first, second))
    cut = len(first) - shared if shared >= _LEAST else len(first)
    return f"{{{first[:cut]},{second[: len(second) - len(first) + cut]}}}{first[cut:]}"


def _start(first: str, second: str) -> str:
    same = takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    return "".join(letter for letter, _ in same)


def _end(first: str, second: str) -> str:
    return _start(first[::-1], second[::-1])[::-1]
