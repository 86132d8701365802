"""Which of the bodies of a compiled MJCF file is the robot, and what of its root is only a stand.

A robot may float on a free joint, slide and turn on up to six joints, or be fixed to the world:
here it always floats, for it is going to walk.

The robot in an MjModel, as plain numbers; and what a person should know about its file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from gaitopt.errors import RobotError
from gaitopt.importers.mjcf_actuators import FREE, fixed_tendon, motors_of, ties_of
from gaitopt.importers.mjcf_compile import Compilation, element_named, load_mujoco, refusal_of
from gaitopt.importers.mjcf_robot import (
    KINDS,
    CompiledBody,
    CompiledGeom,
    CompiledJoint,
    CompiledRobot,
    CompiledSite,
    Pose,
    fault_of,
    pose_of,
    quaternion,
    se3,
    vector,
)
from gaitopt.importers.report import Finding
from gaitopt.importers.urdf_check import MOST_JOINTS
from gaitopt.importers.xml_document import UrdfProblem, XmlTree
from gaitopt.nlp import Array

_LIGHT = 0.01  # of the robot's mass: a body that only carries a joint of the root
_MOST_ROOT_JOINTS = 6


@dataclass(frozen=True)
class Root:
    """The body from which a robot hangs.

    Attributes:
        body: its place in the model.
        carriers: bodies between it and the world that move and have their mass, from the world on.
        joints: of body and carriers, which a free-flyer replaces.
        free: whether the file lets it float.
    """

    body: int
    carriers: tuple[int, ...]
    joints: tuple[int, ...]
    free: bool


class Bodies:
    """The tree of the bodies of an MjModel.

    Args:
        mujoco: the module.
        model: MuJoCo's.
    """

    def __init__(self, mujoco: ModuleType, model: Any) -> None:
        self.model = model
        self.free, self.slide = (
            int(kind) for kind in (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_SLIDE)
        )
        self.children: dict[int, list[int]] = {body: [] for body in range(model.nbody)}
        for body in range(1, model.nbody):
            self.children[int(model.body_parentid[body])].append(body)

    def joints(self, body: int) -> tuple[int, ...]:
        """Return the joints of a body."""
        first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
        return tuple(range(first, first + count))

    def below(self, body: int) -> Iterator[int]:
        """Yield a body and all that hang on it, depth first."""
        yield body
        for child in self.children[body]:
            yield from self.below(child)

    def moving(self, body: int) -> bool:
        """Return whether a body or one on it has a joint."""
        return any(self.joints(b) for b in self.below(body))

    def kinds(self, joints: tuple[int, ...]) -> list[int]:
        """Return the types of joints."""
        return [int(self.model.jnt_type[j]) for j in joints]

    def count(self, root: Root) -> int:
        """Return how many joints a robot has beside those of its root."""
        return sum(len(self.joints(b)) for b in self.below(root.body)) - len(self.joints(root.body))


def choose_root(mujoco: ModuleType, model: Any) -> tuple[Root, tuple[str, ...]]:
    """Return the root of the robot, which is what has most joints, and the names of other robots.

    Raises:
        RobotError: nothing in the file moves.
    """
    bodies = Bodies(mujoco, model)
    roots = [
        root for top in bodies.children[0] if bodies.moving(top) for root in _roots(bodies, top)
    ]
    if not roots:
        raise RobotError("the MJCF file has no body that moves; it describes no robot")
    chosen = max(roots, key=bodies.count)
    return chosen, tuple(str(model.body(r.body).name) for r in roots if r is not chosen)


def _roots(bodies: Bodies, body: int) -> list[Root]:
    """Return the robots on a body that hangs on the world or on what is fixed to it."""
    if bodies.joints(body):
        return [_jointed(bodies, body)]
    hanging = [c for c in bodies.children[body] if bodies.moving(c)]
    inner = [root for child in hanging for root in _roots(bodies, child)]
    # What hangs on hinges alone are the limbs of a body that is held.
    return [root for root in inner if root.free] or [Root(body, (), (), False)]


def _jointed(bodies: Bodies, first: int) -> Root:
    """Return the robot of which the first body has joints."""
    joints = bodies.joints(first)
    if bodies.free in bodies.kinds(joints):
        return Root(first, (), joints, True)
    path = [first]
    while len(bodies.children[path[-1]]) == 1 and _carries_only(bodies, first, path):
        path += bodies.children[path[-1]]
    sliding = [b for b in path if bodies.slide in bodies.kinds(bodies.joints(b))]
    if not sliding:
        return Root(first, (), joints, False)
    joints = tuple(j for b in path for j in bodies.joints(b))
    return Root(path[-1], tuple(path[:-1]), joints, True)


def _carries_only(bodies: Bodies, first: int, path: list[int]) -> bool:
    """Whether the last body of a path is light, and the joints may still all be the root's."""
    model = bodies.model
    (child,) = bodies.children[path[-1]]
    count = sum(len(bodies.joints(b)) for b in [*path, child])
    light = model.body_mass[path[-1]] <= _LIGHT * model.body_subtreemass[first]
    return bool(light and bodies.joints(child) and count <= _MOST_ROOT_JOINTS)


