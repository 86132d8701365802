"""What a description holds: its legs, where it looks, its soles; and what is said of that.

Nothing is changed yet: `chain` makes the robot its own mirror image.
"""

from __future__ import annotations

import glob
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.physics import (
    LOOPS,
    TIES,
    LoopFrames,
    Physics,
    Tie,
    is_generated,
    ties_among,
)
from gaitopt.importers.report import Finding, How, fault_error, faults_of
from gaitopt.importers.source import Source
from gaitopt.importers.urdf_check import locked_mimics
from gaitopt.importers.xml_document import FileProblem
from gaitopt.model.chain_physics import armature_findings, loop_findings
from gaitopt.model.coupling import couple
from gaitopt.model.heading import Heading, axis_name, find_heading, leg_lines
from gaitopt.model.import_options import AXES, SIDES, ImportOptions, LimitOverride
from gaitopt.model.joint_limits import JointLimits, joint_limits
from gaitopt.model.kinematic_tree import LOOP, LegJoints, PosedModel, pose_model
from gaitopt.model.leg_detection import (
    LegPair,
    named_feet,
    no_legs,
    number_word,
    speaks_for_other_side,
    standing_side,
)
from gaitopt.model.leg_geometry import missing_joints
from gaitopt.model.linkage import Linkage
from gaitopt.model.loops import apply_loops, leg_loops, rods_on_balls
from gaitopt.model.overrides import (
    add_payloads,
    loaded_joints,
    override,
    override_bodies,
    without_armature,
    without_mended,
)
from gaitopt.model.proportions import change_feet, proportioned
from gaitopt.model.reference_posture import (
    reference_angles,
    reference_configuration,
    rotor_armatures,
    with_ties,
)
from gaitopt.model.sole_detection import FootShape, FoundSole, find_sole, foot_points
from gaitopt.model.sole_frames import Soles, choose_soles, placement_numbers
from gaitopt.model.stance import Stance, flat_stance, legs_at_zero, level_feet, standing_legs
from gaitopt.model.symmetry import Symmetrised, leg_exchange
from gaitopt.model.upper_body import Pairs, moving_joints, moving_pairs
from gaitopt.nlp import Array

_LEAST_LISTED_EFFECT = 1e-5  # effect: differences that matter less are counted


def _leg_findings(
    model: pin.Model,
    q: Array,
    pair: LegPair,
    heading: Heading,
    angles: dict[str, float],
    others: Pairs = (),
) -> list[Finding]:
    """Return what was found about legs, heading and posture."""
    findings = []
    names = [[str(model.names[j]) for j in leg] for leg in pair.legs]
    for side, own in zip(SIDES, names, strict=True):
        text = f"{number_word(len(own))} joints from hip to ankle: {', '.join(own)}"
        findings.append(Finding("legs", f"{side} leg", text))
    if speaks_for_other_side(names[0], names[1]):
        text = "is the right leg by its place, though its joints' names speak for the left one"
        findings.append(Finding("heading", names[0][0], text, "warning"))
    if pair.beyond:
        toes = [str(model.names[j]) for j in pair.beyond]
        text = f"beyond the ankle: {', '.join(toes)}; locked, as part of the foot"
        findings.append(Finding("legs", "toes", text, "guessed"))
    if pair.tilt:
        findings.append(Finding("heading", "robot", pair.tilt, "guessed"))
    findings += _heading(heading)
    if others:
        moving = dict.fromkeys(str(model.names[j]) for joints in others for j in joints)
        findings.append(Finding("legs", "upper body", f"moves: {', '.join(moving)}", "given"))
    findings += _posture(model, q, [*pair.legs, *others], angles)
    return findings


def symmetry_findings(done: Symmetrised) -> list[Finding]:
    """Return what was changed to make the robot its own mirror image, and what that amounts to."""
    findings = []
    if done.filled:
        text = (
            "the file gives these links a mass but no inertia; it was taken from the mirrored "
            "partner in the other leg"
        )
        findings.append(Finding("symmetry", ", ".join(done.filled), text, "warning"))
    listed = [d for d in done.differences if d.effect.size >= _LEAST_LISTED_EFFECT]
    for d in listed:
        text = f"averaged left and right, which differed by {d.size}: {d.effect.brief()}"
        findings.append(Finding("symmetry", d.subject, text, "changed"))
    if done.differences:
        text = f"averaging left and right changed {done.effect.words()}"
        if more := len(done.differences) - len(listed):
            text += f"; {more} of {len(done.differences)} differences are too small to be listed"
        findings.append(Finding("symmetry", "robot", text, "changed"))
    return findings


