"""Rigid links in modified Denavit-Hartenberg notation (Khalil and Kleinfinger, 1986), Table 1.

Frame j follows frame j-1, or that of its antecedent, by turning gamma about z and moving b along z,
turning alpha about the new x and moving d along it, then turning theta about z_j and moving r:

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

In Table 1 every x axis is the common normal of two joint axes and gamma = b = 0; those two let a
frame sit anywhere on its joint axis, so that every chain can be written.

Link 0 is the stance foot. Frame R0 sits at the stance sole: x0 up, y0 right, z0 forward (Section
2.2). The sole frame has the same origin and x forward, y left, z up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields

import numpy as np
from numpy.typing import ArrayLike

from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.nlp import Array

PARALLEL = 1e-8
"""Below this sine two axes count as parallel [rad]: the dropped tilt and the rounding of the
distant feet of their common normal are then both about 1e-8 of a length."""


def hat(vector: Array) -> Array:
    """Return the matrices H with H @ v = vector x v, shape (..., 3, 3), for vectors (..., 3)."""
    matrix = np.zeros((*vector.shape, 3))
    matrix[..., 2, 1], matrix[..., 1, 2] = vector[..., 0], -vector[..., 0]
    matrix[..., 0, 2], matrix[..., 2, 0] = vector[..., 1], -vector[..., 1]
    matrix[..., 1, 0], matrix[..., 0, 1] = vector[..., 2], -vector[..., 2]
    return matrix


def times(matrix: Array, vector: Array) -> Array:
    """Return the products of matrices (..., m, k) with vectors (..., k); shape (..., m)."""
    product: Array = (matrix @ vector[..., None])[..., 0]
    return product


def transforms(
    gamma: Array, b: Array, alpha: Array, d: Array, theta: Array, r: Array
) -> tuple[Array, Array]:
    """Return where each frame lies in the frame before it.

    Args:
        gamma: of each joint, shape (n,) [rad].
        b: of each joint, shape (n,) [m].
        alpha: of each joint, shape (n,) [rad].
        d: of each joint, shape (n,) [m].
        theta: of each joint, shape (..., n) [rad].
        r: of each joint, shape (..., n) [m].

    Returns:
        Rotations A = ^{j-1}A_j, shape (..., n, 3, 3), and origins P = ^{j-1}P_j, (..., n, 3) [m].
    """
    x, y, z = _turned_axes(gamma, alpha)
    cosine, sine = np.cos(theta)[..., None], np.sin(theta)[..., None]
    z_j = np.broadcast_to(z, (*theta.shape, 3))
    A = np.stack([cosine * x + sine * y, cosine * y - sine * x, z_j], axis=-1)
    P = np.outer(b, [0.0, 0.0, 1.0]) + d[:, None] * x + r[..., None] * z
    return A, P


def _turned_axes(gamma: Array, alpha: Array) -> tuple[Array, Array, Array]:
    """Columns of Rot(z, gamma) Rot(x, alpha), each of shape (n, 3)."""
    cg, sg, ca, sa = np.cos(gamma), np.sin(gamma), np.cos(alpha), np.sin(alpha)
    zero = np.zeros_like(cg)
    x = np.stack([cg, sg, zero], axis=-1)
    y = np.stack([-sg * ca, cg * ca, sa], axis=-1)
    z = np.stack([sg * sa, -cg * sa, ca], axis=-1)
    return x, y, z


def placements(A: Array, P: Array, antecedent: Sequence[int]) -> tuple[Array, Array]:
    """Chain the transforms of `transforms`.

    Args:
        A: rotations, shape (..., n, 3, 3).
        P: origins, shape (..., n, 3) [m].
        antecedent: of each joint, the link it sits on.

    Returns:
        Rotations ^0A_j, shape (..., n + 1, 3, 3), and origins ^0P_j, shape (..., n + 1, 3) [m], of
        the frames 0 to n in frame 0.
    """
    rotations = [np.broadcast_to(np.eye(3), (*A.shape[:-3], 3, 3))]
    origins = [np.zeros((*P.shape[:-2], 3))]
    for j, link in enumerate(antecedent):
        origins.append(origins[link] + times(rotations[link], P[..., j, :]))
        rotations.append(rotations[link] @ A[..., j, :, :])
    return np.stack(rotations, axis=-3), np.stack(origins, axis=-2)


def parameters(rotation: Array, origin: Array) -> tuple[float, float, float, float, float, float]:
    """Return (gamma, b, alpha, d, theta, r) that place a frame in the frame before it.

    Args:
        rotation: of the frame, shape (3, 3).
        origin: of the frame, shape (3,) [m].
    """
    zx, zy, zz = (float(value) for value in rotation[:, 2])
    px, py, pz = (float(value) for value in origin)
    sine = math.hypot(zx, zy)
    if sine > PARALLEL:
        gamma, alpha = math.atan2(zx, -zy), math.atan2(sine, zz)
        d = px * math.cos(gamma) + py * math.sin(gamma)
        r = (px * math.sin(gamma) - py * math.cos(gamma)) / sine
        b = pz - r * zz
    else:
        # Parallel axes have a common normal everywhere: take the one through the first origin.
        gamma, alpha = math.atan2(py, px), 0.0 if zz > 0.0 else math.pi
        d, b, r = math.hypot(px, py), 0.0, math.copysign(1.0, zz) * pz
    x, y, _ = _turned_axes(np.array([gamma]), np.array([alpha]))
    theta = math.atan2(float(y[0] @ rotation[:, 0]), float(x[0] @ rotation[:, 0]))
    return gamma, b, alpha, d, theta, r


SOLE_AXES: Array = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""Turns components along x0, y0, z0 into components along sole axes; its own inverse."""
SOLE_AXES.setflags(write=False)


