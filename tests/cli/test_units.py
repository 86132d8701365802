"""Numbers with a unit behind them."""

import math

import pytest
import typer

from gaitopt import load_gait
from gaitopt.cli.request import make_request
from gaitopt.cli.units import M_PER_S, NM, RAD, RAD_PER_S, M, N, S, reader, sine
from gaitopt.errors import InputError


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("10deg", RAD, math.radians(10.0)),
        (" -10 ° ", RAD, -math.radians(10.0)),
        ("0.2rad", RAD, 0.2),
        ("8rpm", RAD_PER_S, 2.0 * math.pi * 8.0 / 60.0),
        ("90deg/s", RAD_PER_S, math.pi / 2.0),
        ("3.6km/h", M_PER_S, 1.0),
        ("35mm", M, 0.035),
        ("4e2ms", S, 0.4),
        ("0.03kN", N, 30.0),
        ("80N·m", NM, 80.0),
        ("80 Nm", NM, 80.0),
        ("0.7", M_PER_S, 0.7),
        (".5", RAD, 0.5),
    ],
)
def test_units_are_read(text, units, value):
    assert reader(units)(text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["10dg", "deg", "", "10 deg 3", "8rpm", "1,5", "10degrad", "x"])
def test_what_is_no_angle_is_refused_with_the_units_there_are(text):
    with pytest.raises(typer.BadParameter, match=r"no number in rad.*rad, deg, °"):
        reader(RAD)(text)


def test_a_tilt_is_limited_by_its_sine():
    assert sine("10deg") == pytest.approx(math.sin(math.radians(10.0)))
    assert sine("0.2 rad") == pytest.approx(math.sin(0.2))
    assert sine("0.2") == sine(0.2) == 0.2


def test_the_help_shows_defaults_that_are_numbers_already():
    assert reader(RAD)(0.1) == 0.1


def test_a_quantity_is_held_at_a_value_with_its_unit():
    request = make_request({"fix": ["pelvis_roll=3deg", "foot_spacing=-15cm"]}, None)
    held = {q.name: q.value for q in request.task.geometry}
    assert held["pelvis_roll"] == pytest.approx(math.radians(3.0))
    assert held["foot_spacing"] == pytest.approx(-0.15)
    with pytest.raises(InputError, match="--fix pelvis_roll=3mm: give a name and a number"):
        make_request({"fix": ["pelvis_roll=3mm"]}, None)


def test_the_command_takes_them(quick, cli, tmp_path):
    done = quick("--speed", "3.6km/h", "--speed-limit", "95rpm", "-q", "-o", tmp_path)
    assert done.exit_code == 0
    task = load_gait(tmp_path / "gait.npz").meta["task"]
    assert task["speed"] == pytest.approx(1.0)
    assert task["margins"]["speed_limit"] == pytest.approx(95.0 * math.pi / 30.0)
    refused = cli("optimise", "--trunk-roll", "8rpm")
    assert refused.exit_code == 2
    assert "rad, deg" in refused.stderr
