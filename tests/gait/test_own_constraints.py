"""Constraints and costs of one's own: in the program, in records, from plugins."""

import json
import pickle
import subprocess
import sys
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from numerics import check_differences, jacobian_difference, steps
from places import SWING_HEIGHT
from walks import walk

from gaitopt.actuators.motors import JointMotor
from gaitopt.errors import InputError
from gaitopt.gait import costs, quantities
from gaitopt.gait.constraint import Constraint, margin
from gaitopt.gait.constraints import MotorEnvelope
from gaitopt.gait.costs import (
    Cost,
    CostFunction,
    RunningCost,
    TorqueCost,
    WeightedSum,
)
from gaitopt.gait.functions import (
    ComplexStep,
    Entries,
    FrictionCone,
    Linear,
    QuantityFunction,
    SquaredNorm,
    Torsion,
)
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.plugin import (
    constraint_from_record,
    cost_from_record,
    load_plugin,
    terrain_from_record,
)
from gaitopt.gait.presets import preset_task
from gaitopt.gait.problem import WalkProblem
from gaitopt.gait.task import Task, task_from_record, task_record
from gaitopt.gait.terrain import Stairs


@dataclass(frozen=True)
class MotorPower(Constraint):
    """Mechanical power of every motor below a limit: curved in torques and rates together."""

    name, unit, words = "motor power", "W", "power of the motors"
    reads = (quantities.TORQUE, quantities.RATES)
    most_power: float = margin(300.0, "Largest power of a motor.", unit="W", above=0.0)

    def block(self, context):
        joints = context.robot.joint_names
        power = ComplexStep(lambda v: v[:, : len(joints)] * v[:, len(joints) :])
        labels = tuple(f"{joint} power" for joint in joints)
        return self.over_step(context, power, labels, upper=self.most_power, scale=100.0)


@dataclass(frozen=True)
class Smoothness(RunningCost):
    """Squares of the products of torques, rates and angles: mixes three quantities."""

    name, unit, words = "smoothness", "1", "a cost of the tests"
    reads = (quantities.TORQUE, quantities.RATES, quantities.ANGLES)

    def integrand(self, robot):
        n = len(robot.joint_names)
        return ComplexStep(
            lambda v: ((v[:, :n] * v[:, n : 2 * n] + v[:, 2 * n :]) ** 2).sum(axis=1, keepdims=True)
        )


def changed(name: str, **changes):
    """A walk of the tests with another task; its point."""
    known = walk(name)
    return WalkProblem(known.problem.robot, replace(known.problem.task, **changes)), known.x


KNEE = JointMotor("*knee*", 40.0, 15.0, 160.0, 20.0, 0.03, 0.9, 0.5)
OWN = (
    {"constraints": (MotorPower(),)},
    {"constraints": (MotorEnvelope(motors=(KNEE,)),)},
    {"cost": Smoothness()},
    {"cost": TorqueCost({"*_knee": 3.0, "right_hip_*": 0.5})},
    {"cost": WeightedSum(((TorqueCost(), 0.3), (Smoothness(), 2.0)))},
)


@pytest.mark.parametrize("name", ["guess", "everything free"])
@pytest.mark.parametrize("changes", OWN)
def test_derivatives_are_exact(changes, name, rng):
    problem, x = changed(name, **changes)
    scale, last = problem.variables.scale, problem.blocks[-1].name
    rows = problem.rows_of(last)
    weights = np.zeros(problem.rows.lower.size)
    weights[rows] = rng.normal(size=rows.stop - rows.start)

    def sums(at):
        there = problem.values(at)
        return np.array([there.cost, weights @ there.rows])

    def gradients(at):
        there = problem.point(at)
        return there.gradient * problem.cost_scale + weights @ there.jacobian

    point = problem.point(x)
    exact = np.vstack([point.gradient, weights @ point.jacobian]) * scale
    check_differences(exact, [jacobian_difference(sums, x, scale, h) for h in steps(1e-5)])
    H = problem.hessian(x, weights, problem.cost_scale)
    found = [jacobian_difference(gradients, x, scale, h) for h in steps(1e-4)]
    check_differences(scale * H, found)


