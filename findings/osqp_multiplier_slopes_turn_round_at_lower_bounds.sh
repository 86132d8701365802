#!/usr/bin/env bash
# Version:  osqp 1.1.3
# Does:     after adjoint_derivative_compute(dx, dy) every slope that goes through a multiplier of a row that sits at its
#           lower bound (y < 0), or of an equality whose multiplier happens to be negative, has the opposite sign,
#           over q and over the bounds alike. Slopes of the minimiser (dx) and of multipliers of upper bounds are right.
# Guess:    y is one signed vector, and dy asks for the slopes of that vector.
# Means:    forces of contacts and of joint stops are such multipliers: learning or tuning through them runs uphill where a row
#           is held from below (a foot on the ground, a knee at its stop) and downhill where it is held from above. An
#           equality changes its mind as its force changes sign. Turn dy by the sign of y, row by row, before the call.
#           (The C code takes one dy for the parts y+ and y- of y = y+ - y- alike, since pull request 605 made one
#           argument of two; issue 156 of osqp-python says that the test with dy was then switched off.)
# Seen:     40 programs of four variables, two rows with room and one equality: 160 slopes of the minimiser off by 6e-10 at most,
#           55 of multipliers above zero by 2e-10; of 48 below zero each the very opposite, off by 0.45 to 61
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check osqp==1.1.3 numpy==2.4.6 scipy==1.17.1
"$work/env/bin/python" - <<'PY'
import numpy as np
import osqp
import scipy.sparse as sp

TIGHT = {"eps_abs": 1e-11, "eps_rel": 1e-11, "max_iter": 200000, "polishing": True, "verbose": False}
N, M, H = 4, 3, 1e-5


def solved(P, q, A, l, u):
    solver = osqp.OSQP()
    solver.setup(sp.triu(sp.csc_matrix(P), format="csc"), q, sp.csc_matrix(A), l, u, **TIGHT)
    result = solver.solve()
    assert np.abs(P @ result.x + q + A.T @ result.y).max() < 1e-9 and np.all(A @ result.x < u + 1e-9) and np.all(A @ result.x > l - 1e-9)
    return solver, result


def moved(P, q, A, l, u, step):
    result = solved(P, q + step[:N], A, l + step[N:], u + step[N:])[1]
    return np.concatenate([result.x, result.y])


def asked(solver, dx, dy):
    """Slopes over q and over both bounds of a row together."""
    solver.adjoint_derivative_compute(dx=dx, dy=dy)
    dq, dl, du = solver.adjoint_derivative_get_vec()
    return np.concatenate([dq, dl + du])


off = {"x": [], "above": [], "below": []}
for seed in range(40):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N))
    P, q, A = root @ root.T + 0.5 * np.eye(N), 2.0 * rng.normal(size=N), rng.normal(size=(M, N))
    inside = 0.3 * rng.normal(size=N)
    l, u = A @ inside - [0.1, 0.5, 0.0], A @ inside + [0.1, 0.3, 0.0]  # two rows with room, one equality
    solver, result = solved(P, q, A, l, u)
    x, y = result.x, result.y
    active = np.abs(y) > 1e-3
    assert not np.any((np.abs(y) > 1e-9) & ~active)
    # the slopes by hand: the active rows as equalities
    rows = A[active]
    system = np.block([[P, rows.T], [rows, np.zeros((len(rows), len(rows)))]])
    by_hand = np.linalg.inv(system)
    slopes = np.zeros((N + M, N + M))  # of (x, y) over (q, both bounds)
    keep = np.concatenate([np.ones(N, bool), active])
    slopes[np.ix_(keep, keep)] = by_hand * np.concatenate([-np.ones(N), np.ones(len(rows))])
    shifts = H * np.eye(N + M)
    differences = np.array([moved(P, q, A, l, u, s) - moved(P, q, A, l, u, -s) for s in shifts]).T / (2 * H)
    assert np.abs(differences - slopes).max() < 1e-5 * (1 + np.abs(slopes).max())
    for i in range(N):
        off["x"].append(np.abs(asked(solver, np.eye(N)[i], np.zeros(M)) - slopes[i]).max())
    for j in np.flatnonzero(active):
        given, right = asked(solver, np.zeros(N), np.eye(M)[j]), slopes[N + j]
        if y[j] > 0:
            off["above"].append(np.abs(given - right).max())
        else:
            off["below"].append(np.abs(given - right).max())
            assert np.abs(given + right).max() < 1e-5  # the very opposite
            assert np.isclose(off["below"][-1], 2 * np.abs(right).max(), rtol=1e-3)
for name, each in off.items():
    print(f"{name}: {len(each)} slopes, off by {min(each):.2g} to {max(each):.2g}")
assert max(off["x"]) < 1e-5 and max(off["above"]) < 1e-5 and min(off["below"]) > 0.01
assert len(off["above"]) > 20 and len(off["below"]) > 20
PY
