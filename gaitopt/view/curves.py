"""The curves of the page: what every joint and foot does over a period of the walk.

Unlike the figures, which compare the stance leg with the swing leg over one step, they follow the
joints of the robot, so that a cursor can move with the walk.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from gaitopt.design.summary import linkage_motors, named_groups
from gaitopt.gait.result import Recorded
from gaitopt.gait.trajectory import TrajectorySamples
from gaitopt.gait.transition import Transition
from gaitopt.nlp import Array
from gaitopt.units import motion_words

POINTS = 301  # of a period
Record = dict[str, object]


def curves(gait: Recorded) -> Record:
    """Return the curves of a gait over its period, or of a transition, as data for charts.

    Returns:
        `period` and `step` [s], `time` (N,) [s], and `tabs`: for each a name and its panels. A
        panel has a title, a unit, lines (name, side, values; points x and y where it is no curve
        over time), limits, and the joints that it is about. Values are arrays (N,), NaN where
        there is none.
    """
    trajectory = gait.trajectory
    times, before = _instants(gait)
    samples = trajectory.at(times, before=before)
    rows = [trajectory.joint_names.index(name) for name in gait.joint_names]
    torque, rate, angle = (values[:, rows] for values in (samples.torque, samples.dq, samples.q))
    torque_limit = gait.joint_limit("torque")
    pairs = named_groups(gait)
    quantities: tuple[tuple[str, str, Array, Array | None, Array | None], ...] = (
        ("torque", "N·m", torque, torque_limit, None),
        ("speed", "rad/s", rate, gait.joint_limit("speed"), None),
        ("power", "W", torque * rate, None, None),
        ("angle", "rad", angle, None, None),
        ("torque over speed", "N·m over rad/s", torque, torque_limit, rate),
    )
    linked = _linkages(gait, torque, rate, angle)
    tabs = [
        {
            "name": name,
            "panels": [
                *(_joints(gait, *pair, unit, y, limits, x) for pair in pairs),
                *(
                    panels[name] | {"unit": motion_words(unit, slides=slides)}
                    for slides, panels in linked
                ),
            ],
        }
        for name, unit, y, limits, x in quantities
    ]
    tabs.append({"name": "ground", "panels": list(_ground(gait, samples))})
    return {
        "period": trajectory.period,
        "step": trajectory.period if isinstance(gait, Transition) else trajectory.step_duration,
        "time": times,
        "tabs": tabs,
    }


def _instants(gait: Recorded) -> tuple[Array, Array]:
    """Return times [s] of a period, and whether each is the end of the phase before.

    Where the walk jumps there are two instants, before and after.
    """
    trajectory = gait.trajectory
    jumps = trajectory.changes
    inner = np.linspace(0.0, trajectory.period, POINTS)
    inner = inner[np.abs(inner[:, None] - jumps).min(axis=1) > 1e-9]
    times = np.concatenate([inner, jumps, jumps[:-1]])
    before = np.concatenate(
        [np.zeros(len(inner)), np.ones(len(jumps)), np.zeros(len(jumps) - 1)]
    ).astype(bool)
    order = np.lexsort([~before, times])
    return times[order], before[order]


def _joints(
    gait: Recorded,
    title: str,
    group: tuple[int, ...],
    unit: str,
    y: Array,
    limits: Array | None,
    x: Array | None,
) -> Record:
    """Return the panel of a pair of joints: y (N, J) over time, or over x (N, J)."""
    lines = []
    sides = ("stance", "swing") if len(group) > 1 else ("",)
    for joint, side in zip(group, sides, strict=True):
        line: Record = {"name": gait.joint_names[joint], "side": side, "y": y[:, joint]}
        lines.append(line if x is None else {**line, "x": x[:, joint]})
    limit = None if limits is None else float(np.min(limits[list(group)]))
    return {
        "title": title, "unit": unit, "joints": [gait.joint_names[j] for j in group],
        "limits": _bounds(limit), "lines": lines,
    }  # fmt: skip


def _linkages(
    gait: Recorded, torque: Array, rate: Array, q: Array
) -> list[tuple[bool, dict[str, Record]]]:
    """Return for each motor of a linkage whether it slides, and its panels, but for their unit.

    Panels are by the names of tabs.
    """
    found = []
    for title, pair, k in linkage_motors(gait):
        linkage = pair[0].linkage
        limits = {"torque": linkage.torque[k], "speed": linkage.speed[k]}
        limits["torque over speed"] = limits["torque"]
        each = [group.values(torque, rate, q) for group in pair]
        panels: dict[str, Record] = {}
        for name in ("torque", "speed", "power", "angle", "torque over speed"):
            lines = []
            for of, group, side in zip(each, pair, ("stance", "swing"), strict=True):
                line: Record = {"name": f"{linkage.motors[k]}, {group.names[-1]}", "side": side}
                line["y"] = of[name.split()[0]][:, k]
                lines.append(line if " " not in name else {**line, "x": of["speed"][:, k]})
            joints = [joint for group in pair for joint in group.names]
            bounds = _bounds(limits.get(name))
            panels[name] = {"title": title, "joints": joints, "limits": bounds, "lines": lines}
        found.append((linkage.slides(k), panels))
    return found


def _ground(gait: Recorded, samples: TrajectorySamples) -> Iterable[Record]:
    """Yield panels of force, friction and centre of pressure of both feet."""
    force = samples.force
    for axis, title in ((2, "vertical force"), (0, "forward force"), (1, "force to the left")):
        yield {
            "title": title, "unit": "N", "joints": [], "limits": [],
            "lines": [
                {"name": foot, "side": side, "y": force[:, k, axis]}
                for k, foot, side in _feet(gait)
            ],
        }  # fmt: skip
    normal = samples.wrench[..., 2]
    tangential = np.hypot(samples.wrench[..., 0], samples.wrench[..., 1])
    used = np.where(samples.contact & (normal > 0.0), tangential / np.where(normal, normal, 1), 0.0)
    yield {
        "title": "friction used", "unit": "-", "joints": [],
        "limits": _bounds(gait.number("task", "margins", "friction")),
        "lines": [
            {"name": foot, "side": side, "y": used[:, k]} for k, foot, side in _feet(gait)
        ],
    }  # fmt: skip
    for k, foot, side in _feet(gait):
        toe, heel, left, right = gait.trajectory.body.sole_rectangle[k]
        yield {
            "title": f"centre of pressure, {foot}", "unit": "m", "joints": [], "limits": [],
            "box": [float(edge) for edge in (heel, right, toe, left)],
            "lines": [
                {"name": foot, "side": side, "x": samples.pressure[:, k, 0],
                 "y": samples.pressure[:, k, 1]}
            ],
        }  # fmt: skip


def _feet(gait: Recorded) -> Iterable[tuple[int, str, str]]:
    names = (gait.stance_sole, gait.swing_sole_frame)
    for k, side in enumerate(("stance", "swing")):
        yield k, names[k].replace("_sole", " foot").replace("_", " "), side


def _bounds(limit: float | None) -> list[float]:
    """Return the values of a symmetric limit, none where there is none."""
    return [-limit, limit] if limit is not None and np.isfinite(limit) and limit > 0.0 else []
