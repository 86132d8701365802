"""The table of tolerances: complete, consistent, and as the documentation prints it."""

from places import DOCS

from gaitopt import tolerances
from gaitopt.solvers import SQP, Ipopt, TrustConstr

SOLVERS = DOCS / "solvers.md"


def test_every_constant_is_in_the_table():
    constants = {name: value for name, value in vars(tolerances).items() if name.isupper()}
    constants.pop("TABLE")
    assert {t.name: t.value for t in tolerances.TABLE} == constants


def test_the_documentation_prints_it():
    assert tolerances.markdown() in SOLVERS.read_text()


def test_no_part_claims_less_than_another_relies_on():
    t = tolerances
    assert t.FEASIBILITY < t.LOCATED < t.REFINED < t.LIMITS
    assert t.REFINED + t.LOCATED < t.LIMITS
    for solver in (SQP(), TrustConstr(), Ipopt()):
        assert solver.tolerance <= t.OPTIMALITY
        assert solver.feasibility <= t.FEASIBILITY
