"""Design of a transition: from standing to a walk, from a walk to standing, from walk to walk."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gaitopt.bounds import fixed, is_finite, shown
from gaitopt.dataclass import dataclass
from gaitopt.design.audit import (
    ROBOT_FACTS,
    Audit,
    differences_of,
    facts_that_differ,
    imposed,
    problem_of,
    robot_differences,
)
from gaitopt.design.certificate import Certificate, certify, worst_rows
from gaitopt.design.options import SIGMA, DesignOptions, Search
from gaitopt.design.pipeline import attempt, is_walk, polished, proof_record, with_instants_of
from gaitopt.design.refinement import with_work
from gaitopt.errors import (
    EvaluationError,
    GaitFileError,
    InputError,
    NoGaitFoundError,
    StoppedError,
)
from gaitopt.gait.assemble import gait_at, limits_record, robot_record, step_gait
from gaitopt.gait.constraints import imposed_limit
from gaitopt.gait.initial_guess import perturbed, transition_guess
from gaitopt.gait.plugin import Extension
from gaitopt.gait.problem import MakeProgress, WalkProblem
from gaitopt.gait.quantities import PEAK
from gaitopt.gait.result import Gait, array_names
from gaitopt.gait.shift_step import ShiftStepModel
from gaitopt.gait.task import Task, task_from_record, task_record
from gaitopt.gait.terrain import Level
from gaitopt.gait.trajectory import StepSequence
from gaitopt.gait.transition import Transition, WeightShift, standing_phase
from gaitopt.gait.transition_problem import (
    STRETCH,
    Junction,
    TransitionProblem,
    TransitionSteps,
    TransitionTask,
    junction_of,
    standing,
    step_durations,
    wrench_standing,
)
from gaitopt.model.import_options import choices_record
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array, Solution, Status, Stop, never
from gaitopt.settings import checked_arguments, plain
from gaitopt.tolerances import SAME

MOST_STEPS = 8
STEPS = 3
"""Steps unless asked otherwise: one does not do, and not every robot begins in two, measured."""
LOOSENED = (
    "torsional_friction", "swing_height", "swing_tilt", "leg_gap", "arm_gap", "landing_speed",
)  # fmt: skip
"""Margins without which a search begins."""
POSTURES = 3
"""Intermediate postures of each step, if the walk has fewer: such steps are less alike."""
_ATTEMPTS, _ITERATIONS = 3, 150
_OF_SHIFT = ("knots", "coefficients", "front_wrench")
_OWN_FACTS = ("durations", "step_lengths", "cost")  # of the record
_Walk = tuple[WalkProblem, Gait]
_SHORTEST, _LONGEST = 0.05, 5.0  # duration of a step [s]


@dataclass(frozen=True)
class TransitionDesign:
    """A transition with how it was found.

    Attributes:
        transition: the result.
        certificate: its proof, over all steps.
        solution: what the solver returned, with the work of all rounds.
        problem: the transition on its final grid.
    """

    transition: Transition
    certificate: Certificate
    solution: Solution
    problem: TransitionProblem

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return f"<TransitionDesign: {self.transition!r}, {self.solution.solver}>"


@checked_arguments
def design_transition(
    before: Gait | None = None,
    after: Gait | None = None,
    *,
    steps: int = STEPS,
    durations: Sequence[float] | float | None = None,
    shift: float = 0.0,
    stretch: float = STRETCH,
    postures: int | None = None,
    margins: Mapping[str, float | bool | None] | None = None,
    options: DesignOptions | None = None,
    on_progress: MakeProgress | None = None,
    stop: Stop = never,
) -> TransitionDesign:
    """Design the steps that lead from one walk to another, or from and to standing.

    Limits, cost and samples are those of the walk after, or where that is rest of the walk before;
    but for the step width, which is a habit of walks: a robot that has to begin to fall, or to
    cease, steps wider. The mean of the cost per second is least.

    Args:
        before, after: gaits, of one robot; None: it stands at rest on both feet.
        durations: of each of them, or of all [s]; by default they are searched, from those of the
            walks and less next to rest.
        shift: from standing, time for which the weight moves over the first stance foot while both
            feet are on the ground [s], longer or shorter where durations are searched; 0: none.
        stretch: of the legs of a robot that stands: distance of hip and ankle over their length.
        postures: intermediate ones of each step, by default those of the walk, or `POSTURES`.
        margins: limits other than those of the walk, by name as in `Margins`.
        stop: where it says True, the search ends.

    Raises:
        InputError: neither is a gait, they do not go together or have phases that transitions do
            not have, or a number is out of range.
        NoGaitFoundError: no transition was found; more steps or searched durations may do.
        StoppedError: `stop` said so before there was one.
    """
    search = Search(options or DesignOptions(), on_progress, stop)
    problem = transition_problem(
        before, after, steps=steps, durations=durations, shift=shift, stretch=stretch,
        postures=postures, margins=margins,
    )  # fmt: skip
    solution = _searched(problem, search)
    found, solution, refined, fine = polished(problem, solution, search)
    assert isinstance(found, TransitionProblem)
    certificate = certify_transition(found, solution.x, fine)
    proof = proof_record(solution, certificate, refined)
    proof["findings"] = [finding.record() for finding in found.robot.findings]
    result = transition_at(found, solution.x, before, after, {"stretch": stretch, **proof})
    return TransitionDesign(result, certificate, solution, found)


def transition_problem(
    before: Gait | None,
    after: Gait | None,
    *,
    steps: int = STEPS,
    durations: Sequence[float] | float | None = None,
    shift: float = 0.0,
    stretch: float = STRETCH,
    postures: int | None = None,
    margins: Mapping[str, float | bool | None] | None = None,
) -> TransitionProblem:
    """Return the program of a transition at the task's samples, as of `design_transition`.

    Raises:
        InputError: as there.
    """
    steps = plain(steps)
    if isinstance(steps, bool) or not isinstance(steps, int) or not 1 <= steps <= MOST_STEPS:
        raise InputError(f"a transition has {shown(steps)} steps; give 1 to {MOST_STEPS}")
    (chosen, begin, finish), _ = _ends(before, after, stretch)
    task = chosen.task.with_margins({"step_width": None}).with_margins(margins or {})
    task = replace(task, postures=max(task.postures, POSTURES) if postures is None else postures)
    for end in (begin, finish):
        if end.rests:
            _check_standing(chosen.robot, task, end)
    lasts = _durations(durations, begin, finish, steps)
    front = _check_shift(shift, chosen.robot, begin)
    asked = TransitionTask(task, begin, finish, lasts, durations is None, shift, front)
    return TransitionProblem(chosen.robot, asked)


@checked_arguments
def audit_transition(transition: Transition, known: Iterable[Extension] = ()) -> Audit:
    """Compute a transition again from its parameters and its gaits, as `audit` does a gait.

    Raises:
        GaitFileError: it lacks what is needed for that, or its parameters make no steps, or its
            gaits no walks.
        RobotError: its URDF is not a biped.
    """
    before, after = transition.before, transition.after
    try:
        problem, walks = _recorded_problem(transition, known)
        again = transition_at(problem, transition.parameters, before, after, {})
        certificate = certify_transition(problem, transition.parameters)
        whole = [gait_at(walk, gait.parameters, {}) for walk, gait in walks]
    except EvaluationError as error:
        raise GaitFileError(f"the parameters do not make a transition: {error}") from error
    differences = differences_of(transition, again, ("standing", "front_wrench", "mirror"))
    if transition.shift is not None and again.shift is not None:
        own = differences_of(transition.shift, again.shift, _OF_SHIFT)
        differences |= {f"shift {name}": value for name, value in own.items()}
    steps = (f"step {number + 1}" for number in range(len(transition.steps)))
    ends = (end for end, gait in (("before", before), ("after", after)) if gait is not None)
    pairs = zip((*steps, *ends), transition.every, (*again.steps, *whole), strict=True)
    for words, stored, computed in pairs:
        own = differences_of(stored, computed, array_names())
        differences |= {f"{words} {name}": value for name, value in own.items()}
    body, names = transition.steps[0].multibody, (*ROBOT_FACTS, "choices", *_OWN_FACTS)
    if body is not None:
        differences |= robot_differences(body, problem.robot.multibody)
    facts = facts_that_differ(transition, again, names, certificate)
    if (transition.shift is None) != (again.shift is None):
        facts.append("shift")
    claimed = transition.certified
    return Audit(differences, tuple(facts), certificate, claimed, imposed(problem))


def _recorded_problem(
    transition: Transition, known: Iterable[Extension]
) -> tuple[TransitionProblem, list[_Walk]]:
    """Return the program that a transition says it solves, and those of the walks at its ends."""
    try:
        stretch = transition.number("stretch")
        task = task_from_record(transition.fact("task"), known)
        (chosen, begin, finish), walks = _ends(
            transition.before, transition.after, STRETCH if stretch is None else stretch, known
        )
        given, free = (transition.fact("given", name) for name in ("durations", "free"))
        if not isinstance(given, list) or not isinstance(free, bool):
            raise InputError("its record 'given' is none of durations")
        lasts = _durations(given, begin, finish, len(transition.steps))
        shift = transition.number("given", "shift") or 0.0
        front = _check_shift(shift, chosen.robot, begin)
        asked = TransitionTask(task, begin, finish, lasts, free, shift, front)
        grid = with_instants_of(asked.grid, transition)
        problem = TransitionProblem(chosen.robot, asked, grid)
    except InputError as error:
        raise GaitFileError(f"the transition's record cannot be used: {error}") from error
    if transition.parameter_names != problem.layout.names:
        raise GaitFileError(
            "the transition's parameter names are not those of its robot and task; it was not "
            "designed by gaitopt, or its URDF or task has been changed"
        )
    return problem, walks


def _ends(
    before: Gait | None, after: Gait | None, stretch: float, known: Iterable[Extension] = ()
) -> tuple[tuple[WalkProblem, Junction, Junction], list[_Walk]]:
    """Return the walk whose robot and limits a transition has, its given states, and every walk."""
    if before is None and after is None:
        raise InputError("a transition leads from or to a gait; give at least one")
    given = [gait for gait in (before, after) if gait is not None]
    robots = [(gait.joint_names, gait.urdf, gait.fact("choices")) for gait in given]
    if robots[0] != robots[-1]:
        raise InputError(
            "the two gaits are of different robots, or of different choices about one; give gaits "
            "of one robot"
        )
    walks, states = list[_Walk](), list[Junction | None]()
    for gait in (before, after):
        state = None
        if gait is not None:
            problem, state = _walk(gait, known)
            walks.append((problem, gait))
        states.append(state)
    chosen = walks[-1][0]
    walked = next(state for state in reversed(states) if state is not None)
    begin, finish = (
        standing(chosen.robot, walked.geometry, stretch) if state is None else state
        for state in states
    )
    return (chosen, begin, finish), walks


def certify_transition(
    problem: TransitionProblem, x: Array, fine: WalkProblem | None = None
) -> Certificate:
    """Check a transition at x (P,), its beginning included; arguments as of `certify`."""
    found = certify(problem, x, fine)
    apart, rate = problem.begin_gap(x)
    size = max(1.0, float(np.abs(problem.transition.begin.rate).max()))
    verdict = replace(
        found.referee,
        posture=max(found.referee.posture, apart),
        rate=max(found.referee.rate, rate / size),
    )
    return replace(found, referee=verdict)


def transition_at(
    problem: TransitionProblem,
    x: Array,
    before: Gait | None,
    after: Gait | None,
    meta: dict[str, object],
) -> Transition:
    """Return the transition at x (P,), sampled at the task's quadrature nodes.

    Args:
        before, after: the gaits at its ends; None at rest.
        meta: what to record besides robot, task and cost.
    """
    robot, asked, whole = problem.robot, problem.transition, problem.whole(x)
    assert isinstance(whole, TransitionSteps)
    first, model = problem.steps(x)[0], problem.models[0]
    shift = None
    if isinstance(model, ShiftStepModel):
        shift = WeightShift(*model.splines(first), model.points(first))
    facts = {
        **robot_record(robot),
        "choices": choices_record(robot.choices),
        "limits": limits_record(problem),
        "task": task_record(asked.task),
    }
    each = zip(problem.models, problem.steps(x), strict=True)
    steps = tuple(step_gait(robot, model, step, facts) for model, step in each)
    rests = next((end for end in (asked.begin, asked.finish) if end.rests), None)
    return Transition(
        steps,
        before,
        after,
        np.zeros(0) if rests is None else rests.q,
        np.zeros(0) if rests is None else wrench_standing(robot),
        whole.x,
        problem.layout.names,
        {
            **facts,
            "durations": [
                model.swing_duration(step)
                for model, step in zip(problem.models, whole.steps, strict=True)
            ],
            "given": {"durations": list(asked.durations), "free": asked.free, "shift": asked.shift},
            "step_lengths": list(whole.lengths),
            "instants": problem.grid.instants[problem.grid.nodes :].tolist(),
            "cost": problem.cost.value(whole),
            **meta,
        },
        shift,
    )


def _walk(gait: Gait, known: Iterable[Extension] = ()) -> tuple[WalkProblem, Junction]:
    """Return the program of a gait and the state with which its steps begin."""
    if gait.second is not None or len(gait.phases) > 1:
        raise InputError(
            "transitions have steps on one flat foot; this gait has other phases, or two steps "
            "that differ: give one designed without --toe-off, --heel-strike, --double-support, "
            "--stride, --lateral-speed, --turn-rate and --cross-slope"
        )
    problem = problem_of(gait, known)
    if problem.task.ground != Level() or problem.task.terrain is not None:
        raise InputError("transitions are on level ground; give a gait without slope or stairs")
    if PEAK in problem.task.cost.reads:
        raise InputError(
            "a transition has a cost per second, and the largest torque of this gait is none; give "
            "one designed with --cost torque"
        )
    try:
        junction = junction_of(problem, gait.parameters)
    except EvaluationError as error:
        raise InputError(f"the gait's parameters do not make a walk: {error}") from error
    for stored, computed in ((gait.q[0], junction.q), (gait.dq[0], junction.rate)):
        if np.abs(stored - computed).max() > SAME * max(1.0, float(np.abs(computed).max())):
            raise InputError(
                "the gait is not the walk of its own parameters; gaitopt check says what follows "
                "from them"
            )
    return problem, junction


def _durations(
    given: Sequence[float] | float | None, begin: Junction, finish: Junction, steps: int
) -> tuple[float, ...]:
    if given is None:
        return step_durations(begin, finish, steps)
    values = plain(list(given)) if isinstance(given, Iterable) else [given] * steps
    fits = len(values) == steps and all(
        isinstance(one, int | float) and _SHORTEST <= one <= _LONGEST for one in values
    )
    if not fits:
        raise InputError(
            f"durations of {steps} steps are {shown(given)} s; give one for all or one for each, "
            f"from {_SHORTEST} to {_LONGEST} s"
        )
    return tuple(float(one) for one in values)


def _check_shift(shift: float, robot: Robot, begin: Junction) -> Array:
    """Return the wrench on the foot that swings first as a shift begins, (6,), or (0,) without."""
    if is_finite(shift) and shift == 0.0:
        return np.zeros(0)
    if not is_finite(shift) or not _SHORTEST <= shift <= _LONGEST:
        raise InputError(
            f"a shift of the weight lasts {shown(shift)} s; give {_SHORTEST} to {_LONGEST} s, or 0"
        )
    if not begin.rests:
        raise InputError("the weight is shifted before a first step from standing; leave it out")
    if not (robot.tree.determined and robot.coupling.none):
        raise InputError(
            "a shift of the weight is for two legs of six joints and no others; leave it out"
        )
    return wrench_standing(robot)


def _check_standing(robot: Robot, task: Task, still: Junction) -> None:
    """Refuse a posture to stand in beyond the joints' ranges or torques."""
    margins, limits, names = task.margins, robot.limits, robot.joint_names
    if margins.joint_range:
        beyond = np.maximum(limits.lower - still.q, still.q - limits.upper)
        if beyond.max() > 0.0:
            k = int(np.argmax(beyond))
            raise InputError(
                f"the robot cannot stand so: {names[k]} is at {fixed(still.q[k], 3)} rad, its "
                f"range is {fixed(limits.lower[k], 3)} to {fixed(limits.upper[k], 3)} rad; give "
                "another --stretch"
            )
    torque = standing_torque(robot, still.q)
    most = imposed_limit(limits.torque, margins.torque_limit)
    over = np.abs(torque) - most
    if over.max() > 0.0:
        k = int(np.argmax(over))
        raise InputError(
            f"the robot cannot stand so: {names[k]} needs {abs(torque[k]):.4g} N·m of "
            f"{most[k]:.4g}; give a --stretch nearer to 1"
        )


