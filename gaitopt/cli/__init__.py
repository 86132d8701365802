"""The command line: `gaitopt optimise | inspect | check | play | ...`.

Here are its first step and its last: signals before a command has begun and after its end, when
nothing is left to be stopped.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
from collections.abc import Iterable
from types import FrameType

BAD_INPUT, INTERRUPTED = 2, 130
LIKE_CTRL_C = ("SIGTERM", "SIGHUP")  # the second is not on every system
_ALL = ("SIGINT", *LIKE_CTRL_C)
_EARLY = b"error: interrupted before it had begun; nothing was written\n"
_OBJECTS = 300_000
"""New objects before cycles among them are looked for. Imports make a hundred thousand that stay:
at Python's 700, looking for cycles takes a sixteenth of their time, at 50000 still 14 ms
(measured)."""


def main() -> None:
    """Run the command line; the process ends with an exit code of `gaitopt.cli.process`.

    A signal ends it at once as long as it imports: half a second of that has nothing to keep. At
    the very end, when Python takes itself down, all are ignored: the exit code is that of the
    command.
    """
    # the first that is registered is the last that runs
    atexit.register(answer_signals, signal.SIG_IGN, _ALL)
    answer_signals(_quit, _ALL)
    gc.set_threshold(_OBJECTS)  # a walk makes few cycles, and classes of modules stay
    atexit.register(gc.freeze)  # as at the end: 7 % of a command went into that (measured)
    try:
        from gaitopt.cli.app import run
    except ModuleNotFoundError as error:
        from gaitopt.errors import missing_package

        if not (said := missing_package(error)):
            raise
        os.write(2, f"error: {said}\n".encode())
        raise SystemExit(BAD_INPUT) from error
    run()


def leave_with(code: int) -> None:
    """Let a signal end the process with the code of a command that is done.

    Args:
        code: of the command; its output must be flushed.
    """
    answer_signals(lambda *_: os._exit(code), _ALL)
    # Python keeps in mind that an interrupt left code it had as a text, as `dataclass` makes of
    # imports, and at its end kills itself by SIGINT; the next such code makes it forget.
    exec("")


def answer_signals(handler: object, names: Iterable[str]) -> None:
    """Have signals of these names answered by a handler; one that is ignored stays so."""
    for name in names:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)  # type: ignore[arg-type]


def _quit(number: int, frame: FrameType | None) -> None:
    del number, frame
    os.write(2, _EARLY)
    os._exit(INTERRUPTED)


__all__ = ["main"]
