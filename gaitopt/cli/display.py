"""The terminal: a console that shows names as they are, and how a search is going."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from typing import Any

from rich.console import Console, ConsoleOptions, RenderableType
from rich.live import Live
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from gaitopt.cli.process import STOPPING, StopRequest
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Progress, ProgressCallback, Solution
from gaitopt.view.visible import visible, visible_lines

WIDTH = 100  # columns of the tables on a wide terminal
NARROW = 80  # in a file or a pipe, which nobody can make wider


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
    """Return the console of stdout or stderr."""
    console = Screen(stderr=stderr)
    if not console.is_terminal:
        console.width = NARROW
    return console


def warn(console: Console, word: str, text: str) -> None:
    """Print a line that begins with a yellow word."""
    console.print(Text.assemble((f"{word}:", "yellow"), f" {visible(text)}"), soft_wrap=True)


PERIOD = 2.0  # s between two plain lines
NO_VIOLATION = 1e-8  # scaled; smaller ones are rounding

KEPT = "kept walk"

Row = tuple[str, str, str, str, str, str]
_NOTHING: Row = ("", "", "", "", "", "")


class ProgressDisplay:
    """Shows the progress of every round of a design; a context manager.

    An instance is what `design` takes as `on_progress`.
    """

    def __init__(self, console: Console, request: StopRequest, quiet: bool) -> None:
        self._console, self._request, self._quiet = console, request, quiet
        self._rows: list[Row] = []
        self._iterations: dict[int, int] = {}  # of each round
        self._started = time.monotonic()
        self._printed = -PERIOD
        self._live: Live | None = None

    def __enter__(self) -> ProgressDisplay:
        if self._console.is_terminal and not self._quiet:
            self._live = Live(
                console=self._console, refresh_per_second=8, get_renderable=self._shown
            )
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()
        elif self._rows and not self._quiet:
            self._print_line()
        if len(self._iterations) > 1 and not self._quiet:
            self._console.print(
                f"{len(self._iterations)} rounds, {sum(self._iterations.values())} iterations; "
                f"{self._elapsed:.1f} s with all starts and checks",
                soft_wrap=True,
            )

    def __call__(self, problem: WalkProblem) -> ProgressCallback:
        """Begin a round of refinement; return the callback of its solver."""
        first: int | None = None  # a solver may count on from the rounds before

        def show(progress: Progress) -> None:
            nonlocal first
            if first is None:
                first = progress.iteration
                self._rows.append(_NOTHING)
            number, done = len(self._rows), progress.iteration - first
            self._rows[-1] = _row(problem.describe, number, done, progress, self._elapsed)
            self._iterations[number] = done
            self._show()

        return show

    def finish(self, solution: Solution, unit: str) -> None:
        """Show the walk that is kept, which need not be the last one that was tried."""
        violation = f"{solution.violation:.1e}" if solution.violation > NO_VIOLATION else "none"
        self._rows.append(
            (
                KEPT,
                str(solution.iterations),
                f"{solution.cost:.6g} {unit}",
                violation,
                f"{solution.optimality:.0e}",
                f"{self._elapsed:.1f} s",
            )
        )

    @property
    def _elapsed(self) -> float:
        return time.monotonic() - self._started

    def _show(self) -> None:
        if self._live is None and not self._quiet and self._elapsed - self._printed >= PERIOD:
            self._print_line()

    def _shown(self) -> Table:
        """What the terminal shows, asked for eight times a second: Ctrl-C is answered at once."""
        return _table(self._rows, self._request.asked)

    def _print_line(self) -> None:
        self._printed = self._elapsed
        number, iteration, cost, violation, optimality, elapsed = self._rows[-1]
        what = f"{KEPT}, iterations" if number == KEPT else f"round {number}, iteration"
        self._console.print(
            f"{what} {iteration}: cost {cost}, violation {violation}, "
            f"optimality {optimality}, {elapsed}",
            soft_wrap=True,
        )


def _row(
    describe: Callable[[int], str], number: int, done: int, progress: Progress, elapsed: float
) -> Row:
    violation = "none"
    if progress.violation > NO_VIOLATION:
        violation = f"{progress.violation:.1e}  {describe(progress.worst)}"
    return (
        f"{number} ({progress.solver})" if progress.solver else str(number),
        str(done),
        f"{progress.cost:.6g}",
        violation,
        f"{progress.optimality:.0e}",
        f"{elapsed:.1f} s",
    )


def _table(rows: list[Row], stopping: bool) -> Table:
    """One line per round, the last one running; only the latest rounds."""
    table = Table(box=None, pad_edge=False, header_style="dim", caption_justify="left")
    for name in ("round", "iteration", "cost"):
        table.add_column(name, justify="right")
    table.add_column("worst violation", width=46, no_wrap=True, overflow="ellipsis")
    table.add_column("optimality", justify="right")
    table.add_column("time", justify="right")
    for row in rows[-8:]:
        table.add_row(*(Text(cell) for cell in row))
    if stopping:
        table.caption = STOPPING
    return table