def test_a_pair_of_joints_counts_with_the_mean_of_its_weights(robot):
    one, other = TorqueCost({"right_knee": 3.0}), TorqueCost({"*_knee": 2.0})
    costs = [changed("guess", cost=cost)[0].values(walk("guess").x).cost for cost in (one, other)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-14)
    assert costs[0] > walk("guess").problem.values(walk("guess").x).cost


@pytest.mark.parametrize(
    ("weights", "message"),
    [
        ({"wheel": 1.0}, "weighs 'wheel', but no joint is called so; there are right_ankle"),
        ({"*": 0.0}, "weighs every joint with zero; give one a weight above 0"),
        ({"*_knee": -1.0}, r"weight of '\*_knee' in the cost is -1.0; .* zero or more"),
        (5.0, "weights of joints are 5.0; give a table by name"),
    ],
)
def test_weights_that_cannot_be_are_refused(robot, weights, message):
    with pytest.raises(InputError, match=message):
        WalkProblem(robot, preset_task(cost=TorqueCost(weights)))


@dataclass(frozen=True)
class Wrong(Constraint):
    """A constraint of any shape."""

    name, unit, words = "wrong", "N", "what is wrong"
    reads = (quantities.WRENCH,)
    width: int = 6
    labels: int = 1
    scale: float = 1.0
    lower: float = 0.0

    def block(self, context):
        if self.labels == "exit":
            sys.exit(3)
        rows = Linear(np.ones((1, self.width)))
        labels = tuple(f"row {k}" for k in range(self.labels))
        return self.over_step(context, rows, labels, lower=self.lower, scale=self.scale)


class Twice(Wrong):
    """Reads quantities that do not go together."""

    reads = (quantities.WRENCH, quantities.IMPULSE)


@pytest.mark.parametrize(
    ("constraint", "message"),
    [
        (Wrong(width=5), "matrix of 5 columns, but what it reads has 6; give 6 .*'wrong'"),
        (Wrong(labels=2), r"function of .* returns shape \(2, 1\) for 2 .*; return \(2, 2\)"),
        (Wrong(labels=-1, width="six"), "constraint 'wrong' cannot make its rows: TypeError"),
        (Wrong(scale=0.0), "scale of the constraint 'wrong' is .*; it must be above 0"),
        (Wrong(labels="exit"), "constraint 'wrong' cannot make its rows: SystemExit: 3"),
        (Wrong(lower=-np.inf), "no row of the constraint 'wrong' has a limit, .*; give lower="),
        (Twice(), "give quantities of the same instants, one at least"),
    ],
)
def test_rows_that_do_not_fit_are_refused(robot, constraint, message):
    with pytest.raises(InputError, match=message):
        WalkProblem(robot, preset_task(constraints=(constraint,)))


@dataclass(frozen=True)
class Reading(Constraint):
    """The first entry of a quantity, in one of the two ways in which rows are made."""

    name, unit, words = "reading", "1", "what is read"
    way: str = "over_step"

    def block(self, context):
        (one,) = self.reads
        first = Linear(np.eye(1, len(one.labels(context.robot))))
        make = self.once if self.way == "once" else partial(self.over_step, context)
        return make(first, ("first",), lower=-1e9)


class Squared(RunningCost):
    """The square of a quantity."""

    name, unit, words = "squared", "1", "the square of what is read"

    def integrand(self, robot):
        return SquaredNorm(np.ones(sum(len(one.labels(robot)) for one in self.reads)))


def reading(one):
    return type("One", (Reading,), {"reads": (one,)}), type("Two", (Squared,), {"reads": (one,)})()


