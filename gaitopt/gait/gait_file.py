"""The gait file: one .npz, readable with `numpy.load` alone."""

from __future__ import annotations

import io
import json
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gaitopt.atomic import write_atomically
from gaitopt.bounds import GAIT, too_large
from gaitopt.errors import GaitFileError, InputError
from gaitopt.gait.result import Gait, array_names

FORMAT = 1  # raised when a reader of the older format would misread the file
_TEXTS = ("urdf", "stance_sole", "swing_sole_frame")
_NAMES = ("parameter_names", "joint_names")
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}
_EPOCH = (1980, 1, 1, 0, 0, 0)  # equal gaits give equal files: no time of writing inside


def save_gait(gait: Gait, path: str | Path) -> Path:
    """Write a gait file, atomically; equal gaits give equal bytes.

    Args:
        gait: what to write.
        path: file name, used as it is; `.npz` is the custom.

    Returns:
        The path written.

    Raises:
        InputError: the path cannot be written.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, array in _members(gait).items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=_EPOCH)
            entry.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(entry, "w") as stream:
                np.lib.format.write_array(stream, array, version=(1, 0), allow_pickle=False)
    return write_atomically(path, buffer.getvalue())


def load_gait(path: str | Path) -> Gait:
    """Read and validate a gait file.

    Raises:
        GaitFileError: the file is missing, truncated, not a gait file, of a newer format, or what
            it holds is not a gait (missing arrays, shapes, NaN, times, E, JSON).
    """
    source = Path(path)
    members = _read(source)
    keys = (*array_names(), *_TEXTS, *_NAMES, "meta")
    missing = [k for k in keys if k not in members and k != "coefficients"]
    if missing:
        raise _bad(source, f"it is not a complete gait file, '{missing[0]}' is missing")
    meta = _meta(source, members.pop("meta"))
    arrays: dict[str, Any] = {n: members[n] for n in array_names() if n in members}
    try:
        return Gait(
            **arrays,
            urdf=str(members["urdf"]),
            stance_sole=str(members["stance_sole"]),
            swing_sole_frame=str(members["swing_sole_frame"]),
            parameter_names=tuple(members["parameter_names"].reshape(-1).tolist()),
            joint_names=tuple(members["joint_names"].reshape(-1).tolist()),
            meta=meta,
        )
    except InputError as error:
        raise _bad(source, str(error)) from error


def _members(gait: Gait) -> dict[str, NDArray[np.generic]]:
    arrays: dict[str, NDArray[np.generic]] = {n: getattr(gait, n) for n in array_names()}
    arrays |= {n: np.array(getattr(gait, n), dtype=np.str_) for n in (*_NAMES, *_TEXTS)}
    meta = {**gait.meta, "format": FORMAT}
    arrays["meta"] = np.array(json.dumps(meta, sort_keys=True, ensure_ascii=False))
    return arrays


def _read(source: Path) -> dict[str, NDArray[Any]]:
    if not source.is_file():
        raise _bad(source, "there is no such file")
    # Damaged archives raise a dozen unrelated exceptions: zip, zlib, header parser, decoder.
    try:
        if large := too_large(source.stat().st_size, GAIT):
            raise ValueError(large)
        with zipfile.ZipFile(source) as archive:
            if large := too_large(sum(entry.file_size for entry in archive.infolist()), GAIT):
                raise ValueError(f"unpacked, {large}")
            return {
                entry.filename.removesuffix(".npy"): _array(archive, entry)
                for entry in archive.infolist()
                if entry.filename.endswith(".npy")
            }
    except zipfile.BadZipFile as error:
        raise _bad(source, "it is truncated, or not a gait file") from error
    except Exception as error:
        raise _bad(source, f"it is damaged, or not a gait file ({error})") from error


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    """Return an array, its header believed only as far as there are bytes for it.

    Raises:
        ValueError: the header promises another size, or objects.
    """
    with archive.open(entry) as stream:
        version = np.lib.format.read_magic(stream)
        if version not in _HEADERS:
            raise ValueError(f"{entry.filename} is of version {version}")
        shape, _, kind = _HEADERS[version](stream)
        if kind.hasobject or math.prod(shape) * kind.itemsize != entry.file_size - stream.tell():
            raise ValueError(f"{entry.filename} holds no array of the size in its header")
        stream.seek(0)
        array: NDArray[Any] = np.lib.format.read_array(stream, allow_pickle=False)
    return array


def _meta(source: Path, text: NDArray[np.generic]) -> dict[str, object]:
    try:
        meta = json.loads(str(text))
    except (ValueError, RecursionError) as error:
        raise _bad(source, "its 'meta' is not JSON") from error
    if not isinstance(meta, dict):
        raise _bad(source, "its 'meta' is not a JSON object")
    version = meta.pop("format", FORMAT)
    if version != FORMAT:
        raise _bad(
            source, f"its format is {version}, this gaitopt reads {FORMAT}; install a newer gaitopt"
        )
    return meta


def _bad(source: Path, reason: str) -> GaitFileError:
    return GaitFileError(
        f"cannot read the gait file '{source}': {reason}; give one that gaitopt optimise "
        "--output wrote (in Python, save_gait)"
    )
