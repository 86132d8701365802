"""A headless Chromium that a test speaks to over its DevTools socket."""

import asyncio
import contextlib
import json
import shutil
import subprocess
import time
import urllib.request
from pathlib import Path

from tornado.websocket import websocket_connect

BROWSER = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--window-size=1200,800", "--remote-debugging-port=0", "--remote-allow-origins=*",
)  # fmt: skip
PATIENCE = 300.0


async def close(socket):
    """Close a connection from here, and wait for its end."""
    socket.close()
    while await socket.read_message() is not None:
        pass


class Page:
    """A page of the browser."""

    def __init__(self, socket):
        self._socket, self._count = socket, 0

    async def call(self, method, **params):
        """The result of a DevTools method."""
        self._count += 1
        request = {"id": self._count, "method": method, "params": params}
        await self._socket.write_message(json.dumps(request))
        while True:
            answer = json.loads(await asyncio.wait_for(self._socket.read_message(), PATIENCE))
            if answer.get("id") == self._count:
                return answer["result"]

    async def value(self, expression):
        """The value of a script, awaited if it is a promise."""
        result = await self.call(
            "Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True
        )
        assert "exceptionDetails" not in result, result
        return result["result"].get("value")

    async def wait_for(self, expression, patience=PATIENCE):
        """The value of a script as soon as it is true."""
        ends = time.monotonic() + patience
        while time.monotonic() < ends:
            found = await self.value(expression)
            if found:
                return found
            await asyncio.sleep(0.02)
        raise AssertionError(f"never true: {expression}")


@contextlib.asynccontextmanager
async def opened(url: str, folder: Path):
    """A browser with a page."""
    command = [BROWSER, *FLAGS, f"--user-data-dir={folder / 'profile'}", url]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        port = folder / "profile" / "DevToolsActivePort"
        ends = time.monotonic() + PATIENCE
        while not (port.exists() and port.read_text().strip()):
            assert time.monotonic() < ends, "the browser did not start"
            await asyncio.sleep(0.05)
        number = port.read_text().split()[0]
        pages = []
        while not pages:
            with contextlib.suppress(OSError):
                text = urllib.request.urlopen(f"http://127.0.0.1:{number}/json", timeout=300).read()
                pages = [one for one in json.loads(text) if one["type"] == "page"]
        socket = await websocket_connect(pages[0]["webSocketDebuggerUrl"], max_message_size=1 << 28)
        yield Page(socket)
        await close(socket)
    finally:
        process.terminate()
        process.wait(300)
