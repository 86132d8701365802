"""All figures of a gait, and how they get to the disk."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.view.figure_style import styled
from gaitopt.view.ground_figures import cop_figure, force_figure
from gaitopt.view.joint_figures import angle_figure, rate_figure, torque_figure
from gaitopt.view.stick_figures import step_figure, walking_figure

FIGURES: dict[str, Callable[[Gait], Figure]] = {
    "step": step_figure,
    "ground_force": force_figure,
    "cop": cop_figure,
    "torques": torque_figure,
    "rates": rate_figure,
    "angles": angle_figure,
    "walk": walking_figure,
}


def make_figure(gait: Gait, name: str) -> Figure:
    """Return one of the figures named in `FIGURES`.

    Raises:
        InputError: there is no figure of that name.
        RobotError: the gait's URDF cannot be drawn.
    """
    if name not in FIGURES:
        raise InputError(f"there is no figure '{name}'; choose from {', '.join(FIGURES)}")
    with styled():
        return FIGURES[name](gait)


def write_figures(
    gait: Gait, directory: str | Path, formats: tuple[str, ...] = ("png",)
) -> list[Path]:
    """Write every figure of a gait to a directory, which is made if it does not exist.

    Args:
        gait: what to draw.
        directory: where to.
        formats: any of "png" (150 dots per inch), "svg" and "pdf".

    Returns:
        The files written.

    Raises:
        InputError: a format is unknown, or the directory cannot be written.
        RobotError: the gait's URDF cannot be drawn.
    """
    unknown = set(formats) - {"png", "svg", "pdf"}
    if unknown:
        raise InputError(f"figures cannot be written as {sorted(unknown)}; choose png, svg, pdf")
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the directory '{folder}': {error.strerror}") from error
    written = []
    for name in FIGURES:
        figure = make_figure(gait, name)
        for kind in formats:
            written.append(write_atomically(folder / f"{name}.{kind}", rendered(figure, kind)))
    return written


def rendered(figure: Figure, kind: str) -> bytes:
    """Return a figure as a file of a kind: "png", "svg" or "pdf"."""
    buffer = io.BytesIO()
    engine = figure.get_layout_engine()
    # without the date, equal gaits give equal figures
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with styled():
        if engine is not None:  # left to savefig, it would draw everything once more to lay it out
            engine.execute(figure)
            figure.set_layout_engine(None)
        figure.savefig(buffer, format=kind, metadata=metadata)
    return buffer.getvalue()
