#!/usr/bin/env bash
# Version:  newton 1.8.0, warp-lang 1.19.0
# Does:     eval_ik finds joint rates from the velocities of the bodies. Of a D6 joint with two or three sliding axes on a body
#           that turns it leaves out that the slide is carried round: the rates are too large by (angular velocity of
#           the parent) x (displacement of the slide). Positions and the turning rates are right, and so are one
#           sliding axis alone and any number on a parent at rest. eval_fk and eval_jacobian are right, so
#           going from rates to velocities and back does not end where it began. (The same was mended in eval_fk by pull
#           request 2181; of eval_ik no report was found.)
# Guess:    eval_ik undoes eval_fk.
# Means:    a socket, a strap or a soft sole that gives way in two or three directions against a swinging leg seems to
#           move when it is at rest in it; dampers and controllers on these rates act on the swing itself. Solvers that
#           keep bodies need this function to say what joints do. Take Jacobian and velocities, solved for the rates.
# Seen:     shank turning at 5 rad/s about y, sole displaced by 5 and 20 mm in x and z and at rest in it: rates of 0.100
#           and -0.025 m/s for 0; with one axis, or a shank at rest, right to 1e-5; solved with the Jacobian right to 1e-4
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check newton==1.8.0 warp-lang==1.19.0
cd "$work"
WARP_CACHE_PATH="$work/kernels" "$work/env/bin/python" - <<'PY'
import numpy as np
import warp as wp

wp.config.quiet = True
wp.config.enable_backward = False
import newton

slide, unit = newton.ModelBuilder.JointDofConfig, wp.mat33(*np.eye(3).ravel())


def leg(axes):
    builder = newton.ModelBuilder()
    shank, sole = (builder.add_link(mass=1.0, com=wp.vec3(0.0, 0.0, 0.0), inertia=unit) for _ in range(2))
    knee = builder.add_joint_revolute(-1, shank, axis=wp.vec3(0.0, 1.0, 0.0))
    gives = builder.add_joint_d6(shank, sole, linear_axes=[slide(axis=wp.vec3(*axis)) for axis in axes])
    builder.add_articulation([knee, gives])
    return builder.finalize(device="cpu")


def back(axes, places, rates, swing):
    model = leg(axes)
    q, qd = np.array([0.3, *places]), np.array([swing, *rates])
    state = model.state()
    newton.eval_fk(model, wp.array(q, dtype=float), wp.array(qd, dtype=float), state)
    found_q, found_qd = wp.zeros(len(q), dtype=float), wp.zeros(len(q), dtype=float)
    newton.eval_ik(model, state, found_q, found_qd)
    J = newton.eval_jacobian(model, state).numpy()[0]
    solved = np.linalg.lstsq(J[:12, : len(q)], state.body_qd.numpy().ravel(), rcond=None)[0]
    print(f"{len(axes)} axes, swing {swing} rad/s: put in {qd}, eval_ik {found_qd.numpy().round(4)}, by Jacobian {solved.round(4)}")
    assert np.allclose(found_q.numpy(), q, atol=1e-5) and np.allclose(solved, qd, atol=1e-4)
    return found_qd.numpy() - qd


x, y, z = np.eye(3)
off = back([x, z], [0.005, 0.02], [0.0, 0.0], 5.0)
d = np.array([0.005, 0.0, 0.02])
carried = np.cross([0.0, 5.0, 0.0], d)
print("carried round:", carried[[0, 2]])
assert abs(off[0]) < 1e-5 and np.allclose(off[1:], carried[[0, 2]], atol=1e-5) and abs(off).max() > 0.09
off = back([x, y, z], [0.005, -0.01, 0.02], [0.1, 0.2, 0.3], 5.0)
assert np.allclose(off[1:], carried, atol=1e-5)
assert abs(back([x], [0.005], [0.1], 5.0)).max() < 1e-5
assert abs(back([x, z], [0.005, 0.02], [0.1, 0.2], 0.0)).max() < 1e-5
PY
