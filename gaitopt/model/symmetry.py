"""The leg exchange E of Eq. (26), found from the joint axes of the model, never typed.

Make an almost symmetric robot exactly symmetric: a half step must be the mirror of the next.

Drawings and identified inertias differ a little from left to right. Joint lines meet in the middle
(`_mirror_lines`), rotors have the mean of both inertias, and bodies are averaged with the mirror
image of their partner in the ten dynamic parameters, in which the mean of two bodies that can exist
can exist too (Wensing, Kim and Slotine, 2018, IEEE RA-L 3(1), section III).

What that changes is judged by its effect on a walk, all of it together (`_WalkProbe`): over the
range of motion, the mass matrix of the joints with one foot on the ground, and where the other foot
is. A difference of a link's inertia, of a joint's line or of a rotor thus has one measure, and a
light link or a joint near the ground counts as little as it matters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.importers.pinocchio_model import rigid_body
from gaitopt.model.kinematic_tree import angle_between, pose_model, turn_onto
from gaitopt.nlp import Array

REFLECTION = np.diag([1.0, -1.0, 1.0])  # left <-> right, in axes x forward, y left, z up


def joint_lines(model: pin.Model, pelvis: pin.SE3) -> tuple[Array, Array]:
    """Return points on and directions of all joint axes at the neutral posture, (n, 3) each.

    In the frame of the pelvis, given its placement in the world at that posture.
    """
    posed = pose_model(model, pin.neutral(model))
    points = np.array([pelvis.actInv(p.translation) for p in posed.placements[2:]])
    return points, posed.axes[2:] @ pelvis.rotation


def leg_exchange(axes: Array, outward: Array, partners: Sequence[int] | None = None) -> Array:
    """Return E, shape (n, n): `E q` is the posture q reflected left to right, legs exchanged.

    The sign is that between the partner's axis and the mirrored one (a rotation vector mirrors to
    minus its reflection): a waist that yaws has -1, one that pitches +1.

    Args:
        axes: of the joints in the pelvis frame, stance leg from ankle to hip, then swing leg from
            hip to ankle, then others, shape (n, 3).
        outward: (n,) +1 where the joint turns its URDF child by +axis in the re-rooted model, -1
            where the chain runs against the URDF.
        partners: of each joint, the one that does the same on the other side;
            None for two legs alone: the joint of the other leg as many joints away from the hip.
    """
    n = len(axes)
    partners = range(n)[::-1] if partners is None else partners
    E = np.zeros((n, n))
    for i, partner in enumerate(partners):
        mirrored = -REFLECTION @ (outward[i] * axes[i])
        same = mirrored @ (outward[partner] * axes[partner]) >= 0.0
        E[i, partner] = 1.0 if same else -1.0
    return E


def mirror_placement(placement: pin.SE3) -> pin.SE3:
    """Return the mirror image of a placement in the plane y = 0."""
    S = REFLECTION
    return pin.SE3(S @ placement.rotation @ S, S @ placement.translation)


def exchange_error(model: pin.Model, E: Array, stance_sole: str, swing_sole: str) -> float:
    """Return the largest error of mirrored kinematics and inertia over a few postures.

    The swing sole seen from the stance sole at q must mirror to the stance sole seen from the
    swing sole at E q, E (n, n), and the kinetic energy of the mirrored motion must be the same.
    """
    data, numbers = model.createData(), np.arange(1.0, 2 * len(E) + 1).reshape(2, len(E))
    soles = model.getFrameId(stance_sole), model.getFrameId(swing_sole)
    worst = 0.0
    for posture in range(1, 4):  # as good as random ones, whose generator takes long to load
        angles, rates = np.array([[0.4], [1.0]]) * np.sin(posture * numbers)
        placement, energy = _seen_standing(model, data, angles, rates, soles)
        exchanged, other = _seen_standing(model, data, E @ angles, E @ rates, soles[::-1])
        gap = mirror_placement(placement).homogeneous - exchanged.homogeneous
        worst = max(worst, float(np.abs(gap).max()), abs(energy - other) / energy)
    return worst


def _seen_standing(
    model: pin.Model, data: pin.Data, angles: Array, rates: Array, soles: tuple[int, int]
) -> tuple[pin.SE3, float]:
    """Placement of the second sole in the first, and kinetic energy with the first one at rest."""
    q = np.concatenate([pin.neutral(model)[:7], angles])
    v = np.concatenate([np.zeros(6), rates])
    pin.computeJointJacobians(model, data, q)
    J = pin.computeFrameJacobian(model, data, q, soles[0], pin.LOCAL)
    v[:6] = -np.linalg.solve(J[:, :6], J[:, 6:] @ rates)
    pin.updateFramePlacements(model, data)
    # computeKineticEnergy leaves out the rotors of hinges about any axis but +x, +y and +z.
    energy = float(v @ pin.crba(model, data, q) @ v) / 2.0
    return data.oMf[soles[0]].actInv(data.oMf[soles[1]]), energy


_SAME = 1e-12  # m, rad and relative: what is this much alike is left as it is
_MISSING = 1e-6  # an inertia this much smaller than its partner's was left out of the file
_TOLD = 1e-9  # m and rad: less is the rounding of the loader, not a difference of the file
_POSTURES = 48
_LEAST_EFFECT = 1e-6  # what is below matters to nobody
_WIDEST = 1.0  # rad: what a leg's joint turns to either side in a walk, and stairs, and squats
_LISTED = 0.1  # of the largest effect: differences that matter less are counted, not listed
_MOST = 1.0  # the largest value of the choice

_Pair = tuple[int, int]


@dataclass(frozen=True)
class Sides:
    """Where left and right are in a model rooted at the pelvis.

    Attributes:
        right, left: joints of the legs from hip to ankle.
        soles: names of the right and the left sole frame.
        plane: placement of the pelvis frame in the root body; its x-z plane is the mirror.
        others: pairs of other joints that move, right one first; a joint in the middle twice.
    """

    right: tuple[int, ...]
    left: tuple[int, ...]
    soles: tuple[str, str]
    plane: pin.SE3
    others: tuple[_Pair, ...] = ()

    @property
    def pairs(self) -> list[_Pair]:
        """Right and left joints, those that move others first."""
        return sorted([*zip(self.right, self.left, strict=True), *self.others], key=max)


class _LineGap(NamedTuple):
    """How far a joint's line, or the sole beyond it, is from its partner's image [m, rad]."""

    joints: _Pair
    sole: bool
    apart: float
    turn: float


@dataclass(frozen=True)
class Effect:
    """How far two robots differ, the largest over all postures, either foot standing.

    Attributes:
        mass_matrix: difference of the mass matrix, each entry in units of sqrt(D_i D_j), where D_i
            is what joint i or its partner on the other side moves, whichever is more (for most
            joints when its leg stands); for a joint of an arm, what the whole arm moves [-].
        feet: how far the other foot is from where it was, per length of the leg, or by how much it
            is turned [rad], whichever is more.
    """

    mass_matrix: float
    feet: float

    @property
    def size(self) -> float:
        """The larger of the two."""
        return max(self.mass_matrix, self.feet)

    def words(self) -> str:
        """Return both as percentages."""
        return (
            f"the mass matrix by {percent(self.mass_matrix)} and the placement of the feet by "
            f"{percent(self.feet)} of the leg's length"
        )

    def brief(self) -> str:
        """Return what is worth a word, as percentages."""
        parts = (("mass matrix", self.mass_matrix), ("feet", self.feet))
        return ", ".join(f"{name} {percent(s)}" for name, s in parts if s >= _LEAST_EFFECT)


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
        names = f"'{right}'" if right == left else f"'{right}' and '{left}'"
        return {
            "trunk": "trunk",
            "joints": f"joints {names}",
            "soles": "soles",
            "links": f"links moved by {names}",
            "rotors": f"rotors of {names}",
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


class _FootDynamics(NamedTuple):
    """A robot in m postures, the right foot standing, then the left."""

    mass: Array  # (m, 2, n, n): of its joints with that foot at rest
    place: Array  # (m, 2, 3): of the other sole in the standing one
    turn: Array  # (m, 2, 3, 3): likewise


class _WalkProbe:
    """Postures in which robots of one set of joints are compared: straight, and at random."""

    def __init__(self, model: pin.Model, sides: Sides, length: float) -> None:
        self.soles, self.length = sides.soles, length
        low, high = (
            np.clip(np.array(b)[7:], -_WIDEST, _WIDEST)
            for b in (model.lowerPositionLimit, model.upperPositionLimit)
        )
        ranged = low < high  # a range beyond that, or none, is as good as the whole
        low, high = np.where(ranged, low, -_WIDEST), np.where(ranged, high, _WIDEST)
        self.postures = np.tile(pin.neutral(model), (_POSTURES, 1))
        random = np.random.default_rng(0)
        self.postures[1:, 7:] = random.uniform(low, high, (_POSTURES - 1, len(low)))
        self.partner = np.arange(len(low))
        for pair in sides.pairs:
            i, j = (model.joints[joint].idx_v - 6 for joint in pair)
            self.partner[i], self.partner[j] = j, i
        others = sorted({joint for pair in sides.others for joint in pair})
        carried = ((joint, int(model.parents[joint])) for joint in others)
        self.arms = [  # joints with those of arms that carry them, those first that carry others
            (model.joints[joint].idx_v - 6, model.joints[carrier].idx_v - 6)
            for joint, carrier in carried
            if carrier in others
        ]

    def compare(self, first: _FootDynamics, other: _FootDynamics) -> Effect:
        """Return how far two robots differ; the first one gives the scale."""
        moved = np.diagonal(first.mass, axis1=-2, axis2=-1).max(axis=1)  # (m, n): either foot
        moved = np.maximum(moved, moved[:, self.partner])
        for joint, carrier in self.arms:
            moved[:, joint] = np.maximum(moved[:, joint], moved[:, carrier])
        scale = np.sqrt(moved[:, :, None] * moved[:, None, :])[:, None]
        change = np.abs(first.mass - other.mass) / scale
        apart = np.linalg.norm(first.place - other.place, axis=-1) / self.length
        # |R - Q| = 2 sqrt(2) |sin(angle / 2)|
        chord = np.linalg.norm(first.turn - other.turn, axis=(-2, -1)) / np.sqrt(8.0)
        angle = 2.0 * np.arcsin(np.clip(chord, 0.0, 1.0))
        return Effect(float(change.max()), float(max(apart.max(), angle.max())))

    def measure(self, model: pin.Model) -> _FootDynamics:
        """Return mass matrices and placements of a robot in all postures."""
        data, nv = model.createData(), model.nv
        frames = [model.getFrameId(name) for name in self.soles]
        count = len(self.postures)
        M, J = np.zeros((count, nv, nv)), np.zeros((count, 2, 6, nv))
        place, turn = np.zeros((count, 2, 3)), np.zeros((count, 2, 3, 3))
        for k, q in enumerate(self.postures):
            M[k] = pin.crba(model, data, q)
            pin.computeJointJacobians(model, data, q)
            pin.updateFramePlacements(model, data)
            for side, frame in enumerate(frames):
                J[k, side] = pin.getFrameJacobian(model, data, frame, pin.LOCAL)
                seen = data.oMf[frame].actInv(data.oMf[frames[1 - side]])
                place[k, side], turn[k, side] = seen.translation, seen.rotation
        # The free-flyer's twist that keeps the standing foot still is linear in the joint rates.
        held = np.zeros((count, 2, nv, nv - 6))
        held[..., :6, :] = -np.linalg.solve(J[..., :6], J[..., 6:])
        held[..., 6:, :] = np.eye(nv - 6)
        return _FootDynamics(held.swapaxes(-1, -2) @ M[:, None] @ held, place, turn)


def symmetrise(model: pin.Model, sides: Sides, length: float) -> Symmetrised:
    """Return a copy of a model that is its own mirror image, and what it took."""
    whole = model.copy()
    filled = _fill_missing(whole, sides)
    even = whole.copy()
    gaps = [gap for gap in _mirror_lines(even, sides) if max(gap.apart, gap.turn) > _TOLD]
    bodies = _average_bodies(even, sides)
    rotors = _average_rotors(even, sides)
    if not (bodies or rotors or gaps):
        return Symmetrised(even, (), filled, Effect(0.0, 0.0))
    probe = _WalkProbe(even, sides, length)
    seen = probe.measure(even)

    differ = [
        (gap.joints, "soles" if gap.sole else "joints",
         f"{_tidy(gap.apart, 1e3)} mm and {_tidy(gap.turn, 180.0 / np.pi)} degrees")
        for gap in gaps
    ]  # fmt: skip
    differ += [(pair, "trunk" if pair == (1, 1) else "links", size) for pair, size in bodies]
    differ += [(pair, "rotors", size) for pair, size in rotors]
    parts = []
    for pair, kind, size in differ:
        names = str(whole.names[pair[0]]), str(whole.names[pair[1]])
        other = probe.measure(_restored(even, whole, pair, kind, sides.soles))
        parts.append(Difference(names, kind, size, probe.compare(seen, other)))
    parts.sort(key=lambda part: -part.effect.size)
    return Symmetrised(even, tuple(parts), filled, probe.compare(seen, probe.measure(whole)))


def _restored(
    even: pin.Model, file: pin.Model, pair: _Pair, kind: str, soles: tuple[str, str]
) -> pin.Model:
    """Return the even robot with one kind of a pair's differences as the file has it."""
    model = even.copy()
    if kind == "soles":
        for frame in map(model.getFrameId, soles):
            model.frames[frame].placement = file.frames[frame].placement
        return model
    for joint in pair:
        if kind == "joints":
            model.jointPlacements[joint] = file.jointPlacements[joint]
        elif kind == "rotors":
            row = model.joints[joint].idx_v
            model.armature[row] = file.armature[row]
        else:
            model.inertias[joint] = file.inertias[joint]
    return model


