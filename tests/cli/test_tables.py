"""What the screen shows of numbers, lists and progress."""

import re
from collections import Counter
from dataclasses import asdict, replace
from types import SimpleNamespace

import pytest
from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from gaitopt import load_gait
from gaitopt.bounds import fixed, rounded
from gaitopt.cli.display import ProgressDisplay, new_table, screen
from gaitopt.cli.optimise import limit_lines
from gaitopt.cli.process import StopRequest
from gaitopt.cli.report import certificate_table, print_gait
from gaitopt.cli.robots import _short
from gaitopt.design.certificate import WorstRow
from gaitopt.nlp import Progress
from gaitopt.solvers.two_stage import UNCONFIRMED
from gaitopt.sweep.speed_search import Fastest

ROW = WorstRow("speed", "(1)", "left_knee speed", 0.12345, 10.0004, 10.0, "rad/s", 0.0, 0.0)


def text_of(thing, width=100):
    console = Console(width=width)
    with console.capture() as shown:
        console.print(thing)
    return shown.get()


@pytest.mark.parametrize(
    ("value", "text"), [(-9.1393e-13, "0"), (2e-6, "2e-06"), (150.1249, "150.1"), (-0.8, "-0.8")]
)
def test_numbers_that_are_zero_but_for_rounding_are_shown_as_zero(value, text):
    assert rounded(value) == text


@pytest.mark.parametrize(
    ("value", "text"), [(0.4, "0.400"), (-999999.0, "-999999.000"), (-4e8, "-4e+08")]
)
def test_numbers_that_are_huge_have_four_digits(value, text):
    assert fixed(value, 3) == text


def test_a_long_line_is_one_line_in_a_file(capsys):
    path = "some directory/" * 12
    screen().print(path)
    screen().print(Text(path))
    assert capsys.readouterr().out == f"{path}\n" * 2


def fastest_with(rows, refused=1.25):
    design = SimpleNamespace(
        certificate=SimpleNamespace(constraints=rows),
        problem=SimpleNamespace(task=SimpleNamespace(speed=1.2)),
    )
    return Fastest(design, refused, tuple(row.sentence for row in rows[1:]))


def test_limits_of_the_fastest_walk_stand_one_per_line():
    slack = replace(ROW, row="not at its limit")
    zero = replace(ROW, row="friction", time=None, value=-9.1393e-13, limit=0.0, unit="N")
    assert limit_lines(fastest_with([slack, ROW, zero])) == [
        "no walk was found at 1.250 m/s",
        "at their limits at 1.200 m/s:",
        "- left_knee speed at 0.123 s: 10 rad/s, limit 10",
        "- friction: 0 N, limit 0",
    ]
    many = [replace(ROW, row=f"row {i}") for i in range(12)]
    lines = limit_lines(fastest_with(many, float("inf")))
    assert (len(lines), lines[-1]) == (10, "- and 3 more")


def test_long_lists_end_at_a_whole_name():
    names = [f"right_finger_joint_{i}" for i in range(40)]
    text = _short(f"40 joints that are not the legs', locked at 0: {', '.join(names)}")
    shown, _, more = text.partition(": ")[2].rpartition(" and ")
    kept = shown.split(", ")
    assert kept == names[: len(kept)]
    assert more == f"{40 - len(kept)} more"
    assert len(text) <= 300
    assert _short("word " * 100).endswith("word ...")
    assert _short("a, b") == "a, b"
    advice = f"{', '.join(names[:11])}: more than gears do; leave it out, by --without damping"
    assert _short(advice + " or another word" * 3).endswith(" ...")  # a sentence is no list


def test_tables_in_a_pipe_fit_80_columns(cli, designed):
    said = (designed / "stdout.txt").read_text().splitlines()[:-2]  # the last line names files
    for words in (("robots",), ("inspect",), ("check", designed / "gait.npz")):
        said += cli(*words).stdout.splitlines()
    assert max(len(line) for line in said if str(designed) not in line) <= 80
    assert not any("…" in line for line in said)


def test_the_table_of_motors_needs_no_second_lines_on_a_narrow_terminal(designed):
    gait = load_gait(designed / "gait.npz")
    console = Console(width=80, highlight=False)
    with console.capture() as shown:
        print_gait(console, gait)
    lines = shown.get().splitlines()
    assert max(map(len, lines)) <= 80
    knee = next(i for i, line in enumerate(lines) if line.startswith("knee"))
    assert " % of 150 " in lines[knee]
    assert lines[knee + 1].split()[0] == "swing"
    assert "150 steps/min" in shown.get()


@pytest.mark.parametrize(("columns", "width"), [("4", 24), ("40", 40), ("200", 200)])
def test_a_terminal_is_as_wide_as_it_is(monkeypatch, columns, width):
    monkeypatch.setenv("COLUMNS", columns)
    monkeypatch.setenv("FORCE_COLOR", "1")  # as if on a terminal
    assert screen().width == screen(stderr=True).width == width