def pair_findings(names: tuple[str, ...], mirror: Array) -> list[Finding]:
    """Return which joints mirror each other by a leg exchange (n, n), and with which sign."""
    findings = []
    partners = np.abs(mirror).argmax(axis=1)
    pairs = [row for row, partner in enumerate(partners) if row <= partner]
    for row in sorted(pairs, key=lambda row: int(partners[row])):
        partner = int(partners[row])
        sign = "equal" if mirror[row, partner] > 0.0 else "opposite"
        image = f"'{names[partner]}'" if partner != row else "itself"
        text = f"mirrors {image} with {sign} angles"
        findings.append(Finding("pairs", names[row], text))
    return findings


def _heading(heading: Heading) -> list[Finding]:
    forward, left, up = (_axis_words(heading.rotation[:, k]) for k in range(3))
    text = f"forward is {forward}, left {left}, up {up} of the root link: {heading.reasons}"
    findings = [Finding("heading", "robot", text, "given" if heading.given else "found")]
    if heading.doubt:
        findings.append(Finding("heading", "robot", heading.doubt, "warning"))
    return findings


def _axis_words(vector: Array) -> str:
    name = axis_name(vector)
    if isinstance(name, str):
        return f"+{name}" if name in AXES and name[0] != "-" else name
    return "(" + ", ".join(f"{n:.4g}" for n in name) + ")"


def _posture(
    model: pin.Model, q: Array, moved: Sequence[Sequence[int]], angles: dict[str, float]
) -> list[Finding]:
    moving = {j for joints in moved for j in joints}
    locked = [j for j in range(2, model.njoints) if j not in moving]
    findings = []
    if locked:
        bent = [
            f"{model.names[j]} {q[model.joints[j].idx_q]:.4g}"
            for j in locked
            if model.names[j] in angles and model.joints[j].nq == 1
        ]
        names = ", ".join(str(model.names[j]) for j in locked)
        at = f"at {', '.join(bent)} rad, the others at 0" if bent else "at 0"
        count = "one joint that is" if len(locked) == 1 else f"{len(locked)} joints that are"
        text = f"{count} not the legs', locked {at}: {names}"
        findings.append(Finding("posture", "upper body", text, "given" if angles else "guessed"))
    return findings


_SAME_REF = 1e-6  # rad: what rounding leaves between mirrored refs


@dataclass(frozen=True)
class ImportedRobot:
    """A robot as its file and the user have it.

    Attributes:
        model: the whole robot with both sole frames; free-flyer as joint 1.
        q: its reference posture [rad], root at the origin.
        legs: joint ids of the right and of the left leg from hip to ankle.
        others: other joints that move: right and left, or one in the middle twice.
        rotation: forward, left and up of the robot in its root link, columns, shape (3, 3).
        soles: frames and rectangle.
        stance: index of the standing foot, 0 right or 1 left.
        limits: of the joints, in the order of `joints`.
        physics: what counts of its passive joints, gravity and carried weight.
        described: the same before `choices.without` left anything out.
        choices: every guess made explicit.
        findings: what was learnt, in the order of reading.
        faults: what keeps it from being used, to be told together with all else that does.
        problems: what was suspicious in the file.
        drawn_unequally: joints of the legs whose `ref` of an MJCF file is not the mirror image of
            their partner's, in words.
        ties: of joints that move and follow others that do.
        linkages: of motors that turn joints of the right leg through loops of bodies.
    """

    model: pin.Model
    q: Array
    legs: LegJoints
    others: Pairs
    rotation: Array
    soles: Soles
    stance: int
    limits: JointLimits
    physics: Physics
    described: Physics
    choices: ImportOptions
    findings: tuple[Finding, ...]
    faults: tuple[str, ...]
    problems: tuple[FileProblem, ...]
    drawn_unequally: tuple[str, ...]
    ties: Mapping[str, Tie]
    linkages: tuple[Linkage, ...]

    @property
    def joints(self) -> tuple[int, ...]:
        """Ids of the joints that move; see `moving_joints`."""
        return moving_joints(self.legs, self.stance, self.others)[0]

    @property
    def sole_names(self) -> tuple[str, str]:
        """Names of the standing and of the other sole frame."""
        return self.soles.names[self.stance], self.soles.names[1 - self.stance]


