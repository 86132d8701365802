"""What a walk is optimised for: the cost of Eqs. (46) and (47), and others that may take its place.

A `Cost` is declared once, with name, unit and words. Nearly every cost is an integral over the step
per metre walked, forward or backward, and per second of a walk in place: subclass `RunningCost` and
give the integrand. To add one to those known by name,
write a class here and list it in `COSTS`; costs of one's own need not stand here: see
docs/extending.md.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field, fields, is_dataclass, replace
from numbers import Real
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from gaitopt.actuators.motors import JointMotor, joint_motors, joint_motors_of
from gaitopt.bounds import USABLE, is_finite, is_of_use, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import EvaluationError, InputError, did_you_mean, own_code, there_are
from gaitopt.gait import quantities
from gaitopt.gait.constraint import (
    Constraint,
    ConstraintBlock,
    ConstraintContext,
    check_declaration,
    margin,
)
from gaitopt.gait.functions import (
    Linear,
    QuantityFunction,
    SquaredNorm,
    check_function,
    check_width,
    shaped,
)
from gaitopt.gait.grid import Grid
from gaitopt.gait.quantities import TRAVEL, Quantity, typical_entries
from gaitopt.model.import_options import matching
from gaitopt.nlp import Array
from gaitopt.settings import check_settings, checked, setting
from gaitopt.units import read_number

if TYPE_CHECKING:
    from gaitopt.gait.step import Period
    from gaitopt.model.robot import Robot

Pair = tuple[Quantity, Quantity]
RowPairs = NDArray[np.int_]
Neighbours = dict[Quantity, tuple[RowPairs, Array]]


@dataclass(frozen=True)
class CostContext:
    """The walk that a cost is made for.

    Attributes:
        robot: the biped.
        grid: the instants of the step, or of the stride in the order of its rows.
        speed: V asked for [m/s]; below zero backward, zero in place; of a stride along its path.
        nodes: rows of a stride at which it is integrated; None: the first ones of the grid.
    """

    robot: Robot
    grid: Grid
    speed: float
    nodes: NDArray[np.int_] | None = None

    @property
    def weights(self) -> Array:
        """Of the quadrature over the step for T = 1, shape (N,)."""
        return self.grid.weights

    @property
    def way(self) -> int:
        """Sign of the speed, 0 in place."""
        return int(np.sign(self.speed))

    @property
    def pace(self) -> float:
        """Metres per second over which a running cost is told: |V|, or 1 in place."""
        return abs(self.speed) or 1.0


class CostFunction(ABC):
    """A cost of one walk, and its derivatives with respect to the quantities it reads."""

    @abstractmethod
    def value(self, step: Period) -> float:
        """Return the cost."""

    @abstractmethod
    def gradient(self, step: Period) -> dict[Quantity, Array]:
        """Return the derivatives with respect to quantities, each of the quantity's shape."""

    def hessian(self, step: Period) -> dict[Pair, Array]:
        """Return second derivatives by pairs of quantities (a, b), each pair once.

        Rows of different instants do not mix: that of a pair has shape (K, entries of a, entries of
        b). Where b has a single row (`TRAVEL`), it goes with each of the K rows of a.

        By default central differences of `gradient`, to about 1e-9 of their size: leave it out
        rather than approximate it, as Gauss and Newton do. A cost that mixes instants gives it, and
        `neighbours`.
        """
        return _differenced(self, step)

    def neighbours(self, step: Period) -> Neighbours:
        """Return second derivatives between two rows of a quantity, where a cost mixes instants.

        For each quantity the pairs of rows, shape (K, 2), and the second derivatives between the
        same entry of both, shape (K, entries).
        """
        del step
        return {}


