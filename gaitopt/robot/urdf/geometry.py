"""The Pinocchio geometry of a URDF, made shape by shape, so that one mesh at fault costs itself."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterable

import coal
import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.files.meshes import MeshPaths, MeshProblem, unreadable
from gaitopt.robot.files.silence import silenced
from gaitopt.robot.urdf.build import placement
from gaitopt.robot.urdf.shapes import GREY, Shape

Loader = Callable[[str, Array], coal.CollisionGeometry]


def build_geometry(
    model: pin.Model,
    shapes: Iterable[Shape],
    paths: MeshPaths,
    load: Loader,
    links: Collection[str] | None = None,
) -> tuple[pin.GeometryModel, list[MeshProblem]]:
    """Return the geometry of a model, and the meshes that turned out to be unreadable.

    Args:
        model: from `build_model`.
        shapes: of one kind.
        paths: where meshes are; those with a problem there are left out without a word.
        load: reads a mesh file at a scale.
        links: names of the links whose shapes are wanted; None for all.
    """
    geometry, lost = pin.GeometryModel(), []
    frames = {f.name: i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}
    counts: Counter[str] = Counter()
    for shape in shapes:
        if shape.link not in frames or not (links is None or shape.link in links):
            continue
        if shape.form == "mesh" and _mesh_problem(shape, paths) is not None:
            continue
        file = str(paths.find(shape.file)) if shape.form == "mesh" else ""
        form = _form(shape, file, load)
        if form is None:
            reason = "is not a mesh that can be read"
            lost.append(MeshProblem(shape.link, shape.kind, shape.file, reason, there=True))
            continue
        name = f"{shape.link}_{counts[shape.link]}"
        counts[shape.link] += 1
        geometry.addGeometryObject(_object(model, frames[shape.link], name, shape, form, file))
    return geometry, lost


def mesh_problems(shapes: Iterable[Shape], paths: MeshPaths) -> list[MeshProblem]:
    """Return the meshes that cannot be used, in the order of the file.

    Args:
        shapes: of a robot.
        paths: where meshes are.
    """
    meshes = (shape for shape in shapes if shape.form == "mesh")
    found = (_mesh_problem(shape, paths) for shape in meshes)
    return [problem for problem in found if problem is not None]


def _mesh_problem(shape: Shape, paths: MeshPaths) -> MeshProblem | None:
    reason, there = paths.problem(shape.file), False
    path = None if reason else paths.find(shape.file)
    if path is not None:
        reason, there = unreadable(path), True
    return MeshProblem(shape.link, shape.kind, shape.file, reason, there) if reason else None


def diagonals(model: pin.Model, geometry: pin.GeometryModel) -> dict[str, float]:
    """Return the diagonal of a box about all shapes of each link that has some [m].

    Args:
        model: of the robot.
        geometry: that holds the shapes.
    """
    corners: dict[str, list[Array]] = {}
    for item in geometry.geometryObjects:
        item.geometry.computeLocalAABB()
        box = item.geometry.aabb_local
        ends = np.array([np.ravel(box.min_), np.ravel(box.max_)])
        frame = model.frames[item.parentFrame]
        place = frame.placement.actInv(item.placement)
        places = [place.act(np.array(corner)) for corner in itertools.product(*ends.T)]
        corners.setdefault(frame.name, []).extend(places)
    return {name: float(np.linalg.norm(np.ptp(each, axis=0))) for name, each in corners.items()}


def _form(shape: Shape, file: str, load: Loader) -> coal.CollisionGeometry | None:
    """Return the form of a shape, None if its mesh cannot be read."""
    size = shape.size
    if shape.form == "box":
        return coal.Box(*size)
    if shape.form == "sphere":
        return coal.Sphere(size[0])
    if shape.form != "mesh":
        make = coal.Capsule if shape.form == "capsule" else coal.Cylinder
        return make(size[0], size[1])
    try:
        with silenced():
            mesh = load(file, np.array(size))
    except (ValueError, RuntimeError, IndexError, MemoryError):
        return None
    return mesh if np.isfinite(mesh.vertices()).all() else None


def _object(
    model: pin.Model,
    frame: int,
    name: str,
    shape: Shape,
    form: coal.CollisionGeometry,
    file: str,
) -> pin.GeometryObject:
    link = model.frames[frame]
    return pin.GeometryObject(
        name,
        link.parentJoint,
        frame,
        link.placement * placement(shape.pose),
        form,
        file,
        np.array(shape.size if shape.form == "mesh" else (1.0, 1.0, 1.0)),
        shape.colour is not None,
        np.array(shape.colour or GREY),
    )
