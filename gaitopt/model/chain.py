"""A robot's reading made symmetric and re-rooted at the stance sole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.errors import RobotError
from gaitopt.importers.report import Finding, fault_error, faults_of
from gaitopt.importers.urdf_check import refuse_unsound
from gaitopt.model.chain_physics import ChainPhysics, chain_physics
from gaitopt.model.importer import Reading
from gaitopt.model.legs.leg_geometry import HIP_JOINTS, ChainLines, centre, common_point, find_knee
from gaitopt.model.physics_report import tell_physics
from gaitopt.model.report import tell_pairs, tell_symmetry
from gaitopt.model.reroot import PELVIS_FRAME, lock_upper_body, reroot
from gaitopt.model.symmetry.averaging import Sides, Symmetrised, asymmetry_faults, symmetrise
from gaitopt.model.symmetry.leg_exchange import exchange_error, joint_lines, leg_exchange
from gaitopt.nlp import Array

_SYMMETRY_TOLERANCE = 1e-8  # relative: a half step and its mirror must be the same motion


@dataclass(frozen=True)
class Chain:
    """A biped rooted at its stance sole.

    Attributes:
        model: free-flyer, stance leg from ankle to hip, swing leg from hip to ankle.
        names: of the twelve joints.
        mirror: the leg exchange E, shape (12, 12).
        lines: joint lines at the neutral posture.
        symmetry: what making it symmetric took, rooted at the pelvis.
        physics: passive joints, gravity and carried weight.
        findings: what was changed to make it symmetric, what mirrors what, and what of its physics
            counts.
    """

    model: pin.Model
    names: tuple[str, ...]
    mirror: Array
    lines: ChainLines
    symmetry: Symmetrised
    physics: ChainPhysics
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
        RobotError: with all that keeps the robot from being used: what the reading found, a joint
            or a body of the file that is unsound, a difference between the robot and its mirror
            image that matters more than `choices.asymmetry`, its physics (see `chain_physics`).
    """
    reduced = lock_upper_body(reading.model, *reading.sole_names, reading.q)
    faults = list(reading.faults)
    try:
        refuse_unsound(reduced, reading.problems)
    except RobotError as error:
        faults += faults_of(error)
        _forget_inertias(reduced)
    done = symmetrise(reduced, *_sides(reading, reduced))
    faults += asymmetry_faults(done, reading.choices.asymmetry, reading.drawn_unequally)
    model = reroot(done.model, *reading.sole_names)
    names = tuple(str(n) for n in model.names[2:])
    lines = _place_pelvis(model, reading)
    mirror = leg_exchange(lines.axes, np.repeat([-1.0, 1.0], 6))
    try:
        physics = chain_physics(model, mirror, lines.pelvis, reading.rotation, reading.physics)
        _refuse_hanging(model, physics)
    except RobotError as error:
        raise fault_error([*faults, *faults_of(error)]) from error
    if faults:
        raise fault_error(faults)
    model.gravity = pin.Motion(physics.gravity, np.zeros(3))
    off = exchange_error(model, mirror, *reading.sole_names)
    if off > _SYMMETRY_TOLERANCE:
        raise RobotError(
            f"the robot differs from its mirror image by {off:.3g} (relative, placement of the "
            f"feet and kinetic energy); allowed is {_SYMMETRY_TOLERANCE:g}. Make the two legs and "
            "the trunk symmetric in the URDF"
        )
    told = tell_physics(
        reading.described, reading.physics, physics, names, reading.rotation, reading.limits.torque
    )
    findings = (*tell_pairs(names, mirror), *tell_symmetry(done), *told)
    return Chain(model, names, mirror, lines, done, physics, findings)


def _refuse_hanging(model: pin.Model, physics: ChainPhysics) -> None:
    """Refuse a robot that nothing presses on the ground."""
    carried = 0.0 if physics.carried is None else float(physics.carried.mass.sum())
    mass = pin.computeTotalMass(model)
    if carried >= mass:
        raise RobotError(
            f"gravity compensation carries {carried:.4g} kg of the robot's {mass:.4g} kg, so that "
            "nothing presses its feet on the ground; correct the file, or leave it out: "
            "--without gravity-compensation (in Python and in the file for --choices "
            'without = ["gravity-compensation"])'
        )


def _forget_inertias(model: pin.Model) -> None:
    """Put equal balls in the place of all bodies, so that the joints can still be compared."""
    for joint in range(1, model.njoints):
        model.inertias[joint] = pin.Inertia.FromSphere(1.0, 0.1)


def _sides(reading: Reading, reduced: pin.Model) -> tuple[Sides, float]:
    """Legs of the reduced model with the mirror plane between them, and the length of a leg [m]."""
    right, left = (
        tuple(int(reduced.getJointId(reading.model.names[j])) for j in leg) for leg in reading.legs
    )
    points, axes = joint_lines(reduced, pin.SE3.Identity())
    hips = [[j - 2 for j in leg[:3]] for leg in (right, left)]
    centres = [common_point(points[rows], axes[rows]) for rows in hips]
    middle = (centres[0] + centres[1]) / 2.0
    plane = pin.SE3(reading.rotation, middle)
    rows = [j - 2 for j in right]
    ankle = common_point(points[rows[4:]], axes[rows[4:]])
    length = find_knee(points[rows], axes[rows], centres[0], ankle, np.zeros(6)).reach
    return Sides(right, left, reading.soles.names, plane), length


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