class Cost(ABC):
    """A cost; a subclass declares it and makes its function for a walk.

    A subclass with numbers of its own is a frozen dataclass; fields made by `margin` are checked.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Unique: "torque"."""

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of its value per metre; this is the one place where it stands."""

    @property
    @abstractmethod
    def words(self) -> str:
        """What a person calls it: "squared torque per metre"."""

    @property
    @abstractmethod
    def reads(self) -> tuple[Quantity, ...]:
        """The quantities it depends on, without `TRAVEL`."""

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        """What a walk of this cost has to keep, for the cost to be what it says."""
        return ()

    def __post_init__(self) -> None:
        check_settings(self)

    @abstractmethod
    def function(self, context: CostContext) -> CostFunction:
        """Return the cost of a walk as a function of its step."""

    @abstractmethod
    def typical(self, context: CostContext) -> float:
        """Return about what a good walk costs, by which the problem is scaled; above zero."""

    def check(self, context: CostContext) -> None:
        """Check a cost of one's own.

        Raises:
            InputError: it is not above zero where it should be, or a derivative is wrong.
        """
        with own_code(self, f"the cost '{self.name}' has no typical value"):
            typical = self.typical(context)
        if not (is_of_use(typical) and typical > 0.0):
            raise InputError(
                f"the cost '{self.name}' is {shown(typical)} {self.unit} at typical values of what "
                f"it reads; it must be above 0 there, {USABLE}"
            )


def check_cost(cost: Cost) -> None:
    """Check that it is a cost, whose class says what it is and what a walk of it has to keep.

    Raises:
        InputError: it is none, or its class does not; see `check_declaration`.
    """
    if not isinstance(cost, Cost):
        raise InputError(f"cost is {shown(cost)}; give a Cost, as TorqueCost()")
    check_declaration(cost)
    with own_code(cost, f"the cost '{cost.name}' cannot make its constraints"):
        kept: object = cost.constraints
    if not (isinstance(kept, tuple) and all(isinstance(one, Constraint) for one in kept)):
        raise InputError(
            f"the constraints of the cost '{cost.name}' are {shown(kept)}; give a tuple of "
            "instances of subclasses of Constraint"
        )


class RunningCost(Cost):
    """J = (1 / |d|) integral of l dt over a step of length d; a subclass gives the integrand l.

    In place the integral is divided by the duration of the step instead.
    """

    @abstractmethod
    def integrand(self, robot: Robot) -> QuantityFunction:
        """Return l as a function with one row of the quantities it reads, side by side."""

    def function(self, context: CostContext) -> CostFunction:
        integrand = self.integrand(context.robot)
        return _Integral(integrand, self.reads, context.weights, context.way)

    def typical(self, context: CostContext) -> float:
        """Return the cost of typical values of the quantities, see `typical_entries`."""
        entries, integrand = self._typical_entries(context.robot), self.integrand(context.robot)
        return float(integrand.value(entries[None])[0, 0]) / context.pace

    def check(self, context: CostContext) -> None:
        """Check the integrand near typical values of the quantities, and the cost there.

        Raises:
            InputError: the integrand cannot be made, is wrong, or reads what a step has once; see
                `Cost.check`.
        """
        for one in self.reads:
            if one.rows:
                raise InputError(
                    f"the cost '{self.name}' reads {one}, which a step has once; an integral over "
                    "the step has none of it: subclass Cost in place of RunningCost"
                )
        with own_code(self, f"the cost '{self.name}' cannot make its integrand"):
            integrand = self.integrand(context.robot)
        check_function(
            integrand, self._typical_entries(context.robot), 1, f"the cost '{self.name}'"
        )
        super().check(context)

    def _typical_entries(self, robot: Robot) -> Array:
        return np.concatenate([typical_entries(one, robot) for one in self.reads])


def joint_weights_field() -> Any:
    """Return a dataclass field with weights of joints, by patterns of their names."""
    declared = setting(
        "Weight of the joints of that name in the cost: '*_knee=2'.", metavar="PATTERN=VALUE",
        example="'*_knee=2'",
    )  # fmt: skip
    return field(default_factory=dict, hash=False, metadata=declared)


def check_weights(weights: Mapping[str, float]) -> None:
    """Check weights of joints.

    Raises:
        InputError: they are no table, or one is no finite number or negative.
    """
    if not isinstance(weights, Mapping):
        raise InputError(f"the weights of joints are {shown(weights)}; give a table by name")
    for pattern, weight in weights.items():
        if not (is_finite(weight) and weight >= 0.0):
            raise InputError(
                f"the weight of '{pattern}' in the cost is {weight}; it must be a finite number, "
                "zero or more"
            )
        if not is_of_use(weight):
            raise InputError(
                f"the weight of '{pattern}' in the cost is {weight}; it must be 0, or {USABLE}"
            )


@dataclass(frozen=True)
class _OfJoints(Cost):
    """What costs of weighed joints have in common."""

    weights: Mapping[str, float] = joint_weights_field()

    def __post_init__(self) -> None:
        check_settings(self)
        check_weights(self.weights)


@checked
@dataclass(frozen=True)
class TorqueCost(RunningCost, _OfJoints):
    """J = (1 / d) integral of Gamma' W Gamma dt, Eq. (46); W is one in the paper.

    Attributes:
        weights: of joints by patterns of their names, as `{"*_knee": 2.0}`; of several that fit
            the last one counts, and one where none does. Every joint is in the stance leg in one
            step and in the swing leg in the next, so the two joints of a pair count with the mean
            of their weights.

    Raises:
        InputError: a weight is no number, or negative.
    """

    name, unit, words = "torque", "N²·m·s", "squared torque per metre"
    reads = (quantities.TORQUE,)

    def integrand(self, robot: Robot) -> QuantityFunction:
        return SquaredNorm(joint_weights(robot, self.weights))


@dataclass(frozen=True)
class _Work(RunningCost):
    """What costs of the motors' power, rounded off at zero, have in common."""

    reads = (quantities.TORQUE, quantities.RATES)
    power_smoothing: float = margin(
        2.0, "Power around which its absolute value is rounded off.", unit="W", above=0.0
    )
    weights: Mapping[str, float] = joint_weights_field()

    def __post_init__(self) -> None:
        check_settings(self)
        check_weights(self.weights)


