"""A library that version 0.1 wrote: read as it is, converted by the sweep that goes on with it."""

import json
import random
import shutil

import pytest
from places import LIBRARY_0_1
from sweeps import QUICK, Counting, damage, quick_task, run

from gaitopt.errors import GaitoptError, InputError
from gaitopt.sweep.database import robot_source_of
from gaitopt.sweep.grid import Axis
from gaitopt.sweep.interpolation import interpolate
from gaitopt.sweep.library import MISSING, open_library
from gaitopt.sweep.scheduler import sweep

TASK = quick_task().with_margins({"torsional_friction": None})  # which 0.1 did not limit
COSTS = [2574.5958457175575, 3153.8590877184733, 3787.2456625949144]
AXIS = Axis("speed", (0.95, 1.0, 1.05))


@pytest.fixture(scope="module")
def robot():
    """The robot of the library, whatever the generator makes of its specification today."""
    return robot_source_of(LIBRARY_0_1, open_library(LIBRARY_0_1).record).build()


@pytest.fixture
def old(tmp_path):
    return shutil.copytree(LIBRARY_0_1, tmp_path / "lib")


def test_it_is_read_as_it_is(old):
    before = sorted(path.name for path in old.iterdir())
    library = open_library(old)
    assert [row["cost"] for row in library.rows] == COSTS
    assert library.faults == {}
    assert library.gait((1,)).cost == COSTS[1]
    assert library.states[(0,)].walk.origin == "slower walk"
    assert library.seconds > 0.5
    assert run("library", old).exit_code == 0
    assert interpolate(library, {"speed": 0.97}, QUICK).sources == ("speed=0.95", "speed=1")
    assert sorted(path.name for path in old.iterdir()) == before


def test_a_sweep_converts_it_and_computes_nothing_again(robot, old):
    manifest = (old / "manifest.json").read_bytes()
    with Counting() as jobs:
        library = sweep(robot, TASK, [AXIS], old, QUICK)
    assert jobs.done == []
    assert (old / "library.sqlite").exists()
    assert (old / "manifest.json").read_bytes() == manifest
    assert [row["cost"] for row in library.rows] == COSTS
    (old / "manifest.json").unlink()
    (old / "journal.jsonl").unlink()
    assert [row["cost"] for row in open_library(old).rows] == COSTS


def test_a_sweep_goes_on_with_one_that_is_not_done(robot, old):
    journal = old / "journal.jsonl"
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:2]) + lines[2][:-20])  # as kill -9 may leave it
    with Counting() as jobs:
        library = sweep(robot, TASK, [AXIS], old, QUICK)
    assert jobs.done
    assert [row["cost"] for row in library.rows] == pytest.approx(COSTS, rel=1e-6)


def test_another_sweep_is_not_mixed_in(robot, old):
    with pytest.raises(InputError, match=r"limit friction is 0\.7, asked for is 0\.6"):
        sweep(robot, quick_task(friction=0.6), [AXIS], old, QUICK)
    assert not (old / "library.sqlite").exists() or open_library(old).record["format"] == 2


def test_a_gait_that_is_missing_is_finished_anew(robot, old):
    (old / "gaits" / "speed=1.npz").unlink()
    assert open_library(old).faults == {(1,): MISSING}
    with Counting() as jobs:
        library = sweep(robot, TASK, [AXIS], old, QUICK)
    assert [job.point for job in jobs.done] == [(1,)]
    assert library.faults == {}


@pytest.mark.parametrize(
    "line",
    [
        "3",
        "null",
        pytest.param("[" * 100_000, id="nested"),
        "[]",
        "{}",
        '{"point": 3}',
        '{"point": [7]}',
        '{"point": [0, 0]}',
        '{"point": [0.5]}',
        '{"point": [0], "row": 3}',
        *(
            f'{{"point": [0], "footing": {{"x": [], "cost": 0, "active": {active}, "slopes": [], '
            f'"journey": 0, "iterations": 0, "evaluations": 0, "seconds": 0, "origin": "cold"}}}}'
            for active in ('[[["torque"], 0, 0.5, 1.0]]', '[["torque", "0", 0.5, 1.0]]', "[[]]")
        ),
        '{"point": [0], "row": {}}',
        '{"point": [0], "row": {"file": "../../other.npz", "status": "certified", "kkt": 0}}',
        '{"point": [0], "row": {"file": "gaits/speed=0.95.npz", "status": 1, "kkt": 0}}',
        '{"point": [0], "row": {"file": "gaits/speed=0.95.npz", "status": "certified", "kkt": []}}',
        *(
            f'{{"point": [0], "row": {{"file": "gaits/speed=0.95.npz", "status": "certified", '
            f'"kkt": 0, {wrong}}}}}'
            for wrong in (
                '"cost": "much"',
                '"cost": true',
                f'"cost": {10**30}',
                '"origin": 0.9',
                '"certified": 1',
            )
        ),
        '{"point": [0], "footing": {"x": 3}}',
        '{"point": [0], "footing": []}',
        '{"point": [0], "refusal": "none"}',
        '{"point": [0], "refusal": {"sentences": [3]}}',
        '{"point": [0], "tried": [3]}',
        '{"point": [0], "tried": [[[9], 1.0]]}',
        '{"point": [0], "round": [[[0], [9]]]}',
        '{"point": [0], "faulty": 3}',
        '{"point": [0], "seconds": "long"}',
        '{"point": [0], "seconds": NaN}',
        '{"point": [0], "seconds": 1e999}',
    ],
)
def test_damaged_lines_are_told_or_do_not_count(old, line):
    journal = old / "journal.jsonl"
    whole = journal.read_text()
    first, rest = whole.split("\n", 1)
    journal.write_text(f"{first}\n{line}\n{rest}")
    result = run("library", old)
    if result.exit_code:
        assert result.exit_code == 2
        assert f"line 2 of '{journal}' is damaged; remove the line" in result.stderr
    else:
        faults = open_library(old).faults
        assert set(faults) <= {(0,)}
    journal.write_text(whole)  # as the message advises
    assert run("library", old).exit_code == 0


def test_a_line_that_is_no_json_is_named(old):
    (old / "journal.jsonl").write_bytes(b'{"point": [1]}\n{"po\n{"point": [2]}\n')
    with pytest.raises(InputError, match="line 2 of"):
        open_library(old)


def test_a_manifest_of_another_format_is_refused(robot, old):
    manifest = json.loads((old / "manifest.json").read_text())
    (old / "manifest.json").write_text(json.dumps({**manifest, "format": 1}))
    with pytest.raises(GaitoptError, match="is 1, this gaitopt reads 2; make the"):
        open_library(old)
    with pytest.raises(GaitoptError, match="is 1, this gaitopt reads 2; make the"):
        sweep(robot, TASK, [AXIS], old, QUICK)
    assert not (old / "library.sqlite").exists()


@pytest.mark.parametrize("name", ["manifest.json", "journal.jsonl"])
def test_random_damage_ends_in_words(old, name):
    chance = random.Random(20)
    path = old / name
    whole = path.read_text()
    for _ in range(100):
        path.write_text(_damaged(whole, chance))
        try:
            assert len(open_library(old).rows) >= 1
        except GaitoptError:
            continue


def _damaged(text, chance):
    """Another value in place of one somewhere in a JSON line, or an entry less."""
    lines = text.split("\n") if text.count("\n{") else [text]
    at = chance.randrange(len(lines))
    try:
        record = json.loads(lines[at])
    except ValueError:
        return text[: chance.randrange(len(text))]
    damage(record, chance)
    lines[at] = json.dumps(record)
    return "\n".join(lines)
