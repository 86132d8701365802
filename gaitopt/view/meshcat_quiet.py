"""MeshCat without its noise: one of its own imports is deprecated and warns."""

from __future__ import annotations

import warnings
from typing import Any

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import meshcat
    import meshcat.animation as animation
    import meshcat.geometry as geometry
    from meshcat.servers import zmqserver
    from meshcat.visualizer import umsgpack

__all__ = ["animation", "geometry", "meshcat", "pinocchio_visualizer", "umsgpack", "zmqserver"]


def pinocchio_visualizer() -> type[Any]:
    """Return Pinocchio's visualiser; the import, which loads other viewers too, is slow."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from pinocchio.visualize import MeshcatVisualizer
    return MeshcatVisualizer  # type: ignore[no-any-return]
