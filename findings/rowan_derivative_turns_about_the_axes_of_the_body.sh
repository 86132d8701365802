#!/usr/bin/env bash
# Version:  rowan 1.3.2
# Does:     rowan.calculus.derivative(q, v), documented as v q / 2, computes q v / 2: it takes v in the axes of the body.
#           rowan.calculus.integrate(q, v, dt), documented as exp(v dt / 2) q, is that: it takes v in the axes of the
#           world. So the two of one module, of the same q and v, are rates of two motions. Nothing says which
#           axes are meant; the example has q = 1, where both agree.
# Guess:    derivative is the slope of integrate, as its formula says.
# Means:    a trunk's orientation integrated with one and differenced, linearised or put in a defect of collocation
#           with the other has an error of the size of the turn, and none upright: small tests pass. Use
#           multiply([0, v], q) / 2 with integrate, or turn v into the axes of the body.
# Seen:     trunk turned by (0.3, 0.5, 0.4) rad, rate (1, 2, 0.5) rad/s: derivative off by 0.27 from the slope of integrate, equal to
#           1e-9 where the trunk is upright; after 1 s by Runge-Kutta steps 0.48 rad from where integrate ends
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check rowan==1.3.2 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" - <<'PY'
import numpy as np
import rowan
from scipy.spatial.transform import Rotation

RATE, STEP = np.array([1.0, 2.0, 0.5]), 1e-6


def as_rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


for turn in ((0.0, 0.0, 0.0), (0.3, 0.5, 0.4)):
    start = Rotation.from_rotvec(turn)
    q = start.as_quat(scalar_first=True)
    ahead, behind = (rowan.calculus.integrate(q, RATE, dt) for dt in (STEP, -STEP))
    slope = (ahead - behind) / (2 * STEP)
    own = rowan.calculus.derivative(q, RATE)
    documented = rowan.multiply(np.array([0.0, *RATE]), q) / 2
    of_body = (start * Rotation.from_rotvec(RATE * STEP)).as_quat(scalar_first=True)
    of_world = (Rotation.from_rotvec(RATE * STEP) * start).as_quat(scalar_first=True)
    assert np.allclose(slope, documented, atol=1e-9)  # integrate does as documented: axes of the world
    assert np.allclose((of_world - q) / STEP, slope, atol=1e-5)
    assert np.allclose((of_body - q) / STEP, own, atol=1e-5)
    off = np.abs(own - slope).max()
    print(f"turned by {turn}: derivative {own.round(3)}, slope of integrate {slope.round(3)}, off by {off:.2f}")
    assert off < 1e-9 if not any(turn) else off > 0.2

steps = 200
state = q.copy()
for _ in range(steps):
    k1 = rowan.calculus.derivative(rowan.normalize(state), RATE)
    k2 = rowan.calculus.derivative(rowan.normalize(state + k1 / (2 * steps)), RATE)
    k3 = rowan.calculus.derivative(rowan.normalize(state + k2 / (2 * steps)), RATE)
    k4 = rowan.calculus.derivative(rowan.normalize(state + k3 / steps), RATE)
    state = rowan.normalize(state + (k1 + 2 * k2 + 2 * k3 + k4) / (6 * steps))
end = as_rotation(rowan.calculus.integrate(q, RATE, 1.0))
apart = (as_rotation(state).inv() * end).magnitude()
print(f"after 1 s the two are {apart:.2f} rad apart")
assert (end.inv() * (Rotation.from_rotvec(RATE) * start)).magnitude() < 1e-12
assert (as_rotation(state).inv() * (start * Rotation.from_rotvec(RATE))).magnitude() < 1e-6
assert apart > 0.3
PY
