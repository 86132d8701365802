"""MeshCat's viewer without its noise over HTTP, to one address only.

MeshCat's own server is another process, which outlives this one if this one is killed, and it
listens on all interfaces whatever address it prints. Its viewer, which is JavaScript, needs little:
its files, and the drawing commands on a web socket.

`play` shows the walking robot on it.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import socket
import threading
import warnings
import webbrowser
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.web import Application, RequestHandler, StaticFileHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from gaitopt.bounds import shown
from gaitopt.errors import InputError, missing_package, reason_of
from gaitopt.gait.result import Gait
from gaitopt.gait.transition import Transition
from gaitopt.settings import checked_arguments
from gaitopt.view.animation import DEFAULT_STEPS, build_scene
from gaitopt.view.viewer import (
    Node,
    packed_commands,
    packed_viewer,
    page_file,
    umsgpack,
    viewer_root,
)

LOCAL = "127.0.0.1"
FIRST_PORT, PORTS = 7000, 1000  # tried in turn, where none is asked for
_LARGEST_PORT = 65535
_PATIENCE = 10.0  # s for the thread to begin or end

_SCENE = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>MeshCat</title>
<style>body { margin: 0; } #pane { width: 100vw; height: 100vh; overflow: hidden; }</style></head>
<body><div id="pane"></div><script>%s
openScene(document.getElementById("pane"), "%s", "%s");</script></body></html>
"""


class SceneServer:
    """Stands in for MeshCat's window: keeps a scene and shows it to every browser that asks.

    Attributes:
        web_url: address of the page.
        host, port: where it listens.
    """

    def __init__(self, host: str = LOCAL, port: int | None = None) -> None:
        """Begin to serve an empty scene.

        Args:
            host: address or name of the interface to listen on.
            port: 0 for any that is free; None for the first free one from 7000 on.

        Raises:
            InputError: it cannot listen there.
        """
        listening = listening_socket(host, port)
        self.host, self.port = host, int(listening.getsockname()[1])
        self.web_url = f"{url_of(listening, host)}static/"
        self._commands: dict[tuple[str, ...], bytes] = {}
        self._viewers: set[_Socket] = set()
        self._lock = threading.Lock()
        self._ready, self._loop = threading.Event(), asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, args=(listening,), daemon=True)
        self._thread.start()
        self._ready.wait(_PATIENCE)

    def send(self, command: Any) -> None:
        """Take a drawing command of MeshCat's and hand it to the browsers."""
        record = command.lower()
        packed = umsgpack.packb(record)
        with self._lock:
            _keep(self._commands, record, packed)
        with contextlib.suppress(RuntimeError):  # the server was stopped
            self._loop.call_soon_threadsafe(self._forward, packed)

    def get_scene(self) -> str:
        """Return a page that shows the scene as it is, complete in itself."""
        return _SCENE % (page_file("load.js"), packed_viewer(), packed_commands(self.scene()))

    def scene(self) -> list[bytes]:
        """Return the commands that make the scene."""
        with self._lock:
            return list(self._commands.values())

    def open(self) -> None:
        """Open the page in a browser."""
        webbrowser.open(self.web_url, new=2)

    def close(self) -> None:
        """Stop; more than once does no harm."""
        if self._thread.is_alive():
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(_PATIENCE)

    @property
    def closed(self) -> bool:
        """Whether it has stopped."""
        return not self._thread.is_alive()

    def _run(self, listening: socket.socket) -> None:
        asyncio.set_event_loop(self._loop)
        files = {"path": str(viewer_root()), "default_filename": "index.html"}
        socket_of = {"server": self, "viewers": self._viewers}
        served = begin_serving(
            listening, self.host, [(r"/static/(.*)", _Files, files), (r"/", _Socket, socket_of)]
        )
        self._loop.call_soon(self._ready.set)
        try:
            self._loop.run_forever()
            served.stop()
            self._loop.run_until_complete(served.close_all_connections())
            for task in asyncio.all_tasks(self._loop):
                task.cancel()
            self._loop.run_until_complete(asyncio.sleep(0.0))
        finally:
            self._loop.close()

    def _forward(self, packed: bytes) -> None:
        for viewer in list(self._viewers):
            viewer.show(packed)


class _Files(StaticFileHandler):
    """The viewer's files, never from a browser's cache: a new version has the same names."""

    def set_extra_headers(self, path: str) -> None:
        """Forbid caching."""
        del path
        self.set_header("Cache-Control", "no-store")


class _Socket(WebSocketHandler):
    """The connection to one browser."""

    def initialize(self, server: SceneServer, viewers: set[_Socket]) -> None:
        """Take what the application hands over."""
        self._server, self._viewers = server, viewers

    def open(self, *_: str, **__: str) -> None:
        """Show the scene to a browser that has come."""
        self._viewers.add(self)
        for packed in self._server.scene():
            self.show(packed)

    def on_message(self, message: str | bytes) -> None:
        """Pass over what a browser says; nothing was asked."""

    def on_close(self) -> None:
        """Forget a browser that has gone."""
        self._viewers.discard(self)

    def show(self, packed: bytes) -> None:
        """Send a command."""
        with contextlib.suppress(WebSocketClosedError):
            self.write_message(packed, binary=True)


