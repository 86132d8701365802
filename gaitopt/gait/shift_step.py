"""A first step from rest: the weight moves over one foot while both stand, then the other swings.

    x -> posture as the foot leaves -> stance leg -> closed chain -> rates as it leaves -> swing leg

Until the foot leaves the ground the robot is one closed chain (`mechanics/closed_chain.py`): the
stance leg moves as it is told, the leg that will swing is where its sole rests, and takes a wrench
that is a cubic of time in Bernstein's form, from that of a robot at rest to nothing. The stance leg
follows one spline over the whole step, whose first acceleration is zero, so that neither torques
nor forces jump as the robot begins to move. The other leg follows a spline of its own from where it
is let go, at rest on the ground.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import field, replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.contact import AFTER, Schedule
from gaitopt.dataclass import dataclass
from gaitopt.gait.double_support import Posture
from gaitopt.gait.grid import Grid
from gaitopt.gait.parameters import DURATION, KNOT_SCALE, Chart, Layout, wrench_scale
from gaitopt.gait.quantities import Quantity
from gaitopt.gait.spline import SplineBasis, SplineInX, bernstein, on_coefficients, spline_basis
from gaitopt.gait.step import DoubleSupportPart, ShapedTurn, Step, StepDerivatives
from gaitopt.gait.step_model import Course, Landing, Opening, StepModel
from gaitopt.mechanics.closed_chain import FREE, ClosedChain, ClosedMotion
from gaitopt.mechanics.inverse_dynamics_hessian import InverseDynamicsHessian
from gaitopt.mechanics.inverse_kinematics import LegKinematics
from gaitopt.model.joint_tree import TWIST
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.model.scales import Scales
from gaitopt.nlp import Array

SIZE = 3 * TWIST
"""Parameters of a shift: a posture of the stance leg, and two control points of the wrench."""
_PARTS = tuple(f"{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz")
_KNOTS = np.array([0.0, 1.0, 2.0]) / 3.0  # of the shift; then it ends
_DETERMINED, _POSTURE = 1, 2  # knots: by the acceleration at rest, and by the parameters
_LEAVES = 1e-9  # share of the swing: instants this near to the one at which the foot leaves are it
_NOTHING = np.zeros((0, TWIST))  # what places the sole that rests: nothing in x does


@dataclass(frozen=True, eq=False)
class Shift:
    """How a first step begins with both feet on the ground.

    Attributes:
        share: of the step, in which both stand.
        entries: of its parameters in x.
        q: joint angles at rest (n,) [rad].
        ends: wrench of the ground on the foot that will swing as it begins and as it ends, in its
            sole frame, shape (2, 6) [N, N·m].
    """

    share: float
    entries: slice
    q: Array
    ends: Array


def while_shifting(grid: Grid, share: float) -> NDArray[np.bool_]:
    """Return at which instants of a step both feet stand, which they do up to a share of it."""
    return np.asarray(grid.instants <= share + 0.5 * AFTER)


def shift_names(joint_names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of the parameters of a shift."""
    leg = [f"shift_{joint}" for joint in joint_names[:TWIST]]
    return (*leg, *(f"shift_foot_{part}_{k}" for k in (1, 2) for part in _PARTS))


def shift_scale(scales: Scales) -> Array:
    """Return the size of a sensible step of the parameters of a shift, shape (SIZE,)."""
    wrench = wrench_scale(scales)
    return np.concatenate([np.full(TWIST, KNOT_SCALE), wrench, wrench])


def starting_still(basis: SplineBasis) -> SplineBasis:
    """Return the basis of splines that begin without acceleration.

    The value at the second knot is what that makes it; its coefficient counts no more.
    """
    first = spline_basis(basis.knots, np.zeros(1)).unit[0, 2]
    by_others = -first / first[_DETERMINED]
    unit = basis.unit + basis.unit[:, :, [_DETERMINED]] * by_others
    return replace(basis, unit=unit)


