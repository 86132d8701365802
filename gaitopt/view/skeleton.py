"""The robot as a few points and lines: hips, knees, ankles, soles and trunk in the world."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin

from gaitopt.gait.result import Gait
from gaitopt.importers.source import read_source
from gaitopt.nlp import Array
from gaitopt.view.body import joint_indices, resting, upward

_REFLECTION = np.array([1.0, -1.0, 1.0])
_EXCHANGE = [1, 0, 3, 2]  # a sole's left corners are the mirror image of the other's right ones
_TRUNK_TO_LEG = 0.9  # trunk length over leg length, where the model does not show the trunk
_STUB = 0.3  # of the leg's length: less above the hips is a pelvis, not a trunk


@dataclass(frozen=True, eq=False)
class StickFigures:
    """Stick figures of M configurations, points in the world [m].

    Attributes:
        legs: joint origins from ankle to hip, shape (M, 2, joints of a leg, 3); leg 0 is the one of
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
    q = resting(gait, model)
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
    count = gait.leg_joints
    swing = gait.joint_names[count : 2 * count]
    joints = [model.getJointId(n) for n in (*gait.joint_names[:count], *reversed(swing))]
    top = trunk_top(gait, model)
    data = model.createData()
    legs, soles, trunk = [], [], []
    for q in configurations:
        pin.framesForwardKinematics(model, data, q)
        points = np.array([data.oMi[j].translation for j in joints]).reshape(2, count, 3)
        legs.append(points)
        soles.append(
            [data.oMf[f].act(c) for f, cs in zip(frames, corners, strict=True) for c in cs]
        )
        trunk.append([points[:, -1].mean(axis=0), data.oMi[1].act(top)])
    return StickFigures(np.array(legs), np.reshape(soles, (-1, 2, 4, 3)), np.array(trunk))


def trunk_top(gait: Gait, model: pin.Model) -> Array:
    """Return the top of the trunk, above the middle of the hips, in the root joint's frame [m].

    It is the highest joint, or the top of what the URDF draws with simple shapes; in proportion to
    the legs if neither is clearly above the hips.
    """
    data, up = model.createData(), upward(gait)
    pin.framesForwardKinematics(model, data, resting(gait, model))
    hips = [data.oMi[model.getJointId(n)].translation for n in gait.joint_names[5:7]]
    ankles = [data.oMi[model.getJointId(n)].translation for n in gait.joint_names[0::11]]
    middle = np.mean(hips, axis=0)
    leg = float(np.linalg.norm(hips[0] - ankles[0]))
    joints = max(float(up @ place.translation) for place in list(data.oMi)[1:])
    above = max(joints, _drawn_top(gait, model, data)) - float(up @ middle)
    return np.asarray(middle + up * (above if above > _STUB * leg else _TRUNK_TO_LEG * leg))


def _drawn_top(gait: Gait, model: pin.Model, data: pin.Data) -> float:
    """Return the highest point of the shapes that are no meshes [m], -inf if none."""
    # Read from its text alone, without directories, a robot has no meshes: loading them takes long.
    shapes = read_source(gait.urdf).geometry(pin.GeometryType.VISUAL)
    if shapes is None:
        return -np.inf
    up, placements = upward(gait), shapes.createData()
    pin.updateGeometryPlacements(model, data, shapes, placements)
    tops = [
        _top(shape.geometry, place, up)
        for shape, place in zip(shapes.geometryObjects, placements.oMg, strict=True)
    ]
    return max(tops)


def _top(shape: Any, place: pin.SE3, up: Array) -> float:
    """Return the highest point of the box around a shape."""
    shape.computeLocalAABB()
    box = shape.aabb_local
    half = np.array([box.width(), box.height(), box.depth()]) / 2.0
    centre = place.act(shape.aabb_center)
    return float(up @ centre + np.abs(place.rotation.T @ up) @ half)
