"""Numbers with a unit behind them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from looped_bipeds import parallel_ankles

from gaitopt import load_gait
from gaitopt.cli import command_options
from gaitopt.cli.config import SCHEMA, read_config
from gaitopt.cli.request import limit_of, make_request
from gaitopt.errors import InputError, RobotError
from gaitopt.gait.costs import cost_of_text
from gaitopt.model.import_options import ImportOptions, choices_from_toml
from gaitopt.model.robot import Robot
from gaitopt.settings import declared, setting
from gaitopt.units import SINE, SLOPE, UNITS, read_quantity


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10deg", "rad", math.radians(10.0)),
        (" -10 ° ", "rad", -math.radians(10.0)),
        ("0.2rad", "rad", 0.2),
        ("8rpm", "rad/s", 2.0 * math.pi * 8.0 / 60.0),
        ("90deg/s", "rad/s", math.pi / 2.0),
        ("3.6km/h", "m/s", 1.0),
        ("35mm", "m", 0.035),
        ("4e2ms", "s", 0.4),
        ("0.03kN", "N", 30.0),
        ("80N·m", "N·m", 80.0),
        ("80 Nm", "N·m", 80.0),
        ("250g", "kg", 0.25),
        ("300 g·cm²", "kg·m²", 3e-5),
        ("0.7", "m/s", 0.7),
        (".5", "rad", 0.5),
        (7, "rad", 7.0),
        ("1e-6", "", 1e-6),
    ],
)
def test_units_are_read(text, unit, value):
    assert read_quantity(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["10dg", "deg", "", "10 deg 3", "8rpm", "1,5", "10degrad", "x", True, None, [1.0]]
)
def test_what_is_no_angle_is_refused_with_the_units_there_are(text):
    with pytest.raises(ValueError, match=r"give a number in rad, .* with its unit: rad, deg, °"):
        read_quantity(text, "rad")
    with pytest.raises(ValueError, match=r"give a number$"):
        read_quantity("1 rad", "")


@pytest.mark.parametrize("number", ["1_0", "\uff11\uff10", "1\u0660", "\u00b2", "1e\uff11"])
def test_digits_are_those_from_0_to_9_everywhere(number, cli):
    """Python takes underscores and digits of all scripts, which no reader of robots does."""
    for text in (number, f"{number} mm", f"{number}mm"):
        with pytest.raises(ValueError, match="give a number in m, "):
            read_quantity(text, "m")
    for name in ("starts", "samples", "speed", "torque_limit"):
        option = f"--{name.replace('_', '-')}"
        refused = cli("optimise", option, number)
        assert refused.exit_code == 2
        assert "give a" in refused.stderr
    for word in ("weight=", "speed="):
        refused = cli("codesign", "--vary", "shin=25cm:35cm", "--walk", f"{word}{number}")
        assert refused.exit_code == 2, refused.stderr
    with pytest.raises(InputError, match="each with its weight before it"):
        cost_of_text(f"{number} torque")


def test_the_first_unit_is_that_of_a_bare_number():
    assert all(units.get(unit, 1.0) == 1.0 for unit, units in UNITS.items())


def test_a_tilt_is_limited_by_its_sine():
    assert read_quantity("10deg", SINE) == pytest.approx(math.sin(math.radians(10.0)))
    assert read_quantity("0.2 rad", SINE) == pytest.approx(math.sin(0.2))
    assert read_quantity("0.2", SINE) == read_quantity(0.2, SINE) == 0.2


@dataclass(frozen=True)
class Wheel:
    """Something that nobody thought of."""

    radius: float = field(default=0.1, metadata=setting("Of the tyre.", "m", common=True))
    teeth: int | None = field(default=None, metadata=setting("Of its gear."))
    loads: Mapping[str, float] = field(
        default_factory=dict, metadata=setting("By name.", entry_unit=lambda _: "N")
    )
    hidden: float = 3.0


def test_any_dataclass_declares_settings():
    radius, teeth, loads = declared(Wheel)
    assert (radius.name, radius.kind, radius.unit, radius.default) == ("radius", "number", "m", 0.1)
    assert (radius.option, radius.common, teeth.common) == ("--radius", True, False)
    assert radius.read("12cm") == pytest.approx(0.12)
    assert teeth.read("17") == teeth.read(17) == 17
    assert loads.read_entry({"axle": "2kN", "rim": 3}) == {"axle": 2000.0, "rim": 3.0}
    assert loads.read_pairs(["axle=2kN", "rim=3"]) == {"axle": 2000.0, "rim": 3.0}
    for value in ("1.5", 1.5, True, "x"):
        with pytest.raises(ValueError, match="give a whole number"):
            teeth.read(value)
    with pytest.raises(ValueError, match="axle: give a number in N"):
        loads.read_entry({"axle": "2kg"})


def test_a_field_that_nobody_can_write_is_refused():
    @dataclass
    class Odd:
        thing: complex = field(default=1j, metadata=setting("Of no use."))

    with pytest.raises(TypeError, match=r"Odd.thing: nobody can write a complex"):
        list(declared(Odd))


def test_a_file_takes_every_unit_that_options_take(tmp_path: Path):
    path = tmp_path / "task.toml"
    path.write_text(
        '[task]\nspeed = "3.6 km/h"\nsamples = 21\n[margins]\ntrunk_pitch = "10deg"\n'
        'swing_tilt = "10deg"\n[geometry]\nfix = { pelvis_roll = "3deg" }\n'
        '[robot]\narmature = { "*knee*" = "200 g·cm²" }\n'
    )
    read = read_config(path)
    assert read["speed"] == pytest.approx(1.0)
    assert read["trunk_pitch"] == pytest.approx(math.radians(10.0))
    assert read["swing_tilt"] == pytest.approx(math.sin(math.radians(10.0)))
    assert read["fix"] == {"pelvis_roll": pytest.approx(math.radians(3.0))}
    request = make_request({}, path)
    assert request.settings["speed"] == pytest.approx(1.0)
    rotors = {one.joints: one.armature for one in request.robot.choices.limits}
    assert rotors == {"*knee*": pytest.approx(2e-5)}
    path.write_text('[margins]\ntrunk_pitch = "10rpm"\n')
    with pytest.raises(InputError, match=r"margins.trunk_pitch = '10rpm' is wrong; .* rad, deg, °"):
        read_config(path)


def test_choices_take_units_too():
    read = choices_from_toml(
        'sole_drop = "4cm"\nposture = { knee = "10deg", hip = 0.1 }\n'
        'sole = { toe = "12cm", heel = -0.05, left = "30 mm", right = -0.03 }\n'
        '[[inertias]]\nlinks = "*foot*"\nmass = "900g"\n'
        '[[limits]]\njoints = "knee"\ntorque = "0.1kNm"\nlower = "-5deg"\nspeed = "none"\n'
    )
    assert read.sole_drop == pytest.approx(0.04)
    assert dict(read.posture) == {"knee": pytest.approx(math.radians(10.0)), "hip": 0.1}
    assert (read.sole.toe, read.sole.left) == (pytest.approx(0.12), pytest.approx(0.03))
    assert read.inertias[0].mass == pytest.approx(0.9)
    (limits,) = read.limits
    assert (limits.torque, limits.speed) == (pytest.approx(100.0), math.inf)
    assert limits.lower == pytest.approx(math.radians(-5.0))
    limit = '[[limits]]\njoints = "*"\ntorque = "8rpm"'
    for wrong in ('sole_drop = "4deg"', 'posture = { knee = "bent" }', limit):
        with pytest.raises(RobotError, match=r"is wrong; give a number in .*with its unit: "):
            choices_from_toml(f"{wrong}\n")


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("right_inner_motor.speed=12rpm", "given in rad/s, but joint .* slides; give m/s, or a "),
        ("right_inner_motor.range=-1cm:3deg", "given in rad, but joint .* slides; give m, or a "),
        ("right_outer_motor.torque=1kN", "given in N, but joint .* turns; give N·m, or a pattern"),
        ("*_motor.speed=1m/s", "given in m/s, but joint 'left_outer_motor' turns; give rad/s, or"),
    ],
)
def test_units_of_a_limit_are_those_of_its_joints(limit, said):
    """From the command line as from a file of choices."""
    (joints, what), values = limit.split("=")[0].rsplit(".", 1), limit.split("=")[1].split(":")
    names = ("lower", "upper") if what == "range" else (what,)
    lines = [f'{name} = "{value}"' for name, value in zip(names, values, strict=True)]
    table = "\n".join(["[[limits]]", f'joints = "{joints}"', *lines])
    for choices in (ImportOptions(limits=(limit_of(limit),)), choices_from_toml(table)):
        with pytest.raises(RobotError, match=said):
            Robot.from_urdf(parallel_ankles(sliding=("inner",), narrow=True), choices=choices)


def test_every_setting_says_what_it_is():
    for section in SCHEMA.values():
        for one in section.values():
            assert one.help.endswith((".", "'*knee*=0.02'.")), one.name
            said = one.unit or one.metavar or one.name == "tolerance"
            assert one.kind != "number" or said, one.name


def test_every_option_takes_the_unit_that_it_shows():
    own = [vars(command_options)[name] for name in dir(command_options) if "Options" in name]
    known = [one for section in SCHEMA.values() for one in section.values()]
    known += [one for kind in own for one in declared(kind)]
    shown = {one.unit for one in known if one.unit} - {SINE, SLOPE, "cost/m²"}
    assert {"Hz", "m/s²", "W", "s"} <= shown
    for unit in shown:
        assert read_quantity(f"2{unit}", unit) == read_quantity(f"2 {unit}", unit) == 2.0


def test_a_quantity_is_held_at_a_value_with_its_unit(quick):
    fix = SCHEMA["geometry"]["fix"].read_pairs(["pelvis_roll=3deg", "foot_spacing=-15cm"])
    request = make_request({"fix": fix}, None)
    held = {q.name: q.value for q in request.task.geometry}
    assert held["pelvis_roll"] == pytest.approx(math.radians(3.0))
    assert held["foot_spacing"] == pytest.approx(-0.15)
    refused = quick("--fix", "pelvis_roll=3mm")
    assert refused.exit_code == 2
    assert "--fix pelvis_roll=3mm: give a number in rad, if you like" in refused.stderr


def test_the_command_takes_them(quick, cli, tmp_path):
    done = quick("--speed", "3.6km/h", "--speed-limit", "95rpm", "-q", "-o", tmp_path)
    assert done.exit_code == 0
    task = load_gait(tmp_path / "gait.npz").meta["task"]
    assert task["speed"] == pytest.approx(1.0)
    assert task["margins"]["speed_limit"] == pytest.approx(95.0 * math.pi / 30.0)
    refused = cli("optimise", "--trunk-roll", "8rpm")
    assert refused.exit_code == 2
    assert "rad, deg" in refused.stderr
