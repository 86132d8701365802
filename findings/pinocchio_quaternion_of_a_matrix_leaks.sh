#!/usr/bin/env bash
# Version:  pin 4.1.0
# Does:     pin.Quaternion(R), made of a rotation matrix, never gives its memory back: 80 bytes each.
#           Made of four numbers or of two vectors it does, and so do SE3, Motion and exp.
# Guess:    a temporary object is gone when nothing refers to it.
# Means:    whoever writes quaternions of every body at every instant, as an exporter, a viewer or a
#           controller does, grows by megabytes a minute: 13 bodies at 400 Hz by 1.5 GB an hour.
#           Python's own counters show nothing. SE3ToXYZQUAT(SE3(R, t)) gives the same and leaks not.
# Seen:     bytes a call: of a matrix 80, of four numbers 0, SE3ToXYZQUAT 0
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pin==4.1.0
"$work/env/bin/python" - <<'PY'
import gc
import re
from pathlib import Path

import numpy as np
import pinocchio as pin


def resident():
    return 1024 * int(re.search(r"VmRSS:\s+(\d+)", Path("/proc/self/status").read_text())[1])


def grows(make, count=200_000):
    for _ in range(1000):
        make()
    gc.collect()
    before = resident()
    for _ in range(count):
        make()
    gc.collect()
    return (resident() - before) / count


turn, zero = np.eye(3), np.zeros(3)
found = {
    "of a matrix": grows(lambda: pin.Quaternion(turn)),
    "of four numbers": grows(lambda: pin.Quaternion(1.0, 0.0, 0.0, 0.0)),
    "SE3ToXYZQUAT": grows(lambda: pin.SE3ToXYZQUAT(pin.SE3(turn, zero))),
}
print("bytes a call:", ", ".join(f"{name} {value:.0f}" for name, value in found.items()))
assert found["of a matrix"] > 40.0
assert found["of four numbers"] < 4.0 and found["SE3ToXYZQUAT"] < 4.0
PY
