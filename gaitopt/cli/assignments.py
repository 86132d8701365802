"""NAME=VALUE, as options that may be repeated take it."""

from __future__ import annotations

from collections.abc import Mapping

from gaitopt.cli.units import Units, with_unit
from gaitopt.errors import InputError


def named_values(
    texts: object,
    option: str,
    example: str = "speed=0.83",
    units: Mapping[str, Units] | None = None,
) -> dict[str, float]:
    """Read NAME=VALUE texts.

    Args:
        texts: of one option, a list of texts; anything else has no values.
        option: its name, for the error.
        example: of a text, likewise.
        units: that may stand behind the value of a name.

    Raises:
        InputError: one is none, or a name comes twice.
    """
    values: dict[str, float] = {}
    for text in texts if isinstance(texts, list | tuple) else []:
        name, _, number = str(text).partition("=")
        if name.strip() in values:
            raise InputError(f"{option} gives {name.strip()} twice; give its value once")
        try:
            values[name.strip()] = with_unit(number, (units or {}).get(name.strip(), {}))
        except ValueError as error:
            raise InputError(
                f"{option} {text}: give a name and a number, as in {option} {example}"
            ) from error
    return values
