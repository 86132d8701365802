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
from gaitopt.motions.formats import FORMATS
from gaitopt.motions.orders import ORDERS

PAGE = DOCS / "motions.md"
HEADER = "| format | array | shape | unit | what, frame | order unless asked | read by |\n"
SIZES = {"T": 80, "n": 12, "B": 13}  # a stride of 0.8 s at 100 Hz of the thirteen-link biped


def table() -> str:
    lines = [HEADER, "|---|---|---|---|---|---|---|\n"]
    for form in FORMATS.values():
        first = [f"`{form.name}` ({form.suffix})", form.joints, form.readers]
        if form.sampled:
            first[1] += f"; {form.rate:g} Hz"
        for one in form.arrays:
            cells = [first[0], f"`{one.name}`", one.shape, one.unit, one.meaning, *first[1:]]
            lines.append("| " + " | ".join(cells) + " |\n")
            first = ["", "", ""]
    return "".join(line.replace("|  |", "| |").replace("|  |", "| |") for line in lines)


def test_the_table_is_current():
    assert table() in PAGE.read_text("utf-8"), table()


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
    assert found == {one.name: shape_of(one.shape) for one in FORMATS[name].arrays}


def test_tables_have_the_columns_of_the_table(tmp_path):
    path = gaitopt.export(sample_gait(), tmp_path / "m.csv", format="csv")
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    assert len(rows) == SIZES["T"]
    assert len(set(header)) == len(header) == 3 + 3 + 4 + 3 + 3 + 4 * 12 + 2 * 7
    foot, joint = "right_sole", "left_knee"
    for one in FORMATS["csv"].arrays:
        assert one.name.replace("FOOT", foot).replace("JOINT", joint) in header


def test_records_have_the_entries_of_the_table(tmp_path):
    content = json.loads(
        gaitopt.export(sample_gait(), tmp_path / "m.json", format="json").read_text()
    )
    for one in FORMATS["json"].arrays:
        assert np.shape(content[one.name]) == shape_of(one.shape), one.name
    curves = yaml.safe_load(
        gaitopt.export(sample_gait(), tmp_path / "m.yaml", format="bezier").read_text()
    )
    for one in FORMATS["bezier"].arrays:
        assert one.name in {**curves, **curves["RightSS"]}
    assert len(curves["LeftSS"]["coeff_jt"]) == 8 * SIZES["n"]
    assert len(curves["LeftSS"]["coeff_b"]) == 8 * 6
    assert {type(v) for v in curves["LeftSS"]["coeff_jt"]} == {float}