@checked
@dataclass(frozen=True)
class MechanicalWork(_Work):
    """J = (1 / d) integral of the absolute mechanical power of the motors, rounded off at zero.

    What motors take that cannot give back: sum of sqrt((Gamma_i dq_i)² + s²) - s over the joints.

    Attributes:
        power_smoothing: s, the power around which the absolute value turns round [W].
        weights: of joints, as those of `TorqueCost`.

    Raises:
        InputError: s is not above zero, or a weight is no number, or negative.
    """

    name, unit, words = "work", "J/m", "absolute mechanical work per metre"

    def integrand(self, robot: Robot) -> QuantityFunction:
        weights = joint_weights(robot, self.weights)
        return MotorPower(curved=weights, power_smoothing=self.power_smoothing)


@checked
@dataclass(frozen=True)
class PositiveWork(_Work):
    """J = (1 / d) integral of the positive mechanical power of the motors, rounded off at zero.

    What motors take whose braking is free: sum of (p_i + sqrt(p_i² + s²) - s) / 2 over the joints.

    Attributes:
        power_smoothing, weights: as those of `MechanicalWork`.

    Raises:
        InputError: as `MechanicalWork`.
    """

    name, unit, words = "positive-work", "J/m", "positive mechanical work per metre"

    def integrand(self, robot: Robot) -> QuantityFunction:
        half = 0.5 * joint_weights(robot, self.weights)
        return MotorPower(linear=half, curved=half, power_smoothing=self.power_smoothing)


@checked
@dataclass(frozen=True)
class ElectricalEnergy(RunningCost):
    """J = (1 / d) integral of the electrical power of the motors: copper loss and what they give.

    A motor whose joint takes the mechanical power p draws loss * torque² + p / efficiency where it
    drives; where it brakes, regeneration * efficiency * p comes back. Both are joined smoothly.

    Attributes:
        regeneration: share of the braking power behind the gear that the supply takes back.
        power_smoothing: s, the power around which drawing turns into giving back [W].
        motors: of every joint, `gaitopt.actuators.motors.MotorTable.at_joints`.

    Raises:
        InputError: a number is out of range; when the walk is made, a joint has no motor.
    """

    name, unit, words = "energy", "J/m", "electrical energy per metre"
    reads = (quantities.TORQUE, quantities.RATES)
    regeneration: float = margin(
        0.0, "Share of the braking power that the supply takes back.", least=0.0, most=1.0,
        metavar="SHARE",
    )  # fmt: skip
    power_smoothing: float = margin(
        2.0, "Power around which its absolute value is rounded off.", unit="W", above=0.0
    )
    motors: tuple[JointMotor, ...] = ()

    def __post_init__(self) -> None:
        check_settings(self)
        object.__setattr__(self, "motors", joint_motors_of(self.motors))

    def integrand(self, robot: Robot) -> QuantityFunction:
        """Return the sum of electrical powers.

        Raises:
            InputError: there are no motors, or not of every joint that moves.
        """
        if not self.motors:
            raise InputError(
                f"the cost '{self.name}' needs the motors of the joints: give --motors FILE "
                "(in Python ElectricalEnergy(motors=read_motors(FILE).at_joints))"
            )
        found = joint_motors(self.motors, robot.joint_names, robot.mirror)
        motors = [one for one in found if one is not None]
        if len(motors) < len(found):
            bare = [n for n, one in zip(robot.joint_names, found, strict=True) if one is None]
            raise InputError(
                f"the cost '{self.name}' needs the motor of every joint that moves, but "
                f"{', '.join(bare)} has none; add [[drives]] for it to the table of motors"
            )
        loss, efficiency, friction = (
            np.array([getattr(one, name) for one in motors])
            for name in ("loss", "efficiency", "friction")
        )
        drawn, returned = 1.0 / efficiency, self.regeneration * efficiency
        return MotorPower(
            loss=loss,
            linear=0.5 * (drawn + returned),
            curved=0.5 * (drawn - returned),
            friction=friction,
            power_smoothing=self.power_smoothing,
        )


RATE_SMOOTHING = 0.05
"""Rate around which the power of friction is rounded off [rad/s]; walks turn joints at 1 to 10."""


