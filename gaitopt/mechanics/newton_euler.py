"""The recursive Newton-Euler algorithm of Section 2.3 and the impact of Section 2.4, by equation.

It referees the production code, which computes the same on Pinocchio from a URDF, and shares no
code with it. Any number of states is evaluated at once: every argument may carry the same leading
axes "...".

Rigid links are in modified Denavit-Hartenberg notation (Khalil and Kleinfinger, 1986), Table 1.
Frame j follows frame j-1, or that of its antecedent where links branch, by turning gamma about z
and moving b along z, turning alpha about the new x and moving d along it, then turning theta about
z_j and moving r:

    T = Rot(z, gamma) Trans(z, b) Rot(x, alpha) Trans(x, d) Rot(z, theta) Trans(z, r)

In Table 1 every x axis is the common normal of two joint axes and gamma = b = 0; those two let a
frame sit anywhere on its joint axis, so that every chain can be written.

Link 0 is the stance foot. Frame R0 sits at the stance sole: x0 up, y0 right, z0 forward (Section
2.2). The sole frame has the same origin and x forward, y left, z up; `sole_axes` turns twists and
wrenches from one to the other. Velocities of the impact are V = [V_0; omega_0; dq], the base in R0;
wrenches and twists of the swing foot are the paper's, at the origin of its link frame;
`impulse_on_foot` takes an impulse to the sole.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import field, fields, replace

import numpy as np
from numpy.typing import ArrayLike

from gaitopt.bounds import must_be, shown
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.nlp import Array

PARALLEL = 1e-3
"""Below this sine two axes count as nearly parallel [rad]: their common normal may lie far away and
rounds as much, so that a small turn `beta` takes its place."""


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
    gamma: Array, b: Array, alpha: Array, d: Array, theta: Array, r: Array, beta: Array
) -> tuple[Array, Array]:
    """Return where each frame lies in the frame before it.

    Args:
        gamma: of each joint, shape (n,) [rad].
        b: of each joint, shape (n,) [m].
        alpha: of each joint, shape (n,) [rad].
        d: of each joint, shape (n,) [m].
        theta: of each joint, shape (..., n) [rad].
        r: of each joint, shape (..., n) [m].
        beta: of each joint, shape (n,) [rad].

    Returns:
        Rotations A, shape (..., n, 3, 3), and origins P, (..., n, 3) [m], of frame j in frame j-1.
    """
    x, y, z = _turned_axes(gamma, alpha, beta)
    normal = np.stack([np.cos(gamma), np.sin(gamma), np.zeros_like(gamma)], axis=-1)
    cosine, sine = np.cos(theta)[..., None], np.sin(theta)[..., None]
    z_j = np.broadcast_to(z, (*theta.shape, 3))
    A = np.stack([cosine * x + sine * y, cosine * y - sine * x, z_j], axis=-1)
    P = np.outer(b, [0.0, 0.0, 1.0]) + d[:, None] * normal + r[..., None] * z
    return A, P


def _turned_axes(gamma: Array, alpha: Array, beta: Array) -> tuple[Array, Array, Array]:
    """Columns of Rot(z, gamma) Rot(x, alpha) Rot(y, beta), each of shape (n, 3)."""
    cg, sg, ca, sa = np.cos(gamma), np.sin(gamma), np.cos(alpha), np.sin(alpha)
    cb, sb = np.cos(beta)[..., None], np.sin(beta)[..., None]
    zero = np.zeros_like(cg)
    x = np.stack([cg, sg, zero], axis=-1)
    y = np.stack([-sg * ca, cg * ca, sa], axis=-1)
    z = np.stack([sg * sa, -cg * sa, ca], axis=-1)
    return cb * x - sb * z, y, sb * x + cb * z


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


def parameters(rotation: Array, origin: Array) -> tuple[float, ...]:
    """Return gamma, b, alpha, d, theta, r, beta that place a frame in the frame before it.

    Args:
        rotation: of the frame, shape (3, 3).
        origin: of the frame, shape (3,) [m].
    """
    zx, zy, zz = (float(value) for value in rotation[:, 2])
    px, py, pz = (float(value) for value in origin)
    sine = math.hypot(zx, zy)
    if sine > PARALLEL:
        gamma, alpha, beta = math.atan2(zx, -zy), math.atan2(sine, zz), 0.0
        d = px * math.cos(gamma) + py * math.sin(gamma)
        r = (px * math.sin(gamma) - py * math.cos(gamma)) / sine
        b = pz - r * zz
    else:
        # From the first origin, square to its axis, to the other axis.
        b, r = 0.0, pz / zz
        px, py = px - r * zx, py - r * zy
        gamma, d = math.atan2(py, px), math.hypot(px, py)
        ahead = zx * math.cos(gamma) + zy * math.sin(gamma)
        aside = zx * math.sin(gamma) - zy * math.cos(gamma)
        alpha, beta = math.atan2(aside + 0.0, zz), math.atan2(ahead, math.hypot(aside, zz))
    x, y, _ = _turned_axes(*(np.array([angle]) for angle in (gamma, alpha, beta)))
    theta = math.atan2(float(y[0] @ rotation[:, 0]), float(x[0] @ rotation[:, 0]))
    return gamma, b, alpha, d, theta, r, beta


SOLE_AXES: Array = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
"""Turns components along x0, y0, z0 into components along sole axes; its own inverse."""
SOLE_AXES.setflags(write=False)


@dataclass(frozen=True)
class JointTable:
    """The rows of Table 1, one per joint; every array has shape (n,).

    Attributes:
        alpha: angle from z of j-1 to z_j about the common normal [rad].
        d: distance from z of j-1 to z_j along the common normal [m].
        theta: turn about z_j at zero joint value [rad].
        r: move along z_j at zero joint value [m].
        sigma: 0 for a revolute joint, 1 for a prismatic one.
        gamma: angle from x of j-1 to the common normal about z of j-1 [rad]; 0 in Table 1.
        b: distance from O of j-1 to the common normal along z of j-1 [m]; 0 in Table 1.
        antecedent: a(j): link on which each joint sits, in place of j-1 above where the links
            branch; left out: link j-1, as in Table 1.
        beta: turn about the y axis between those of alpha and theta, of nearly parallel axes [rad]
            (Hayati and Mirmirani, J. Robotic Systems 2 (1985)); left out: 0, as in Table 1.

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
    beta: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        n = _rows("alpha", self.alpha)
        if not _numbers("beta", self.beta).size:
            object.__setattr__(self, "beta", np.zeros(n))
        _freeze(self, {f.name: (n,) for f in fields(self) if f.name != "antecedent"})
        given = _numbers("antecedent", self.antecedent)
        links = given if given.size else np.arange(n)
        if links.shape != (n,) or not all(link in range(j + 1) for j, link in enumerate(links)):
            raise InputError(
                f"antecedent = {shown(self.antecedent)} is not allowed; give each of the {n} "
                "joints a link before it"
            )
        object.__setattr__(self, "antecedent", tuple(map(int, links)))
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
        count = _rows("mass", self.mass)
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
        must_be(self.joints, JointTable, "joints of the chain", "a JointTable")
        must_be(self.links, LinkTable, "links of the chain", "a LinkTable")
        must_be(self.end, int, "end of the chain", "the number of a link: 12")
        n = self.dof
        if self.end < 0:
            object.__setattr__(self, "end", n)
        if self.end > n:
            raise InputError(f"end = {shown(self.end)} is not allowed; the last link is {n}")
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
    """Return rotations A (..., n, 3, 3) and origins P (..., n, 3) [m] of `transforms` at q."""
    table = chain.joints
    move = chain.sign * q
    theta = table.theta + (1.0 - table.sigma) * move
    r = table.r + table.sigma * move
    return transforms(table.gamma, table.b, table.alpha, table.d, theta, r, table.beta)


