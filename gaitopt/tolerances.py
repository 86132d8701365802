"""Every tolerance by which a walk is called found, confirmed, certified or unaltered.

One table for solvers, confirmation, certificate, referee and audit, so that no part claims less
than another relies on; docs/solvers.md tells who uses which. Rows are scaled by their limits
(torques, rates) or by a typical size (gaitopt/gait/constraints.py).
"""

OPTIMALITY = 1e-6
"""Gradient of the Lagrangian and complementarity, of a cost of order one to ten and scaled rows;
the cost is then right to about 1e-6 of itself, and the SQP's last step, which converges
quadratically, is far below it."""
FEASIBILITY = 1e-8
"""Violation of scaled rows at the samples of an answer called optimal; a hundredth of what the
certificate allows, so that confirming an answer cannot use up its allowance."""
FEASIBLE = 1e-6
"""Violation of scaled rows at the samples below which a point counts as a walk, optimal or not."""
ACTIVITY = 1e-6
"""Distance of scaled rows and variables to a limit below which it may carry a multiplier;
complementarity is judged with OPTIMALITY whatever was let in here."""
AGREEMENT = 1e-6
"""Difference of the two solvers' scaled costs, or of one if that is less, in addition to each
answer's own conditions; on eleven walks of the thirteen-link biped it is 3e-11 at most."""
LIMITS = 1e-6
"""Violation of scaled rows at any instant of the step, with the uncertainty of the located extreme:
1.5e-4 N·m of 150 N·m, 1e-5 rad/s of 10 rad/s, 1e-7 m of the scale of 0.1 m."""
REFINED = 5e-7
"""Violation of scaled rows at a located extreme above which its instant is added; half of LIMITS,
so that what refinement leaves passes the certificate with its uncertainty."""
LOCATED = 1e-7
"""Estimated error of a polynomial of a scaled row near its limit; the estimate is ten times the
last four coefficients, above a hundred times the error that was measured."""
REFEREE = 1e-8
"""Difference of two formulations of the same mechanics, which agree to rounding times conditioning,
over the largest entry of what is compared, at least a thousandth of its natural size."""
MOMENTUM = 1e-8
"""Ground force and impulse over a step against gravity, over weight times step duration, m g T; the
quadrature at Chebyshev points converges geometrically."""
SAME = 1e-9
"""Difference of one formula computed twice on two machines, rounding apart, over the largest entry
of an array, or the number itself."""
