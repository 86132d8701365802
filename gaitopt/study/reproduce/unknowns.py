"""The five values that the paper does not print and that move its costs most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Array
from gaitopt.robot.generated.inertia import box_inertia
from gaitopt.robot.generated.presets import biped13
from gaitopt.robot.generated.spec import BipedSpec
from gaitopt.robot.generated.spec_table import changed
from gaitopt.study.reproduce.printed import printed
from gaitopt.study.reproduce.walks import (
    biped_robot,
    identified_biped,
    identified_margins,
    paper_task,
)


@dataclass(frozen=True)
class Unknown:
    """A value to be identified.

    Attributes:
        name: short.
        unit: of the value, empty if it has none.
        lower, upper: what a machine of this kind may have.
        meaning: what it is and why the paper leaves it open.
    """

    name: str
    unit: str
    lower: float
    upper: float
    meaning: str


UNKNOWNS = (
    Unknown(
        "knee flexion", "rad", 0.3, 1.1,
        "least bend of both knees over the step: stands for the joint range (30) and l_hip (31), "
        "of which no number is printed; it sets the cost of slow walks",
    ),
    Unknown(
        "joint speed limit", "rad/s", 3.0, 10.0,
        "of Eq. (29), the same for all joints; it sets the cost of fast walks",
    ),
    Unknown(
        "torso inertia", "of the box", 0.4, 2.5,
        "inertia about the centre of mass over that of a homogeneous box of 0.2 x 0.3 x 0.595 m",
    ),
    Unknown(
        "torso centre of mass", "m", 0.2, 0.42, "height above the hips; the torso is 0.595 m tall"
    ),
    Unknown(
        "ankle position l1", "m", -0.19, -0.107,
        "from the toe edge to the ankle, along the foot of 0.214 m: from 24 mm before the heel to "
        "the middle; the foot's centre of mass stays at its middle",
    ),
)  # fmt: skip
"""With the ranges in which they were sought."""

_TORSO_TOP = 0.595  # m above the hips: 1.30 m above the ground; drawn only
_SOLE_MIDDLE = 0.107  # m behind the toe edge
_JOINTS = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")


def identified_values() -> Array:
    """Return the values of the catalogue's biped, in the order of `UNKNOWNS`."""
    spec = identified_biped()
    torso, box = spec.links.torso, biped13().links.torso
    factor = torso.com_inertia[1][1] / box.com_inertia[1][1]
    return np.array(
        [
            identified_margins()["knee_flexion"],
            spec.joints.knee.speed,
            factor,
            torso.com[2],
            spec.geometry.l1,
        ]
    )


def biped_with(values: Sequence[float] | Array) -> BipedSpec:
    """Return the paper's biped with the unknowns that belong to the machine.

    Args:
        values: in the order of `UNKNOWNS`.

    Raises:
        SpecError: a value is not physical.
    """
    _, speed, factor, com, l1 = (float(value) for value in values)
    torso = biped13().links.torso
    inertia = np.array(box_inertia(torso.mass, torso.size)) * factor
    width, depth, _ = torso.size
    machine = {
        "geometry.l1": l1,
        "links.foot.com": (-l1 - _SOLE_MIDDLE, 0.0, biped13().links.foot.com[2]),
        "links.torso.com": (0.0, 0.0, com),
        "links.torso.size": (width, depth, 2.0 * (_TORSO_TOP - com)),
        "links.torso.inertia": tuple(map(tuple, inertia.tolist())),
    }
    limits = {f"joints.{joint}.speed": speed for joint in _JOINTS}
    return changed(biped13(), {**machine, **limits})


def walks_with(values: Sequence[float] | Array) -> list[WalkProblem]:
    """Return the walks at the eight speeds of Table 3.

    Args:
        values: in the order of `UNKNOWNS`.

    Raises:
        InputError: a value cannot be used.
    """
    robot = biped_robot(biped_with(values))
    margins = {**identified_margins(), "knee_flexion": float(values[0])}
    return [WalkProblem(robot, paper_task(v, margins)) for v in printed().speeds]
