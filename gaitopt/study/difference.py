"""In what two sweeps differ, in words."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

Path = tuple[str, ...]
Found = tuple[Path, Any, Any]

_PARTS = {
    ("first task", "margins"): "limit",
    ("first task", "geometry"): "",
    ("first task",): "",
    ("options", "solver options", "travel"): "solver option",
    ("options", "solver options", "certify"): "second solver's option",
    ("options", "solver options"): "solver option",
    ("options",): "option",
}
"""What to call the entries below each part of a record; the longest that fits counts."""


def difference(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    """Return the first thing in which two records of sweeps differ, the robot first, or None.

    Robots are the same if their URDF and what was chosen about it are: the specification from which
    a URDF was made counts only where a sweep changes it.

    Args:
        there, asked: as of `manifest_record`.
    """
    return _robot(there, asked) or _points(there, asked) or _rest(there, asked)


def _robot(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    a, b = there["robot"], asked["robot"]
    names = _name(a["urdf"]), _name(b["urdf"])
    same = a["urdf"] == b["urdf"]
    if names[0] != names[1]:
        return f"it is of the robot '{names[0]}', asked for is '{names[1]}'"
    varied = any("." in axis and axis.split(".")[0] in (a["spec"] or ()) for axis in there["axes"])
    if not same or varied:
        found = first_difference(a["spec"], b["spec"])
        if found is not None and a["spec"] and b["spec"]:
            return f"of its robot '{names[0]}', {_compared(*found)}"
        if not same or found is not None:
            return f"it is of another robot named '{names[0]}': their URDF or tables differ"
    found = first_difference(a["choices"], b["choices"])
    return None if found is None else f"of what was chosen about its robot, {_compared(*found)}"


def _points(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    if [*there["axes"]] != [*asked["axes"]]:
        return f"it is over {', '.join(there['axes'])}, asked for is {', '.join(asked['axes'])}"
    found = first_difference(there["axes"], asked["axes"])
    if found is not None:
        (name, *_), old, new = found
        return f"its values of {name} are {_short(old)}, asked for are {_short(new)}"
    if there["seeds"] != asked["seeds"]:
        return "it began at other points than is asked for"
    return None


def _rest(there: Mapping[str, Any], asked: Mapping[str, Any]) -> str | None:
    parts = ("first task", "options")
    found = first_difference({p: there[p] for p in parts}, {p: asked[p] for p in parts})
    if found is None:
        return None
    path, old, new = found
    whole = max((p for p in _PARTS if path[: len(p)] == p), key=len)
    return f"its {_compared((_PARTS[whole], *path[len(whole) :]), old, new)}"


def first_difference(there: Any, asked: Any) -> Found | None:
    """Return the first entry in which two records differ: its path and both values."""
    if isinstance(there, Mapping) and isinstance(asked, Mapping):
        for key in dict.fromkeys([*asked, *there]):
            found = first_difference(there.get(key), asked.get(key))
            if found is not None:
                path, old, new = found
                return (key, *path), old, new
        return None
    return None if there == asked else ((), there, asked)


def _compared(path: Path, old: object, new: object) -> str:
    name = " ".join(filter(None, path))
    return f"{name} is {_short(old)}, asked for is {_short(new)}"


def _name(urdf: str) -> str:
    found = re.search(r"<(?:robot|mujoco)\b[^>]*?\b(?:name|model)\s*=\s*[\"']([^\"']*)", urdf)
    return found[1] if found else "without a name"


def _short(value: object) -> str:
    text = "none" if value is None else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 60 else f"{text[:57]}..."
