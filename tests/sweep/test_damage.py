"""A damaged database of a library is told in words, and followed advice mends it."""

import random
import shutil

import pytest
from sweeps import damage, rewrite, run

from gaitopt.errors import GaitoptError
from gaitopt.sweep.library import UNREADABLE, open_library

SWEEP = ("sweep", "--speeds", "0.9,1.0", "--no-refine", "--solver", "sqp", "-o")
WALK = {
    "x": [], "cost": 0, "active": [], "cost_gradient": [0.0], "first_iterations": 0,
    "iterations": 0, "evaluations": 0, "seconds": 0, "origin": "cold",
}  # fmt: skip
ROW = {"file": "gaits/speed=0.9.npz", "status": "certified", "kkt": 0}


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    directory = tmp_path_factory.mktemp("sweep") / "gaits"
    assert run(*SWEEP, directory).exit_code == 0
    return directory


@pytest.fixture
def library(original, tmp_path):
    return shutil.copytree(original, tmp_path / "gaits")


@pytest.mark.parametrize(
    "change",
    [
        {"walk": 3},
        {"walk": []},
        {"walk": {"x": 3}},
        *({"walk": {**WALK, "active": active}} for active in (
            [[["torque"], 0, 0.5, 1.0]], [["torque", "0", 0.5, 1.0]], [[]],
        )),
        {"walk": {**WALK, "cost_gradient": [0.0, 0.0]}},
        {"walk": {**WALK, "origin": 3}},
        {"row": 3},
        {"row": {}},
        {"row": {**ROW, "file": "../../other.npz"}},
        {"row": {**ROW, "status": 1}},
        {"row": {**ROW, "kkt": []}},
        {"row": {**ROW, "cost": "much"}},
        {"row": {**ROW, "cost": True}},
        {"row": {**ROW, "cost": 10**30}},
        {"row": {**ROW, "origin": 0.9}},
        {"row": {**ROW, "certified": 1}},
        {"refusal": "none"},
        {"refusal": {"sentences": [3]}},
        {"tried": [3]},
        {"tried": [[[9], 1.0]]},
        {"due": [9]},
        {"due": [0.5]},
        {"due": 3},
        {"fault": 3},
        {"seconds": "long"},
        {"seconds": float("nan")},
        {"seconds": float("inf")},
        {"explored": 1},
        {"unknown": 1},
    ],
)  # fmt: skip
def test_records_of_another_shape_do_not_count_and_are_made_anew(library, change):
    rewrite(library, lambda name, record: name == "speed=0.9" and record.update(change))
    opened = open_library(library)
    assert opened.faults == {(0,): UNREADABLE}
    assert opened.rows[0]["status"] == UNREADABLE
    shown = run("library", library)
    assert shown.exit_code == 0
    assert UNREADABLE in shown.stdout


def test_the_command_of_the_sweep_makes_a_damaged_point_anew(original, library):
    rewrite(library, lambda name, record: name == "speed=0.9" and record.update(walk=3))
    again = run(*SWEEP, library)
    assert again.exit_code == 0
    assert again.stdout.startswith(f"made anew: gaits/speed=0.9.npz ({UNREADABLE})")
    assert open_library(library).faults == {}
    costs = [[row["cost"] for row in open_library(d).rows] for d in (original, library)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)
    assert run(*SWEEP, library).stdout.startswith("all 2 were there; nothing was computed")


def test_random_damage_of_a_record_ends_in_words(library, tmp_path):
    chance = random.Random(20)
    for attempt in range(60):
        copied = shutil.copytree(library, tmp_path / str(attempt))
        rewrite(copied, lambda name, record: damage(record, chance))
        opened = open_library(copied)
        assert len(opened.rows) == 2
        if attempt < 4:
            assert run("library", copied, "--at", "speed=0.95").exit_code in (0, 1, 2, 3)


def test_random_damage_of_the_file_ends_in_words(library):
    chance = random.Random(21)
    path = library / "library.sqlite"
    whole = path.read_bytes()
    opened = refused = 0
    for _ in range(150):
        data = bytearray(whole)
        for _ in range(chance.choice([1, 3, 30])):
            data[chance.randrange(len(data))] = chance.randrange(256)
        path.write_bytes(data[: chance.choice([len(data), chance.randrange(len(data))])])
        try:
            assert len(open_library(library).rows) == 2
            opened += 1
        except GaitoptError:
            refused += 1
    assert opened
    assert refused
