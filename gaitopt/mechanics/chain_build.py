"""Chains of any robot, from its joint lines, in the notation of the paper's Table 1."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError, RobotError
from gaitopt.mechanics.newton_euler import (
    SOLE_AXES,
    Chain,
    JointTable,
    LinkTable,
    Loads,
    hat,
    parameters,
    placements,
    transforms,
    turned,
)
from gaitopt.model.chain_physics import CarriedWeight
from gaitopt.model.robot import Robot
from gaitopt.nlp import Array

_KEPT = 4  # chains


@dataclass(frozen=True)
class LinkMasses:
    """Mass properties of rigid links at the zero posture, all in one common frame.

    Attributes:
        masses: shape (n + 1,) [kg].
        coms: centres of mass, shape (n + 1, 3) [m].
        inertias: about the centres of mass, shape (n + 1, 3, 3) [kg·m²].
    """

    masses: Array
    coms: Array
    inertias: Array


@lru_cache(maxsize=_KEPT)
def chain_of_robot(robot: Robot) -> Chain:
    """Return the chain of a robot rooted at its stance sole; the last few are kept.

    Pinocchio only hands over what the URDF says: placements, axes and inertias.

    Raises:
        RobotError: the model does not start at the foot, or a joint has more than one axis.
    """
    model = robot.model
    frames = [_frame(model, name) for name in (robot.stance_sole, robot.swing_sole)]
    joints, antecedent = _joints(model, frames[0].parentJoint)
    places = [frames[0].placement.inverse()]
    for joint, link in zip(joints, antecedent, strict=True):
        places.append(places[link] * model.jointPlacements[joint])
    motions = [_motion(model, joint) for joint in joints]
    end = joints.index(frames[1].parentJoint) + 1
    tool = places[end] * frames[1].placement
    return chain_from_axes(
        np.array([place.translation for place in places[1:]]),
        np.array(
            [place.rotation @ axis for place, (axis, _) in zip(places[1:], motions, strict=True)]
        ),
        _bodies_of_model(model, [frames[0].parentJoint, *joints], places),
        (tool.rotation, tool.translation),
        antecedent=antecedent,
        end=end,
        sigma=np.array([sigma for _, sigma in motions]),
        armature=np.array([model.armature[model.joints[joint].idx_v] for joint in joints]),
    )


def loads_of_robot(robot: Robot, chain: Chain) -> Loads:
    """Return what acts on the chain of a robot beside its rigid bodies."""
    passive, carried = robot.physics.passive, robot.physics.carried
    none = np.zeros((chain.dof, 1))
    return Loads(
        damping=none if passive is None else passive.damping,
        stiffness=none if passive is None else passive.stiffness,
        friction=none[:, 0] if passive is None else passive.friction,
        rest=none[:, 0] if passive is None else passive.rest,
        points=None if carried is None else _hung(robot.model, chain, carried),
    )


def _hung(model: pin.Model, chain: Chain, carried: CarriedWeight) -> LinkTable:
    """Express carried points in the link frames, about their origins."""
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    places = list(data.oMi)[1:]
    totals = np.array(
        [
            place.rotation @ moment + mass * place.translation
            for place, mass, moment in zip(places, carried.mass, carried.moment, strict=True)
        ]
    )
    rotations, origins = zero_posture(chain.joints)
    arms = turned(totals) - carried.mass[:, None] * origins
    first = (np.swapaxes(rotations, -1, -2) @ arms[..., None])[..., 0]
    return LinkTable(carried.mass, first, np.zeros((len(totals), 3, 3)))


def _frame(model: pin.Model, name: str) -> pin.Frame:
    return model.frames[model.getFrameId(name)]


def _joints(model: pin.Model, first: int) -> tuple[list[int], tuple[int, ...]]:
    joints = list(range(first + 1, model.njoints))
    if first != 1:
        raise RobotError(
            f"the stance sole is fixed to joint '{model.names[first]}', not to the root; root the "
            "model at the stance sole first"
        )
    return joints, tuple(int(model.parents[joint]) - 1 for joint in joints)


def _motion(model: pin.Model, joint: int) -> tuple[Array, float]:
    """Axis of a joint in its own frame (3,), and sigma."""
    kind = model.joints[joint]
    data = kind.createData()
    kind.calc(data, pin.neutral(model))
    subspace = np.asarray(data.S, dtype=np.float64)
    if subspace.size == 6:
        linear, angular = subspace.reshape(6)[:3], subspace.reshape(6)[3:]
        if not linear.any():
            return angular, 0.0
        if not angular.any():
            return linear, 1.0
    raise RobotError(f"joint '{model.names[joint]}' must be revolute or prismatic")


def _bodies_of_model(model: pin.Model, joints: list[int], places: list[pin.SE3]) -> LinkMasses:
    bodies = [place.act(model.inertias[joint]) for joint, place in zip(joints, places, strict=True)]
    return LinkMasses(
        masses=np.array([body.mass for body in bodies]),
        coms=np.array([body.lever for body in bodies]),
        inertias=np.array([body.inertia for body in bodies]),
    )


def chain_from_axes(
    origins: Array,
    axes: Array,
    bodies: LinkMasses,
    tool: tuple[Array, Array],
    *,
    sigma: Array | None = None,
    armature: Array | None = None,
    antecedent: tuple[int, ...] = (),
    end: int = -1,
) -> Chain:
    """Return the chain of given joint lines, by geometry alone.

    Everything is given at the zero posture in the stance sole frame. Frame R_j gets its origin at
    the given point and its z axis along the given axis; consecutive axes are joined by their common
    normal, or, nearly parallel, by a line square to the first and a small turn.

    Args:
        origins: a point on each joint axis, shape (n, 3) [m].
        axes: direction in which link j turns or slides relative to link j-1, shape (n, 3).
        bodies: links 0 to n.
        tool: rotation (3, 3) and origin (3,) [m] of the swing sole frame.
        sigma: 0 for revolute, 1 for prismatic joints, shape (n,); None: all revolute.
        armature: reflected inertia of the motors, shape (n,) [kg·m²]; None: zero.
        antecedent, end: as in `JointTable` and `Chain`.

    Raises:
        InputError: an array has the wrong shape or is not finite, or an axis has no direction.
    """
    n = len(origins)
    rotations = np.array([SOLE_AXES, *(_axes_about(axis) for axis in axes)])
    points = np.concatenate([np.zeros((1, 3)), origins])
    rows = [
        parameters(rotations[a].T @ rotations[j + 1], rotations[a].T @ (points[j + 1] - points[a]))
        for j, a in enumerate(antecedent or range(n))
    ]
    gamma, b, alpha, d, theta, r, beta = np.array(rows).T
    sigma = np.zeros(n) if sigma is None else sigma
    joints = JointTable(alpha, d, theta, r, sigma, gamma, b, antecedent, beta)
    return Chain(
        joints=joints,
        links=link_table(*zero_posture(joints), bodies),
        sign=np.ones(n),
        armature=np.zeros(n) if armature is None else armature,
        tool_rotation=rotations[end].T @ tool[0],
        tool_position=rotations[end].T @ (tool[1] - points[end]),
        end=end,
    )


def _axes_about(axis: Array) -> Array:
    """Rotation whose z axis is the given direction, shape (3, 3)."""
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise InputError(f"a joint axis is {axis}; give a finite direction of non-zero length")
    z = axis / length
    x = np.eye(3)[np.argmin(np.abs(z))]
    x = x - (x @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def zero_posture(joints: JointTable) -> tuple[Array, Array]:
    """Placements of R_0 to R_n in R0 at zero joint values, (n + 1, 3, 3) and (n + 1, 3)."""
    table = (joints.gamma, joints.b, joints.alpha, joints.d, joints.theta, joints.r, joints.beta)
    return placements(*transforms(*table), joints.antecedent)


def link_table(rotations: Array, origins: Array, bodies: LinkMasses) -> LinkTable:
    """Express bodies given in the stance sole frame in the link frames, about their origins.

    Args:
        rotations, origins: of the link frames in R0, (n + 1, 3, 3) and (n + 1, 3) [m].
        bodies: in the stance sole frame.
    """
    to_link = np.swapaxes(rotations, -1, -2) @ SOLE_AXES
    arms = bodies.coms - turned(origins)
    arms = (to_link @ arms[..., None])[..., 0]
    skew = hat(arms)
    return LinkTable(
        mass=bodies.masses,
        first_moment=bodies.masses[:, None] * arms,
        inertia=to_link @ bodies.inertias @ np.swapaxes(to_link, -1, -2)
        - bodies.masses[:, None, None] * skew @ skew,
    )
