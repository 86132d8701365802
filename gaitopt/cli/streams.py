"""Standard streams that outlive their readers: `gaitopt optimise -o DIR | head -1` goes on.

A pipe that was closed, or a terminal that is gone, must not end a search half way. What can no
longer be read is dropped. A disk that is full is another matter: then the output is missed, and the
command says so.
"""

from __future__ import annotations

import errno
import io
import os
import sys
from contextlib import suppress
from typing import TextIO

from gaitopt.errors import InputError

_NOBODY_READS = (errno.EPIPE, errno.EIO, errno.ECONNRESET)
_STANDARD = 3  # descriptors: stdin, stdout, stderr


class _Outliving(io.RawIOBase):
    """A descriptor; what nobody reads any more is dropped.

    Args of the constructor: the descriptor, and whether every failure is passed over.
    """

    def __init__(self, descriptor: int, lenient: bool) -> None:
        self._descriptor, self._lenient, self._open = descriptor, lenient, True

    def write(self, data: object) -> int:
        """Write bytes; return how many were taken.

        Raises:
            InputError: they cannot be written, though somebody would read them.
        """
        view = memoryview(data).cast("B")  # type: ignore[arg-type]
        if not self._open:
            return len(view)
        try:
            return os.write(self._descriptor, view)
        except OSError as error:
            self._open = False
            if not (self._lenient or error.errno in _NOBODY_READS):
                reason = (error.strerror or "unknown reason").lower()
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


def outlive_readers() -> None:
    """Replace stdout and stderr of this process by streams that outlive their readers.

    A terminal that cannot show "N·m" shows "N?m". A descriptor that is closed from the start is
    opened on nothing, so that no file that is opened later takes its place.
    """
    with suppress(OSError):
        while (free := os.open(os.devnull, os.O_RDWR)) < _STANDARD:
            pass
        os.close(free)
    sys.stdout = _outliving(sys.stdout, 1, lenient=False)
    sys.stderr = _outliving(sys.stderr, 2, lenient=True)


def _outliving(stream: TextIO | None, descriptor: int, *, lenient: bool) -> TextIO:
    encoding = "utf-8" if stream is None else stream.encoding
    if stream is not None:
        with suppress(OSError, ValueError):
            stream.flush()
    raw = _Outliving(descriptor, lenient)
    buffer = io.BufferedWriter(raw)
    return io.TextIOWrapper(buffer, encoding, "replace", line_buffering=raw.isatty() or lenient)
