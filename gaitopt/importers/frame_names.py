"""Links that bear the name of a joint, as URDF and MJCF allow; Pinocchio has one frame for each.

It finds frames by name alone, and refuses a name that two of them have. A link keeps its name, for
soles are asked for by it; the frame of the joint gets a mark while anything but Pinocchio's own
reduction looks for frames.
"""

from __future__ import annotations

import pinocchio as pin

from gaitopt.nlp import Array

_JOINT, _LINK = " (joint)", " (link)"


def tell_apart(model: pin.Model) -> pin.Model:
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
