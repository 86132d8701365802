"""Dataclasses of options refuse names and kinds of values with advice that works."""

import re

import pytest

from gaitopt import (
    BipedSpec,
    DesignOptions,
    ImportOptions,
    Margins,
    Sole,
    Task,
    TorqueCost,
    WeightedSum,
    preset_task,
    solver_by_name,
)
from gaitopt.errors import InputError, OptionError
from gaitopt.model.import_options import LimitOverride, Payload
from gaitopt.solvers import SLSQP, SQP, Ipopt, TrustConstr, TwoStageSQP


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Task(torque_limit=3), "torque_limit is a margin: preset_task(torque_limit=...)"),
        (lambda: Task(spede=1.0), "Task has no option spede; did you mean 'speed'?"),
        (lambda: Task(*range(40)), "Task: too many positional arguments; its options are speed"),
        (lambda: Task(margins=3), "Task: margins is 3; give Margins"),
        (lambda: Task(geometry=4), "Task: geometry is 4; give a tuple or a list"),
        (lambda: Margins(fricton=0.5), "did you mean 'friction'?"),
        (lambda: DesignOptions(solvr=None), "did you mean 'solver'?"),
        (lambda: DesignOptions(refine="no"), "refine is 'no'; give True or False"),
        (lambda: SQP(tolerance="x"), "SQP: tolerance is 'x'; give a number"),
        (lambda: SQP(max_iterations=2.5), "max_iterations is 2.5; give a whole number"),
        (lambda: SQP(max_iterations=True), "max_iterations is True; give a whole number"),
        (lambda: SLSQP(tolerence=1e-3), "SLSQP has no option tolerence; did you mean 'tolerance'?"),
        (lambda: Ipopt(max_iterations="x"), "Ipopt: max_iterations is 'x'; give a whole number"),
        (lambda: TrustConstr(1, 2, 3, 4, 5, 6, 7, 8, 9), "TrustConstr: too many positional"),
        (lambda: TwoStageSQP(first=3), "TwoStageSQP: first is 3; give SQP"),
        (lambda: ImportOptions(sole=3), "ImportOptions: sole is 3; give Sole or None"),
        (lambda: LimitOverride("knee", sped=3.0), "did you mean 'speed'?"),
        (lambda: Payload(), "Payload: missing a required argument: 'link'; its options are link"),
        (lambda: TorqueCost(weight={}), "did you mean 'weights'?"),
        (lambda: WeightedSum(3), "WeightedSum: terms is 3; give a tuple or a list"),
        (lambda: Sole(toe="x", heel=0.0, left=1.0, right=0.0), "Sole: toe is 'x'; give a number"),
        (lambda: BipedSpec(nme="x"), "BipedSpec has no option nme; did you mean 'name'?"),
    ],
)
def test_what_is_no_option_is_told(make, said):
    with pytest.raises(OptionError, match=re.escape(said)) as told:
        make()
    assert isinstance(told.value, InputError)
    assert isinstance(told.value, TypeError)  # which programs may catch


def test_the_advice_works():
    assert preset_task(torque_limit=80.0).margins.torque_limit == 80.0
    assert Task(margins=Margins(torque_limit=80.0)).margin("torque_limit") == 80.0
    with pytest.raises(InputError, match=re.escape("as solver_by_name('sqp')")):
        DesignOptions(solver="sqp")
    assert DesignOptions(solver=solver_by_name("sqp")).solver == SQP()


def test_what_a_class_says_itself_goes_first():
    with pytest.raises(InputError, match="postures is 'a'; it must be a whole number"):
        Task(postures="a")
