"""Sizing: against motors computed by hand, certified gaits, refusals."""

import numpy as np
import pytest
from places import EXAMPLES

from gaitopt.actuators.motors import read_motors
from gaitopt.design.design import design
from gaitopt.design.options import DesignOptions
from gaitopt.design.requirements import motor_loops, motor_uses
from gaitopt.design.sizing import AIMS, Catalogue, chosen, read_catalogue, size, table_of
from gaitopt.errors import InputError, SpecError, StoppedError
from gaitopt.gait.gait_file import load_gait, save_gait
from gaitopt.gait.presets import preset_task
from gaitopt.solvers import solver_by_name

FILE = EXAMPLES / "catalogue.toml"
QUICK = DesignOptions(solver=solver_by_name("sqp"))


@pytest.fixture(scope="module")
def gaits(robot):
    found = {}
    for speed in (0.6, 0.9):
        task = preset_task(speed=speed, samples=21)
        found[f"{speed:g} m/s"] = design(robot, task, QUICK).gait
    return found


@pytest.fixture(scope="module")
def catalogue():
    return read_catalogue(FILE)


@pytest.mark.parametrize("aim", AIMS)
def test_the_best_of_all_motors_and_ratios(gaits, catalogue, aim):
    """Every motor at every ratio, judged as `requirements --motors` does."""
    choices = chosen(gaits, catalogue, aim)
    assert len(choices) == 6
    knee = next(one for one in choices if one.motor == "knee")
    assert set(knee.joints) == {"right_knee", "left_knee"}
    fit = []
    for motor in catalogue.motors.values():
        for ratio in catalogue.ratios:
            from gaitopt.actuators.motors import Drive, MotorTable

            drive = Drive("*", motor, ratio, catalogue.efficiency, catalogue.friction)
            table = MotorTable((drive,))
            loops = {label: motor_loops(gait, table) for label, gait in gaits.items()}
            uses = [one for one in motor_uses(loops, table) if one.motor == "knee"]
            shares = [max(one.peak_share, one.rms_share, one.voltage_share) for one in uses]
            if 1.1 * max(shares) <= 1.0:
                loss = float(np.mean([one.copper_loss for one in uses]))
                worth = (motor.mass, loss) if aim == "mass" else (loss, motor.mass)
                fit.append((worth, motor.name, ratio))
    worth, name, ratio = min(fit)
    assert (knee.drive.motor.name, knee.drive.ratio) == (name, ratio)
    assert knee.loss == pytest.approx(worth[1] if aim == "mass" else worth[0], rel=1e-9)


def test_a_search_that_is_stopped_blames_no_motor(gaits, catalogue):
    """Stopped at any time: before there is a walk, and with one that is not done."""
    for allowed in (0, 5, 40):
        asked = iter(range(allowed))
        with pytest.raises(StoppedError, match=r"^interrupted before there was a result$"):
            size(gaits, catalogue, QUICK, stop=lambda asked=asked: next(asked, None) is None)


def test_gaits_are_designed_again_and_certified(gaits, catalogue, tmp_path):
    from gaitopt.cli.motors import motors_text

    found = size(gaits, catalogue, QUICK)
    assert found.settled
    assert set(found.gaits) == set(gaits)
    path = tmp_path / "motors.toml"
    path.write_text(motors_text(found.table, "size"), encoding="utf-8")
    table = read_motors(path)
    assert [d.ratio for d in table.drives] == [d.ratio for d in table_of(found.choices).drives]
    assert found.mass == pytest.approx(sum(d.motor.mass for d in table.drives))
    for gait in found.gaits.values():
        assert gait.fact("certificate", "certified") is True
        again = load_gait(save_gait(gait, tmp_path / "gait.npz"))
        for use in motor_uses({"": motor_loops(again, table)}, table):
            choice = next(one for one in found.choices if one.motor == use.motor)
            assert use.rms_share <= choice.rms_share * (1.0 + 1e-9) <= 1.0
            assert use.peak_share <= choice.peak_share * (1.0 + 1e-9) <= 1.0 + 1e-6


def test_ratios_are_free_where_none_are_given(gaits, catalogue):
    free = Catalogue(catalogue.motors, (), catalogue.efficiency, catalogue.friction)
    for own, listed in zip(chosen(gaits, free, "loss"), chosen(gaits, catalogue, "loss"),
                           strict=True):  # fmt: skip
        assert own.loss <= listed.loss * 1.001


def test_what_cannot_serve_is_refused(gaits, catalogue):
    small = Catalogue({"small": catalogue.motors["small"]}, (1.0, 2.0))
    with pytest.raises(InputError, match=r"serves the hip yaw|comes near"):
        chosen(gaits, small)
    with pytest.raises(InputError, match="give mass or loss"):
        chosen(gaits, catalogue, "price")


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (("resistance = 0.12", "resistance = -0.12"), "resistance is -0.12"),
        (("no_load_speed = 760.0", "no_load_speed = 7257.0"), "check the units"),
        (("ratios = [4", "ratios = [-4"), "ratio is -4"),
        (("efficiency = 0.9", "efficiency = 90"), "must be a share"),
        (("friction = 0.3", 'friction = "0.3kg"'), "friction"),
        (("[gear]", "[gears]"), "did you mean 'gear'"),
        (("mass = 0.35\n", ""), "mass is missing"),
        (("peak_current = 45.0", "peak_current = 4500.0"), "cannot flow"),
    ],
)
def test_bad_catalogues_are_refused(tmp_path, edit, told):
    text = FILE.read_text("utf-8")
    assert edit[0] in text
    path = tmp_path / "catalogue.toml"
    path.write_text(text.replace(*edit, 1), encoding="utf-8")
    with pytest.raises(SpecError, match=told):
        read_catalogue(path)
