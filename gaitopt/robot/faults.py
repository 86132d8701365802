"""Several faults of one robot as one error: nobody should mend one only to meet the next."""

from __future__ import annotations

from collections.abc import Sequence

from gaitopt.errors import RobotError


def fault_error(faults: Sequence[str]) -> RobotError:
    """Return the error that lists all faults.

    Args:
        faults: at least one sentence; doubled ones count once.
    """
    listed = list(dict.fromkeys(faults))
    if len(listed) == 1:
        return RobotError(listed[0])
    numbered = "; ".join(f"({k}) {fault}" for k, fault in enumerate(listed, 1))
    return RobotError(f"{len(listed)} faults keep this robot from being used: {numbered}")