def asymmetry_faults(
    done: Symmetrised, allowed: float, drawn_unequally: Sequence[str] = ()
) -> list[str]:
    """Return what is wrong with a robot that differs too much from its mirror image, if it does."""
    size = done.effect.size
    if size <= allowed:
        return []
    least = _LISTED * done.differences[0].effect.size
    listed = [d for d in done.differences if d.effect.size >= least]
    more = len(done.differences) - len(listed)
    differs = "; ".join(f"{d.subject}: {d.size} ({d.effect.brief()})" for d in listed)
    rest = f"; {more} more that matter less" if more else ""
    ref = "; ".join(drawn_unequally)
    drawn = f" The file draws the legs in postures that are no mirror images: {ref}." if ref else ""
    return [
        f"the robot is not its own mirror image: averaging left and right would change "
        f"{done.effect.words()}; allowed is {percent(allowed)} (asymmetry = {allowed:g}). What "
        f"differs, by its effect: {differs}{rest}.{drawn} {_remedy(done, size, bool(ref))}"
    ]


def _remedy(done: Symmetrised, size: float, by_ref: bool) -> str:
    kind = done.differences[0].kind
    place = "<origin>, <axis>" if kind in ("joints", "soles") else "<inertial>"
    first = ", from the hips on" if kind == "joints" else " first"
    correct = f"Correct the file ({place} of what is named{first})"
    if by_ref:
        correct = "Correct the ref of one joint of each such pair"
    if kind == "joints":
        correct += (
            ", or if the whole robot leans in the root link's axes, say which direction of it is "
            "up (up = [X, Y, Z] in the file for --choices)"
        )
    if not size <= _MOST:
        return f"{correct}; no choice accepts so much"
    # The next number of two digits, so that what is written accepts what was measured.
    digit = 10.0 ** (math.floor(math.log10(size)) - 1)
    above = math.ceil(size / digit) * digit
    above = min(float(f"{above if above > size else above + digit:.3g}"), _MOST)
    return f"{correct}, or have it averaged: asymmetry = {above:g} in the file for --choices"


