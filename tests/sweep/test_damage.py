"""A damaged journal or manifest of a library is told in words, and followed advice mends it."""

import json
import random
import shutil

import pytest
from typer.testing import CliRunner

from gaitopt.cli.app import app
from gaitopt.errors import GaitoptError
from gaitopt.sweep.library import open_library

SWEEP = ("sweep", "--speeds", "0.9,1.0", "--no-refine", "--solver", "sqp", "-o")


def run(*words):
    return CliRunner().invoke(app, [str(w) for w in words], catch_exceptions=False)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    directory = tmp_path_factory.mktemp("sweep") / "gaits"
    assert run(*SWEEP, directory).exit_code == 0
    return directory


@pytest.fixture
def library(original, tmp_path):
    return shutil.copytree(original, tmp_path / "gaits")


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
        '{"point": [0], "row": {"file": "gaits/speed=0.9.npz", "status": 1, "kkt": 0}}',
        '{"point": [0], "row": {"file": "gaits/speed=0.9.npz", "status": "certified", "kkt": []}}',
        *(
            f'{{"point": [0], "row": {{"file": "gaits/speed=0.9.npz", "status": "certified", '
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
def test_lines_of_another_shape(library, line):
    journal = library / "journal.jsonl"
    whole = journal.read_text()
    first, rest = whole.split("\n", 1)
    journal.write_text(f"{first}\n{line}\n{rest}")
    for words in (("library", library), (*SWEEP, library)):
        result = run(*words)
        assert result.exit_code == 2
        assert f"line 2 of '{journal}' is damaged" in result.stderr
    journal.write_text(whole)  # as the message advises
    assert run("library", library).exit_code == 0


@pytest.mark.parametrize("name", ["manifest.json", "journal.jsonl"])
def test_random_damage_ends_in_words(library, name):
    chance = random.Random(20)
    path = library / name
    whole = path.read_text()
    for _ in range(150):
        path.write_text(_damaged(whole, chance))
        try:
            opened = open_library(library)
            opened.rows  # noqa: B018
        except GaitoptError:
            continue
    for _ in range(4):
        path.write_text(_damaged(whole, chance))
        assert run("library", library, "--at", "speed=0.95").exit_code in (0, 1, 2, 3)


def _damaged(text, chance):
    """Another value in place of one somewhere in a JSON line, or an entry less."""
    lines = text.split("\n") if text.count("\n{") else [text]
    at = chance.randrange(len(lines))
    try:
        record = json.loads(lines[at])
    except ValueError:
        return text[: chance.randrange(len(text))]
    place = record
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            break
        key = chance.choice(keys)
        inner = place[key]
        if isinstance(inner, dict | list) and inner and chance.random() < 0.7:
            place = inner
            continue
        if chance.random() < 0.3:
            del place[key]
        else:
            place[key] = chance.choice([None, 3, -1, "text", [], {}, [[1]], 1e300, True])
        break
    lines[at] = json.dumps(record)
    return "\n".join(lines)
