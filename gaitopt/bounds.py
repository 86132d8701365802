"""The largest of everything that a user can ask for; more is refused by its number, at once.

Each bound is far above what is of use and below what takes the memory or the day of a machine, so
that a slip of the keyboard, or a number in a file from elsewhere, ends in a sentence. They are
checked where a value enters (`Task`, `Gait`, `Grid`, readers of files), before anything of
that size is made.
"""

from __future__ import annotations

import json
import math
import os
import select
import stat
from collections.abc import Iterator
from numbers import Real
from pathlib import Path
from typing import TypeGuard

from gaitopt.errors import InputError, OptionError
from gaitopt.tolerances import LIMITS

SAMPLES = 1001
"""Instants of a step. Results change by less than 1e-4 beyond 101; a solve with 1001 takes some ten
times one with 31."""
INSTANTS = 20_000
"""Instants in a gait file: the samples and those that refinement added."""
POSTURES = 20
"""Intermediate postures: the cost hardly falls beyond ten, and a design with 20 takes minutes."""
STARTS = 1000
"""First guesses of one search, each of which takes a second or so."""
WORKERS = 256
"""Processes on this machine, each of which takes some 150 MB."""
POINTS = 20_000
"""Points of a sweep: each is a file and a second or more of work."""
STEPS = 200
"""Steps of a film: a minute and a half at 0.4 s."""
FRAMES = 20_000
"""Frames of a film, steps times instants: a page holds every part of the robot at each."""
TIMES = 1_000_000
"""Instants at which a trajectory is evaluated at once: half a minute, and a gigabyte."""
RATE = 100_000
"""Samples a second of a motion [Hz]: drives run at some ten thousand."""
STRIDES = 10_000
"""Strides of a motion: some hours of walking."""
INSTANTS_OF_MOTION = 200_000
"""Instants of a motion: 200 s at 1 kHz, some gigabyte while it is made with its bodies."""

MEGABYTE = 10**6
TEXT = 32 * MEGABYTE
"""Bytes of a robot's file (URDF, MJCF, SRDF): public ones have less than one megabyte."""
TABLE = MEGABYTE
"""Bytes of a TOML file."""
MESH = 256 * MEGABYTE
"""Bytes of one mesh file: the largest of public humanoids have 50 MB."""
GAIT = 256 * MEGABYTE
"""Bytes of a gait file, unpacked; numpy stores a text in four bytes a character."""
MANIFEST = 256 * MEGABYTE
"""Bytes of the manifest of a library of version 0.1, which holds the robot's file."""
JOURNAL = 1000 * MEGABYTE
"""Bytes of the journal of a sweep of version 0.1: some ten kilobytes a point."""
DATABASE = 1000 * MEGABYTE
"""Bytes of the database of a library: some ten kilobytes a point."""
SILENCE = 15.0
"""Time for which nothing comes out of a pipe until it is given up [s]: xacro takes two."""
NUMBER = 1e50
"""Size of any number, in SI units: sums of squares, products and quotients still have a value."""
USABLE = f"between {1.0 / NUMBER:g} and {NUMBER:g}"
"""Sizes of numbers other than 0 with which computing has sense, in words."""

SIZE = 1e9
"""Size of any number of a robot's file [kg, m, kg·m²]: a thousand times the largest machines, in mm
and g."""
ARMATURE = 1000.0
"""Inertia of the rotor of a joint seen from there [kg·m²; kg]: a leg of 10 kg and 1 m has 3 about
its hip."""

_READABLE = 10**15
_PIECE = 2**22  # bytes read at once
_SHOWN = 120  # characters of a value of a record
_DIGITS = 12  # characters of a number
_MANY = 1e6  # beyond it nobody reads decimals
_LONGEST = 60  # characters of a value in a message


def at_most(value: int, most: int, what: str, advice: str = "") -> None:
    """Refuse a number beyond its bound.

    Args:
        value: asked for.
        most: its bound.
        what: is counted, as "samples".
        advice: what else to do, appended to the message.

    Raises:
        InputError: the number is too large.
    """
    if value > most:
        more = f"; {advice}" if advice else ""
        raise InputError(f"{shown(value)} {what} are too many; give at most {most}{more}")


