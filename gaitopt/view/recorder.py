"""Drawing commands for a page, kept instead of sent to a window."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable
from pathlib import Path

from gaitopt.errors import InputError
from gaitopt.view.meshcat_quiet import umsgpack, zmqserver


class Recorder:
    """Stands in for MeshCat's window: keeps the drawing commands instead of sending them."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []

    def send(self, command: object) -> None:
        """Keep one command, packed as the viewer reads it."""
        self.commands.append(umsgpack.packb(command.lower()))  # type: ignore[attr-defined]

    def text(self) -> str:
        """Return the commands as JSON, for `MeshCat.Viewer.handle_command_bytearray`."""
        return encoded(self.commands)

    def get_image(self) -> None:
        """Do nothing: there is no picture before a browser opens the page."""


def encoded(commands: Iterable[bytes]) -> str:
    """Return packed commands as JSON, for `MeshCat.Viewer.handle_command_bytearray`."""
    return json.dumps([base64.b64encode(c).decode("ascii") for c in commands])


def viewer_script() -> str:
    """Return MeshCat's viewer, which the MeshCat package carries.

    Raises:
        InputError: the package lacks it.
    """
    source = Path(zmqserver.VIEWER_ROOT) / "main.min.js"
    try:
        return source.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            "the installed meshcat package lacks its viewer; run: pip install --force-reinstall "
            "'meshcat>=0.3.2'"
        ) from error
