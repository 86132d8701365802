"""Every constraint of section 3.2, one function each, and the few a real walk needs besides."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gaitopt.gait.extra_constraints import switched_on
from gaitopt.gait.families import Entries, Family, FrictionCone, Length, Linear
from gaitopt.gait.grid import Grid
from gaitopt.gait.rows import (
    EDGES,
    FORCE_SCALE,
    FORCE_SMOOTHING,
    FREE,
    IMPULSE_MOMENT_SCALE,
    IMPULSE_SCALE,
    IMPULSE_SMOOTHING,
    LENGTH_SCALE,
    MOMENT_SCALE,
    Setting,
    edge_moments,
    family_over_step,
    ground_rows,
    joint_rows,
    rows_once,
    size,
)
from gaitopt.gait.step import Reads
from gaitopt.gait.task import Task
from gaitopt.mechanics.forward_kinematics import sole_edge_speeds
from gaitopt.robot.model import Robot

_SINKING = 29  # a foot that may sink does so for about a thirtieth of the step
CORNERS = ("toe left", "toe right", "heel left", "heel right")


def torque(at: Setting) -> Family:
    """Eq. (28): |Gamma_i| <= Gamma_i,max."""
    limit = at.robot.limits.torque
    if at.margins.torque_limit is not None:
        limit = np.full(at.robot.tree.size, at.margins.torque_limit)
    return joint_rows(at, "torque", "(28)", Reads.TORQUE, "N·m", -limit, limit, size(limit))


def speed(at: Setting) -> Family:
    """Eq. (29): |dq_i| <= dq_i,max."""
    limit = at.robot.limits.speed
    if at.margins.speed_limit is not None:
        limit = np.full(at.robot.tree.size, at.margins.speed_limit)
    return joint_rows(at, "speed", "(29)", Reads.RATES, "rad/s", -limit, limit, size(limit))


def joint_range(at: Setting) -> Family:
    """Eq. (30): q_min <= q <= q_max."""
    limits, one = at.robot.limits, np.ones(at.robot.tree.size)
    return joint_rows(at, "range", "(30)", Reads.ANGLES, "rad", limits.lower, limits.upper, one)


def knee_flexion(at: Setting) -> Family:
    """Both knees stay bent by a margin from the straight leg."""
    legs = at.robot.legs
    first, second = legs.knees
    chosen = slice(first, second + 1, second - first)
    bend = Entries(chosen, at.robot.tree.size, legs.flexion)
    least = legs.flexion * legs.straight + at.margins.knee_flexion
    labels = tuple(f"{at.robot.joint_names[k]} flexion" for k in legs.knees)
    return family_over_step(
        at, "knee", "3.2.1", Reads.ANGLES, bend, labels, "rad", lower=least, scale=1.0
    )


def leg_length(at: Setting) -> Family:
    """Eq. (31): d(hip, foot) <= l_hip in double support."""
    longest = (at.margins.leg_extension or 1.0) * at.robot.legs.reach
    return Family(
        name="leg length",
        equation="(31)",
        reads=Reads.LEGS,
        rows=Length(),
        labels=("hip-ankle distance",),
        unit="m",
        lower=np.full((2, 1), -FREE),
        upper=np.full((2, 1), longest),
        scale=np.full(1, LENGTH_SCALE),
        instants=np.arange(2),
        times=None,
    )


def lateral(at: Setting) -> Family:
    """Eq. (32) over the whole step: the swing foot stays beside the stance foot."""
    side = at.robot.legs.side
    edge = at.robot.sole.left if side > 0 else -at.robot.sole.right
    labels = tuple(f"swing foot {c} sideways" for c in CORNERS)
    return family_over_step(
        at,
        "lateral",
        "(32)",
        Reads.CORNERS,
        Entries(slice(1, 12, 3), 12, side),
        labels,
        "m",
        lower=edge + at.margins.lateral_gap,
        scale=LENGTH_SCALE,
    )


def clearance(at: Setting) -> Family:
    """Section 3.2.3: the swing foot's corners stay above a smooth profile.

    A foot that may leave the ground with a negative speed sinks at first, whatever it does then;
    the profile is lowered by as much as that.
    """
    inside = np.flatnonzero((at.grid.instants > 0.0) & (at.grid.instants < 1.0))
    s = at.grid.instants[inside]
    profile = at.margins.clearance * np.sin(np.pi * s) ** 2
    if at.margins.liftoff_speed < 0.0:
        profile += at.margins.liftoff_speed * at.task.duration * s * (1.0 - s) ** _SINKING
    labels = tuple(f"swing foot {c} height" for c in CORNERS)
    return family_over_step(
        at,
        "clearance",
        "3.2.3",
        Reads.CORNERS,
        Entries(slice(2, 12, 3), 12),
        labels,
        "m",
        lower=profile[:, None],
        scale=LENGTH_SCALE,
        instants=inside,
    )


def friction(at: Setting) -> Family:
    """Eq. (33): the ground force stays inside the friction cone."""
    cone = FrictionCone(at.margins.friction, FORCE_SMOOTHING)
    return ground_rows(at, "friction", "(33)", cone, ("friction cone margin",), 0.0, FORCE_SCALE)


def load(at: Setting) -> Family:
    """Eq. (35): the stance foot keeps pressing on the ground."""
    vertical = Entries(slice(2, 3), 6)
    least = at.margins.minimum_load
    return ground_rows(at, "load", "(35)", vertical, ("vertical ground force",), least, FORCE_SCALE)


def centre_of_pressure(at: Setting) -> Family:
    """Eqs. (37)-(38) as moments about the edges: they stay linear when the load vanishes."""
    rows = Linear(edge_moments(at))
    labels = tuple(f"centre of pressure, moment about the {e} edge" for e in EDGES)
    return ground_rows(at, "cop", "(37)-(38)", rows, labels, 0.0, MOMENT_SCALE, unit="N·m")


def impulse_up(at: Setting) -> Family:
    """Eq. (36): the ground pushes the landing foot up."""
    return rows_once(
        "impulse", "(36)", Reads.IMPULSE, Entries(slice(2, 3), 6), ("vertical impact impulse",),
        "N·s", 0.0, IMPULSE_SCALE,
    )  # fmt: skip


def impulse_friction(at: Setting) -> Family:
    """Eq. (34): the impulse stays inside the friction cone."""
    cone = FrictionCone(at.margins.friction, IMPULSE_SMOOTHING)
    return rows_once(
        "impulse friction", "(34)", Reads.IMPULSE, cone, ("impulse friction cone margin",),
        "N·s", 0.0, IMPULSE_SCALE,
    )  # fmt: skip


def impulse_cop(at: Setting) -> Family:
    """The landing foot does not tip: impulsive centre of pressure inside the landing sole."""
    labels = tuple(f"impulsive centre of pressure, moment about the {e} edge" for e in EDGES)
    return rows_once(
        "impulse cop", "3.2.3", Reads.IMPULSE, Linear(edge_moments(at)), labels,
        "N·m·s", 0.0, IMPULSE_MOMENT_SCALE,
    )  # fmt: skip


def liftoff(at: Setting) -> Family:
    """Section 2.4.1, first case: the old stance foot leaves the ground at all four corners."""
    rows = Linear(sole_edge_speeds(at.robot.sole.corners))
    labels = tuple(f"rear foot {c} lift-off speed" for c in CORNERS)
    return rows_once(
        "lift-off", "2.4.1", Reads.SOLE_TWIST, rows, labels, "m/s", at.margins.liftoff_speed, 1.0
    )


def walking_speed(at: Setting) -> Family:
    """Eq. (39): V T - d = 0."""
    rows = Linear(np.array([[-1.0, at.task.speed]]))
    return rows_once(
        "walking speed", "(39)", Reads.TRAVEL, rows, ("V T - d",), "m", 0.0, 1.0, upper=0.0
    )


def closure(at: Setting) -> Family:
    """Lifted form of Eq. (26): pelvis and swing sole are where the quantities put them."""
    labels = tuple(f"closure along {a}" for a in "xyz") + tuple(f"closure about {a}" for a in "xyz")
    return Family(
        name="closure",
        equation="(26)",
        reads=Reads.GAPS,
        rows=Entries(slice(0, 6), 6),
        labels=labels,
        unit="m, rad",
        lower=np.zeros((2, 6)),
        upper=np.zeros((2, 6)),
        scale=np.full(6, LENGTH_SCALE),
        instants=np.arange(2),
        times=None,
    )


_STANDARD: tuple[Callable[[Setting], Family], ...] = (
    torque,
    speed,
    load,
    friction,
    centre_of_pressure,
    impulse_up,
    impulse_friction,
    liftoff,
    clearance,
    lateral,
    knee_flexion,
)


def families(robot: Robot, task: Task, grid: Grid) -> tuple[Family, ...]:
    """Return the constraint families of a task, in a fixed order.

    To add a constraint: write a function above that returns its Family, and list it here.
    """
    at = Setting(robot, task, grid)
    chosen = list(_STANDARD)
    if task.margins.leg_extension is not None:
        chosen.append(leg_length)
    if task.margins.joint_range:
        chosen.append(joint_range)
    if task.margins.impulse_cop:
        chosen.append(impulse_cop)
    if task.speed_as == "constraint":
        chosen.append(walking_speed)
    if task.boundary == "lifted":
        chosen.append(closure)
    return tuple(make(at) for make in (*chosen, *switched_on(task.margins)))