@pytest.mark.parametrize("one", quantities.ALL, ids=lambda one: one.name)
def test_a_quantity_is_read_as_a_step_has_it_or_refused(robot, one):
    rows, cost = reading(one)
    wrong, right = ("over_step", "once") if one.rows else ("once", "over_step")
    if one is not quantities.ARM_GAPS:
        with pytest.raises(InputError, match=f"which a step has .*; make its rows by self.{right}"):
            WalkProblem(robot, preset_task(constraints=(rows(way=wrong),)))
    absent = ("foot_turn", "arm_gaps", "front_wrench", "rear_impulse", "gaps", "advance")
    missing = pytest.raises(InputError, match=r"this walk does not have|no entries for this")
    with missing if one.name in (*absent, "peak") else nullcontext():  # a cost brings the peak
        problem = WalkProblem(robot, preset_task(constraints=(rows(way=right),)))
        expected = len(one.rows) or problem.grid.count
        assert (
            problem.values(first_guess(problem)).rows[problem.rows_of("reading")].size == expected
        )
    refused = pytest.raises(InputError, match=r"a step has once; .* subclass Cost in place of")
    with refused if one.rows else missing if one.name in absent else nullcontext():
        problem = WalkProblem(robot, preset_task(cost=cost))
        assert problem.values(first_guess(problem)).cost > 0.0


@dataclass(frozen=True)
class AtSome(Constraint):
    """The knee's rate, at instants that a function of the context chooses."""

    name, unit, words = "at some", "rad/s", "what holds at some instants"
    reads = (quantities.RATES,)
    chosen: str = "landing"

    def block(self, context):
        s = context.grid.instants
        instants = {
            "landing": np.flatnonzero(s == context.touch_down),
            "late": np.flatnonzero(s > 0.8),
            "last": np.array([s.size - 1]),
            "nearest": np.array([np.argmin(np.abs(s - 0.352))]),
        }[self.chosen]
        row = Linear(np.eye(1, len(context.robot.joint_names), 2))
        return self.over_step(context, row, ("knee",), upper=5.0, instants=instants)


WALKS = ({}, {"toe_off": 0.7}, {"double_support": 0.05}, {"stride": True})


@pytest.mark.parametrize("task", WALKS, ids=str)
@pytest.mark.parametrize("chosen", ["landing", "late"])
def test_rows_at_instants_chosen_by_their_times_are_taken(robot, chosen, task):
    """Whatever instants a refinement adds behind the others, landings stay landings."""
    problem = WalkProblem(robot, preset_task(constraints=(AtSome(chosen),), **task))
    finer = problem.with_grid(problem.grid.with_instants(np.array([0.111, 0.313])))
    for one in (problem, finer):
        times = one.blocks[-1].times
        assert times.size > 0
        if chosen == "landing":
            ends = {0.5, 1.0} if "stride" in task else {touch_down(one.task)}
            assert set(times) == ends


def touch_down(task):
    """Share of the step at which the swing foot lands."""
    return 1.0 - (task.double_support or 0.0) / task.duration


@pytest.mark.parametrize("task", WALKS, ids=str)
@pytest.mark.parametrize("chosen", ["last", "nearest"])
def test_rows_that_would_wander_with_the_grid_are_refused(robot, chosen, task):
    message = "'at some' has a row at s = .* Choose them by their times, as np.flatnonzero"
    with pytest.raises(InputError, match=message):
        WalkProblem(robot, preset_task(constraints=(AtSome(chosen),), **task))


class OfOneGrid(AtSome):
    """A constraint that counts on the instants that the task begins with."""

    def over_step(self, context, function, labels, **more):
        instants = np.arange(0, context.grid.count, 2)
        more = {**more, "instants": instants, "lower": np.zeros((16, 1))}
        return super().over_step(context, function, labels, **more)


def test_rows_of_one_grid_alone_are_refused(robot):
    with pytest.raises(InputError, match="'at some' cannot make its rows: ValueError"):
        WalkProblem(robot, preset_task(constraints=(OfOneGrid("late"),)))


@dataclass(frozen=True)
class Shapeless(RunningCost):
    """A cost whose integrand has two rows."""

    name, unit, words = "shapeless", "1", "a cost of the tests"
    reads = (quantities.RATES,)
    rows: int = 2
    factor: float = 1.0

    def integrand(self, robot):
        return Linear(self.factor * np.ones((self.rows, len(robot.joint_names))))


def test_costs_that_do_not_fit_are_refused(robot):
    with pytest.raises(InputError, match=r"'shapeless' returns shape \(2, 2\) .* return \(2, 1\)"):
        WalkProblem(robot, preset_task(cost=Shapeless()))
    both = WeightedSum(((TorqueCost(), 1.0), (Shapeless(1, -1.0), 1.0)))
    with pytest.raises(InputError, match=r"'shapeless' is -12.0 1 at typical .* above 0"):
        WalkProblem(robot, preset_task(cost=both))
    with pytest.raises(InputError, match="'shapeless' cannot make its integrand: TypeError"):
        WalkProblem(robot, preset_task(cost=Shapeless("two")))