def link_placements(chain: Chain, q: ArrayLike) -> tuple[Array, Array]:
    """Return where the link frames R_0 to R_n lie in R0.

    Args:
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
        value = _numbers(name, getattr(table, name))
        if value.shape != shape:
            raise InputError(f"{name} has shape {value.shape}; give shape {shape}")
        array = np.array(_checked(name, value, shape))
        array.setflags(write=False)
        object.__setattr__(table, name, array)


def _numbers(name: str, value: ArrayLike) -> Array:
    """Return what a caller gives as an array of any shape."""
    try:
        found = np.asarray(value)
        if found.dtype.kind not in "biuf" and found.size:
            raise ValueError
        return found.astype(np.float64, copy=False)
    except (ValueError, TypeError, OverflowError):  # texts, rows of different lengths
        raise InputError(f"{name} is {shown(value)}; give an array of numbers") from None


def _rows(name: str, value: ArrayLike) -> int:
    """Return how many entries the array has that tells the shape of the others."""
    found = _numbers(name, value)
    if found.ndim != 1:
        raise InputError(f"{name} has shape {found.shape}; give one number each: shape (n,)")
    return len(found)


def _alike(**arrays: Array) -> None:
    """Refuse arrays whose leading axes "..." do not fit each other.

    Args:
        arrays: by name, with one further axis each.
    """
    try:
        np.broadcast_shapes(*(one.shape[:-1] for one in arrays.values()))
    except ValueError:
        told = ", ".join(f"{name} {one.shape}" for name, one in arrays.items())
        raise InputError(
            f"shapes of different leading axes: {told}; give the same states"
        ) from None


def _checked(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = _numbers(name, value)
    if array.shape[-len(shape) :] != shape:
        raise InputError(f"{name} has shape {array.shape}; its last axes must be {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} has an entry that is not finite; give finite numbers")
    return array


GRAVITY = 9.81
"""Acceleration of free fall [m/s²]; the referee has its own, to see a wrong one elsewhere."""

_A_J: Array = np.array([0.0, 0.0, 1.0])
"""Joint axis a_j in R_j: the z axis."""

_Pair = tuple[Array, Array]
"""A linear and an angular vector of one link, each (..., 3)."""


def inverse_dynamics(
    chain: Chain,
    q: ArrayLike,
    dq: ArrayLike,
    ddq: ArrayLike,
    *,
    gravity: ArrayLike = GRAVITY,
    base_velocity: ArrayLike | None = None,
    base_acceleration: ArrayLike | None = None,
    end_wrench: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return the ground wrench and the joint torques: [R0; Gamma] = NE(q, dq, ddq, R13), Eq. (1).

    Args:
        q: joint values, shape (..., n) [rad; m if prismatic].
        dq: joint rates, shape (..., n) [rad/s; m/s].
        ddq: joint accelerations, shape (..., n) [rad/s²; m/s²].
        gravity: g, along -x0, or a vector in R0, shape (3,) [m/s²].
        base_velocity: [V_0; omega_0] of link 0 in R0, shape (..., 6) [m/s, rad/s]; None: at rest.
        base_acceleration: of O_0, and angular, in R0, shape (..., 6) [m/s², rad/s²]; None: zero.
        end_wrench: R13, force and moment about O_n that link n exerts on its surroundings, in
            R_n, shape (..., 6) [N, N·m]; None: zero.

    Returns:
        R0 = [f_0; m_0], ground on stance foot about O_0 in R0, shape (..., 6) [N, N·m], and the
        torques, shape (..., n) [N·m; N if prismatic], which include armature * ddq.

    Raises:
        InputError: an argument has the wrong shape or is not finite.
    """
    q, rate = joint_values(chain, "q", q), joint_values(chain, "dq", dq)
    ddq, start = (
        joint_values(chain, "ddq", ddq),
        _six_or_zero("base_acceleration", base_acceleration),
    )
    base, end = _six_or_zero("base_velocity", base_velocity), _six_or_zero("end_wrench", end_wrench)
    _alike(q=q, dq=rate, ddq=ddq, base_velocity=base, base_acceleration=start, end_wrench=end)
    A, P = joint_transforms(chain, q)
    velocity = _velocities(chain, A, P, rate, base)
    acceleration = _accelerations(chain, A, P, rate, ddq, velocity, start + _eq2(gravity))
    wrenches = _inertial_wrenches(chain, velocity, acceleration)
    f, m = _equilibrium(chain, A, P, wrenches, end)
    return _joined(f[0], m[0]), _torques(chain, f, m) + chain.armature * ddq