def import_robot(source: Source, choices: ImportOptions) -> ImportedRobot:
    """Find legs, heading and soles of a robot.

    Raises:
        RobotError: it is not a biped with two legs, or something cannot be told.
    """
    folder = Path() if source.path is None else source.path.parent
    whole, bodies, mended = override_bodies(source.model(), choices.inertias)
    ties, loops, problems = _counting(source, choices, without_mended(source.problems, mended))
    angles = {**source.drawn_posture, **reference_angles(choices, whole, folder)}
    overrides = (*_rotors(choices, whole, folder), *choices.limits)
    if "armature" in choices.without:
        overrides = without_armature(overrides)
    model, notes = override(whole, overrides)
    if "armature" in choices.without:
        model.armature = np.zeros(model.nv)
    stands, apart = with_ties(model, reference_configuration(model, angles), ties, angles)
    unlooped = tuple(p for p in problems if p.kind != LOOP)
    posed = replace(pose_model(model, stands, unlooped), rods=rods_on_balls(model, source.loops))
    pair = standing_legs(source, posed, choices)
    faults = _empty_ranges(model, pair.legs, problems)
    pair, heading, shapes = _heading_with_feet(source, posed, pair, choices)
    closed = leg_loops(model, stands, loops, source.loop_motors, pair.legs, problems)
    apply_loops(model, closed)
    side = standing_side(model, pair.legs, choices)
    straight = legs_at_zero(posed, pair.legs)
    others, locked = moving_pairs(
        replace(posed, problems=problems), pair.legs, heading.rotation, choices.moving, ties,
        loaded_joints(model, choices.payloads),
    )  # fmt: skip
    if toes := {joint for both in others for joint in both} & {*pair.beyond}:
        pair = replace(pair, beyond=tuple(j for j in pair.beyond if j not in toes))
        shapes = _shapes(source, posed, pair, choices)
    sized: list[Finding] = []
    moving = (*pair.legs[0], *pair.legs[1], *(joint for both in others for joint in both))
    if choices.proportions:
        model, sized = proportioned(
            straight, pair.legs, moving, heading.rotation, choices.proportions
        )
        posed = pose_model(model, stands, unlooped)
        straight = legs_at_zero(posed, pair.legs)
    chain, partners = moving_joints(pair.legs, side, others)
    names = [str(model.names[joint]) for joint in chain]
    moving_ties, tied = _moving_ties(ties, names, apart, locked)
    axes = straight.axes[list(chain)] @ heading.rotation
    mirror = leg_exchange(axes, np.ones(len(chain)), partners)
    right = np.isin(chain, [*pair.legs[0], *(first for first, _ in others)])
    complete = couple(names, moving_ties, mirror).complete
    limits, odd, wrong = joint_limits(
        model, chain, mirror, choices.unequal_limits, right, complete, closed.armature
    )
    faults += () if faults else tuple(wrong)
    at = [model.joints[joint].idx_q for joint in chain]
    ranged = np.not_equal(
        [model.lowerPositionLimit[at], model.upperPositionLimit[at]],
        [whole.lowerPositionLimit[at], whole.upperPositionLimit[at]],
    ).any(axis=0)  # by choices
    given = {
        "effort": limits.torque < np.inf, "velocity": limits.speed < np.inf, "range": ranged
    }  # fmt: skip
    known = {(kind, name) for kind, own in given.items() for name in np.array(names)[own]}
    unlooped = tuple(p for p in unlooped if (p.kind, p.name) not in known)
    asked = (choices.stance_sole, choices.swing_sole)
    sides = (asked[side], asked[1 - side])
    try:
        stood = flat_stance(posed, straight, pair.legs, heading.rotation, shapes)
        stance, tilted = level_feet(stood, shapes, sides, heading.rotation)
        faces = _faces(stance, shapes, told=choices.sole is not None and _is_placed(choices))
        lost = source.mesh_problems() if None in faces else []
        broken = [problem for problem in source.problems if problem.kind == "shape"]
        soles = choose_soles(stance.centred(), faces, sides, choices, (*broken, *lost))
    except RobotError as error:
        raise fault_error([*faults, *faults_of(error)]) from error
    resolved = _resolved(choices, model, pair, heading, soles, side)  # before feet are changed
    ankle = stance.height(soles.placements)
    soles, shod = change_feet(straight, pair.legs, moving, soles, ankle, choices.proportions)
    if soles.added:
        for leg, name, place in zip(pair.legs, soles.names, soles.placements, strict=True):
            model.addFrame(pin.Frame(name, leg[-1], place, pin.FrameType.OP_FRAME), False)
    # after the proportions: a load does not grow with the link that carries it
    payloads, carried = add_payloads(model, choices.payloads, pair.legs)
    resolved = replace(
        resolved,
        posture=tuple(angles.items()) or None,
        limits=tuple(replace(one, units=()) for one in overrides),  # which fit, as `override` knows
        payloads=payloads,
    )
    counted = source.physics.without(choices.without)
    if choices.gravity is not None:
        x, y, z = (float(-choices.gravity * n) for n in heading.rotation[:, 2])
        counted = replace(counted, gravity=(x, y, z))
    findings = (
        *_leg_findings(model, posed.q, pair, heading, angles, others),
        *tied,
        *_missing(straight, pair.legs[side], heading.rotation),
        *tilted,
        *soles.findings,
        *notes,
        *bodies,
        *sized,
        *shod,
        *carried,
        *closed.findings,
        *loop_findings(model, closed.others, counted),
        *odd,
        *armature_findings(whole, model, pair.legs, resolved, is_generated(source.text)),
        *source.findings(),
    )
    return ImportedRobot(
        model, posed.q, pair.legs, others, heading.rotation, soles, side, limits, counted,
        source.physics, resolved, findings, faults, locked_mimics(unlooped, names),
        _drawn_unequally(source.drawn_posture, model, chain, mirror), moving_ties, closed.linkages,
    )  # fmt: skip