def words_of(text):
    """Numbers and words, in any order; of long names in lines their parts."""
    return Counter(re.findall(r"[^\s─━]+", text))


@pytest.mark.parametrize("width", [40, 60])
def test_on_a_narrow_terminal_no_number_is_broken(designed, width):
    """Tables come in parts, each with the names: all that stands at 80 columns stands there."""
    gait = load_gait(designed / "gait.npz")
    shown = []
    for columns in (width, 80):
        console = Console(width=columns, highlight=False)
        with console.capture() as said:
            print_gait(console, gait)
        shown.append(said.get())
    assert max(map(cell_len, shown[0].splitlines())) <= width
    assert not words_of(shown[1]) - words_of(shown[0])
    lines = shown[0].splitlines()
    assert sum(line.startswith("knee  ") for line in lines) == (3 if width < 60 else 2)


@pytest.mark.parametrize("width", [24, 40, 60, 79])
def test_long_names_leave_room_for_a_number(width):
    table = new_table("A table", "joint", ">torque\nN·m", ">a speed\nrad/s", "in words")
    names = [f"left_front_{k}_of_the_linkage_of_the_ankle" for k in range(3)]
    for k, name in enumerate(names):
        table.add_row(name, f"{1.25 + k:.4f}", f"{-1e-7 * (k + 1):.3e}", "more than that")
    text = text_of(table, width)
    assert max(map(cell_len, text.splitlines())) <= width
    for number in ("1.2500", "3.2500", "-1.000e-07", "-3.000e-07"):
        assert text.count(number) == 1
    assert text.startswith("A table")


@pytest.mark.parametrize(
    ("width", "heads"),
    [(40, "round cost worst violation"), (60, "round cost worst violation time"),
     (100, "round iteration cost worst violation optimality time")],
)  # fmt: skip
def test_a_search_is_shown_in_the_columns_that_there_are(width, heads):
    console = Console(width=width, force_terminal=True)
    display = ProgressDisplay(console, StopRequest(), False)
    show = display(SimpleNamespace(describe=lambda _: "left_knee torque at 80.0 % of the step"))
    show(Progress(12, 3359.62, 0.25, 0, 1e-3, 0.1, 0.2, 1, "sqp"))
    first, *rest = text_of(display._shown(), width).splitlines()
    assert first.split() == heads.split()
    assert "3359.62" in rest[0]
    assert "2.5e-01  left_knee" in rest[0]
    assert len(rest) == 1


def test_an_unconfirmed_answer_says_what_that_means():
    solver = {"name": UNCONFIRMED, "iterations": 3, "evaluations": 4, "seconds": 0.1}
    for name, said in ((UNCONFIRMED, True), ("sqp", False)):
        record = {**solver, "name": name, "sentence": "optimal"}
        table = certificate_table(record, {"kkt": None, "certified": True, "verdict": "certified"})
        assert ("the certificate does not need it" in text_of(table)) == said


def test_rounds_add_up_to_the_sum_that_is_told():
    console = Console(width=100, force_terminal=False)
    problem = SimpleNamespace(describe=str)
    with console.capture() as shown, ProgressDisplay(console, StopRequest(), False) as display:
        for begins, ends in ((0, 5), (0, 3), (19, 20)):
            show = display(problem)
            for iteration in range(begins, ends + 1):
                show(Progress(iteration, 1.0, 0.0, 0, 1e-3, 0.1, 0.2, 1, "sqp"))
    lines = shown.get().splitlines()
    assert lines[-2].startswith("round 3 (sqp), iteration 1: ")
    assert lines[-1].startswith("3 rounds, 9 iterations; ")


@pytest.mark.parametrize(
    "damage",
    [
        {"kkt": {}},
        {"kkt": 3},
        {"worst": {"time": None}},
        {"worst": {"row": "", "time": "late", "value": 0.0, "unit": "", "limit": 0.0}},
        {"referee": []},
        {"fine_violation": "none"},
        {"rear_foot_speed": {}},
    ],
)
def test_a_damaged_record_of_the_proof_is_said_to_be_one(damage):
    referee = dict.fromkeys(
        ("torque", "wrench", "impulse", "rate_after", "sole_twist", "posture", "rate", "vertical",
         "weight", "momentum"), 0.0,
    )  # fmt: skip
    record = {
        "kkt": {"stationarity": 0.0, "feasibility": 0.0, "complementarity": 0.0},
        "worst": asdict(ROW), "referee": referee, "fine_violation": 0.0, "certified": True,
        "verdict": "optimal", "rear_foot_lifts": False, "rear_foot_speed": None,
    }  # fmt: skip
    assert "worst row: left_knee speed" in text_of(certificate_table({"name": None}, record))
    shown = text_of(certificate_table({"name": None}, {**record, **damage}))
    assert "the file's record of them is damaged" in shown
