"""One shape of a robot as a node of the viewer.

Simple shapes, STL and OBJ files are drawn here; the rest is left to Pinocchio's visualiser, whose
import alone takes as long as a page.
"""

from __future__ import annotations

from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.view.meshcat_quiet import geometry, meshcat, pinocchio_visualizer

# MeshCat's cylinders stand along y, the others' along z
UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
_FILES = {
    ".stl": geometry.StlMeshGeometry.from_file,
    ".obj": geometry.ObjMeshGeometry.from_file,
}
_AROUND, _ALONG = 30, 10  # facets of a capsule: around its axis, and from rim to pole


def draw_shape(
    robot: meshcat.Visualizer, group: str, item: pin.GeometryObject, placement: pin.SE3
) -> None:
    """Draw one shape of a robot, as the node `group`/NAME below the robot's.

    Args:
        robot: its node.
        group: name of the node that carries the shape.
        item: the shape, with name, scale and colour.
        placement: in the group.
    """
    node = robot[f"{group}/{item.name}"]
    matrix = placement.homogeneous @ np.diag([*item.meshScale, 1.0])
    shape = None if _has_lustre(item) else _shape(item)
    if shape is None:
        _leave_to_pinocchio(robot, group, item)
    else:
        node.set_object(shape, _material(item.meshColor))
        if not _suffix(item) and isinstance(item.geometry, coal.Cylinder | coal.Cone):
            matrix = matrix @ UPRIGHT
    node.set_transform(matrix)


def _shape(item: pin.GeometryObject) -> geometry.Geometry | None:
    """Return the shape as MeshCat's, None if it is not known here."""
    solid = item.geometry
    if suffix := _suffix(item):
        return _FILES[suffix](item.meshPath) if suffix in _FILES else None
    if isinstance(solid, coal.Box):
        return geometry.Box(list(2.0 * solid.halfSide))
    if isinstance(solid, coal.Sphere):
        return geometry.Sphere(solid.radius)
    if isinstance(solid, coal.Cylinder):
        return geometry.Cylinder(2.0 * solid.halfLength, solid.radius)
    if isinstance(solid, coal.Cone):
        height = 2.0 * solid.halfLength
        return geometry.Cylinder(height, radiusTop=0.0, radiusBottom=solid.radius)
    if isinstance(solid, coal.Capsule):
        return geometry.TriangularMeshGeometry(*capsule(solid.radius, solid.halfLength))
    return None


def _suffix(item: pin.GeometryObject) -> str:
    """Return the suffix of the file; the "file" of a simple shape is BOX or the like."""
    return Path(item.meshPath).suffix.lower()


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


def _material(colour: Array) -> geometry.Material:
    red, green, blue = (int(255.0 * c) for c in colour[:3])
    opacity = float(colour[3])
    number = (red << 16) + (green << 8) + blue
    return geometry.MeshPhongMaterial(color=number, opacity=opacity, transparent=opacity < 1.0)


def _has_lustre(item: pin.GeometryObject) -> bool:
    """Whether the robot's file tells how the shape shines."""
    return bool(item.overrideMaterial) and isinstance(item.meshMaterial, pin.GeometryPhongMaterial)


def _leave_to_pinocchio(robot: meshcat.Visualizer, group: str, item: pin.GeometryObject) -> None:
    drawer = pinocchio_visualizer()(pin.Model(), pin.GeometryModel(), pin.GeometryModel())
    drawer.initViewer(viewer=robot)
    drawer.viewerVisualGroupName = group
    drawer.loadViewerGeometryObject(item, pin.GeometryType.VISUAL)
