"""The terminal: a console that shows names as they are, tables, and how a search is going."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeVar

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.live import Live
from rich.rule import Rule
from rich.segment import Segment
from rich.table import Column, Table
from rich.text import Text

from gaitopt import bounds
from gaitopt.cli.process import STOPPING, StopRequest
from gaitopt.escape import printable, printable_lines
from gaitopt.gait.problem import WalkProblem
from gaitopt.nlp import Progress, ProgressCallback, Solution

WIDTH = 100  # columns of the tables on a wide terminal
NARROW = 80  # in a file or a pipe, which nobody can make wider; below it tables come in parts
NARROWEST = 24  # in which a name and a number fit


class Screen(Console):
    """A console whose texts are only texts.

    Names come from files that others made. Here nothing in them is markup, and what would steer a
    terminal is shown as an escape; lines are broken in cells of tables only.
    """

    def __init__(self, *, stderr: bool = False) -> None:
        super().__init__(stderr=stderr, highlight=False, markup=False, emoji=False)

    def print(self, *objects: Any, **how: Any) -> None:
        """Print; a text by itself is one line, whatever names it holds."""
        if objects and all(isinstance(one, str | Text) for one in objects):
            how.setdefault("soft_wrap", True)
        super().print(*(printable(o) if isinstance(o, str) else o for o in objects), **how)

    def render_str(self, text: str, **how: Any) -> Text:
        """Return a text to be laid out with its escapes, so that cells are as wide as they look."""
        return super().render_str(printable_lines(text), **how)

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Yield what is printed; whatever made it, only the console itself steers the terminal."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(printable_lines(segment.text), segment.style)


def screen(*, stderr: bool = False) -> Console:
    """Return the console of stdout or stderr."""
    console = Screen(stderr=stderr)
    console.width = max(console.width, NARROWEST) if console.is_terminal else NARROW
    return console


def warn(console: Console, word: str, text: str) -> None:
    """Print a line that begins with a yellow word."""
    console.print(Text.assemble((f"{word}:", "yellow"), f" {printable(text)}"))


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
                f"{self._elapsed:.1f} s with all starts and checks"
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
            if self._live is None and not self._quiet and self._elapsed - self._printed >= PERIOD:
                self._print_line()

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

    def _shown(self) -> Table:
        """What the terminal shows, asked for eight times a second: Ctrl-C is answered at once."""
        return _table(self._rows, self._request.asked, self._console.width)

    def _print_line(self) -> None:
        self._printed = self._elapsed
        number, iteration, cost, violation, optimality, elapsed = self._rows[-1]
        what = f"{KEPT}, iterations" if number == KEPT else f"round {number}, iteration"
        self._console.print(
            f"{what} {iteration}: cost {cost}, violation {violation}, "
            f"optimality {optimality}, {elapsed}"
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


def _table(rows: list[Row], stopping: bool, width: int) -> Table:
    """One line per round, the last one running; only the latest rounds, and what there is room for.

    Args:
        width: of the terminal, in columns.
    """
    table = Table(box=None, pad_edge=False, header_style="dim", caption_justify="left")
    names = ("round", "iteration", "cost", "worst violation", "optimality", "time")
    wide = [max([len(name), *(len(row[k]) for row in rows)]) for k, name in enumerate(names)]
    shown = [*range(len(names))]
    for k in (_OPTIMALITY, _ITERATION, _TIME):
        if width - sum(wide[j] + _GAP for j in shown if j != _WORST) < min(wide[_WORST], _LEAST):
            shown.remove(k)
    room = width - sum(wide[k] + _GAP for k in shown if k != _WORST)
    for k in shown:
        if k == _WORST:
            table.add_column(
                names[k], width=max(1, min(room, _MOST)), no_wrap=True, overflow="ellipsis"
            )
        else:
            table.add_column(names[k], justify="right", no_wrap=True)
    for row in rows[-8:]:
        table.add_row(*(Text(row[k]) for k in shown))
    if stopping:
        table.caption = STOPPING
    return table


_ITERATION, _WORST, _OPTIMALITY, _TIME = 1, 3, 4, 5  # columns
_LEAST, _MOST = 30, 46  # characters of the worst violation: as it begins, and of nearly all


BAR = 6
"""Characters of a full bar."""
_AT_LIMIT, _NEAR_LIMIT = 0.999, 0.8
ABSENT = "-"


_WHOLE = 12  # columns: shorter texts are not broken
_GAP = 2  # columns between two of a table
_NAME = 8  # columns that are left for a name, and what is between it and the next
_REPEATED = 2 / 3  # of the room at most, for the columns that each part repeats


class FittedTable(Table):
    """A table that is readable where a terminal is narrow: there it comes in parts.

    Each part has the first columns and as many others as fit without breaking numbers or words.

    Attributes:
        keys: how many columns every part begins with.
    """

    keys = 1

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Yield it as it is, or its parts."""
        if options.max_width >= NARROW:
            yield from super().__rich_console__(console, options)
            return
        for number, part in enumerate(self._parts(options.max_width)):
            if number > 0:
                yield ""
            yield part

    def _parts(self, room: int) -> Iterator[Table]:
        sizes = [_sizes(column) for column in self.columns]
        keys = list(range(min(self.keys, len(sizes) - 1)))
        others = max([0, *(least for least, _ in sizes[len(keys) :])])
        repeated = max(min(_REPEATED * room, room - others), _NAME * len(keys))
        for k in keys:
            least, most = sizes[k]
            sizes[k] = min(least, int(repeated / len(keys)) - _GAP), most
        taken = sum(sizes[k][0] + _GAP for k in keys)
        parts: list[list[int]] = [[]]
        left = room - taken
        for k in range(len(keys), len(sizes)):
            if parts[-1] and sizes[k][0] > left:
                parts.append([])
                left = room - taken
            parts[-1].append(k)
            left -= sizes[k][0] + _GAP
        for number, part in enumerate(parts):
            yield self._part(room, [*keys, *part], sizes, first=number == 0)

    def _part(
        self, room: int, chosen: list[int], sizes: list[tuple[int, int]], *, first: bool
    ) -> Table:
        """Return some of the columns, wider than they must be where there is room."""
        spare = room + _GAP - sum(sizes[k][0] + _GAP for k in chosen)
        wanted = sum(sizes[k][1] - sizes[k][0] for k in chosen)
        part = _empty(Table, str(self.title) if first and self.title else None)
        part.expand, part.show_header = False, self.show_header
        for k in chosen:
            least, most = sizes[k]
            more = max(0, min(most - least, spare * (most - least) // max(wanted, 1)))
            own = self.columns[k]
            part.add_column(
                own.header, justify=own.justify, style=own.style, overflow="fold",
                width=least + more,
            )  # fmt: skip
        for row in zip(*(self.columns[k].cells for k in chosen), strict=True):
            part.add_row(*row)
        return part


def _sizes(column: Column) -> tuple[int, int]:
    """Return the least width in which nothing is broken that should not be, and the widest."""
    header, *cells = (
        [str(line) for line in str(cell).split("\n")] for cell in (column.header, *column.cells)
    )
    widest = max(cell_len(line) for lines in (header, *cells) for line in lines)
    numbers = cells if column.justify == "right" else []
    texts = [header] if numbers else [header, *cells]
    words = max(cell_len(word) for lines in texts for line in lines for word in line.split(" "))
    whole = max([0, *(cell_len(line) for lines in numbers for line in lines)])
    return max(words, whole, min(widest, _WHOLE)), widest


Kind = TypeVar("Kind", bound=Table)


def _empty(kind: type[Kind], title: str | None) -> Kind:
    return kind(
        title=title, title_justify="left", title_style="bold", header_style="dim",
        box=SIMPLE_HEAD, pad_edge=False, show_edge=False, expand=True, padding=(0, 1, 0, 0),
    )  # fmt: skip


def new_table(title: str, *columns: str, keys: int = 1) -> Table:
    """Return an empty table; a column's name is its header, with ">" before it if it holds numbers.

    A header may have a second line, for the unit.

    Args:
        keys: how many columns say what a row is of, see `FittedTable`.
    """
    table = _empty(FittedTable, title)
    table.keys = keys
    for name in columns:
        table.add_column(
            Text(name.removeprefix(">")),
            justify="right" if name.startswith(">") else "left",
            overflow="fold",
        )
    return table


def facts_grid(facts: Sequence[tuple[str, RenderableType]], width: int) -> Table:
    """Return names and values of facts, two side by side where there is room."""
    beside = 1 if width < NARROW else 2
    table = Table.grid(padding=(0, 2))
    for _ in range(beside):
        table.add_column(style="dim")
        table.add_column(style="bold")
    for k in range(0, len(facts), beside):
        table.add_row(*(cell for fact in facts[k : k + beside] for cell in fact))
    return table


def headline(title: str, verdict: tuple[str, str], width: int) -> RenderableType:
    """Return a title with its verdict and the style of that, between rules where these fit."""
    text = Text.assemble((printable(title), "bold"), "  ", verdict)
    return Rule(text) if text.cell_len + _RULES <= width else text


_RULES = 4  # columns that a rule needs beside its title


def number(value: float | None, unit: str, digits: int = 3) -> str:
    """Return a number with significant digits and unit, or a dash."""
    if value is None:
        return ABSENT
    return f"{value:.{digits}g} {unit}".rstrip()


def fixed(value: float | None, decimals: int) -> str:
    """Return a number with a fixed number of decimals, or a dash."""
    return ABSENT if value is None else bounds.fixed(value, decimals)


def bar(used: float | None, limit: float | None, length: int = BAR) -> Text:
    """Return the share of a limit as a bar, a percentage, and the limit.

    Args:
        limit: in the unit of the column.
        length: characters of a full bar; 0 where there is no room for one.
    """
    if used is None or limit is None:
        return Text("no limit", style="dim")
    full = min(length, round(length * used))
    text = Text("━" * full, style=shade(used))
    text.append("─" * (length - full), style="dim")
    text.append(f"{' ' if length else ''}{100.0 * used:3.0f} %", style=shade(used))
    text.append(f" of {limit:g}", style="dim")
    return text


def share(used: float | None, limit: float | None) -> Text:
    """Return a quantity with its limit: 0.31 of 0.7."""
    if used is None:
        return Text(ABSENT)
    if limit is None:
        return Text(fixed(used, 3))
    return Text(f"{fixed(used, 3)} of {limit:g}", style=shade(used / limit))


def shade(used: float) -> str:
    """Return the colour of a share of a limit."""
    if used >= _AT_LIMIT:
        return "bold red"
    return "yellow" if used >= _NEAR_LIMIT else "green"