def _counting(
    source: Source, choices: ImportOptions, problems: tuple[FileProblem, ...]
) -> tuple[Mapping[str, Tie], tuple[LoopFrames, ...], tuple[FileProblem, ...]]:
    """Return the ties and the loops that count, and the problems without those of others."""
    ties, loops, passed = source.ties, source.loops, list[str]()
    if TIES in choices.without:
        ties, passed = {}, ["mimic", "tied"]
    if LOOPS in choices.without:
        loops, passed = (), [*passed, LOOP, "held"]
    return ties, loops, tuple(one for one in problems if one.kind not in passed)


def _heading_with_feet(
    source: Source, posed: PosedModel, pair: LegPair, choices: ImportOptions
) -> tuple[LegPair, Heading, list[FootShape | None]]:
    """Return the legs with the right one first, where the robot looks, and their feet's shapes."""
    shapes = _shapes(source, posed, pair, choices)
    feet = [None if shape is None else shape.points for shape in shapes]
    lines = [leg_lines(posed, leg, foot) for leg, foot in zip(pair.legs, feet, strict=True)]
    try:
        heading = find_heading((lines[0], lines[1]), pair.up, choices.forward)
    except RobotError as fault:
        if choices.forward is not None or named_feet(posed.model, choices) is not None:
            raise
        raise no_legs(posed, (pair.legs[0][-1], pair.legs[1][-1]), fault) from None
    if heading.right == 1:
        pair, shapes = replace(pair, legs=(pair.legs[1], pair.legs[0])), shapes[::-1]
    return pair, heading, shapes


def _moving_ties(
    ties: Mapping[str, Tie],
    names: Sequence[str],
    apart: Mapping[str, str],
    locked: Mapping[str, str],
) -> tuple[dict[str, Tie], list[Finding]]:
    """Return the ties of joints that move, and what is to be said of ties."""
    found = ties_among(ties, names)
    if wrong := [apart[name] for name in found if name in apart]:
        raise RobotError(f"posture: {'; '.join(wrong)}; leave the joints that follow out of it")
    findings = [Finding("ties", n, f"{tie}; one motor turns both") for n, tie in found.items()]
    for name, fault in locked.items():
        text = f"{ties[name]}, which moves, but is locked: {fault}"
        how: How = "found" if "no mass" in fault else "warning"
        findings.append(Finding("ties", name, text, how))
    return found, findings


def _rotors(choices: ImportOptions, model: pin.Model, folder: Path) -> tuple[LimitOverride, ...]:
    if not choices.rotors:
        return ()
    armatures = rotor_armatures(choices, folder)
    return tuple(
        LimitOverride(glob.escape(name), armature=value, source="rotor_params of the SRDF")
        for name, value in armatures.items()
        if model.existJointName(name)
    )