@dataclass(frozen=True)
class MotorPower(QuantityFunction):
    """Power of motors, of torques and rates side by side; p_i = Gamma_i dq_i.

    Sum over the joints of loss Gamma² + linear p + curved (sqrt(p² + s²) - s)
    + friction (sqrt(dq² + r²) - r), r being `RATE_SMOOTHING`.

    Attributes:
        curved: of each joint, shape (n,).
        power_smoothing: s [W].
        loss: [W/(N·m)²], shape (n,) or a number for all.
        linear: likewise.
        friction: [N·m], likewise.
    """

    curved: Array
    power_smoothing: float
    loss: Array | float = 0.0
    linear: Array | float = 0.0
    friction: Array | float = 0.0

    def value(self, quantity: Array) -> Array:
        torque, rate, power, size = self._parts(quantity)
        rubbing = np.hypot(rate, RATE_SMOOTHING) - RATE_SMOOTHING
        each = self.curved * (size - self.power_smoothing) + self.linear * power
        each += self.loss * torque**2 + self.friction * rubbing
        return np.asarray(each.sum(axis=1, keepdims=True))

    def jacobian(self, quantity: Array) -> Array:
        torque, rate, power, size = self._parts(quantity)
        of_power = self.curved * power / size + self.linear
        rubbing = self.friction * rate / np.hypot(rate, RATE_SMOOTHING)
        by_torque = of_power * rate + 2.0 * self.loss * torque
        by_rate = of_power * torque + rubbing
        return np.concatenate([by_torque, by_rate], axis=1)[:, None]

    def hessian(self, quantity: Array, weights: Array) -> Array:
        torque, rate, power, size = self._parts(quantity)
        second = self.curved * self.power_smoothing**2 / size**3
        rubbing = self.friction * RATE_SMOOTHING**2 / np.hypot(rate, RATE_SMOOTHING) ** 3
        mixed = second * power + self.curved * power / size + self.linear
        blocks = [
            [second * rate**2 + 2.0 * self.loss, mixed],
            [mixed, second * torque**2 + rubbing],
        ]
        diagonals = [
            [(weights * entry)[:, :, None] * np.eye(len(self.curved)) for entry in row]
            for row in blocks
        ]
        return np.block(diagonals)

    def _parts(self, quantity: Array) -> tuple[Array, Array, Array, Array]:
        """Torque, rate, p and sqrt(p² + s²), shape (K, n) each."""
        check_width(
            2 * len(self.curved),
            quantity,
            f"a MotorPower of {len(self.curved)} motors takes {{}} entries, torques and rates",
        )
        torque, rate = np.split(quantity, 2, axis=1)
        power = torque * rate
        return torque, rate, power, np.hypot(power, self.power_smoothing)


@checked
@dataclass(frozen=True)
class PeakTorque(_OfJoints):
    """J = p, the largest |torque| of any joint at any instant, weighed: a minimax.

    p is a parameter of the walk, below which all torques stay; the constraint holds between the
    samples too. Only the joints at their peaks decide: a sum with a little of another cost settles
    the rest of the walk.

    Attributes:
        weights: of joints, as those of `TorqueCost`; the torques are multiplied by them.

    Raises:
        InputError: a weight is no number, or negative.
    """

    name, unit, words = "peak-torque", "N·m", "largest torque"
    reads = (quantities.PEAK,)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        return (BelowPeak(weights=self.weights),)

    def function(self, context: CostContext) -> CostFunction:
        del context
        return _Peak()

    def typical(self, context: CostContext) -> float:
        return float(typical_entries(quantities.PEAK, context.robot)[0])


@checked
@dataclass(frozen=True)
class BelowPeak(Constraint):
    """-p <= weighed torques <= p, with p the largest one, which a cost minimises.

    Attributes:
        weights: of joints by patterns of their names.
    """

    name, unit, words = "peak torque", "N·m", "largest torque"
    reads = (quantities.TORQUE, quantities.PEAK)
    weights: Mapping[str, float] = field(default_factory=dict, hash=False)

    def block(self, context: ConstraintContext) -> ConstraintBlock:
        names = context.robot.joint_names
        weights = joint_weights(context.robot, self.weights)
        kept = np.flatnonzero(weights)
        weighed, own = np.diag(weights)[kept], np.ones((len(kept), 1))
        rows = [np.hstack([weighed, side * own]) for side in (-1.0, 1.0)]
        labels = [f"{names[k]} torque {side} peak" for side in ("and", "and minus") for k in kept]
        upper = np.repeat([0.0, np.inf], len(kept))
        scale = float(typical_entries(quantities.PEAK, context.robot)[0])
        return self.over_step(
            context, Linear(np.vstack(rows)), tuple(labels), lower=-upper[::-1], upper=upper,
            scale=scale,
        )  # fmt: skip


@dataclass(frozen=True)
class _Peak(CostFunction):
    """p, which is the same at every instant."""

    def value(self, step: Period) -> float:
        return float(step.read(quantities.PEAK)[0, 0])

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        first = np.zeros(step.read(quantities.PEAK).shape)
        first[0] = 1.0
        return {quantities.PEAK: first}

    def hessian(self, step: Period) -> dict[Pair, Array]:
        del step
        return {}


@checked
@dataclass(frozen=True)
class TorqueRate(_OfJoints):
    """J = (1 / |d|) integral of the squared rates of the torques: how jerky the motors pull.

    Rates are those between consecutive samples, within the step: at the impact the torques jump,
    as they do where the phase changes. In place the integral is divided by the duration instead.

    Attributes:
        weights: of joints, as those of `TorqueCost`.

    Raises:
        InputError: a weight is no number, or negative.
    """

    name, unit, words = "torque-rate", "N²·m/s", "squared torque rate per metre"
    reads = (quantities.TORQUE,)

    def function(self, context: CostContext) -> CostFunction:
        nodes = np.arange(context.grid.nodes) if context.nodes is None else context.nodes
        lengths = np.diff(context.grid.instants[nodes])
        whole = np.flatnonzero(lengths > _SAME_INSTANT)
        weights = joint_weights(context.robot, self.weights) / lengths[whole, None]
        return _RateSum(np.stack([nodes[whole], nodes[whole + 1]], axis=1), weights, context.way)

    def typical(self, context: CostContext) -> float:
        torque = typical_entries(quantities.TORQUE, context.robot)
        weights = joint_weights(context.robot, self.weights)
        turn = _TYPICAL_TURN * context.robot.scales.rate
        return float(turn**2 * weights @ torque**2) / context.pace


