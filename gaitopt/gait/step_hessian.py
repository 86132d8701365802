"""Exact second derivatives of any weighted sum of a step's quantities.

The chain rule in two levels (docs/derivations.md): at each instant the local Hessian in
(q, dq, ddq), mapped by the motion's slope; then the curvature of the spline coefficients
themselves, which the weights reach through the impact and through the inverse kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gaitopt.gait.parameters import DURATION
from gaitopt.gait.step import Reads, Step, StepSlope
from gaitopt.gait.step_model import StepModel
from gaitopt.mechanics.feet import corner_curvature
from gaitopt.nlp import Array


@dataclass(frozen=True)
class StepWeights:
    """First and second derivatives of a function of a step's quantities.

    Attributes:
        first: of each quantity, shape (K, entries).
        second: of each quantity, shape (K, entries, entries).
    """

    first: dict[Reads, Array]
    second: dict[Reads, Array]

    @classmethod
    def zero(cls, step: Step) -> StepWeights:
        """Return zero weights in the shapes of a step."""
        quantities = {what: step.read(what) for what in Reads}
        return cls(
            {what: np.zeros(q.shape) for what, q in quantities.items()},
            {what: np.zeros((*q.shape, q.shape[1])) for what, q in quantities.items()},
        )


def step_hessian(model: StepModel, step: Step, slope: StepSlope, weights: StepWeights) -> Array:
    """Return the Hessian in x of the function that `weights` differentiates, shape (P, P)."""
    local, pull = _local(slope, weights)
    motion = slope.motion
    size = motion.shape[2]
    H = motion.reshape(-1, size).T @ (local @ motion).reshape(-1, size)
    for what in (Reads.IMPULSE, Reads.SOLE_TWIST, Reads.LEGS, Reads.TRAVEL):
        if weights.second[what].any():
            jac = slope.reads[what]
            H += (jac.swapaxes(1, 2) @ weights.second[what] @ jac).sum(axis=0)
    H += _coefficient_curvature(model, step, slope, weights, pull)
    return (H + H.T) / 2.0


def _local(slope: StepSlope, weights: StepWeights) -> tuple[Array, Array]:
    """Local Hessian in (q, dq, ddq), shape (N, 36, 36), and local gradient, shape (N, 36)."""
    support = slope.support
    count = support.effort.shape[0]
    first, second = weights.first, weights.second
    effort = np.concatenate([first[Reads.WRENCH], first[Reads.TORQUE]], axis=1)
    corners = first[Reads.CORNERS].reshape(count, 4, 3)
    pull = (effort[:, None] @ support.effort)[:, 0]
    pull[:, :12] += np.einsum("nck,nckj->nj", corners, support.corners) + first[Reads.ANGLES]
    pull[:, 12:24] += first[Reads.RATES]

    bend = np.zeros((count, 18, 18))
    bend[:, :6, :6], bend[:, 6:, 6:] = second[Reads.WRENCH], second[Reads.TORQUE]
    local = support.effort.swapaxes(1, 2) @ (bend @ support.effort)
    torque = support.curvature(effort)
    local[:, :12, :12] += torque.qq + corner_curvature(support.axes, support.corners, corners)
    local[:, :12, 12:24] += torque.qv
    local[:, 12:24, :12] += torque.qv.swapaxes(1, 2)
    local[:, 12:24, 12:24] += torque.vv
    local[:, :12, 24:] += torque.qa
    local[:, 24:, :12] += torque.qa.swapaxes(1, 2)
    for what, reading in slope.optional.items():
        jac = reading.jacobian
        pull[:, :12] += (first[what][:, None] @ jac)[:, 0]
        local[:, :12, :12] += reading.curvature(first[what])
        if second[what].any():
            local[:, :12, :12] += jac.swapaxes(1, 2) @ second[what] @ jac
    return local, pull


def _coefficient_curvature(
    model: StepModel, step: Step, slope: StepSlope, weights: StepWeights, pull: Array
) -> Array:
    """Curvature of the map from x to the motion, weighted by the local gradient `pull`."""
    layout, E = model.layout, model.robot.mirror
    by_sample = pull.reshape(-1, 12)
    width = step.coefficients.shape[0]
    on_coefficients = model.basis.at(step.duration).reshape(-1, width).T @ by_sample
    q_weights = on_coefficients[0] + E.T @ on_coefficients[-3]
    after = np.concatenate(
        [
            weights.first[Reads.SOLE_TWIST][0],
            E.T @ on_coefficients[-2],
            weights.first[Reads.IMPULSE][0],
        ]
    )
    q_weights = q_weights + E.T @ (slope.impact.posture.T @ after)

    H = np.zeros((layout.size, layout.size))
    bend = model.impact_curvature.hessian(
        E @ step.posture.q_start, step.rate_before, step.impact, slope.impact, after
    )
    inputs = np.concatenate([slope.coefficients[-3], slope.coefficients[-1]])
    H += inputs.T @ bend @ inputs
    first = weights.first
    posture = model.boundary.curvature(
        step.posture, slope.posture, q_weights, first[Reads.LEGS], first[Reads.GAPS]
    )
    own = layout.boundary_columns
    H[layout.boundary, layout.boundary] += posture[np.ix_(own, own)]
    column = layout.index("duration")
    if column is not None:
        H += _duration_curvature(model, step, slope, by_sample, column)
    return H


def _duration_curvature(
    model: StepModel, step: Step, slope: StepSlope, by_sample: Array, column: int
) -> Array:
    """Terms of the spline map's dependence on the step duration T."""
    width, T = step.coefficients.shape[0], step.geometry[DURATION]
    first = model.basis.at(T, 1).reshape(-1, width).T @ by_sample
    second = model.basis.at(T, 2).reshape(-1, width).T @ by_sample
    H = np.zeros((model.layout.size, model.layout.size))
    H[column] = np.einsum("mj,mjp->p", first, slope.coefficients)
    H += H.T
    H[column, column] += float(np.sum(second * step.coefficients))
    return H
