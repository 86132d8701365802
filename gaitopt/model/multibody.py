"""The robot that walks as plain arrays: a floating base and every joint of its file.

The bodies have the inertias that the walk was designed with: averaged with their mirror images, and
with what the user replaced. Joints that do not move in the walk are listed with the angle at which
they stand.
"""

from __future__ import annotations

from dataclasses import field, fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.bounds import NUMBER, fixed
from gaitopt.dataclass import dataclass, made_anew
from gaitopt.errors import OptionError, RobotError
from gaitopt.importers.physics import LEAST_MULTIPLIER, MOST_COEFFICIENT, MOST_POWER
from gaitopt.importers.pinocchio_model import joint_coordinate, joint_motions, reduced, rigid_body
from gaitopt.model.chain import RootedChain
from gaitopt.model.chain_physics import CarriedWeight, PassiveJoints
from gaitopt.model.coupling import Coupling
from gaitopt.model.sole import Sole
from gaitopt.nlp import Array
from gaitopt.settings import checked_facts

Index = NDArray[np.int64]
BASE = -1  # as parent of a joint: the floating base
_RIGID = 1e-6  # of what makes a matrix a rotation: more is no rounding
_SAME = 1e-12  # relative: what is left of no difference by rounding
_LEAST = 1e-9  # relative: moments of inertia this much below what a body can have are rounding


def protect(one: Any) -> None:
    """Keep arrays of a dataclass, and of dataclasses in it, from being written into.

    Those that somebody else can write into are copied: theirs stay as they are.
    """
    for name, value in ((entry.name, getattr(one, entry.name)) for entry in fields(one)):
        if isinstance(value, np.ndarray):
            if value.flags.writeable or getattr(value.base, "flags", value.flags).writeable:
                value = np.array(value)
                value.setflags(write=False)
                object.__setattr__(one, name, value)
        elif is_dataclass(value):
            protect(value)


_OF_JOINTS: dict[str, tuple[int, ...] | None] = {
    "parent": (), "revolute": (), "placement": (4, 4), "axis": (3,), "posture": (), "armature": (),
    "friction": (), "damping": None, "stiffness": None, "rest": (),
}  # fmt: skip
_OF_BODIES = {
    "mass": (), "centre": (3,), "inertia": (3, 3), "carried_mass": (), "carried_moment": (3,)
}  # fmt: skip
"""Arrays of a `Multibody` of M joints and M + 1 bodies, and shapes of an entry; None for any."""