class HalfSquares(CostFunction):
    """0.5 sum of w v², v the joint rates, one of whose answers is changed."""

    def __init__(self, cost, weights):
        self.cost, self.weights = cost, weights

    def changed(self, name, answer):
        """Return an answer, another one if it is asked for."""
        return self.cost.change(answer) if self.cost.of == name else answer

    def value(self, step):
        """Return the cost."""
        v = step.values[quantities.RATES]
        if self.cost.of == "what it reads":
            v.fill(0.0)
        return self.changed("value", float(0.5 * self.weights @ (v * v).sum(axis=1)))

    def gradient(self, step):
        """Return w v."""
        first = self.weights[:, None] * step.values[quantities.RATES]
        return self.changed("gradient", {quantities.RATES: first})

    def hessian(self, step):
        """Return w."""
        width = step.values[quantities.RATES].shape[1]
        pair = (quantities.RATES, quantities.RATES)
        return self.changed("hessian", {pair: self.weights[:, None, None] * np.eye(width)})

    def neighbours(self, step):
        """Return none."""
        return self.changed("neighbours", {})


@dataclass(frozen=True)
class Half(Cost):
    """A cost that is no integral."""

    name, unit, words = "half", "1", "a cost of the tests"
    reads = (quantities.RATES,)
    of: str = ""
    change: object = None

    def function(self, context):
        """Return it for a walk."""
        found = HalfSquares(self, context.weights)
        return self.change(found) if self.of == "function" else found

    def typical(self, context):
        """Return its size."""
        return self.change(1.0) if self.of == "typical" else 1.0

    @property
    def constraints(self):
        """Return none."""
        return self.change(()) if self.of == "constraints" else ()


def entries(change):
    """Return a change of every entry of a dictionary."""
    return lambda found: {key: change(entry) for key, entry in found.items()}


def test_a_sound_cost_that_is_no_integral_is_taken(robot):
    both = WeightedSum(((TorqueCost(), 1.0), (Half(), 20.0)))
    for cost in (Half(), both, Half("typical", np.float32)):
        problem = WalkProblem(robot, preset_task(cost=cost, samples=9))
        first_guess(problem)
        assert type(problem.cost_scale) is float  # gait files keep it


def test_weights_and_matrices_may_be_lists():
    v, row = np.array([[1.0, 2.0]]), [3.0, 4.0]
    assert SquaredNorm(row).value(v) == 3.0 + 4.0 * 4.0
    assert SquaredNorm(row).jacobian(v).tolist() == [[[6.0, 16.0]]]
    assert Linear([row]).value(v) == 3.0 + 8.0
    for wrong in ([[1.0], row], ["a"]):
        with pytest.raises(InputError, match=r"matrix of a Linear is .*; give an array of real"):
            Linear(wrong)


