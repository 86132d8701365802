"""How every figure looks: colours, sizes, axes.

What must be told apart has Okabe & Ito's colours (2008): by any colour vision, and in grey print.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT, MarkerStyle
from matplotlib.rcsetup import cycler
from numpy.typing import NDArray

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.escape import printable
from gaitopt.gait.result import Recorded

STANCE = "#D55E00"
SWING = "#0072B2"
TRUNK = "#333333"
SECOND = "#009E73"
MEAN = "#CC79A7"
LIMIT = "#B00020"
GREY = "#8A8A8A"
GROUND = "#B5B5B5"
RULE = "#C8C8C8"
INSIDE = "#F1F4F7"

KINDS = ("png", "svg", "pdf")
"""Forms in which figures are written."""
_GRID = "#E4E4E4"
_LONGEST = 40  # characters of a name
_COLOURS = (SWING, STANCE, SECOND, MEAN, "#56B4E9", "#E69F00", TRUNK, "#8A4B3A")
"""Of lines one after the other, for whoever confuses red with green, too; none is a limit's."""
_STYLE: Any = {
    "axes.prop_cycle": cycler("color", _COLOURS),
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titley": 1.0,  # else each draw measures all labels to keep the title off them
    "axes.labelsize": 9.0,
    "axes.formatter.useoffset": False,  # a factor of the numbers can be told with their unit
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "grid.color": _GRID,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "figure.titlesize": 11.0,
    "figure.dpi": 150,  # in which it is laid out, and saved
    "text.hinting": "none",  # as clear at this size, and quicker
    "svg.fonttype": "none",
    "svg.hashsalt": "gaitopt",
}


_WRITTEN: dict[str, Any] = {
    "svg": {"metadata": {"Date": None}},
    "pdf": {"metadata": {"CreationDate": None}},
}
"""How each form is written: without the date, equal gaits give equal figures."""


def kind_of(path: Path) -> str:
    """Return the form of a figure that a file's suffix names: "png", "svg" or "pdf".

    Raises:
        InputError: it is none of them.
    """
    kind = path.suffix.removeprefix(".").lower()
    if kind not in KINDS:
        raise InputError(f"'{path}' is no figure; give a name that ends in .png, .svg or .pdf")
    return kind


def styled() -> AbstractContextManager[None]:
    """Return the context in which figures are made and saved."""
    return rc_context(_STYLE)


def new_figure(
    width: float, height: float, layout: Literal["constrained"] | None = "constrained"
) -> Figure:
    """Return an empty figure, without any global plotting state.

    Args:
        width, height: of the figure [inch].
        layout: None for panels that are put in their place by hand.
    """
    figure = Figure(figsize=(width, height), layout=layout)
    FigureCanvasAgg(figure)  # which keeps what measures texts
    return figure


_LEFT, _GAP = 0.7, 0.16  # inch; of a panel's width: as long as no numbers are drawn
_BELOW, _ABOVE, _PANEL_TITLES, _TITLE = 0.5, 0.3, 0.175, 0.1  # inch: label, title, above the title
_LEGEND_ROW, _BESIDE = 0.2, 0.1  # inch: a row of a legend; free beside legends


def panelled(
    size: tuple[float, float], title: str, rows: int = 1, columns: int = 1, *,
    right: float = 0.1, titles: bool = False, hspace: float = 0.1, **how: Any,
) -> tuple[Figure, list[Axes]]:  # fmt: skip
    """Return a figure and its panels, row by row, for which space is left by hand.

    To measure every label twice, as Matplotlib's layouts do, takes longer than to draw it.

    Args:
        size: width and height [inch].
        title: of the figure.
        right: space on the right [inch].
        titles: whether each panel has a title.
        hspace: between rows, of a panel's height.
        how: of `Figure.subplots`.
    """
    width, height = size
    figure = new_figure(width, height, layout=None)
    above = _ABOVE + (_PANEL_TITLES if titles else 0.0)
    figure.subplots_adjust(
        left=_LEFT / width, right=1.0 - right / width, wspace=_GAP, hspace=hspace,
        bottom=_BELOW / height, top=1.0 - above / height,
    )  # fmt: skip
    figure.suptitle(title, y=1.0 - _TITLE / height)
    return figure, list(figure.subplots(rows, columns, squeeze=False, **how).ravel())