_SHOWN_GROUPS = 3  # of geoms: MuJoCo's viewer shows groups 0, 1 and 2 unless told otherwise
_GREY = (0.5, 0.5, 0.5, 1.0)  # of a geom that says no colour; then its material's counts


@dataclass(frozen=True)
class Extract:
    """What was read of a file.

    Attributes:
        robot: in numbers.
        problems: what is suspicious in it, see `UrdfProblem`.
        findings: what a person should know about how it was read.
    """

    robot: CompiledRobot
    problems: tuple[UrdfProblem, ...]
    findings: tuple[Finding, ...]


def extract(compilation: Compilation, tree: XmlTree) -> Extract:
    """Return the one robot of a compiled file.

    Args:
        compilation: of the file.
        tree: of the document with what it includes, for the places in messages.

    Raises:
        RobotError: nothing moves, a number is not finite, or there are too many joints.
    """
    with np.errstate(all="ignore"):  # what is not finite is refused with its place
        return _Extraction(load_mujoco(), compilation, tree).run()


class _Extraction:
    """One reading of an MjModel."""

    def __init__(self, mujoco: ModuleType, compilation: Compilation, tree: XmlTree) -> None:
        self.mujoco, self.model, self.tree = mujoco, compilation.model, tree
        self.meshes, self.compilation = compilation.meshes, compilation
        self.bodies = Bodies(mujoco, self.model)
        self.root, self.others = choose_root(mujoco, self.model)
        self.data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, self.data)  # of a new MjData: the posture as drawn
        self.motors = motors_of(mujoco, self.model)
        self.joint_names = _names(
            "joint", [self.model.joint(j).name for j in range(self.model.njnt)]
        )
        self.body_names = _names("body", [self.model.body(b).name for b in range(self.model.nbody)])
        self.paired = {int(g) for g in [*self.model.pair_geom1, *self.model.pair_geom2]}
        self.findings: list[Finding] = []

    def run(self) -> Extract:
        kept = [*self.bodies.below(self.root.body), *reversed(self.root.carriers)]
        joints = {j for b in kept for j in self.bodies.joints(b)} - set(self.root.joints)
        if len(joints) > MOST_JOINTS:
            raise RobotError(
                f"the MJCF file has {len(joints)} joints that move; at most {MOST_JOINTS} can be "
                "read; make those that a walk does not need fixed (remove their <joint>)"
            )
        self._tell_root()
        place = {body: index for index, body in enumerate(kept)}
        bodies = tuple(self._body(body, place) for body in kept)
        shown = {geom.mesh for body in bodies for geom in body.geoms}
        robot = CompiledRobot(
            name=str(self.model.names[: self.model.names.index(b"\0")].decode("utf-8", "replace")),
            gravity=self._gravity(),
            bodies=_with_some_drawn(bodies),
            meshes=tuple(mesh for name, mesh in self.meshes.items() if name in shown),
            keyframes=self._keyframes(joints),
        )
        kind, name, fault = fault_of(robot)
        if fault:
            raise refusal_of(self.tree, (kind,), name, fault)
        self._tell_joints(robot, joints)
        self._tell_left_out(joints)
        problems = [*self._ties(joints), *self._forces(joints)]
        return Extract(robot, tuple(sorted(problems, key=lambda p: p.line)), tuple(self.findings))

    # Bodies

    def _body(self, body: int, place: dict[int, int]) -> CompiledBody:
        model = self.model
        parent, where = int(model.body_parentid[body]), self._placed(body)
        if body == self.root.body:
            index = -1
        elif body in self.root.carriers:
            # What carried the root hangs on it now, as it stands in the posture that is drawn.
            index, where = (
                0,
                pose_of(se3(self._world(self.root.body)).actInv(se3(self._world(body)))),
            )
        else:
            index = place[parent]
        first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
        geoms = [self._geom(g) for g in range(first, first + count)]
        return CompiledBody(
            name=self.body_names[body],
            parent=index,
            place=self._world(body) if index < 0 else where,
            mass=float(model.body_mass[body]),
            centre=Pose(vector(model.body_ipos[body]), quaternion(model.body_iquat[body])),
            moments=vector(model.body_inertia[body]),
            gravcomp=self._gravcomp(body),
            joints=tuple(
                self._joint(j) for j in self.bodies.joints(body) if j not in self.root.joints
            ),
            geoms=tuple(geom for geom in geoms if geom is not None),
            sites=tuple(
                CompiledSite(
                    str(model.site(s).name),
                    Pose(vector(model.site_pos[s]), quaternion(model.site_quat[s])),
                )
                for s in np.flatnonzero(model.site_bodyid == body)
                if model.site(int(s)).name
            ),
        )

    def _placed(self, body: int) -> Pose:
        return Pose(vector(self.model.body_pos[body]), quaternion(self.model.body_quat[body]))

    def _world(self, body: int) -> Pose:
        return Pose(vector(self.data.xpos[body]), quaternion(self.data.xquat[body]))

    def _gravcomp(self, body: int) -> float:
        """Return the compensation of a body's weight; none where motors are what compensates it.

        MuJoCo counts negative ones only beside one that is positive.
        """
        if not (self.model.body_gravcomp > 0.0).any():
            return 0.0
        above = body
        while above > 0:
            if any(self.model.jnt_actgravcomp[j] for j in self.bodies.joints(above)):
                return 0.0
            above = int(self.model.body_parentid[above])
        return float(self.model.body_gravcomp[body])

    def _gravity(self) -> tuple[float, float, float]:
        flags, off = int(self.model.opt.disableflags), self.mujoco.mjtDisableBit.mjDSBL_GRAVITY
        return (0.0, 0.0, 0.0) if flags & int(off) else vector(self.model.opt.gravity)

    # Joints

    def _joint(self, joint: int) -> CompiledJoint:
        model, kinds = self.model, self.mujoco.mjtJoint
        kind = {
            int(kinds.mjJNT_HINGE): "hinge",
            int(kinds.mjJNT_SLIDE): "slide",
            int(kinds.mjJNT_BALL): "ball",
        }[int(model.jnt_type[joint])]
        name, pos = self.joint_names[joint], vector(model.jnt_pos[joint])
        dof, angle = int(model.jnt_dofadr[joint]), int(model.jnt_qposadr[joint])
        if kind == "ball":
            return CompiledJoint(name, kind, pos, armature=float(model.dof_armature[dof]))
        lower, upper = -math.inf, math.inf
        if model.jnt_limited[joint] and not self._off("LIMIT"):
            lower, upper = (float(end) for end in model.jnt_range[joint])
        least, most = self.motors.ranges.get(joint, FREE)
        spring, rest = self._spring(joint)
        return CompiledJoint(
            name=name,
            kind=kind,
            pos=pos,
            axis=vector(model.jnt_axis[joint]),
            ref=float(model.qpos0[angle]),
            lower=lower,
            upper=upper,
            armature=self._armature(joint, dof),
            damping=() if self._off("DAMPER") else self._damping(joint, dof),
            friction=0.0 if self._off("FRICTIONLOSS") else self._friction(joint, dof),
            stiffness=() if self._off("SPRING") else spring,
            rest=0.0 if self._off("SPRING") else rest,
            least=least,
            most=most,
        )

    def _off(self, what: str) -> bool:
        """Whether the options of the file switch something off."""
        bit = getattr(self.mujoco.mjtDisableBit, f"mjDSBL_{what}")
        return bool(int(self.model.opt.disableflags) & int(bit))

    def _gears(self, joint: int) -> list[tuple[int, float]]:
        """Return the actuators that turn a joint directly, with their gears."""
        model, kinds = self.model, self.mujoco.mjtTrn
        direct = (int(kinds.mjTRN_JOINT), int(kinds.mjTRN_JOINTINPARENT))
        return [
            (a, float(model.actuator_gear[a, 0]))
            for a in range(len(model.actuator_trntype))
            if int(model.actuator_trntype[a]) in direct and int(model.actuator_trnid[a, 0]) == joint
        ]

    def _tendons(self, joint: int) -> list[tuple[int, float]]:
        """Return the fixed tendons of one joint alone, with their coefficients."""
        arms = [(t, fixed_tendon(self.mujoco, self.model, t)) for t in range(self.model.ntendon)]
        return [(t, arm[joint]) for t, arm in arms if set(arm) == {joint}]

    def _armature(self, joint: int, dof: int) -> float:
        model = self.model
        motors = sum(g * g * float(model.actuator_armature[a]) for a, g in self._gears(joint))
        tendons = sum(c * c * float(self._tendon_armature(t)) for t, c in self._tendons(joint))
        return float(model.dof_armature[dof]) + motors + tendons

    def _pulling(self, tendon: int) -> list[tuple[int, float]]:
        """Return the actuators that pull a tendon, with their gears."""
        model, kind = self.model, int(self.mujoco.mjtTrn.mjTRN_TENDON)
        return [
            (a, float(model.actuator_gear[a, 0]))
            for a in range(len(model.actuator_trntype))
            if int(model.actuator_trntype[a]) == kind and int(model.actuator_trnid[a, 0]) == tendon
        ]

    def _tendon_armature(self, tendon: int) -> float:
        """Return the inertia along a tendon, with that of the actuators that pull it."""
        model = self.model
        motors = sum(g * g * float(model.actuator_armature[a]) for a, g in self._pulling(tendon))
        return float(model.tendon_armature[tendon]) + motors

    def _tendon_damping(self, tendon: int) -> Array:
        """Return the damping along a tendon, with that of the actuators that pull it."""
        model = self.model
        total = np.array([model.tendon_damping[tendon], *model.tendon_dampingpoly[tendon]])
        return total + self._motor_damping(self._pulling(tendon), total.size)

    def _motor_damping(self, actuators: list[tuple[int, float]], size: int) -> Array:
        """Return the damping of actuators: a polynomial in the rate of the joint or tendon."""
        model, total = self.model, np.zeros(size)
        for a, gear in actuators:
            total += (
                gear * gear * np.array([model.actuator_damping[a], *model.actuator_dampingpoly[a]])
            )
        return total

    def _damping(self, joint: int, dof: int) -> tuple[float, ...]:
        model = self.model
        total = np.array([model.dof_damping[dof], *model.dof_dampingpoly[dof]])
        total += self._motor_damping(self._gears(joint), total.size)
        for tendon, arm in self._tendons(joint):
            total += self._tendon_damping(tendon) * abs(arm) ** np.arange(2, 2 + total.size)
        return _trimmed(total)

    def _friction(self, joint: int, dof: int) -> float:
        model = self.model
        tendons = sum(abs(c) * float(model.tendon_frictionloss[t]) for t, c in self._tendons(joint))
        return float(model.dof_frictionloss[dof]) + tendons

    def _spring(self, joint: int) -> tuple[tuple[float, ...], float]:
        """Return the stiffness of a joint's spring and of its tendons, and where they rest."""
        model = self.model
        own = _trimmed([model.jnt_stiffness[joint], *model.jnt_stiffnesspoly[joint]])
        rest = float(model.qpos_spring[int(model.jnt_qposadr[joint])]) if own else 0.0
        torque = _expanded(own, 1.0, rest)
        alone = True
        for tendon, arm in self._tendons(joint):
            stiff = _trimmed([model.tendon_stiffness[tendon], *model.tendon_stiffnesspoly[tendon]])
            least, most = (float(length) for length in model.tendon_lengthspring[tendon])
            if stiff and least == most:
                torque = torque + _expanded(stiff, arm, least)
                alone = False
        return (own, rest) if alone else _about_rest(torque, rest)

    # Shapes

    def _geom(self, geom: int) -> CompiledGeom | None:
        model, kinds = self.model, self.mujoco.mjtGeom
        names = {int(getattr(kinds, f"mjGEOM_{name.upper()}")): name for name in KINDS}
        names[int(kinds.mjGEOM_SDF)] = "mesh"
        kind = names.get(int(model.geom_type[geom]))
        if kind is None:  # planes and height fields are terrain
            return None
        place = Pose(vector(model.geom_pos[geom]), quaternion(model.geom_quat[geom]))
        mesh = ""
        if kind == "mesh":
            index = int(model.geom_dataid[geom])
            mesh = str(model.mesh(index).name)
            moved = se3(Pose(vector(model.mesh_pos[index]), quaternion(model.mesh_quat[index])))
            place = pose_of(se3(place) * moved.inverse())
        rgba = tuple(float(n) for n in model.geom_rgba[geom])
        if rgba == _GREY and model.geom_matid[geom] >= 0:
            rgba = tuple(float(n) for n in model.mat_rgba[model.geom_matid[geom]])
        masks = bool(model.geom_contype[geom]) or bool(model.geom_conaffinity[geom])
        return CompiledGeom(
            name=str(model.geom(geom).name),
            kind=kind,
            size=vector(model.geom_size[geom]) if kind != "mesh" else (0.0, 0.0, 0.0),
            place=place,
            mesh=mesh,
            rgba=rgba,  # type: ignore[arg-type]
            touches=masks
            or geom in self.paired
            or str(model.geom(geom).name) in self.compilation.touching,
            drawn=int(model.geom_group[geom]) < _SHOWN_GROUPS and rgba[3] > 0.0,
        )

    # What else is told

    def _keyframes(self, joints: set[int]) -> tuple[tuple[str, tuple[tuple[str, float], ...]], ...]:
        model, kinds = self.model, self.mujoco.mjtJoint
        single = (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE))
        names = _names("key", [model.key(k).name for k in range(model.nkey)])
        return tuple(
            (
                names[key],
                tuple(
                    (self.joint_names[j], float(model.key_qpos[key, model.jnt_qposadr[j]]))
                    for j in sorted(joints)
                    if int(model.jnt_type[j]) in single
                ),
            )
            for key in range(model.nkey)
        )

    def _tell(self, topic: str, subject: str, text: str, how: str = "found") -> None:
        self.findings.append(Finding(topic, subject, text, how))  # type: ignore[arg-type]

    def _tell_root(self) -> None:
        name, root = self.body_names[self.root.body], self.root
        if self.others:
            others = ", ".join(f"'{n}'" for n in self.others)
            text = f"the file holds others that move, too, which are left out: {others}"
            self._tell("root", f"'{name}'", text, "guessed")
        model = self.model
        dofs = [d for d in range(model.nv) if int(model.dof_jntid[d]) in root.joints]
        passive = {
            "armature": model.dof_armature,
            "damping": model.dof_damping,
            "friction": model.dof_frictionloss,
        }
        if words := [word for word, values in passive.items() if values[dofs].any()]:
            text = f"floats free: the {', '.join(words)} of what holds it in the file is left out"
            self._tell("root", f"'{name}'", text, "changed")
        if root.joints and int(model.jnt_type[root.joints[0]]) == self.bodies.free:
            return
        if root.joints:
            names = ", ".join(self.joint_names[j] for j in root.joints)
            text = f"floats; the joints that hold it in the file do not count: {names}"
        else:
            text = "floats, though the file fixes it to the world"
        self._tell("root", f"'{name}'", text, "changed")

    def _tell_joints(self, robot: CompiledRobot, joints: set[int]) -> None:
        if robot.drawn_posture:
            drawn = ", ".join(f"{n} {value:.4g}" for n, value in robot.drawn_posture.items())
            text = (
                "joint coordinates, ranges and postures are MuJoCo's: the posture that the file "
                f"draws has them at their ref, not at 0: {drawn} (rad, or m)"
            )
            self._tell("posture", "all joints", text)
        model = self.model
        for joint in sorted(joints):
            least, most = (float(end) for end in model.jnt_range[joint])
            if not model.jnt_limited[joint] and least > most:
                text = f"its range {least:g} to {most:g} is upside down: to MuJoCo, it has none"
                self._tell("limits", self.joint_names[joint], text, "warning")
        for index in range(len(model.actuator_trntype)):
            for what in ("force", "ctrl"):
                least, most = (float(end) for end in getattr(model, f"actuator_{what}range")[index])
                if not getattr(model, f"actuator_{what}limited")[index] and least > most:
                    name = str(model.actuator(index).name) or f"number {index}"
                    text = f"its {what}range {least:g} to {most:g} is upside down: to MuJoCo, none"
                    self._tell("limits", f"actuator '{name}'", text, "warning")
        if self.compilation.lost:
            files = ", ".join(f"'{file}'" for file in self.compilation.lost[:3])
            more = len(self.compilation.lost) - 3
            text = (
                f"mesh files were not found: {files}{f' and {more} more' if more > 0 else ''}; no "
                "mass depends on them, their shapes are left out; --package-dir DIR says where "
                "they are"
            )
            self._tell("meshes", "robot", text, "warning")

    def _tell_left_out(self, joints: set[int]) -> None:
        model = self.model
        if self.motors.left_out:
            names = ", ".join(self.motors.left_out)
            text = f"their force on the joints depends on the posture and is left out: {names}"
            self._tell("limits", "actuators", text, "warning")
        if self.motors.muscles:
            names = ", ".join(self.motors.muscles)
            text = f"muscles count with their pull at rest at their best length: {names}"
            self._tell("limits", "actuators", text, "warning")
        if self.motors.disabled:
            names = ", ".join(self.motors.disabled)
            text = f"<option actuatorgroupdisable> switches them off: not counted: {names}"
            self._tell("limits", "actuators", text, "warning")
        if self._off("ACTUATION"):
            text = (
                '<flag actuation="disable"> switches all motors off; a walk needs them: their '
                "ranges count all the same"
            )
            self._tell("limits", "actuators", text, "warning")
        coupled = sorted(self.motors.coupled & joints)
        if coupled:
            names = ", ".join(self.joint_names[j] for j in coupled)
            text = (
                "share motors through a tendon; each has the torque that it could have alone, "
                "though not all of them at once"
            )
            self._tell("limits", names, text, "warning")
        for tendon in range(model.ntendon):
            arms = fixed_tendon(self.mujoco, model, tendon)
            passive = [
                word
                for word, value in (
                    ("armature", self._tendon_armature(tendon)),
                    ("damping", self._tendon_damping(tendon).any()),
                    ("friction", model.tendon_frictionloss[tendon]),
                    ("stiffness", model.tendon_stiffness[tendon]),
                )
                if value
            ]
            least, most = model.tendon_lengthspring[tendon]
            if len(arms) == 1:
                passive = ["stiffness"] if "stiffness" in passive and least != most else []
            if passive:
                name = str(model.tendon(tendon).name) or f"number {tendon}"
                text = f"the {' and '.join(passive)} of this tendon is left out"
                self._tell("physics", f"tendon '{name}'", text, "warning")
        held = sum(float(m) for m in self.model.body_gravcomp)
        if held and any(model.jnt_actgravcomp[j] for j in joints):
            text = (
                "what joints with actuatorgravcomp move is not carried from outside: their motors "
                "bear that weight, and so does the ground here, though MuJoCo takes it off a root "
                "that floats"
            )
            self._tell("gravity compensation", "robot", text, "warning")
        if model.opt.density or model.opt.viscosity:
            text = "the drag of the medium in <option> is left out"
            self._tell("physics", "robot", text, "warning")
        if self.compilation.scene:
            names = ", ".join(f"'{n}'" for n in self.compilation.scene)
            text = f"contact pairs with {names}, which the file does not hold, are left out"
            self._tell("contact", "robot", text)
        for words in self.compilation.said:
            self._tell("mujoco", "file", f"MuJoCo warns: {words}", "warning")

    def _forces(self, joints: set[int]) -> list[UrdfProblem]:
        """Return the joints whose motors cannot hold zero force; tell of those with two ranges."""
        problems = []
        for joint in sorted(joints):
            least, most = self.motors.ranges.get(joint, FREE)
            name = self.joint_names[joint]
            unit = "N" if int(self.model.jnt_type[joint]) == self.bodies.slide else "N·m"
            if not least < 0.0 < most:
                text = (
                    f"joint '{name}': its motors give from {least:g} to {most:g} {unit}, which "
                    "does not reach to both sides of 0; correct the ranges and the gear of its "
                    "actuators"
                )
                problems.append(self._problem("torque", name, text, ("joint",), name))
            elif -least != most:
                text = (
                    f"its motors give from {least:g} to {most:g} {unit}; a walk keeps the smaller "
                    "of the two to both sides"
                )
                self._tell("limits", name, text, "changed")
        return problems

    def _ties(self, joints: set[int]) -> list[UrdfProblem]:
        elements = [e for section in self.tree.root.findall("equality") for e in section]
        problems = []
        for tie in ties_of(self.mujoco, self.model):
            for name in sorted(self.joint_names[j] for j in tie.joints & joints):
                text = (
                    f"joint '{name}': <{tie.tag}> of {tie.ends} in <equality> ties it, which is "
                    "not supported in a leg: every leg joint has its own motor; remove that "
                    f"<{tie.tag}>"
                )
                element = elements[tie.index] if len(elements) == self.model.neq else None
                line = 0 if element is None else self.tree.line(element)
                file = "" if element is None else self.tree.file(element)
                kind = "free" if tie.loop else "mimic"
                problems.append(UrdfProblem(kind, name, text, line, file))
        return problems

    def _problem(
        self, kind: str, name: str, text: str, tags: tuple[str, ...], element_name: str
    ) -> UrdfProblem:
        element = element_named(self.tree, tags, element_name)
        line = 0 if element is None else self.tree.line(element)
        file = "" if element is None else self.tree.file(element)
        return UrdfProblem(kind, name, text, line, file)


