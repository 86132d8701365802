"""The filter of Fletcher & Leyffer: a step must better the cost or the violation of every entry.

R. Fletcher, S. Leyffer, "Nonlinear programming without a penalty function", Mathematical
Programming 91 (2002); the rules are those of the globally convergent version of Fletcher,
Leyffer & Toint, "On the global convergence of a filter-SQP algorithm", SIAM J. Optim. 13 (2002).
"""

from __future__ import annotations

from dataclasses import dataclass, field

MARGIN = 1e-5
"""gamma, beta: relative betterment asked of a filter entry (Fletcher & Leyffer, section 2.4)."""

CEILING = 10.0
"""Largest violation the filter ever lets in, in scaled rows, unless the start is worse
(Fletcher & Leyffer, 2002, use 100 for rows that are not scaled)."""
FILTER_RESETS = 5
"""Times the filter may be emptied when it alone blocks progress (Waechter & Biegler, 2006)."""


@dataclass
class Filter:
    """Pairs (violation, cost), none of which a new iterate may be dominated by.

    Attributes:
        ceiling: largest violation ever accepted.
        entries: the pairs.
    """

    ceiling: float
    entries: list[tuple[float, float]] = field(default_factory=list)

    def accepts(self, violation: float, cost: float) -> bool:
        """Return whether no entry dominates the pair."""
        return violation <= self.ceiling and all(
            improves(violation, cost, *entry) for entry in self.entries
        )

    def add(self, violation: float, cost: float) -> None:
        """Enter a pair and drop those it dominates."""
        self.entries = [e for e in self.entries if e[0] < violation or e[1] < cost]
        self.entries.append((violation, cost))


def improves(
    violation: float, cost: float, old_violation: float, old_cost: float, noise: float = 0.0
) -> bool:
    """Return whether a pair is enough below the old one in violation or in cost.

    Args:
        violation: of the new point.
        cost: of the new point.
        old_violation: of the point or filter entry to be bettered.
        old_cost: of the same.
        noise: rounding error of a cost; a rise below it is not a rise.
    """
    return (
        violation < (1.0 - MARGIN) * old_violation or cost <= old_cost - MARGIN * violation + noise
    )
