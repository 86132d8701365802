"""The in-house Newton-Euler algorithm judges a step that Pinocchio evaluated.

Another implementation, another geometry (modified Denavit-Hartenberg), and conservation laws that
neither was built from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from gaitopt.contact.schedule import Schedule, Symmetry
from gaitopt.dataclass import dataclass
from gaitopt.gait import quantities
from gaitopt.gait.grid import Grid
from gaitopt.gait.step import Step
from gaitopt.mechanics.chain_build import chain_of_robot, loads_of_robot
from gaitopt.mechanics.closed_impact import ClosedJump
from gaitopt.mechanics.foot_flat import FlatJump
from gaitopt.mechanics.hinged import standing_robot
from gaitopt.mechanics.mdh_chain import Chain, sole_placement, turned
from gaitopt.mechanics.newton_euler import (
    at_rest,
    base_in_sole_axes,
    foot_twist,
    impact,
    impulse_on_foot,
    inverse_dynamics,
    momentum,
    motor_effort,
    sole_axes,
    swing_jacobian,
    wrench_on_ground,
)
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

LEAST = 1e-3  # share of a quantity's natural size below which differences are relative to that


@dataclass(frozen=True)
class RefereeVerdict:
    """Disagreements; relative ones to the largest entry of what is compared.

    Attributes:
        torque, wrench: inverse dynamics at every instant, relative.
        impulse, rate_after: impact, relative.
        sole_twist: twist of the old stance foot after the impact, and of a front foot that stands
            [m/s, rad/s].
        posture: q(0) and E q(T), Eq. (26) [rad]; with it the place of a front foot that stands [m].
        rate: dq(0) and E times the rates after impact, Eq. (27), relative; with them the rate at
            which a foot that landed on a line turns about it.
        momentum: ground force over the step plus impact impulse against the weight's impulse
            m g T and the change of the robot's momentum, largest component, relative to m g T.
        vertical: integral of the vertical ground force plus the vertical impulse [N·s].
        weight: m g T [N·s], without weight that is carried from outside; on a slope its part along
            the ground's normal, as `vertical` is.
    """

    torque: float
    wrench: float
    impulse: float
    rate_after: float
    sole_twist: float
    posture: float
    rate: float
    momentum: float
    vertical: float
    weight: float

    @property
    def worst(self) -> float:
        """Largest disagreement, the momentum balance apart (it carries a quadrature error)."""
        return max(
            self.torque, self.wrench, self.impulse, self.rate_after, self.sole_twist,
            self.posture, self.rate,
        )  # fmt: skip


def ask_referee(
    robot: Robot,
    step: Step,
    grid: Grid,
    schedule: Schedule | None = None,
    starts: tuple[Step, Step] | None = None,
) -> RefereeVerdict:
    """Compare a step with the referee's own computation.

    Args:
        robot: the robot.
        step: a step evaluated on `grid`.
        grid: fine enough for the momentum balance; all its instants are quadrature nodes.
        schedule: of the step; by default that of the paper.
        starts: this step and the one after it, there exchanged, each at instants of which its
            start is the first; by default the step is followed by itself.
    """
    schedule, starts = schedule or Schedule(), starts or (step, step)
    after = starts[1]
    standing = standing_robot(robot, *schedule.contacts)
    chain = chain_of_robot(standing)
    loads = loads_of_robot(standing, chain)
    gravity: Array = np.array(robot.model.gravity.linear)
    coupled = standing.coupling.motion(step.whole_motion)
    motion = coupled.of_all
    own = chain if standing is robot else chain_of_robot(robot)
    front = None if step.double is None else wrench_on_ground(own, step.double.front)
    R0, torque = motor_effort(chain, loads, *motion, gravity=turned(gravity), end_wrench=front)
    torque = coupled.tangent.reduced(torque)
    wrench = sole_axes(R0)
    tied = robot.coupling
    landing = tied.at(step.q_end)
    last = step.rate_before
    if step.double is not None and not step.double.opens:
        last = step.double.liftoff.motion[1, 0, step.hinges :]
    q_end, before = tied.angles(step.q_end), at_rest(landing.rates(last))
    if step.turn is not None:
        before[:6] = sole_axes(step.turn.twist)
    line = None if step.landed is None else step.landed.hinge.twist
    ties = None if tied.none else tied.constraints(step.q_end)
    velocity, I13 = impact(own, q_end, before, line, ties)
    rate_after = velocity[6:][tied.free]
    impulse = impulse_on_foot(own, I13)
    struck = None if step.double is None else step.double.struck
    stated = step.impact.impulse, impulse
    if struck is not None:
        stated = _struck(own, step, struck)
    if step.flat is not None:
        flat = _flat(chain, step, step.flat)
        stated = np.concatenate([stated[0], flat[0]]), np.concatenate([stated[1], flat[1]])
    twist = base_in_sole_axes(velocity)[:6]
    E = schedule.symmetry.joint_map(robot)
    carried = 0.0 if loads.points is None else float(loads.points.mass.sum())
    weight = (chain.mass - carried) * gravity
    force, length = float(np.linalg.norm(weight)), robot.legs.reach
    rate = float(np.sqrt(np.linalg.norm(gravity) / length))
    start, landed = after.motion[1, 0], E @ rate_after
    push = impulse
    if step.landed is not None and line is not None:
        push = step.landed.on_ground @ impulse
        free = foot_twist(own, line)
        turn_rate = free @ swing_jacobian(own, q_end) @ velocity / (free @ free)
        start, landed = np.r_[start, after.foot_motion[1, 0, 0]], np.r_[landed, turn_rate]
    moved, displaced = _front_foot(chain, step)
    ground = _Ground(wrench, push, weight * step.duration)
    turned_by = [] if step.landed is None else [0.0]
    turned_by += [] if step.turn is None else [step.turn.angle]
    begin, following = (standing.coupling.motion(one.whole_motion).of_all[:2, 0] for one in starts)
    ends = begin, np.r_[turned_by, q_end], following
    balance, vertical = _momentum_balance(chain, step, grid, ground, schedule.symmetry, ends)
    return RefereeVerdict(
        torque=_apart(step.read(quantities.TORQUE), torque[:, step.hinges :], force * length),
        wrench=_apart(step.read(quantities.WRENCH), wrench, force),
        impulse=_apart(*stated, force * step.duration),
        rate_after=_apart(step.impact.rate_after if struck is None else last, rate_after, rate),
        sole_twist=max(float(np.abs(step.impact.sole_twist - twist).max()), moved),
        posture=max(float(np.abs(after.motion[0, 0] - E @ step.q_end).max()), displaced),
        rate=_apart(start, landed, rate),
        momentum=balance,
        vertical=vertical,
        weight=-float(ground.weight[2]),
    )


def _struck(chain: Chain, step: Step, struck: ClosedJump) -> tuple[Array, Array]:
    """Return stated and found impulses of an impact that both feet take, shape (6 + n,) each.

    On the rear foot, then of the joints, of which there must be none.
    """
    push = wrench_on_ground(chain, step.impact.impulse)
    jump = step.impact.rate_after - step.rate_before
    R0, torque = inverse_dynamics(
        chain, struck.posture, np.zeros_like(jump), jump, gravity=np.zeros(3), end_wrench=push
    )
    stated = np.concatenate([struck.rear, np.zeros(jump.size)])
    return stated, np.concatenate([sole_axes(R0), torque])


def _flat(chain: Chain, step: Step, flat: FlatJump) -> tuple[Array, Array]:
    """Return stated and found impulses of a foot that comes to lie flat, shape (6 + n,) each.

    On the foot, then of the joints, of which there must be none; found with the hinge about which
    it turned, of the chain's first joints, as one of those that jump.
    """
    before, after = step.coefficients[-5], step.coefficients[-4]
    still = np.zeros(step.hinges)
    jump = np.concatenate([[-flat.rate], still[1:], after - before])
    posture = np.concatenate([still, flat.posture])
    R0, torque = inverse_dynamics(chain, posture, np.zeros_like(jump), jump, gravity=np.zeros(3))
    stated = np.concatenate([flat.impulse, np.zeros(flat.jump.size)])
    return stated, np.concatenate([sole_axes(R0), torque[step.hinges :]])


def _front_foot(chain: Chain, step: Step) -> tuple[float, float]:
    """How fast the front foot moves while both stand [m/s, rad/s], and how far it is away [m]."""
    if step.double is None:
        return 0.0, 0.0
    ends = step.double.touchdown, step.double.motion, step.double.liftoff
    q, dq, _ = np.concatenate([one.motion for one in ends], axis=1)
    twist = (swing_jacobian(chain, q)[..., 6:] @ dq[..., None])[..., 0]
    rotation, origin = sole_placement(chain, q)
    away = np.abs(origin - step.double.sole.translation).max()
    turned_by = np.abs(rotation - step.double.sole.rotation).max()
    return float(np.abs(twist).max()), float(max(away, turned_by))


def both(checks: Sequence[RefereeVerdict]) -> RefereeVerdict:
    """Return the disagreements about steps that follow each other: the largest of each kind."""
    summed = ("vertical", "weight")  # [N·s] over all of them
    found = {
        one.name: (sum if one.name in summed else max)(getattr(check, one.name) for check in checks)
        for one in fields(RefereeVerdict)
    }
    return RefereeVerdict(**found)


@dataclass(frozen=True)
class _Ground:
    """What the ground and gravity do to the robot, in the axes of its footprint.

    Attributes:
        wrench: ground on stance foot at the instants, shape (N, 6) [N, N·m].
        impulse: ground on landing foot, in its footprint, shape (6,) [N·s, N·m·s].
        weight: impulse over the step of the weight that nothing else carries, shape (3,) [N·s].
    """

    wrench: Array
    impulse: Array
    weight: Array


def _momentum_balance(
    chain: Chain,
    step: Step,
    grid: Grid,
    ground: _Ground,
    symmetry: Symmetry,
    ends: tuple[Array, Array, Array],
) -> tuple[float, float]:
    """Over a step the impulses of ground and weight are the change of momentum.

    From just after one impact to just after the next; there the symmetry of the walk
    makes it what the next step begins with, seen from the foot that has landed. `ends` are angles
    and rates of all joints of the chain at the start, angles at the end, and angles and rates at
    the start of the next step.

    Returns:
        The largest component of what is left, over m g T, and the ground's vertical impulse [N·s].
    """
    begin, end, following = ends
    pushed = ground.wrench[:, :3]
    if step.double is not None:
        pushed = pushed + step.double.front[:, :3] @ step.double.sole.rotation.T
    force = step.duration * grid.weights @ pushed
    if step.double is not None and step.double.struck is not None:
        force += step.double.sole.rotation @ step.impact.impulse[:3] + step.double.struck.rear[:3]
    if step.flat is not None:
        force += step.flat.impulse[:3]
    landed, _ = sole_placement(chain, end)
    if step.landed is not None:  # of the sole; from here on of its footprint
        landed = landed @ step.landed.place.rotation.T
    push = landed @ ground.impulse[:3]
    start, after = (momentum(chain, *one)[:3] for one in (begin, following))
    change = landed @ (np.array(symmetry.reflection) * after) - start
    gap = force + push + ground.weight - change
    size = float(np.linalg.norm(ground.weight))
    balance = float(np.abs(gap).max())
    return balance / size if size > 0.0 else balance, float(force[2] + push[2])


def _apart(a: Array, b: Array, size: float) -> float:
    """Return the largest difference, relative to what is compared or to a thousandth of its size.

    The size is that of such a quantity in a walk, so that rounding next to an impulse of zero is
    not a disagreement; two quantities without any size agree where both are zero.
    """
    difference = float(np.abs(a - b).max())
    scale = max(float(np.abs(b).max()), LEAST * size)
    return difference / scale if scale > 0.0 else difference
