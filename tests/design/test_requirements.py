"""What gaits require of motors: against hand-computed loops and the samples of a real gait."""

import numpy as np
import pytest
from sample_gait import JOINT_NAMES, sample_gait
from scipy.integrate import trapezoid

from gaitopt.design.requirements import (
    FIGURES,
    MotorLoop,
    motor_loops,
    requirement,
    requirements,
    requirements_of,
    worst_case,
)
from gaitopt.errors import InputError


def loop(torque=40.0, rate=3.0, name="knee"):
    """Torque A cos(wt) and rate B sin(wt + 0.5): everything is known in closed form."""
    time = np.linspace(0.0, 1.0, 100_001)
    phase = 2.0 * np.pi * time
    return MotorLoop(
        name,
        f"right_{name}",
        time,
        torque * np.cos(phase),
        rate * np.sin(phase + 0.5),
        np.zeros_like(time),
    )


def test_figures_of_a_loop_known_in_closed_form():
    found = requirement(loop(), "walk")
    assert (found.motor, found.gait) == ("knee", "walk")
    assert found.peak_torque == pytest.approx(40.0)
    assert found.speed_at_peak_torque == pytest.approx(3.0 * np.sin(0.5))
    assert found.peak_speed == pytest.approx(3.0)
    assert found.torque_at_peak_speed == pytest.approx(40.0 * np.sin(0.5), rel=1e-4)
    assert found.rms_torque == pytest.approx(40.0 / np.sqrt(2.0))
    # A cos(a) B sin(a + 0.5) = A B / 2 (sin(2 a + 0.5) + sin(0.5))
    assert found.peak_power == pytest.approx(60.0 * (1.0 + np.sin(0.5)))
    assert found.regenerated_power == pytest.approx(60.0 * (1.0 - np.sin(0.5)))
    assert found.duty == pytest.approx(2.0 / 3.0, rel=1e-4)  # |cos| above a half


def test_loops_pass_through_the_samples_of_both_joints():
    gait = sample_gait()
    loops = {one.motor: one for one in motor_loops(gait)}
    assert list(loops) == ["hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"]
    for motor, sign in (("knee", 1.0), ("hip_roll", -1.0)):
        right, left = (JOINT_NAMES.index(f"{side}_{motor}") for side in ("right", "left"))
        of = loops[motor.replace("_", " ")]
        inside = slice(1, -1)  # the ends are where rates jump
        half = len(of.time) // 2
        times = gait.time[inside]
        pairs = ((of.torque, gait.torque), (of.rate, gait.dq), (of.acceleration, gait.ddq))
        for found, known in pairs:
            near = 1e-6 * np.abs(known[:, [right, left]]).max()
            first = np.interp(times, of.time[:half], found[:half])
            second = np.interp(gait.duration + times, of.time[half:], found[half:])
            assert first == pytest.approx(known[inside, right], abs=near)
            assert second == pytest.approx(sign * known[inside, left], abs=near)


def test_the_sign_of_the_power_is_that_of_the_motion():
    gait = sample_gait()
    power = {one.motor: one.mean(one.power) for one in motor_loops(gait)}
    columns = [JOINT_NAMES.index(f"{side}_knee") for side in ("right", "left")]
    samples = (gait.torque * gait.dq)[:, columns].sum(axis=1)
    mean = trapezoid(samples, gait.time) / (2.0 * gait.duration)
    assert abs(mean) > 1.0
    assert power["knee"] == pytest.approx(mean, rel=0.05)


def test_the_worst_of_a_set_and_the_gait_that_decides():
    found = worst_case(requirements_of({"slow": [loop(60.0, 2.0)], "fast": [loop(40.0, 5.0)]}))
    (knee,) = found
    assert knee.values["peak_torque"] == pytest.approx(60.0)
    assert knee.gaits["peak_torque"] == "slow"
    # what goes with a peak is of the gait of the peak
    assert knee.values["speed_at_peak_torque"] == pytest.approx(2.0 * np.sin(0.5))
    assert knee.gaits["speed_at_peak_torque"] == "slow"
    assert knee.values["torque_at_peak_speed"] == pytest.approx(40.0 * np.sin(0.5), rel=1e-4)
    assert knee.gaits["peak_power"] == "fast"
    assert set(knee.values) == set(knee.gaits) == set(FIGURES)


def test_gaits_that_do_not_belong_together_are_refused():
    with pytest.raises(InputError, match="no gait to take requirements from"):
        requirements({})
    with pytest.raises(InputError, match=r"move different joints.*--against"):
        requirements_of({"a": [loop()], "b": [loop(name="elbow")]})
