"""Joints and frames of Pinocchio models that are made here.

A link may bear the name of a joint, as URDF and MJCF allow. Pinocchio finds frames by name alone,
and refuses a name that two of them have. A link keeps its name, for soles are asked for by it; the
frame of the joint gets a mark while anything but Pinocchio's own reduction looks for frames.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array

_JOINT, _LINK = " (joint)", " (link)"
_ROUNDING = 1e-15  # of an axis: cos(pi/2) = 6e-17 as programs write it


def joint_model(axis: Array, slides: bool) -> pin.JointModel:
    """Return the joint that turns about an axis of any length (3,), or slides along it."""
    axis = axis / np.abs(axis).max()  # its square may be too large or too small for a number
    for unit, name in zip(np.eye(3), "XYZ", strict=True):
        if np.abs(axis - unit).max() < _ROUNDING:
            return getattr(pin, f"JointModel{'P' if slides else 'R'}{name}")()
    kind = pin.JointModelPrismaticUnaligned if slides else pin.JointModelRevoluteUnaligned
    return kind(axis / np.linalg.norm(axis))


def mark_joint_frames(model: pin.Model) -> pin.Model:
    """Mark, in a model just read, the frames of joints whose name a link has; return the model."""
    links = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY and frame.name in links:
            frame.name += _JOINT
    return model


def reduced(model: pin.Model, locked: list[int], q: Array) -> pin.Model:
    """Return the model without the locked joints, which stand at q (nq,).

    Pinocchio looks for the frames of joints under the names of the joints, so that here it is the
    links that are marked.
    """
    named = model.copy()
    marked = {f.name.removesuffix(_JOINT) for f in named.frames if f.name.endswith(_JOINT)}
    for frame in named.frames:
        if frame.name in marked:
            frame.name += _LINK
        frame.name = frame.name.removesuffix(_JOINT)
    without = pin.buildReducedModel(named, locked, q)
    for frame in without.frames:
        if frame.name in marked:
            frame.name += _JOINT
        frame.name = frame.name.removesuffix(_LINK)
    return without
