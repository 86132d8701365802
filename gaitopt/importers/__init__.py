"""Descriptions of robots (URDF, MJCF, meshes), read to the last digit and checked."""