def _names(kind: str, given: list[str]) -> list[str]:
    """Return names that all differ, made up where none is given."""
    names, known = [], set(given)
    for index, name in enumerate(given):
        made = name or f"{kind}_{index}"
        while not name and made in known:
            made += "_"
        known.add(made)
        names.append(str(made))
    return names


def _trimmed(numbers: object) -> tuple[float, ...]:
    """Return coefficients without the zeros at the end."""
    values = [float(n) for n in numbers]  # type: ignore[attr-defined]
    while values and values[-1] == 0.0:
        values.pop()
    return tuple(values)


def _expanded(stiffness: tuple[float, ...], arm: float, length: float) -> Polynomial:
    """Return the torque of a spring of stiffness k0 + k1 x + ..., x = arm q - length, in q."""
    stretch = Polynomial([-length, arm])
    return arm * Polynomial([0.0, *stiffness])(stretch) if stiffness else Polynomial([0.0])


def _about_rest(torque: Polynomial, near: float) -> tuple[tuple[float, ...], float]:
    """Return the stiffness of a torque about the angle at which it vanishes, and that angle."""
    roots = torque.roots()
    real = [float(r.real) for r in roots if abs(r.imag) <= 1e-9 * (1.0 + abs(r.real))]
    if not real:
        return (), 0.0
    rest = min(real, key=lambda r: abs(r - near))
    terms = [
        float(torque.deriv(n)(rest)) / math.factorial(n) for n in range(1, torque.degree() + 1)
    ]
    return _trimmed(terms), rest


def _with_some_drawn(bodies: tuple[CompiledBody, ...]) -> tuple[CompiledBody, ...]:
    """Draw everything where a file would show nothing at all."""
    if any(geom.drawn for body in bodies for geom in body.geoms):
        return bodies
    return tuple(
        replace(body, geoms=tuple(replace(g, drawn=g.rgba[3] > 0.0) for g in body.geoms))
        for body in bodies
    )