def percent(share: float) -> str:
    """Return a share in words."""
    return f"{100.0 * share:.2g} %" if share >= _LEAST_EFFECT else "less than 0.0001 %"


def mirrored(inertia: pin.Inertia) -> pin.Inertia:
    """Return the mirror image of a body in the plane y = 0."""
    S = REFLECTION
    return rigid_body(inertia.mass, S @ inertia.lever, S @ inertia.inertia @ S)


def _mirror_lines(model: pin.Model, sides: Sides) -> tuple[_LineGap, ...]:
    """Make the joints of a model mirror images; tell how far each pair of lines was off."""
    # From the root outwards, a joint's line is compared with the mirror image of its partner's as
    # it lies once the joints before it are mirror images: what the hip is off is not told again of
    # the knee. Both are then moved half the way, each with all that hangs on it. Lines count, not
    # the origins that may slide along them or the angle at which a joint frame stands about its own
    # axis.
    posed = pose_model(model, pin.neutral(model))
    local = [sides.plane.actInv(p) for p in posed.placements]
    axes = posed.axes @ sides.plane.rotation
    moved = {1: local[1]}
    gaps = []
    for pair in sides.pairs:
        parents = [int(model.parents[j]) for j in pair]
        carried = [moved[p] * local[p].inverse() for p in parents]  # what became of its parent
        places = [C * local[j] for C, j in zip(carried, pair, strict=True)]
        lines = [C.rotation @ axes[j] for C, j in zip(carried, pair, strict=True)]
        points = [places[0].translation, REFLECTION @ places[1].translation]
        point, axis, apart, turn = _mean_line(points, [lines[0], REFLECTION @ lines[1]])
        gaps.append(_LineGap(pair, False, apart, turn))
        goals = ((point, axis), (REFLECTION @ point, REFLECTION @ axis))
        for joint, place, line, goal in zip(pair, places, lines, goals, strict=True):
            moved[joint] = _onto_line(place, line, *goal)
    frames = [model.getFrameId(name) for name in sides.soles]
    ankles = sides.right[-1], sides.left[-1]
    soles = [moved[j] * model.frames[f].placement for j, f in zip(ankles, frames, strict=True)]
    mean, apart, turn = _mean_placement(soles[0], mirror_placement(soles[1]))
    gaps.append(_LineGap(ankles, True, apart, turn))
    if max(max(gap.apart, gap.turn) for gap in gaps) > _SAME:
        for joint in moved.keys() - {1}:
            model.jointPlacements[joint] = moved[int(model.parents[joint])].actInv(moved[joint])
        model.frames[frames[0]].placement = moved[ankles[0]].actInv(mean)
        model.frames[frames[1]].placement = moved[ankles[1]].actInv(mirror_placement(mean))
    return tuple(gaps)


