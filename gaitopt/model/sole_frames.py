"""The two sole frames: those of the file, those the user names or measures, or new ones.

Found, named or measured, the soles end as mirror images of each other, flat on the ground in the
reference posture, so that one rectangle serves both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from gaitopt.bounds import fixed
from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.meshes import MeshProblem
from gaitopt.importers.report import Finding, How
from gaitopt.importers.xml_document import EXPAND, FileProblem, is_macro
from gaitopt.model.import_options import ImportOptions, Placement
from gaitopt.model.scales import REACH
from gaitopt.model.sole import Sole
from gaitopt.model.sole_detection import FoundSole, Rectangle, common_rectangle
from gaitopt.model.stance import Stance
from gaitopt.model.symmetry import mirror_placement
from gaitopt.nlp import Array

SOLE_NAMES = ("right_sole", "left_sole")

_ALIGNED = 1e-3  # rad: a sole frame's axes may differ from the robot's by rounding in the file
# Of the leg's length:
_IN_PLANE = 1e-3 / REACH  # the frame's origin may be so far from the plane of the lower face
_CENTRED = 1e-3 / REACH  # and from the middle of its width
_MIRRORED = 2e-3 / REACH  # and rad: frames that are each other's; `symmetrise` judges it
_ALIKE = 2e-3 / REACH  # rectangles that differ by less are one
_OFF_PLANE = 5e-3 / REACH  # a named frame further from the foot's lower face is not its sole
_MEASURED = 5e-3 / REACH  # what a tape measure may be wrong by
_DIRECTORY = (
    "give the directory that holds their package (--package-dir DIR; in Python package_dirs), or "
)
_RECTANGLE = (
    "the sole rectangle ([sole] with toe, heel, left, right in the file for --choices, or --sole; "
    "in Python sole=Sole(toe, heel, left, right))"
)
_DROP = " and the height of the ankle above it (sole_drop in the same file, or in Python)"

_Frames = tuple[pin.Frame, pin.Frame]


@dataclass(frozen=True)
class Soles:
    """Sole frames of the right and of the left foot.

    Attributes:
        names: of the frames.
        placements: in the frames of the last leg joints.
        added: whether they are not in the file.
        sole: the rectangle of either.
        findings: how they came about.
    """

    names: tuple[str, str]
    placements: tuple[pin.SE3, pin.SE3]
    added: bool
    sole: Sole
    findings: tuple[Finding, ...]


def choose_soles(
    stance: Stance,
    found: tuple[FoundSole | None, FoundSole | None],
    names: tuple[str | None, str | None],
    choices: ImportOptions,
    lost: Sequence[FileProblem | MeshProblem] = (),
) -> Soles:
    """Return the sole frames and their rectangle.

    Args:
        lost: shapes and meshes that cannot be used, to be told if they are missed.

    Raises:
        RobotError: a named frame is not in the plane of the sole, or the feet have no shape and
            the user gives no rectangle.
    """
    if choices.sole_placements is not None:
        return _as_given(stance, names, choices)
    try:
        face = common_rectangle(found, stance.places)
    except RobotError:
        if choices.sole is None or choices.sole_drop is None:
            raise
        face = None
    frames = _named_frames(stance, names, face, choices)
    if frames is None and choices.sole_drop is None:
        frames = _frames_of_the_file(stance, face)
    if frames is None:
        if face is None and choices.sole_drop is None:
            raise _unseen_sole(lost, None)
        level = pin.SE3(np.eye(3), _origin(stance, face, choices.sole_drop))
        images = (level, mirror_placement(level))
        first, other = (place.actInv(p) for place, p in zip(stance.places, images, strict=True))
        titles = free_names(stance.model)
    else:
        first, other = (frame.placement.copy() for frame in frames)
        titles = (str(frames[0].name), str(frames[1].name))
    where = f"frames '{titles[0]}' and '{titles[1]}' of the file" if frames else "new frames"
    here = stance.places[0] * first
    if (sole := choices.sole) is not None:
        findings = [Finding("sole", "both feet", f"{_described(sole)}, in {where}", "given")]
    elif face is None:
        raise _unseen_sole(lost, titles[0] if frames else None)
    else:
        sole, findings = _found_rectangle(
            stance, here, where, face, "found" if frames else "guessed"
        )
    if frames is None:
        findings += _drop_doubts(stance, face, choices.sole_drop)
    return Soles(titles, (first, other), frames is None, sole, tuple(findings))


def free_names(model: pin.Model) -> tuple[str, str]:
    """Return names for two sole frames that the model does not use."""
    right, left = SOLE_NAMES
    while model.existFrame(right) or model.existFrame(left):
        right, left = f"{right}_frame", f"{left}_frame"
    return right, left


def placement_numbers(placement: pin.SE3) -> Placement:
    """Return the rows of [R p], 12 numbers."""
    return tuple(float(n) for n in np.asarray(placement.homogeneous[:3]).ravel())


def _as_given(
    stance: Stance, names: tuple[str | None, str | None], choices: ImportOptions
) -> Soles:
    if choices.sole is None or choices.sole_placements is None:
        raise RobotError("sole_placements are given without the sole rectangle (sole); give both")
    free = free_names(stance.model)
    titles = (names[0] or free[0], names[1] or free[1])
    rows = np.array(choices.sole_placements).reshape(2, 3, 4)
    first, other = (pin.SE3(row[:, :3].copy(), row[:, 3].copy()) for row in rows)
    text = f"{_described(choices.sole)}, placed as given"
    finding = Finding("sole", "both feet", text, "given")
    return Soles(titles, (first, other), True, choices.sole, (finding,))


def _named_frames(
    stance: Stance,
    names: tuple[str | None, str | None],
    face: Rectangle | None,
    choices: ImportOptions,
) -> _Frames | None:
    """Frames of the user's names; where only one is named, the other foot's mirrored frame."""
    if names == (None, None):
        return None
    frames: list[pin.Frame | None] = [None, None]
    for side, name in enumerate(names):
        if name is not None:
            frames[side] = stance.model.frames[stance.model.getFrameId(name)]
            if face is not None and choices.sole is None:
                _check_plane(stance, side, frames[side], face)
    for side in (0, 1):
        if frames[side] is None:
            frames[side] = _partner(stance, 1 - side, frames[1 - side])
            if frames[side] is None:
                raise RobotError(
                    f"no frame of the other foot mirrors '{names[1 - side]}'; name both sole frames"
                )
    return frames[0], frames[1]


def _check_plane(stance: Stance, side: int, frame: pin.Frame, face: Rectangle) -> None:
    here = stance.places[side] * frame.placement
    tilt = float(np.linalg.norm(pin.log3(here.rotation)))
    above = float(here.translation[2] - face.height)
    if tilt > 10.0 * _ALIGNED or abs(above) > _OFF_PLANE * stance.leg:
        raise RobotError(
            f"frame '{frame.name}' is not in the plane of the sole with x forward and z up: it is "
            f"turned by {tilt:.3g} rad and lies {fixed(above * 1e3, 1)} mm above the foot's lower "
            "face; leave the sole frames out to have them found, or give the sole rectangle too"
        )


def _frames_of_the_file(stance: Stance, face: Rectangle | None) -> _Frames | None:
    """Frames of the file that are soles already: level, in the plane, mirrored on both feet."""
    pairs: list[tuple[bool, int, _Frames]] = []
    for frame in _links_of(stance, 0):
        here = stance.places[0] * frame.placement
        named = "sole" in frame.name.lower()
        if np.linalg.norm(pin.log3(here.rotation)) > _ALIGNED:
            continue
        if face is None:
            fits = named and here.translation[2] < stance.ankles[0, 2]
        else:
            _, y, z = here.translation
            centred = abs(y - (face.left + face.right) / 2.0) < _CENTRED * stance.leg
            fits = abs(z - face.height) < _IN_PLANE * stance.leg and centred
        other = _partner(stance, 0, frame) if fits else None
        if other is not None:
            pairs.append((not named, len(pairs), (frame, other)))
    return min(pairs)[2] if pairs else None


def _links_of(stance: Stance, side: int) -> list[pin.Frame]:
    kinds = (pin.FrameType.BODY, pin.FrameType.OP_FRAME)
    return [
        f for f in stance.model.frames if f.parentJoint == stance.feet[side] and f.type in kinds
    ]


def _partner(stance: Stance, side: int, frame: pin.Frame) -> pin.Frame | None:
    """Return the frame of the other foot that is the mirror image of one."""
    image = mirror_placement(stance.places[side] * frame.placement)
    best, least = None, _MIRRORED
    for other in _links_of(stance, 1 - side):
        there = stance.places[1 - side] * other.placement
        turn = np.abs(image.rotation - there.rotation).max() / REACH
        gap = float(max(np.abs(image.translation - there.translation).max() / stance.leg, turn))
        # Several links may share a place; a sole by name comes first.
        if gap < least or (gap <= least + 1e-9 and "sole" in other.name.lower()):
            best, least = other, min(gap, least)
    return best


def _origin(stance: Stance, face: Rectangle | None, drop: float | None) -> Array:
    """Origin of a new right sole frame in the pelvis frame: below the ankle, mid-width."""
    ankle = (stance.ankles[0] + stance.ankles[1] * [1.0, -1.0, 1.0]) / 2.0
    if drop is not None or face is None:
        return np.array([ankle[0], ankle[1], ankle[2] - (drop or 0.0)])
    return np.array([ankle[0], (face.left + face.right) / 2.0, face.height])


def _found_rectangle(
    stance: Stance, here: pin.SE3, where: str, face: Rectangle, how: How
) -> tuple[Sole, list[Finding]]:
    """Return the rectangle of the shapes in a sole frame, and what is said of it."""
    sole, cut = face.seen_from(here.translation)
    drop = float(stance.ankles[0, 2] - here.translation[2])
    below = f"{fixed(drop * 1e3, 1)} mm below the ankle"
    text = f"{_described(sole)}, {below}; found: {face.how}; in {where}"
    doubts = (*face.doubts, *cut, *_other_choices(face, here.translation, sole, stance.leg))
    warnings = [Finding("sole", "both feet", doubt, "warning") for doubt in doubts]
    return sole, [Finding("sole", "both feet", text, how), *warnings]


def _other_choices(face: Rectangle, origin: Array, taken: Sole, leg: float) -> list[str]:
    """Say which other rectangles there are, where the one taken leaves out much of the foot."""
    shown, own = [], np.array([taken.toe, taken.heel, taken.left, taken.right])
    for name, other in face.others:
        try:
            sole = other.seen_from(origin)[0]
        except RobotError:
            continue
        edges = _inward(sole)
        if np.abs(edges - own).max() > _ALIKE * leg:
            shown.append(f"{','.join(f'{edge:g}' for edge in edges)} ({name})")
    if not shown:
        return []
    return [
        f"the rectangle holds {face.share:.0%} of the flat part under the foot; if the foot stands "
        f"on more, choose another with --sole=TOE,HEEL,LEFT,RIGHT: {'; '.join(shown)}"
    ]


def _inward(sole: Sole) -> list[float]:
    """Return toe, heel, left and right to a tenth of a millimetre inside the rectangle [m]."""
    # What is within a millionth of that of a round number is that number: no machine differs.
    tenths = 1e4 * np.array([sole.toe, sole.heel, sole.left, sole.right])
    signs = np.array([1.0, -1.0, 1.0, -1.0])
    return [float(edge) for edge in signs * np.floor(signs * tenths + 1e-6) / 1e4]


def _drop_doubts(stance: Stance, face: Rectangle | None, given: float | None) -> list[Finding]:
    """Compare the given height of the ankle above the sole with that of the shapes."""
    if given is None or face is None:
        return []
    seen = float(stance.ankles[:, 2].mean() - face.height)
    if abs(given - seen) <= _MEASURED * stance.leg:
        return []
    text = (
        f"sole_drop is {fixed(given * 1e3, 1)} mm as given, but the lower faces of the feet were "
        f"found {fixed(seen * 1e3, 1)} mm below the ankles; the given one counts; check it, it "
        "must be in m"
    )
    return [Finding("sole", "both feet", text, "warning")]


def _unseen_sole(lost: Sequence[FileProblem | MeshProblem], frame: str | None) -> RobotError:
    """Return the error that the feet have no shape, to be raised."""
    shows = "no collision box or visual shape of the feet shows their soles"
    where = ", and the file has no sole frames" if frame is None else f" (frame '{frame}')"
    drop = _DROP if frame is None else ""
    meshes = [problem for problem in lost if isinstance(problem, MeshProblem)]
    shapes = [problem for problem in lost if isinstance(problem, FileProblem)]
    which = ""
    if shapes:
        which += f"; {shapes[0]}{', and so on' if len(shapes) > 1 else ''}; correct it"
    if not meshes:
        return RobotError(
            f"{shows}{where}{which}{', or' if shapes else ';'} give {_RECTANGLE}{drop}"
        )
    count = len({problem.file for problem in meshes})
    many = "one mesh" if count == 1 else f"{count} meshes"
    first = f"'{meshes[0].file}' of link '{meshes[0].link}' {meshes[0].reason}"
    which += f"; {many} cannot be used: {first}{', and so on' if count > 1 else ''}"
    advice = "give one in STL format in its place, or " if meshes[0].there else _DIRECTORY
    if is_macro(meshes[0].file):
        advice = f"{EXPAND}, or give "
    return RobotError(f"{shows}{where}{which}; {advice}{_RECTANGLE}{drop}")


def _described(sole: Sole) -> str:
    edges = (sole.toe, -sole.heel, sole.left, -sole.right)
    toe, heel, left, right = (fixed(edge * 1e3, 1) for edge in edges)
    return (
        f"the sole reaches {toe} mm forward, {heel} mm back, {left} mm left and {right} mm right "
        "of its frame"
    )
