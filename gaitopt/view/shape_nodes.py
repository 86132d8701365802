"""One shape of a robot as a node of the viewer.

Simple shapes, and the triangles of meshes, are drawn here; the rest is left to Pinocchio's
visualiser, whose import alone takes as long as a page. Of a mesh file nothing but its shape and its
colours comes into a page.
"""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

import coal
import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.view.bare_collada import bare_collada
from gaitopt.view.mesh_files import mesh_triangles
from gaitopt.view.meshcat_quiet import geometry, meshcat, pinocchio_visualizer

# MeshCat's cylinders stand along y, the others' along z
UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])
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
    text = bare_collada(item.meshPath) if _keeps_colours(item) else None
    shape = None if text is not None else _shape(item)
    if text is not None:
        node.window.send(_ColladaScene(node, text))
    elif shape is None:
        _leave_to_pinocchio(robot, group, item)
    else:
        node.set_object(shape, _material(item))
        if not _suffix(item) and isinstance(item.geometry, coal.Cylinder | coal.Cone):
            matrix = matrix @ UPRIGHT
    node.set_transform(matrix)


def _shape(item: pin.GeometryObject) -> geometry.Geometry | None:
    """Return the shape as MeshCat's, None if it is not known here."""
    solid = item.geometry
    if _suffix(item) or isinstance(solid, coal.BVHModelBase):
        corners = mesh_triangles(item.meshPath)
        if corners is None:
            corners = _triangles(solid, item.meshScale)
        return None if corners is None else _facets(corners)
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


def _triangles(solid: object, scale: Array) -> Array | None:
    """Return the triangles of a mesh as it was read, shape (M, 3, 3), before it was scaled."""
    if not isinstance(solid, coal.BVHModelBase) or not np.all(scale):
        return None
    corners = np.array(solid.vertices()) / scale
    faces = [solid.tri_indices(i) for i in range(solid.num_tris)]
    return corners[np.array([[f[0], f[1], f[2]] for f in faces], dtype=np.intp)]


def _facets(corners: Array) -> geometry.Geometry:
    """Return triangles (M, 3, 3) as a shape with flat facets: no two of them share a corner."""
    points = corners.reshape(-1, 3)
    return geometry.TriangularMeshGeometry(points, np.arange(len(points)).reshape(-1, 3))


def _material(item: pin.GeometryObject) -> geometry.Material:
    opacity, lustre = float(item.meshColor[3]), item.meshMaterial
    shines: dict[str, float] = {}
    if item.overrideMaterial and isinstance(lustre, pin.GeometryPhongMaterial):
        shines["emissive"] = _number(lustre.meshEmissionColor)
        shines["specular"] = _number(lustre.meshSpecularColor)
        shines["shininess"] = 100.0 * lustre.meshShininess
    return geometry.MeshPhongMaterial(
        color=_number(item.meshColor), opacity=opacity, transparent=opacity < 1.0, **shines
    )


def _number(colour: Array) -> int:
    """Return red, green and blue, each from 0 to 1, as one number."""
    red, green, blue = (int(255.0 * c) for c in np.clip(colour[:3], 0.0, 1.0))
    return (red << 16) + (green << 8) + blue


def _keeps_colours(item: pin.GeometryObject) -> bool:
    """Whether a Collada file is to be drawn in its own colours, see `drawable`."""
    return _suffix(item) == ".dae" and not item.overrideMaterial


class _ColladaScene:
    """The command that draws a Collada document as a node."""

    def __init__(self, node: meshcat.Visualizer, text: str) -> None:
        self._path, self._text = node.path, text

    def lower(self) -> dict[str, object]:
        """Return the command as the viewer reads it."""
        whole = {
            "uuid": str(uuid4()),
            "type": "_meshfile_object",
            "format": "dae",
            "data": self._text,
            "resources": {},
            "matrix": np.eye(4).ravel().tolist(),
        }
        made = {"metadata": {"version": 4.5, "type": "Object"}, "geometries": [], "materials": []}
        return {
            "type": "set_object",
            "path": self._path.lower(),
            "object": {**made, "object": whole},
        }


def _leave_to_pinocchio(robot: meshcat.Visualizer, group: str, item: pin.GeometryObject) -> None:
    drawer = pinocchio_visualizer()(pin.Model(), pin.GeometryModel(), pin.GeometryModel())
    drawer.initViewer(viewer=robot)
    drawer.viewerVisualGroupName = group
    drawer.loadViewerGeometryObject(item, pin.GeometryType.VISUAL)
