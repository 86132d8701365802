"""Whether the Pinocchio that Python finds is the one that gaitopt needs.

Other installations may stand before it on the path: that of a ROS distribution, which PYTHONPATH
names, or a directory that happens to bear the name. They would be noticed late, by a function that
is missing.
"""

from __future__ import annotations

import importlib
import importlib.util
from types import ModuleType

from gaitopt.errors import InputError

LEAST, BELOW = (4, 1), (5, 0)  # versions, as in pyproject.toml
_NEEDED = ("buildModelFromXML", "buildGeomFromUrdfString", "computeRNEADerivatives", "SE3", "Model")


def require_pinocchio() -> None:
    """Import Pinocchio and see that it can be used.

    Raises:
        InputError: it is another one, or none.
    """
    try:
        found = importlib.import_module("pinocchio")
    except ImportError as error:
        raise _unfit(_place(), "", f"it cannot be imported: {error}") from error
    version = str(getattr(found, "__version__", ""))
    if not version or not LEAST <= _numbers(version) < BELOW:
        raise _unfit(_place(found), version, "")
    missing = [name for name in _NEEDED if not hasattr(found, name)]
    if missing:
        raise _unfit(_place(found), version, f"it has no {missing[0]}")


def _unfit(place: str, version: str, reason: str) -> InputError:
    wanted = f">={_text(LEAST)},<{BELOW[0]}"
    if not place:
        return InputError(f"Pinocchio is not installed; run: pip install 'pin{wanted}'")
    which = f"version {version}" if version else "of unknown version"
    why = f" ({reason})" if reason else ""
    return InputError(
        f"the Pinocchio that Python finds is '{place}', {which}{why}; gaitopt needs one of "
        f"{_text(LEAST)} or newer, below {_text(BELOW)}. If another is installed, this one hides "
        "it: take its directory off the path, as by 'env -u PYTHONPATH gaitopt ...', or leave the "
        f"directory that holds it; else run: pip install 'pin{wanted}'"
    )


def _place(found: ModuleType | None = None) -> str:
    """Return where it is; empty if there is none."""
    if found is not None and getattr(found, "__file__", None):
        return str(found.__file__)
    try:
        spec = importlib.util.find_spec("pinocchio")
    except (ImportError, ValueError):
        return ""
    if spec is None:
        return ""
    return str(spec.origin or next(iter(spec.submodule_search_locations or ()), ""))


def _numbers(version: str) -> tuple[int, ...]:
    numbers = []
    for part in version.split("."):
        if not part.isdigit():
            break
        numbers.append(int(part))
    return tuple(numbers)


def _text(version: tuple[int, ...]) -> str:
    return ".".join(map(str, version))
