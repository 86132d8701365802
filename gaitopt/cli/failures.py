"""What the command line answers when something is wrong: one message, one exit code."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from enum import IntEnum

import typer

from gaitopt.errors import GaitoptError
from gaitopt.pinocchio_check import require_pinocchio
from gaitopt.view.visible import visible


class ExitCode(IntEnum):
    """Exit codes of every command.

    With --no-refine, OK means optimal at the given samples.
    """

    OK = 0
    NOT_CERTIFIED = 1
    BAD_INPUT = 2
    NO_GAIT = 3
    INTERRUPTED = 130


@contextmanager
def failures_reported() -> Iterator[None]:
    """Turn errors the user can mend into a message on stderr and an exit code; no traceback.

    An unexpected exception is left to Python: it is a bug of gaitopt and its traceback is wanted.
    """
    try:
        require_pinocchio()
        yield
        sys.stdout.flush()  # a full disk is told here, not after the last exit
    except GaitoptError as error:
        complain(str(error))
        sentences = getattr(getattr(error, "diagnosis", None), "sentences", ())
        advise(f"- {sentence}" for sentence in sentences)
        raise typer.Exit(error.exit_code) from error
    except OSError as error:
        complain(str(error))
        raise typer.Exit(ExitCode.BAD_INPUT) from error
    except KeyboardInterrupt as error:
        complain("interrupted before it was done; every file that was written is complete")
        raise typer.Exit(ExitCode.INTERRUPTED) from error


def advise(lines: Iterable[str]) -> None:
    """Print why there is no gait and what would help; long lines are not broken."""
    for line in lines:
        print(visible(line), file=sys.stderr)  # noqa: T201


def complain(message: str) -> None:
    """Print an error: in a panel on a terminal, else in one line that can be searched."""
    message = visible(message)
    if not sys.stderr.isatty():
        print(f"error: {message}", file=sys.stderr)  # noqa: T201
        return
    from rich.panel import Panel
    from rich.text import Text

    from gaitopt.cli.screen import screen

    panel = Panel(Text(message), title="Error", title_align="left", border_style="red")
    screen(stderr=True).print(panel)