def inertia_matrix(chain: Chain, q: ArrayLike) -> Array:
    """Return D of Eq. (14), shape (..., 6 + n, 6 + n), by Walker's method of Section 2.4.3.

    Column i is NE for dV = e_i. Arguments and errors as of `inverse_dynamics`.
    """
    q = joint_values(chain, "q", q)[..., None, :]
    unit = np.eye(6 + chain.dof)
    R0, torque = inverse_dynamics(
        chain, q, np.zeros(chain.dof), unit[:, 6:], gravity=0.0, base_acceleration=unit[:, :6]
    )
    return np.swapaxes(np.concatenate([R0, torque], axis=-1), -1, -2)


def momentum(
    chain: Chain, q: ArrayLike, dq: ArrayLike, base_velocity: ArrayLike | None = None
) -> Array:
    """Return the momentum of the links: linear, then angular about the stance sole origin.

    Its shape is (..., 6), in the axes of the stance sole frame [N·s, N·m·s]. Arguments and errors
    are those of `inverse_dynamics`.
    """
    q, rate = joint_values(chain, "q", q), joint_values(chain, "dq", dq)
    base = _six_or_zero("base_velocity", base_velocity)
    _alike(q=q, dq=rate, base_velocity=base)
    A, P = joint_transforms(chain, q)
    V, omega = _of_links(_velocities(chain, A, P, rate, base))
    mass, MS, J = chain.links.mass[:, None], chain.links.first_moment, chain.links.inertia
    links = _pairs(mass * V + _cross(omega, MS), times(J, omega) + _cross(MS, V))
    # Momenta of the links gather at O_0 as their inertial wrenches do.
    linear, angular = _equilibrium(chain, A, P, links, np.zeros(6))
    return sole_axes(_joined(linear[0], angular[0]))


