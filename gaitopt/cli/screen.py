"""Where the command line prints."""

from __future__ import annotations

from rich.console import Console

WIDTH = 100  # columns of the tables


def screen(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr; a file or a pipe gets the tables' full width."""
    console = Console(stderr=stderr, highlight=False)
    if not console.is_terminal:
        console.width = WIDTH
    return console
