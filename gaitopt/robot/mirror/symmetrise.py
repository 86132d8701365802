"""Make an almost symmetric robot exactly symmetric: a half step must be the mirror of the next.

Drawings and identified inertias differ a little from left to right. Joint lines meet in the middle
(`mirror_lines`), rotors have the mean of both inertias, and bodies are averaged with the mirror
image of their partner in the ten dynamic parameters, in which the mean of two bodies that can exist
can exist too (Wensing, Kim and Slotine, 2018, IEEE RA-L 3(1), section III). What that changes is
judged by its effect on a walk (`effect`), all of it together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.robot.legs.placed import place
from gaitopt.robot.mirror.effect import Effect, Motions, WalkProbe, walk_probe
from gaitopt.robot.mirror.mean_lines import LineGap, Sides, mirror_lines
from gaitopt.robot.mirror.symmetry import REFLECTION

_SAME = 1e-12  # relative: bodies that are this much alike are left as they are
_MISSING = 1e-6  # an inertia this much smaller than its partner's was left out of the file
_TOLD = 1e-9  # m and rad: less is the rounding of the loader, not a difference of the file
_NOTHING = Effect(0.0, 0.0)


@dataclass(frozen=True)
class Difference:
    """One thing in which a robot differs from its mirror image.

    Attributes:
        joints: names of the right and the left joint; of the root's twice for the trunk.
        kind: "joints" (their lines), "soles", "links" (inertia), "trunk" or "rotors" (armature).
        size: how far the two differ, in words with units.
        effect: what averaging it alone changes.
    """

    joints: tuple[str, str]
    kind: str
    size: str
    effect: Effect

    @property
    def subject(self) -> str:
        """What it is about, in words."""
        right, left = self.joints
        if self.kind == "trunk":
            return "trunk"
        return {
            "joints": f"joints '{right}' and '{left}'",
            "soles": "soles",
            "links": f"links moved by '{right}' and '{left}'",
            "rotors": f"rotors of '{right}' and '{left}'",
        }[self.kind]


@dataclass(frozen=True)
class Symmetrised:
    """A symmetric model and what it took.

    Attributes:
        model: the model, changed where it had to be.
        differences: what was averaged, by effect, largest first.
        filled: joints whose links had no inertia in the file and took their partner's.
        effect: of all differences together: what averaging changed.
    """

    model: pin.Model
    differences: tuple[Difference, ...]
    filled: tuple[str, ...]
    effect: Effect


def symmetrise(model: pin.Model, sides: Sides, length: float) -> Symmetrised:
    """Return a copy of the model that is its own mirror image, and what it took.

    Args:
        model: free-flyer and twelve joints, rooted at the pelvis.
        sides: its legs.
        length: of the leg [m].
    """
    whole = model.copy()
    filled = _fill_missing(whole, sides)
    even = whole.copy()
    gaps = mirror_lines(even, sides)
    bodies = _average_bodies(even, sides)
    rotors = _average_rotors(even, sides)
    if not (bodies or rotors or any(_differs(gap) for gap in gaps)):
        return Symmetrised(even, (), filled, _NOTHING)
    probe = walk_probe(even, (sides.right, sides.left), sides.soles, length)
    seen = probe.measure(even)
    parts = [
        *(_line(whole, even, gap, probe, seen) for gap in gaps if _differs(gap)),
        *(_part(whole, even, pair, words, probe, seen, _links) for pair, words in bodies),
        *(_part(whole, even, pair, words, probe, seen, _rotors) for pair, words in rotors),
    ]
    parts.sort(key=lambda part: -part.effect.size)
    return Symmetrised(even, tuple(parts), filled, probe.compare(seen, probe.measure(whole)))


def mirrored(inertia: pin.Inertia) -> pin.Inertia:
    """Return the mirror image of a body in the plane y = 0."""
    S = REFLECTION
    return pin.Inertia(inertia.mass, S @ inertia.lever, S @ inertia.inertia @ S)


def _differs(gap: LineGap) -> bool:
    return max(gap.apart, gap.turn) > _TOLD


_Pair = tuple[int, int]
_Undo = Callable[[pin.Model, pin.Model, _Pair], None]


def _links(model: pin.Model, file: pin.Model, pair: _Pair) -> None:
    for joint in pair:
        model.inertias[joint] = file.inertias[joint]


def _rotors(model: pin.Model, file: pin.Model, pair: _Pair) -> None:
    armature = np.array(model.armature)
    for joint in pair:
        row = model.joints[joint].idx_v
        armature[row] = file.armature[row]
    model.armature = armature


def _part(
    file: pin.Model,
    even: pin.Model,
    pair: _Pair,
    words: str,
    probe: WalkProbe,
    seen: Motions,
    undo: _Undo,
) -> Difference:
    """Return one difference with what it alone does: the even robot with that as in the file."""
    other = even.copy()
    undo(other, file, pair)
    names = str(file.names[pair[0]]), str(file.names[pair[1]])
    kind = "trunk" if pair[0] == pair[1] else "rotors" if undo is _rotors else "links"
    return Difference(names, kind, words, probe.compare(seen, probe.measure(other)))


def _line(
    file: pin.Model, even: pin.Model, gap: LineGap, probe: WalkProbe, seen: Motions
) -> Difference:
    other = even.copy()
    if gap.sole:
        for name in probe.soles:
            frame = other.getFrameId(name)
            other.frames[frame].placement = file.frames[frame].placement
    else:
        for joint in gap.joints:
            other.jointPlacements[joint] = file.jointPlacements[joint]
    names = str(file.names[gap.joints[0]]), str(file.names[gap.joints[1]])
    words = f"{_tidy(gap.apart, 1e3)} mm and {_tidy(gap.turn, 180.0 / np.pi)} degrees"
    kind = "soles" if gap.sole else "joints"
    return Difference(names, kind, words, probe.compare(seen, probe.measure(other)))


def _seen(model: pin.Model, sides: Sides) -> list[tuple[int, int, pin.SE3, pin.SE3]]:
    """Pairs of bodies and their placements in the pelvis frame, the trunk with itself first."""
    local = [sides.plane.actInv(p) for p in place(model, pin.neutral(model)).places]
    return [(i, j, local[i], local[j]) for i, j in ((1, 1), *sides.pairs)]


def _fill_missing(model: pin.Model, sides: Sides) -> tuple[str, ...]:
    filled = []
    for i, j, first, second in _seen(model, sides)[1:]:
        for to, there, from_, here in ((i, first, j, second), (j, second, i, first)):
            own, other = model.inertias[to], model.inertias[from_]
            if np.abs(own.inertia).max() < _MISSING * np.abs(other.inertia).max():
                image = there.actInv(mirrored(here.act(other)))
                model.inertias[to] = pin.Inertia(own.mass, own.lever, image.inertia)
                filled.append(str(model.names[to]))
    return tuple(filled)


def _average_bodies(model: pin.Model, sides: Sides) -> list[tuple[_Pair, str]]:
    """Average the bodies; return the pairs that differ, and by how much in words."""
    changes, differ = {}, []
    for i, j, first, second in _seen(model, sides):
        own, image = first.act(model.inertias[i]), mirrored(second.act(model.inertias[j]))
        words = _body_words(own, image)
        if words:
            mean = (own.toDynamicParameters() + image.toDynamicParameters()) / 2.0
            body = pin.Inertia.FromDynamicParameters(mean)
            changes[i], changes[j] = first.actInv(body), second.actInv(mirrored(body))
            differ.append(((i, j), words))
    for joint, body in changes.items():
        model.inertias[joint] = body
    return differ


def _body_words(own: pin.Inertia, image: pin.Inertia) -> str:
    """How far two bodies differ, empty where they do not."""
    mean = (own.mass + image.mass) / 2.0
    mass = abs(own.mass - image.mass)
    shift = float(np.linalg.norm(own.lever - image.lever)) if mean > 0.0 else 0.0
    entry = float(np.abs(own.inertia - image.inertia).max())
    largest = max(float(np.abs(b.inertia).max()) for b in (own, image))
    size = np.sqrt(largest / mean) if mean > 0.0 and largest > 0.0 else 1.0
    if mass <= _SAME * mean and shift <= _SAME * size and entry <= _SAME * largest:
        return ""
    return (
        f"{_tidy(mass, 1e3)} g in mass, {_tidy(shift, 1e3)} mm in centre of mass and "
        f"{entry:.2g} kg·m² in inertia"
    )


def _tidy(size: float, unit: float) -> str:
    """Return a size in other units, nothing for what rounding leaves of nothing."""
    return f"{size * unit:.3g}" if size > _TOLD else "0"


def _average_rotors(model: pin.Model, sides: Sides) -> list[tuple[_Pair, str]]:
    armature, differ = np.array(model.armature), []
    for pair in sides.pairs:
        rows = [model.joints[j].idx_v for j in pair]
        first, other = (float(armature[row]) for row in rows)
        if first != other:
            armature[rows] = (first + other) / 2.0
            differ.append((pair, f"{abs(first - other):.3g} kg·m² (armature)"))
    model.armature = armature
    return differ