def legend_below(
    figure: Figure, handles: Sequence[Any], labels: Sequence[str], columns: int, title: str = ""
) -> None:
    """Write one legend below all panels of `panelled`, and leave space for it."""
    figure.legend(
        handles, labels, loc="lower center", ncols=columns, title=title or None, title_fontsize=8.0
    )
    rows = -(-len(labels) // columns) + bool(title)
    figure.subplots_adjust(bottom=(_BELOW + rows * _LEGEND_ROW) / figure.get_figheight())


def legends_beside(figure: Figure) -> None:
    """Write a legend on the right of each panel of `panelled`, and leave space for them."""
    legends = [axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0)) for axes in figure.axes]
    wide = max(legend.get_window_extent().width for legend in legends) / figure.bbox.width
    figure.subplots_adjust(right=1.0 - wide - _BESIDE / figure.get_figwidth())


def name_on_figure(name: str, longest: int = _LONGEST) -> str:
    """Return a name from a file as a label: visible, no mathematics in it, and not too long."""
    shown = printable(name)
    shown = shown if len(shown) <= longest else f"{shown[: longest - 3]}..."
    return shown.replace("$", "\\$")


def leg_names(gait: Recorded) -> tuple[str, str]:
    """Return what the legs are called, in the colours `STANCE` and `SWING`: "right leg", ..."""
    names = (gait.stance_sole, gait.swing_sole_frame)
    first, second = (name_on_figure(n.replace("_sole", " leg").replace("_", " ")) for n in names)
    return first, second


def label_axes(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Name both axes, with units, and the panel."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title, loc="left")


def write_figure(path: Path, draw: Callable[[], Figure]) -> Path:
    """Write what a function draws, in the form that the file's suffix names; return the path.

    Raises:
        InputError: the suffix is of no figure, or the file cannot be written.
    """
    kind = kind_of(path)
    with styled():
        figure = draw()
    return write_atomically(path, rendered(figure, kind))


def rendered(figure: Figure, kind: str) -> bytes:
    """Return a figure as a file of a kind: "png", "svg" or "pdf"."""
    buffer = io.BytesIO()
    engine = figure.get_layout_engine()
    with styled():
        if engine is None:
            _lay_out(figure)
        else:  # left to savefig, it would draw everything once more to lay it out
            engine.execute(figure)
            if sum(_name_factor(axis) for one in figure.axes for axis in (one.xaxis, one.yaxis)):
                engine.execute(figure)
            figure.set_layout_engine("none")
        if kind == "png":
            canvas: Any = figure.canvas
            canvas.draw()
            return _png(np.asarray(canvas.buffer_rgba()), figure.dpi)
        figure.savefig(buffer, format=kind, **_WRITTEN[kind])
    return buffer.getvalue()


def _name_factor(axis: Axis) -> bool:
    """Tell a factor of an axis's numbers, if it has one, in its label; return whether it has.

    Matplotlib writes it above the axis, where it lies on the title.
    """
    formatter = axis.get_major_formatter()
    formatter.format_ticks(axis.get_majorticklocs())  # type: ignore[arg-type]
    factor = formatter.get_offset() if axis.get_visible() else ""
    if factor:
        axis.get_offset_text().set_visible(False)
        axis.set_label_text(_with_factor(axis.get_label_text(), factor))
    return bool(factor)


def _with_factor(label: str, factor: str) -> str:
    """Return a label with a factor before its unit: "torque [1e6 N·m]"."""
    words, bracket, unit = label.removesuffix("]").rpartition("[")
    if not bracket:
        words, unit = f"{label} " if label else "", "-"
    return f"{words}[{factor}]" if unit == "-" else f"{words}[{factor} {unit}]"


_INCHES = 39.3701  # in a metre
_LEVEL = 3  # of compression; at 6 it takes twice as long, for 8 % less


def _png(pixels: NDArray[np.uint8], dpi: float) -> bytes:
    """Return an opaque image, red, green, blue and opacity, as a PNG file without filters.

    Pillow tries five of them for each row of pixels, which takes three times as long, for a file
    that is larger: what is drawn with lines repeats itself as it is.
    """
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), np.uint8)  # each begins with the number of its filter
    for colour in range(3):
        rows[:, 1 + colour :: 3] = pixels[..., colour]
    pitch = round(dpi * _INCHES)
    chunks = {
        b"IHDR": struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0),  # 8 bits of each colour
        b"pHYs": struct.pack(">IIB", pitch, pitch, 1),  # in a metre
        b"IDAT": zlib.compress(rows.data, _LEVEL),
        b"IEND": b"",
    }
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in chunks.items()
    )


