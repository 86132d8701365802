"""The figures of a gait, against the gait's own arrays and known answers."""

import json
from dataclasses import replace

import numpy as np
import pytest
from sample_gait import bare_gait, sample_gait

from gaitopt.design.summary import summarise
from gaitopt.model.sole import centre_of_pressure

JOINTS = ["hip yaw", "hip roll", "hip pitch", "knee", "ankle pitch", "ankle roll"]


@pytest.fixture(scope="module")
def facts():
    return summarise(sample_gait())


def test_is_json(facts):
    assert json.loads(json.dumps(facts, allow_nan=False)) == facts


def test_joints_from_hip_to_ankle_stance_before_swing(facts):
    assert [j["joint"] for j in facts["joints"][::2]] == JOINTS
    assert [j["name"] for j in facts["joints"][4:6]] == ["right_hip_pitch", "left_hip_pitch"]
    assert [j["leg"] for j in facts["joints"]] == ["stance", "swing"] * 6


def test_joint_of_known_motion():
    gait = sample_gait()
    torque, dq = np.zeros_like(gait.torque), np.zeros_like(gait.dq)
    s = gait.time / gait.duration
    torque[:, 2] = -30.0 * s  # right knee: peak 30, effective 30 / sqrt(3)
    dq[:, 2] = 4.0 * (1.0 - s)
    facts = summarise(replace(gait, torque=torque, dq=dq))
    knee = next(j for j in facts["joints"] if j["name"] == "right_knee")
    assert knee["peak_torque_Nm"] == pytest.approx(30.0)
    assert knee["rms_torque_Nm"] == pytest.approx(30.0 / np.sqrt(3.0), rel=1e-3)
    assert knee["torque_used"] == pytest.approx(0.2)
    assert knee["speed_used"] == pytest.approx(0.4)
    assert knee["peak_power_W"] == pytest.approx(30.0, rel=1e-2)  # 120 s (1 - s) at s = 1/2
    # the integral of 120 s (1 - s) over 0.4 s
    assert facts["walk"]["mechanical_work_per_step_J"] == pytest.approx(8.0, rel=1e-2)
    assert facts["walk"]["mechanical_cost_of_transport"] == pytest.approx(
        8.0 / (56.87 * 9.81 * 0.4), rel=1e-2
    )
    # one motor does stance and swing: the swing knee rests
    motor = next(m for m in facts["motors"] if m["joint"] == "knee")
    assert motor["peak_torque_Nm"] == pytest.approx(30.0)
    assert motor["rms_torque_Nm"] == pytest.approx(30.0 / np.sqrt(6.0), rel=1e-3)


def test_contact_of_known_wrench():
    gait = sample_gait()
    cop = np.tile([-0.1, 0.01], (len(gait.time), 1))
    cop[3] = [-0.02, 0.03]
    wrench = np.tile([30.0, 40.0, 500.0, 0.0, 0.0, 0.0], (len(gait.time), 1))
    wrench[5, 2] = 200.0
    contact = summarise(replace(gait, cop=cop, ground_wrench=wrench))["contact"]
    expected = {"front": 20.0, "rear": 114.0, "left": 38.0, "right": 78.0}
    assert contact["cop_to_edge_mm"] == pytest.approx(expected)
    assert contact["friction_used"] == pytest.approx(0.25)
    assert contact["least_vertical_force_N"] == pytest.approx(200.0)
    assert contact["largest_vertical_force_N"] == pytest.approx(500.0)


def test_foot_that_pulls_has_no_friction_to_speak_of():
    wrench = np.array(sample_gait().ground_wrench)
    wrench[4, 2] = -1.5
    contact = summarise(replace(sample_gait(), ground_wrench=wrench))["contact"]
    assert contact["friction_used"] is None
    assert contact["least_vertical_force_N"] == -1.5


def test_impact_of_known_impulse():
    impulse = np.array([3.0, 4.0, 20.0, 0.5, 2.0, 0.0])
    facts = summarise(replace(sample_gait(), impulse=impulse))["impact"]
    assert facts["horizontal_impulse_Ns"] == pytest.approx(5.0)
    assert facts["friction_used"] == pytest.approx(0.25)
    expected = {"front": 100.0, "rear": 114.0, "left": 43.0, "right": 93.0}
    assert facts["cop_to_edge_mm"] == pytest.approx(expected)


def test_impulse_that_pulls_has_no_centre_of_pressure():
    impulse = np.array([0.0, 0.0, -2.0, 0.0, 0.0, 0.0])
    facts = summarise(replace(sample_gait(), impulse=impulse))["impact"]
    assert facts["vertical_impulse_Ns"] == -2.0
    assert facts["cop_to_edge_mm"] is None
    assert facts["friction_used"] is None


def test_centre_of_pressure_is_the_gaits_own():
    gait = sample_gait()
    assert centre_of_pressure(gait.ground_wrench) == pytest.approx(gait.cop, rel=1e-9)


def test_gait_with_nothing_recorded():
    facts = summarise(bare_gait())
    assert facts["walk"]["cost_N2ms"] is None
    assert facts["contact"]["cop_to_edge_mm"] is None
    assert facts["joints"][0]["torque_used"] is None
    assert facts["walk"]["speed_m_per_s"] == pytest.approx(1.0)


def test_designed_gait_records_its_proof(refined_design):
    facts = summarise(refined_design.gait)
    assert facts["certificate"]["certified"] is True
    assert facts["certificate"]["referee"]["weight"] == pytest.approx(56.87 * 9.81 * 0.4)
    assert facts["solver"]["iterations"] == refined_design.solution.iterations
    assert facts["impact"]["friction_used"] == pytest.approx(0.7, abs=1e-3)