@pytest.mark.parametrize(
    ("of", "change", "message"),
    [
        ("function", lambda _: None, "'half' has None for its function; return a CostFunction"),
        ("function", lambda _: 1 / 0, "'half' cannot make its function: ZeroDivisionError: .*line"),
        ("typical", lambda _: "1", "'half' is '1' 1 at typical .* above 0 there"),
        ("typical", lambda _: 1e-300, "'half' is 1e-300 1 at typical"),
        ("typical", next, "'half' has no typical value: TypeError"),
        ("value", str, "the value of the cost 'half' is '.*'; return a number"),
        ("value", lambda v: v + 0j, "the value of the cost 'half' is .*; return a number"),
        ("value", lambda _: 10**400, "the value of the cost 'half': OverflowError"),
        ("value", lambda _: float("nan"), "'half' has no finite value at the first guess"),
        ("gradient", lambda _: None, "the gradient of the cost 'half' is None; return a dict"),
        ("gradient", list, "the gradient of the cost 'half' is .*; return a dictionary"),
        ("gradient", lambda found: {"rates": found}, "an entry 'rates'; those of what it reads"),
        ("gradient", lambda g: {quantities.TORQUE: g}, r"entry <.*torque .*are <.*rates .*travel"),
        ("gradient", entries(np.transpose), r"rates .* has shape \(12, 9\); return \(9, 12\)"),
        ("gradient", entries(lambda g: g + 0j), "give an array of real numbers"),
        ("gradient", entries(lambda g: 1.1 * g), "the gradient of the cost 'half' disagrees with"),
        ("gradient", lambda _: {}, "the gradient .* disagrees with differences of its value; cor"),
        ("hessian", lambda _: None, "the hessian of the cost 'half' is None; return a dictionary"),
        ("hessian", entries(lambda h: h[1:]), r"has shape \(8, 12, 12\); return \(9, 12, 12\)"),
        ("hessian", lambda h: dict.fromkeys([quantities.RATES], h), "an entry <.*rates.*>; those"),
        ("hessian", entries(lambda h: 0 * h), "the hessian .* disagrees with .* its gradient; cor"),
        ("neighbours", lambda _: None, "the neighbours of the cost 'half': AttributeError"),
        ("neighbours", lambda _: {quantities.RATES: ([[0, 9]], 1.0)}, "IndexError: index 9"),
        ("neighbours", lambda _: {quantities.RATES: ([[0, 1]], "1")}, "give an array of real"),
        ("constraints", lambda _: 7, "constraints of the cost 'half' are 7; give a tuple of inst"),
        ("constraints", next, "the cost 'half' cannot make its constraints: TypeError"),
        ("what it reads", None, "the value of the cost 'half': ValueError: .* read-only .line"),
    ],
)  # fmt: skip
def test_a_cost_function_that_is_none_is_told(robot, of, change, message):
    with pytest.raises(InputError, match=message):
        first_guess(WalkProblem(robot, preset_task(cost=Half(of, change), samples=9)))


@dataclass(frozen=True)
class Residuals(Cost):
    """J = sum of w r² over d, r = torque * rate + angle: least squares over the way."""

    name, unit, words = "residuals", "1", "a cost of the tests"
    reads = (quantities.TORQUE, quantities.RATES, quantities.ANGLES)
    hessian: str = "none"

    def function(self, context):
        """Return it for a walk."""
        kinds = {"none": Squares, "Gauss-Newton": GaussNewton}
        return kinds[self.hessian](context.weights)

    def typical(self, context):
        """Return its size."""
        return 1000.0


class Squares(CostFunction):
    """Its value and gradient alone."""

    def __init__(self, weights):
        self.weights = weights[:, None]

    def parts(self, step):
        """Return torque, rate, residual."""
        torque, rate, angle = (step.read(one) for one in Residuals.reads)
        return torque, rate, torque * rate + angle

    def value(self, step):
        """Return the cost."""
        return float((self.weights * self.parts(step)[2] ** 2).sum() / step.step_length)

    def gradient(self, step):
        """Return its derivatives in all that it reads, and in the way."""
        torque, rate, rest = self.parts(step)
        first = 2.0 * self.weights * rest / step.step_length
        by = dict(zip(Residuals.reads, (first * rate, first * torque, first), strict=True))
        return by | {quantities.TRAVEL: [[-self.value(step) / step.step_length, 0.0]]}


class GaussNewton(Squares):
    """The Hessian without the curvature of the residuals."""

    def hessian(self, step):
        """Return 2 w J' J."""
        torque, rate, _ = self.parts(step)
        slopes = dict(zip(Residuals.reads, (rate, torque, np.ones(rate.shape)), strict=True))
        scale = (2.0 * self.weights / step.step_length)[:, :, None] * np.eye(torque.shape[1])
        reads = Residuals.reads
        return {
            (a, b): scale * (slopes[a] * slopes[b])[:, :, None]
            for k, a in enumerate(reads)
            for b in reads[k:]
        }


