"""An option that would have no effect is refused, with what it needs; with that it acts."""

import re
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from places import EXAMPLES
from synthetic_bipeds import ARM, SIX, biped_urdf

from gaitopt.cli.config import SCHEMA
from gaitopt.cli.idle import NEEDS
from gaitopt.cli.request import make_request
from gaitopt.errors import IdleOptionError, InputError
from gaitopt.gait.initial_guess import first_guess
from gaitopt.gait.problem import WalkProblem

VALUES = {
    "preset": "paper", "speed": 0.9, "lateral_speed": 0.1, "turn_rate": 0.1, "postures": 3,
    "samples": 41, "quadrature": "euler", "speed_as": "penalty", "boundary": "lifted",
    "toe_off": 0.7, "heel_strike": 0.2, "foot_flat": "impact", "double_support": 0.05,
    "touch_down": "impact", "slope": 0.05, "cross_slope": 0.03, "stairs": 0.05,
    "leg_extension": 0.9, "cost": "work", "weights": {"*knee*": 2.0}, "free": ("pelvis_roll",),
    "fix": {"pelvis_roll": 0.03}, "urdf": EXAMPLES.parent / "tests/data/cases/base_mini.urdf",
    "set": {"shin": 0.33}, "limit": ("knee.torque=60",), "payload": ("10kg@torso",),
    "gravity": 3.0, "posture": "stand", "srdf": Path("none.srdf"), "sole": "0,-0.2,0.06,-0.06",
    "move": ("arms",), "motors": EXAMPLES / "motors.toml",
    "linkages": EXAMPLES / "linkages.toml", "armature": {"*": 0.01}, "solver": "slsqp",
    "starts": 3, "seed": 3, "max_iterations": 100, "qp_solver": "quadprog",
    "differences": "all", "approach": "relaxed", "toe_begin": "given", "phase_times": "best",
}  # fmt: skip
"""That say something else than the default does, of settings that are no number or flag."""
ELSEWHERE = {"robot", "spec", "choices", "plugin", "start"}
"""Settings that name a file or a robot, tested with what they read."""
SAME = {"package_dir", "forward", "stance_sole", "swing_sole", "without"}
"""Settings that may say of a robot what holds anyway."""


def value_of(setting) -> object:
    if setting.name in VALUES:
        return VALUES[setting.name]
    if setting.kind == "flag":
        return not setting.default
    return 0.9 * setting.default if setting.default else 0.07


def built(**settings) -> object:
    """What a request leads to: rows and cost at the first guess, bounds, method, first guess."""
    request = make_request(settings, None)
    problem = WalkProblem(request.robot, request.task)
    x = first_guess(problem)
    values, bounds = problem.values(x), problem.layout.bounds()
    parts = [x, values.rows, *bounds, problem.rows.lower, problem.rows.upper, request.start]
    numbers = [None if part is None else np.asarray(part).tolist() for part in parts]
    return numbers, values.cost, request.options, request.starts, request.noise, request.task.cost


@pytest.fixture(scope="module")
def usual() -> object:
    return built()


@pytest.mark.parametrize(
    "setting",
    [
        one
        for section in SCHEMA.values()
        for one in section.values()
        if one.name not in ELSEWHERE | SAME
    ],
    ids=lambda one: one.name,
)
def test_every_setting_acts_or_is_refused(setting, usual):
    with suppress(InputError):
        assert built(**{setting.name: value_of(setting)}) != usual


IDLE = [
    ("toe_strip", {}, {"toe_off": 0.7}),
    ("toe_begin", {}, {"toe_off": 0.7}),
    ("heel_strip", {}, {"heel_strike": 0.2}),
    ("foot_flat", {"foot_flat": "gentle"}, {"heel_strike": 0.2}),
    ("touch_down", {"touch_down": "gentle"}, {"double_support": 0.05}),
    ("phase_times", {}, {"double_support": 0.05}),
    ("phase_times", {"phase_times": "given"}, {"heel_strike": 0.2}),
    ("penalty_weight", {}, {"speed_as": "penalty"}),
    ("quadrature", {"cost": "peak-torque"}, {"cost": "work"}),
    ("quadrature", {"cost": "torque-rate"}, {"cost": "torque-rate + torque"}),
    ("nosing", {}, {"stairs": 0.05}),
    ("landing_impulse", {"soft_landing": True}, {"soft_landing": False}),
    ("landing_impulse", {"double_support": 0.05}, {"double_support": 0.05, "touch_down": "impact"}),
    ("impulse_cop", {"soft_landing": True}, {"soft_landing": False}),
    ("liftoff_speed", {"soft_landing": True}, {"soft_landing": False}),
]


