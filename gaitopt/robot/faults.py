"""Several faults of one robot as one error: nobody should mend one only to meet the next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from gaitopt.errors import RobotError, RobotFaultsError

_LISTED = 24  # faults: more are counted


def fault_error(faults: Sequence[str]) -> RobotError:
    """Return the error that lists all faults.

    Args:
        faults: at least one sentence; doubled ones count once.
    """
    every = tuple(dict.fromkeys(faults))
    if len(every) == 1:
        return RobotError(every[0])
    listed = "; ".join(f"({k}) {fault}" for k, fault in enumerate(every[:_LISTED], 1))
    more = f"; and {len(every) - _LISTED} more" if len(every) > _LISTED else ""
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