def test_a_hessian_that_is_left_out_is_taken_from_differences(rng):
    """Of a cost and of a function; the walk's own check compares that with differences in x."""
    problem, x = changed("everything free", cost=Residuals())
    problem.check_own(x)
    scale, none = problem.variables.scale, np.zeros(problem.rows.lower.size)
    H = problem.hessian(x, none, 1.0)
    differences = [
        jacobian_difference(lambda at: problem.point(at).gradient, x, scale, h) for h in steps(1e-4)
    ]
    check_differences(scale * H, differences)
    v, weights = rng.normal(size=(3, 4)), rng.normal(size=(3, 1))
    left_out = Quartic().hessian(v, weights)
    exact = weights[:, :, None] * (12.0 * v**2)[:, :, None] * np.eye(4)
    np.testing.assert_allclose(left_out, exact, atol=1e-7)


class Quartic(QuantityFunction):
    """Sum of v⁴, without its Hessian."""

    def value(self, quantity):
        """Return it."""
        return (quantity**4).sum(axis=1, keepdims=True)

    def jacobian(self, quantity):
        """Return 4 v³."""
        return 4.0 * quantity[:, None] ** 3


def test_half_a_hessian_is_refused_and_told_to_be_left_out():
    problem, x = changed("guess", cost=Residuals("Gauss-Newton"))
    with pytest.raises(InputError, match=r"hessian of the cost 'residuals' .* or leave it out"):
        problem.check_own(x)


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (lambda: SquaredNorm(1.0), r"weights of a SquaredNorm have shape \(\); .*np\.ones\(12\)"),
        (lambda: SquaredNorm(np.eye(12)), r"have shape \(12, 12\); give one for each entry"),
        (lambda: SquaredNorm(np.ones(6)), r"has 6 weights, but .* has 12; give 12 \(the cost 'wid"),
        (lambda: Linear(1.0), r"matrix of a Linear has shape \(\); give \(rows, entries\)"),
        (lambda: Linear(np.ones(12)), r"has shape \(12,\); give \(rows, entries\)"),
        (lambda: Linear(np.ones((1, 6))), r"matrix of 6 columns, but what .* 12; give 12 \(the co"),
        (lambda: Entries(slice(0, 12), 12, np.ones(5)), r"factor .* shape \(5,\); .* 12 entries"),
        (lambda: Entries(slice(0, 1), 6), r"Entries of 6, but what it reads has 12; give 12"),
        (lambda: costs.MotorPower(np.ones(12), 2.0), r"MotorPower of 12 motors .* 24 .* has 12"),
        (lambda: FrictionCone("a", 1.0), "friction is 'a'; give a number"),
        (lambda: Torsion(1.0, None), "least is None; give a number"),
    ],
)  # fmt: skip
def test_functions_of_another_width_are_told(robot, made, message):
    @dataclass(frozen=True)
    class Wide(RunningCost):
        name, unit, words, reads = "wide", "1", "a cost of the tests", (quantities.TORQUE,)

        def integrand(self, robot):
            return made()

    with pytest.raises(InputError, match=message) as caught:
        WalkProblem(robot, preset_task(cost=Wide()))
    assert "matmul" not in str(caught.value)
    assert "broadcast" not in str(caught.value)


class Nameless(Constraint):
    """Says nothing of itself."""

    reads = (quantities.WRENCH,)

    def block(self, context):
        """Return no rows."""


def test_what_is_not_declared_is_asked_for():
    with pytest.raises(InputError, match="Nameless declares no name and no unit and no words"):
        Task(constraints=(Nameless(),))


TELLING = [
    (MotorPower, "constraints", name)
    for name in ("name", "unit", "words", "equation", "reads", "change", "margins", "couplings")
]
TELLING += [(Smoothness, "cost", name) for name in ("name", "unit", "words", "reads", "check")]
TELLING += [(Stairs, "terrain", name) for name in ("name", "shaped", "down", "rise")]  # fmt: skip


@pytest.mark.parametrize("error", [ValueError, AttributeError, SystemExit])
@pytest.mark.parametrize(("kind", "field", "name"), TELLING)
def test_what_raises_as_it_says_what_it_is_is_told_with_its_line(robot, kind, field, name, error):
    @dataclass(frozen=True)
    class Raising(kind):
        def raises(self, *_):
            raise error("a slip of mine")

        locals()[name] = raises if name == "check" else property(raises)

    one = Raising(0.1) if kind is Stairs else Raising()
    told = rf"({name}|terrain 'stairs'|checked).*: {error.__name__}: a slip of mine \(line \d+ of"
    with pytest.raises(InputError, match=told):
        WalkProblem(robot, Task(**{field: (one,) if field == "constraints" else one}))
    if name == "name":  # as a file that names another is read
        record = {"name": "another", "fields": {}, "class": "mine.Another"}
        read = {
            "constraints": constraint_from_record,
            "cost": cost_from_record,
            "terrain": terrain_from_record,
        }
        with pytest.raises(InputError, match=told):
            read[field](record, (one,))


