"""MeshCat without its noise: one of its own imports is deprecated and warns."""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import meshcat
    import meshcat.animation as animation
    import meshcat.geometry as geometry
    from meshcat.servers import zmqserver
    from meshcat.visualizer import umsgpack
    from pinocchio.visualize import MeshcatVisualizer

__all__ = ["MeshcatVisualizer", "animation", "geometry", "meshcat", "umsgpack", "zmqserver"]
