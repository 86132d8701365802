"""Small mesh files, written by hand."""

import struct
from pathlib import Path

import numpy as np

TETRAHEDRON = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.1]])
_FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]


def write_stl(path: Path, vertices: np.ndarray = TETRAHEDRON) -> Path:
    """Write a tetrahedron as a binary STL file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    triangles = [struct.pack("<12fH", 0, 0, 0, *vertices[list(f)].ravel(), 0) for f in _FACES]
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(_FACES)) + b"".join(triangles))
    return path


def sorted_rows(points: np.ndarray) -> np.ndarray:
    """The rows without repetition, in one order."""
    return np.unique(np.round(points, 6), axis=0)
