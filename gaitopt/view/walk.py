"""Several steps of a gait as a film: where every part of the robot is, in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from gaitopt.bounds import FRAMES, STEPS, at_most, shown
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.nlp import Array
from gaitopt.view.body import joint_indices, resting

DEFAULT_STEPS = 6
_REFLECTION = np.array([1.0, -1.0, 1.0])  # left <-> right in sole axes: x forward, y left, z up


@dataclass(frozen=True, eq=False)
class Walk:
    """Frames of several steps; the frames of one step follow those of the step before.

    The last frame of a step and the first of the next are the same instant and posture, before
    and after the impact: rates, force and standing foot jump there. The world's origin is below
    the first stance sole frame's origin.

    Attributes:
        time: [s], shape (M,), not decreasing.
        step: number of the step of each frame, from 0, shape (M,).
        q: configuration of the free-flyer model (root position, quaternion, joints), (M, nq).
        joints: angles of `Gait.joint_names` [rad], shape (M, n).
        rates: of the same joints [rad/s], shape (M, n).
        standing: name of the standing foot's sole frame, one for each step.
        stance: placement of the standing sole in the world, one for each step.
        cop: centre of pressure in the world [m], shape (M, 3).
        force: force of the ground in world axes [N], shape (M, 3).
    """

    time: Array
    step: np.ndarray[tuple[int], np.dtype[np.intp]]
    q: Array
    joints: Array
    rates: Array
    standing: tuple[str, ...]
    stance: tuple[pin.SE3, ...]
    cop: Array
    force: Array


def walk(gait: Gait, model: pin.Model, steps: int = DEFAULT_STEPS) -> Walk:
    """Let a gait walk: each step is the mirror image of the one before, from where it landed.

    Even steps are the gait as computed. In odd steps the legs have changed roles and the same
    joints take the values E q(t), Eq. (26). The standing sole stays where it landed.

    Args:
        gait: one step.
        model: from `walking_model`.
        steps: how many, at least one.

    Raises:
        InputError: steps < 1.
    """
    if steps < 1:
        raise InputError(f"{shown(steps)} steps cannot be shown; ask for one or more")
    at_most(steps, STEPS, "steps")
    frames = steps * len(gait.time)
    few = FRAMES // len(gait.time)
    at_most(frames, FRAMES, "frames", f"{few} steps of this gait's {len(gait.time)} instants")
    soles = (gait.stance_sole, gait.swing_sole_frame)
    data = model.createData()
    rest = resting(gait, model)
    stance, q = [pin.SE3.Identity()], []
    for step in range(steps):
        standing, swinging = soles[step % 2], soles[(step + 1) % 2]
        for posture in _mirrored(gait.q, gait, step):
            rest[joint_indices(gait, model)] = posture
            q.append(_standing_at(model, data, rest, standing, stance[-1]))
        stance.append(data.oMf[model.getFrameId(swinging)].copy())
    count = len(gait.time)
    return Walk(
        time=np.concatenate([gait.time + k * gait.duration for k in range(steps)]),
        step=np.repeat(np.arange(steps), count),
        q=np.array(q),
        joints=np.concatenate([_mirrored(gait.q, gait, k) for k in range(steps)]),
        rates=np.concatenate([_mirrored(gait.dq, gait, k) for k in range(steps)]),
        standing=tuple(soles[k % 2] for k in range(steps)),
        stance=tuple(stance[:-1]),
        cop=np.concatenate([_cop(gait, k, stance[k]) for k in range(steps)]),
        force=np.concatenate([_force(gait, k, stance[k]) for k in range(steps)]),
    )


def _mirrored(values: Array, gait: Gait, step: int) -> Array:
    """Return joint values (N, n) of a step: as computed, or with the legs exchanged."""
    return values if step % 2 == 0 else values @ gait.mirror.T


def _standing_at(
    model: pin.Model, data: pin.Data, posture: Array, sole: str, place: pin.SE3
) -> Array:
    """Return the configuration with `sole` at `place`; leave its kinematics in `data`.

    The root of `posture` is at the origin.
    """
    q = posture.copy()
    pin.framesForwardKinematics(model, data, q)
    root = place * data.oMf[model.getFrameId(sole)].inverse() * data.oMi[1]
    q[:7] = pin.SE3ToXYZQUAT(root)
    pin.framesForwardKinematics(model, data, q)
    return np.array(q)


def _cop(gait: Gait, step: int, place: pin.SE3) -> Array:
    local = np.column_stack([gait.cop, np.zeros(len(gait.cop))])
    return np.array(_reflected(local, step) @ place.rotation.T + place.translation)


def _force(gait: Gait, step: int, place: pin.SE3) -> Array:
    return np.array(_reflected(gait.ground_wrench[:, :3], step) @ place.rotation.T)


def _reflected(vectors: Array, step: int) -> Array:
    return vectors if step % 2 == 0 else vectors * _REFLECTION
