"""What is said about a robot: findings for a person, and all faults of one robot in one error."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Literal, get_args

from gaitopt.dataclass import dataclass
from gaitopt.errors import RobotError, RobotFaultsError

_MOST_FAULTS_LISTED = 24  # faults: more are counted

How = Literal["found", "guessed", "given", "changed", "warning"]
"""Read off the model; most likely so; fixed by the user; not as in the file; worth a look."""


@dataclass(frozen=True)
class Finding:
    """One fact about a robot.

    Attributes:
        topic: what it belongs to: "legs", "pairs", "heading", "sole", "limits", "symmetry",
            "posture", "armature", "damping", "joint friction", "springs", "gravity",
            "gravity compensation", "mass", "inertia", "proportions", "payload", "ties", "loops", or
            "file" for what is odd in a line of it.
        subject: the joint, link or leg it is about.
        text: the fact with its numbers and units.
        how: how sure it is.
    """

    topic: str
    subject: str
    text: str
    how: How = "found"

    def record(self) -> dict[str, str]:
        """Return it as JSON-able data."""
        return {"topic": self.topic, "subject": self.subject, "how": self.how, "text": self.text}


def findings_of(record: object) -> tuple[Finding, ...]:
    """Return the findings of a list of records; what is none is passed over."""
    found = []
    for entry in record if isinstance(record, list) else []:
        if isinstance(entry, Mapping) and entry.get("how") in get_args(How):
            topic, subject, text = (str(entry.get(n, "")) for n in ("topic", "subject", "text"))
            found.append(Finding(topic, subject, text, entry["how"]))
    return tuple(found)


def as_before(findings: Iterable[Finding], before: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings about a robot that is read again with every choice made explicit.

    What was found or guessed the first time remains so, with what was said of it: nobody gave it.

    Args:
        findings: of the second reading.
        before: of the first one.
    """
    again, known = list(findings), list(before)
    # of a sole that is given, where it lies is found
    found = (one for one in known if one.how in ("found", "guessed") or one.topic == "sole")
    guesses = {_fact(one) for one in found}
    for one in [one for one in again if one.how == "given" and _fact(one) in guesses]:
        told = (f for f in known if (f.topic, f.subject) == (one.topic, one.subject))
        place = again.index(one)
        again[place : place + 1] = [f for f in told if f == one or f not in again]
    return tuple(again)


def _fact(finding: Finding) -> tuple[str, str, str]:
    """Return what a finding says of what, without how it is known."""
    said = re.split(" of |[:;]", finding.text, maxsplit=1)[0]
    return finding.topic, finding.subject, said


def listed(names: Iterable[str], most: int | None = 4, quote: str = "'") -> str:
    """Return names in quotes, of many only the first: "'a', 'b' and 3 more"."""
    every = list(names)
    shown = ", ".join(f"{quote}{name}{quote}" for name in every[:most])
    more = 0 if most is None else len(every) - most
    return shown + (f" and {more} more" if more > 0 else "")


def fault_error(faults: Sequence[str]) -> RobotError:
    """Return the error that lists all faults; those that come twice count once."""
    every = tuple(dict.fromkeys(faults))
    if len(every) == 1:
        return RobotError(every[0])
    listed = "; ".join(f"({k}) {fault}" for k, fault in enumerate(every[:_MOST_FAULTS_LISTED], 1))
    more = (
        f"; and {len(every) - _MOST_FAULTS_LISTED} more" if len(every) > _MOST_FAULTS_LISTED else ""
    )
    return RobotFaultsError(
        f"{len(every)} faults keep this robot from being used: {listed}{more}", every
    )


def faults_of(error: RobotError) -> tuple[str, ...]:
    """Return the faults that an error lists, or the one that it is."""
    return error.faults if isinstance(error, RobotFaultsError) else (str(error),)


class Faults:
    """Faults that are collected while reading goes on.

    Attributes:
        found: a sentence for each.
    """

    def __init__(self) -> None:
        self.found: list[str] = []

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Note what is refused within, in place of raising it."""
        try:
            yield
        except RobotError as error:
            self.found += faults_of(error)

    def refuse(self) -> None:
        """Refuse the robot if a fault was found.

        Raises:
            RobotError: with all of them.
        """
        if self.found:
            raise fault_error(self.found)
