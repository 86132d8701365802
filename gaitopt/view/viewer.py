"""MeshCat's drawing commands, recorded, and its viewer in a page."""

from __future__ import annotations

import base64
import gzip
import importlib
import json
import sys
import warnings
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.resources import files
from importlib.util import find_spec, module_from_spec
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from gaitopt.errors import InputError
from gaitopt.nlp import Array

_SMALL = 6  # of gzip: 9 takes three times as long for a hundredth less
_SPEC = find_spec("meshcat")


def _parts(names: Sequence[str]) -> list[ModuleType]:
    """Return modules of MeshCat without what the package itself loads.

    That is IPython, ZeroMQ and Pillow, for a server that is not used here: a twentieth of the time
    of `gaitopt optimise` (measured). Whoever imports the package gets it whole.
    """
    if _SPEC is None:
        raise ModuleNotFoundError("No module named 'meshcat'", name="meshcat")
    before = {name: module for name, module in sys.modules.items() if name.startswith("meshcat")}
    sys.modules.setdefault("meshcat", module_from_spec(_SPEC))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return [importlib.import_module(f"meshcat.{name}") for name in names]
    finally:
        for name in [name for name in sys.modules if name.startswith("meshcat")]:
            if name not in before:
                del sys.modules[name]


animation: Any
commands: Any
geometry: Any
animation, commands, geometry = _parts(("animation", "commands", "geometry"))
umsgpack: Any = geometry.umsgpack  # a dependency of MeshCat's


class Window(Protocol):
    """Where drawing commands go."""

    def send(self, command: Any) -> None:
        """Take a command of MeshCat's."""


class Node:
    """A node of a scene in MeshCat's viewer; `node["arm/hand"]` is one below it.

    Args:
        window: where its commands go.
        path: names from the root on.
    """

    def __init__(self, window: Window, path: Any = None) -> None:
        self.window = window
        self.path = commands.Path(("meshcat",)) if path is None else path

    def __getitem__(self, names: str) -> Node:
        return Node(self.window, self.path.append(names))

    def set_object(self, shape: Any, material: Any = None) -> None:
        """Draw a geometry with a material, or an object, in its place."""
        self.window.send(commands.SetObject(shape, material, self.path))

    def set_transform(self, placement: Array) -> None:
        """Place it by a homogeneous matrix (4, 4)."""
        self.window.send(commands.SetTransform(placement, self.path))

    def set_property(self, name: str, value: object) -> None:
        """Change a property, as "visible"."""
        self.window.send(commands.SetProperty(name, value, self.path))

    def set_animation(self, moves: Any, play: bool = True, repetitions: int = 1) -> None:
        """Give the scene an animation."""
        self.window.send(commands.SetAnimation(moves, play=play, repetitions=repetitions))

    def delete(self) -> None:
        """Take it and all below it away."""
        self.window.send(commands.Delete(self.path))


class RecordingWindow:
    """Stands in for MeshCat's window: keeps the drawing commands instead of sending them."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []

    def send(self, command: Any) -> None:
        """Keep one command, packed as the viewer reads it."""
        self.commands.append(umsgpack.packb(command.lower()))

    def text(self) -> str:
        """Return the commands for a page, packed."""
        return packed_commands(self.commands)


def packed_commands(commands: Iterable[bytes]) -> str:
    """Return commands as text of a page, for `shown` of load.js.

    Each is told its length, in four bytes, the lowest first; all are compressed together.
    """
    parts = [part for c in commands for part in (len(c).to_bytes(4, "little"), c)]
    return packed(b"".join(parts))


def packed(data: bytes) -> str:
    """Return data compressed, as text, for `unpacked` of load.js; the same for the same data."""
    return base64.b64encode(gzip.compress(data, compresslevel=_SMALL, mtime=0)).decode("ascii")


def data_text(data: object) -> str:
    """Return data as JSON; arrays in it are base64 of 32-bit floats, for `numbers` of load.js."""
    return json.dumps(data, separators=(",", ":"), default=_floats)


def _floats(values: object) -> str:
    if not isinstance(values, np.ndarray):
        raise TypeError(f"{type(values).__name__} is no data of a page")
    return base64.b64encode(values.astype("<f4").tobytes()).decode("ascii")


def viewer_root() -> Path:
    """Return the directory of the viewer's files in the MeshCat package."""
    assert _SPEC is not None
    assert _SPEC.origin is not None
    return Path(_SPEC.origin).parent / "viewer" / "dist"


@cache
def packed_viewer() -> str:
    """Return MeshCat's viewer, which the MeshCat package carries, packed.

    Raises:
        InputError: the package lacks it.
    """
    try:
        return packed((viewer_root() / "main.min.js").read_bytes())
    except OSError as error:
        raise InputError(
            "the installed meshcat package lacks its viewer; run: pip install --force-reinstall "
            "'meshcat>=0.3.2'"
        ) from error


def page_file(name: str) -> str:
    """Return a file of gaitopt's own that pages are made of."""
    return files("gaitopt.view").joinpath(name).read_text(encoding="utf-8")
