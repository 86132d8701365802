#!/usr/bin/env bash
# Version:  interpax 0.3.16 with jax 0.10.2, scipy 1.17.1 to compare
# Does:     Interpolator1D(..., method="cubic2", period=1), "C2 cubic splines (aka natural splines)", of a periodic function:
#           values and slopes go round, the second derivative jumps at the seam, a little at the last sample and nowhere else. It is a spline
#           through the samples with a few of them repeated at both ends and not-a-knot conditions beyond, not the periodic one;
#           without a period it is SciPy's not-a-knot spline to rounding, not the natural one.
# Guess:    C2 and a period together mean a second derivative that goes round, as CubicSpline(bc_type="periodic") has it.
# Means:    a gait cycle in JAX has an acceleration that jumps once a stride, wherever its phase zero is put (heel strike, as
#           a rule), so torques jump, and a spike comes out of whatever differences them; the error is there nearly
#           three times, that of the slope four times that of the periodic spline. interpax.CubicSpline(..., bc_type="periodic")
#           is right. No report was found.
# Seen:     0.5 + 0.4 sin, twelve samples a stride: second derivative jumps by 0.93 rad at the seam (largest 15.8), by 0.0045 at
#           the last sample, 2e-5 at the others; error 2.2e-4 for 0.8e-4 rad, slope 0.0120 for 0.0030; the jump of
#           CubicSpline of either library 2e-5
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check interpax==0.3.16 jax==0.10.2 jaxlib==0.10.2 \
  scipy==1.17.1 numpy==2.4.6
cd "$work"
JAX_PLATFORMS=cpu "$work/env/bin/python" - <<'PY'
import interpax
import jax
import numpy as np
from scipy.interpolate import CubicSpline

jax.config.update("jax_enable_x64", True)
count, after = 12, 1e-7
t = np.arange(count) / count


def knee(s, rate=False):
    turn = 2 * np.pi * s + 0.7
    return 0.8 * np.pi * np.cos(turn) if rate else 0.5 + 0.4 * np.sin(turn)


closed = np.append(t, 1.0), np.append(knee(t), knee(0.0))
seamed = interpax.Interpolator1D(t, knee(t), method="cubic2", period=1.0)
scipys = CubicSpline(*closed, bc_type="periodic")
interpaxs = interpax.CubicSpline(*closed, bc_type="periodic")


def jump(curve, at, order):
    return float(curve((at + after) % 1.0, order) - curve((at - after) % 1.0, order))


def of(s, order):
    return seamed(np.atleast_1d(s), dx=order)[0]


for name, curve in (("cubic2", of), ("CubicSpline of interpax", interpaxs), ("CubicSpline of SciPy", scipys)):
    at_seam = [jump(curve, 0.0, order) for order in range(3)]
    elsewhere = max(abs(jump(curve, s, 2)) for s in t[1:-1])
    print(f"{name}: at the seam value, slope, second derivative jump by {np.round(at_seam, 6)}, "
          f"second at the last sample {jump(curve, t[-1], 2):.1e}, at others {elsewhere:.1e}")
    assert abs(at_seam[0]) < 1e-5 and abs(at_seam[1]) < 1e-4 and elsewhere < 1e-3
    assert (abs(at_seam[2]) > 0.9) if curve is of else (abs(at_seam[2]) < 1e-3), name

s = np.linspace(0, 1, 2001)
value = abs(np.asarray(seamed(s)) - knee(s)).max(), abs(scipys(s) - knee(s)).max()
slope = abs(np.asarray(seamed(s, dx=1)) - knee(s, True)).max(), abs(scipys(s, 1) - knee(s, True)).max()
print(f"off by {value[0]:.1e} and {value[1]:.1e}, slope by {slope[0]:.4f} and {slope[1]:.4f}")
assert value[0] > 2.5 * value[1] and slope[0] > 3.5 * slope[1]

uneven = np.sort(np.r_[0.0, np.random.default_rng(0).uniform(0, 1, 9), 1.0])
plain = np.asarray(interpax.Interpolator1D(uneven, knee(uneven), method="cubic2")(s))
ends = {ends: abs(plain - CubicSpline(uneven, knee(uneven), bc_type=ends)(s)).max() for ends in ("not-a-knot", "natural")}
print("without a period off SciPy's", {name: float(f"{off:.1e}") for name, off in ends.items()})
assert ends["not-a-knot"] < 1e-12 and ends["natural"] > 1e-4
PY
