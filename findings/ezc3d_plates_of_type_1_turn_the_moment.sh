#!/usr/bin/env bash
# Version:  ezc3d 1.7.2, kineticstoolkit 0.17.0
# Does:     the same step on the same plate, written to C3D as a plate of type 1 (force, centre of pressure,
#           free moment) and of types 2, 3 and 4, comes back with one force, one centre of pressure and one
#           free moment, but with type 1 the moment about the plate's centre has the other sign.
#           Kinetics Toolkit hands it on as MomentAtCenter.
# Guess:    the type says how a plate measures; what is given in laboratory axes is the same wrench.
# Means:    inverse dynamics fed with force and moment of a type 1 plate turns the shank the wrong way:
#           70 N·m here, half of what an ankle gives. Take centre of pressure, force and Tz, or check
#           that moment = (centre of pressure - centre of plate) x force + Tz.
# Seen:     moment (-70, 42, -7.8) N·m of types 2, 3 and 4, which is that of the step, (70, -42, 7.8) of
#           type 1; centre of pressure (1.06, 2.1, 0) m, force and Tz of all four alike
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check ezc3d==1.7.2 kineticstoolkit==0.17.0
cd "$work"
"$work/env/bin/python" - <<'PY'
import ezc3d
import kineticstoolkit as ktk
import numpy as np

CENTRE = np.array([1000.0, 2000.0, 0.0])  # of the top surface, in the laboratory [mm]
TURN = np.diag([1.0, -1.0, -1.0])  # axes of the plate, whose z points down, in the laboratory
PLACE = np.array([60.0, 100.0, 0.0])  # of the step from the centre [mm]
FORCE = np.array([50.0, -30.0, -700.0])  # of the foot on the plate [N]
FREE = np.array([0.0, 0.0, -1000.0])  # free moment [N mm]
DEPTH = np.array([0.0, 0.0, -20.0])  # from the sensors to the top surface, in plate axes [mm]
A, B = 120.0, 200.0  # half distances of the sensors of type 3 [mm]

force, place = TURN.T @ FORCE, TURN.T @ PLACE
six = np.r_[force, np.cross(place + DEPTH, force) + TURN.T @ FREE]
# What the eight sensors of type 3 add up to: three forces, three moments about their centre.
sums = np.array([
    [1, 1, 0, 0, 0, 0, 0, 0], [0, 0, 1, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 1, 1, 1],
    [0, 0, 0, 0, B, B, -B, -B], [0, 0, 0, 0, -A, A, A, -A], [-B, B, A, -A, 0, 0, 0, 0],
])
mixing = np.eye(6) + 0.1 * np.tri(6)
signals = {
    1: (np.r_[force, place[:2], (TURN.T @ FREE)[2]], np.zeros(3)),
    2: (six, DEPTH),
    3: (np.linalg.pinv(sums) @ six, DEPTH + [A, B, 0.0]),
    4: (np.linalg.solve(mixing, six), DEPTH),
}
quadrants = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) * [200.0, 300.0, 0.0]


def write(kind):
    values, origin = signals[kind]
    file = ezc3d.c3d()
    parameters = file["parameters"]
    parameters["POINT"]["RATE"]["value"] = [100.0]
    parameters["POINT"]["UNITS"]["value"] = ["mm"]
    parameters["POINT"]["LABELS"]["value"] = ["marker"]
    parameters["ANALOG"]["RATE"]["value"] = [100.0]
    parameters["ANALOG"]["LABELS"]["value"] = [f"channel{k}" for k in range(len(values))]
    file["data"]["points"] = np.ones((4, 1, 5))
    file["data"]["analogs"] = np.tile(values[:, None], (1, 1, 5))
    plate = {
        "TYPE": (2, [kind]), "ZERO": (2, [0, 0]),
        "CHANNEL": (2, np.arange(1, len(values) + 1)[:, None]),
        "CORNERS": (4, (CENTRE + quadrants @ TURN.T).T[:, :, None]), "ORIGIN": (4, origin[:, None]),
    }
    if kind == 4:
        plate["CAL_MATRIX"] = (4, mixing[:, :, None])
    parameters["FORCE_PLATFORM"]["USED"]["value"] = [1]
    for name, (number, value) in plate.items():
        parameters["FORCE_PLATFORM"][name] = {
            "type": number, "value": value, "description": "", "is_locked": False,
        }
    file.write(f"type{kind}.c3d")


moment = (np.cross(PLACE, FORCE) + FREE) / 1000
print("of the step: moment about the centre", moment, "N·m")
for kind in signals:
    write(kind)
    plate = ezc3d.c3d(f"type{kind}.c3d", extract_forceplat_data=True)["data"]["platform"][0]
    at = {key: plate[key][:, 0] for key in ("force", "moment", "center_of_pressure", "Tz")}
    toolkit = ktk.read_c3d(f"type{kind}.c3d", convert_point_unit=True)["ForcePlatforms"].data
    handed_on = toolkit["FP0_MomentAtCenter"][0, :3]
    print(f"type {kind}: moment {at['moment'].round(1) / 1000}, handed on {handed_on.round(4)}, "
          f"centre of pressure {at['center_of_pressure'].round(2)}, force {at['force'].round(2)}, "
          f"Tz {at['Tz'].round(1)}")
    sign = -1 if kind == 1 else 1
    assert np.allclose(at["moment"] / 1000, sign * moment, atol=1e-3)
    assert np.allclose(handed_on, sign * moment, atol=1e-3)
    assert np.allclose(at["center_of_pressure"], CENTRE + PLACE, atol=1e-2)
    assert np.allclose(at["force"], FORCE, atol=1e-2)
    assert np.allclose(at["Tz"], FREE, atol=1e-1)
PY