@checked_facts
@dataclass(frozen=True, eq=False)
class Multibody:
    """A tree of M joints on a floating base, and the bodies they move; SI units throughout.

    The frame of a body is that of the joint which moves it, as in URDF; that of the base is its
    root link. Parents come before children. Body 0 is the base, body i + 1 is moved by joint i.

    Attributes:
        name: of the robot.
        base: name of the root link.
        joint_names: of the file's joints of one degree of freedom, length M; what hangs on a joint
            of more degrees of freedom, which no walk moves, belongs to the body before it.
        parent: joint that moves the body on which a joint sits, -1 for the base, shape (M,).
        revolute: whether a joint turns; otherwise it slides, shape (M,).
        placement: of the joint's frame in that body at joint coordinate 0, shape (M, 4, 4).
        axis: unit axis in the joint's frame, shape (M, 3).
        posture: coordinate at which a joint stands that the walk does not move [rad or m], (M,).
        moving: the joints that the walk moves, in the order of a gait's columns, shape (n,):
            each has a motor.
        mass: of the bodies [kg], shape (M + 1,).
        centre: their centres of mass in the body's frame [m], shape (M + 1, 3).
        inertia: about the centre of mass, in the body's axes [kg·m²], shape (M + 1, 3, 3).
        armature: inertia of the rotors as seen from the joints [kg·m²], shape (M,).
        friction: Coulomb friction of the joints that move, else 0 [N·m], shape (M,).
        damping: torques per rate, |rate| rate, ..., shape (M, D), likewise.
        stiffness: torques per angle, angle², ... of springs, shape (M, S), likewise.
        rest: angles at which springs give no torque [rad], shape (M,).
        carried_mass: mass whose weight is carried from outside [kg], shape (M + 1,).
        carried_moment: mass times position of the same in the body's frame [kg·m], (M + 1, 3).
        gravity: in the world [m/s²], shape (3,).
        sole_names: frames of the foot that stands first and of the other.
        sole_joint: joints that move the feet, shape (2,).
        sole_placement: sole frames (x forward, y left, z up) in the feet's bodies, (2, 4, 4).
        sole_rectangle: toe, heel (x), left, right (y) of each sole in its frame [m], shape (2, 4).
        heading: forward, left and up of the robot in the axes of the base, columns, shape (3, 3).
        tied: joints that follow others, shape (t,); they move too.
        tied_to: of the moving joints, the one that each of them follows, shape (t,).
        tie: rate of each over that of the one it follows, and its coordinate where that of the
            other is 0 [rad], shape (t, 2).
        tie_bend: coefficients of the second to the fourth power of the other's angle, (t, 3).

    Raises:
        OptionError: an array has another shape.
    """

    name: str
    base: str
    joint_names: tuple[str, ...]
    parent: Index
    revolute: NDArray[np.bool_]
    placement: Array
    axis: Array
    posture: Array
    moving: Index
    mass: Array
    centre: Array
    inertia: Array
    armature: Array
    friction: Array
    damping: Array
    stiffness: Array
    rest: Array
    carried_mass: Array
    carried_moment: Array
    gravity: Array
    sole_names: tuple[str, str]
    sole_joint: Index
    sole_placement: Array
    sole_rectangle: Array
    heading: Array
    tied: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    tied_to: Index = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    tie: Array = field(default_factory=lambda: np.zeros((0, 2)))
    tie_bend: Array = field(default_factory=lambda: np.zeros((0, MOST_POWER - 1)))

    def __post_init__(self) -> None:
        joints = len(self.joint_names)
        for name, entry in {**_OF_JOINTS, **_OF_BODIES}.items():
            shape, count = getattr(self, name).shape, joints + (name in _OF_BODIES)
            if shape[:1] != (count,) or entry not in (None, shape[1:]):
                wanted = f"({count}, any)" if entry is None else (count, *entry)
                raise OptionError(
                    f"Multibody: {name} has shape {shape}; with {joints} joints give {wanted}"
                )
        protect(self)

    __reduce__ = made_anew

    def __repr__(self) -> str:
        """Return it in one line: the whole of it is pages long."""
        return (
            f"<Multibody {self.name!r}: {len(self.joint_names)} joints, {len(self.moving)} move, "
            f"{fixed(self.mass.sum(), 2)} kg>"
        )

    @property
    def moving_names(self) -> tuple[str, ...]:
        """Names of the joints that the walk moves, in the order of a gait's columns."""
        return tuple(self.joint_names[row] for row in self.moving)

    @cached_property
    def driven(self) -> Index:
        """All joints that move, those of `moving` first, shape (n + t,)."""
        return np.concatenate([self.moving, self.tied])

    @property
    def driven_names(self) -> tuple[str, ...]:
        """Names of all joints that move, those with motors first."""
        return tuple(self.joint_names[row] for row in self.driven)

    @cached_property
    def bends(self) -> bool:
        """Whether a joint follows another by more than a constant rate."""
        return bool(self.tie_bend.any())

    @cached_property
    def led(self) -> Index:
        """Which of `moving` each of `tied` follows, shape (t,)."""
        order = np.argsort(self.moving)
        return np.asarray(order[np.searchsorted(self.moving, self.tied_to, sorter=order)])

    def followers(self, angles: Array) -> tuple[Array, Array, Array]:
        """Return tied joints and two derivatives (..., t) at angles that they follow [rad]."""
        value, slope = angles * self.tie[:, 0], np.broadcast_to(self.tie[:, 0], angles.shape)
        value, second = value + self.tie[:, 1], np.zeros(angles.shape)
        if self.bends:
            for k, c in enumerate(self.tie_bend.T, 2):
                value = value + c * angles**k
                slope = slope + k * c * angles ** (k - 1)
                second = second + k * (k - 1) * c * angles ** (k - 2)
        return value, slope, second

    def coupling(self, angles: Array) -> Array:
        """Return rates of `driven` per rate of `moving` at angles (n,) [rad], (n + t, n)."""
        return self._coupling_at(angles) if self.bends else self._constant_coupling

    @cached_property
    def _constant_coupling(self) -> Array:
        return self._coupling_at(np.zeros(len(self.moving)))

    def _coupling_at(self, angles: Array) -> Array:
        _, slope, _ = self.followers(angles[self.led])
        follows = (self.tied_to[:, None] == self.moving) * slope[:, None]
        return np.concatenate([np.eye(len(self.moving)), follows])

    def follow(self, motion: Array) -> None:
        """Write into coordinates, rates and accelerations (3, ..., M) those of tied joints.

        Coordinates alone, or with rates, do too.
        """
        value, slope, second = self.followers(motion[0][..., self.tied_to])
        motion[0][..., self.tied] = value
        for order in motion[1:]:
            order[..., self.tied] = slope * order[..., self.tied_to]
        if self.bends and len(motion) > 2:
            motion[2][..., self.tied] += second * motion[1][..., self.tied_to] ** 2

    def by_motors(self, torque: Array, angles: Array) -> Array:
        """Return torques [N·m] of joints at angles [rad], (..., M) each, as those of motors."""
        found = torque.copy()
        _, slope, _ = self.followers(angles[..., self.tied_to])
        for k, (row, master) in enumerate(zip(self.tied, self.tied_to, strict=True)):
            found[..., master] += slope[..., k] * torque[..., row]
            found[..., row] = 0.0
        return found

    @cached_property
    def sole_corners(self) -> Array:
        """Toe left, toe right, heel left, heel right of each sole in its frame, (2, 4, 3) [m]."""
        toe, heel, left, right = self.sole_rectangle.T
        zero = np.zeros(2)
        corners = [[x, y, zero] for x in (toe, heel) for y in (left, right)]
        return np.moveaxis(np.array(corners), 2, 0)

    @cached_property
    def model(self) -> pin.Model:
        """Pinocchio's model: free-flyer, then every joint in order; treat it as read-only.

        Sole frames bear the names of `sole_names`.
        """
        model = pin.Model()
        model.name = self.name
        root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
        ids: list[int] = []
        for name, parent, turns, placement, axis in zip(
            self.joint_names, self.parent, self.revolute, self.placement, self.axis, strict=True
        ):
            kind = pin.JointModelRevoluteUnaligned if turns else pin.JointModelPrismaticUnaligned
            on = root if parent == BASE else ids[parent]
            ids.append(model.addJoint(on, kind(axis), pin.SE3(placement), name))
        for joint, mass, centre, inertia in zip(
            [root, *ids], self.mass, self.centre, self.inertia, strict=True
        ):
            body = rigid_body(float(mass), centre, inertia)
            model.appendBodyToJoint(joint, body, pin.SE3.Identity())
            model.addJointFrame(joint)
        model.armature = np.concatenate([np.zeros(6), self.armature])
        for name, row, placement in zip(
            self.sole_names, self.sole_joint, self.sole_placement, strict=True
        ):
            frame = pin.Frame(name, ids[row], pin.SE3(placement), pin.FrameType.OP_FRAME)
            model.addFrame(frame, False)
        model.gravity = pin.Motion(self.gravity, np.zeros(3))
        return model

    def placements(self, configurations: Array) -> Array:
        """Return bodies' places at configurations (N, 7 + M), the base first, (N, M + 1, 4, 4)."""
        model, data = self.model, self.model.createData()
        places = np.empty((len(configurations), len(self.joint_names) + 1, 4, 4))
        for own, q in zip(places, configurations, strict=True):
            pin.forwardKinematics(model, data, q)
            for row, place in enumerate(own):
                place[:] = data.oMi[row + 1].homogeneous
        return places

    def leg(self, foot: int) -> tuple[int, ...]:
        """Return the joints of a foot's own leg that move, from the sole up to the hip."""
        own, other = (self._above(joint) for joint in self.sole_joint[[foot, 1 - foot]])
        moving = set(self.driven.tolist())
        return tuple(row for row in own if row not in other and row in moving)

    def _above(self, joint: int) -> list[int]:
        """Return a joint and those above it, up to the base."""
        rows = []
        while joint != BASE:
            rows.append(int(joint))
            joint = self.parent[joint]
        return rows

    @property
    def carried(self) -> CarriedWeight | None:
        """The weight that is carried from outside, by body; None where there is none."""
        if not (self.carried_mass.any() or self.carried_moment.any()):
            return None
        return CarriedWeight(self.carried_mass, self.carried_moment)


