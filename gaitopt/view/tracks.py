"""Animation tracks: how a thing in the scene moves, keyed by seconds."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from gaitopt.nlp import Array
from gaitopt.view.meshcat_quiet import animation, meshcat


class Film:
    """Collects the motion of the nodes of a scene."""

    def __init__(self) -> None:
        # one frame is one second, so that key times are times
        self._animation = animation.Animation(default_framerate=1)

    def place(self, node: meshcat.Visualizer, times: Array, positions: Array) -> None:
        """Move a node through positions (M, 3) [m] at times (M,) [s]."""
        self._key(node, "position", "vector3", times, positions)

    def turn(self, node: meshcat.Visualizer, times: Array, rotations: list[Array]) -> None:
        """Turn a node through rotation matrices, M of (3, 3)."""
        quaternions = np.array([pin.Quaternion(r).coeffs() for r in rotations])
        self._key(node, "quaternion", "quaternion", times, quaternions)

    def stretch(self, node: meshcat.Visualizer, times: Array, scales: Array) -> None:
        """Scale a node by factors (M, 3) along its axes."""
        self._key(node, "scale", "vector3", times, scales)

    def show(self, viewer: meshcat.Visualizer, repetitions: int = 1_000_000) -> None:
        """Hand the motion to the viewer, which plays it over and over."""
        viewer.set_animation(self._animation, play=True, repetitions=repetitions)

    def _key(
        self, node: meshcat.Visualizer, prop: str, kind: str, times: Array, values: Array
    ) -> None:
        clip = self._animation.clips.setdefault(node.path, animation.AnimationClip(fps=1))
        clip.tracks[prop] = animation.AnimationTrack(prop, kind, times.tolist(), values.tolist())
