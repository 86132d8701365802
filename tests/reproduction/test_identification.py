"""The search for the unknowns, on costs whose best values are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from reproduction.identification import FIRST_STRIDE, UNKNOWNS, identified_values, identify, misfit
from reproduction.paper import printed

LOWER = np.array([u.lower for u in UNKNOWNS])
RANGES = np.array([u.upper - u.lower for u in UNKNOWNS])
BEST = LOWER + RANGES * np.array([0.3, 0.55, 0.4, 0.6, 0.7])


@pytest.fixture
def tried(monkeypatch):
    """Costs that are the printed ones at BEST and linear in the values; returns what is asked."""
    slopes = np.random.default_rng(3).normal(0.0, 1.0, (8, 5))
    asked = []

    def walks(values):
        asked.append(np.array(values))
        errors = slopes @ ((values - BEST) / RANGES)
        costs = dict(zip(printed().speeds, printed().costs * (1.0 + errors), strict=True))
        return [SimpleNamespace(task=SimpleNamespace(speed=v), cost=c) for v, c in costs.items()]

    def curve(problems, known=None):
        solution = SimpleNamespace(x=np.ones(43))
        return {p.task.speed: SimpleNamespace(cost=p.cost, solution=solution) for p in problems}

    module = "reproduction.identification"
    monkeypatch.setattr(f"{module}.walks_with", walks)
    monkeypatch.setattr(f"{module}.cost_curve", curve)
    monkeypatch.setattr(f"{module}.warm_curve", curve)
    return asked


def test_the_best_values_are_found(tried):
    told = []
    found = identify(BEST + 0.05 * RANGES, evaluations=600, on_better=lambda v, e: told.append(e))
    np.testing.assert_allclose((found - LOWER) / RANGES, (BEST - LOWER) / RANGES, atol=2e-3)
    sizes = [misfit(errors) for errors in told]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] < 0.01 * sizes[0]


def test_the_first_tries_are_the_shipped_values_and_a_stride_along_each(tried):
    identify(evaluations=3)
    first = identified_values()
    tries = [np.flatnonzero(v != first) for v in tried]
    assert {*map(tuple, tries)} == {(), (0,), (1,)}
    assert tried[-1][1] - first[1] == pytest.approx(FIRST_STRIDE * RANGES[1])


def test_values_outside_their_ranges_are_never_walked(tried):
    edge = LOWER + RANGES * np.array([0.99, 0.55, 0.4, 0.01, 0.7])
    found = identify(edge, evaluations=60)
    for values in [*tried[1:], found]:
        assert np.all(values >= LOWER - 1e-12)
        assert np.all(values <= LOWER + RANGES + 1e-12)