@dataclass(frozen=True)
class JointTable:
    """The rows of Table 1, one per joint; every array has shape (n,).

    Attributes:
        alpha: angle from z_{j-1} to z_j about the common normal [rad].
        d: distance from z_{j-1} to z_j along the common normal [m].
        theta: turn about z_j at zero joint value [rad].
        r: move along z_j at zero joint value [m].
        sigma: 0 for a revolute joint, 1 for a prismatic one.
        gamma: angle from x_{j-1} to the common normal about z_{j-1} [rad]; 0 in Table 1.
        b: distance from O_{j-1} to the common normal along z_{j-1} [m]; 0 in Table 1.
        antecedent: a(j): link on which each joint sits, in place of j-1 above where the links
            branch; left out: link j-1, as in Table 1.

    Raises:
        InputError: the arrays differ in shape, or are not finite.
    """

    alpha: Array
    d: Array
    theta: Array
    r: Array
    sigma: Array
    gamma: Array
    b: Array
    antecedent: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.alpha)
        _freeze(self, {f.name: (n,) for f in fields(self) if f.name != "antecedent"})
        if not self.antecedent:
            object.__setattr__(self, "antecedent", tuple(range(n)))
        links = self.antecedent
        if len(links) != n or not all(0 <= link <= j for j, link in enumerate(links)):
            raise InputError(
                f"antecedent = {links} is not allowed; give each of the {n} joints a link before it"
            )
        if not np.isin(self.sigma, (0.0, 1.0)).all():
            raise InputError(
                f"sigma = {self.sigma} is not allowed; use 0 (revolute) or 1 (prismatic)"
            )


@dataclass(frozen=True)
class LinkTable:
    """Mass properties of links 0 to n, each in its own frame R_j, about its origin O_j.

    Attributes:
        mass: M_j, shape (n + 1,) [kg].
        first_moment: MS_j, mass times centre of mass, shape (n + 1, 3) [kg·m].
        inertia: J_j about O_j, shape (n + 1, 3, 3) [kg·m²].

    Raises:
        InputError: the arrays differ in shape, or are not finite.
    """

    mass: Array
    first_moment: Array
    inertia: Array

    def __post_init__(self) -> None:
        count = len(self.mass)
        shapes = {"mass": (count,), "first_moment": (count, 3), "inertia": (count, 3, 3)}
        _freeze(self, shapes)


