"""Where the command line prints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from gaitopt.view.visible import visible, visible_lines

WIDTH = 100  # columns of the tables


class Screen(Console):
    """A console whose texts are only texts.

    Names come from files that others made. Here nothing in them is markup, and what would steer a
    terminal is shown as an escape; lines are broken in cells of tables only.
    """

    def __init__(self, *, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def print(self, *objects: Any, **how: Any) -> None:
        """Print; a text by itself is one line, whatever names it holds."""
        super().print(*(visible(o) if isinstance(o, str) else o for o in objects), **how)

    def render_str(self, text: str, **how: Any) -> Text:
        """Return a text to be laid out with its escapes, so that cells are as wide as they look."""
        return super().render_str(visible_lines(text), **how)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Yield what is printed; whatever made it, only the console itself steers the terminal."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(visible_lines(segment.text), segment.style)


def screen(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr; a file or a pipe gets the tables' full width."""
    console = Screen(stderr=stderr)
    if not console.is_terminal:
        console.width = WIDTH
    return console


def warn(console: Console, word: str, text: str) -> None:
    """Print a line that begins with a yellow word."""
    console.print(Text.assemble((f"{word}:", "yellow"), f" {visible(text)}"), soft_wrap=True)
