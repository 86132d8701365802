"""NAME=VALUE, as options that may be repeated take it."""

from __future__ import annotations

from gaitopt.errors import InputError


def named_values(texts: object, option: str, example: str = "speed=0.83") -> dict[str, float]:
    """Read NAME=VALUE texts.

    Args:
        texts: of one option, a list of texts; anything else has no values.
        option: its name, for the error.
        example: of a text, likewise.

    Raises:
        InputError: one is none, or a name comes twice.
    """
    values: dict[str, float] = {}
    for text in texts if isinstance(texts, list | tuple) else []:
        name, _, number = str(text).partition("=")
        if name.strip() in values:
            raise InputError(f"{option} gives {name.strip()} twice; give its value once")
        try:
            values[name.strip()] = float(number)
        except ValueError as error:
            raise InputError(
                f"{option} {text}: give a name and a number, as in {option} {example}"
            ) from error
    return values
