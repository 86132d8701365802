"""Ctrl-C while a solver runs: the first asks it to stop, the second ends the program."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType


@dataclass
class StopRequest:
    """Whether Ctrl-C was pressed."""

    asked: bool = False


@contextmanager
def ctrl_c_asks() -> Iterator[StopRequest]:
    """Note the first Ctrl-C inside the block instead of raising; the second raises as usual.

    The solver stops between two iterations, so that its best iterate is complete.
    """
    request = StopRequest()

    def note(number: int, frame: FrameType | None) -> None:
        if request.asked:
            signal.default_int_handler(number, frame)
        request.asked = True

    if threading.current_thread() is not threading.main_thread():
        yield request  # only the main thread receives signals
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield request
    finally:
        signal.signal(signal.SIGINT, before)
