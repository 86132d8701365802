"""Inputs of every kind changed at random: a small run of `benchmarks/fuzz.py`, in this process."""

import pytest
from fuzz_cases import SHARES, kind_of, prepare, run_case

SEED = 7
EACH = {"URDF": 30, "MJCF": 24, "task": 16, "choices": 20, "specification": 16, "catalogue": 8,
        "gait file": 10, "library": 10, "arguments": 16}  # fmt: skip


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fuzz") / "inputs"
    prepare(folder)
    return folder


def numbers_of(kind, count):
    """The first so many mutations of a kind that no process of their own is started for."""
    found = (n for n in range(100_000) if kind_of(n) == kind and n // 100 % 100 != n % 100)
    return [next(found) for _ in range(count)]


def test_any_hundred_in_a_row_have_their_shares():
    kinds = [kind_of(n) for n in range(1234, 1334)]
    assert {kind: kinds.count(kind) for kind in SHARES} == SHARES


@pytest.mark.parametrize("kind", EACH)
def test_a_damaged_input_is_read_as_it_is_or_refused_in_words(kind, inputs, tmp_path, capfd):
    results = set()
    for number in numbers_of(kind, EACH[kind]):
        folder = tmp_path / str(number)
        folder.mkdir()
        outcome = run_case(number, SEED, inputs, folder)
        assert outcome.findings == [], number
        assert outcome.seconds < 20.0
        results.add(outcome.result)
    assert len(results) >= 2  # not all alike: some are read, some are refused
    assert capfd.readouterr() == ("", "")
