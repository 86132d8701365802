"""An MJCF file as the source of a robot, and the compiled robot as Pinocchio has it.

A joint coordinate is MuJoCo's `qpos`: a joint frame stands turned (or shifted) back by `ref`, so
that the posture which the file draws is the one with every coordinate at its `ref`.
It is compiled by MuJoCo, or is the normal form of one that was.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.importers.meshes import LoadMesh, MeshPaths, MeshProblem
from gaitopt.importers.mjcf_compile import (
    check_magnitudes,
    compile_mjcf,
    mesh_by_mujoco,
    whole_mjcf,
)
from gaitopt.importers.mjcf_extract import extract
from gaitopt.importers.mjcf_robot import (
    NO_TURN,
    CompiledBody,
    CompiledGeom,
    CompiledJoint,
    CompiledMesh,
    CompiledRobot,
    NotNormalError,
    is_normal,
    normal_text,
    read_normal,
    se3,
)
from gaitopt.importers.physics import (
    STANDARD_GRAVITY,
    LoopFrames,
    PassiveJoint,
    Physics,
    PointMass,
    Tie,
    ties_to_masters,
)
from gaitopt.importers.pinocchio_model import joint_model, rigid_body
from gaitopt.importers.report import Finding
from gaitopt.importers.source import Source, load_mesh, mesh_paths, mesh_triangles
from gaitopt.importers.xml_document import XmlTree
from gaitopt.nlp import Array

_NO_LIMIT = (-math.inf, math.inf)
_ROOT_JOINT = "root_joint"
_SITE_MARK = " (site)"


def build_mjcf_model(robot: CompiledRobot) -> pin.Model:
    """Return the model of a robot; joint 1 is a free-flyer that stands in the root body.

    Its reference configurations are the keyframes, the root at the origin.
    """
    model = pin.Model()
    model.name = robot.name
    flyer, names = _ROOT_JOINT, {joint.name for joint in robot.joints}
    while flyer in names:
        flyer += "_"
    places: list[tuple[int, pin.SE3]] = []  # of every body: joint that carries it, and where
    frames: list[int] = []
    for body in robot.bodies:
        if body.parent < 0:
            floating, place = pin.JointModelFreeFlyer(), pin.SE3.Identity()
            joint = model.addJoint(0, floating, place, flyer, *_limits(floating))
            frame = int(model.addJointFrame(joint, 0))
        else:
            joint, place = places[body.parent]
            place, frame = place * se3(body.place), frames[body.parent]
        for own in body.joints:
            joint, place = _add_joint(model, joint, place, own)
            frame = int(model.addJointFrame(joint, frame))
        model.appendBodyToJoint(joint, _inertia(body), place)
        places.append((joint, place))
        own_frame = pin.Frame(body.name, joint, frame, place, pin.FrameType.BODY)
        frames.append(int(model.addFrame(own_frame, False)))
        for site in body.sites:
            at, name = place * se3(site.place), _frame_name(robot, site.name)
            model.addFrame(pin.Frame(name, joint, frames[-1], at, pin.FrameType.OP_FRAME), False)
    for name, angles in robot.keyframes:
        q = np.array(pin.neutral(model))
        for moved, angle in angles:
            q[model.joints[model.getJointId(moved)].idx_q] = angle
        model.referenceConfigurations[name] = q
    return model


def _frame_name(robot: CompiledRobot, site: str) -> str:
    """Return the name of a site's frame: one that a body or a joint has, too, gets a mark."""
    taken = {joint.name for joint in robot.joints} | {body.name for body in robot.bodies}
    return site + _SITE_MARK if site in taken else site


def _add_joint(
    model: pin.Model, parent: int, place: pin.SE3, own: CompiledJoint
) -> tuple[int, pin.SE3]:
    """Add a joint of a body that stands at a place in its parent; return both as they are then."""
    anchor, axis = np.array(own.pos), np.array(own.axis)
    at = place * pin.SE3(np.eye(3), anchor)
    if own.kind == "ball":
        moving = pin.JointModelSpherical()
    else:
        moving = joint_model(axis, own.kind == "slide")
        if own.ref and own.kind == "hinge":
            at = at * pin.SE3(pin.AngleAxis(-own.ref, axis).toRotationMatrix(), np.zeros(3))
        elif own.ref:
            at = at * pin.SE3(np.eye(3), -own.ref * axis)
    # Of the force that its motors give, the smaller counts to both sides.
    force = max(min(-own.least, own.most), 0.0)
    limits = _limits(moving, force, (own.lower, own.upper))
    joint = int(model.addJoint(parent, moving, at, own.name, *limits))
    first, count = model.joints[joint].idx_v, model.joints[joint].nv
    model.armature[first : first + count] = own.armature
    return joint, pin.SE3(np.eye(3), -anchor)


