"""What a robot is drawn with: the visual shapes of its file, or a skeleton if it has none.

Pinocchio's own visualiser is not used: its import alone takes as long as a page, and it puts whole
mesh files, authors and paths included, into a page.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError
from gaitopt.gait.recorded import Recorded, recorded_choices
from gaitopt.importers.meshes import MeshProblem
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source, load_mesh
from gaitopt.model.multibody import Multibody
from gaitopt.nlp import Array
from gaitopt.view.mesh_data import GREY, MeshData, read_mesh
from gaitopt.view.simplify import Surface, simplified
from gaitopt.view.stick_figures import at_reference, stick_figures, trunk_top
from gaitopt.view.viewer import Node, geometry

# MeshCat's cylinders stand along y, the others' along z
UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
_AROUND, _ALONG = 30, 10  # facets of a capsule: around its axis, and from rim to pole
_BONE = 0.025  # m: radius of the skeleton's limbs
_FOOT = 0.02  # m: thickness of its feet
_ENOUGH = 0.5  # of the moving bodies of the legs must be drawn
_POINT = 0.06  # m: edge of the box that shows a load without one
_LOAD = np.array([0.55, 0.36, 0.16, 1.0])
_STANCE, _SWING, _TRUNK = 0xD55E00, 0x0072B2, 0x333333  # the colours of the figures


@dataclass(frozen=True, eq=False)
class RobotShapes:
    """What a walking robot is drawn with.

    Attributes:
        shapes: body of `Multibody` that carries a shape, 0 for the base; the shape; its placement
            in the body's frame.
        note: what is missing and how to get it, or empty.
    """

    shapes: tuple[tuple[int, pin.GeometryObject, pin.SE3], ...]
    note: str = ""

    @property
    def carriers(self) -> tuple[int, ...]:
        """The bodies that carry something."""
        return tuple(sorted({body for body, _, _ in self.shapes}))


def robot_shapes(gait: Recorded, package_dirs: tuple[str, ...] = ()) -> RobotShapes:
    """Return the visual shapes of a gait's robot, a skeleton if those of a leg are missing.

    Args:
        gait: its robot's file is drawn.
        package_dirs: where to look for meshes, before the directories that the gait records.

    Raises:
        RobotError: the robot's file cannot be read.
    """
    source = _source(gait, package_dirs)
    lost = [p for p in source.mesh_problems() if p.kind == "visual"]
    note = _note(lost[0], len(lost)) if lost else ""
    try:
        found = source.geometry(pin.GeometryType.VISUAL, load=unloaded)
    except RobotError as error:
        found, note = None, str(error)
    body = gait.trajectory.body
    if found is not None:
        _add_payloads(gait, source, found)
        shapes = tuple(_carried(gait, body, source, found))
        legs = {row + 1 for foot in (0, 1) for row in body.leg(foot)}
        if not lost or len(legs & {carrier for carrier, _, _ in shapes}) >= _ENOUGH * len(legs):
            return RobotShapes(shapes, note)
    skeleton = tuple(_skeleton(gait, body))
    return RobotShapes(skeleton, note and f"{note}. The robot is drawn as a skeleton")


def unloaded(path: str, scale: Array) -> coal.BVHModelBase:
    """Return an empty mesh for a file that is read here when drawn, else the mesh, by scale (3,).

    Coal builds a tree of boxes about every mesh, for which a page has no use and which takes fifty
    times as long as reading the file.
    """
    if Path(path).suffix.lower() in (".stl", ".obj") and file_parts(path) is not None:
        return coal.BVHModelOBB()
    return load_mesh(path, scale)


def draw_shape(robot: Node, group: str, item: pin.GeometryObject, placement: pin.SE3) -> None:
    """Draw one shape of a robot, as the node `group`/NAME below the robot's.

    Args:
        robot: its node.
        group: name of the node that carries the shape.
        item: the shape, with name, scale and colour.
        placement: in the group.
    """
    node = robot[f"{group}/{item.name}"]
    matrix = placement.homogeneous @ np.diag([*item.meshScale, 1.0])
    solid = item.geometry
    if _suffix(item) or isinstance(solid, coal.BVHModelBase):
        parts = file_parts(item.meshPath)
        loaded = None if parts is not None else _loaded(solid, item.meshScale)
        _draw_parts(node, parts or (() if loaded is None else mesh_parts(loaded)), item)
    else:
        node.set_object(_simple(solid), _material(item))
        if isinstance(solid, coal.Cylinder | coal.Cone):
            matrix = matrix @ UPRIGHT
    node.set_transform(matrix)


def capsule(radius: float, half: float) -> tuple[Array, Array]:
    """Return corners (V, 3) [m] and triangles (F, 3) of a capsule along z, seen from outside.

    Args:
        radius: of the capsule [m].
        half: from its middle to the centre of either end [m].
    """
    rise = np.linspace(0.0, np.pi / 2.0, _ALONG + 1)
    rise = np.concatenate([-rise[::-1], rise])  # from pole to pole, each rim once
    centre = np.repeat([-half, half], _ALONG + 1)
    turn = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    x, y = (np.outer(radius * np.cos(rise), f(turn)) for f in (np.cos, np.sin))
    z = np.outer(centre + radius * np.sin(rise), np.ones(_AROUND))
    corners = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    ring, place = (i.ravel() for i in np.indices((len(rise) - 1, _AROUND)))
    here, beside = ring * _AROUND + place, ring * _AROUND + (place + 1) % _AROUND
    above, across = here + _AROUND, beside + _AROUND
    faces = np.concatenate(
        [np.stack([here, beside, across], axis=1), np.stack([here, across, above], axis=1)]
    )
    return corners, faces


def _source(gait: Recorded, package_dirs: tuple[str, ...]) -> Source:
    directories = (*package_dirs, *recorded_choices(gait).package_dirs)
    try:
        return read_source(gait.urdf, tuple(dict.fromkeys(directories)))
    except RobotError as error:
        raise RobotError(f"the gait's URDF cannot be read: {error}") from error


def _note(lost: MeshProblem, count: int) -> str:
    others = f" and {count - 1} more are not drawn" if count > 1 else " is not drawn"
    return (
        f"the mesh '{lost.file}' {lost.reason}: it{others}; give the directory that holds its "
        "package (--package-dir)"
    )


def _add_payloads(gait: Recorded, source: Source, shapes: pin.GeometryModel) -> None:
    """Add the loads that the robot carries, as boxes in their links."""
    model = source.model()
    for number, load in enumerate(recorded_choices(gait).payloads):
        frame = model.frames[model.getFrameId(load.link)]
        lengths = [length or _POINT for length in load.box]
        place = frame.placement * pin.SE3(np.eye(3), np.array(load.place or np.zeros(3)))
        shape = pin.GeometryObject(
            f"payload_{number}", frame.parentJoint, place, coal.Box(*lengths)
        )
        shape.meshColor = _LOAD
        shapes.addGeometryObject(shape)


def _carried(
    gait: Recorded, body: Multibody, source: Source, shapes: pin.GeometryModel
) -> Iterator[tuple[int, pin.GeometryObject, pin.SE3]]:
    """Yield each shape with the nearest body towards the base that moves, and its place there."""
    model, data = at_reference(gait, source)
    rows = {body.joint_names[row]: int(row) + 1 for row in body.driven}
    for item in shapes.geometryObjects:
        joint = item.parentJoint
        while joint > 1 and str(model.names[joint]) not in rows:
            joint = model.parents[joint]
        inside = data.oMi[joint].actInv(data.oMi[item.parentJoint]) * item.placement
        yield rows.get(str(model.names[joint]), 0), item, inside


def _skeleton(gait: Recorded, body: Multibody) -> Iterator[tuple[int, pin.GeometryObject, pin.SE3]]:
    """Yield capsules from joint to joint, plates for the feet and a bar for the trunk."""
    at_rest = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], body.posture])[None]
    places = body.placements(at_rest)[0]
    sticks = stick_figures(body, at_rest, trunk_top(gait))
    bars: list[tuple[int, Array, Array, int]] = []
    for foot, colour in ((0, _STANCE), (1, _SWING)):
        points, rows = sticks.legs[0, foot], [row + 1 for row in body.leg(foot)]
        bars += [(row, *ends, colour) for row, ends in zip(rows[1:], pairwise(points), strict=True)]
        bars.append((rows[0], points[0], sticks.soles[0, foot].mean(axis=0), colour))
        yield _foot(body, foot, colour)
    bars.append((0, *sticks.trunk[0], _TRUNK))
    bars.append((0, *sticks.legs[0, :, -1], _TRUNK))
    for number, (row, start, end, colour) in enumerate(bars):
        span = end - start
        length = float(np.linalg.norm(span))
        if length >= 1e-6:
            turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), span / length).matrix()
            place = pin.SE3(places[row]).actInv(pin.SE3(turn, (start + end) / 2.0))
            yield row, _bone(f"bone_{number}", coal.Capsule(_BONE, length), colour), place


def _foot(body: Multibody, foot: int, colour: int) -> tuple[int, pin.GeometryObject, pin.SE3]:
    toe, heel, left, right = body.sole_rectangle[foot]
    centre = np.array([(toe + heel) / 2.0, (left + right) / 2.0, _FOOT / 2.0])
    place = pin.SE3(body.sole_placement[foot]) * pin.SE3(np.eye(3), centre)
    plate = coal.Box(toe - heel, left - right, _FOOT)
    return int(body.sole_joint[foot]) + 1, _bone(f"foot_{foot}", plate, colour), place


def _bone(name: str, shape: coal.CollisionGeometry, colour: int) -> pin.GeometryObject:
    item = pin.GeometryObject(name, 0, pin.SE3.Identity(), shape)
    item.meshColor = np.array([*((colour >> shift & 0xFF) / 255.0 for shift in (16, 8, 0)), 1.0])
    return item


def _simple(solid: coal.CollisionGeometry) -> geometry.Geometry:
    """Return a simple shape as MeshCat's."""
    if isinstance(solid, coal.Box):
        return geometry.Box(list(2.0 * solid.halfSide))
    if isinstance(solid, coal.Sphere):
        return geometry.Sphere(solid.radius)
    if isinstance(solid, coal.Cylinder):
        return geometry.Cylinder(2.0 * solid.halfLength, solid.radius)
    if isinstance(solid, coal.Cone):
        height = 2.0 * solid.halfLength
        return geometry.Cylinder(height, radiusTop=0.0, radiusBottom=solid.radius)
    if isinstance(solid, coal.Ellipsoid):
        return geometry.Ellipsoid(np.ravel(solid.radii))
    return geometry.TriangularMeshGeometry(*capsule(solid.radius, solid.halfLength))