def must_be(value: object, kind: type | tuple[type, ...], what: str, advice: str) -> None:
    """Refuse an argument of another kind.

    Args:
        what: it is, as "the robot".
        advice: what to give, with an example.

    Raises:
        OptionError: it is of another kind.
    """
    if not isinstance(value, kind):
        raise OptionError(f"{what} is {shown(value)}; give {advice}")


def is_finite(value: object) -> TypeGuard[float]:
    """Return whether a value is a finite number."""
    if isinstance(value, bool):  # to Python a kind of int
        return False
    try:
        return isinstance(value, Real) and math.isfinite(value)
    except OverflowError:  # a whole number beyond every float
        return False


def is_of_use(value: object) -> bool:
    """Return whether a value is a finite number, 0 or of a size with which computing has sense."""
    return is_finite(value) and (value == 0.0 or 1.0 / NUMBER <= abs(float(value)) <= NUMBER)


def is_line(value: object) -> TypeGuard[str]:
    """Return whether a value is a text of one line."""
    return isinstance(value, str) and value.isprintable()


def shown(value: object) -> str:
    """Return a value as text for a message: ten digits, those of hundreds by their size."""
    if isinstance(value, int) and abs(value) >= _READABLE:
        return "more than 1e15" if value > 0 else "less than -1e15"
    text = " ".join(map(str.strip, repr(value).splitlines()))[:_LONGEST]  # arrays have many
    return f"{value:.10g}" if isinstance(value, float) and len(text) > _DIGITS else text


def shortened(value: object) -> str:
    """Return a value as JSON for a message, cut where it is long."""
    text = "none" if value is None else json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def rounded(value: float) -> str:
    """Return a number with four digits; one that is zero but for the solver's tolerance as 0."""
    return "0" if abs(value) < LIMITS else f"{value:.4g}"


def fixed(value: float, decimals: int) -> str:
    """Return a number with fixed decimals, of some million or more with four digits in all."""
    return f"{value:.{decimals}f}" if abs(value) < _MANY else f"{value:.4g}"


NOTHING = 0.01
"""Of the largest of its kind: a percentage of less would tell of rounding, not of a design."""


def percentage(before: float, after: float, largest: float) -> float | None:
    """Return a change in per cent of what was before; None where that is next to nothing.

    Args:
        before, after: a figure.
        largest: of its kind, in the same unit.
    """
    if not abs(before) > NOTHING * abs(largest):
        return None
    return 100.0 * (after / before - 1.0)


def read_bounded(path: Path, most: int) -> bytes:
    """Return what a file holds; of a device without an end no more is read than of a file.

    A pipe is read to its end, as of `<(xacro robot.xacro)` in a shell.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is larger than its bound, the path is none, or nothing comes out of a pipe.
    """
    parts, size = [], 0
    with open(path, "rb", buffering=0, opener=_opened) as stream:
        for part in _pieces(stream.fileno(), most + 1):
            parts.append(part)
            size += len(part)
    if reason := too_large(size, most):
        raise ValueError(reason)
    return b"".join(parts)


def _opened(path: str, flags: int) -> int:
    """Open a file, of a pipe without waiting for somebody who writes into it."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def _pieces(descriptor: int, most: int) -> Iterator[bytes]:
    """Yield what an open file holds, up to some bytes: one `read` would reserve all of them."""
    waits = not stat.S_ISREG(os.fstat(descriptor).st_mode)
    begun = ended = False
    while most > 0 and not ended:
        try:
            part = os.read(descriptor, min(_PIECE, most))
            ended = not part and (begun or not waits)  # else nobody has written yet
        except BlockingIOError:
            part = b""
        if part:
            most -= len(part)
            yield part
            begun = True
        elif not ended:
            if not select.select([descriptor], [], [], SILENCE)[0]:
                raise ValueError(
                    f"it is a pipe or a terminal, out of which nothing came for {SILENCE:g} s"
                )
            begun = True


def too_large(size: int, most: int) -> str:
    """Return why a file of so many bytes is not read, or an empty text."""
    if size <= most:
        return ""
    return f"it is larger than {most // MEGABYTE} million bytes, the most that is read"