def _limits(
    moving: pin.JointModel, force: float = math.inf, ends: tuple[float, float] = _NO_LIMIT
) -> tuple[Array, ...]:
    """Limits in the order of `pin.Model.addJoint`: effort, rate, and both ends of the range."""
    sizes = ((force, moving.nv), (math.inf, moving.nv), (ends[0], moving.nq), (ends[1], moving.nq))
    return tuple(np.full(size, value) for value, size in sizes)


def _inertia(body: CompiledBody) -> pin.Inertia:
    axes = se3(body.centre)
    with np.errstate(all="ignore"):  # impossible numbers are refused where they matter
        tensor = axes.rotation @ np.diag(body.moments) @ axes.rotation.T
        tensor = tensor / 2.0 + tensor.T / 2.0
    return rigid_body(body.mass, axes.translation, tensor)


def _shape(geom: CompiledGeom) -> coal.CollisionGeometry:
    a, b, c = geom.size
    return {
        "sphere": lambda: coal.Sphere(a),
        "capsule": lambda: coal.Capsule(a, 2.0 * b),
        "cylinder": lambda: coal.Cylinder(a, 2.0 * b),
        "ellipsoid": lambda: coal.Ellipsoid(a, b, c),
        "box": lambda: coal.Box(2.0 * a, 2.0 * b, 2.0 * c),
    }[geom.kind]()


def _mesh_item(name: str, mesh: CompiledMesh, paths: MeshPaths) -> pin.GeometryObject | None:
    """Return the shape of a mesh in its own frame, None if its file is missing."""
    none = pin.SE3.Identity()
    if not mesh.file:
        points, triangles = (np.reshape(n, (-1, 3)) for n in (mesh.vertices, mesh.triangles))
        return pin.GeometryObject(name, 0, none, _triangles(points, triangles))
    path = paths.find(mesh.file)
    if path is None or paths.problem(mesh.file):
        return None
    scale, ref = np.array(mesh.scale), se3(mesh.ref)
    if mesh.ref.quat == NO_TURN or (scale == scale[0]).all():
        moved = pin.SE3(ref.rotation, scale * ref.translation).inverse()
        shape = _loaded(path, scale)
        if shape is not None:
            return pin.GeometryObject(name, 0, moved, shape, str(path), scale)
    # Turned before it is stretched, as no placement can be.
    points, triangles = _corners(path)
    points = (points - ref.translation) @ ref.rotation * scale
    return pin.GeometryObject(name, 0, none, _triangles(points, triangles))


def _loaded(path: Path, scale: Array) -> coal.BVHModelBase | None:
    try:
        return load_mesh(str(path), scale)
    except (ValueError, RuntimeError):
        return None


def _corners(path: Path) -> tuple[Array, NDArray[Any]]:
    """Return corners (n, 3) and triangles (m, 3) of a mesh file."""
    if (shape := _loaded(path, np.ones(3))) is not None:
        return mesh_triangles(shape)
    if (read := mesh_by_mujoco(path)) is None:
        raise RobotError(
            f"the mesh '{path.name}' cannot be read; write it again, in STL format say"
        )
    return read


def _triangles(points: Array, triangles: NDArray[Any]) -> coal.BVHModelBase:
    corners, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for point in points:
        corners.append(point)
    for a, b, c in triangles:
        faces.append(coal.Triangle(int(a), int(b), int(c)))
    shape = coal.BVHModelOBB()
    shape.beginModel(len(triangles), len(points))
    shape.addSubModel(corners, faces)
    shape.endModel()
    return shape