def _suffix(item: pin.GeometryObject) -> str:
    """Return the suffix of the file; the "file" of a simple shape is BOX or the like."""
    return Path(item.meshPath).suffix.lower()


def _loaded(solid: object, scale: Array) -> MeshData | None:
    """Return the triangles of a mesh as it was read, before it was scaled."""
    if not isinstance(solid, coal.BVHModelBase) or not np.all(scale) or not solid.num_tris:
        return None
    corners = np.array(solid.vertices()) / scale
    faces = [solid.tri_indices(i) for i in range(solid.num_tris)]
    return MeshData(corners[np.array([[f[0], f[1], f[2]] for f in faces], dtype=np.intp)])


Part = tuple[Array | None, Surface]
"""What is drawn of a mesh in one colour (4,), in that of the robot's file where it is None."""


def mesh_parts(mesh: MeshData) -> tuple[Part, ...]:
    """Return a mesh by its colours, simplified where triangles are many."""
    if mesh.colours is None:
        return ((None, _surface(mesh.corners, mesh.normals)),)
    colours, which = np.unique(mesh.colours, axis=0, return_inverse=True)
    each = [which.reshape(-1) == number for number in range(len(colours))]
    return tuple(
        (colour, _surface(mesh.corners[rows], None if mesh.normals is None else mesh.normals[rows]))
        for colour, rows in zip(colours, each, strict=True)
    )


