"""A transition as it was found: its steps, and what they lead from and to.

Its file is of format 2 of the gait file, for steps that lead from here to there: robot, names and
record are as in that of a gait; the arrays of a step are there for
every step, and for the gaits at the ends, whose program `gaitopt check` needs to certify the whole
again. docs/gait-file.md documents all of it.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gaitopt.atomic import write_atomically
from gaitopt.bounds import fixed
from gaitopt.contact import FlatFoot, PhaseEnd
from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitFileError, InputError, RobotError
from gaitopt.gait.costs import TorqueCost, per_second
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
from gaitopt.gait.result import Gait, Recorded
from gaitopt.gait.trajectory import StepSequence, TrajectoryPhase
from gaitopt.nlp import Array
from gaitopt.settings import checked_arguments, checked_facts
from gaitopt.version import __version__

REST = 0.5
"""Time for which the motion of a transition stands before it begins and after it ends [s]."""
_CYCLE = 2  # steps of a walk that its motion walks before and after


@checked_facts
@dataclass(frozen=True, eq=False)
class WeightShift:
    """How the weight moves over the first stance foot before the other leaves the ground.

    Attributes:
        knots: of the joints' splines [s], shape (m,).
        coefficients: angles at the knots [rad], rates at the start and at the end, (m + 2, n): the
            leg that will swing is near its splines, where its sole rests.
        front_wrench: of the ground on the foot that will swing, in its sole frame: control points
            of a cubic in Bernstein's form [N, N·m], shape (4, 6).
    """

    knots: Array
    coefficients: Array
    front_wrench: Array

    @property
    def duration(self) -> float:
        """Duration of it [s]."""
        return float(self.knots[-1])

    @property
    def phase(self) -> TrajectoryPhase:
        """It as a phase of the motion."""
        return TrajectoryPhase(0, self.knots, self.coefficients, front=self.front_wrench)


@checked_facts
@dataclass(frozen=True, eq=False)
class Transition(Recorded):
    """Steps from rest or from a walk to another walk or to rest.

    Attributes:
        steps: as of a gait, each seen from its own stance foot, as mirror images; the first one
            stands on the foot of the gaits' `stance_sole`. Their parameters are among those of the
            whole.
        before, after: the gaits that it leads from and to; None at rest.
        standing: joint angles of the robot at rest (n,) [rad]; empty where it rests at neither end.
        front_wrench: of the ground on the swing foot there, in its sole frame (6,) [N, N·m], or
            empty; the other foot has the rest.
        parameters, parameter_names: of the program, (P,).
        shift: what comes before the first step; None where its foot leaves at once.
        meta: JSON-able record (robot, task, durations, cost, solver, certificate, versions).
        joint_names, mirror, urdf, stance_sole, swing_sole_frame: as of its steps.

    Raises:
        InputError: there is no step, or its ends do not fit.
    """

    steps: tuple[Gait, ...]
    before: Gait | None
    after: Gait | None
    standing: Array
    front_wrench: Array
    parameters: Array
    parameter_names: tuple[str, ...]
    meta: Mapping[str, object] = field(default_factory=dict)
    shift: WeightShift | None = None
    joint_names: tuple[str, ...] = field(init=False)
    mirror: Array = field(init=False)
    urdf: str = field(init=False)
    stance_sole: str = field(init=False)
    swing_sole_frame: str = field(init=False)
    lateral_speed = turn_rate = 0.0  # it leads straight on

    def __post_init__(self) -> None:
        if not self.steps or any(len(one.phases) > 1 or one.second for one in self.every):
            raise InputError("a transition has one step or more, and all its steps on flat feet")
        for name in ("joint_names", "mirror", "urdf", "stance_sole", "swing_sole_frame"):
            object.__setattr__(self, name, getattr(self.steps[0], name))
        names = self.joint_names
        if any(one.joint_names != names for one in self.every):
            raise InputError("the steps of a transition move other joints than its gaits")
        sizes = self.standing.shape, self.front_wrench.shape
        if sizes != (((len(names),), (6,)) if self.rests else ((0,), (0,))):
            raise InputError(
                "a transition from or to rest has the posture and the wrench of a robot at rest, "
                "another has neither"
            )
        if self.shift is not None and self.before is not None:
            raise InputError("a transition from a walk has no shift of the weight")
        if len(self.parameters) != len(self.parameter_names):
            raise InputError(
                f"a transition has {len(self.parameters)} parameters and "
                f"{len(self.parameter_names)} names of them"
            )

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        proof = "certified" if self.certified else "not certified"
        steps = f"{len(self.steps)} steps, {fixed(self.duration, 3)} s"
        return f"<Transition {self.words}: {steps}, {proof}>"

    @property
    def rests(self) -> bool:
        """Whether it leads from or to rest."""
        return self.before is None or self.after is None

    @property
    def every(self) -> tuple[Gait, ...]:
        """Its steps, then the gaits at its ends."""
        return (*self.steps, *(one for one in (self.before, self.after) if one is not None))

    @property
    def ends(self) -> tuple[str, str]:
        """What it leads from and to, in words: "standing", "1 m/s"."""
        before, after = ("standing" if g is None else g.way for g in (self.before, self.after))
        return before, after

    @property
    def words(self) -> str:
        """Both in words: "from standing to 1 m/s"."""
        return f"from {self.ends[0]} to {self.ends[1]}"

    @property
    def step_lengths(self) -> tuple[float, ...]:
        """How far ahead of the standing foot the other lands in each step [m]."""
        ends = self.begins + self.shifts_for + np.cumsum([step.duration for step in self.steps])
        samples = self.trajectory.at(ends, before=True)
        each = zip(samples.sole, samples.standing, strict=True)
        return tuple(
            float((np.linalg.inv(soles[foot]) @ soles[1 - foot])[0, 3]) for soles, foot in each
        )

    @property
    def duration(self) -> float:
        """Duration of all its steps, with the shift of the weight [s]."""
        return self.shifts_for + sum(step.duration for step in self.steps)

    @property
    def shifts_for(self) -> float:
        """Duration of the shift of the weight [s]; 0 where there is none."""
        return 0.0 if self.shift is None else self.shift.duration

    @property
    def cost(self) -> float | None:
        """Mean of the cost per second, None if it was not recorded."""
        return self.number("cost")

    @property
    def cost_unit(self) -> str:
        """Unit of the cost."""
        found = next(one for one in (self.after, self.before) if one is not None)
        return per_second(found.text("task", "cost", "unit") or TorqueCost().unit)

    @property
    def speed(self) -> float:
        """Speed of the walk that it leads to [m/s]; 0 where that is rest."""
        return 0.0 if self.after is None else self.after.speed

    @property
    def step_length(self) -> float:
        """Length of a step of that walk [m]."""
        return 0.0 if self.after is None else self.after.step_length

    @cached_property
    def trajectory(self) -> StepSequence:  # type: ignore[override]
        """The motion: a stride of the walk before, or a rest, the steps, and the same after them.

        Time is 0 where that begins; the transition itself begins at `begins`.
        """
        first = self.steps[0]
        lead, tail = self._around(self.before), self._around(self.after)
        body = first.trajectory.body
        shift = () if self.shift is None else (self.shift.phase,)
        phases = (*lead, *shift, *(_phase(step) for step in self.steps), *tail)
        others = range(len(phases) - len(lead) - len(shift))
        numbers = (*range(-len(lead), 0), *(0 for _ in shift), *others)
        return StepSequence(body, phases, first.mirror, numbers=numbers)

    @property
    def phase_names(self) -> tuple[str, ...]:
        """What the phases of its trajectory are, in words, "standing", "step 1"."""
        lead, tail = (
            [words] * len(self._around(gait))
            for words, gait in zip(self.ends, (self.before, self.after), strict=True)
        )
        shift = () if self.shift is None else ("weight shift",)
        steps = (f"step {number + 1}" for number in range(len(self.steps)))
        return (*lead, *shift, *steps, *tail)

    @property
    def begins(self) -> float:
        """Time in its trajectory at which its first step begins [s]."""
        return sum(phase.duration for phase in self._around(self.before))

    def _around(self, gait: Gait | None) -> tuple[TrajectoryPhase, ...]:
        if gait is not None:
            return (_phase(gait),) * _CYCLE
        return (standing_phase(self.standing, self.front_wrench),)


def standing_phase(angles: Array, front_wrench: Array, duration: float = REST) -> TrajectoryPhase:
    """Return a phase at rest on both feet.

    Args:
        angles: of the joints [rad], shape (n,).
        front_wrench: of the ground on the foot that does not carry the phase [N, N·m], (6,).
        duration: of it [s].
    """
    still = np.zeros((2, angles.size))
    coefficients = np.concatenate([np.tile(angles, (2, 1)), still])
    knots = np.array([0.0, duration])
    return TrajectoryPhase(0, knots, coefficients, front=np.tile(front_wrench, (4, 1)))


def _phase(step: Gait) -> TrajectoryPhase:
    return TrajectoryPhase(0, step.knots, step.coefficients)


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


@checked_arguments
def save_transition(transition: Transition, path: str | Path) -> Path:
    """Write the file of a transition, atomically; equal transitions give equal bytes.

    Args:
        path: file name, used as it is; `.npz` is the custom.

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