_SAME_INSTANT = 1e-6  # of the step: both sides of a change of phase
_TYPICAL_TURN = 10.0  # 1/s: rate of a torque over the torque


@dataclass(frozen=True)
class _RateSum(CostFunction):
    """(1 / (|d| T)) sum of weights (change of the torques)² over the intervals; in place / T².

    Attributes:
        rows: of both ends of each interval, shape (K, 2).
        weights: of the joints over the length of the interval for T = 1, shape (K, n).
        way: sign of d, 0 in place.
    """

    rows: RowPairs
    weights: Array
    way: int

    def value(self, step: Period) -> float:
        return self._factors(step)[0] * self._sum(step)

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        factor, of_factor, _ = self._factors(step)
        total = self._sum(step)
        return {quantities.TORQUE: factor * self._slope(step), TRAVEL: total * of_factor[None]}

    def hessian(self, step: Period) -> dict[Pair, Array]:
        """Return the second derivatives within rows; those between them are `neighbours`."""
        factor, of_factor, bent = self._factors(step)
        torque = quantities.TORQUE
        own = np.zeros(step.read(torque).shape)
        for end in (0, 1):
            np.add.at(own, self.rows[:, end], 2.0 * factor * self.weights)
        return {
            (torque, torque): own[:, :, None] * np.eye(self.weights.shape[1]),
            (torque, TRAVEL): self._slope(step)[:, :, None] * of_factor,
            (TRAVEL, TRAVEL): self._sum(step) * bent[None],
        }

    def neighbours(self, step: Period) -> Neighbours:
        return {quantities.TORQUE: (self.rows, -2.0 * self._factors(step)[0] * self.weights)}

    def _changes(self, step: Period) -> Array:
        torque = step.read(quantities.TORQUE)
        return np.asarray(torque[self.rows[:, 1]] - torque[self.rows[:, 0]])

    def _sum(self, step: Period) -> float:
        return float(np.sum(self.weights * self._changes(step) ** 2))

    def _slope(self, step: Period) -> Array:
        """Derivative of the sum in the torques, shape (N, n)."""
        slope = np.zeros(step.read(quantities.TORQUE).shape)
        moved = 2.0 * self.weights * self._changes(step)
        np.add.at(slope, self.rows[:, 0], -moved)
        np.add.at(slope, self.rows[:, 1], moved)
        return slope

    def _factors(self, step: Period) -> tuple[float, Array, Array]:
        """1 / (|d| T), or 1 / T² in place, with its derivatives in (d, T), (2,) and (2, 2)."""
        d, T = step.step_length, step.duration
        if self.way == 0:
            return 1.0 / T**2, np.array([0.0, -2.0 / T**3]), np.diag([0.0, 6.0 / T**4])
        if not self.way * d > 0.0:
            raise EvaluationError(f"a step of {d} m does not go where it should")
        factor = 1.0 / (self.way * d * T)
        mixed = factor / (d * T)
        return (
            factor,
            np.array([-factor / d, -factor / T]),
            np.array([[2.0 * factor / d**2, mixed], [mixed, 2.0 * factor / T**2]]),
        )


COSTS: tuple[Cost, ...] = (
    TorqueCost(), MechanicalWork(), PositiveWork(), ElectricalEnergy(), PeakTorque(), TorqueRate(),
)  # fmt: skip
"""The costs that are known by name."""


def cost_by_name(name: str, known: Iterable[Cost] = (), **changes: object) -> Cost:
    """Return a cost by its name, with some of its fields changed.

    Args:
        known: costs there are besides.
        changes: fields, as `weights={"*_knee": 2.0}`.

    Raises:
        InputError: there is no such cost or field, or a value is out of range.
    """
    costs = {one.name: one for one in (*COSTS, *known)}
    if name not in costs:
        raise InputError(f"there is no cost '{name}'; {there_are(costs, name)}")
    names = _fields_of(costs[name])
    if unknown := set(changes) - set(names):
        raise InputError(
            f"the cost '{name}' has no {', '.join(sorted(unknown))}; "
            f"{did_you_mean(min(unknown), names)}it has {', '.join(names) or 'no fields'}"
        )
    return _changed(costs[name], changes)


def _fields_of(cost: Cost) -> list[str]:
    """Return the names of the fields of a cost, of a sum those of its terms."""
    if isinstance(cost, WeightedSum):
        return list(dict.fromkeys(name for term, _ in cost.terms for name in _fields_of(term)))
    return [one.name for one in fields(cost)] if is_dataclass(cost) else []


