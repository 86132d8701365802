"""Random chains and bipeds, and oracles for them that share no code with the referee.

A chain's links are clouds of particles. Where the particles are is computed here with 4 x 4
matrices; what forces they need follows from Newton's second law for each particle.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.mechanics.newton_euler import Chain, JointTable, LinkTable

EXACT = 1e-9  # relative: rounding of twelve chained transforms, with a wide margin
UP = np.array([1.0, 0.0, 0.0])  # R0


def seeded(test):
    """Call a test with twenty generators `rng` of random numbers, the same at every run."""
    rngs = st.integers(0, 2**32 - 1).map(np.random.default_rng)
    return settings(max_examples=20, derandomize=True, deadline=None)(given(rng=rngs)(test))


def turned_about(axis, angle):
    return Rotation.from_rotvec(np.asarray(axis) * angle).as_matrix()


def _turn(axis: int, angle):
    matrix = np.eye(4, dtype=np.result_type(angle, float))
    i, k = [(1, 2), (2, 0), (0, 1)][axis]
    matrix[i, i] = matrix[k, k] = np.cos(angle)
    matrix[k, i] = np.sin(angle)
    matrix[i, k] = -matrix[k, i]
    return matrix


def _move(axis: int, distance):
    matrix = np.eye(4, dtype=np.result_type(distance, float))
    matrix[axis, 3] = distance
    return matrix


def row_matrix(table: JointTable, j: int, turn=0.0, slide=0.0):
    """Khalil and Kleinfinger's ^{j-1}T_j, one elementary matrix after another; (4, 4)."""
    return (
        _turn(2, table.gamma[j])
        @ _move(2, table.b[j])
        @ _turn(0, table.alpha[j])
        @ _move(0, table.d[j])
        @ _turn(2, table.theta[j] + turn)
        @ _move(2, table.r[j] + slide)
    )


def link_matrices(chain: Chain, q):
    """(4, 4) placements of links 0 to n in R0; q may be complex."""
    places = [np.eye(4)]
    for j in range(chain.dof):
        value = chain.sign[j] * q[j]
        moves = {"slide": value} if chain.joints.sigma[j] else {"turn": value}
        places.append(places[-1] @ row_matrix(chain.joints, j, **moves))
    return places


def centre_of_mass(chain: Chain, q):
    """In the stance sole frame: x forward, y left, z up; (3,)."""
    links = zip(chain.links.mass, chain.links.first_moment, link_matrices(chain, q), strict=True)
    x, y, z = sum(m * place[:3, 3] + place[:3, :3] @ s for m, s, place in links) / chain.mass
    return np.array([z, -y, x])


@dataclass
class Cloud:
    """Particles of each link: masses (k,) and positions in the link frame (k, 3)."""

    masses: list
    points: list

    def mass(self):
        return np.concatenate(self.masses)

    def positions(self, chain: Chain, q):
        """Positions of all particles in R0, shape (K, 3)."""
        return np.concatenate(
            [
                points @ place[:3, :3].T + place[:3, 3]
                for points, place in zip(self.points, link_matrices(chain, q), strict=True)
            ]
        )

    def velocities(self, chain: Chain, q, dq):
        step = 1e-30
        return self.positions(chain, q + 1j * step * dq).imag / step

    def energy(self, chain: Chain, q, dq, gravity):
        speed = self.velocities(chain, q, dq)
        height = self.positions(chain, q) @ UP
        return float(self.mass() @ (0.5 * np.sum(speed**2, axis=1) + gravity * height))


def random_cloud_chain(rng, n=7, prismatic=True):
    """A chain with any parameters at all, and the particles it is made of."""
    masses = [rng.uniform(0.2, 2.0, 6) for _ in range(n + 1)]
    points = [rng.normal(0.0, 0.2, (6, 3)) for _ in range(n + 1)]
    inertia = [
        sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(ms, xs, strict=True))
        for ms, xs in zip(masses, points, strict=True)
    ]
    links = LinkTable(
        mass=np.array([m.sum() for m in masses]),
        first_moment=np.array([m @ x for m, x in zip(masses, points, strict=True)]),
        inertia=np.array(inertia),
    )
    angles, lengths = rng.uniform(-np.pi, np.pi, (3, n)), rng.uniform(-0.4, 0.4, (3, n))
    sigma = (rng.random(n) < 0.4).astype(float) if prismatic else np.zeros(n)
    joints = JointTable(
        alpha=angles[0], d=lengths[0], theta=angles[1], r=lengths[1], sigma=sigma,
        gamma=angles[2], b=lengths[2],
    )  # fmt: skip
    chain = Chain(
        joints=joints,
        links=links,
        sign=rng.choice([-1.0, 1.0], n),
        armature=np.zeros(n),
        tool_rotation=np.array(pin.exp3(rng.normal(size=3))),
        tool_position=rng.uniform(-0.2, 0.2, 3),
    )
    return chain, Cloud(masses, points)


