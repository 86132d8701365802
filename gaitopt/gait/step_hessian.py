"""Exact second derivatives of any weighted sum of a step's quantities.

The chain rule in two levels (docs/derivations.md): at each instant the local Hessian in
(q, dq, ddq), mapped by the motion's Jacobian; then the second derivatives of the spline's
coefficients, which the weights reach through the impact and through the inverse kinematics.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.step import Period, Step, StepDerivatives
from gaitopt.gait.step_model import StepModel
from gaitopt.mechanics.impact import WeightedImpact
from gaitopt.mechanics.inverse_dynamics_hessian import DynamicsHessian, InverseDynamicsHessian
from gaitopt.mechanics.spatial import force_cross_matrix, motion_cross_matrix
from gaitopt.model.robot import cached_workspace
from gaitopt.nlp import Array

Indices = NDArray[np.int_]


@dataclass(frozen=True)
class StepWeights:
    """First and second derivatives of a function of a step's quantities.

    Attributes:
        first: of each quantity, shape (K, entries).
        second: of the pairs of quantities (a, b) that have some, each pair once, shape (K, entries
            of a, entries of b); where b has a single row, it goes with each of the K rows of a.
    """

    first: dict[Quantity, Array]
    second: dict[tuple[Quantity, Quantity], Array]

    @classmethod
    def zero(cls, step: Period) -> StepWeights:
        """Return zero weights of a step; a pair without second ones has no entry there."""
        values = step.values
        return cls({one: np.zeros(values[one].shape) for one in quantities.ALL}, {})

    def add(
        self, reads: tuple[Quantity, ...], rows: Indices | slice, first: Array, second: Array | None
    ) -> None:
        """Add the derivatives of a function of several quantities side by side.

        Args:
            rows: of each of them.
            first: shape (k, entries of all).
            second: shape (k, entries of all, entries of all), None for zero.
        """
        if len(reads) == 1:  # nearly all of them: nothing to be cut apart
            self.first[reads[0]][rows] += first
            if second is not None:
                self.add_second((reads[0], reads[0]), rows, second)
            return
        parts = quantities.columns(reads, self.first)
        for i, (one, own) in enumerate(parts):
            self.first[one][rows] += first[:, own]
            if second is not None:
                for other, columns in parts[i:]:
                    self.add_second((one, other), rows, second[:, own, columns])

    def add_second(
        self, pair: tuple[Quantity, Quantity], rows: Indices | slice, second: Array
    ) -> None:
        """Add second derivatives (k, entries of a, entries of b) of a pair at some rows of a."""
        a, b = pair
        if (b, a) in self.second and a is not b:
            pair, (a, b), second = (b, a), (b, a), second.swapaxes(1, 2)
        if pair not in self.second:
            shape = *self.first[a].shape, self.first[b].shape[1]
            if second.shape == shape:  # at all rows
                self.second[pair] = second.copy()
                return
            self.second[pair] = np.zeros(shape)
        self.second[pair][rows] += second


@dataclass(frozen=True)
class StepAdjoint:
    """What a weighted sum of a step's quantities weighs on the way back to x.

    Attributes:
        effort: weights of wrench, of the hinge's torque where there is one, and of the torques,
            shape (N, 6 + h + n).
        by_order: derivative in (q, dq, ddq) at the instants, the foot's turn in front of each,
            shape (N, 3, h + n).
        q_start: weights of the posture at the start through spline and impact, shape (n,).
        impact: the impact with its weights.
        after_flat: weights of the rates after an impact by which the foot comes to lie flat, (n,);
            they are such where there is one.
    """

    effort: Array
    by_order: Array
    q_start: Array
    impact: WeightedImpact
    after_flat: Array


def step_adjoint(
    model: StepModel, step: Step, derivatives: StepDerivatives, first: dict[Quantity, Array]
) -> StepAdjoint:
    """Return what the weights `first` of the step's quantities weigh on the way back to x."""
    return cycle_adjoint((model,), (step,), (derivatives,), (first,))[0]


