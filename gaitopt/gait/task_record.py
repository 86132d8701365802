"""A task as plain data, for gait files and configuration, and back."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, fields

from gaitopt.errors import InputError
from gaitopt.gait.constraints import Margins
from gaitopt.gait.costs import TorqueCost
from gaitopt.gait.parameters import GEOMETRY, INFINITY, Quantity, set_quantities
from gaitopt.gait.plugin import (
    Extension,
    constraint_from_record,
    cost_from_record,
    extension_record,
)
from gaitopt.gait.task import Task

_QUANTITY_FIELDS = ("free", "value", "lower", "upper", "scale")
_NO_BOUND = {"lower": -INFINITY, "upper": INFINITY}


def task_record(task: Task) -> dict[str, object]:
    """Return a task as JSON-able data; an infinite bound is None, or left out by default.

    A cost other than the paper's and constraints of its own stand there if it has any.
    """
    apart = ("margins", "geometry", "cost", "constraints")
    record: dict[str, object] = {
        entry.name: getattr(task, entry.name) for entry in fields(task) if entry.name not in apart
    }
    record["margins"] = asdict(task.margins)
    if task.cost != TorqueCost():
        record["cost"] = extension_record(task.cost)
    if task.constraints:
        record["constraints"] = [extension_record(one) for one in task.constraints]
    record["geometry"] = {
        q.name: _quantity_record(q, usual) for q, usual in zip(task.geometry, GEOMETRY, strict=True)
    }
    return record


def _quantity_record(quantity: Quantity, usual: Quantity) -> dict[str, object]:
    record: dict[str, object] = {}
    for name in _QUANTITY_FIELDS:
        value = getattr(quantity, name)
        if value != _NO_BOUND.get(name):
            record[name] = value
        elif value != getattr(usual, name):
            record[name] = None  # JSON has no infinity
    return record


def task_from_record(record: object, known: Iterable[Extension] = ()) -> Task:
    """Return the task of a record made by `task_record`.

    Args:
        record: of it.
        known: constraints and costs that are not gaitopt's own, as of a plugin.

    Raises:
        InputError: the record is not that of a task, or names what is not known.
    """
    if not isinstance(record, Mapping):
        raise InputError("the record of the task is missing; was the gait designed by gaitopt?")
    values = dict(record)
    margins, geometry = values.pop("margins", {}), values.pop("geometry", {})
    cost, own = values.pop("cost", None), values.pop("constraints", [])
    known = tuple(known)
    try:
        return Task(
            **values,
            margins=Margins(**margins),
            geometry=set_quantities(GEOMETRY, _quantities(geometry)),
            cost=TorqueCost() if cost is None else cost_from_record(cost, known),
            constraints=tuple(constraint_from_record(one, known) for one in own),
        )
    except TypeError as error:
        raise InputError(f"the record of the task cannot be read: {error}") from error


def _quantities(record: object) -> dict[str, dict[str, float | bool]]:
    """Return what `set_quantities` takes; records of old leave out every infinite bound."""
    entries = record.values() if isinstance(record, Mapping) else [record]
    if not isinstance(record, Mapping) or not all(isinstance(e, Mapping) for e in entries):
        raise TypeError("its geometry is no table of tables")
    return {
        name: {k: _NO_BOUND[k] if v is None and k in _NO_BOUND else v for k, v in entry.items()}
        for name, entry in record.items()
    }
