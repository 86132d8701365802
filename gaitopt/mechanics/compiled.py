"""Which mechanics are compiled: inner loops over instants and joints, in C++.

The plain path, NumPy and Pinocchio, computes the same and is the oracle of the tests. It takes over
where the kernels were not built, or are not wanted: GAITOPT_COMPILED=0 in the environment. Why
there are two: docs/decisions/compiled.md.

Kernels of other sources, as after an update of a clone, are not used either: a warning says so.
"""

from __future__ import annotations

import os
import warnings
import zlib
from pathlib import Path

import numpy as np
import pinocchio as pin

from gaitopt.model.joint_tree import FIRST, TWIST, joint_axes
from gaitopt.model.robot import Robot, cached_workspace
from gaitopt.nlp import Array

try:
    from gaitopt.mechanics import kernels as kernels
except ImportError:
    BUILT = False
else:
    sources = sorted(Path(__file__).parents[1].glob("*/*.[ch]pp"))
    known = zlib.crc32(b"".join(file.read_bytes() for file in sources))
    BUILT = not sources or known == getattr(kernels, "SOURCES", None)
    if not BUILT:
        warnings.warn(
            "gaitopt's kernels were compiled from other sources, so that a walk takes a "
            "third longer; install gaitopt again, or: python setup.py build_ext --inplace --force",
            stacklevel=1,
        )

WANTED = os.environ.get("GAITOPT_COMPILED", "1") != "0"


def in_use() -> bool:
    """Return whether the kernels compute, not the plain path."""
    return BUILT and WANTED


class MadeAnew:
    """What has something compiled in `_compiled`: copies and pickles make that anew."""

    def __getstate__(self) -> dict[str, object]:
        return {name: value for name, value in vars(self).items() if name != "_compiled"}


class _Compiled:
    def __init__(self, robot: Robot) -> None:
        model = robot.model
        joints = range(FIRST, model.njoints)
        placements = [model.jointPlacements[j] for j in joints]
        frames = [
            model.frames[frame].placement for frame in (robot.pelvis_frame, robot.swing_frame)
        ]
        inertias = [model.inertias[j] for j in range(FIRST - 1, model.njoints)]
        self.bodies = kernels.Bodies(
            parents=list(robot.tree.parents),
            foot=robot.tree.swing_foot - 1,
            placements=_rows(placements),
            axes=joint_axes(model),
            inertias=np.array([[b.mass, *b.lever, *b.inertia.ravel()] for b in inertias]),
            frames=_rows(frames),
            armature=np.array(model.armature[TWIST:]),
            gravity=np.array(model.gravity.linear),
        )


def _rows(placements: list[pin.SE3]) -> Array:
    return np.array([[*p.rotation.ravel(), *p.translation] for p in placements])


def bodies_of(robot: Robot) -> kernels.Bodies:
    """Return the robot as the kernels have it, made once."""
    return cached_workspace(robot, _Compiled).bodies


def landing_of(robot: Robot, line: Array | None) -> kernels.Landing:
    """Return an impact of a robot none of whose joints follows another by a bend.

    Args:
        robot: rooted at its old stance sole.
        line: twist of the line of the landing sole on which it lands, shape (6,); None: flat.
    """
    ties = robot.coupling
    return kernels.Landing(
        robot=bodies_of(robot),
        motors=ties.motor.tolist(),
        slopes=ties.coefficients[:, 1],
        line=line,
    )


def linear_rows() -> kernels.LinearRows:
    """Return rows of constant matrices and quantities, as yet without any."""
    return kernels.LinearRows()
