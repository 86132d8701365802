"""A transition as it was found: its steps, and what they lead from and to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from functools import cached_property

import numpy as np

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.costs import TorqueCost, per_second
from gaitopt.gait.recorded import Recorded
from gaitopt.gait.result import Gait
from gaitopt.gait.trajectory import StepSequence, TrajectoryPhase
from gaitopt.nlp import Array

REST = 0.5
"""Time for which the motion of a transition stands before it begins and after it ends [s]."""
_CYCLE = 2  # steps of a walk that its motion walks before and after


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
        return f"<Transition {self.words}: {len(self.steps)} steps, {self.duration:.3f} s, {proof}>"

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

    @property
    def lateral_speed(self) -> float:
        """Zero: it leads straight on [m/s]."""
        return 0.0

    @property
    def turn_rate(self) -> float:
        """Zero: it leads straight on [rad/s]."""
        return 0.0

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
