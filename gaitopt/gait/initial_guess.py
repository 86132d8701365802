"""Starting points: a first guess that walks badly but is a walk, and a walk for other lengths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.contact import Hinge
from gaitopt.dataclass import dataclass
from gaitopt.errors import UnreachableError
from gaitopt.gait import quantities
from gaitopt.gait.double_step import DoubleStepModel
from gaitopt.gait.double_support import (
    PELVIS_CHAIN,
    JointAngleSupport,
    place,
    swing_sole_chain,
)
from gaitopt.gait.foot_turn import FootTurn
from gaitopt.gait.parameters import (
    DURATION,
    FOOT_SPACING,
    FOOT_YAW,
    KNOT_SCALE,
    PELVIS_FORWARD,
    PELVIS_HEIGHT,
    PELVIS_LATERAL,
    RATE_SCALE,
    STEP_LENGTH,
    TRUNK_PITCH,
    GeometricParameter,
    Layout,
    set_geometry,
)
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.step_model import after_each
from gaitopt.gait.stride import StepsLayout
from gaitopt.gait.transition_problem import (
    TransitionLayout,
    TransitionProblem,
    TransitionTask,
)
from gaitopt.mechanics.inverse_kinematics import LegKinematics, loop_gap
from gaitopt.model.joint_tree import TWIST
from gaitopt.nlp import Array

_DIGITS = 12  # of instants, as `Grid.with_instants` rounds them
_CROUCH = 0.875  # hip height above the ankle over the leg's length; measured to start well
_LONGEST = 0.97  # of the leg's length, in double support
_STRAIGHT = 0.995  # likewise, beyond which the pelvis of the guess is lowered to that
_TRUNK_PITCH = 0.05  # rad
_CLEAR_OF_GAP = 0.014  # m of the thirteen-link biped: so far off the lateral constraint
_EXTRA_LIFT = 0.02  # m above the clearance profile, likewise
_FOOT_ANGLE = 0.15  # rad at the end, where the stance foot turns; from less a heel may never rise
_LANDING_ANGLE = 0.15  # rad, where the foot lands on its heel
_NEAR, _PLAIN = 1e-4, 1000.0  # m, rad: how exactly it is told what can be held; parts of one
_HAIR = 1e-12  # between bounds that are equal: least squares wants room
_BESIDE = 0.4  # of the pelvis' distance from the stance foot at rest, as the other foot leaves
_WIDER = 1.2  # steps of a transition than of a walk: it begins to fall sideways, or ceases to
_LOWERED, _LOWER = 10, 0.02  # times, and by how much of the leg's length, for a leg to reach
_RATE_FRACTION = 0.5  # of the last secant: the foot slows down before it lands
_PUSH = 0.05  # m/s, likewise: vertical impulse of an impact that both feet take, over the mass


def first_guess(problem: WalkProblem) -> Array:
    """Return a starting point x for a walk, shape (P,).

    Raises:
        UnreachableError: the step is too long for the legs.
        InputError: a constraint or a cost of one's own has no finite value there.
    """
    try:
        parts, _ = _guessed_steps(problem)
    except UnreachableError as error:
        raise UnreachableError(_held_told(problem, str(error))) from None
    whole = problem.layout
    x = with_peak(problem, whole.pack(parts) if isinstance(whole, StepsLayout) else parts[0])
    problem.check_own(x)
    return x


def _guessed_steps(
    problem: WalkProblem, **changes: dict[str, float | bool]
) -> tuple[list[Array], list[Array]]:
    """Return the parameters (p,) of every step, and the geometric quantities (10,) of each.

    Args:
        changes: of the table of these, by name.
    """
    layouts = [model.layout for model in problem.models]
    geometries = [
        _geometry(problem, step, set_geometry(layout.geometry, changes))
        for step, layout in enumerate(layouts)
    ]
    starts = [_start(problem, geometry) for geometry in geometries]
    guessed = _guessed_closing if problem.schedule.closing else _guessed_step
    parts = [
        guessed(problem, layout, start, geometry, after.q)
        for layout, start, geometry, after in zip(
            layouts, starts, geometries, after_each(starts), strict=True
        )
    ]
    return parts, geometries


def _held_told(problem: WalkProblem, told: str) -> str:
    """Return why the legs cannot reach, and up to where what is held may be, if that is why."""
    table = problem.models[0].layout.geometry
    held = [(row, one) for row, one in enumerate(table[:STEP_LENGTH]) if not one.free]
    for row, one in held:
        try:
            own = _guessed_steps(problem, **{one.name: {"free": True, "value": 0.0}})[1][0][row]
        except UnreachableError:
            continue
        inside, outside = float(own), one.value
        while abs(outside - inside) > _NEAR:
            between = 0.5 * (inside + outside)
            if _can_be_held(problem, one.name, between):
                inside = between
            else:
                outside = between
        end, towards = ("most", np.floor) if one.value > inside else ("least", np.ceil)
        plain = float(towards(inside * _PLAIN) / _PLAIN)
        inside = plain if _can_be_held(problem, one.name, plain) else inside
        return (
            f"{one.name} is held at {one.value:g} {one.unit}, out of reach of the legs: "
            f"{told.partition(';')[0]}; hold it at {inside:g} {one.unit} at {end}, better near "
            f"{own:.3g}, or let it be free"
        )
    if not held:
        return told
    names = ", ".join(one.name for _, one in held)
    return f"{told.partition(';')[0]}; held are {names}: let them be free, or shorten the step"


def _can_be_held(problem: WalkProblem, name: str, value: float) -> bool:
    try:
        _guessed_steps(problem, **{name: {"value": value}})
    except UnreachableError:
        return False
    return True


@dataclass(frozen=True)
class _Start:
    """A double support: placements of pelvis and rear foot, and joint angles q (n,)."""

    pelvis: pin.SE3
    rear: pin.SE3
    q: Array


def _start(problem: WalkProblem, geometry: Array) -> _Start:
    """Return the double support of geometric quantities."""
    pelvis, _ = place(PELVIS_CHAIN, geometry)
    rear, _ = place(swing_sole_chain(problem.task.ground.rise), geometry)
    turns = _turns(problem, geometry)
    rear, landed = rear * turns.place(1.0), turns.place(0.0).inverse()
    q = LegKinematics(problem.robot).solve(landed * pelvis, landed * rear)
    return _Start(pelvis, rear, q)


def _guessed_step(
    problem: WalkProblem, layout: Layout, start: _Start, geometry: Array, following: Array
) -> Array:
    """Return the parameters (p,) of a step that swings over to the posture (n,) that follows."""
    kinematics, turns = LegKinematics(problem.robot), _turns(problem, geometry)
    q_end = problem.model.exchange @ following
    pelvis_end, front = (turns.place(1.0) * at for at in kinematics.placements(q_end))
    count = layout.postures
    lift = _lift(problem)
    knots = []
    inner = problem.model.basis.knots[1:-1]
    for s in inner if turns.turns else np.arange(1, count + 1) / (count + 1):
        sole = pin.SE3.Interpolate(start.rear, front, float(s))
        sole.translation = sole.translation + np.array([0.0, 0.0, lift * np.sin(np.pi * s)])
        foot = turns.place(float(s)).inverse()
        at_pelvis = foot * pin.SE3.Interpolate(start.pelvis, pelvis_end, float(s))
        knots.append(kinematics.solve(at_pelvis, foot * sole))
    last = (
        geometry[DURATION] * (1.0 - inner[-1]) if turns.turns else geometry[DURATION] / (count + 1)
    )
    rate_before = _RATE_FRACTION * (q_end - knots[-1]) / last
    more = turns.parameters
    if layout.slapping:  # the rate at which the guess passes there
        shares = problem.model.basis.knots
        rates = np.gradient(np.array([start.q, *knots, q_end]), geometry[DURATION] * shares, axis=0)
        flat = int(np.argmin(np.abs(shares - problem.schedule.first.end)))
        more = np.concatenate([more, rates[flat]])
    return layout.pack(np.array(knots), rate_before, start.q, geometry, more)


def transition_guess(problem: TransitionProblem) -> Array:
    """Return a starting point x for a transition, shape (P,).

    Double supports lie evenly between those at its ends, and so do the lengths of the steps.

    Raises:
        UnreachableError: a double support between is out of reach.
    """
    asked, layout = problem.transition, problem.layout
    assert isinstance(layout, TransitionLayout)
    count = len(asked.durations)
    first, last = asked.begin.geometry, asked.finish.geometry
    shares = np.linspace(0.0, 1.0, count + 1)
    geometries = [(1.0 - share) * first + share * last for share in shares]
    for geometry in geometries[1:-1]:
        geometry[FOOT_SPACING] *= _WIDER
    starts = [_lowered_start(problem, geometry) for geometry in geometries]
    starts[0] = replace(starts[0], q=asked.begin.q)
    if asked.shift:  # the pelvis is then nearer to the foot that stands
        geometries[0][PELVIS_LATERAL] *= _BESIDE
        starts[0] = _lowered_start(problem, geometries[0])
    starts[-1] = replace(starts[-1], q=asked.finish.q)
    parts = []
    for k, (own, duration) in enumerate(zip(layout.steps, asked.lasts, strict=True)):
        geometry = geometries[k].copy()
        geometry[DURATION] = duration
        parts.append(_guessed_step(problem, own, starts[k], geometry, starts[k + 1].q))
    return layout.pack(parts, _guessed_shift(asked, starts[0].q) if asked.shift else None)


def _guessed_shift(asked: TransitionTask, q: Array) -> Array:
    """Return the parameters of a shift that moves evenly to a posture (n,), as the load does."""
    leg, share = slice(TWIST), 2.0 / 3.0
    posture = asked.begin.q[leg] + (3.0 - 2.0 * share) * share**2 * (q - asked.begin.q)[leg]
    return np.concatenate([posture, share * asked.front, (1.0 - share) * asked.front])


def _lowered_start(problem: WalkProblem, geometry: Array) -> _Start:
    """Return the double support of geometric quantities, whose pelvis is lowered into reach."""
    for _ in range(_LOWERED):
        try:
            return _start(problem, geometry)
        except UnreachableError:
            geometry[PELVIS_HEIGHT] -= _LOWER * problem.robot.legs.reach
    return _start(problem, geometry)


def with_peak(problem: WalkProblem, x: Array) -> Array:
    """Return x (P,) with its largest torque, if that is in it, as large as its torques are."""
    if problem.model.layout.peak:
        x = x.copy()
        x[problem.layout.largest] = np.abs(problem.whole(x).read(quantities.TORQUE)).max()
    return x


def _guessed_closing(
    problem: WalkProblem, layout: Layout, start: _Start, geometry: Array, following: Array
) -> Array:
    """Return the parameters of a step (p,) at whose end both feet stand; as `_guessed_step`.

    The pelvis moves evenly all the time, and the load passes from the rear foot to the front one.
    """
    model, kinematics = problem.model, LegKinematics(problem.robot)
    assert isinstance(model, DoubleStepModel)
    turns, pelvis, rear = _turns(problem, geometry), start.pelvis, start.rear
    q_end = model.exchange @ following
    pelvis_end, front = (turns.place(1.0) * at for at in kinematics.placements(q_end))
    lift = _lift(problem)

    def posture(s: float) -> Array:
        share = min(s / model.touch, 1.0)
        sole = pin.SE3.Interpolate(rear, front, share)
        sole.translation = sole.translation + np.array([0.0, 0.0, lift * np.sin(np.pi * share)])
        foot = turns.place(s).inverse()
        return kinematics.solve(foot * pin.SE3.Interpolate(pelvis, pelvis_end, s), foot * sole)

    *early, touch, middle = (posture(float(s)) for s in model.basis.knots[1:-1])
    # the secant as rate at lift-off: nothing bends at touch-down, and midway what is left
    span = float(geometry[DURATION]) * (1.0 - model.touch)
    rate = (q_end - touch) / span
    bend = 8.0 * (middle - q_end + 0.5 * span * rate) / span**2
    weight = problem.robot.weight
    wrench = np.zeros((4, TWIST))
    wrench[:, 2] = weight * np.array([0.1, 0.3, 0.7, 0.9])
    wrench[:, 4] = -wrench[:, 2] * 0.5 * (problem.robot.sole.toe + problem.robot.sole.heel)
    own = model.free
    bends, push = [np.zeros(own.size), bend[own]], np.zeros(TWIST * model.striking)
    if model.striking:
        bends.append(np.zeros(own.size))
        push[2] = _PUSH * problem.robot.scales.speed * problem.robot.mass
        push[4] = -push[2] * 0.5 * (problem.robot.sole.toe + problem.robot.sole.heel)
    more = np.concatenate([turns.parameters, *bends, wrench.ravel(), push])
    return layout.pack(np.array(early), rate[own], start.q, geometry, more)


_HIGHEST_CLEARANCE = 0.5  # over the length of the legs: more is for the diagnosis to answer


def _lift(problem: WalkProblem) -> float:
    """Return how high the foot is lifted [m]."""
    most = _HIGHEST_CLEARANCE * problem.robot.legs.reach
    clearance = min(problem.task.margins.clearance, most)
    return clearance + _EXTRA_LIFT * problem.robot.scales.length + problem.task.ground.lift


@dataclass(frozen=True)
class _Turns:
    """The turns of the stance foot in the guess.

    Attributes:
        turns: line, angle as a function of time and what shapes it, of each of them.
        duration: of the step [s].
    """

    turns: tuple[tuple[Hinge, FootTurn, Array], ...]
    duration: float

    @property
    def parameters(self) -> Array:
        """Parameters of the turns, before the foot leaves, then after it landed."""
        leaving = [shape for _, turn, shape in self.turns if not turn.landed]
        landed = [shape[:-1] for _, turn, shape in self.turns if turn.landed]
        return np.concatenate([np.zeros(0), *leaving, *landed])

    def place(self, s: float) -> pin.SE3:
        """Return the placement of the stance sole in its footprint at s = t / T."""
        place = pin.SE3.Identity()
        for hinge, turn, shape in self.turns:
            at = replace(turn, instants=np.array([s]))
            angle = at.basis.at(self.duration)[0, 0] @ at.coefficients @ shape
            place = place * pin.exp6(float(angle) * hinge.twist)
        return place


def _turns(problem: WalkProblem, geometry: Array) -> _Turns:
    model, duration = problem.model, float(geometry[DURATION])
    asked = ((model.line, model.landing_turn), (model.hinge, model.foot_turn))
    angles = (_LANDING_ANGLE, _FOOT_ANGLE)
    turns = tuple(
        (hinge, turn, turn.guess(angle, duration))
        for (hinge, turn), angle in zip(asked, angles, strict=True)
        if hinge is not None and turn is not None
    )
    return _Turns(turns, duration)


def flat_feet_gap(problem: WalkProblem) -> float:
    """Return how far at least the feet are from lying flat at the asked step [m, rad].

    The largest entry of both loops' gaps in the posture nearest to a double support, by least
    squares over the joint angles within their ranges and the free geometric quantities. Legs of
    six motors and more can take any posture within reach: 0.
    """
    robot, layout = problem.robot, problem.layout
    if robot.tree.stance >= TWIST and robot.coupling.none:
        return 0.0
    from scipy.optimize import least_squares  # which takes longer to import than most answers need

    support = JointAngleSupport(robot, rise=problem.task.ground.rise)
    geometry, count = _geometry(problem, 0), len(robot.joint_names)
    fixed_step = not layout.geometry[DURATION].free and problem.task.speed_as == "constraint"
    rows = [row for row in layout.free if not (row == STEP_LENGTH and fixed_step)]
    table = [layout.geometry[row] for row in rows]
    kept = problem.task.margins.joint_range
    lower, upper = (
        np.r_[limit if kept else np.full(count, end), [getattr(q, side) for q in table]]
        for limit, end, side in (
            (robot.limits.lower, -np.inf, "lower"),
            (robot.limits.upper, np.inf, "upper"),
        )
    )

    def gaps(y: Array) -> Array:
        at = geometry.copy()
        at[rows] = y[count:]
        return np.concatenate([loop_gap(loop) for loop in support.posture(at, y[:count]).loops])

    kinematics = LegKinematics(robot)
    sole = place(swing_sole_chain(problem.task.ground.rise), geometry)[0]
    q = kinematics.solve(place(PELVIS_CHAIN, geometry)[0], sole)
    start = np.clip(np.r_[q, geometry[rows]], lower, upper)
    found = least_squares(gaps, start, bounds=(lower, upper + _HAIR), x_scale="jac")
    return float(np.abs(found.fun).max())


def perturbed(problem: WalkProblem, x: Array, sigma: float, seed: int) -> Array:
    """Return x (P,) with normal noise of standard deviation sigma on every joint parameter.

    Args:
        sigma: standard deviation [rad], and [rad/s] for the rates of the thirteen-link biped, those
            of other robots in proportion.
    """
    noisy = np.array(x)
    joints = problem.layout.of_joints
    noise = np.random.default_rng(seed).normal(0.0, sigma, len(joints))
    sizes = problem.variables.scale[joints]
    noisy[joints] += noise * np.where(sizes == KNOT_SCALE, 1.0, sizes / RATE_SCALE)
    return noisy


def _geometry(
    problem: WalkProblem, number: int, table: tuple[GeometricParameter, ...] | None = None
) -> Array:
    """Geometric quantities of the guess at the start of a step: fixed ones keep their value.

    Args:
        table: of the quantities, by default that of the step.
    """
    robot, task = problem.robot, problem.task
    table = problem.models[number].layout.geometry if table is None else table
    legs, ground = robot.legs, task.ground
    guess = np.array([quantity.value for quantity in table])
    step = guess[STEP_LENGTH]
    narrowest = robot.sole.width + task.margins.lateral_gap
    clear = narrowest + _CLEAR_OF_GAP * robot.scales.length
    spacing = legs.side * max(abs(legs.stance_width), clear)
    aside = (2 * number - 1) * task.lateral_speed * task.duration  # half of what a step widens
    spacing += (aside + legs.side * abs(aside)) if task.steps > 1 else 0.0
    spacing = _given(table[FOOT_SPACING], spacing)
    share = 0.0 if task.double_support is None else task.double_support / task.duration
    if (1.0 + share) * abs(step) / 2.0 >= _LONGEST * legs.reach:
        raise UnreachableError(
            f"a step of {fixed(abs(step), 3)} m ({task.speed:g} m/s for {task.duration:g} s) is "
            "longer than the legs can span: at most "
            f"{2.0 * _LONGEST * legs.reach / (1.0 + share):.3f} m; ask for a lower speed or a "
            "shorter step duration"
        )
    # On a slope the hips stand over the middle, further from one of the feet.
    half, sine, longest = (
        (1.0 + share) * step / 2.0,
        abs(np.sin(ground.incline)),
        _LONGEST * legs.reach,
    )
    root = np.sqrt((half * sine) ** 2 + (1.0 + sine**2) * (longest**2 - half**2))
    height = min(_CROUCH * legs.reach, (root - half * sine) / (1.0 + sine**2))
    height -= max(ground.rise, 0.0)  # the rear leg reaches down
    ankle, middle = legs.ankles.mean(axis=0), legs.hips.mean(axis=0)
    heading = 0.5 * guess[FOOT_YAW] if task.steps > 1 else 0.0
    ahead = np.array([np.cos(heading), np.sin(heading)])
    half_way = 0.5 * (spacing * np.array([-ahead[1], ahead[0]]) - step * ahead)
    if task.turn_rate != 0.0:  # the pelvis points between the feet
        half_way += (ankle[0] - middle[0]) * (ahead - [1.0, 0.0])
    values = {
        PELVIS_HEIGHT: ankle[2] + height - middle[2],
        PELVIS_LATERAL: half_way[1] + (1 - 2 * number) * height * np.sin(ground.across_angle),
        PELVIS_FORWARD: ankle[0]
        + half_way[0]
        + share * step / 2.0
        - middle[0]
        + height * np.sin(ground.incline),
        TRUNK_PITCH: _TRUNK_PITCH + ground.incline,
        FOOT_SPACING: spacing,
    }
    for row, quantity in enumerate(table):
        if quantity.free:
            guess[row] = _given(quantity, values.get(row, guess[row]))
    return _lowered(problem, table, guess)


def _given(quantity: GeometricParameter, value: float) -> float:
    """Return the value of a quantity in the guess: its own if it has one, else one within bounds.

    One that is free has one if its value is not 0, with which it stands in `GEOMETRY`.
    """
    if not quantity.free:
        return quantity.value
    return float(np.clip(quantity.value or value, quantity.lower, quantity.upper))


def _lowered(problem: WalkProblem, table: tuple[GeometricParameter, ...], geometry: Array) -> Array:
    """Return geometric quantities (10,) with the pelvis, while it is free, in reach of the legs.

    Raises:
        UnreachableError: the feet are too far apart for any height.
    """
    quantity = table[PELVIS_HEIGHT]
    legs, longest = problem.robot.legs, _LONGEST * problem.robot.legs.reach
    pelvis, sole = (
        place(chain, geometry)[0]
        for chain in (PELVIS_CHAIN, swing_sole_chain(problem.task.ground.rise))
    )
    vectors = problem.model.boundary.kinematics.legs(pelvis, sole)[0]
    if not quantity.free or np.linalg.norm(vectors, axis=1).max() <= _STRAIGHT * legs.reach:
        return geometry
    away = np.linalg.norm(vectors[:, :2], axis=1)
    if away.max() >= longest:
        raise UnreachableError(
            f"a foot is {fixed(away.max(), 3)} m aside of its hip, where the legs reach "
            f"{longest:.3f} m; give a smaller lateral_gap, a lower speed or a shorter step"
        )
    lower = (vectors[:, 2] - np.sqrt(longest**2 - away**2)).max()
    geometry[PELVIS_HEIGHT] = np.clip(
        geometry[PELVIS_HEIGHT] - lower, quantity.lower, quantity.upper
    )
    return geometry


def resized(x: Array, old: WalkProblem, new: WalkProblem) -> Array:
    """Return x (P,) with the pelvis at the height where no leg is straighter than for `old`.

    Joint angles fit legs of any length; a height that is kept bends them otherwise, or is out of
    their reach.
    """
    lifted = x.copy()
    for number, model in enumerate(new.models):
        at = model.layout.index("pelvis_height")
        if at is None:
            return x
        before, after = _legs(old, number, x), _legs(new, number, x)
        share = np.linalg.norm(before, axis=1) / old.robot.legs.reach
        reach = share * new.robot.legs.reach
        room = reach**2 - (after[:, :2] ** 2).sum(axis=1)
        if not (room > 0.0).all():
            return x
        lifted += model.chart.matrix[at] * float((np.sqrt(room) - after[:, 2]).min())
    return lifted


def retimed(x: Array, old: WalkProblem, new: WalkProblem) -> Array:
    """Return x (P,) with postures at inner knots as the motion of `old` has them at those of `new`.

    Knots share the phases of a step, so that at other times of phases the same postures are
    another motion.

    Raises:
        EvaluationError: the walk is not defined at x.
    """
    found, count = x.copy(), len(new.models)
    shares = [np.round(model.knots[1:-1], _DIGITS) for model in new.models]
    instants = np.concatenate([(number + one) / count for number, one in enumerate(shares)])
    missing = np.setdiff1d(np.round(instants, _DIGITS), np.round(old.grid.instants, _DIGITS))
    fine = old.with_grid(old.grid.with_instants(missing))
    each = zip(new.models, fine.models, fine.steps(x), shares, strict=True)
    for model, dense, step, at in each:
        rows = np.abs(dense.grid.instants[:, None] - at).argmin(axis=0)
        here = model.chart.matrix[model.layout.knots].argmax(axis=1)
        found[here] = step.motion[0, rows].ravel()
    return found


def _legs(problem: WalkProblem, number: int, x: Array) -> Array:
    """Return the vectors from ankles to hips in the double support of a step, shape (2, 3)."""
    model, boundary = problem.models[number], problem.model.boundary
    (pelvis, _), (sole, _) = boundary.place(model.layout.geometry_of(model.chart.of(x)))
    return boundary.kinematics.legs(pelvis, sole)[0]