def multibody(
    model: pin.Model,
    posture: Array,
    chain: RootedChain,
    coupling: Coupling,
    sole_names: tuple[str, str],
    sole: Sole,
) -> Multibody:
    """Return the arrays of a robot that was read.

    Links that stand still on each other keep their file's inertias, except for the heaviest, which
    takes what averaging changed of all of them; where no such link can exist, all of them are made
    one body.

    Args:
        posture: its reference posture, in which joints that do not move are locked, shape (nq,).
        chain: the same robot made symmetric; see `build_chain`.
    """
    even = chain.symmetry.model
    free = [j for j in range(2, model.njoints) if model.joints[j].nv != 1]
    whole = reduced(model, free, posture)
    names = tuple(str(name) for name in whole.names[2:])
    q = pin.neutral(whole)
    for joint in whole.joints[2:]:
        old = model.joints[model.getJointId(whole.names[joint.id])]
        q[joint.idx_q : joint.idx_q + joint.nq] = posture[old.idx_q : old.idx_q + old.nq]
    driven = np.array([names.index(name) for name in chain.names], dtype=np.int64)
    moving = driven[coupling.free]
    tied = np.setdiff1d(np.arange(len(driven)), coupling.free)
    bends = coupling.coefficients[tied, 2:]
    placement, carried_by = _placements(whole, even, q, set(chain.names))
    bodies = _bodies(whole, even, carried_by)
    motions = joint_motions(whole)
    revolute = np.abs(motions[:, 3:]).max(axis=1) > 0.0
    armature = np.array(whole.armature[6:])
    for row, name in zip(driven, chain.names, strict=True):
        armature[row] = even.armature[even.joints[even.getJointId(name)].idx_v]

    none = np.zeros(len(driven))
    passive = chain.physics.passive or PassiveJoints(none[:, None], none, none[:, None], none)

    def of_joints(values: Array) -> Array:
        out = np.zeros((len(names), *values.shape[1:]))
        out[driven] = values
        return out

    carried_mass, carried_moment = _carried(chain, even, names)
    frames = [even.frames[even.getFrameId(name)] for name in sole_names]
    return Multibody(
        name=str(model.name),
        base=next(f.name for f in whole.frames[1:] if f.type == pin.FrameType.BODY),
        joint_names=names,
        parent=np.array([whole.parents[j] - 2 for j in range(2, whole.njoints)], dtype=np.int64),
        revolute=revolute,
        placement=placement,
        axis=np.where(revolute[:, None], motions[:, 3:], motions[:, :3]),
        posture=np.array([joint_coordinate(joint, q) for joint in whole.joints[2:]]),
        moving=moving,
        tied=driven[tied],
        tied_to=moving[coupling.motor[tied]],
        tie=coupling.coefficients[tied, 1::-1],
        tie_bend=np.pad(bends, ((0, 0), (0, MOST_POWER - 1 - bends.shape[1]))),
        mass=np.array([body.mass for body in bodies]),
        centre=np.array([body.lever if body.mass else np.zeros(3) for body in bodies]),
        inertia=np.array([body.inertia for body in bodies]),
        armature=armature,
        friction=of_joints(passive.friction),
        damping=of_joints(passive.damping),
        stiffness=of_joints(passive.stiffness),
        rest=of_joints(passive.rest),
        carried_mass=carried_mass,
        carried_moment=carried_moment,
        gravity=chain.physics.gravity,
        sole_names=sole_names,
        sole_joint=np.array(
            [names.index(even.names[frame.parentJoint]) for frame in frames], dtype=np.int64
        ),
        sole_placement=np.array([frame.placement.homogeneous for frame in frames]),
        sole_rectangle=np.array(
            [
                [sole.toe, sole.heel, sole.left, sole.right],
                [sole.toe, sole.heel, -sole.right, -sole.left],
            ]
        ),
        heading=np.array(chain.heading),
    )


