"""The file of a transition: format 2 of the gait file, for steps that lead from here to there.

The robot, the names and the record are as in the file of a gait; the arrays of a step are there for
every step, and for the gaits at the ends, whose program `gaitopt check` needs to certify the whole
again. docs/gait-file.md documents all of it.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.contact import FlatFoot, PhaseEnd
from gaitopt.errors import GaitFileError, InputError, RobotError
from gaitopt.gait.gait_file import (
    BENT,
    FORMAT,
    MEMBERS,
    OF_STEP,
    STEP_MARK,
    TIED,
    WRITTEN_BY,
    Arrays,
    Member,
    altered,
    archive_bytes,
    arrays_of_step,
    bad_file,
    check_members,
    gait_members,
    gait_of,
    read_body,
    read_gait,
    read_json,
    read_members,
    read_meta,
    read_record,
    record_text,
    refuse_altered,
    same_numbers,
    typed,
)
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition, WeightShift
from gaitopt.version import __version__

SYMMETRY = "transition"
"""What the schedule says in place of how a step is followed by the next of a walk."""
_ENDS = ("before", "after")
_OF_GAIT = ("parameters", "parameter_names", "multipliers", "bound_multipliers", "meta")
_FACTS = (
    "robot", "mass", "leg_length", "leg_joints", "physics", "sole", "choices", "limits",
    "task",
)  # fmt: skip
"""Keys of the record that the steps have as well."""

_BY_NAME = {member.name: member for member in MEMBERS}
SHARED = tuple(
    member
    for member in MEMBERS
    if member.name not in (*OF_STEP, "multipliers", "bound_multipliers")
)
"""Arrays that are in the file as in that of a gait."""
STANDING = (
    Member("standing_q", "float64", ("J",), "rad", "joint"),
    Member("standing_wrench", "float64", (6,), "N, N·m", "sole"),
)
"""Further arrays, of a transition that leads from or to rest."""


SHIFT = (
    Member("shift_knots", "float64", ("k",), "s"),
    Member("shift_coefficients", "float64", ("k + 2", "J"), "rad, rad/s", "joint"),
    Member("shift_front_wrench", "float64", (4, 6), "N, N·m", "sole"),
)
"""Further arrays, of a transition whose first step begins with a shift of the weight."""


def step_members(number: int) -> tuple[Member, ...]:
    """Return the arrays of a step, counted from 1."""
    return _with_prefix(f"step_{number}", OF_STEP, str(number))


def end_members(end: str) -> tuple[Member, ...]:
    """Return the arrays of the gait "before" or "after"."""
    return _with_prefix(end, (*OF_STEP, *_OF_GAIT), f"_{end}")


def _with_prefix(prefix: str, names: tuple[str, ...], index: str) -> tuple[Member, ...]:
    """Return arrays of a gait whose names begin otherwise, with sizes of their own."""

    def sizes(shape: tuple[int | str, ...]) -> tuple[int | str, ...]:
        return tuple(
            size if isinstance(size, int) or size == "J" else size[0] + index + size[1:]
            for size in shape
        )

    found = (_BY_NAME[name] for name in names)
    return tuple(replace(m, name=f"{prefix}_{m.name}", shape=sizes(m.shape)) for m in found)


def members_of(names: Container[str]) -> tuple[Member, ...]:
    """Return the arrays that the file of a transition has, given those of it, or some of them."""
    ends = [end_members(end) for end in _ENDS]
    groups = [
        part for part in (STANDING, SHIFT, *ends, TIED, BENT) if any(m.name in names for m in part)
    ]
    steps = (member for number in _numbers(names) for member in step_members(number))
    *shared, digest = SHARED
    return (*shared, *steps, *(member for part in groups for member in part), digest)


def _numbers(names: Container[str]) -> range:
    """Return the numbers of the steps of a file."""
    count = 1
    while f"step_{count + 1}_{OF_STEP[0]}" in names:
        count += 1
    return range(1, count + 1)


def save_transition(transition: Transition, path: str | Path) -> Path:
    """Write the file of a transition, atomically; equal transitions give equal bytes.

    Args:
        transition: what to write.
        path: file name, used as it is; `.npz` is the custom.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    return write_atomically(path, archive_bytes(transition_members(transition)))


def transition_members(transition: Transition) -> Arrays:
    """Return the arrays of a transition's file by name, all but the digest."""
    first, trajectory = transition.steps[0], transition.trajectory
    found: dict[str, Any] = dict(gait_members(first))
    begin = transition.begins + transition.shifts_for
    for number, step in enumerate(transition.steps):
        at = trajectory.at(begin + step.time, before=step.time > step.duration / 2.0)
        found |= {f"step_{number + 1}_{n}": a for n, a in arrays_of_step(step, at).items()}
        begin += step.duration
    for end, gait in zip(_ENDS, (transition.before, transition.after), strict=True):
        if gait is not None:
            own = gait_members(gait)
            found |= {f"{end}_{name}": own[name] for name in (*OF_STEP, *_OF_GAIT)}
    if transition.rests:
        values = (transition.standing, transition.front_wrench)
        found |= {member.name: value for member, value in zip(STANDING, values, strict=True)}
    if transition.shift is not None:
        shift = transition.shift
        found |= {m.name: getattr(shift, m.name.removeprefix("shift_")) for m in SHIFT}
    found |= {
        "parameters": transition.parameters,
        "parameter_names": transition.parameter_names,
        "schedule": record_text(_schedule(transition)),
        "meta": record_text({**transition.meta, "format": FORMAT, WRITTEN_BY: __version__}),
    }
    return typed(found, members_of(found))


