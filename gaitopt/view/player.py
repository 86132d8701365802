"""A live MeshCat window with the walking robot."""

from __future__ import annotations

import contextlib
import io
import threading
import webbrowser
from types import TracebackType

from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.view.meshcat_quiet import meshcat
from gaitopt.view.scene import build_scene
from gaitopt.view.walk import DEFAULT_STEPS


class Player:
    """A MeshCat server showing a walk; a context manager that stops the server at its end.

    MeshCat's panel has play, pause, the time and `timeScale` for slow motion.

    Attributes:
        viewer: the MeshCat viewer, for adding to the scene.
        url: address of the page.
        note: what of the robot is missing in the scene and how to get it, or empty.
    """

    def __init__(self, viewer: meshcat.Visualizer) -> None:
        self.viewer = viewer
        self.url = str(viewer.url())
        self.note = ""
        self._closed = threading.Event()

    def wait(self) -> None:
        """Keep the page alive until the player is closed, or Ctrl-C."""
        with contextlib.suppress(KeyboardInterrupt):
            self._closed.wait()
        self.close()

    def close(self) -> None:
        """Stop the server; more than once does no harm."""
        if self._closed.is_set():
            return
        self._closed.set()
        self.viewer.window.zmq_socket.close(linger=0)
        server = self.viewer.window.server_proc
        server.terminate()
        server.wait()
        for pipe in (server.stdout, server.stderr):
            pipe.close()

    def __enter__(self) -> Player:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def play(
    gait: Gait,
    steps: int = DEFAULT_STEPS,
    *,
    open_browser: bool = True,
    package_dirs: tuple[str, ...] = (),
) -> Player:
    """Start a MeshCat server on this machine with the robot walking, over and over.

    Args:
        gait: one step.
        steps: how many before the film starts again.
        open_browser: whether to open the page.
        package_dirs: where to look for meshes.

    Returns:
        The running player; close it, or use it in a `with` block.

    Raises:
        InputError: steps < 1, or the server does not start.
        RobotError: the robot cannot be drawn.
    """
    player = _start()
    try:
        player.note = build_scene(player.viewer, gait, steps, package_dirs).note
    except BaseException:
        player.close()
        raise
    if open_browser:
        webbrowser.open(player.url, new=2)
    return player


def _start() -> Player:
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # MeshCat prints its address
            return Player(meshcat.Visualizer())
    except (RuntimeError, OSError) as error:
        raise InputError(
            f"the MeshCat server does not start: {error}; write a page with 'write_page' instead"
        ) from error