def _onto_line(placement: pin.SE3, axis: Array, point: Array, goal: Array) -> pin.SE3:
    """Return a placement turned and shifted as little as puts its axis on a line, (3,) each."""
    goal = goal if goal @ axis >= 0.0 else -goal
    shift = point - placement.translation
    return pin.SE3(
        turn_onto(axis, goal) @ placement.rotation,
        placement.translation + shift - (shift @ goal) * goal,
    )


def _mean_line(points: list[Array], axes: list[Array]) -> tuple[Array, Array, float, float]:
    """Return point and direction of the line between two, their distance and their angle."""
    # The distance is where they cross the plane square to the mean direction through the middle of
    # the two origins: the same whichever leg is called the first.
    first, other = axes[0], axes[1] if axes[0] @ axes[1] >= 0.0 else -axes[1]
    axis = first + other
    axis = axis / np.linalg.norm(axis)
    middle = (points[0] + points[1]) / 2.0
    crossings = [
        p + ((middle - p) @ axis) / float(a @ axis) * a
        for p, a in zip(points, (first, other), strict=True)
    ]
    apart = float(np.linalg.norm(crossings[0] - crossings[1]))
    return (crossings[0] + crossings[1]) / 2.0, axis, apart, angle_between(first, other)


def _mean_placement(first: pin.SE3, other: pin.SE3) -> tuple[pin.SE3, float, float]:
    turn = pin.log3(first.rotation.T @ other.rotation)
    rotation = first.rotation @ pin.exp3(turn / 2.0)
    apart = float(np.linalg.norm(first.translation - other.translation))
    mean = pin.SE3(rotation, (first.translation + other.translation) / 2.0)
    return mean, apart, float(np.linalg.norm(turn))


