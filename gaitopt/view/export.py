"""Write a gait in a form other programs read, chosen by the suffix of the file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gaitopt.atomic import write_atomically
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.view.record import json_text
from gaitopt.view.stride import Stride, stride
from gaitopt.view.table import csv_text

# Every JSON text is a YAML text (YAML 1.2, section 1.3), so YAML needs no package of its own.
WRITERS: dict[str, Callable[[Gait, Stride], str]] = {
    ".csv": csv_text,
    ".json": json_text,
    ".yaml": json_text,
    ".yml": json_text,
}


def export(gait: Gait, path: str | Path, *, both_legs: bool = False) -> Path:
    """Write a gait for a spreadsheet (.csv) or a controller (.json, .yaml, .yml), atomically.

    Args:
        gait: what to write.
        path: file; its suffix chooses the form.
        both_legs: whether to add the mirror image of the step, for a whole stride.

    Returns:
        The path written.

    Raises:
        InputError: the suffix is unknown, the path cannot be written, or there are too few samples
            for the splines of a .json or .yaml file.
    """
    writer = WRITERS.get(Path(path).suffix.lower())
    if writer is None:
        raise InputError(
            f"cannot export to '{path}': the suffix must be one of {', '.join(WRITERS)}"
        )
    return write_atomically(path, writer(gait, stride(gait, both_legs)).encode("utf-8"))
