"""How every figure looks: colours, sizes, axes.

What must be told apart has Okabe & Ito's colours (2008): by any colour vision, and in grey print.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.escape import printable

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
_LONGEST = 40  # characters of a name
_STYLE: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titley": 1.0,  # else each draw measures all labels to keep the title off them
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "lines.linewidth": 1.6,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "figure.titlesize": 11.0,
    "figure.dpi": 150,  # in which it is laid out, and saved
    "svg.fonttype": "none",
    "svg.hashsalt": "gaitopt",
}


_WRITTEN: dict[str, Any] = {
    "png": {"pil_kwargs": {"compress_level": 3}},  # at 6 it takes half as long again, for 7 % less
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
    return Figure(figsize=(width, height), layout=layout)


def name_on_figure(name: str) -> str:
    """Return a name from a file as a label: visible, no mathematics in it, and not too long."""
    shown = printable(name)
    shown = shown if len(shown) <= _LONGEST else f"{shown[: _LONGEST - 3]}..."
    return shown.replace("$", "\\$")


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
        if engine is not None:  # left to savefig, it would draw everything once more to lay it out
            engine.execute(figure)
            figure.set_layout_engine(None)
        figure.savefig(buffer, format=kind, **_WRITTEN[kind])
    return buffer.getvalue()
