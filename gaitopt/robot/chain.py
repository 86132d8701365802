"""A robot's reading made symmetric and re-rooted at the stance sole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.nlp import Array
from gaitopt.robot.findings import Finding
from gaitopt.robot.legs.measures import HIP_JOINTS, ChainLines, centre, common_point
from gaitopt.robot.mirror.symmetrise import Sides, symmetrise
from gaitopt.robot.mirror.symmetry import exchange_error, joint_lines, leg_exchange
from gaitopt.robot.reading import Reading
from gaitopt.robot.reroot import PELVIS_FRAME, lock_upper_body, reroot
from gaitopt.robot.telling import tell_pairs, tell_symmetry
from gaitopt.robot.urdf.check import refuse_unsound

_SYMMETRY_TOLERANCE = 1e-8  # relative: a half step and its mirror must be the same motion


@dataclass(frozen=True)
class Chain:
    """A biped rooted at its stance sole.

    Attributes:
        model: free-flyer, stance leg from ankle to hip, swing leg from hip to ankle.
        names: of the twelve joints.
        mirror: the leg exchange E, shape (12, 12).
        lines: joint lines at the neutral posture.
        findings: what was changed to make it symmetric, and what mirrors what.
    """

    model: pin.Model
    names: tuple[str, ...]
    mirror: Array
    lines: ChainLines
    findings: tuple[Finding, ...]

    @property
    def pelvis(self) -> str:
        """Name of the pelvis frame."""
        return self.lines.frame


def build_chain(reading: Reading) -> Chain:
    """Lock the upper body, make the robot its own mirror image, and root it at the stance sole.

    Args:
        reading: of the robot.

    Raises:
        RobotError: a joint or a body of the file is unsound, or the robot differs from its mirror
            image by more than `choices.asymmetry`.
    """
    reduced = lock_upper_body(reading.model, *reading.sole_names, reading.q)
    refuse_unsound(reduced, reading.problems)
    done = symmetrise(reduced, _sides(reading, reduced), reading.choices.asymmetry)
    model = reroot(done.model, *reading.sole_names)
    names = tuple(str(n) for n in model.names[2:])
    lines = _place_pelvis(model, reading)
    mirror = leg_exchange(names, lines.points, lines.axes, np.repeat([-1.0, 1.0], 6))
    error = exchange_error(model, mirror, *reading.sole_names)
    if error > _SYMMETRY_TOLERANCE:
        raise RobotError(
            f"the robot differs from its mirror image by {error:.3g} (relative, placement of the "
            f"feet and kinetic energy); allowed is {_SYMMETRY_TOLERANCE:g}. Make the two legs and "
            "the trunk symmetric in the URDF"
        )
    findings = (*tell_pairs(names, mirror), *tell_symmetry(done))
    return Chain(model, names, mirror, lines, findings)


def _sides(reading: Reading, reduced: pin.Model) -> Sides:
    """Legs of the reduced model, and the mirror plane between them."""
    right, left = (
        tuple(int(reduced.getJointId(reading.model.names[j])) for j in leg) for leg in reading.legs
    )
    points, axes = joint_lines(reduced, pin.SE3.Identity())
    hips = [[j - 2 for j in leg[:3]] for leg in (right, left)]
    middle = sum(common_point(points[rows], axes[rows]) for rows in hips) / 2.0
    plane = pin.SE3(reading.rotation, middle)
    return Sides(right, left, reading.soles.names, plane)


def _place_pelvis(model: pin.Model, reading: Reading) -> ChainLines:
    """Add the pelvis frame midway between the hips; return it with the joint lines in it."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    frames = (f for f in reading.model.frames if f.type == pin.FrameType.BODY)
    root_name = next(f.name for f in frames if f.name != "universe")
    root = data.oMf[model.getFrameId(root_name)]
    points, axes = joint_lines(model, root)
    R = reading.rotation
    hips = [centre(points @ R, axes @ R, rows) for rows in HIP_JOINTS]
    middle = R @ ((hips[0] + hips[1]) / 2.0)
    name = PELVIS_FRAME
    while model.existFrame(name):
        name += "_centre"
    frame = model.frames[model.getFrameId(root_name)]
    placement = frame.placement * pin.SE3(R, middle)
    model.addFrame(pin.Frame(name, frame.parentJoint, placement, pin.FrameType.OP_FRAME), False)
    return ChainLines(model, name, root * pin.SE3(R, middle), (points - middle) @ R, axes @ R)