def pin_model(chain: Chain, gravity: float) -> pin.Model:
    """The same chain for Pinocchio: free-flyer at R0, joint frames R_j, world = R0."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array([-gravity, 0.0, 0.0]), np.zeros(3))
    joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "foot")
    model.appendBodyToJoint(joint, _pin_inertia(chain, 0), pin.SE3.Identity())
    for j in range(chain.dof):
        axis = np.array([0.0, 0.0, chain.sign[j]])
        kind = pin.JointModelPrismaticUnaligned if chain.joints.sigma[j] else None
        kind = kind or pin.JointModelRevoluteUnaligned
        place = pin.SE3(row_matrix(chain.joints, j))
        joint = model.addJoint(joint, kind(axis), place, f"joint{j + 1}")
        model.appendBodyToJoint(joint, _pin_inertia(chain, j + 1), pin.SE3.Identity())
    model.armature = np.concatenate([np.zeros(6), chain.armature])
    tool = pin.SE3(chain.tool_rotation, chain.tool_position)
    model.addFrame(pin.Frame("swing", joint, tool, pin.FrameType.OP_FRAME), False)
    model.addFrame(pin.Frame("stance", 1, pin.SE3.Identity(), pin.FrameType.OP_FRAME), False)
    return model


def _pin_inertia(chain: Chain, j: int) -> pin.Inertia:
    mass = chain.links.mass[j]
    com = chain.links.first_moment[j] / mass
    about_com = chain.links.inertia[j] - mass * ((com @ com) * np.eye(3) - np.outer(com, com))
    return pin.Inertia(mass, com, about_com)


def posture(q) -> np.ndarray:
    """Pinocchio's configuration with the foot at the world's origin."""
    return np.concatenate([[0, 0, 0, 0, 0, 0, 1.0], q])


def random_spec(rng):
    """A biped with other lengths, masses, centres of mass and full inertia matrices."""
    spec = biped13()
    g = spec.geometry
    geometry = replace(
        g, l1=g.l1 * rng.uniform(0.3, 1.5), l4=rng.uniform(-0.05, 0.05),
        **{name: getattr(g, name) * rng.uniform(0.6, 1.6) for name in ("d1", "d3", "d4", "d7")},
    )  # fmt: skip
    links = {}
    for name, link in spec.links.named():
        points = rng.normal(0.0, 0.1, (5, 3))
        inertia = sum((x @ x) * np.eye(3) - np.outer(x, x) for x in points) * link.mass
        links[name] = replace(
            link,
            mass=link.mass * rng.uniform(0.5, 2.0),
            com=tuple(np.add(link.com, rng.uniform(-0.05, 0.05, 3)).tolist()),
            inertia=tuple(tuple(row) for row in inertia.tolist()),
        )
    # The torso lies on the plane of symmetry, or the robot would not equal its mirror image.
    torso = links["torso"]
    (xx, _, xz), (_, yy, _), (_, _, zz) = torso.inertia
    inertia = ((xx, 0.0, xz), (0.0, yy, 0.0), (xz, 0.0, zz))
    x, _, z = torso.com
    links["torso"] = replace(torso, com=(x, 0.0, z), inertia=inertia)
    return replace(spec, geometry=geometry, links=replace(spec.links, **links))


def slope(function, h=1e-3):
    """Derivative at zero: central differences of fourth order."""
    return (8 * (function(h) - function(-h)) - function(2 * h) + function(-2 * h)) / (12 * h)


def relative(value, expected) -> float:
    """Largest difference, relative to the largest expected entry (which must not be zero)."""
    size = np.abs(expected).max()
    if not size > 1e-9:
        raise ValueError("an expected value of zero proves nothing")
    return float(np.abs(np.asarray(value) - expected).max() / size)
