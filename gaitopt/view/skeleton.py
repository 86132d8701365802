"""The robot as a few points and lines: hips, knees, ankles, soles and trunk in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.walk import joint_indices

_REFLECTION = np.array([1.0, -1.0, 1.0])
_EXCHANGE = [1, 0, 3, 2]  # a sole's left corners are the mirror image of the other's right ones
_TRUNK_TO_LEG = 0.9  # trunk length over leg length, for a robot whose URDF draws no trunk


@dataclass(frozen=True, eq=False)
class StickFigures:
    """Stick figures of M configurations, points in the world [m].

    Attributes:
        legs: joint origins from ankle to hip, shape (M, 2, 6, 3); leg 0 is the one of
            `Gait.stance_sole`.
        soles: corners toe left, toe right, heel left, heel right, shape (M, 2, 4, 3).
        trunk: midpoint of the hips and top of the trunk, shape (M, 2, 3).
    """

    legs: Array
    soles: Array
    trunk: Array


def sole_corners(gait: Gait, model: pin.Model) -> Array:
    """Return the corners of the stance sole in its own frame [m], shape (4, 3).

    They are the mirror image of the swing sole, whose corners the gait records.
    """
    data = model.createData()
    q = pin.neutral(model)
    q[joint_indices(gait, model)] = gait.q[0]
    pin.framesForwardKinematics(model, data, q)
    stance, swing = (
        data.oMf[model.getFrameId(name)] for name in (gait.stance_sole, gait.swing_sole_frame)
    )
    placement = stance.inverse() * swing
    local = (gait.swing_sole[0] - placement.translation) @ placement.rotation
    return np.array((local * _REFLECTION)[_EXCHANGE])


def stick_figures(gait: Gait, model: pin.Model, configurations: Array) -> StickFigures:
    """Return the stick figures of configurations (M, nq) of the model of `walking_model`."""
    stance = sole_corners(gait, model)
    corners = (stance, (stance * _REFLECTION)[_EXCHANGE])
    frames = [model.getFrameId(n) for n in (gait.stance_sole, gait.swing_sole_frame)]
    joints = [model.getJointId(n) for n in (*gait.joint_names[:6], *reversed(gait.joint_names[6:]))]
    top = trunk_top(gait, model)
    data = model.createData()
    legs, soles, trunk = [], [], []
    for q in configurations:
        pin.framesForwardKinematics(model, data, q)
        points = np.array([data.oMi[j].translation for j in joints]).reshape(2, 6, 3)
        legs.append(points)
        soles.append(
            [data.oMf[f].act(c) for f, cs in zip(frames, corners, strict=True) for c in cs]
        )
        trunk.append([points[:, 5].mean(axis=0), data.oMi[1].act(top)])
    return StickFigures(np.array(legs), np.reshape(soles, (-1, 2, 4, 3)), np.array(trunk))


def trunk_top(gait: Gait, model: pin.Model) -> Array:
    """Return the top of the trunk, above the middle of the hips, in the root joint's frame [m].

    It is the top of what the URDF draws above the hips, or in proportion to the legs.
    """
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    hips = [data.oMi[model.getJointId(n)].translation for n in gait.joint_names[5:7]]
    ankles = [data.oMi[model.getJointId(n)].translation for n in gait.joint_names[0::11]]
    middle = np.mean(hips, axis=0)
    leg = float(np.linalg.norm(hips[0] - ankles[0]))
    height = _drawn_top(gait, model, data)
    if height is None or height <= middle[2]:
        height = middle[2] + _TRUNK_TO_LEG * leg
    return np.array([middle[0], middle[1], height])


def _drawn_top(gait: Gait, model: pin.Model, data: pin.Data) -> float | None:
    """Return the highest point of the visual shapes that are boxes, cylinders or the like."""
    try:
        shapes = pin.buildGeomFromUrdfString(model, gait.urdf, pin.GeometryType.VISUAL)
    except (ValueError, RuntimeError):  # meshes that are not on this machine
        return None
    top = None
    placements = shapes.createData()
    pin.updateGeometryPlacements(model, data, shapes, placements)
    for index, shape in enumerate(shapes.geometryObjects):
        shape.geometry.computeLocalAABB()
        centre = placements.oMg[index].act(shape.geometry.aabb_center)
        half = _half_height(shape.geometry, placements.oMg[index].rotation)
        top = max(top or -np.inf, float(centre[2]) + half)
    return top


def _half_height(geometry: object, rotation: Array) -> float:
    box = geometry.aabb_local  # type: ignore[attr-defined]
    half = np.array([box.width(), box.height(), box.depth()]) / 2.0
    return float(np.abs(rotation[2]) @ half)
