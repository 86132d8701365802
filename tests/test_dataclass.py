"""The project's `dataclass` does what the library's does: same classes made by both, compared."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import re
from collections.abc import Callable
from dataclasses import field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import gaitopt
from gaitopt.dataclass import dataclass

BOTH = pytest.mark.parametrize("decorate", [dataclass, dataclasses.dataclass])


def _classes(decorate: Callable[..., Any], seed: int) -> list[Any]:
    """Return a class with random fields, and one that inherits from it, made by one decorator."""
    rng = np.random.default_rng(seed)
    made: list[Any] = []
    for bases in ((), None):
        body: dict[str, Any] = {"__annotations__": {"known": "ClassVar[int]"}, "known": 3}
        body["__doc__"] = "A class of the test."
        body["__module__"] = __name__
        for i in rng.permutation(6)[: rng.integers(0, 6)]:
            name = f"field{i}"
            settings = {
                key: bool(rng.integers(2))
                for key in ("repr", "compare", "hash", "kw_only")
                if rng.random() < 0.3
            }
            if rng.random() < 0.15:
                settings["init"] = False
            kind = rng.integers(3)
            value = {"default": int(i)} if kind else {"default_factory": list}
            body["__annotations__"][name] = "int" if kind else "list"
            body[name] = field(**settings, **value)
        if rng.random() < 0.3:
            body["__post_init__"] = lambda self: object.__setattr__(self, "seen", True)
        if rng.random() < 0.3:
            body["__eq__"] = lambda self, other: type(other) is type(self)
        if rng.random() < 0.2:
            body["__repr__"] = lambda self: "its own"
        one = type("Inherits" if bases is None else "Plain", bases or tuple(made), body)
        made.append(decorate(frozen=True, eq=bool(rng.random() < 0.8))(one))
    return made


def _hash(one: object) -> object:
    try:
        return hash(one)
    except TypeError as problem:
        return str(problem)


def _refusals(one: object, name: str) -> list[str]:
    """Return what is said when an attribute is assigned, and deleted."""
    with pytest.raises(dataclasses.FrozenInstanceError) as assigned:
        setattr(one, name, 1)
    with pytest.raises(dataclasses.FrozenInstanceError) as deleted:
        delattr(one, name)
    return [str(assigned.value), str(deleted.value)]


@pytest.mark.parametrize("seed", range(60))
def test_random_classes_are_those_of_the_library(seed: int) -> None:
    for ours, theirs in zip(
        _classes(dataclass, seed), _classes(dataclasses.dataclass, seed), strict=True
    ):
        assert str(inspect.signature(ours)) == str(inspect.signature(theirs))
        assert ours.__match_args__ == theirs.__match_args__
        assert ours.__dataclass_params__.frozen
        names = [one.name for one in dataclasses.fields(ours)]
        assert names == [one.name for one in dataclasses.fields(theirs)]
        taken = [one.name for one in dataclasses.fields(ours) if one.init]
        rng = np.random.default_rng(seed)
        pairs = []
        for _ in range(4):
            values = {name: int(rng.integers(2)) for name in taken if rng.random() < 0.6}
            pairs.append((ours(**values), theirs(**values)))
        for one, other in pairs:
            assert repr(one) == repr(other)
            assert dataclasses.asdict(one) == dataclasses.asdict(other)
            assert vars(one) == vars(other)
            known = type(one).__hash__ is object.__hash__, type(other).__hash__ is object.__hash__
            assert known[0] == known[1]
            if not known[0]:
                assert _hash(one) == _hash(other)
            for again, their_again in pairs:
                assert (one == again) == (other == their_again)
            assert vars(copy.copy(one)) == vars(one) == vars(copy.deepcopy(one))
            for name in [*names, "unknown"]:
                assert _refusals(one, name) == _refusals(other, name)


@dataclass(frozen=True)
class Point:
    """A point of the plane."""

    x: float
    y: float = 0.0
    name: str = field(default="", compare=False)
    origin: ClassVar[float] = 0.0


@dataclasses.dataclass(frozen=True)
class Named(Point):
    """A user's class, made by the library, that inherits from one of ours."""

    colour: str = "red"


class Plain(Point):
    """A user's class without a decorator."""


def test_instances_travel_and_match() -> None:
    point = Point(1.0, name="here")
    assert pickle.loads(pickle.dumps(point)) == point == Point(1.0, name="there")
    assert hash(point) == hash(Point(1.0))
    assert dataclasses.replace(point, y=2.0) == Point(1.0, 2.0)
    match point:
        case Point(x, y):
            assert (x, y) == (1.0, 0.0)
    with pytest.raises(
        TypeError, match=re.escape("Point.__init__() missing 1 required positional")
    ):
        Point()  # type: ignore[call-arg]


def test_classes_of_the_library_inherit() -> None:
    named = Named(1.0, colour="blue")
    assert repr(named) == "Named(x=1.0, y=0.0, name='', colour='blue')"
    assert named != Named(1.0)
    assert named != Point(1.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        named.x = 2.0  # type: ignore[misc]


@BOTH
def test_plain_subclasses_may_have_attributes(decorate: Callable[..., Any]) -> None:
    kind = decorate(frozen=True)(type("Base", (), {"__annotations__": {"x": float}}))
    plain = type("Plain", (kind,), {})(1.0)
    plain.other = 2
    del plain.other
    with pytest.raises(dataclasses.FrozenInstanceError):
        plain.x = 2.0


def test_nan_and_arrays_equal_themselves() -> None:
    """Those of the library do not from Python 3.13 on."""
    kind = dataclass(frozen=True)(type("Base", (), {"__annotations__": {"x": float}}))
    for value in (float("nan"), np.zeros(3)):
        assert kind(value) == kind(value)


@BOTH
def test_an_instance_may_hold_itself(decorate: Callable[..., Any]) -> None:
    kind = decorate(frozen=True)(type("Base", (), {"__annotations__": {"held": list}}))
    one = kind([])
    one.held.append(one)
    assert repr(one) == "Base(held=[...])"


def test_the_package_makes_its_frozen_classes_by_it() -> None:
    for file in Path(gaitopt.__file__).parent.rglob("*.py"):
        text = file.read_text("utf-8")
        if file.name != "dataclass.py" and "@dataclass(frozen=True" in text:
            assert not re.search(r"^from dataclasses import .*\bdataclass\b", text, re.M), file
