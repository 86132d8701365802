"""A robot made symmetric and re-rooted at the stance sole.

Its sizes are judged as well (`size_doubts`): a wrong unit passes every other check.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.pinocchio_model import refuse_unsound
from gaitopt.importers.report import Finding, fault_error, faults_of
from gaitopt.model.chain_physics import ChainPhysics, chain_physics, physics_findings
from gaitopt.model.coupling import couple
from gaitopt.model.importer import ImportedRobot, pair_findings, symmetry_findings
from gaitopt.model.joint_tree import (
    FIRST,
    PELVIS_FRAME,
    JointTree,
    joint_tree,
    lock_upper_body,
    reroot,
    reversed_joints,
)
from gaitopt.model.leg_geometry import (
    ChainLines,
    centre,
    common_point,
    find_knee,
    hip_and_ankle,
    leg_rows,
)
from gaitopt.model.sole import Sole
from gaitopt.model.symmetry import (
    Sides,
    Symmetrised,
    asymmetry_faults,
    exchange_error,
    joint_lines,
    leg_exchange,
    symmetrise,
)
from gaitopt.nlp import Array

_SYMMETRY_TOLERANCE = 1e-8  # relative: a half step and its mirror must be the same motion


@dataclass(frozen=True)
class RootedChain:
    """A biped rooted at its stance sole.

    Attributes:
        model: free-flyer, stance leg from ankle to hip, swing leg from hip to ankle, other branches
            that move.
        tree: of its joints.
        mirror: the leg exchange E, shape (n, n).
        lines: joint lines at the neutral posture.
        physics: passive joints, gravity and carried weight.
        findings: what was changed to make it symmetric, what mirrors what, and what of its physics
            counts.
        heading: forward, left and up of the robot in its root link, columns, shape (3, 3).
        symmetry: the same robot, rooted as in its file, and what making it symmetric took.
    """

    model: pin.Model
    tree: JointTree
    mirror: Array
    lines: ChainLines
    physics: ChainPhysics
    findings: tuple[Finding, ...]
    heading: Array
    symmetry: Symmetrised

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints."""
        return self.tree.names

    @property
    def pelvis(self) -> str:
        """Name of the pelvis frame."""
        return self.lines.frame


def build_chain(reading: ImportedRobot) -> RootedChain:
    """Lock the upper body, make the robot its own mirror image, and root it at the stance sole.

    Raises:
        RobotError: with all that keeps the robot from being used: what the reading found, a joint
            or a body of the file that is unsound, a difference between the robot and its mirror
            image that matters more than `choices.asymmetry`, its physics (see `chain_physics`).
    """
    names = reading.model.names
    moving = [str(names[j]) for pair in reading.others for j in pair]
    partner = dict[str, str]()
    for pair in (*zip(*reading.legs, strict=True), *reading.others):
        first, other = (str(names[j]) for j in pair)
        partner[first], partner[other] = other, first
    reduced = lock_upper_body(reading.model, *reading.sole_names, reading.q, moving)
    faults = list(reading.faults)
    try:
        refuse_unsound(reduced, reading.problems)
    except RobotError as error:
        faults += faults_of(error)
        for joint in range(1, reduced.njoints):  # so that the joints can still be compared
            reduced.inertias[joint] = pin.Inertia.FromSphere(1.0, 0.1)
    done = symmetrise(reduced, *_sides(reading, reduced))
    faults += asymmetry_faults(done, reading.choices.asymmetry, reading.drawn_unequally)
    model = reroot(done.model, *reading.sole_names)
    feet = [int(model.frames[model.getFrameId(s)].parentJoint) for s in reading.sole_names]
    tree = joint_tree(model, feet[0] + len(reading.legs[0]), feet[1])
    lines = _place_pelvis(model, _root_link(done.model), reading.rotation, tree)
    against = reversed_joints(done.model, reading.sole_names[0])
    outward = np.array([-1.0 if name in against else 1.0 for name in tree.names])
    mirror = leg_exchange(lines.axes, outward, [tree.names.index(partner[n]) for n in tree.names])
    try:  # a tie that no mirror leaves as it is bends the legs unequally: tell that first
        couple(tree.names, reading.ties, mirror).exchange()
    except RobotError as error:
        faults = [*faults_of(error), *faults]
    try:
        physics = chain_physics(
            model, tree, mirror, lines.pelvis, reading.rotation, reading.physics
        )
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
    findings = (
        *pair_findings(tree.names, mirror),
        *symmetry_findings(done),
        *physics_findings(
            reading.described,
            reading.physics,
            physics,
            tree.names,
            reading.rotation,
            reading.limits.torque,
            reading.choices.gravity,
        ),
    )
    return RootedChain(model, tree, mirror, lines, physics, findings, reading.rotation, done)


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


def _sides(reading: ImportedRobot, reduced: pin.Model) -> tuple[Sides, float]:
    """Legs of the reduced model with the mirror plane between them, and the length of a leg [m]."""

    def there(joint: int) -> int:
        return int(reduced.getJointId(reading.model.names[joint]))

    right, left = (tuple(map(there, leg)) for leg in reading.legs)
    points, axes = joint_lines(reduced, pin.SE3.Identity())
    hips = []
    for leg in (left, right):
        rows = [j - FIRST for j in leg]
        hip, ankle = hip_and_ankle(points[rows], axes[rows])
        hips.append(common_point(points[rows][hip], axes[rows][hip]))
    end = common_point(points[rows][ankle], axes[rows][ankle])
    length = find_knee(points[rows], axes[rows], hips[1], end, np.zeros(len(rows))).reach
    plane = pin.SE3(reading.rotation, (hips[1] + hips[0]) / 2.0)
    others = tuple((there(first), there(second)) for first, second in reading.others)
    return Sides(right, left, reading.soles.names, plane, others), length


