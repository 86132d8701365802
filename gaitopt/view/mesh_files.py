"""The triangles of STL and OBJ files: what a page shows of a mesh, and nothing else of its file."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np

from gaitopt.nlp import Array

_HEAD, _RECORD = 84, 50  # bytes of a binary STL: before the triangles, and of each
_CORNERS = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.MULTILINE | re.IGNORECASE)


def mesh_triangles(path: str) -> Array | None:
    """Return the triangles of an STL or OBJ file, shape (M, 3, 3): corners in the file's units.

    Args:
        path: of the file.

    Returns:
        None if it is another file, or one that cannot be read here.
    """
    read = {".stl": _stl, ".obj": _obj}.get(Path(path).suffix.lower())
    if read is None:
        return None
    try:
        found = read(Path(path).read_bytes())
    except (OSError, ValueError, IndexError):
        return None
    return found if found.size and bool(np.isfinite(found).all()) else None


def _stl(data: bytes) -> Array:
    """Read an STL file, binary or text: one with "solid" in its head may be either."""
    count = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
    if len(data) >= _HEAD and len(data) >= _HEAD + _RECORD * count and count:
        records = np.frombuffer(data, _CORNERS, count, _HEAD)
        return np.array(records["corners"], dtype=np.float64)
    numbers = [[float(n) for n in corner] for corner in _VERTEX.findall(data)]
    return np.array(numbers, dtype=np.float64).reshape(-1, 3, 3)


def _obj(data: bytes) -> Array:
    """Read an OBJ file; faces of more corners are cut into fans."""
    points: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for line in data.splitlines():
        words = line.split()
        if words[:1] == [b"v"]:
            points.append([float(w) for w in words[1:4]])
        elif words[:1] == [b"f"]:
            ids = [int(w.partition(b"/")[0]) for w in words[1:]]
            ids = [i - 1 if i > 0 else len(points) + i for i in ids]  # negative: from the end
            faces += [(ids[0], a, b) for a, b in pairwise(ids[1:])]
    return np.array(points, dtype=np.float64)[np.array(faces, dtype=np.intp)]