@dataclass(frozen=True)
class Chain:
    """Links and joints from the stance foot to the swing foot, and branches of them.

    The values a caller gives are those of the robot's joints; the paper's are q_j = sign_j times
    them. Torques come back in the robot's sign too.

    Attributes:
        joints: geometry.
        links: mass properties; one link more than joints.
        sign: +1 or -1 for each joint, shape (n,).
        armature: reflected inertia of each motor, shape (n,) [kg·m²; kg if prismatic].
        tool_rotation: axes of the swing sole frame in that of its link, shape (3, 3).
        tool_position: origin of the swing sole frame there, shape (3,) [m].
        end: link of the swing sole; left out: n.

    Raises:
        InputError: an array has the wrong shape, is not finite, or a sign is not +1 or -1.
    """

    joints: JointTable
    links: LinkTable
    sign: Array
    armature: Array
    tool_rotation: Array
    tool_position: Array
    end: int = -1

    def __post_init__(self) -> None:
        n = self.dof
        if self.end < 0:
            object.__setattr__(self, "end", n)
        shapes = {"sign": (n,), "armature": (n,), "tool_rotation": (3, 3), "tool_position": (3,)}
        _freeze(self, shapes)
        if not np.isin(self.sign, (-1.0, 1.0)).all():
            raise InputError(f"sign = {self.sign} is not allowed; use +1 or -1 for each joint")
        if len(self.links.mass) != n + 1:
            raise InputError(
                f"the chain has {n} joints and {len(self.links.mass)} links; give {n + 1} links"
            )

    @property
    def dof(self) -> int:
        """Number of joints n."""
        return len(self.joints.alpha)

    @property
    def mass(self) -> float:
        """Total mass [kg]."""
        return float(self.links.mass.sum())


def joint_values(chain: Chain, name: str, value: ArrayLike) -> Array:
    """Return values given by a caller as an array, shape (..., n).

    Raises:
        InputError: the last axis does not have one entry for each joint, or one is not finite.
    """
    return _checked(name, value, (chain.dof,))


def six_vector(name: str, value: ArrayLike) -> Array:
    """Return a twist or wrench given by a caller as an array, shape (..., 6).

    Raises:
        InputError: the last axis does not have six entries, or one is not finite.
    """
    return _checked(name, value, (6,))


def joint_transforms(chain: Chain, q: Array) -> tuple[Array, Array]:
    """Return rotations ^{j-1}A_j (..., n, 3, 3) and origins ^{j-1}P_j (..., n, 3) [m] at q."""
    table = chain.joints
    move = chain.sign * q
    theta = table.theta + (1.0 - table.sigma) * move
    r = table.r + table.sigma * move
    return transforms(table.gamma, table.b, table.alpha, table.d, theta, r)


def link_placements(chain: Chain, q: ArrayLike) -> tuple[Array, Array]:
    """Return where the link frames R_0 to R_n lie in R0.

    Args:
        chain: the chain.
        q: joint values, shape (..., n) [rad, m].

    Returns:
        Rotations ^0A_j, shape (..., n + 1, 3, 3), and origins ^0P_j, shape (..., n + 1, 3) [m].

    Raises:
        InputError: q has the wrong shape or is not finite.
    """
    A, P = joint_transforms(chain, joint_values(chain, "q", q))
    return placements(A, P, chain.joints.antecedent)


def sole_placement(chain: Chain, q: ArrayLike) -> tuple[Array, Array]:
    """Return the swing sole in the stance sole frame.

    Args:
        chain: the chain.
        q: joint values, shape (..., n) [rad, m].

    Returns:
        Its rotation, shape (..., 3, 3), and its origin, shape (..., 3) [m].

    Raises:
        InputError: q has the wrong shape or is not finite.
    """
    A, P = link_placements(chain, q)
    rotation = SOLE_AXES @ A[..., chain.end, :, :] @ chain.tool_rotation
    origin = P[..., chain.end, :] + times(A[..., chain.end, :, :], chain.tool_position)
    return rotation, turned(origin)


def turned(vector: Array) -> Array:
    """Turn vectors (..., 3) from R0 axes into sole axes, or from those into R0 axes."""
    product: Array = vector @ SOLE_AXES
    return product


def _freeze(table: object, shapes: dict[str, tuple[int, ...]]) -> None:
    for name, shape in shapes.items():
        value = getattr(table, name)
        if np.shape(value) != shape:
            raise InputError(f"{name} has shape {np.shape(value)}; give shape {shape}")
        array = np.array(_checked(name, value, shape))
        array.setflags(write=False)
        object.__setattr__(table, name, array)


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.asarray(value, dtype=np.float64)
    if array.shape[-len(shape) :] != shape:
        raise InputError(f"{name} has shape {array.shape}; its last axes must be {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} has an entry that is not finite; give finite numbers")
    return array
