"""Names of version 0.1 that still work, with a warning."""

from __future__ import annotations

import warnings


class Renamed:
    """The name that an attribute had in version 0.1."""

    def __init__(self, new: str) -> None:
        self._new, self._old = new, ""

    def __set_name__(self, owner: type, name: str) -> None:
        """Learn the old name."""
        self._old = f"{owner.__name__}.{name}"

    def __get__(self, one: object, owner: type | None = None) -> object:
        """Return the attribute under its new name."""
        if one is None:
            return self
        warnings.warn(f"{self._old} is now '{self._new}'", DeprecationWarning, stacklevel=2)
        return getattr(one, self._new)
