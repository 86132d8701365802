"""Bipeds that nobody built, with legs of any number of joints, a waist and arms."""

import functools

import numpy as np

from gaitopt.model.robot import Robot
from gaitopt.model.sole import Sole

SOLE = Sole(toe=0.14, heel=-0.08, left=0.055, right=-0.055)
REFLECT = np.array([1.0, -1.0, 1.0])

# name, origin in the link before (left side) [m], axis, mass of the link it moves [kg]
SEVEN = (
    ("hip_yaw", (0.0, 0.09, -0.04), (0.05, 0.03, 1.0), 1.2),
    ("hip_roll", (0.01, 0.0, 0.0), (1.0, 0.02, 0.0), 1.1),
    ("hip_pitch", (-0.01, 0.0, 0.0), (0.0, 1.0, 0.04), 4.0),
    ("knee", (0.005, 0.01, -0.36), (0.0, 1.0, 0.02), 2.0),
    ("shank_twist", (0.0, 0.0, -0.15), (0.03, 0.0, 1.0), 1.0),
    ("ankle_pitch", (0.0, 0.0, -0.19), (0.0, 1.0, 0.0), 0.5),
    ("ankle_roll", (0.0, 0.0, 0.0), (1.0, 0.0, 0.05), 0.9),
)
SIX = (*SEVEN[:4], *SEVEN[5:])
FIVE = (
    ("hip_roll", (0.0, 0.09, -0.04), (1.0, 0.02, 0.0), 1.1),
    *SEVEN[2:4],
    ("ankle_pitch", (0.0, 0.0, -0.34), (0.0, 1.0, 0.0), 0.5),
    SEVEN[6],
)
ARM = (
    ("shoulder_pitch", (0.01, 0.2, 0.3), (0.02, 1.0, 0.1), 0.9),
    ("shoulder_roll", (0.0, 0.02, 0.0), (1.0, 0.05, 0.0), 1.4),
    ("elbow", (0.02, 0.01, -0.28), (0.1, 1.0, 0.0), 1.0),
)
FIN = (("fin", (-0.03, 0.02, -0.1), (0.1, 0.3, 1.0), 0.3),)
WAISTS = {"yaw": (0.0, 0.0, 1.0), "pitch": (0.0, 1.0, 0.0), "roll": (1.0, 0.0, 0.0)}
MOVING = tuple(f"{side}_{name}" for side in ("left", "right") for name, *_ in ARM)


def _numbers(values: object) -> str:
    return " ".join(repr(float(v)) for v in np.asarray(values))


def _link(name: str, mass: float, rng: np.random.Generator | None, side: float) -> str:
    """A link whose centre of mass and inertia are random, mirrored on the right side."""
    rng = rng or np.random.default_rng(0)
    centre = rng.uniform(-0.03, 0.03, 3) - [0.0, 0.0, 0.05]
    points = rng.normal(0.0, 0.05, (6, 3))  # of which the body is made: its inertia can exist
    points -= points.mean(axis=0)
    inertia = mass / 6.0 * ((points**2).sum() * np.eye(3) - points.T @ points)
    turn = np.diag([1.0, side, 1.0])
    inertia, centre = turn @ inertia @ turn, turn @ centre
    if side == 0.0:  # in the mirror plane
        inertia = np.diag([0.06, 0.05, 0.03]) * mass / 8.0
        inertia[0, 2] = inertia[2, 0] = 0.002
        centre = np.array([0.01, 0.0, 0.08])
    entries = zip(
        ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), inertia[np.triu_indices(3)], strict=True
    )
    told = " ".join(f'{key}="{float(value)!r}"' for key, value in entries)
    return (
        f'<link name="{name}"><inertial><origin xyz="{_numbers(centre)}"/>'
        f'<mass value="{mass!r}"/><inertia {told}/></inertial></link>'
    )


def _joint(name: str, parent: str, child: str, origin: object, axis: object) -> str:
    unit = np.asarray(axis) / np.linalg.norm(axis)
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{_numbers(origin)}"/><axis xyz="{_numbers(unit)}"/>'
        '<limit effort="150" velocity="12" lower="-2.5" upper="2.5"/></joint>'
    )


def _limb(parent: str, side: str, joints: tuple) -> list[str]:
    sign, parts = (1.0 if side == "left" else -1.0), []
    for seed, (name, origin, axis, mass) in enumerate(joints):
        flip = np.array([1.0, sign, 1.0])
        link = f"{side}_{name}_link"
        parts.append(_link(link, mass, np.random.default_rng(seed + 7 * len(joints)), sign))
        parts.append(_joint(f"{side}_{name}", parent, link, flip * origin, flip * axis))
        parent = link
    return parts


def biped_urdf(
    leg: tuple, arm: tuple = (), waist: str = "", root: str = "pelvis", fin: tuple = ()
) -> str:
    """The URDF of a biped, rooted at its pelvis or at its torso; fins hang on its shanks."""
    parts = [_link("pelvis", 6.0, None, 0.0)]
    if waist:
        parts.append(_link("torso", 12.0, None, 0.0))
        origin = np.array([0.02, 0.0, 0.1])
        ends = ("pelvis", "torso") if root == "pelvis" else ("torso", "pelvis")
        parts.append(_joint("waist", *ends, origin if root == "pelvis" else -origin, WAISTS[waist]))
    for side in ("left", "right"):
        parts += _limb("pelvis", side, leg)
        foot = f"{side}_{leg[-1][0]}_link"
        parts.append(f'<link name="{side}_sole"/>')
        parts.append(
            f'<joint name="{side}_sole_joint" type="fixed"><parent link="{foot}"/>'
            f'<child link="{side}_sole"/><origin xyz="0.01 0 -0.07"/></joint>'
        )
        parts += _limb("torso" if waist else "pelvis", side, arm)
        parts += _limb(f"{side}_knee_link", side, fin)
    return f'<robot name="synthetic">{"".join(parts)}</robot>'


def _robot(urdf: str, moving: tuple[str, ...]) -> Robot:
    return Robot.from_urdf(
        urdf, stance_sole="right_sole", swing_sole="left_sole", sole=SOLE, moving=moving
    )


_MAKERS = {
    "seven, waist and arms": lambda: _robot(biped_urdf(SEVEN, ARM, "yaw"), ("waist", *MOVING)),
    "seven, torso first": lambda: _robot(
        biped_urdf(SEVEN, ARM, "pitch", "torso"), ("waist", *MOVING)
    ),
    "five": lambda: _robot(biped_urdf(FIVE), ()),
    "five and arms": lambda: _robot(biped_urdf(FIVE, ARM), MOVING),
    "six, waist and arms": lambda: _robot(biped_urdf(SIX, ARM, "yaw"), ("waist", *MOVING)),
    "five and fins": lambda: _robot(biped_urdf(FIVE, fin=FIN), ("left_fin", "right_fin")),
}
SYNTHETIC = tuple(_MAKERS)


@functools.cache
def synthetic(name: str) -> Robot:
    """One of `SYNTHETIC`."""
    return _MAKERS[name]()