def sole_axes(vector: Array) -> Array:
    """Turn a twist or wrench (..., 6) at O_0 from R0 into sole axes, or from those into R0."""
    return _joined(turned(vector[..., :3]), turned(vector[..., 3:]))


def _six_or_zero(name: str, value: ArrayLike | None) -> Array:
    return six_vector(name, np.zeros(6) if value is None else value)


def _eq2(gravity: ArrayLike) -> Array:
    """Acceleration of the ground that stands for weight, Eq. (2): against gravity."""
    given = _numbers("gravity", gravity)
    vector = np.array([-given, 0.0, 0.0]) if given.ndim == 0 else given
    if vector.shape != (3,):
        raise InputError(f"gravity has shape {vector.shape}; give a number or shape (3,)")
    return six_vector("gravity", np.concatenate([-vector, np.zeros(3)]))


def _velocities(chain: Chain, A: Array, P: Array, dq: Array, base: Array) -> list[_Pair]:
    """(V_j, omega_j) of links 0 to n in their own frames, Eqs. (3) and (4)."""
    V, omega = base[..., :3], base[..., 3:]
    links = [(V, omega)]
    rate = (chain.sign * dq)[..., None] * _A_J
    for j, (sigma, link) in enumerate(_joints(chain)):
        R = np.swapaxes(A[..., j, :, :], -1, -2)
        V, omega = links[link]
        V = times(R, V + _cross(omega, P[..., j, :])) + sigma * rate[..., j, :]
        omega = times(R, omega) + (1.0 - sigma) * rate[..., j, :]
        links.append((V, omega))
    return links


def _joints(chain: Chain) -> Iterator[tuple[float, int]]:
    """Yield sigma and the antecedent link of each joint."""
    return zip(chain.joints.sigma, chain.joints.antecedent, strict=True)


def _accelerations(
    chain: Chain, A: Array, P: Array, dq: Array, ddq: Array, velocity: list[_Pair], base: Array
) -> list[_Pair]:
    """(dV_j, domega_j) of links 0 to n in their own frames, Eqs. (5) and (6)."""
    dV, domega = base[..., :3], base[..., 3:]
    links = [(dV, domega)]
    rate, change = ((chain.sign * value)[..., None] * _A_J for value in (dq, ddq))
    for j, (sigma, link) in enumerate(_joints(chain)):
        R = np.swapaxes(A[..., j, :, :], -1, -2)
        omega = velocity[link][1]
        dV, domega = links[link]
        turned = _cross(times(R, omega), rate[..., j, :])
        U = _field(omega, domega)
        dV = times(R, dV + times(U, P[..., j, :])) + sigma * (change[..., j, :] + 2.0 * turned)
        domega = times(R, domega) + (1.0 - sigma) * (change[..., j, :] + turned)
        links.append((dV, domega))
    return links


