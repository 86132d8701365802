"""The tolerances: consistent, and as the documentation tells them."""

import re

from places import DOCS

from gaitopt import tolerances
from gaitopt.solvers import SQP, Ipopt, TrustConstr

SOLVERS = DOCS / "solvers.md"


def test_the_documentation_has_every_constant_with_its_value():
    constants = {name: value for name, value in vars(tolerances).items() if name.isupper()}
    table = SOLVERS.read_text("utf-8").partition("## Tolerances")[2].partition("\n## ")[0]
    told = re.findall(r"^\| `(\w+)` \| (\S+) \| .+ \| .+ \| .+ \|$", table, re.MULTILINE)
    assert {name: float(value) for name, value in told} == constants
    assert len(told) == len(constants) == 11


def test_no_part_claims_less_than_another_relies_on():
    t = tolerances
    assert t.FEASIBILITY < t.LOCATED < t.REFINED < t.LIMITS
    assert t.REFINED + t.LOCATED < t.LIMITS
    for solver in (SQP(), TrustConstr(), Ipopt()):
        assert solver.tolerance <= t.OPTIMALITY
        assert solver.feasibility <= t.FEASIBILITY
