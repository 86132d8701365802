"""How the contacts of a foot look in figures and on pages, and what its phases are called."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gaitopt.contact import BOTH_FEET, FlatFoot, HeelLine, ToeLine
from gaitopt.gait.result import ContactPhase, Gait
from gaitopt.gait.transition import Transition

COLOURS = {FlatFoot.name: "#009E73", ToeLine.name: "#CC79A7", HeelLine.name: "#56B4E9"} | {
    BOTH_FEET: "#F0E442"
}
"""By the name of the contact; of Okabe & Ito, as those of figures."""
OTHER = "#8A8A8A"
"""Of a contact that is none of these."""


def contact_colour(contact: str) -> str:
    """Return the colour of a contact, "#rrggbb"."""
    return COLOURS.get(contact, OTHER)


def contact_words(contact: str) -> str:
    """Return how a foot stands in words: "flat", "on the toe line"."""
    if contact == BOTH_FEET:
        return "beside the other"
    return contact if contact == FlatFoot.name else f"on the {contact}"


def flat_contact(stands: NDArray[np.bool_]) -> str:
    """Return the contact where these feet stand flat, shape (2,)."""
    return BOTH_FEET if stands.all() else FlatFoot.name


def contacts(gait: Gait | Transition) -> list[str]:
    """Return the contacts of a step, each once, in their order, or those of a transition."""
    if isinstance(gait, Transition):
        return [BOTH_FEET, FlatFoot.name][not gait.rests :]
    return list(dict.fromkeys(phase.contact for phase in gait.phases))


def phase_at(gait: Gait, time: float) -> ContactPhase:
    """Return the phase of a step at a time [s]; the instant of a change is before it."""
    return next((one for one in gait.phases if time <= one.end), gait.phases[-1])