def _inertial_wrenches(
    chain: Chain, velocity: list[_Pair], acceleration: list[_Pair]
) -> list[_Pair]:
    """(F_j, M_j) of links 0 to n about O_j in their own frames, Eqs. (7) and (8)."""
    (_, omega), (dV, domega) = _of_links(velocity), _of_links(acceleration)
    mass, MS, J = chain.links.mass[:, None], chain.links.first_moment, chain.links.inertia
    F = mass * dV + times(_field(omega, domega), MS)
    M = times(J, domega) + _cross(omega, times(J, omega)) + _cross(MS, dV)
    return _pairs(F, M)


def _of_links(pairs: list[_Pair]) -> _Pair:
    """Return the linear and the angular vectors of all links, each (..., n + 1, 3)."""
    together = np.broadcast_arrays(*(one for pair in pairs for one in pair))
    each = np.stack(together, axis=-2)
    return each[..., ::2, :], each[..., 1::2, :]


def _pairs(linear: Array, angular: Array) -> list[_Pair]:
    """Return vectors (..., n + 1, 3) link by link."""
    return [(linear[..., j, :], angular[..., j, :]) for j in range(linear.shape[-2])]


def _equilibrium(
    chain: Chain, A: Array, P: Array, wrenches: list[_Pair], end: Array
) -> tuple[list[Array], list[Array]]:
    """f_j and m_j for j = 0 to n, Eqs. (9) and (10); `end` is exerted by the swing foot's link."""
    f, m = [F for F, _ in wrenches], [M for _, M in wrenches]
    f[chain.end] = f[chain.end] + end[..., :3]
    m[chain.end] = m[chain.end] + end[..., 3:]
    for j, link in reversed(list(enumerate(chain.joints.antecedent))):
        passed = times(A[..., j, :, :], f[j + 1])
        f[link] = f[link] + passed
        m[link] = m[link] + times(A[..., j, :, :], m[j + 1]) + _cross(P[..., j, :], passed)
    return f, m


def _torques(chain: Chain, f: list[Array], m: list[Array]) -> Array:
    """Projections on the joint axes z_j, Eq. (11), in the sign of the robot's joints."""
    force = np.stack([f_j[..., 2] for f_j in f[1:]], axis=-1)
    moment = np.stack([m_j[..., 2] for m_j in m[1:]], axis=-1)
    sigma = chain.joints.sigma
    return chain.sign * (sigma * force + (1.0 - sigma) * moment)


def _field(omega: Array, domega: Array) -> Array:
    """Matrix of the acceleration field of a link, below Eq. (6), shape (..., 3, 3)."""
    turn = hat(omega)
    U: Array = hat(domega) + turn @ turn
    return U


def _cross(a: Array, b: Array) -> Array:
    return times(hat(a), b)


def _joined(first: Array, second: Array) -> Array:
    return np.concatenate(np.broadcast_arrays(first, second), axis=-1)


FRICTION_RATE = 0.1
"""Rate in which Coulomb friction turns round [rad/s]; the referee has its own, as for gravity."""


@dataclass(frozen=True)
class Loads:
    """Passive joints, in the sign of the robot's joints, and weight carried from outside.

    Attributes:
        damping: torques per |rate|^(k-1) rate, k = 1, 2, ..., shape (n, K) [N·m·s/rad, ...].
        stiffness: torques per (angle - rest)^k, shape (n, K) [N·m/rad, ...].
        friction: Coulomb friction, shape (n,) [N·m].
        rest: of the springs, shape (n,) [rad].
        points: the points that are carried, as links of a chain of their own; None for none.
    """

    damping: Array
    stiffness: Array
    friction: Array
    rest: Array
    points: LinkTable | None


