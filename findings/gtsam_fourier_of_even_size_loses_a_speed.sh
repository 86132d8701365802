#!/usr/bin/env bash
# Version:  gtsam 4.3.0
# Does:     FourierBasis with an even number N of coefficients has a last cosine without its sine. Values count it.
#           DerivativeWeights and DifferentiationMatrix give the derivative of the series without it, since the sine that it
#           turns into is no member of the basis. With N odd both are the derivative. Any N is taken, and nothing is said.
# Guess:    "weights at a given x that calculate the derivative": those that CalculateWeights has as slopes.
# Means:    a stride is a Fourier series: angles fitted with six coefficients keep the cosine of the third harmonic, and the rates that
#           go with them, and with them torques and powers, do not have it. Take N odd. No report was found.
# Seen:     knee of 0.6 + 0.4 cos x + 0.25 sin 2x + 0.1 cos 3x rad, N = 6: values right to 1e-15, rate off by 0.30 of 0.77 rad per
#           rad, which is the whole 0.3 sin 3x; N = 7: rate right to 1e-9; fitted to samples by FitBasis likewise
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
cd "$work"
"$work/env/bin/python" - <<'PY'
import gtsam
import numpy as np

basis = gtsam.FourierBasis
phases = np.linspace(0, 2 * np.pi, 41)[:-1]


def knee(x):
    return 0.6 + 0.4 * np.cos(x) + 0.25 * np.sin(2 * x) + 0.1 * np.cos(3 * x)


def rate(x):
    return -0.4 * np.sin(x) + 0.5 * np.cos(2 * x) - 0.3 * np.sin(3 * x)


for size in (6, 7):
    fit = gtsam.FitBasisFourierBasis({float(x): float(knee(x)) for x in phases}, gtsam.noiseModel.Unit.Create(1), size)
    fitted = np.asarray(fit.parameters()).ravel()
    exact = np.array([0.6, 0.4, 0.0, 0.0, 0.25, 0.1, 0.0])[:size]
    for name, given in (("exact", exact), ("fitted", fitted)):
        values = np.array([float((basis.CalculateWeights(size, x) @ given).item()) for x in phases])
        said = np.array([float((basis.DerivativeWeights(size, x) @ given).item()) for x in phases])
        by_matrix = np.array([float((basis.CalculateWeights(size, x) @ (basis.DifferentiationMatrix(size) @ given)).item()) for x in phases])
        off = abs(said - rate(phases)).max()
        print(f"N = {size}, {name}: value off by {abs(values - knee(phases)).max():.1e}, rate by {off:.2e} of {abs(rate(phases)).max():.2f}")
        assert abs(values - knee(phases)).max() < 1e-9 and np.allclose(said, by_matrix, atol=1e-12)
        if size == 6:
            assert np.allclose(said - rate(phases), 0.3 * np.sin(3 * phases), atol=1e-9)
        else:
            assert off < 1e-9
PY