def _lay_out(figure: Figure) -> None:
    """Draw the scales of the panels of `panelled`, with as much space as their numbers take."""
    panels = [axes for axes in figure.axes if axes.get_visible()]
    left = gap = 0.0
    for axes in panels:
        axes.apply_aspect()  # there is room for as many numbers as in what it leaves
        space = _draw_scale(axes, axes.yaxis) / (_INCH * figure.get_figwidth())
        place: Any = axes.get_subplotspec()
        left, gap = (max(left, space), gap) if place.is_first_col() else (left, max(gap, space))
    if left:
        columns = place.get_gridspec().ncols
        width = (figure.subplotpars.right - left - (columns - 1) * gap) / columns
        figure.subplots_adjust(left=left, wspace=gap / width)
    for axes in panels:
        axes.apply_aspect()
        _draw_scale(axes, axes.xaxis)


_INCH = 72.0  # points
_TICK, _TO_LABEL = 7.0, 4.0  # points, as Matplotlib has them: from a panel to numbers, to the label
_LABEL, _MARGIN = 11.0, 4.0  # points: height of a label, free beside it
_NEAR = 1e-9  # of what is seen: numbers so near its ends are shown


def _draw_scale(axes: Any, axis: Axis) -> float:
    """Draw ticks, grid, numbers and label of an axis as few objects; the axis itself no more.

    Matplotlib makes five objects of each tick, which took two thirds of the time of a figure.

    Returns:
        The space that it needs beside the panel [points]; 0 where it was drawn before.
    """
    x, shown, formatter = axis is axes.xaxis, axis.get_tick_params(), axis.get_major_formatter()
    if not axis.get_visible():
        return 0.0
    places: Any = np.asarray(axis.get_majorticklocs())
    words = formatter.format_ticks(places)
    factor = formatter.get_offset()
    axis.set_visible(False)
    low, high = axis.get_view_interval()
    inside = np.abs(places - 0.5 * (low + high)) <= (0.5 + _NEAR) * abs(high - low)
    places, words = places[inside], [word for word, seen in zip(words, inside, strict=True) if seen]
    along = axes.get_xaxis_transform if x else axes.get_yaxis_transform
    where, vertical, horizontal = (
        axes.get_xaxis_text1_transform(_TICK) if x else axes.get_yaxis_text1_transform(_TICK)
    )
    turned = 1 if x else -1  # how to order what is along the axis and what is across it
    if shown["gridOn"]:
        lines = (np.repeat(places, 3), np.tile([0.0, 1.0, np.nan], places.size))
        grid = Line2D(*lines[::turned], color=_GRID, linewidth=0.6, transform=along("grid"))
        axes.add_artist(grid).set_zorder(0.5)
    ticks = Line2D(
        *(places, np.zeros(places.size))[::turned], color="black", linestyle="", clip_on=False,
        marker=MarkerStyle(TICKDOWN if x else TICKLEFT), markersize=3.5, markeredgewidth=0.8,
        transform=along("tick1"), zorder=0.5,
    )  # fmt: skip
    axes.add_artist(ticks)
    away, label = _TICK, axis.get_label_text()
    if shown["labelbottom" if x else "labelleft"] and words:
        label = _with_factor(label, factor) if factor else label
        style: Any = {"transform": where, "va": vertical, "ha": horizontal, "fontsize": 8.0}
        texts = [
            axes.text(*(place, 0.0)[::turned], word, **style)
            for place, word in zip(places, words, strict=True)
        ]
        box = max(texts, key=lambda text: len(text.get_text())).get_window_extent()
        away += (box.height if x else box.width) * _INCH / axes.figure.dpi
    if label:
        axes.annotate(
            label, (0.5, 0.0)[::turned], (0.0, -away - _TO_LABEL)[::turned],
            xycoords="axes fraction", textcoords="offset points", rotation=0 if x else 90,
            ha="center" if x else "right", va="top" if x else "center",
        )  # fmt: skip
        away += _TO_LABEL + _LABEL
    return away + _MARGIN