def _changed(cost: Cost, changes: Mapping[str, object]) -> Cost:
    """Return a cost with other values of its fields; of a sum, of every term that has them."""
    if isinstance(cost, WeightedSum):
        return WeightedSum(tuple((_changed(term, changes), weight) for term, weight in cost.terms))
    own: Any = {name: changes[name] for name in _fields_of(cost) if name in changes}
    changed: Any = cost
    return cast(Cost, replace(changed, **own)) if own else cost


def cost_of_text(text: str, known: Iterable[Cost] = (), **changes: object) -> Cost:
    """Return a cost by its name, or a sum of some: "torque + 0.5 energy".

    Args:
        text: names joined by +, each with its weight before it if that is not 1.
        known: costs there are besides the built-in ones.
        changes: fields; of a sum, of every term that has them.

    Raises:
        InputError: a name or a weight cannot be used, or no term has one of the fields.
    """
    parts, known = [part.split() for part in text.split("+")], tuple(known)
    if parts == [[text.strip()]] or text in (one.name for one in known):
        return cost_by_name(text.strip(), known, **changes)
    terms, names = [], set[str]()
    for part in parts:
        *weight, name = part or [""]
        try:
            value = read_number(weight[0]) if weight else 1.0
        except ValueError:
            value = float("nan")
        if not name or len(weight) > 1 or not is_finite(value):
            raise InputError(
                f"the sum of costs '{text[:80]}' cannot be read; join names by +, each with its "
                "weight before it, as in 'torque + 0.5 energy'"
            )
        plain = cost_by_name(name, known)
        names |= set(_fields_of(plain))
        terms.append((_changed(plain, changes), value))
    if unknown := set(changes) - names:
        hint = did_you_mean(min(unknown), names)
        known_ones = ", ".join(sorted(names)) or "no fields"
        raise InputError(
            f"no cost of '{text}' has {', '.join(sorted(unknown))}; {hint}they have {known_ones}"
        )
    return WeightedSum(tuple(terms))


@checked
@dataclass(frozen=True)
class WeightedSum(Cost):
    """A weighted sum of costs.

    Attributes:
        terms: costs and their weights.

    Raises:
        InputError: there are no terms, or a weight is not above zero.
    """

    terms: tuple[tuple[Cost, float], ...]

    def __post_init__(self) -> None:
        if not self.terms or not all(is_of_use(w) and w > 0.0 for _, w in self.terms):
            raise InputError(f"a weighted sum needs costs, with weights above 0, {USABLE}")
        for cost, _ in self.terms:
            check_cost(cost)
        if sum(quantities.PEAK in cost.reads for cost, _ in self.terms) > 1:
            raise InputError("a weighted sum has one largest torque; give peak-torque once")

    @property
    def name(self) -> str:
        return " + ".join(f"{weight:g} {cost.name}" for cost, weight in self.terms)

    @property
    def unit(self) -> str:
        """The unit of its terms; where they differ, the weights carry units."""
        units = {cost.unit for cost, _ in self.terms}
        return units.pop() if len(units) == 1 else "weighted"

    @property
    def words(self) -> str:
        return " + ".join(f"{weight:g} * {cost.words}" for cost, weight in self.terms)

    @property
    def reads(self) -> tuple[Quantity, ...]:
        return tuple(dict.fromkeys(one for cost, _ in self.terms for one in cost.reads))

    @property
    def motors(self) -> tuple[JointMotor, ...]:
        """Those that its terms know."""
        known = (one for cost, _ in self.terms for one in getattr(cost, "motors", ()))
        return tuple(dict.fromkeys(known))

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        return tuple(one for cost, _ in self.terms for one in cost.constraints)

    def function(self, context: CostContext) -> CostFunction:
        return _Sum(tuple((_function(cost, context), weight) for cost, weight in self.terms))

    def typical(self, context: CostContext) -> float:
        return sum(weight * cost.typical(context) for cost, weight in self.terms)

    def check(self, context: CostContext) -> None:
        for cost, _ in self.terms:
            cost.check(context)


def motors_replaced(
    cost: Cost, change: Callable[[tuple[JointMotor, ...]], tuple[JointMotor, ...]]
) -> Cost:
    """Return a cost with other motors, each term of a sum that knows any; others as they are."""
    if isinstance(cost, WeightedSum):
        return WeightedSum(tuple((motors_replaced(one, change), w) for one, w in cost.terms))
    motors = getattr(cost, "motors", None)
    return cost if motors is None else replace(cast(Any, cost), motors=change(motors))


def per_second(unit: str) -> str:
    """Return the unit of a cost per second, from that of it per metre."""
    return _PER_SECOND.get(unit, f"{unit}·m/s")


_PER_SECOND = {TorqueCost.unit: "N²·m²", MechanicalWork.unit: "W", "weighted": "weighted"}


def cost_function(cost: Cost, context: CostContext, penalty: float) -> CostFunction:
    """Return a cost with the second term of Eq. (47), penalty * (V T - d)², unless that is zero.

    Args:
        penalty: rho [cost / m²].
    """
    if isinstance(cost, WeightedSum) or type(cost).__module__ != __name__:
        with own_code(cost, f"the cost '{cost.name}' cannot be checked"):
            cost.check(context)
    plain = _function(cost, context)
    if penalty == 0.0:
        return plain
    return _Sum(((plain, 1.0), (SpeedPenalty(context.speed), penalty)))