def checked_multibody(body: Multibody) -> Multibody:
    """Return a robot whose arrays come from elsewhere, if they are those of one.

    Shapes and finite numbers are taken for granted.

    Raises:
        RobotError: they are not.
    """
    count = len(body.joint_names)
    rows = np.arange(count)
    for entry in fields(body):
        value = getattr(body, entry.name)
        numbers = isinstance(value, np.ndarray) and value.dtype.kind == "f"
        if numbers and float(np.abs(value).max(initial=0.0)) > NUMBER:  # not as a float32
            raise RobotError(
                f"the robot of the gait is not one: its {entry.name} holds a number beyond "
                f"{NUMBER:g}"
            )

    def refuse(what: str, wrong: NDArray[np.bool_]) -> None:
        if (found := np.flatnonzero(wrong)).size:
            raise RobotError(f"the robot of the gait is not one: {what} ({found[0]})")

    for names in (body.joint_names, body.sole_names):
        if len(set(names)) != len(names) or not all(names):
            raise RobotError("the robot of the gait is not one: names are empty or there twice")
    refuse(
        "the parent of a joint must be -1 or a joint before it",
        (body.parent < BASE) | (body.parent >= rows),
    )
    for rows_of, what in (
        (body.moving, "moving joint"),
        (body.sole_joint, "joint of a sole"),
        (body.tied, "tied joint"),
        (body.tied_to, "joint that leads another"),
    ):
        refuse(f"a {what} is not in its list", (rows_of < 0) | (rows_of >= count))
    refuse("a joint moves twice", np.bincount(body.driven, minlength=count) > 1)
    refuse("a tied joint follows one that does not move", ~np.isin(body.tied_to, body.moving))
    refuse(
        "the rate of a tied joint is not a usual part of the other's",
        ~(
            (np.abs(np.hstack([body.tie, body.tie_bend])) <= MOST_COEFFICIENT).all(axis=1)
            & (body.tie_bend.any(axis=1) | (np.abs(body.tie[:, 0]) >= LEAST_MULTIPLIER))
        ),
    )
    length = np.linalg.norm(body.axis, axis=1)
    refuse("the axis of a joint has not the length 1", np.abs(length - 1.0) > _RIGID)
    for places in (body.placement, body.sole_placement):
        turned, last = places[:, :3, :3], places[:, 3]
        off = np.abs(turned @ turned.swapaxes(1, 2) - np.eye(3)).max(axis=(1, 2), initial=0.0)
        mirrored = np.linalg.det(turned) < 0.0
        odd = np.abs(last - [0.0, 0.0, 0.0, 1.0]).max(axis=1, initial=0.0)
        refuse("a placement is no rotation and shift", (off > _RIGID) | mirrored | (odd > _RIGID))
    refuse("a body has a mass below 0", body.mass < 0.0)
    if not body.mass.sum() > 0.0:
        raise RobotError("the robot of the gait is not one: it has no mass")
    try:
        _ = body.model
    except RuntimeError as error:  # Pinocchio judges the inertias
        raise RobotError(f"the robot of the gait is not one: {error}") from error
    moments = np.linalg.eigvalsh([np.array(own.inertia) for own in _walking_bodies(body)])
    # A rod's least moment is 0 but for rounding.
    below = moments[:, 0] < -_RIGID * np.abs(moments).max(axis=1, initial=0.0)
    refuse("the inertia should be positive", below)
    return body


