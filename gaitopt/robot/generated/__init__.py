"""Bipeds that gaitopt makes itself, from a table of parameters."""

GENERATED = "<!-- Made by gaitopt: links without rotors. -->"
"""Marks the descriptions of these bipeds, whose motors have no rotor inertia on purpose."""


def is_generated(text: str) -> bool:
    """Return whether a description was made by gaitopt."""
    return GENERATED in text[:200]
