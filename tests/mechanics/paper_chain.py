"""The chain of the paper's Table 1, from the table alone, and its zero-moment point."""

from __future__ import annotations

import numpy as np

from gaitopt.catalogue.biped_spec import BipedSpec, Geometry, LinkSpec, mirrored_inertia
from gaitopt.errors import EvaluationError
from gaitopt.mechanics.chain_build import LinkMasses, link_table, zero_posture
from gaitopt.mechanics.newton_euler import Chain, JointTable, six_vector, transforms, turned
from gaitopt.nlp import Array


def chain_of_spec(spec: BipedSpec) -> Chain:
    """Return the chain of the paper's Table 1 with a specification's lengths and links.

    Table 1 has thirteen rows for twelve joints: row 13 places the swing sole in R12 (q13 = 0).
    Stance-leg joints get sign -1: in a URDF the torso carries the leg, in Table 1 the foot carries
    the torso, about axes that point the same way.
    """
    joints, tool_rotation, tool_position = _table_1(spec.geometry)
    rotations, origins = zero_posture(joints)
    return Chain(
        joints=joints,
        links=link_table(rotations, origins, _bodies_of_spec(spec, turned(origins))),
        sign=np.repeat([-1.0, 1.0], 6),
        armature=np.zeros(len(joints.alpha)),
        tool_rotation=tool_rotation,
        tool_position=tool_position,
    )


def _table_1(g: Geometry) -> tuple[JointTable, Array, Array]:
    """All rows but the last as the joints; row 13, and R13 to the sole axes, as the tool."""
    quarter, zero = np.pi / 2.0, np.zeros(13)
    alpha = np.array([0, 1, 0, 0, -1, -1, 0, 1, -1, 0, 0, 1, 0]) * quarter
    theta = np.array([0, 0, 0, 0, -1, 0, 0, -1, 0, 0, 0, 0, 0]) * quarter
    d = np.array([g.d1, 0, g.d3, g.d4, 0, 0, g.d7, 0, 0, g.d4, g.d3, 0, g.d1])
    r = np.array([g.l1, 0, 0, g.l4, 0, 0, 0, 0, 0, g.l4, 0, 0, -g.l1])
    A, P = transforms(zero, zero, alpha, d, theta, r, zero)
    joints = JointTable(
        alpha=alpha[:-1],
        d=d[:-1],
        theta=theta[:-1],
        r=r[:-1],
        sigma=zero[:-1],
        gamma=zero[:-1],
        b=zero[:-1],
    )
    # R13 is R0 turned upside down about z: x13 down, y13 left, z13 forward.
    sole_in_13 = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    return joints, A[-1] @ sole_in_13, P[-1]


def _bodies_of_spec(spec: BipedSpec, origins: Array) -> LinkMasses:
    """Links in the stance sole frame, the stance foot first.

    Args:
        spec: of the biped.
        origins: of the link frames there, shape (13, 3) [m].
    """
    hips = (origins[6] + origins[7]) / 2.0
    right = [(part, -1.0) for part in reversed(spec.links.leg)]
    left = [(part, 1.0) for part in spec.links.leg]
    parts = [*right, (spec.links.torso, 1.0), *left]
    # A specification measures from the joint nearer the torso: for right links, the next one.
    points = [*origins[1:7], hips, *origins[7:]]
    return LinkMasses(
        masses=np.array([part.mass for part, _ in parts]),
        coms=np.array(
            [point + _side(part, side) for (part, side), point in zip(parts, points, strict=True)]
        ),
        inertias=np.array([_com_inertia(part, side) for part, side in parts]),
    )


def _side(part: LinkSpec, side: float) -> Array:
    return np.array(part.com) * [1.0, side, 1.0]


def _com_inertia(part: LinkSpec, side: float) -> Array:
    return np.array(part.com_inertia if side > 0.0 else mirrored_inertia(part.com_inertia))


def zero_moment_point(R0: Array) -> tuple[Array, Array]:
    """Return the ZMP on the stance sole, Eqs. (12) and (13).

    Args:
        R0: ground wrench in R0, shape (..., 6) [N, N·m].

    Returns:
        (y, z) along y0 and z0, shape (..., 2) [m], and the same point as (x, y) of the sole frame
        (forward, left), shape (..., 2) [m].

    Raises:
        EvaluationError: the ground carries no vertical force, so that there is no such point.
        InputError: the wrench has the wrong shape or is not finite.
    """
    R0 = six_vector("R0", R0)
    f_x, m_y, m_z = R0[..., 0], R0[..., 4], R0[..., 5]
    if not f_x.all():
        raise EvaluationError("the vertical ground force is 0 N: there is no zero-moment point")
    y, z = -m_z / f_x, m_y / f_x
    return np.stack([y, z], axis=-1), np.stack([z, -y], axis=-1)
