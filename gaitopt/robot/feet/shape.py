"""The shape of a foot: everything its last joint carries, as points that may be round."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.robot.feet.shape_points import Points, placed_shapes
from gaitopt.robot.files.source import Source


@dataclass(frozen=True)
class FootShape:
    """A foot in the frame of the last joint of its leg.

    Attributes:
        points: corners of boxes and meshes, centres of spheres, ends of capsules [m], shape (n, 3).
        radii: of the balls about the points, 0 for corners [m], shape (n,).
        kind: of the geometry the points are from: "collision" or "visual".
        parts: what they are from, as "box of 'left_foot'".
    """

    points: Array
    radii: Array
    kind: str
    parts: tuple[str, ...]

    @property
    def how(self) -> str:
        """Where the shape came from, as "collision geometry: box of 'left_foot'"."""
        counts = {part: self.parts.count(part) for part in self.parts}
        named = [part if n == 1 else f"{n} x {part}" for part, n in counts.items()]
        return f"{self.kind} geometry: {', '.join(named)}"


def foot_points(source: Source, model: pin.Model, foot_joint: int) -> FootShape | None:
    """Return the shape of all links that the last joint of a leg carries.

    Args:
        source: the robot's description.
        model: its model, or one made from it by locking joints; links keep their names.
        foot_joint: id of the joint in `model`.

    Returns:
        The collision geometry, where there is none what is drawn, None where there is neither.

    Raises:
        RobotError: a mesh file of the foot cannot be read.
    """
    links = {
        str(frame.name): frame.placement
        for frame in model.frames
        if frame.parentJoint == foot_joint and frame.type == pin.FrameType.BODY
    }
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        shapes = placed_shapes(source, kind, links, around=False)
        if shapes:
            points = Points.joined([shape.points for shape in shapes])
            parts = tuple(f"{shape.title} of '{shape.link}'" for shape in shapes)
            return FootShape(points.centres, points.radii, kind.name.lower(), parts)
    return None