def file_parts(path: str) -> tuple[Part, ...] | None:
    """Return the parts of a mesh file that is read here, else None; those of the last are kept."""
    with suppress(OSError, ValueError):  # a simple shape has no file
        facts = Path(path).stat()
        return _file_parts(path, facts.st_mtime_ns, facts.st_size)
    return None


@lru_cache(maxsize=256)
def _file_parts(path: str, _changed: int, _size: int) -> tuple[Part, ...] | None:
    mesh = read_mesh(path)
    return None if mesh is None else mesh_parts(mesh)


def triangles(corners: Array) -> geometry.Geometry:
    """Return triangles (M, 3, 3) as MeshCat's, simplified where they are many."""
    return _Triangles(_surface(corners, None))


def _surface(corners: Array, normals: Array | None) -> Surface:
    few = simplified(corners)
    if few is not None:
        return few
    flat = corners.reshape(-1, 3)
    return Surface(flat, normals, np.arange(len(flat)).reshape(-1, 3))


def _draw_parts(node: Node, parts: tuple[Part, ...], item: pin.GeometryObject) -> None:
    """Draw the parts of a mesh, as the node or as one node each below it."""
    for number, (colour, surface) in enumerate(parts):
        part = node if len(parts) == 1 else node[str(number)]
        material = _material(item) if colour is None else _painted(colour)
        part.set_object(_Triangles(surface), material)


class _Triangles(geometry.TriangularMeshGeometry):  # type: ignore[misc]
    """Triangles with normals at their corners; where there are none, facets are flat."""

    def __init__(self, surface: Surface) -> None:
        super().__init__(surface.corners, surface.faces)
        self.normals = surface.normals

    def lower(self, object_data: object) -> dict[str, object]:
        """Return the geometry as the viewer reads it."""
        made: dict[str, object] = super().lower(object_data)
        if self.normals is not None:
            flat = np.asarray(self.normals, dtype=np.float32).reshape(-1, 3)
            made["data"]["attributes"]["normal"] = geometry.pack_numpy_array(flat.T)  # type: ignore[index]
        return made


def _material(item: pin.GeometryObject) -> geometry.Material:
    lustre = item.meshMaterial
    shines: dict[str, float] = {}
    if item.overrideMaterial and isinstance(lustre, pin.GeometryPhongMaterial):
        shines["emissive"] = _number(lustre.meshEmissionColor)
        shines["specular"] = _number(lustre.meshSpecularColor)
        shines["shininess"] = 100.0 * lustre.meshShininess
    black = _suffix(item) == ".dae" and not item.meshColor[:3].any()  # on it no shape can be seen
    return _painted(GREY if black else item.meshColor, **shines)


def _painted(colour: Array, **more: float) -> geometry.Material:
    """Return the material of a colour with opacity."""
    opacity = float(colour[3])
    return geometry.MeshPhongMaterial(
        color=_number(colour), opacity=opacity, transparent=opacity < 1.0, **more
    )


def _number(colour: Array) -> int:
    """Return red, green and blue, each from 0 to 1, as one number."""
    red, green, blue = (int(255.0 * c) for c in np.clip(colour[:3], 0.0, 1.0))
    return (red << 16) + (green << 8) + blue
