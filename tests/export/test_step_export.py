import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.errors import InputError
from gaitopt.motions.export import cubic_pieces, export, stride_samples


def table(path):
    with path.open(newline="") as stream:
        header, *rows = csv.reader(stream)
    return header, np.array(rows, dtype=float)


def test_the_table_holds_every_sample_to_the_last_digit(tmp_path):
    gait = sample_gait()
    header, rows = table(export(gait, tmp_path / "gait.csv"))
    assert rows.shape == (31, 2 + 48 + 8)
    assert np.array_equal(rows[:, header.index("time [s]")], gait.time)
    assert np.array_equal(rows[:, header.index("left_knee q [rad]")], gait.q[:, 9])
    assert np.array_equal(rows[:, header.index("right_hip_pitch dq [rad/s]")], gait.dq[:, 3])
    assert np.array_equal(rows[:, header.index("left_hip_yaw ddq [rad/s2]")], gait.ddq[:, 6])
    assert np.array_equal(rows[:, header.index("right_knee torque [N.m]")], gait.torque[:, 2])
    assert np.array_equal(rows[:, header.index("moment_y [N.m]")], gait.ground_wrench[:, 4])
    assert np.array_equal(rows[:, header.index("cop_y [m]")], gait.cop[:, 1])


def test_a_stride_is_the_step_and_its_mirror_image(tmp_path):
    gait = sample_gait()
    header, rows = table(export(gait, tmp_path / "gait.csv", both_legs=True))
    assert rows.shape[0] == 62
    assert rows[-1, 0] == pytest.approx(0.8)
    right, left = header.index("right_knee q [rad]"), header.index("left_knee q [rad]")
    assert rows[31:, right] == pytest.approx(rows[:31, left], abs=1e-15)
    right, left = header.index("right_hip_roll q [rad]"), header.index("left_hip_roll q [rad]")
    assert rows[31:, right] == pytest.approx(-rows[:31, left], abs=1e-15)
    whole = stride_samples(gait, both_legs=True)
    assert whole["q"][31] == pytest.approx(whole["q"][30], abs=1e-12)
    assert np.bincount(whole["step"]).tolist() == [31, 31]


def test_wrench_and_cop_of_a_stride_agree_in_both_steps():
    whole = stride_samples(sample_gait(), both_legs=True)
    fz, mx, my = (
        whole["ground_wrench"][:, 2],
        whole["ground_wrench"][:, 3],
        whole["ground_wrench"][:, 4],
    )
    assert -my / fz == pytest.approx(whole["cop"][:, 0], abs=1e-9)
    assert mx / fz == pytest.approx(whole["cop"][:, 1], abs=1e-9)
    assert whole["cop"][31:, 1] == pytest.approx(-whole["cop"][:31, 1])


def evaluated(pieces, knots, t):
    k = np.clip(np.searchsorted(knots, t, side="right") - 1, 0, len(knots) - 2)
    return np.einsum("nic,nc->ni", pieces[k], (t - knots[k])[:, None] ** np.arange(4))


def test_the_pieces_are_the_motion_and_smooth_at_the_knots():
    gait = sample_gait()
    pieces = cubic_pieces(gait)
    assert evaluated(pieces, gait.knots, gait.time) == pytest.approx(gait.q, abs=1e-10)
    h = np.diff(gait.knots)[0]
    for order in range(3):  # angle, rate and acceleration from the left and from the right
        powers = np.array([np.polyder(c[::-1], order) for c in pieces[0]])
        left = np.array([np.polyval(c, h) for c in powers])
        right = np.array([np.polyval(np.polyder(c[::-1], order), 0.0) for c in pieces[1]])
        assert left == pytest.approx(right, abs=1e-7 * 30.0**order)


def test_pieces_need_no_samples_between_their_knots():
    gait = sample_gait()
    coarse = replace(
        gait, **{n: getattr(gait, n)[::15] for n in ("time", "q", "dq", "ddq", "torque")},
        **{n: getattr(gait, n)[::15] for n in ("ground_wrench", "cop", "swing_sole")},
    )  # fmt: skip
    assert len(coarse.time) == 3
    assert np.array_equal(cubic_pieces(coarse), cubic_pieces(gait))


@pytest.mark.parametrize("suffix", [".json", ".yaml", ".YML"])
def test_a_controller_finds_joints_splines_and_impact(tmp_path, suffix):
    gait = sample_gait()
    path = export(gait, tmp_path / f"gait{suffix}", both_legs=True)
    content = json.loads(path.read_text(encoding="utf-8"))
    assert content["joints"]["left_knee"]["q"][:31] == gait.q[:, 9].tolist()
    assert content["standing_foot_of_step"] == ["right_sole", "left_sole"]
    knee = np.array(content["splines"]["coefficients"]["left_knee"])
    assert knee.shape == (2, 3, 4)
    assert knee[0, 0, 0] == pytest.approx(gait.q[0, 9])
    assert knee[1, 0, 0] == pytest.approx(gait.q[0, 2])  # the other knee's motion
    assert knee[1, 0, 1] == pytest.approx(gait.dq[0, 2])
    impact = content["impact"]
    assert impact["rates"]["jump"]["right_knee"] == gait.rate_after[2] - gait.rate_before[2]
    assert impact["impulse_in_landing_sole"]["linear_z"] == gait.impulse[2]
    assert content["meta"]["task"]["speed"] == 1.0


def test_small_numbers_are_numbers_for_every_reader(tmp_path):
    gait = replace(sample_gait(), meta={"cost": -3e-07, "status": 'said "1e-07", 2e-07'})
    text = export(gait, tmp_path / "gait.yaml").read_text(encoding="utf-8")
    assert '"cost": -3.0e-07' in text  # YAML 1.1 asks for the point
    assert json.loads(text)["meta"] == gait.meta


def test_an_unknown_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"the suffix must be one of \.csv, \.json"):
        export(sample_gait(), tmp_path / "gait.xlsx")
    with pytest.raises(InputError, match="cannot write"):
        export(sample_gait(), tmp_path / "no" / "gait.csv")
