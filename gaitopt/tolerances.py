"""Every tolerance by which a walk is called found, confirmed, certified or unaltered.

One table for solvers, confirmation, certificate, referee and audit, so that no part claims less
than another relies on. docs/solvers.md prints it. All are relative to a scale: rows are scaled by
their limits (torques, rates) or by a typical size (gaitopt/gait/constraints.py).
"""

from __future__ import annotations

from gaitopt.dataclass import dataclass

OPTIMALITY = 1e-6
FEASIBILITY = 1e-8
FEASIBLE = 1e-6
ACTIVITY = 1e-6
AGREEMENT = 1e-6
LIMITS = 1e-6
REFINED = 5e-7
LOCATED = 1e-7
REFEREE = 1e-8
MOMENTUM = 1e-8
SAME = 1e-9


@dataclass(frozen=True)
class Tolerance:
    """One tolerance.

    Attributes:
        name: of the constant in this module.
        value: largest amount allowed.
        scale: what it is relative to.
        used: by whom.
        why: what it means and why it is of that size.
    """

    name: str
    value: float
    scale: str
    used: str
    why: str


TABLE = (
    Tolerance(
        "OPTIMALITY",
        OPTIMALITY,
        "cost of order one to ten, scaled rows",
        "sqp, trust-constr, ipopt, confirmation, certificate",
        "gradient of the Lagrangian and complementarity; the cost is then right to about 1e-6 of "
        "itself, and the SQP's last step, which converges quadratically, is far below it",
    ),
    Tolerance(
        "FEASIBILITY",
        FEASIBILITY,
        "scaled rows",
        "sqp, trust-constr, ipopt, confirmation",
        "violation at the samples of an answer called optimal; a hundredth of what the certificate "
        "allows, so that confirming an answer cannot use up its allowance",
    ),
    Tolerance(
        "FEASIBLE",
        FEASIBLE,
        "scaled rows",
        "choice of the best iterate, search",
        "violation at the samples below which a point counts as a walk, optimal or not",
    ),
    Tolerance(
        "ACTIVITY",
        ACTIVITY,
        "scaled rows and variables",
        "certificate, confirmation",
        "distance to a limit below which it may carry a multiplier; complementarity is judged "
        "with OPTIMALITY whatever was let in here",
    ),
    Tolerance(
        "AGREEMENT",
        AGREEMENT,
        "scaled cost, or one if that is less",
        "confirmation, choice of the best iterate",
        "difference of the two solvers' costs, in addition to each answer's own conditions; on "
        "eleven walks of the thirteen-link biped it is 3e-11 at most",
    ),
    Tolerance(
        "LIMITS",
        LIMITS,
        "scaled rows",
        "certificate",
        "violation at any instant of the step, with the uncertainty of the located extreme: "
        "1.5e-4 N·m of 150 N·m, 1e-5 rad/s of 10 rad/s, 1e-7 m of the scale of 0.1 m",
    ),
    Tolerance(
        "REFINED",
        REFINED,
        "scaled rows",
        "refinement",
        "violation at a located extreme above which its instant is added; half of LIMITS, so that "
        "what refinement leaves passes the certificate with its uncertainty",
    ),
    Tolerance(
        "LOCATED",
        LOCATED,
        "scaled rows",
        "location of extremes",
        "estimated error of a polynomial of a row near its limit; the estimate is ten times the "
        "last four coefficients, above a hundred times the error that was measured",
    ),
    Tolerance(
        "REFEREE",
        REFEREE,
        "largest entry of what is compared, at least a thousandth of its natural size",
        "referee",
        "two formulations of the same mechanics agree to rounding times conditioning",
    ),
    Tolerance(
        "MOMENTUM",
        MOMENTUM,
        "weight times step duration, m g T",
        "referee",
        "ground force and impulse over a step against gravity; the quadrature at Chebyshev points "
        "converges geometrically",
    ),
    Tolerance(
        "SAME",
        SAME,
        "largest entry of an array, or the number itself",
        "audit",
        "one formula computed twice on two machines, rounding apart",
    ),
)


def markdown() -> str:
    """Return the table as docs/solvers.md prints it."""
    lines = ["| tolerance | value | relative to | used by | why |", "|---|---|---|---|---|"]
    lines += [f"| `{t.name}` | {t.value:g} | {t.scale} | {t.used} | {t.why} |" for t in TABLE]
    return "\n".join(lines)
