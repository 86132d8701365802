import pytest

from gaitopt.design.relaxation import FEASIBLE_STALL, INFEASIBLE_STALL, EarlyStopping
from gaitopt.nlp import Progress


def progress(cost, violation):
    return Progress(0, cost, violation, 0, 1.0, 1.0, 0.0, 0)


def iterations(settle, records):
    """How many records a run sees until it ends."""
    return next((n for n, record in enumerate(records, start=1) if settle(record)), None)


def test_a_walk_that_no_longer_gets_better_ends_a_run():
    records = [progress(10.0 - k, 0.0) for k in range(5)] + [progress(5.999, 0.0)] * 50
    assert iterations(EarlyStopping(), records) == 5 + FEASIBLE_STALL


def test_a_run_that_gets_nowhere_ends():
    records = [progress(1.0, 0.5)] * 50
    assert iterations(EarlyStopping(), records) == 1 + INFEASIBLE_STALL


@pytest.mark.parametrize(
    "records",
    [
        [progress(10.0 * 0.9**k, 0.0) for k in range(40)],
        [progress(1.0, 0.5 * 0.8**k) for k in range(40)],
        [progress(1.0, 5e-4)] * 40,  # near
    ],
)
def test_a_run_that_gets_somewhere_goes_on(records):
    assert iterations(EarlyStopping(), records) is None