def motor_effort(
    chain: Chain,
    loads: Loads,
    q: ArrayLike,
    dq: ArrayLike,
    ddq: ArrayLike,
    *,
    gravity: ArrayLike = GRAVITY,
    end_wrench: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return what ground and motors give where loads act as well; as of `inverse_dynamics`."""
    R0, torque = inverse_dynamics(chain, q, dq, ddq, gravity=gravity, end_wrench=end_wrench)
    angle, rate = joint_values(chain, "q", q), joint_values(chain, "dq", dq)
    torque = torque + np.sign(rate) * _powers(loads.damping, np.abs(rate))
    torque = torque + _powers(loads.stiffness, angle - loads.rest)
    torque = torque + loads.friction * _turned(rate / FRICTION_RATE)
    if loads.points is not None:
        hung = replace(chain, links=loads.points, armature=np.zeros(chain.dof))
        still = np.zeros(chain.dof)
        unneeded, unneeded_torque = inverse_dynamics(hung, q, still, still, gravity=gravity)
        R0, torque = R0 - unneeded, torque - unneeded_torque
    return R0, torque


def _powers(coefficients: Array, x: Array) -> Array:
    """Sum of c_k x^k."""
    powers = x[..., None] ** np.arange(1, coefficients.shape[1] + 1)
    return np.asarray((coefficients * powers).sum(axis=-1))


def _turned(x: Array) -> Array:
    """The smooth sign (1 - exp(-2 x)) / (1 + exp(-2 x)), from the side that does not overflow."""
    fading = np.exp(-2.0 * np.abs(x))
    return np.asarray(np.sign(x) * (1.0 - fading) / (1.0 + fading))


def swing_jacobian(chain: Chain, q: ArrayLike) -> Array:
    """Return D12' of Eq. (24), shape (..., 6, 6 + n), of which Eq. (23) takes the product with V.

    That is [V_n; omega_n] of the swing foot's link in R_n. Arguments and errors are those of
    `inverse_dynamics`.
    """
    A, P = link_placements(chain, q)
    to_last = np.swapaxes(A[..., chain.end, :, :], -1, -2)
    jacobian = np.zeros((*P.shape[:-2], 6, 6 + chain.dof))
    jacobian[..., :3, :3] = jacobian[..., 3:, 3:6] = to_last
    jacobian[..., :3, 3:6] = -to_last @ hat(P[..., chain.end, :])
    jacobian[..., 6:] = _joint_columns(chain, A, P)
    return jacobian


def _joint_columns(chain: Chain, A: Array, P: Array) -> Array:
    """^nJ_n: twist of link n at O_n in R_n for unit rates, shape (..., 6, n)."""
    on_the_way, link = np.zeros(chain.dof), chain.end
    while link > 0:
        on_the_way[link - 1] = 1.0
        link = chain.joints.antecedent[link - 1]
    axis = A[..., 1:, :, 2] * (chain.sign * on_the_way)[:, None]
    arm = P[..., chain.end, None, :] - P[..., 1:, :]
    sigma = chain.joints.sigma[:, None]
    linear = sigma * axis + (1.0 - sigma) * times(hat(axis), arm)
    # Rows times A_n are columns in R_n.
    columns = np.concatenate(
        [linear @ A[..., chain.end, :, :], ((1.0 - sigma) * axis) @ A[..., chain.end, :, :]],
        axis=-1,
    )
    return np.swapaxes(columns, -1, -2)


def impact(
    chain: Chain,
    q: ArrayLike,
    v_minus: ArrayLike,
    free: ArrayLike | None = None,
    ties: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return the velocity after the impact and the impulse, Eqs. (19) and (20).

    The former stance foot is free to leave the ground, I_0 = 0. Ties of joints keep holding by
    impulses of their own.

    Args:
        q: joint values, shape (..., n) [rad, m].
        v_minus: V before the impact, shape (..., 6 + n) [m/s, rad/s].
        free: twist that the swing foot keeps, about the line of it that lands, in its sole frame,
            shape (6,): the ground then gives no moment about it, and (17) holds across it.
        ties: C, the joint rates before and after keep C rates = 0, shape (c, n); None: none.

    Returns:
        V after the impact, shape (..., 6 + n), and I13, the impulse of the swing foot ON THE
        GROUND about O_n in R_n (the paper's sign), shape (..., 6) [N·s, N·m·s].

    Raises:
        InputError: an argument has the wrong shape or is not finite, or a joint moves no mass.
    """
    before = _numbers("v_minus", v_minus)
    if before.shape[-1:] != (6 + chain.dof,) or not np.isfinite(before).all():
        raise InputError(
            f"v_minus has shape {before.shape}; give {6 + chain.dof} finite velocities: linear "
            "and angular velocity of link 0 in R0, then the joint rates"
        )
    q = joint_values(chain, "q", q)
    _alike(q=q, v_minus=before)
    D, D12_t = inertia_matrix(chain, q), swing_jacobian(chain, q)
    across: Array = np.eye(6)
    if free is not None:
        across = np.linalg.qr(foot_twist(chain, free)[:, None], mode="complete")[0][:, 1:]
        D12_t = across.T @ D12_t
    held, count = D12_t, D12_t.shape[-2]
    if ties is not None:
        ties = joint_values(chain, "ties", ties)
        if ties.ndim != 2:
            raise InputError(f"ties have shape {ties.shape}; give shape (c, {chain.dof})")
        rows = np.pad(ties, ((0, 0), (6, 0)))
        rows = np.broadcast_to(rows, (*D12_t.shape[:-2], *rows.shape))
        held = np.concatenate([D12_t, rows], axis=-2)
    compliance = _solved(D, np.swapaxes(held, -1, -2))
    impulses = _solved(held @ compliance, times(held, before)[..., None])[..., 0]
    return before - times(compliance, impulses), impulses[..., :count] @ across.T


def foot_twist(chain: Chain, twist: ArrayLike) -> Array:
    """Return a twist (6,) [m/s, rad/s] of the swing foot given in its sole frame, at O_n in R_n.

    Raises:
        InputError: it has the wrong shape or is not finite.
    """
    given = six_vector("twist", twist)
    if given.ndim != 1:
        raise InputError(f"twist has shape {given.shape}; give shape (6,)")
    linear, angular = np.split(given, 2)
    R = chain.tool_rotation
    turn = R @ angular
    return np.concatenate([R @ linear + np.cross(chain.tool_position, turn), turn])


def _solved(matrix: Array, right: Array) -> Array:
    try:
        return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
    except np.linalg.LinAlgError as error:
        raise InputError(
            "the inertia matrix of the chain is singular: a joint moves no mass; give every link "
            "a mass and an inertia"
        ) from error


def impulse_on_foot(chain: Chain, I13: Array) -> Array:
    """Return the impulse of the ground on the landing foot in its sole frame, (..., 6).

    Args:
        I13: of `impact`.
    """
    R = chain.tool_rotation
    force = I13[..., :3]
    moment = I13[..., 3:] - times(hat(np.broadcast_to(chain.tool_position, force.shape)), force)
    return -np.concatenate([force @ R, moment @ R], axis=-1)


def wrench_on_ground(chain: Chain, wrench: Array) -> Array:
    """Return R13 (..., 6) [N, N·m] from a wrench of the ground on the swing foot in its sole frame.

    The inverse of `impulse_on_foot`.
    """
    R = chain.tool_rotation
    force = -wrench[..., :3] @ R.T
    moment = -wrench[..., 3:] @ R.T
    moment = moment + times(hat(np.broadcast_to(chain.tool_position, force.shape)), force)
    return np.concatenate([force, moment], axis=-1)


def at_rest(rate: ArrayLike) -> Array:
    """Return V for joint rates (..., n) [rad/s] while the stance foot stands still, Eq. (18).

    Raises:
        InputError: they are no array of numbers.
    """
    rate = _numbers("rate", rate)
    if not rate.ndim:
        raise InputError(f"rate is {shown(float(rate))}; give shape (..., n)")
    return np.concatenate([np.zeros((*rate.shape[:-1], 6)), rate], axis=-1)


def base_in_sole_axes(velocity: Array) -> Array:
    """Turn the first six entries of V (..., 6 + n) [m/s, rad/s] from R0 into sole axes, or back."""
    return np.concatenate([sole_axes(velocity[..., :6]), velocity[..., 6:]], axis=-1)