def _function(cost: Cost, context: CostContext) -> CostFunction:
    return cost.function(context) if type(cost).__module__ == __name__ else _Own(cost, context)


class _Own(CostFunction):
    """The function of a cost of one's own: what it returns is looked at each time."""

    def __init__(self, cost: Cost, context: CostContext) -> None:
        self._cost, self._name = cost, f"the cost '{cost.name}'"
        self._reads = (*cost.reads, TRAVEL)
        with own_code(cost, f"{self._name} cannot make its function"):
            self._function = cost.function(context)
        if not isinstance(self._function, CostFunction):
            raise InputError(
                f"{self._name} has {shown(self._function)} for its function; return a CostFunction"
            )

    def value(self, step: Period) -> float:
        what = f"the value of {self._name}"
        with own_code(self._cost, what):
            value = self._function.value(step)
            if not isinstance(value, Real):
                raise InputError(f"{what} is {shown(value)}; return a number")
            return float(value)

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        with own_code(self._cost, what := f"the gradient of {self._name}"):
            shapes = {one: step.values[one].shape for one in self._reads}
            return _looked_at(self._function.gradient(step), shapes, what)

    def hessian(self, step: Period) -> dict[Pair, Array]:
        with own_code(self._cost, what := f"the hessian of {self._name}"):
            of = {one: step.values[one].shape for one in self._reads}
            pairs = [(a, b) for a in of for b in of if of[b][0] in (1, of[a][0])]
            shapes = {(a, b): (*of[a], of[b][1]) for a, b in pairs}
            return _looked_at(self._function.hessian(step), shapes, what)

    def neighbours(self, step: Period) -> Neighbours:
        with own_code(self._cost, what := f"the neighbours of {self._name}"):
            found = self._function.neighbours(step)
            shapes = {one: step.values[one][at][:, 1].shape for one, (at, _) in found.items()}
            bent = _looked_at({one: values for one, (_, values) in found.items()}, shapes, what)
            return {one: (found[one][0], bent[one]) for one in found}


@dataclass(frozen=True)
class _Beside:
    """A step some of whose quantities are others, for differences of a cost."""

    step: Period
    values: dict[Quantity, Array]

    def read(self, what: Quantity) -> Array:
        return self.values[what]

    @property
    def step_length(self) -> float:
        return float(self.values[TRAVEL][0, 0])

    @property
    def duration(self) -> float:
        return float(self.values[TRAVEL][0, 1])

    def __getattr__(self, name: str) -> Any:
        return getattr(self.step, name)


_RELATIVE = 1e-5  # step of differences of gradients, over the entry or one unit


def _differenced(function: CostFunction, step: Period) -> dict[Pair, Array]:
    """Return central differences of the gradient of a cost, as its `hessian`."""
    values = dict(step.values)
    asked, found = list(function.gradient(step)), dict[Pair, Array]()
    for k, other in enumerate(asked):
        entries = values[other]
        one_row = [one for one in asked if len(values[one]) > len(entries) == 1]
        same = [one for one in asked[: k + 1] if len(values[one]) == len(entries)]
        columns: dict[Quantity, list[Array]] = {one: [] for one in (*one_row, *same)}
        for entry in range(entries.shape[1]):
            move = np.zeros(entries.shape)
            move[:, entry] = _RELATIVE * np.maximum(1.0, np.abs(entries[:, entry]))
            after, before = (
                function.gradient(_Beside(step, {**values, other: entries + side * move}))
                for side in (1.0, -1.0)
            )
            for one, column in columns.items():
                change = np.subtract(after[one], before[one]) / (2.0 * move[:, entry, None])
                column.append(np.broadcast_to(change, values[one].shape))
        for one, column in columns.items():
            found[one, other] = np.stack(column, axis=2)
        square = found[other, other]
        found[other, other] = 0.5 * (square + square.swapaxes(1, 2))
    return found


Key = TypeVar("Key")


def _looked_at(found: object, shapes: Mapping[Key, tuple[int, ...]], what: str) -> dict[Key, Array]:
    """Return derivatives by quantity, or by pairs of them, if they are arrays of their shapes."""
    if not isinstance(found, Mapping):
        raise InputError(f"{what} is {shown(found)}; return a dictionary")
    for key in found:
        if key not in shapes:
            keys = ", ".join(dict.fromkeys(map(str, shapes)))
            raise InputError(f"{what} has an entry {shown(key)}; those of what it reads are {keys}")
    return {key: shaped(one, shapes[key], f"{what} in {key}") for key, one in found.items()}


