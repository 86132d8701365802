#!/usr/bin/env bash
# Version:  crocoddyl 3.2.1 with pin 4.0.0 (with pin 4.1.0 it installs and computes garbage)
# Does:     ActionModelImpulseFwdDynamics with a restitution coefficient r maps the state as it should: the foot
#           leaves the ground at -r times the velocity it came with. Its derivative Fx leaves that velocity
#           out: over the velocities it is that of r = 0 for every r, J Fv = 0 where it should be -r J, and
#           over the configuration it lacks the same share.
# Guess:    Fx is the derivative of the map that calc computes, for every value of its parameters.
# Means:    DDP over a touchdown with a rebound predicts a decrease that the rollout does not show, and the
#           feedback gains across it belong to another contact. The walks that come with Crocoddyl take r
#           as an argument. Keep r = 0, or take ActionModelNumDiff. Pinocchio's own
#           computeImpulseDynamicsDerivatives knows r.
# Seen:     r = 0.5: foot from -2.66 to 1.33 m/s; Fx off by 4.3, its velocity part changed with r by 0, that of
#           difference quotients by 1.5; r = 0: Fx right to 1e-7
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
state = crocoddyl.StateMultibody(model)
foot = model.getFrameId("rleg_effector_body")
rng, nv, none = np.random.default_rng(0), model.nv, np.zeros(0)
x = np.concatenate([pin.integrate(model, pin.neutral(model), rng.uniform(-0.4, 0.4, nv)), rng.uniform(-1, 1, nv)])
jacobian = pin.computeFrameJacobian(model, model.createData(), x[: model.nq], foot, pin.LOCAL)
given, right = {}, {}
for r in (0.0, 0.25, 0.5):
    impulses = crocoddyl.ImpulseModelMultiple(state)
    impulses.addImpulse("foot", crocoddyl.ImpulseModel6D(state, foot, pin.LOCAL))
    action = crocoddyl.ActionModelImpulseFwdDynamics(state, impulses, crocoddyl.CostModelSum(state, 0), r, 0.0, True)
    data = action.createData()
    action.calc(data, x, none)
    action.calcDiff(data, x, none)
    before, after = jacobian @ x[model.nq :], jacobian @ data.xnext[model.nq :]
    assert np.abs(after + r * before).max() < 1e-10
    given[r] = np.array(data.Fx)

    def step(at):
        action.calc(data, at, none)
        return np.array(data.xnext)

    columns = [
        (state.diff(step(x), step(state.integrate(x, h))) - state.diff(step(x), step(state.integrate(x, -h)))) / 2e-6
        for h in 1e-6 * np.eye(2 * nv)
    ]
    right[r] = np.array(columns).T
    print(
        f"r {r}: foot {before[2]:.3f} to {after[2]:.3f} m/s, Fx off by {np.abs(given[r] - right[r]).max():.2g}"
    )
half = slice(nv, 2 * nv)
assert np.abs(given[0.0] - right[0.0]).max() < 1e-6
for r in (0.25, 0.5):
    print(f"r {r}: velocity part given changed by {np.abs((given[r] - given[0.0])[half, half]).max():.1g}")
    print(f"  of difference quotients by {np.abs((right[r] - right[0.0])[half, half]).max():.3g}")
    assert np.abs((given[r] - given[0.0])[half, half]).max() < 1e-9
    assert np.abs((right[r] - right[0.0])[half, half]).max() > 0.2
    assert np.abs(jacobian @ given[r][half, half]).max() < 1e-9
    assert np.abs(jacobian @ right[r][half, half] + r * jacobian).max() < 1e-5
    assert np.abs((given[r] - right[r])[half, :nv]).max() > 0.01
PY