def _walking_bodies(body: Multibody) -> list[pin.Inertia]:
    """Return the base and the bodies of joints that move, each with all that is locked to it.

    These alone are judged when a file of a robot is read: part of one may be no body by itself.
    """
    model, still = body.model, np.setdiff1d(np.arange(len(body.joint_names)), body.driven)
    q = np.concatenate([pin.neutral(model)[:7], body.posture])
    reduced = pin.buildReducedModel(model, (still + 2).tolist(), q)
    return list(reduced.inertias)[1:]


def _placements(
    whole: pin.Model, even: pin.Model, q: Array, moves: set[str]
) -> tuple[Array, list[tuple[int, pin.SE3]]]:
    """Return the joints' placements in the parent's body (M, 4, 4).

    And for each body of `whole`, from the base on, the joint of `even` that moves it and its frame
    in that joint's.
    """
    data = whole.createData()
    pin.forwardKinematics(whole, data, q)
    placements = []
    carrier = {1: (1, pin.SE3.Identity())}
    for joint in range(2, whole.njoints):
        parent, name = whole.parents[joint], str(whole.names[joint])
        at, inside = carrier[parent]
        if name in moves:
            own = even.getJointId(name)
            placements.append((inside.inverse() * even.jointPlacements[own]).homogeneous)
            carrier[joint] = (own, pin.SE3.Identity())
        else:
            placements.append(whole.jointPlacements[joint].homogeneous)
            carrier[joint] = (at, inside * data.liMi[joint])
    return np.array(placements).reshape(-1, 4, 4), [carrier[j] for j in range(1, whole.njoints)]


