"""The process: one message and one exit code for an error, signals, and its standard streams.

Ctrl-C while a solver runs asks it to stop, the second ends the program; SIGTERM and SIGHUP are
answered as Ctrl-C is. A pipe that was closed, or a terminal that is gone, ends no search half way:
what can no longer be read is dropped. A full disk is an error.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import IntEnum
from types import FrameType
from typing import TextIO

import typer

from gaitopt.cli import BAD_INPUT, INTERRUPTED, LIKE_CTRL_C, answer_signals, leave_with
from gaitopt.errors import (
    GaitoptError,
    IdleOptionError,
    InputError,
    missing_package,
    plugins_told,
    reason_of,
)
from gaitopt.escape import printable
from gaitopt.pinocchio_check import require_pinocchio

_LONGEST = 200  # characters of a file's name in a message


class ExitCode(IntEnum):
    """Exit codes of every command.

    With --no-refine, OK means optimal at the given samples.
    """

    OK = 0
    NOT_CERTIFIED = 1
    BAD_INPUT = BAD_INPUT
    NO_GAIT = 3
    INTERRUPTED = INTERRUPTED


@contextmanager
def errors_reported(*, robots: bool = True) -> Iterator[None]:
    """Turn errors the user can mend into a message on stderr and an exit code; no traceback.

    An unexpected exception is left to Python: it is a bug of gaitopt and its traceback is wanted;
    but one that a plugin raises is told with its line.

    Args:
        robots: whether the block needs Pinocchio, which takes half a second to import.
    """
    try:
        if robots:
            require_pinocchio()
        with plugins_told():
            yield
        sys.stdout.flush()  # a full disk is told here, not after the last exit
    except GaitoptError as error:
        print_error(str(error))
        sentences = getattr(getattr(error, "diagnosis", None), "sentences", ())
        print_advice(f"- {sentence}" for sentence in sentences)
        raise typer.Exit(error.exit_code) from error
    except OSError as error:
        name = "" if error.filename is None else f"cannot use '{str(error.filename)[:_LONGEST]}': "
        print_error(f"{name}{reason_of(error)}")
        raise typer.Exit(ExitCode.BAD_INPUT) from error
    except KeyboardInterrupt as error:
        print_error("interrupted before it was done; every file that was written is complete")
        raise typer.Exit(ExitCode.INTERRUPTED) from error
    except ModuleNotFoundError as error:
        if not (said := missing_package(error)):
            raise
        print_error(said)
        raise typer.Exit(ExitCode.BAD_INPUT) from error


def refuse_options(given: Mapping[str, object], when: str) -> None:
    """Check that none of some options is given.

    Args:
        given: their values, by the options as they were typed.
        when: they act, as `IdleOptionError` has it.

    Raises:
        IdleOptionError: one is.
    """
    for option, value in given.items():
        if value:
            raise IdleOptionError(option, when)


def print_advice(lines: Iterable[str]) -> None:
    """Print why there is no gait and what would help; long lines are not broken."""
    for line in lines:
        print(printable(line), file=sys.stderr)  # noqa: T201


def print_error(message: str) -> None:
    """Print an error: in a panel on a terminal, else in one line that can be searched."""
    message = printable(message)
    if not sys.stderr.isatty():
        print(f"error: {message}", file=sys.stderr)  # noqa: T201
        return
    from rich.console import Console
    from rich.panel import Panel
    from rich.text import Text

    panel = Panel(Text(message), title="Error", title_align="left", border_style="red")
    Console(stderr=True).print(panel)


STOPPING = "stopping; press Ctrl-C again to quit at once"


@dataclass
class StopRequest:
    """Whether Ctrl-C was pressed; called, it says so, as the `stop` of a search.

    Attributes:
        asked: whether it was.
    """

    asked: bool = False

    def __call__(self) -> bool:
        """Return whether the search shall end."""
        return self.asked


def forget_odd_widths() -> None:
    """Take no width of a terminal that is none, as Emacs says 0; what prints asks Rich for it."""
    for name in ("COLUMNS", "LINES", "TERMINAL_WIDTH"):
        said = os.environ.get(name, "")
        if not (said.isascii() and said.isdigit() and len(said) < 5 and int(said) >= _NARROWEST):
            os.environ.pop(name, None)


_NARROWEST = 10  # columns; words do not fit into fewer


def handle_termination() -> None:
    """Answer SIGTERM and SIGHUP as Ctrl-C is answered at the time; one that is ignored stays so."""
    answer_signals(signal.default_int_handler, ("SIGINT",))
    answer_signals(_as_interrupt, LIKE_CTRL_C)


@contextmanager
def exit_code_kept() -> Iterator[None]:
    """Let no signal change the exit code of a command once it is known, nor show a traceback.

    A second Ctrl-C often comes when the first has just been answered.
    """
    code: object = 1  # Python's, of an exception that is told by its traceback
    try:
        try:
            yield
            code = ExitCode.OK
        except SystemExit as error:
            code = error.code
            raise
        finally:
            with suppress(GaitoptError):
                sys.stdout.flush()
            leave_with(int(code) if isinstance(code, int) else 1)
    except KeyboardInterrupt:  # amid the answer to another
        leave_with(int(ExitCode.INTERRUPTED))
        raise SystemExit(int(ExitCode.INTERRUPTED)) from None


def _as_interrupt(number: int, frame: FrameType | None) -> None:
    handler = signal.getsignal(signal.SIGINT)
    if not callable(handler):  # Ctrl-C is ignored, as in a process that a script started by "&"
        raise KeyboardInterrupt
    handler(number, frame)


@contextmanager
def stop_on_interrupt(*, announce: bool = True) -> Iterator[StopRequest]:
    """Note the first Ctrl-C inside the block instead of raising; the second raises as always.

    The solver stops between two iterations, so that its best iterate is complete.

    Args:
        announce: whether to say on stderr, at once, that the first was heard.
    """
    request = StopRequest()

    def note(number: int, frame: FrameType | None) -> None:
        del number, frame
        if request.asked:
            raise KeyboardInterrupt  # told where the command is left: after its progress
        request.asked = True
        if announce:
            _announce(STOPPING)

    if threading.current_thread() is not threading.main_thread():
        yield request  # only the main thread receives signals
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield request
    finally:
        signal.signal(signal.SIGINT, before)


def _announce(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)  # noqa: T201
    except RuntimeError:  # the signal came amid another print
        with suppress(OSError):
            os.write(2, f"{text}\n".encode())


_NOBODY_READS = (errno.EPIPE, errno.EIO, errno.ECONNRESET)
_STANDARD = 3  # descriptors: stdin, stdout, stderr


class _PipeStream(io.RawIOBase):
    """A descriptor; what nobody reads any more is dropped, and all that fails if it is lenient."""

    def __init__(self, descriptor: int, lenient: bool) -> None:
        self._descriptor, self._lenient, self._open = descriptor, lenient, True

    def write(self, data: object) -> int:
        """Write bytes, return how many were taken; raise InputError if somebody would read them."""
        view = memoryview(data).cast("B")  # type: ignore[arg-type]
        if not self._open:
            return len(view)
        try:
            return os.write(self._descriptor, view)
        except OSError as error:
            self._open = False
            if not (self._lenient or error.errno in _NOBODY_READS):
                reason = reason_of(error)
                raise InputError(
                    f"cannot write the output: {reason}; make room, or send it elsewhere"
                ) from error
            return len(view)

    def writable(self) -> bool:
        """Whether it can be written: always."""
        return True

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._descriptor

    def isatty(self) -> bool:
        """Whether it is a terminal."""
        return os.isatty(self._descriptor)


def survive_closed_pipes() -> None:
    """Replace stdout and stderr of this process by streams that outlive their readers.

    A terminal that cannot show "N·m" shows "N?m". A descriptor that is closed from the start is
    opened on nothing, so that no file that is opened later takes its place.
    """
    with suppress(OSError):
        while (free := os.open(os.devnull, os.O_RDWR)) < _STANDARD:
            pass
        os.close(free)
    sys.stdout = _pipe_stream(sys.stdout, 1, lenient=False)
    sys.stderr = _pipe_stream(sys.stderr, 2, lenient=True)


def _pipe_stream(stream: TextIO | None, descriptor: int, *, lenient: bool) -> TextIO:
    encoding = "utf-8" if stream is None else stream.encoding
    if stream is not None:
        with suppress(OSError, ValueError):
            stream.flush()
    raw = _PipeStream(descriptor, lenient)
    buffer = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffer, encoding, "replace", line_buffering=raw.isatty() or lenient)