@dataclass(frozen=True)
class ShiftPart(DoubleSupportPart):
    """The double support that begins a step; as of `DoubleSupportPart`, whose touch-down is rest.

    Attributes:
        swing: control points of the wrench on the foot that will swing, shape (4, 6).
        free: coefficients of the stance leg's spline over the whole step, shape (K, 6).
    """

    free: Array = field(kw_only=True)

    @property
    def opens(self) -> bool:
        return True


@dataclass(frozen=True)
class _ShiftOpening(Opening):
    """The double support as the foot leaves, and the parameters of the shift (SIZE,)."""

    shift: Array


class ShiftStepModel(StepModel):
    """Evaluates first steps that begin with a shift of the weight, among those that follow."""

    def __init__(
        self,
        robot: Robot,
        layout: Layout,
        grid: Grid,
        optional: Collection[Quantity],
        schedule: Schedule,
        chart: Chart,
        shift: Shift,
    ) -> None:
        """Prepare what does not depend on x; arguments as of `StepModel`, and the shift."""
        super().__init__(robot, layout, grid, optional, schedule, chart)
        self.shift, s = shift, shift.share
        self.both = while_shifting(grid, s)
        inner = self.basis.knots
        swinging = np.clip((grid.instants - s) / (1.0 - s), 0.0, 1.0)
        swinging[swinging < _LEAVES] = 0.0
        self.basis = spline_basis(inner, swinging)
        self.knots = np.concatenate([s * _KNOTS, s + (1.0 - s) * inner])
        until = np.minimum(grid.instants[self.both], s)
        self._free = starting_still(spline_basis(self.knots, until))
        self._leaving = starting_still(spline_basis(self.knots, np.array([s])))
        self._at_knots = starting_still(spline_basis(self.knots, s * np.append(_KNOTS, 1.0)))
        self._shares = bernstein(until / s)
        self.sole: pin.SE3 = LegKinematics(robot).placements(shift.q)[1]
        still = np.zeros(TWIST)
        self._rest = self._closed(np.stack([shift.q[FREE], still, still])[:, None])

    @property
    def closed(self) -> ClosedChain:
        """The closed chain of the robot."""
        return cached_workspace(self.robot, ClosedChain)

    def opening(self, x: Array, posture: Posture | None = None) -> Opening:
        found = super().opening(x, posture)
        return _ShiftOpening(found.z, found.geometry, found.posture, x[self.shift.entries])

    def _closed(self, free: Array) -> ClosedMotion:
        motion, axes = self.closed.motion(np.ascontiguousarray(free), self.sole)
        return ClosedMotion(motion, axes, _NOTHING, np.zeros((0, 0)))

    def _course(self, opening: Opening, ending: Landing, before: Landing) -> Course:
        del before  # it begins at rest
        assert isinstance(opening, _ShiftOpening)
        z, T, n = opening.z, float(opening.geometry[DURATION]), self.layout.joints
        q, knots = opening.posture.q_start, z[self.layout.knots].reshape(-1, n)
        free = np.zeros((self.knots.size + 2, TWIST))
        free[0], free[_POSTURE] = self.shift.q[FREE], opening.shift[:TWIST]
        free[3:-2] = np.vstack([q, knots, ending.q_end])[:, FREE]
        free[-1] = ending.rate_before[FREE]
        leaves = self._closed((self._leaving.at(T) @ free).swapaxes(0, 1))
        closed = self._closed((self._free.at(T) @ free).swapaxes(0, 1))
        coefficients = np.vstack([q, knots, ending.q_end, leaves.motion[1, 0], ending.rate_before])
        motion = self._motion(coefficients, opening.geometry)
        motion[:, self.both] = closed.motion
        first, last = self.shift.ends
        points = np.vstack([first, opening.shift[TWIST:].reshape(2, TWIST), last])
        wrench = self._shares @ points
        front = np.zeros((self.grid.count, TWIST))
        front[self.both] = wrench
        part = ShiftPart(closed, self._rest, leaves, self.sole, wrench, points, front, free=free)
        return Course(coefficients, motion, np.zeros((3, self.grid.count, 0)), double=part)

    def _motion(self, coefficients: Array, geometry: Array) -> Array:
        motion = self.basis.at((1.0 - self.shift.share) * float(geometry[DURATION])) @ coefficients
        return np.ascontiguousarray(motion.swapaxes(0, 1))

    def swing_duration(self, step: Step) -> float:
        return (1.0 - self.shift.share) * step.duration

    def sampled(self, step: Step) -> tuple[NDArray[np.int_], Array]:
        """Return the nodes after the foot has left, and their times since then; as `StepModel`."""
        nodes = np.arange(self.grid.nodes)
        nodes = nodes[~self.both[nodes]]
        return nodes, self.basis.instants[nodes] * self.swing_duration(step)

    def points(self, step: Step) -> Array:
        """Return the control points of the wrench on the foot that will swing, shape (4, 6)."""
        return _part(step).swing

    def splines(self, step: Step) -> tuple[Array, Array]:
        """Return knots [s] (m,) and coefficients (m + 2, n) of the joints while both feet stand.

        The leg that will swing is near its splines, exact at the knots and in its last rates.
        """
        part = _part(step)
        free = (self._at_knots.at(step.duration) @ part.free).swapaxes(0, 1)
        motion = self._closed(free).motion
        times = self.knots[: len(_KNOTS) + 1] * step.duration
        return times, np.concatenate([motion[0], motion[1, [0, -1]]])

    def _motion_jacobian(
        self, step: Step, coefficients: Array, turns: tuple[ShapedTurn, ...]
    ) -> Array:
        del turns  # the foot stands flat
        part = _part(step)
        swing, free, _ = self._in_x(step, part, coefficients)
        found = _by_instant(swing.motion())
        found[self.both] = part.motion.jacobian @ _by_instant(free.motion())
        return found

    def _in_x(
        self, step: Step, part: ShiftPart, coefficients: Array
    ) -> tuple[SplineInX, SplineInX, SplineInX]:
        """All joints' splines in the swing; the stance leg's before it, and as the foot leaves.

        Args:
            coefficients: derivatives of the swing's, (K, n, P); none of the rates as it begins.
        """
        T, s, n, lasts = step.duration, self.shift.share, self.layout.joints, self.along("duration")
        along = self._free_jacobian(coefficients)
        free, leaving = (
            SplineInX(basis, T, part.free, along, lasts) for basis in (self._free, self._leaving)
        )
        own = coefficients.copy()
        own[-2] = (part.liftoff.jacobian[0] @ _by_instant(leaving.motion())[0])[n : 2 * n]
        swings = None if lasts is None else (1.0 - s) * lasts
        swing = SplineInX(self.basis, self.swing_duration(step), step.coefficients, own, swings)
        return swing, free, leaving

    def _free_jacobian(self, coefficients: Array) -> Array:
        """Derivatives of the stance leg's coefficients, (K, 6, P), from those of the swing."""
        P = coefficients.shape[-1]
        free = np.zeros((self.knots.size + 2, TWIST, P))
        first = self.shift.entries.start
        free[_POSTURE] = np.eye(P)[first : first + TWIST]
        free[3:-2], free[-1] = coefficients[:-2, FREE], coefficients[-1, FREE]
        return free

    def _wrench_jacobian(self, size: int) -> Array:
        """Derivatives of the wrench on the other foot while both stand, (M, 6, P)."""
        first = self.shift.entries.start + TWIST
        points = np.eye(size)[first : first + 2 * TWIST].reshape(2, TWIST, size)
        return np.asarray(np.einsum("mb,bjp->mjp", self._shares[:, 1:3], points))

    def _effort_jacobian(self, step: Step, effort: Array, motion: Array) -> Array:
        found, part = super()._effort_jacobian(step, effort, motion), _part(step)
        P = motion.shape[2]
        angles = motion[self.both, : self.layout.joints]
        found[self.both] -= part.foot.jacobian(angles, np.zeros((0, P)), self._wrench_jacobian(P))
        return found

    def _front_jacobian(self, size: int) -> Array:
        found = np.zeros((self.grid.count, TWIST, size))
        found[self.both] = self._wrench_jacobian(size)
        return found

    def on_coefficients(self, step: Step, by_order: Array) -> Array:
        # the rates as the foot leaves, which follow, have no weights
        on_swing, at_free, leaving = self._weights(step, by_order)
        free = on_coefficients(self._free, step.duration, at_free)
        free += on_coefficients(self._leaving, step.duration, leaving)
        on_swing[-2] = 0.0
        on_swing[:-2, FREE] += free[3:-2]
        on_swing[-1, FREE] += free[-1]
        return on_swing

    def _weights(self, step: Step, by_order: Array) -> tuple[Array, Array, Array]:
        """Weights of the swing's coefficients (k + 4, n), and of (u, du, ddu), (M, 3, 6) each.

        Those while both feet stand, and as the foot leaves.
        """
        part, n = _part(step), self.layout.joints
        alone = by_order * ~self.both[:, None, None]
        on_swing = on_coefficients(self.basis, self.swing_duration(step), alone)
        flat = by_order[self.both].reshape(-1, 1, 3 * n)
        at_free = (flat @ part.motion.jacobian).reshape(-1, 3, TWIST)
        rates = np.zeros((1, 1, 3 * n))
        rates[0, 0, n : 2 * n] = on_swing[-2]
        leaving = (rates @ part.liftoff.jacobian).reshape(1, 3, TWIST)
        return on_swing, at_free, leaving

    def add_front_gradient(
        self, step: Step, derivatives: StepDerivatives, effort: Array, by_order: Array
    ) -> None:
        by_order[self.both, 0] += self._taken(step, derivatives.motion, effort)[0]

    def _taken(self, step: Step, motion: Array, effort: Array) -> tuple[Array, Array]:
        part, n, P = _part(step), self.layout.joints, motion.shape[-1]
        by_x = self._wrench_jacobian(P)
        angles = motion[self.both, :n]
        return part.foot.hessian(angles, np.zeros((0, P)), by_x, -effort[self.both])

    def motion_hessian(
        self,
        step: Step,
        derivatives: StepDerivatives,
        local: InverseDynamicsHessian,
        by_order: Array,
        effort: Array,
    ) -> Array:
        part, motion, n = _part(step), derivatives.motion, self.layout.joints
        H = local.through(motion) + self._taken(step, motion, effort)[1]
        on_swing, at_free, at_leaving = self._weights(step, by_order)
        swing, free, leaving = self._in_x(step, part, derivatives.coefficients)
        flat = by_order[self.both].reshape(-1, 3 * n)
        along = _by_instant(free.motion())
        H += np.tensordot(along, part.motion.hessian(flat) @ along, ((0, 1), (0, 1)))
        rates = np.zeros((1, 3 * n))
        rates[0, n : 2 * n] = on_swing[-2]
        leaves = _by_instant(leaving.motion())
        H += np.tensordot(leaves, part.liftoff.hessian(rates) @ leaves, ((0, 1), (0, 1)))
        H += swing.hessian(by_order * ~self.both[:, None, None])
        return np.asarray(H + free.hessian(at_free) + leaving.hessian(at_leaving))


def _part(step: Step) -> ShiftPart:
    part = step.double
    assert isinstance(part, ShiftPart)
    return part


def _by_instant(moved: Array) -> Array:
    """Derivatives (N, 3, j, P) of a motion as those of one vector at each instant, (N, 3 j, P)."""
    return moved.reshape(len(moved), -1, moved.shape[3])
