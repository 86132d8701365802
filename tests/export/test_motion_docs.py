"""docs/motions.md tells of every form what a file of it has."""

import csv
import json
import re

import numpy as np
import pytest
import yaml
from places import DOCS
from sample_gait import sample_gait

import gaitopt
from gaitopt import bounds
from gaitopt.motions.export import FORMATS
from gaitopt.motions.motion import ORDERS

PAGE = DOCS / "motions.md"
SIZES = {"T": 80, "n": 12, "B": 13}  # a stride of 0.8 s at 100 Hz of the thirteen-link biped


def table() -> dict[str, tuple[str, dict[str, str]]]:
    """Of each form of the page: suffix with order and rate; its arrays and their shapes."""
    lines = PAGE.read_text("utf-8").split("## Formats")[1].split("## World")[0].splitlines()
    found: dict[str, tuple[str, dict[str, str]]] = {}
    for line in lines:
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 7 and cells[1].startswith("`"):
            if cells[0]:
                name, suffix = re.fullmatch(r"`(\S+)` \((\S+)\)", cells[0]).groups()
                found[name] = f"{suffix}; {cells[5]}", {}
                assert cells[6], "nobody reads it"
            assert cells[4], "it means nothing"
            found[name][1][cells[1].strip("`")] = cells[2]
    return found


TABLE = table()


def test_the_table_has_every_form():
    assert {name: head for name, (head, _) in TABLE.items()} == {
        name: f"{form.suffix}; {form.joints}" + (f"; {form.rate:g} Hz" if form.sampled else "")
        for name, form in FORMATS.items()
    }


def test_the_page_names_orders_and_bounds():
    text = PAGE.read_text("utf-8")
    assert [name for name in ORDERS if f"`{name}`" not in text] == []
    for bound in (bounds.RATE, bounds.STRIDES, bounds.INSTANTS_OF_MOTION):
        assert f"{bound:,}" in text


def shape_of(text: str) -> tuple[int, ...]:
    """The shape that the table tells, as numbers."""
    parts = re.sub(r"[()\s]", "", text).replace("×", ",").strip(",").split(",")
    return tuple(
        sum(SIZES[p] if p in SIZES else int(p) for p in part.split("+")) for part in parts if part
    )


@pytest.mark.parametrize("name", [name for name, form in FORMATS.items() if form.suffix == ".npz"])
def test_files_have_the_arrays_of_the_table(tmp_path, name):
    order = "mujoco" if name == "mujoco" else None
    path = gaitopt.export(sample_gait(), tmp_path / "m.npz", format=name, rate=100.0, joints=order)
    with np.load(path) as content:
        found = {key: content[key].shape for key in content.files}
    assert found == {key: shape_of(shape) for key, shape in TABLE[name][1].items()}


def test_tables_have_the_columns_of_the_table(tmp_path):
    path = gaitopt.export(sample_gait(), tmp_path / "m.csv", format="csv")
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    assert len(rows) == SIZES["T"]
    assert len(set(header)) == len(header) == 3 + 3 + 4 + 3 + 3 + 4 * 12 + 2 * 7
    foot, joint = "right_sole", "left_knee"
    for name in TABLE["csv"][1]:
        assert name.replace("FOOT", foot).replace("JOINT", joint) in header


def test_records_have_the_entries_of_the_table(tmp_path):
    content = json.loads(
        gaitopt.export(sample_gait(), tmp_path / "m.json", format="json").read_text()
    )
    for name, shape in TABLE["json"][1].items():
        assert np.shape(content[name]) == shape_of(shape), name
    curves = yaml.safe_load(
        gaitopt.export(sample_gait(), tmp_path / "m.yaml", format="bezier").read_text()
    )
    for name in TABLE["bezier"][1]:
        assert name in {**curves, **curves["RightSS"]}
    assert len(curves["LeftSS"]["coeff_jt"]) == 8 * SIZES["n"]
    assert len(curves["LeftSS"]["coeff_b"]) == 8 * 6
    assert {type(v) for v in curves["LeftSS"]["coeff_jt"]} == {float}
