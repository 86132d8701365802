"""Whether two models are the same robot."""

import numpy as np
import pinocchio as pin


def same_motion(a: pin.Model, b: pin.Model, rng) -> bool:
    """Whether two models need the same torques, joint by joint, wherever the root is drawn."""
    assert list(a.names[2:]) == list(b.names[2:])
    q = pin.integrate(a, pin.neutral(a), rng.normal(size=a.nv))
    v, acc = rng.normal(size=(2, a.nv))
    ours, theirs = (pin.rnea(m, m.createData(), q, v, acc) for m in (a, b))
    return bool(np.abs(ours - theirs).max() < 1e-9 * np.abs(ours).max())
