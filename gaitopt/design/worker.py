"""What a process that works for another one does first."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from contextlib import suppress


def serve_parent() -> None:
    """Leave Ctrl-C and its like to the parent process, and end when it ends, however that happens.

    A worker that waits for work would not notice: it holds an end of the pipe itself.
    """
    leave_ctrl_c()
    for name in ("SIGTERM", "SIGHUP"):  # sent to all processes of a service or a terminal
        if hasattr(signal, name):
            with suppress(ValueError):
                signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def leave_ctrl_c() -> None:
    """Do not take Ctrl-C, which a terminal sends to all processes of a command."""
    with suppress(ValueError):  # not the main thread: then it would not get the signal either
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