def _keep(kept: dict[tuple[str, ...], bytes], record: Mapping[str, Any], packed: bytes) -> None:
    """Keep a command until another of its kind about the same thing takes its place."""
    kind, path = str(record["type"]), str(record.get("path", ""))
    if kind == "delete":
        for key in [k for k in kept if k[1] == path or k[1].startswith(f"{path}/")]:
            del kept[key]
        return
    key = (kind, path, str(record.get("property", "")))
    kept.pop(key, None)
    kept[key] = packed


def listening_socket(host: str, port: int | None) -> socket.socket:
    """Return a socket that listens at an address.

    Raises:
        InputError: there is no such address here, or the port is taken.
    """
    if not host.strip() or not host.isprintable():
        what = shown(host) if host.strip() else "empty"
        raise InputError(f"the host is {what}; give an address of this machine, as {LOCAL}")
    if port is not None and not 0 <= port <= _LARGEST_PORT:
        raise InputError(f"port {shown(port)} does not exist; give 0 for any, or one up to 65535")
    if port is not None:
        return _bound(host, port)
    _bound(host, 0).close()  # an address that is none here is told at once
    for candidate in range(FIRST_PORT, FIRST_PORT + PORTS - 1):
        with contextlib.suppress(InputError):
            return _bound(host, candidate)
    return _bound(host, FIRST_PORT + PORTS - 1)


def _bound(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        bound = socket.create_server((host, port), family=family)
    except (OSError, UnicodeError) as error:
        reason = reason_of(error).partition("(while")[0].strip()
        raise InputError(
            f"the viewer cannot listen at {host}, port {port}: {reason}; give another "
            "--port, 0 for any, or an address of this machine by --host"
        ) from error
    bound.setblocking(False)
    return bound


def url_of(listening: socket.socket, host: str) -> str:
    """Return the address of what is served at a socket that listens at a host."""
    return f"http://{f'[{host}]' if ':' in host else host}:{listening.getsockname()[1]}/"


def begin_serving(
    listening: socket.socket, host: str, handlers: list[Any], **settings: Any
) -> HTTPServer:
    """Serve Tornado's handlers at a socket, on the loop that runs, and say nothing of requests."""
    application = Application(log_function=lambda _: None, **settings)
    application.add_handlers(hosts_of(host), [*handlers, (r"/favicon.ico", _NoIcon)])
    served = HTTPServer(application)
    served.add_socket(listening)
    return served


class _NoIcon(RequestHandler):
    """Answers browsers, which ask for a picture of the page on their tab, that there is none."""

    def get(self) -> None:
        """Say so; "not found" would stand as an error in the browser's console."""
        self.set_status(204)


def is_local(host: str) -> bool:
    """Whether only this machine can reach an address."""
    return host in ("localhost", "::1") or host.startswith("127.")


def hosts_of(host: str) -> str:
    """Return the pattern of names under which a server that listens there may be asked for.

    One that only this machine can reach has no other names: a page of another site that lets its
    own name mean this machine would pass for one of the server's own.
    """
    return rf"localhost|127\.[\d.]+|\[?::1\]?|{re.escape(host)}" if is_local(host) else ".*"


class Player:
    """A server of MeshCat's viewer showing a walk; a context manager that stops it at its end.

    MeshCat's panel has play, pause, the time and `timeScale` for slow motion.

    Attributes:
        viewer: the MeshCat viewer, for adding to the scene.
        server: the server that it draws on.
        url: address of the page.
        note: what of the robot is missing in the scene and how to get it, or empty.

    Raises:
        InputError: MeshCat, or a package that it needs, is not installed.
    """

    def __init__(self, server: SceneServer) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                import meshcat  # with IPython and more, which no other server needs
            except ModuleNotFoundError as error:
                server.close()
                raise InputError(missing_package(error)) from error

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


@checked_arguments
def play(
    gait: Gait | Transition,
    steps: int = DEFAULT_STEPS,
    *,
    open_browser: bool = True,
    package_dirs: tuple[str | Path, ...] = (),
    host: str = LOCAL,
    port: int | None = None,
) -> Player:
    """Serve a page with the robot walking, over and over, from this process.

    Args:
        steps: how many before the film starts again.
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
        scene = build_scene(
            Node(player.server), gait, steps, tuple(map(str, package_dirs)), whole=True
        )
        player.note = scene.shapes.note
    except BaseException:
        player.close()
        raise
    if open_browser:
        webbrowser.open(player.url, new=2)
    return player