def cycle_adjoint(
    models: Sequence[StepModel],
    steps: Sequence[Step],
    derivatives: Sequence[StepDerivatives],
    weights: Sequence[dict[Quantity, Array]],
    repeats: bool = True,
) -> list[StepAdjoint]:
    """Return what weights of steps that follow each other weigh on the way back to x.

    Args:
        models, steps, derivatives: as of `gaitopt.gait.step_model.cycle_derivatives`.
        weights: of the quantities of each step.
        repeats: whether the first step follows the last again; else both their ends are given.
    """
    count, each = len(models), list(zip(models, steps, derivatives, weights, strict=True))
    gradients = [_step_gradient(*one) for one in each]
    maps, turns = [gradient[2] for gradient in gradients], [gradient[3] for gradient in gradients]
    starts = [one[-2] if k or repeats else np.zeros_like(one[-2]) for k, one in enumerate(maps)]
    ends = [
        _impact_vjp(*one, starts[(k + 1) % count], turns[(k + 1) % count])
        for k, one in enumerate(each)
    ]
    found = []
    for k, (effort, by_order, on_joints, _) in enumerate(gradients):
        q_start = on_joints[0]
        if k or repeats:
            at_end = maps[(k - 1) % count][-3] + ends[(k - 1) % count][0]
            q_start = q_start + models[k].exchange.T @ at_end
        found.append(StepAdjoint(effort, by_order, q_start, ends[k][1], on_joints[-4]))
    return found


def _step_gradient(
    model: StepModel, step: Step, derivatives: StepDerivatives, first: dict[Quantity, Array]
) -> tuple[Array, Array, Array, list[Array]]:
    """Weights of effort, (q, dq, ddq), the spline's coefficients (k + 4, n), and turns."""
    effort = weighed_effort(step, first)
    gradient = local_gradient(derivatives, first, effort, step.hinges)
    by_order = gradient.reshape(len(effort), 3, -1)
    model.add_front_gradient(step, derivatives, effort, by_order)
    on_joints = model.on_coefficients(step, by_order)
    return effort, by_order, on_joints, _turn_weights(step, derivatives, by_order)


def weighed_effort(step: Step, first: dict[Quantity, Array]) -> Array:
    """Return the weights of wrench, hinges and torques, shape (N, 6 + h + n)."""
    wrench, torque = first[quantities.WRENCH], first[quantities.TORQUE]
    of_hinge = np.zeros((len(torque), step.hinges))  # its torque is part of the wrench
    return np.concatenate([wrench, of_hinge, torque] if step.hinges else [wrench, torque], axis=1)


def pairs_added(H: Array, weights: StepWeights, jacobians: dict[Quantity, Array]) -> Array:
    """Return H with the second derivatives in pairs of quantities.

    Args:
        H: the rest of the Hessian, shape (P, P).
        weights: of the quantities.
        jacobians: of the quantities in x, shape (K, entries, P).
    """
    for (a, b), second in weights.second.items():
        left, right = jacobians[a], jacobians[b]
        if a is b:
            H = H + _quadratic(second, left)
            continue
        if len(right) == 1:  # it goes with each row of a, so that these are added first
            by_b = left.reshape(-1, len(H)).T @ second.reshape(-1, second.shape[2]) @ right[0]
        else:
            by_b = left.reshape(-1, len(H)).T @ (second @ right).reshape(-1, len(H))
        H = H + by_b + by_b.T
    return (H + H.T) / 2.0