def _bodies(model: pin.Model, sides: Sides) -> list[tuple[int, int, pin.SE3, pin.SE3]]:
    """Pairs of bodies and their placements in the pelvis frame, the trunk with itself first."""
    placements = pose_model(model, pin.neutral(model)).placements
    local = [sides.plane.actInv(p) for p in placements]
    return [(i, j, local[i], local[j]) for i, j in ((1, 1), *sides.pairs)]


def _fill_missing(model: pin.Model, sides: Sides) -> tuple[str, ...]:
    filled = []
    for i, j, first, second in _bodies(model, sides):
        if i == j:
            continue
        for to, there, from_, here in ((i, first, j, second), (j, second, i, first)):
            own, other = model.inertias[to], model.inertias[from_]
            if np.abs(own.inertia).max() < _MISSING * np.abs(other.inertia).max():
                image = there.actInv(mirrored(here.act(other)))
                model.inertias[to] = rigid_body(own.mass, own.lever, image.inertia)
                filled.append(str(model.names[to]))
    return tuple(filled)


def _average_bodies(model: pin.Model, sides: Sides) -> list[tuple[_Pair, str]]:
    """Average the bodies; return the pairs that differ, and by how much in words."""
    changes, differ = {}, []
    for i, j, first, second in _bodies(model, sides):
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
    differ = []
    for pair in sides.pairs:
        rows = [model.joints[j].idx_v for j in pair]
        first, other = (float(model.armature[row]) for row in rows)
        if first != other:
            model.armature[rows] = (first + other) / 2.0
            differ.append((pair, f"{abs(first - other):.3g} kg·m² (armature)"))
    return differ
