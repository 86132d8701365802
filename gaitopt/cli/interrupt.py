"""Ctrl-C while a solver runs: the first asks it to stop, the second ends the program.

SIGTERM, which asks a process to end, and SIGHUP, which tells that its terminal is gone, are
answered as Ctrl-C is.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import FrameType
from typing import NoReturn

from gaitopt.cli.failures import ExitCode

STOPPING = "stopping; press Ctrl-C again to quit at once"
QUIT = "error: interrupted before there was a result; nothing was written"

_LIKE_CTRL_C = ("SIGTERM", "SIGHUP")  # the second is not on every system


@dataclass
class StopRequest:
    """Whether Ctrl-C was pressed; called, it says so, as the `stop` of a search."""

    asked: bool = False

    def __call__(self) -> bool:
        """Return whether the search shall end."""
        return self.asked


def take_signals() -> None:
    """Answer SIGTERM and SIGHUP as Ctrl-C is answered at the time; one that is ignored stays so."""
    for name in _LIKE_CTRL_C:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _as_ctrl_c)


def _as_ctrl_c(number: int, frame: FrameType | None) -> None:
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler):  # Ctrl-C is ignored, as in a process that a script started by "&"
        raise KeyboardInterrupt
    handler(number, frame)


@contextmanager
def ctrl_c_asks(*, told: bool = True) -> Iterator[StopRequest]:
    """Note the first Ctrl-C inside the block instead of raising; the second ends the program.

    The solver stops between two iterations, so that its best iterate is complete.

    Args:
        told: whether to say on stderr, at once, that the first was heard.
    """
    request = StopRequest()

    def note(number: int, frame: FrameType | None) -> None:
        del number, frame
        if request.asked:
            _quit()
        request.asked = True
        if told:
            _tell(STOPPING)

    with _answered_by(note):
        yield request


@contextmanager
def _answered_by(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread receives signals
        return
    before = signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _quit() -> NoReturn:
    _tell(QUIT)
    raise SystemExit(int(ExitCode.INTERRUPTED))


def _tell(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)  # noqa: T201
    except RuntimeError:  # the signal came amid another print
        with suppress(OSError):
            os.write(2, f"{text}\n".encode())