def _quadratic(second: Array, jacobian: Array) -> Array:
    """Return the sum over rows of J' S J, shape (P, P), of S (K, e, e) and J (K, e, P)."""
    if len(second) == 1:
        return np.asarray(jacobian[0].T @ second[0] @ jacobian[0])
    width, own = jacobian.shape[-1], second.diagonal(axis1=1, axis2=2)
    if np.count_nonzero(second) == np.count_nonzero(own) and own.min(initial=0.0) >= 0.0:
        # as of squared torques: a product with its own transpose is half the work
        rooted = (np.sqrt(own)[:, :, None] * jacobian).reshape(-1, width)
        return np.asarray(rooted.T @ rooted)
    bent, used = second.any(axis=(1, 2)), second.any(axis=(0, 1))
    if not (bent.all() and used.all()):  # as of a limit that is met at few instants
        second, jacobian = second[bent][:, used][:, :, used], jacobian[bent][:, used]
    return np.asarray(jacobian.reshape(-1, width).T @ (second @ jacobian).reshape(-1, width))


def cycle_hessian(
    models: Sequence[StepModel],
    steps: Sequence[Step],
    derivatives: Sequence[StepDerivatives],
    weights: Sequence[dict[Quantity, Array]],
    repeats: bool = True,
) -> Array:
    """Return the Hessian in x of weights . (quantities) of steps that follow each other, (P, P).

    Args:
        models, steps, derivatives: as of `gaitopt.gait.step_model.cycle_derivatives`.
        weights: of the quantities of each step.
        repeats: whether the first step follows the last again.
    """
    backs = cycle_adjoint(models, steps, derivatives, weights, repeats)
    each = zip(models, steps, derivatives, weights, backs, strict=True)
    H = sum((_own_hessian(*one) for one in each), np.zeros(()))
    return np.asarray((H + H.T) / 2.0)


def _own_hessian(
    model: StepModel,
    step: Step,
    derivatives: StepDerivatives,
    first: dict[Quantity, Array],
    back: StepAdjoint,
) -> Array:
    """What a step, its impact and its double support bend, shape (P, P)."""
    matrix, effort, impact = model.chart.matrix, back.effort, back.impact
    jacobians = derivatives.jacobians
    if step.hinges:
        dynamics = derivatives.support.hessian(effort)
        at_impact = cached_workspace(model.robot, DynamicsHessian).of(impact.dynamics)
    else:  # the impact's single posture costs little more in one sweep with the others than nothing
        dynamics, at_impact = derivatives.support.hessians(effort, impact.dynamics)
    local = local_hessian(derivatives, first, dynamics)
    H = model.motion_hessian(step, derivatives, local, back.by_order, effort)
    inputs = np.concatenate([derivatives.coefficients[-3], derivatives.coefficients[-1]])
    if step.turn is not None:
        rate = matrix[model.layout.turn.stop - 1]
        inputs = np.concatenate([inputs, np.outer(step.turn.hinge.twist, rate)])
        across, angle = motion_cross_matrix(step.turn.hinge.twist), matrix[model.layout.turn.start]
        weights, slopes = (table[quantities.SOLE_TWIST][0] for table in (first, jacobians))
        H += _turned_hessian(across, angle, weights, step.sole_twist, slopes)
    if step.landed is not None:
        across = force_cross_matrix(step.landed.hinge.twist)
        weights, slopes = (table[quantities.IMPULSE][0] for table in (first, jacobians))
        H += _turned_hessian(across, derivatives.landing_angle, weights, step.impulse, slopes)
    own = model.beyond_knots
    inputs, boundary = inputs[:, own], model.at_start[:, own]
    H[own, own] += inputs.T @ impact.hessian(at_impact) @ inputs
    if step.flat is not None:
        pushed = first[quantities.REAR_IMPULSE][0]
        bent = model.flat_impact.hessian(step.flat, back.after_flat, pushed)
        H += model.at_flat.T @ bent @ model.at_flat
    at_start = model.start_hessian(step, derivatives, back.q_start, first)
    H[own, own] += boundary.T @ at_start @ boundary
    return H


