"""Files of gaits and transitions whose members are changed, and what the document says of them."""

import hashlib
import json
import re
import zipfile

import numpy as np
from places import DOCS

DOCUMENT = DOCS / "gait-file.md"


def written(path, members, seal):
    """A file with these members, and with digests that are theirs if it is sealed."""
    np.savez(path, **members)
    if seal and "digest" in members:
        with zipfile.ZipFile(path) as archive:
            digest = {
                n.removesuffix(".npy"): hashlib.sha256(archive.read(n)).hexdigest()
                for n in archive.namelist()
                if n != "digest.npy"
            }
        np.savez(path, **{**members, "digest": np.array(json.dumps(digest))})
    return path


def changed(name, array):
    """The array with another value in it, of the same kind and shape where that has any."""
    array = np.array(array)
    if name == "urdf":
        return np.array(str(array).replace('mass value="1', 'mass value="2', 1))
    if array.dtype.kind == "U":
        flat = array.reshape(-1).astype(object)
        flat[0] = flat[0].replace("1", "2", 1) if "1" in flat[0] else flat[0] + "x"
        return flat.astype(str).reshape(array.shape)
    if array.dtype.kind == "b":
        return ~array
    largest = np.unravel_index(np.abs(array).argmax(), array.shape)
    array[largest] = array[largest] + 1 if array.dtype.kind == "i" else array[largest] * 1.001 + 1.0
    return array


def documented():
    """Rows of the table of arrays: name, kind, shape, unit, frame."""
    rows = re.findall(r"^\| `(\w+)` \|(.*)\|$", DOCUMENT.read_text(), flags=re.MULTILINE)
    cells = [(name, *(cell.strip() for cell in rest.split("|"))) for name, rest in rows]
    return [row for row in cells if len(row) == 6]


def holds_what_is_documented(content, rows):
    """The sizes of arrays whose kinds and shapes are those of rows of the document."""
    sizes = {}
    for name, kind, shape, *_ in rows:
        array = content[name]
        assert array.dtype.kind == {"str": "U"}.get(kind, np.dtype(kind).kind), name
        assert array.dtype.byteorder in "<=|", name
        assert array.flags.c_contiguous
        letters = [] if shape == "scalar" else shape.split(" × ")
        assert array.ndim == len(letters), name
        for letter, found in zip(letters, array.shape, strict=True):
            base, _, more = letter.partition(" + ")
            wanted = int(base) if base.isdigit() else sizes.setdefault(base, found)
            assert found == wanted + int(more or 0), name
    return sizes