def standing_torque(robot: Robot, angles: Array) -> Array:
    """Return the joint torques of a robot at rest, both feet pressing alike [N·m], shape (n,)."""
    body, E = robot.multibody, robot.mirror
    phase = standing_phase(angles, wrench_standing(robot))
    torque = StepSequence(body, (phase,), E).at(0.0).torque[0]
    return np.asarray(torque[body.moving])


def _searched(problem: TransitionProblem, search: Search) -> Solution:
    """Solve from the first guess, first without habits and torsional friction, then with them.

    With all limits at once the way from a guess often ends where they contradict each other nearby
    (measured on G1). Where that fails too, other guesses near it are tried.
    """
    guess = transition_guess(problem)
    solver = search.options.solver.limited(_ITERATIONS)
    how = search.changed(solver=solver, approach="direct")
    margins = problem.task.margins
    loose = {name: None for name in LOOSENED if getattr(margins, name) is not None}
    tried: list[Solution] = []
    for number in range(_ATTEMPTS):
        x, spent = guess if number == 0 else perturbed(problem, guess, SIGMA, number), None
        if loose:
            easier = problem.with_task(problem.task.with_margins(loose))
            spent = attempt(easier, how, x)
            x = spent.x if is_walk(spent) else x
        if spent is None or spent.status is not Status.INTERRUPTED:
            solution = attempt(problem, how, x)
            if spent is not None:
                solution = with_work(solution, spent)
            if is_walk(solution):
                return solution
            tried.append(solution)
        if search.stop():
            raise StoppedError(spent if not tried else tried[-1])
    nearest = min(tried, key=lambda s: s.violation if np.isfinite(s.violation) else np.inf)
    raise NoGaitFoundError(_refusal(problem, nearest), nearest)


def _refusal(problem: TransitionProblem, solution: Solution) -> str:
    steps = len(problem.transition.durations)
    reason = f"no transition of {steps} steps was found ({solution.status.value})"
    searched = problem.transition.free
    advice = "give more --steps" + ("" if searched else ", or leave --duration out: it is searched")
    try:
        worst = worst_rows(problem, solution.x)[0]
    except EvaluationError as error:
        return f"{reason}; {error}; {advice}"
    return f"{reason}; the least violation leaves {worst.sentence}; {advice}"