def _turned_hessian(
    across: Array, angle: Array, weights: Array, values: Array, slopes: Array
) -> Array:
    """What a turn of the sole's axes adds to weights . values of the footprint, shape (P, P).

    With X the turn and S its axis, d X V = S x (X V) d angle + X dV; of forces with S x*.

    Args:
        across: S x or S x*, shape (6, 6).
        angle: derivatives of the turn, shape (P,).
        weights, values: shape (6,).
        slopes: derivatives of the values, shape (6, P).
    """
    H = np.outer(angle, weights @ across @ slopes)
    twice = float(weights @ across @ across @ values)
    return H + H.T - twice * np.outer(angle, angle)  # which is in either of the two


def _turn_weights(step: Step, derivatives: StepDerivatives, by_order: Array) -> list[Array]:
    """What the local gradient (N, 3, h + n) is worth in what shapes each turn, shape (p,)."""
    return [
        np.tensordot(by_order[:, :, number], one.turn.basis.at(step.duration), 2)
        @ one.turn.coefficients
        for number, one in enumerate(derivatives.turns)
    ]


def local_gradient(
    derivatives: StepDerivatives, first: dict[Quantity, Array], effort: Array, hinges: int
) -> Array:
    """Return the gradient in (q, dq, ddq), the foot's turn before each, (N, 3 (h + n))."""
    support = derivatives.support
    n = support.corners.shape[-1]
    corners = support.corners.reshape(len(effort), -1, n)
    gradient = (effort[:, None] @ support.effort)[:, 0]
    gradient[:, :n] += (first[quantities.CORNERS][:, None] @ corners)[:, 0]
    gradient[:, hinges:n] += first[quantities.ANGLES]
    for hinge in range(hinges):
        gradient[:, hinge::n] += first[quantities.FOOT_TURN]
    gradient[:, n + hinges : 2 * n] += first[quantities.RATES]
    gradient[:, 2 * n + hinges :] += first[quantities.ACCELERATIONS]
    for what, reading in derivatives.optional.items():
        if first[what].any():
            gradient[:, :n] += reading.vjp(first[what])
    return np.asarray(gradient)


def local_hessian(
    derivatives: StepDerivatives, first: dict[Quantity, Array], effort: InverseDynamicsHessian
) -> InverseDynamicsHessian:
    """Return the second derivatives in (q, dq, ddq), the foot's turn before each.

    Args:
        first: weights of its quantities.
        effort: second derivatives of the weighted effort.
    """
    support = derivatives.support
    corners = first[quantities.CORNERS].reshape(len(support.effort), 4, 3)
    qq = effort.qq + support.corner_hessian(corners)
    for what, reading in derivatives.optional.items():
        if first[what].any():
            qq += reading.hessian(first[what])
    return InverseDynamicsHessian(qq, effort.qv, effort.vv, effort.qa, effort.base)


def _impact_vjp(
    model: StepModel,
    step: Step,
    derivatives: StepDerivatives,
    first: dict[Quantity, Array],
    on_next_start: Array,
    on_next_turns: list[Array],
) -> tuple[Array, WeightedImpact]:
    """What the weights reach through an impact: the posture there (n,), and the impact itself.

    Args:
        model, step, derivatives, first: of the step that it ends, and its weights.
        on_next_start: weights of the rates at the start of the next step, shape (n,).
        on_next_turns: of what shapes its turns; the last of the first is the rate after a landing
            on a line.
    """
    E = model.exchange
    of_twist, turn = first[quantities.SOLE_TWIST][0], step.turn
    if turn is not None:
        of_twist = turn.place.toActionMatrix().T @ of_twist
    of_impulse, slopes = first[quantities.IMPULSE][0], derivatives.impact
    assert slopes is not None
    parts = [of_twist, E.T @ on_next_start, of_impulse]
    if step.landed is not None:
        parts = [*parts[:2], step.landed.on_ground.T @ of_impulse, on_next_turns[0][-1:]]
    after = np.concatenate(parts)
    impact = model.impact.weighted(
        step.q_end, step.rate_before, step.impact, slopes, after,
        None if turn is None else turn.twist,
    )  # fmt: skip
    return slopes.posture.T @ after, impact
