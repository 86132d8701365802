#!/usr/bin/env bash
# Version:  pyomeca 2026.0.2 with numpy 2.4.6, xarray and SciPy (oracle) pinned below
# Does:     Angles.from_rototrans allocates the angles and fills them for the sequences that it knows. For "yxz", "xyx", "xzx",
#           "yxy" and "yzy" nothing is filled, and what the memory held is returned as angles. Nothing is said.
#           Rototrans.from_euler_angles builds the matrices of all of them rightly.
# Guess:    a sequence that one direction takes, the other takes too, or refuses, as the first refuses "abc".
# Means:    "yxz" (flexion, adduction, rotation where y points to the side) is the order of hip and knee in a
#           laboratory whose x points forward: joint angles of a recorded walk, and ranges taken from them, are chance, and
#           look like angles where the memory held some. Take SciPy's as_euler("YXZ"), or build the matrix again and compare.
# Seen:     200 turns of each sequence, angles of 0.1 to 1.0 rad: of the matrices rebuilt from the angles none is right for the
#           five, all are to 1e-9 for "zyz", "zxz" and every other order of x, y and z
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check pyomeca==2026.0.2 numpy==2.4.6 scipy==1.17.1 xarray==2026.9.0
"$work/env/bin/python" -W ignore - <<'PY'
import itertools

import numpy as np
from pyomeca import Angles, Rototrans
from scipy.spatial.transform import Rotation

draw = np.random.default_rng(0)
UNFILLED = ("yxz", "xyx", "xzx", "yxy", "yzy")
count = 200
for sequence in [*map("".join, itertools.permutations("xyz")), "zyz", "zxz", *UNFILLED[1:]]:
    given = draw.uniform(0.1, 1.0, size=(3, 1, count))
    turns = Rototrans.from_euler_angles(Angles(given), sequence)
    built = np.moveaxis(np.asarray(turns)[:3, :3], 2, 0)
    right = Rotation.from_euler(sequence.upper(), given[:, 0].T)
    assert np.abs(built - right.as_matrix()).max() < 1e-12  # the matrices are right

    read = np.asarray(Angles.from_rototrans(turns, sequence))[:, 0].T
    with np.errstate(all="ignore"):
        good = np.isfinite(read).all(axis=1) & (np.abs(read) < 1e3).all(axis=1)
    again = Rotation.from_euler(sequence.upper(), np.where(good[:, None], read, 0.0)).as_matrix()
    off = np.abs(again - built).max(axis=(1, 2))
    off[~good] = np.inf
    exact = int((off < 1e-9).sum())
    print(f"{sequence}: rebuilt {exact} of {count} matrices, first {given[:, 0, 0].round(3)} read as {read[0]}")
    assert (exact < 20) if sequence in UNFILLED else (exact == count), sequence
    assert np.abs(right.as_euler(sequence.upper()) - given[:, 0].T).max() < 1e-9  # they can be had
try:
    Rototrans.from_euler_angles(Angles(given), "abc")
except ValueError as refused:
    print(f'"abc" when building: {refused}')
else:
    raise AssertionError("abc is taken")
PY