@pytest.mark.parametrize(("name", "alone", "needed"), IDLE)
def test_what_acts_only_with_others_is_refused_without_them(name, alone, needed):
    setting = next(one[name] for one in SCHEMA.values() if name in one)
    given = {name: value_of(setting), **alone}
    option = name.replace("_", "-")
    with pytest.raises(IdleOptionError, match=f"-{option}.* has no effect here: it acts only "):
        make_request(given, None)
    make_request({**given, **needed}, None)
    make_request(given, None, varied=NEEDS[name].others)  # which a sweep may give


def test_a_gap_of_arms_needs_arms_that_move(tmp_path):
    robot = tmp_path / "robot.urdf"
    robot.write_text(biped_urdf(SIX, ARM, "yaw"))
    given = {"arm_gap": 0.02, "urdf": robot, "sole": "0.14,-0.07,0.05,-0.05"}
    for idle in ({"arm_gap": 0.02}, given, {**given, "move": ("waist",)}):
        with pytest.raises(IdleOptionError, match=r"--arm-gap 0.02 m has no effect .* --move arms"):
            make_request(idle, None)
    make_request({**given, "move": ("waist", "arms")}, None)


def test_a_limit_of_one_joint_and_one_of_all_exclude_each_other(tmp_path):
    config = tmp_path / "task.toml"
    config.write_text('[limits]\n"knee.torque" = 60\n')
    make_request({"torque_limit": 80.0}, config)  # the command line wins
    with pytest.raises(IdleOptionError, match="without --torque-limit 80, which is for every"):
        make_request({"torque_limit": 80.0, "limit": ("knee.torque=60",)}, None)
    with pytest.raises(IdleOptionError, match="without --speed-limit 5"):
        make_request({"speed_limit": 5.0, "limit": ("knee.speed=60rpm",)}, None)
    make_request({"speed_limit": 5.0, "limit": ("knee.torque=60",)}, None)


def test_free_and_fixed_contradict_each_other():
    both = {"free": ("pelvis_roll",), "fix": {"pelvis_roll": 0.02}}
    with pytest.raises(InputError, match=r"--free pelvis_roll and --fix pelvis_roll=0.02 "):
        make_request(both, None)


def test_a_file_may_hold_defaults_that_do_nothing(tmp_path):
    config = tmp_path / "task.toml"
    config.write_text("[task]\ntoe_strip = 0.01\n")
    make_request({}, config)
    config.write_text("[task]\ntoe_strip = 0.02\n")
    with pytest.raises(IdleOptionError, match=r"--toe-strip 0.02 m has no effect"):
        make_request({}, config)
    make_request({"toe_off": 0.7}, config)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["optimise", "--figures"], "--figures has no effect here: it acts only with --output DIR"),
        (["optimise", "--no-page"], "--no-page has no effect here: it acts only with --output DIR"),
        (["library", "none", "--output", "a.npz"], "--output .* only with --at NAME=VALUE"),
        (["library", "none", "--plugin", "a.py"], "--plugin .* only with --at NAME=VALUE"),
        (["library", "none", "--at", "speed=1", "--where", "speed>1"], "--where .* without --at"),
        (["library", "none", "--at", "speed=1", "--columns", "cost"], "--columns .* without --at"),
        (["library", "none", "--at", "speed=1", "--plot", "a.png"], "--plot .* without --at"),
        (
            ["library", "none", "--plot", "a.png", "--columns", "cost"],
            "--columns .* without --plot",
        ),
        (
            ["transition", "a.npz", "b.npz", "--stretch", "0.9", "-o", "c.npz"],
            "--stretch 0.9 .* only where the robot stands, with 'standing' at one end",
        ),
    ],
)
def test_options_of_one_command(cli, words, said):
    result = cli(*words)
    assert result.exit_code == 2
    assert re.search(said, " ".join(result.stderr.split()))