def _place_pelvis(model: pin.Model, root_link: str, rotation: Array, tree: JointTree) -> ChainLines:
    """Add the pelvis frame midway between the hips; return it with the joint lines in it."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    root = data.oMf[model.getFrameId(root_link)]
    points, axes = joint_lines(model, root)
    R = rotation
    hips = []
    for rows in leg_rows(tree.stance):
        part = hip_and_ankle(points[rows], axes[rows])[0]
        hips.append(centre(points[rows] @ R, axes[rows] @ R, part))
    middle = R @ ((hips[0] + hips[1]) / 2.0)
    name = PELVIS_FRAME
    while model.existFrame(name):
        name += "_centre"
    joint = tree.pelvis + 1
    pelvis = root * pin.SE3(R, middle)
    placement = data.oMi[joint].actInv(pelvis)
    model.addFrame(pin.Frame(name, joint, placement, pin.FrameType.OP_FRAME), False)
    return ChainLines(model, name, pelvis, (points - middle) @ R, axes @ R, tree.stance)


def _root_link(model: pin.Model) -> str:
    frames = (f for f in model.frames if f.type == pin.FrameType.BODY)
    return next(str(f.name) for f in frames if f.name != "universe")


# Between a toy and an excavator: a unit that is wrong is wrong by a thousand, and falls outside.
_REACH = (0.1, 5.0)  # m, from hip to ankle
_MASS = (0.5, 1000.0)  # kg
# Radius of gyration of a leg's body per length of the leg. A rod as long as the leg has 0.29, a
# drawing with generous inertias 1.1; lumps of a few millimetres have 0.01.
_GYRATION = (1e-3, 3.0)


def size_doubts(chain: RootedChain, reach: float, sole: Sole, height: float) -> list[Finding]:
    """Return what is odd, given reach of the legs and height of the ankles above the soles [m].

    Raises:
        RobotError: the sole is longer or wider than the legs.
    """
    _check_sole(sole, reach)
    findings = []
    if height < 0.0:
        text = (
            f"the soles lie {fixed(-1e3 * height, 1)} mm above the ankles, where no foot has its "
            "own; has the place of their shapes the wrong sign?"
        )
        findings.append(Finding("sole", "both feet", text, "warning"))
    if not _REACH[0] <= reach <= _REACH[1]:
        text = (
            f"the legs are {reach:.4g} m long from hip to ankle; {_REACH[0]:g} to {_REACH[1]:g} m "
            f"are plausible; {_question('lengths', 'm', reach, _REACH, {'mm': 1e-3, 'cm': 1e-2})}"
        )
        findings.append(Finding("legs", "both legs", text, "warning"))
    mass = float(pin.computeTotalMass(chain.model))
    if not _MASS[0] <= mass <= _MASS[1]:
        text = (
            f"the robot weighs {mass:.4g} kg; {_MASS[0]:g} to {_MASS[1]:g} kg are plausible; "
            f"{_question('masses', 'kg', mass, _MASS, {'g': 1e-3})}"
        )
        findings.append(Finding("mass", "robot", text, "warning"))
    # A wrong unit of length or mass makes every radius of gyration look wrong as well.
    return findings or _gyration_doubts(chain, reach)


def _question(
    what: str, unit: str, value: float, plausible: tuple[float, float], others: dict[str, float]
) -> str:
    """Say in which unit numbers must be, and ask whether they are in one where they would fit."""
    least, most = plausible
    fits = [other for other, size in others.items() if least <= value * size <= most]
    return (
        f"are {what} of the file in {fits[0]}? They must be in {unit}"
        if fits
        else (f"{what} of the file must be in {unit}")
    )


def _check_sole(sole: Sole, reach: float) -> None:
    length, width = sole.length, sole.width
    if max(length, width) > reach:
        raise RobotError(
            f"the sole is {length:.4g} m long and {width:.4g} m wide, but the legs measure only "
            f"{reach:.4g} m from hip to ankle; no foot is larger than its leg. Give all lengths in "
            "m, not in mm: in the URDF, and for the sole (toe, heel, left, right)"
        )


def _gyration_doubts(chain: RootedChain, reach: float) -> list[Finding]:
    """Look at the bodies of the swing leg; those of the other one are their mirror images."""
    small, large = [], []
    for name in chain.names[chain.tree.stance :]:
        body = chain.model.inertias[chain.model.getJointId(name)]
        if not body.mass > 0.0:
            continue
        moment = max(float(np.linalg.eigvalsh(body.inertia)[-1]), 0.0)
        radius = float(np.sqrt(moment / body.mass))
        if radius < _GYRATION[0] * reach:
            small.append((name, moment, radius))
        elif radius > _GYRATION[1] * reach:
            large.append((name, moment, radius))
    least, most = (1e3 * limit * reach for limit in _GYRATION)
    return [
        *_told(small, f"below {least:.2g} mm is implausible; are inertias left out of the file?"),
        *_told(large, f"above {most:.4g} mm is implausible; are they in g·m² or kg·mm²?"),
    ]


def _told(bodies: list[tuple[str, float, float]], text: str) -> list[Finding]:
    if not bodies:
        return []
    name, moment, radius = bodies[0]
    told = (
        f"the link that '{name}' moves has moments of inertia up to {moment:.3g} kg·m², a radius "
        f"of gyration of {1e3 * radius:.4g} mm; {text} They must be in kg·m²"
    )
    others = len(bodies) - 1
    subject = name if others == 0 else f"{name} and {others} more of each leg"
    return [Finding("inertia", subject, told, "warning")]