def joint_weights(robot: Robot, patterns: Mapping[str, float]) -> Array:
    """Return the weight of each joint, the mean over each pair of joints, shape (joints,).

    Raises:
        InputError: a pattern fits no joint, or all weights are zero.
    """
    names, weights = robot.joint_names, np.ones(len(robot.joint_names))
    for pattern, weight in patterns.items():
        fits = matching(pattern, names)
        if not fits:
            raise InputError(
                f"the cost weighs '{pattern}', but no joint is called so; "
                f"{there_are(names, pattern)}, and patterns as '*_knee'"
            )
        weights[[name in fits for name in names]] = weight
    if not weights.any():
        raise InputError("the cost weighs every joint with zero; give one a weight above 0")
    return np.asarray(0.5 * (weights + np.abs(robot.mirror) @ weights))


@dataclass(frozen=True)
class SpeedPenalty(CostFunction):
    """(V T - d)² [m²], the second term of Eq. (47).

    Attributes:
        speed: V [m/s].
    """

    speed: float

    def value(self, step: Period) -> float:
        return (self.speed * step.duration - step.step_length) ** 2

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        gap = 2.0 * (self.speed * step.duration - step.step_length)
        return {TRAVEL: np.array([[-gap, self.speed * gap]])}

    def hessian(self, step: Period) -> dict[Pair, Array]:
        del step
        away = np.array([-1.0, self.speed])
        return {(TRAVEL, TRAVEL): 2.0 * np.outer(away, away)[None]}


@dataclass(frozen=True)
class _Integral(CostFunction):
    """(T / |d|) sum of weights_k l(quantities at instant k); in place the mean of l over time.

    Attributes:
        way: sign of d, 0 in place.
    """

    integrand: QuantityFunction
    reads: tuple[Quantity, ...]
    weights: Array
    way: int

    def value(self, step: Period) -> float:
        d, T = self._travel(step)
        return T / d * self._sum(self._entries(step))

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        """Return the derivatives in the quantities and in (d, T), Eqs. (50)-(57)."""
        (d, T), entries = self._travel(step), self._entries(step)
        by_entry = self.integrand.vjp(entries, (T / d * self.weights)[:, None])
        found = {
            one: by_entry[:, part] for one, part in quantities.columns(self.reads, step.values)
        }
        if self.way == 0:
            return found
        total = self._sum(entries)
        return found | {TRAVEL: np.array([[-self.way * T / d**2 * total, total / d]])}

    def hessian(self, step: Period) -> dict[Pair, Array]:
        (d, T), entries = self._travel(step), self._entries(step)
        found: dict[Pair, Array] = {}
        second = self.integrand.hessian(entries, (T / d * self.weights)[:, None])
        parts = quantities.columns(self.reads, step.values)
        if self.way != 0:
            total, way = self._sum(entries), self.way
            corner = -way * total / d**2
            bent = [[2.0 * T / d**3 * total, corner], [corner, 0.0]]
            by_entry = self.integrand.vjp(entries, self.weights[:, None])
            mixed = by_entry[:, :, None] * np.array([-way * T / d**2, 1.0 / d])
            found[TRAVEL, TRAVEL] = np.array([bent])
            found |= {(one, TRAVEL): mixed[:, rows] for one, rows in parts}
        for i, (one, rows) in enumerate(parts):
            if second is not None:
                found |= {(one, other): second[:, rows, columns] for other, columns in parts[i:]}
        return found

    def _travel(self, step: Period) -> tuple[float, float]:
        """Return |d| and T; (T, T) in place."""
        d, T = self.way * step.step_length, step.duration
        if self.way != 0 and not d > 0.0:
            raise EvaluationError(f"a step of {step.step_length} m does not go where it should")
        return (d, T) if self.way != 0 else (T, T)

    def _sum(self, entries: Array) -> float:
        return float(self.weights @ self.integrand.value(entries)[:, 0])

    def _entries(self, step: Period) -> Array:
        values = [step.read(one) for one in self.reads]
        return values[0] if len(values) == 1 else np.concatenate(values, axis=1)


@dataclass(frozen=True)
class _Sum(CostFunction):
    """Weighted sum of cost functions."""

    terms: tuple[tuple[CostFunction, float], ...]

    def value(self, step: Period) -> float:
        return sum(weight * term.value(step) for term, weight in self.terms)

    def gradient(self, step: Period) -> dict[Quantity, Array]:
        found: dict[Quantity, Array] = {}
        for term, weight in self.terms:
            for one, gradient in term.gradient(step).items():
                found[one] = found.get(one, 0.0) + weight * gradient
        return found

    def hessian(self, step: Period) -> dict[Pair, Array]:
        found: dict[Pair, Array] = {}
        for term, weight in self.terms:
            for pair, hessian in term.hessian(step).items():
                a, b = pair
                if (b, a) in found and a is not b:
                    pair, hessian = (b, a), hessian.swapaxes(1, 2)
                found[pair] = found.get(pair, 0.0) + weight * hessian
        return found

    def neighbours(self, step: Period) -> Neighbours:
        found: Neighbours = {}
        for term, weight in self.terms:
            for one, (pairs, bent) in term.neighbours(step).items():
                before = [found[one]] if one in found else []
                parts = [*before, (pairs, weight * bent)]
                found[one] = (
                    np.concatenate([part[0] for part in parts]),
                    np.concatenate([part[1] for part in parts]),
                )
        return found
