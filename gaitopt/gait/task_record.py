"""A task as plain data, for gait files and configuration, and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict

from gaitopt.errors import InputError
from gaitopt.gait.parameters import GEOMETRY, set_quantities
from gaitopt.gait.task import Margins, Task

_QUANTITY_FIELDS = ("free", "value", "lower", "upper", "scale")


def task_record(task: Task) -> dict[str, object]:
    """Return a task as JSON-able data; infinite bounds are left out."""
    record = {k: v for k, v in asdict(task).items() if k not in ("margins", "geometry")}
    record["margins"] = asdict(task.margins)
    record["geometry"] = {
        q.name: {
            name: getattr(q, name)
            for name in _QUANTITY_FIELDS
            if abs(getattr(q, name)) != float("inf")
        }
        for q in task.geometry
    }
    return record


def task_from_record(record: object) -> Task:
    """Return the task of a record made by `task_record`.

    Raises:
        InputError: the record is not that of a task.
    """
    if not isinstance(record, Mapping):
        raise InputError("the record of the task is missing; was the gait designed by gaitopt?")
    values = dict(record)
    margins, geometry = values.pop("margins", {}), values.pop("geometry", {})
    try:
        return Task(
            **values, margins=Margins(**margins), geometry=set_quantities(GEOMETRY, geometry)
        )
    except TypeError as error:
        raise InputError(f"the record of the task cannot be read: {error}") from error
