"""Signals before a command has begun and after its end, when nothing is left to be stopped."""

from __future__ import annotations

import atexit
import os
import signal
from types import FrameType

INTERRUPTED = 130
LIKE_CTRL_C = ("SIGTERM", "SIGHUP")  # the second is not on every system
_EARLY = b"error: interrupted before it had begun; nothing was written\n"


def quit_on_signals() -> None:
    """End the process at once at a signal: half a second of imports has nothing to keep.

    One that is ignored stays so. At the very end, when Python takes itself down, all are ignored:
    the exit code is that of the command.
    """
    atexit.register(_set, signal.SIG_IGN)  # the first that is registered is the last that runs
    _set(_quit)


def leave_with(code: int) -> None:
    """Let a signal end the process with the code of a command that is done.

    Args:
        code: of the command; its output must be flushed.
    """
    _set(lambda *_: os._exit(code))
    # Python keeps in mind that an interrupt left code it had as a text, as `dataclass` makes of
    # imports, and at its end kills itself by SIGINT; the next such code makes it forget.
    exec("")


def _quit(number: int, frame: FrameType | None) -> None:
    del number, frame
    os.write(2, _EARLY)
    os._exit(INTERRUPTED)


def _set(handler: object) -> None:
    for name in ("SIGINT", *LIKE_CTRL_C):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)  # type: ignore[arg-type]