@checked_arguments
def load_transition(path: str | Path, *, verify: bool = True) -> Transition:
    """Read and validate the file of a transition.

    Args:
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
    """Return the transition of the arrays and the record of a file."""
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
        record = read_record(members, f"{end}_meta") if there else {}
        own = {name: one for name, one in record.items() if name not in ("format", WRITTEN_BY)}
        ends.append(gait(f"{end}_", own) if there else None)
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


def _schedule(transition: Transition) -> dict[str, object]:
    """Return what happens when: which foot stands in every step, and what ends it."""
    feet = (transition.stance_sole, transition.swing_sole_frame)
    last = PhaseEnd.TOUCH_DOWN if transition.after is None else PhaseEnd.IMPACT
    ends = [PhaseEnd.IMPACT] * (len(transition.steps) - 1) + [last]
    phases: list[dict[str, object]] = [
        {"contacts": {feet[number % 2]: FlatFoot.name}, "duration": step.duration, "end": end.value}
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
    """Refuse arrays of a file that are not those of the transition that it holds."""
    found = transition_members(transition)
    for name in found.keys() ^ (members.keys() - {"digest"}):
        raise InputError(f"its '{name}' is no array of such a transition")
    for name, array in found.items():
        if array.dtype.kind == "f" and not same_numbers(array, members[name]):
            raise InputError(f"its '{name}' is not that of its splines and its robot")
    if read_json(members, "schedule") != _schedule(transition):
        raise InputError("its 'schedule' is not that of its steps; this gaitopt reads no other")