def load_transition(path: str | Path, *, verify: bool = True) -> Transition:
    """Read and validate the file of a transition.

    Args:
        path: of the file.
        verify: whether a file that was changed after it was written is refused.

    Raises:
        GaitFileError: the file cannot be read, or what it holds is no transition.
    """
    found = load(path, verify=verify)
    if isinstance(found, Transition):
        return found
    raise GaitFileError(
        f"'{path}' is the gait of a walk, and this is for a transition; give a file that gaitopt "
        "transition wrote (in Python, save_transition)"
    )


def load(path: str | Path, *, verify: bool = True) -> Gait | Transition:
    """Read and validate a file of a gait or of a transition; arguments as of `load_gait`.

    Raises:
        GaitFileError: as by `load_gait`.
    """
    source = Path(path)
    members, digests = read_members(source)
    if STEP_MARK not in members:
        return read_gait(source, members, digests, verify)
    _, meta = read_meta(source, members)
    wanted = members_of(members)
    if missing := [one.name for one in wanted if one.name not in members]:
        raise bad_file(source, f"it is not a complete transition, '{missing[0]}' is missing")
    try:
        if verify:
            refuse_altered(altered(members, digests))
        check_members(members, wanted)
        return _transition(members, meta)
    except (InputError, RobotError) as error:
        raise bad_file(source, str(error)) from error


def _transition(members: Arrays, meta: dict[str, object]) -> Transition:
    """Return the transition of the arrays and the record of a file.

    Raises:
        InputError: something in it is not what it should be.
    """
    meta.pop(WRITTEN_BY, None)
    shared = {one.name: members[one.name] for one in SHARED}
    body = read_body(members)
    facts = {name: meta[name] for name in _FACTS if name in meta}

    def gait(prefix: str, record: Mapping[str, object]) -> Gait:
        own = {n.removeprefix(prefix): a for n, a in members.items() if n.startswith(prefix)}
        return gait_of({**shared, **own}, record, body)

    steps = []
    for number in _numbers(members):
        one = gait(f"step_{number}_", facts)
        # its parameters follow from those of the whole, which gaitopt check computes
        steps.append(replace(one, parameters=np.zeros(0), parameter_names=()))
    ends = []
    for end in _ENDS:
        there = f"{end}_{OF_STEP[0]}" in members
        ends.append(gait(f"{end}_", _record(members, end)) if there else None)
    rests = [members.get(one.name, np.zeros(0)) for one in STANDING]
    names = tuple(map(str, members["parameter_names"].reshape(-1)))
    before, after = ends
    shifts = SHIFT[0].name in members
    shift = WeightShift(*(members[one.name] for one in SHIFT)) if shifts else None
    result = Transition(
        tuple(steps), before, after, rests[0], rests[1], members["parameters"], names, meta, shift
    )
    _check_statements(result, members)
    return result


def _record(members: Arrays, end: str) -> dict[str, object]:
    """Return the record of a gait at an end."""
    record = read_record(members, f"{end}_meta")
    return {name: one for name, one in record.items() if name not in ("format", WRITTEN_BY)}


def _schedule(transition: Transition) -> dict[str, object]:
    """Return what happens when: which foot stands in every step, and what ends it."""
    feet = (transition.stance_sole, transition.swing_sole_frame)
    last = PhaseEnd.TOUCH_DOWN if transition.after is None else PhaseEnd.IMPACT
    ends = [PhaseEnd.IMPACT] * (len(transition.steps) - 1) + [last]
    phases: list[dict[str, object]] = [
        {
            "contacts": {feet[number % 2]: FlatFoot.name},
            "duration": step.duration,
            "end": end.value,
        }
        for number, (step, end) in enumerate(zip(transition.steps, ends, strict=True))
    ]
    if transition.shift is not None:
        both: dict[str, object] = {
            "contacts": dict.fromkeys(feet, FlatFoot.name),
            "duration": transition.shift.duration,
            "end": PhaseEnd.LIFT_OFF.value,
        }
        phases = [both, *phases]
    return {"phases": phases, "symmetry": SYMMETRY}


def _check_statements(transition: Transition, members: Arrays) -> None:
    """Refuse arrays of a file that are not those of the transition that it holds.

    Raises:
        InputError: there are any.
    """
    found = transition_members(transition)
    for name in found.keys() ^ (members.keys() - {"digest"}):
        raise InputError(f"its '{name}' is no array of such a transition")
    for name, array in found.items():
        if array.dtype.kind == "f" and not same_numbers(array, members[name]):
            raise InputError(f"its '{name}' is not that of its splines and its robot")
    if read_json(members, "schedule") != _schedule(transition):
        raise InputError("its 'schedule' is not that of its steps; this gaitopt reads no other")