def _shapes(
    source: Source, posed: PosedModel, pair: LegPair, choices: ImportOptions
) -> list[FootShape | None]:
    """Shapes of the feet, only looked for where they are still asked: meshes may be missing."""
    if choices.sole is not None and choices.forward is not None and _is_placed(choices):
        return [None, None]
    model, places = posed.model, posed.placements
    return [
        foot_points(source, model, foot, {
            toe: places[foot].actInv(places[toe])
            for toe in pair.beyond if foot in model.supports[toe]
        })
        for *_, foot in pair.legs
    ]  # fmt: skip


def _is_placed(choices: ImportOptions) -> bool:
    """Tell whether the user says where the soles are."""
    return bool(choices.sole_placements or choices.sole_drop or choices.stance_sole)


def _faces(
    stance: Stance, shapes: list[FootShape | None], *, told: bool
) -> tuple[FoundSole | None, FoundSole | None]:
    """Return the soles that the feet show, None where they do not and need not (`told`)."""

    def found(side: int) -> FoundSole | None:
        if (shape := shapes[side]) is None:
            return None
        ankle = stance.places[side].actInv(stance.ankles[side])
        try:
            return find_sole(shape, stance.places[side].rotation.T, ankle, stance.leg)
        except RobotError:
            if told:
                return None
            raise

    return found(0), found(1)


def _empty_ranges(
    model: pin.Model, legs: LegJoints, problems: tuple[FileProblem, ...]
) -> tuple[str, ...]:
    """Return what is wrong with empty ranges, before they are compared with the other leg's."""
    joints = {str(model.names[j]): model.joints[j] for leg in legs for j in leg}
    low, high = model.lowerPositionLimit, model.upperPositionLimit
    faults = []
    for problem in problems:
        if (joint := joints.get(problem.name)) is None:
            continue
        given = ""
        if problem.kind == "range" and not low[joint.idx_q] < high[joint.idx_q]:
            given = "range"
        elif problem.kind == "torque" and not model.effortLimit[joint.idx_v] > 0.0:
            given = "torque"
        if given:
            faults.append(f"{problem}; or give a {given}: [[limits]] in the file for --choices")
    return tuple(faults)


def _missing(straight: PosedModel, leg: tuple[int, ...], rotation: Array) -> list[Finding]:
    """Return what joints a leg lacks without which it walks in fewer ways."""
    joints = list(leg)
    missing = missing_joints(straight.points[joints] @ rotation, straight.axes[joints] @ rotation)
    text = f"have no {' and no '.join(missing)} joint; the feet turn with the trunk there"
    return [Finding("legs", "both legs", text, "warning")] if missing else []


def _drawn_unequally(
    drawn: Mapping[str, float], model: pin.Model, chain: tuple[int, ...], mirror: Array
) -> tuple[str, ...]:
    """Return the pairs of joints whose coordinates in the drawn posture are no mirror images."""
    names = [str(model.names[joint]) for joint in chain]
    angles = np.array([drawn.get(name, 0.0) for name in names])
    images = mirror @ angles
    partners = np.abs(mirror).argmax(axis=1)
    return tuple(
        f"'{names[row]}' at ref {angles[row]:.4g} rad, '{names[partners[row]]}' at "
        f"{angles[partners[row]]:.4g} rad, mirrored {images[row]:.4g}"
        for row in range(len(chain))
        if row < partners[row]
        if abs(images[row] - angles[row]) > _SAME_REF
    )


def _resolved(
    choices: ImportOptions,
    model: pin.Model,
    pair: LegPair,
    heading: Heading,
    soles: Soles,
    side: int,
) -> ImportOptions:
    placements = None
    if soles.added:
        right, left = soles.placements
        placements = placement_numbers(right), placement_numbers(left)
    feet = [str(model.names[leg[-1]]) for leg in pair.legs]
    return replace(
        choices,
        feet=(feet[0], feet[1]),
        stance=SIDES[side],
        stance_sole=soles.names[side],
        swing_sole=soles.names[1 - side],
        forward=axis_name(heading.rotation[:, 0]),
        up=axis_name(heading.rotation[:, 2]),
        srdf=None,
        rotors=False,
        sole=soles.sole,
        sole_drop=None,
        sole_placements=placements,
    )