def test_one_quantity_without_a_comma_is_told():
    class Comma(Nameless):
        name, unit, words, reads = "comma", "N", "nothing", quantities.WRENCH

    with pytest.raises(InputError, match=r"give a tuple of quantities: reads = \(quantities"):
        Task(constraints=(Comma(),))


def test_a_failure_in_a_plugin_has_its_line(robot, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(SWING_HEIGHT.read_text().replace("self.over_step", "self.over_stp"))
    (line,) = [k for k, one in enumerate(path.read_text().split("\n"), 1) if "over_stp(" in one]
    with pytest.raises(InputError, match=rf"'over_stp' \(line {line} of mine\.py\)"):
        WalkProblem(robot, preset_task(constraints=load_plugin(path).constraints))


class Plain(MotorPower):
    """Not decorated: its field would stay a declaration."""

    least_power: float = margin(1.0, "Least power.", unit="W")


@dataclass
class Mutable(Constraint):
    """Not frozen."""

    name, unit, words, reads = "mutable", "N", "what changes", (quantities.WRENCH,)
    limit: float = 5.0

    def block(self, context):
        """Return no rows."""


class Keeper(Constraint):
    """Keeps a value where no file sees it."""

    name, unit, words, reads = "keeper", "N", "what is kept", (quantities.WRENCH,)

    def __init__(self):
        self.limit = 5.0

    def block(self, context):
        """Return no rows."""


@pytest.mark.parametrize("one", [Plain(), Mutable(), Keeper()])
def test_values_are_kept_in_frozen_dataclasses(one):
    with pytest.raises(
        InputError, match=f"{type(one).__name__} keeps values but is no frozen data"
    ):
        Task(constraints=(one,))


def test_names_must_be_ones_own():
    with pytest.raises(InputError, match="two constraints are called 'wrong'; rename one"):
        Task(constraints=(Wrong(), Twice()))
    with pytest.raises(InputError, match="give instances of subclasses of Constraint"):
        Task(constraints=("low swing",))
    with pytest.raises(InputError, match=r"cost is 'effort'; give a Cost, as TorqueCost\(\)"):
        Task(cost="effort")


def test_margins_of_ones_own_are_set_like_the_others():
    task = preset_task(constraints=(MotorPower(),), most_power=250.0, friction=0.5)
    assert task.margin("most_power") == task.constraints[0].most_power == 250.0
    assert task.margin("friction") == task.margins.friction == 0.5
    assert list(task.declared)[-1] == "most_power"
    with pytest.raises(InputError, match=r"most_power is -1.0 W; it must be above 0"):
        task.with_margins({"most_power": -1.0})
    with pytest.raises(
        InputError, match=r"no margin 'power'; did you mean 'most_power'\? there are friction, "
    ):
        task.margin("power")
    with pytest.raises(InputError, match="no task field most_power"):
        preset_task(most_power=250.0)


def test_a_margin_that_is_none_switches_its_constraint_off(robot):
    @dataclass(frozen=True)
    class Asked(MotorPower):
        most_power: float | None = margin(None, "Largest power of a motor.", unit="W", above=0.0)

    def names(**margins):
        task = preset_task(constraints=(Asked(),), **margins)
        return {block.name for block in WalkProblem(robot, task).blocks}

    assert names(most_power=250.0) - names() == {"motor power"}


def test_a_task_knows_what_of_it_is_not_built_in():
    """Sensitivities say of what they do not know all; a first guess is checked for it."""
    sums = WeightedSum(((OWN[-1]["cost"], 0.5), (TorqueCost(), 1.0)))
    motors = MotorEnvelope(motors=(KNEE,))
    task = preset_task(cost=sums, constraints=(motors, MotorPower()))
    assert task.extensions == (Smoothness(), MotorPower())
    assert preset_task(constraints=(motors,)).extensions == ()


def test_a_task_with_its_own_comes_back_through_json():
    plugin = load_plugin(SWING_HEIGHT)
    cost = WeightedSum(((TorqueCost({"*_knee": 2.0}), 0.5), (TorqueCost(), 0.5)))
    task = preset_task(constraints=plugin.constraints, low_swing=0.055, cost=cost)
    record = json.loads(json.dumps(task_record(task), allow_nan=False))
    (own,) = record["constraints"]
    assert own["fields"] == {"low_swing": 0.055}
    assert own["plugin"] == {"file": "swing_height.py", "sha256": plugin.digest}
    assert task_from_record(record, plugin.extensions) == task
    with pytest.raises(InputError, match=r"'low swing', .* --plugin swing_height.py \(in Python"):
        task_from_record(record)
    with pytest.raises(InputError, match=r"'motor power', .*: it is a .*MotorPower; put it into a"):
        task_from_record(task_record(Task(constraints=(MotorPower(),))))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"constraints": 5}, "record of the task cannot be read: .*not iterable"),
        ({"constraints": [5]}, "record of a constraint has no name"),
        ({"constraints": [{"name": "a\x1b[31m", "plugin": {"file": 7}}]}, r"'a\?\[31m', .* '7'"),
        ({"constraints": [{"name": "low swing", "fields": 5}]}, "does not take the values recor"),
        (
            {"constraints": [{"name": "low swing", "fields": {"x": 1}}]},
            "takes low_swing, and no x, which is recorded",
        ),
        ({"constraints": [{"name": "low swing", "fields": {"low_swing": "a"}}]}, "a finite number"),
        ({"cost": 5}, "record of a cost has no name"),
        ({"cost": {"name": "torque", "fields": {"weights": 5}}}, "weights of joints are 5"),
        ({"cost": {"name": "sum", "fields": {"terms": [5]}}}, "no pairs of a cost and its weight"),
        ({"cost": {"name": "sum", "fields": {"terms": []}}}, "a weighted sum needs costs"),
    ],
)
def test_records_of_strangers_are_refused(changes, message):
    record = {**task_record(Task()), **changes}
    with pytest.raises(InputError, match=message):
        task_from_record(record, load_plugin(SWING_HEIGHT).extensions)


