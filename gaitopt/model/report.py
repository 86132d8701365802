"""What was found in a description, in sentences with numbers and units."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.importers.report import Finding
from gaitopt.model.import_options import AXES, SIDES
from gaitopt.model.legs.heading import Heading, axis_name
from gaitopt.model.legs.leg_detection import Pair, speaks_for_other_side
from gaitopt.model.symmetry.averaging import Symmetrised
from gaitopt.nlp import Array

_LISTED = 1e-5  # effect: differences that matter less are counted


def tell(
    model: pin.Model, q: Array, pair: Pair, heading: Heading, angles: dict[str, float]
) -> list[Finding]:
    """Return what was found about legs, heading and posture.

    Args:
        model: the whole robot.
        q: its reference posture.
        pair: the right and the left leg.
        heading: where it looks.
        angles: of the reference posture that were given [rad].
    """
    findings = []
    names = [[str(model.names[j]) for j in leg] for leg in pair.legs]
    for side, own in zip(SIDES, names, strict=True):
        text = f"six joints from hip to ankle: {', '.join(own)}"
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
    findings += _posture(model, q, pair, angles)
    return findings


def tell_symmetry(done: Symmetrised) -> list[Finding]:
    """Return what was changed to make the robot its own mirror image, and what that amounts to."""
    findings = []
    if done.filled:
        text = (
            "the file gives these links a mass but no inertia; it was taken from the mirrored "
            "partner in the other leg"
        )
        findings.append(Finding("symmetry", ", ".join(done.filled), text, "warning"))
    listed = [d for d in done.differences if d.effect.size >= _LISTED]
    for d in listed:
        text = f"averaged left and right, which differed by {d.size}: {d.effect.brief()}"
        findings.append(Finding("symmetry", d.subject, text, "changed"))
    if done.differences:
        text = f"averaging left and right changed {done.effect.words()}"
        if more := len(done.differences) - len(listed):
            text += f"; {more} of {len(done.differences)} differences are too small to be listed"
        findings.append(Finding("symmetry", "robot", text, "changed"))
    return findings


def tell_pairs(names: tuple[str, ...], mirror: Array) -> list[Finding]:
    """Return which joints mirror each other, and with which sign."""
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


def _posture(model: pin.Model, q: Array, pair: Pair, angles: dict[str, float]) -> list[Finding]:
    moving = {j for leg in pair.legs for j in leg}
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