@dataclass(frozen=True, eq=False)
class MjcfSource(Source):
    """An MJCF file.

    Attributes:
        compiled: what MuJoCo made of it.
        notes: what a person should know about how MuJoCo's numbers were read.
    """

    format = "mjcf"
    compiled: CompiledRobot
    notes: tuple[Finding, ...] = ()

    @cached_property
    def physics(self) -> Physics:
        robot = self.compiled
        joints = (
            (joint.name, PassiveJoint(joint.damping, joint.friction, joint.stiffness, joint.rest))
            for joint in robot.joints
        )
        x, y, z = se3(robot.bodies[0].place).rotation.T @ np.array(robot.gravity)
        own = robot.gravity != (0.0, 0.0, -STANDARD_GRAVITY)
        return Physics(
            joints={name: joint for name, joint in joints if not joint.idle},
            gravity=(float(x), float(y), float(z)) if own else None,
            compensated={
                body.name: PointMass(body.gravcomp * body.mass, body.centre.pos)
                for body in robot.bodies
                if body.gravcomp and body.mass
            },
        )

    @property
    def drawn_posture(self) -> Mapping[str, float]:
        return self.compiled.drawn_posture

    @cached_property
    def ties(self) -> Mapping[str, Tie]:
        return ties_to_masters(self.compiled.followers)[0]

    @property
    def loops(self) -> tuple[LoopFrames, ...]:
        robot = self.compiled
        return tuple(
            LoopFrames(
                _frame_name(robot, one.site1), _frame_name(robot, one.site2), one.kind == "weld"
            )
            for one in robot.loops
        )

    @property
    def loop_motors(self) -> tuple[str, ...]:
        return self.compiled.motors

    def mesh_problems(self) -> list[MeshProblem]:
        """Return the meshes at fault, once for every shape that is drawn or can touch."""
        meshes, problems = self.compiled.meshes, list[MeshProblem]()
        reasons = {m.name: (m.file, self._paths.problem(m.file)) for m in meshes if m.file}
        for body in self.compiled.bodies:
            for geom in body.geoms:
                file, reason = reasons.get(geom.mesh, ("", ""))
                if reason and (geom.drawn or geom.touches):
                    kind = "visual" if geom.drawn else "collision"
                    problems.append(MeshProblem(body.name, kind, file, reason))
        return problems

    def findings(self) -> tuple[Finding, ...]:
        return self.notes

    def _build(self) -> pin.Model:
        try:
            return build_mjcf_model(self.compiled)
        except (ValueError, RuntimeError, IndexError, KeyError) as error:
            # Pinocchio puts where in its own code the error arose before the message proper.
            told = str(error).split("message:")[-1].strip() or type(error).__name__
            text = f"the MJCF file cannot be read: {told.splitlines()[0]}; correct it"
            raise RobotError(text) from error

    def _shapes(
        self, kind: pin.GeometryType, links: Collection[str] | None, load: LoadMesh
    ) -> pin.GeometryModel | None:
        del load  # only those of a URDF may be unreadable
        shapes, model, paths = pin.GeometryModel(), self._whole, self._paths
        meshes = {mesh.name: mesh for mesh in self.compiled.meshes}
        visual = kind == pin.GeometryType.VISUAL
        for body in self.compiled.bodies:
            if links is not None and body.name not in links:
                continue
            own = model.getFrameId(body.name, pin.FrameType.BODY)
            frame = model.frames[own]
            for number, geom in enumerate(body.geoms):
                if not (geom.drawn if visual else geom.touches):
                    continue
                name, at = f"{body.name}_{number}", frame.placement * se3(geom.place)
                if geom.mesh:
                    item = _mesh_item(name, meshes[geom.mesh], paths)
                    if item is None:
                        continue
                    item.placement = at * item.placement
                else:
                    item = pin.GeometryObject(name, 0, at, _shape(geom))
                item.parentJoint, item.parentFrame = frame.parentJoint, own
                item.meshColor = np.array(geom.rgba)
                shapes.addGeometryObject(item)
        return shapes if shapes.ngeoms else None

    def _mesh_files(self) -> list[str]:
        return [mesh.file for mesh in self.compiled.meshes if mesh.file]


def read_mjcf(tree: XmlTree, text: str, path: Path | None, dirs: tuple[str, ...]) -> MjcfSource:
    """Read a robot from an MJCF file.

    Raises:
        RobotError: what the file describes is no robot.
        MissingExtraError: MuJoCo is not installed.
    """
    if is_normal(tree.root):
        check_magnitudes(tree)
        try:
            return MjcfSource(text, path, dirs, (), tree, read_normal(tree.root))
        except NotNormalError:
            pass  # changed by hand; it is still MJCF
    whole = whole_mjcf(tree, None if path is None else path.parent)
    compiled = compile_mjcf(text, path, whole, mesh_paths(path, dirs))
    robot, problems, notes = extract(compiled, whole)
    return MjcfSource(normal_text(robot), path, dirs, problems, whole, robot, notes)