def test_a_file_records_only_what_it_can_hold():
    @dataclass(frozen=True)
    class Odd(Wrong):
        value: object = None

    with pytest.raises(InputError, match="value of 'wrong' is a set, which a gait file cannot"):
        task_record(Task(constraints=(Odd(value={1}),)))


def test_another_process_imports_the_plugin(tmp_path):
    task = Task(constraints=load_plugin(SWING_HEIGHT).constraints)
    assert pickle.loads(pickle.dumps(task)) == task
    path = tmp_path / "task"
    path.write_bytes(pickle.dumps(task))
    code = (
        "import pickle, sys; task = pickle.load(open(sys.argv[1], 'rb'));"
        "print(task.constraints[0].name, task.margin('low_swing'))"
    )
    found = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    assert found.stdout == "low swing 0.06\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "offers nothing; at module level, let `constraints` be a tuple of"),
        ("constraints = (5,)", "has 5 in `constraints`; give instances of subclasses of Constr"),
        ("cost = 'effort'", "`cost` of the plugin .* is 'effort'; give an instance of a Cost"),
        ("import nothing_there", r"imported: ModuleNotFoundError: .*_there' \(line 1 of mine.py\)"),
        ("constraints = (", "cannot be imported: SyntaxError: .*line 1"),
        (
            "from gaitopt import margin\nmargin()",
            r"a required argument: 'de.* \(line 2 of mine.py\)",
        ),
    ],
)
def test_plugins_that_cannot_be_are_refused(tmp_path, text, message):
    path = tmp_path / "mine.py"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        load_plugin(path)


def test_files_that_are_no_plugins_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the plugin .*: no such file"):
        load_plugin(tmp_path / "missing.py")
    path = tmp_path / "mine.txt"
    path.write_text("constraints = ()")
    with pytest.raises(InputError, match=r"is no Python file; give one whose name ends in \.py"):
        load_plugin(path)
