"""A live MeshCat window with the walking robot."""

from __future__ import annotations

import contextlib
import threading
import warnings
import webbrowser
from types import TracebackType

from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition
from gaitopt.view.animation import DEFAULT_STEPS, build_scene
from gaitopt.view.scene_server import LOCAL, SceneServer
from gaitopt.view.viewer import Node

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import meshcat


class Player:
    """A server of MeshCat's viewer showing a walk; a context manager that stops it at its end.

    MeshCat's panel has play, pause, the time and `timeScale` for slow motion.

    Attributes:
        viewer: the MeshCat viewer, for adding to the scene.
        server: the server that it draws on.
        url: address of the page.
        note: what of the robot is missing in the scene and how to get it, or empty.
    """

    def __init__(self, server: SceneServer) -> None:
        self.server = server
        self.viewer = meshcat.Visualizer(window=server)
        self.url = server.web_url
        self.note = ""
        self._closed = threading.Event()

    def wait(self) -> None:
        """Keep the page alive until the player is closed, or Ctrl-C."""
        with contextlib.suppress(KeyboardInterrupt):
            self._closed.wait()
        self.close()

    def close(self) -> None:
        """Stop the server; more than once does no harm."""
        self._closed.set()
        self.server.close()

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
    gait: Gait | Transition,
    steps: int = DEFAULT_STEPS,
    *,
    open_browser: bool = True,
    package_dirs: tuple[str, ...] = (),
    host: str = LOCAL,
    port: int | None = None,
) -> Player:
    """Serve a page with the robot walking, over and over, from this process.

    Args:
        gait: one step, or a transition.
        steps: how many before the film starts again.
        open_browser: whether to open the page.
        package_dirs: where to look for meshes.
        host: address to listen on; by default only this machine can reach it.
        port: 0 for any that is free; by default the first free one from 7000 on.

    Returns:
        The running player; close it, or use it in a `with` block.

    Raises:
        InputError: steps < 1, or it cannot listen there.
        RobotError: the robot cannot be drawn.
    """
    player = Player(SceneServer(host, port))
    try:
        scene = build_scene(Node(player.server), gait, steps, package_dirs, whole=True)
        player.note = scene.shapes.note
    except BaseException:
        player.close()
        raise
    if open_browser:
        webbrowser.open(player.url, new=2)
    return player
