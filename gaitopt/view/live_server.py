"""The page of `gaitopt live`: served to this machine, with sliders that a session answers.

One thread serves, another one works. Of settings that come while it works only the latest count.
The browser sends `{"number": n, "tab": name, "settings": {...}}` or `{"save": true}`; what goes
back, to all tabs, is what a session says, with the number and tab that it answers and the settings.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any, Protocol

from tornado.web import RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from gaitopt.dataclass import dataclass
from gaitopt.errors import GaitoptError
from gaitopt.view.scene_server import LOCAL, begin_serving, listening_socket, url_of
from gaitopt.view.viewer import data_text

LONELY = 3.0  # s without a page before the server ends, once there was one
SWITCH = 5e-4  # s
SENDING = 0.1  # s that an answer may wait to be sent
LARGEST = 65_536  # bytes of a message
MOST = 1e9  # of a value in it
Message = dict[str, Any]


@dataclass(frozen=True)
class Slider:
    """A setting that the page changes.

    Attributes:
        name: of the setting.
        words: what it is, for people.
        unit: of its value.
        low, high, step: of the slider.
        value: at the beginning.
    """

    name: str
    words: str
    unit: str
    low: float
    high: float
    step: float
    value: float


class Session(Protocol):
    """What answers a page."""

    sliders: tuple[Slider, ...]

    def page(self) -> str:
        """Return the text of the page, which shows the first walk."""

    def answers(self, settings: Mapping[str, float], stop: Callable[[], bool]) -> Iterator[Message]:
        """Yield what a page is told about settings, the most urgent first.

        Args:
            stop: says True as soon as other settings are wanted: what follows is of no use then.
        """

    def save(self) -> Message:
        """Keep the last certified walk, and say where."""


def serve(
    session: Session,
    host: str = LOCAL,
    port: int | None = None,
    *,
    on_ready: Callable[[str], None],
    stay: bool = False,
) -> None:
    """Serve a session until Ctrl-C, SIGTERM, or until its page is closed.

    Args:
        host, port: where to listen; see `SceneServer`.
        on_ready: told the address.
        stay: whether to go on when the page is closed.

    Raises:
        InputError: it cannot listen there.
        Exception: what went wrong in the session, where that is no `GaitoptError`.
    """
    listening = listening_socket(host, port)
    with _switching(SWITCH):
        asyncio.run(_serve(session, listening, host, on_ready, stay))


@contextlib.contextmanager
def _switching(interval: float) -> Iterator[None]:
    """Let another thread go on after an interval [s]."""
    # After 5 ms, as usual, the thread that serves would wait for the one that works at every read
    # and write, four times for a move.
    before = sys.getswitchinterval()
    sys.setswitchinterval(interval)
    try:
        yield
    finally:
        sys.setswitchinterval(before)


async def _serve(
    session: Session,
    listening: Any,
    host: str,
    on_ready: Callable[[str], None],
    stay: bool,
) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError, ValueError):  # not the main thread
            loop.add_signal_handler(number, ended.set)
    desk = _Desk(session, loop, ended.set)
    handlers = [(r"/", _Page, {"session": session}), (r"/socket", _Socket, {"desk": desk})]
    served = begin_serving(listening, host, handlers, websocket_max_message_size=LARGEST)
    desk.start()
    on_ready(url_of(listening, host))
    try:
        while not ended.is_set():
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(ended.wait(), 0.25)
            if not stay and desk.alone_for() > LONELY:
                ended.set()
    finally:
        desk.end()
        served.stop()
        await served.close_all_connections()
    if desk.fault is not None:
        raise desk.fault


class _Desk:
    """Hands wishes of the pages to the thread that works, and its answers to the pages."""

    # What goes wrong in that thread, and is no refusal, ends the server: a page would else wait for
    # ever.

    def __init__(
        self, session: Session, loop: asyncio.AbstractEventLoop, end: Callable[[], None]
    ) -> None:
        self.fault: Exception | None = None
        self._end = end
        self._lonely_since: float | None = None
        self._session, self._loop = session, loop
        self._pages: set[_Socket] = set()
        self._wish: Message | None = None
        self._save, self._over = False, False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def end(self) -> None:
        with self._changed:
            self._over = True
            self._changed.notify()
        self._thread.join(10.0)

    def come(self, page: _Socket) -> None:
        self._pages.add(page)
        self._lonely_since = None

    def gone(self, page: _Socket) -> None:
        self._pages.discard(page)
        if not self._pages:
            self._lonely_since = time.monotonic()

    def alone_for(self) -> float:
        """Return for how long there has been no page any more [s]; 0 before the first."""
        since = self._lonely_since
        return 0.0 if since is None else time.monotonic() - since

    def wish(self, message: Message) -> None:
        with self._changed:
            if message.get("save") is True:
                self._save = True
            else:
                self._wish = message
            self._changed.notify()

    def _outdated(self) -> bool:
        return self._over or self._wish is not None

    def _run(self) -> None:
        try:
            self._work()
        except Exception as error:
            self.fault = error
            with contextlib.suppress(RuntimeError):  # the server has ended
                self._loop.call_soon_threadsafe(self._end)

    def _work(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._over or self._save or self._wish is not None)
                if self._over:
                    return
                wish, save = self._wish, self._save
                self._wish, self._save = None, False
            if save:
                self._say(self._answered(self._session.save))
            if wish is not None:
                self._answer(wish)

    def _answer(self, wish: Message) -> None:
        settings = self._settings(wish)
        asked = {"number": wish.get("number"), "tab": wish.get("tab"), "settings": settings}
        try:
            for message in self._session.answers(settings, self._outdated):
                self._say({**asked, **message})
        except GaitoptError as error:
            self._say({**asked, "kind": "none", "text": str(error)})

    @staticmethod
    def _answered(what: Callable[[], Message]) -> Message:
        try:
            return what()
        except GaitoptError as error:
            return {"kind": "saved", "text": str(error)}

    def _settings(self, wish: Message) -> dict[str, float]:
        """Return the value of each slider, within its range whatever was sent."""
        asked = wish.get("settings")
        asked = asked if isinstance(asked, dict) else {}
        found = {}
        for one in self._session.sliders:
            value = asked.get(one.name)
            kept = one.value
            if (isinstance(value, float) or type(value) is int) and -MOST < value < MOST:
                kept = float(value)
            found[one.name] = min(max(kept, one.low), one.high)
        return found

    def _say(self, message: Message) -> None:
        text, sent = data_text(message), threading.Event()
        with contextlib.suppress(RuntimeError):  # the server has ended
            self._loop.call_soon_threadsafe(self._send, text, sent)
            sent.wait(SENDING)  # work that goes on at once would keep the other thread from it

    def _send(self, text: str, sent: threading.Event) -> None:
        for page in list(self._pages):
            page.show(text)
        sent.set()


class _Page(RequestHandler):
    """The page."""

    def initialize(self, session: Session) -> None:
        self._session = session

    def get(self) -> None:
        """Send it."""
        self.set_header("Cache-Control", "no-store")
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.write(self._session.page())


class _Socket(WebSocketHandler):
    """The connection to one page; pages of other sites are refused by their origin."""

    def initialize(self, desk: _Desk) -> None:
        self._desk = desk

    def open(self, *_: str, **__: str) -> None:
        """Take in a page that has come."""
        self.set_nodelay(True)
        self._desk.come(self)

    def on_message(self, message: str | bytes) -> None:
        """Pass on what a page wishes; what is no wish is passed over."""
        with contextlib.suppress(ValueError, RecursionError):
            wish = json.loads(message)
            if isinstance(wish, dict):
                self._desk.wish(wish)

    def on_close(self) -> None:
        """Forget a page that has gone."""
        self._desk.gone(self)

    def show(self, text: str) -> None:
        """Send an answer."""
        with contextlib.suppress(WebSocketClosedError):
            self.write_message(text)