def _bodies(
    whole: pin.Model, even: pin.Model, carried_by: list[tuple[int, pin.SE3]]
) -> list[pin.Inertia]:
    """Return the inertias of the bodies of `whole`, whose sums are those of `even`."""
    members: dict[int, list[int]] = {}
    for body, (joint, _) in enumerate(carried_by):
        members.setdefault(joint, []).append(body)
    bodies = [whole.inertias[body + 1].copy() for body in range(len(carried_by))]
    for joint, parts in members.items():
        total = even.inertias[joint].toDynamicParameters()
        placed = {body: carried_by[body][1].act(bodies[body]) for body in parts}
        seen = {body: inertia.toDynamicParameters() for body, inertia in placed.items()}
        difference = total - sum(seen.values())
        if np.abs(difference).max() <= _SAME * np.abs(total).max():
            continue
        for body in sorted(parts, key=lambda body: -seen[body][0]):
            if _can_exist(changed := seen[body] + difference):
                inertia = pin.Inertia.FromDynamicParameters(changed)
                bodies[body] = carried_by[body][1].actInv(inertia)
                break
        else:
            for body in parts:
                bodies[body] = pin.Inertia.Zero()
            bodies[parts[0]] = even.inertias[joint].copy()
    return bodies


def _can_exist(parameters: Array) -> bool:
    """Whether a body can have these ten dynamic parameters: its pseudo-inertia is positive."""
    if not parameters[0] > 0.0:
        return False
    body = pin.Inertia.FromDynamicParameters(parameters)
    moments = np.linalg.eigvalsh(body.inertia)
    return bool(moments[0] >= 0.0 and moments[2] <= (moments[0] + moments[1]) * (1.0 + _LEAST))


def _carried(chain: RootedChain, even: pin.Model, names: tuple[str, ...]) -> tuple[Array, Array]:
    """Return the weight carried from outside by body of the file: mass and moment."""
    mass, moment = np.zeros(len(names) + 1), np.zeros((len(names) + 1, 3))
    weight = chain.physics.carried
    if weight is None:
        return mass, moment
    rooted = chain.model
    ends = [f.name for f in rooted.frames if f.parentJoint and even.existFrame(f.name)]
    for frame in ends:  # each body of the chain is found by a frame that it has in both models
        there = rooted.frames[rooted.getFrameId(frame)]
        here = even.frames[even.getFrameId(frame)]
        body = there.parentJoint - 1
        joint = here.parentJoint
        row = 0 if joint == 1 else names.index(str(even.names[joint])) + 1
        move = here.placement * there.placement.inverse()
        mass[row] = weight.mass[body]
        moment[row] = move.rotation @ weight.moment[body] + weight.mass[body] * move.translation
    return mass, moment
