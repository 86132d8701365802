#!/usr/bin/env bash
# Version:  crocoddyl 3.2.1 with pin 4.0.0 (with pin 4.1.0 it installs and computes garbage)
# Does:     in an ActionModelImpulseFwdDynamics a cost on the velocity of a frame (ResidualModelFrameVelocity) has
#           the value of the instant before the impact, and a derivative over the configuration made with the
#           velocity after it. For ResidualModelCentroidalMomentum that derivative is of neither instant.
# Guess:    Lx is the derivative of the cost that is added up, for the one instant or the other.
# Means:    a penalty on the speed with which a foot lands, the usual wish of a soft step, is pulled along a
#           direction that is not downhill; solvers shorten their steps there and end off the optimum.
#           Put such a cost on the last node before the impact, where value and slope agree.
# Seen:     foot that lands: value that of before exactly, slope off by 0.78 (0 instead: it is at rest after);
#           other foot: slope off by 0.73 of 1.13 and that of after to 1e-10; momentum: off by 26 of 26
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check crocoddyl==3.2.1 pin==4.0.0
"$work/env/bin/python" - <<'PY'
import crocoddyl
import numpy as np
import pinocchio as pin

model = pin.buildSampleModelHumanoid()
state, nv, nq, none = crocoddyl.StateMultibody(model), model.nv, model.nq, np.zeros(0)
left, right = model.getFrameId("lleg_effector_body"), model.getFrameId("rleg_effector_body")
rng = np.random.default_rng(0)
x = np.concatenate([pin.integrate(model, pin.neutral(model), rng.uniform(-0.4, 0.4, nv)), rng.uniform(-1, 1, nv)])


def action(residual, lands):
    costs, impulses = crocoddyl.CostModelSum(state, 0), crocoddyl.ImpulseModelMultiple(state)
    costs.addCost("cost", crocoddyl.CostModelResidual(state, residual), 1.0)
    impulses.addImpulse("foot", crocoddyl.ImpulseModel6D(state, lands, pin.LOCAL))
    return crocoddyl.ActionModelImpulseFwdDynamics(state, impulses, costs)


def run(model_, at):
    data = model_.createData()
    model_.calc(data, at, none)
    return data


def foot_velocity(q, v):
    data = model.createData()
    pin.forwardKinematics(model, data, q, v)
    return pin.getFrameVelocity(model, data, left, pin.LOCAL).vector.copy()


def momentum(q, v):
    return pin.computeCentroidalMomentum(model, model.createData(), q, v).vector.copy()


def slope(f, q, v):
    """Difference quotient over the configuration, the velocity held."""
    steps = 1e-6 * np.eye(nv)
    return np.array([f(pin.integrate(model, q, h), v) - f(pin.integrate(model, q, -h), v) for h in steps]).T / 2e-6


wishes = {
    "velocity of the foot that lands": (
        crocoddyl.ResidualModelFrameVelocity(state, left, pin.Motion.Zero(), pin.LOCAL, 0), foot_velocity, left),
    "velocity of the other foot": (
        crocoddyl.ResidualModelFrameVelocity(state, left, pin.Motion.Zero(), pin.LOCAL, 0), foot_velocity, right),
    "centroidal momentum": (crocoddyl.ResidualModelCentroidalMomentum(state, np.zeros(6), 0), momentum, left),
}
for name, (residual, f, lands) in wishes.items():
    touchdown = action(residual, lands)
    data = run(touchdown, x)
    q, before, after = x[:nq], x[nq:].copy(), data.xnext[nq:].copy()
    value = np.array(data.costs.costs["cost"].residual.r)
    touchdown.calcDiff(data, x, none)
    given = np.array(data.costs.costs["cost"].residual.Rx)[:, :nv]
    late, early = (np.abs(value - f(q, v)).max() for v in (after, before))
    print(f"{name}: value off from that before by {early:.1g}, from that after by {late:.2g}")
    assert early < 1e-12 and late > 0.01
    late, early = (np.abs(given - slope(f, q, v)).max() for v in (after, before))
    size = np.abs(slope(f, q, before)).max()
    print(f"  slope over the configuration off by {early:.2g} of {size:.3g}; from that after by {late:.1g}")
    gradient = [run(touchdown, state.integrate(x, h)).cost - run(touchdown, state.integrate(x, -h)).cost
                         for h in 1e-6 * np.eye(2 * nv)]
    gradient = np.array(gradient) / 2e-6
    assert early > 0.3 and (late < 1e-7) == (f is foot_velocity)
    print(f"  gradient of the cost off by {np.abs(gradient - data.Lx).max():.2g} of {np.abs(gradient).max():.3g}")
    assert np.abs(gradient - data.Lx)[:nv].max() > 0.2 and np.abs(gradient - data.Lx)[nv:].max() < 1e-3
PY
