"""What a URDF says, by two other readers: Python's own XML with `float`, and MuJoCo.

The first is the standard to the letter and decides. MuJoCo reads some files otherwise, on purpose:
a joint without a range, an effort of 0, links without mass; what it refuses or reads otherwise is
told, and does not count.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree as ET

import numpy as np
import pinocchio as pin
from urdf_mutations import strict_facts

from gaitopt.importers.source import Source

ROUNDING = 1e-9  # relative
REPAIRED = 2e-6  # of an inertia that lay outside of what a body can have by less than this
_SHAPES = ("visual", "collision")


def differences_from_text(source: Source, rng: np.random.Generator) -> list[str]:
    """Return in what the model differs from what the text says, at a random posture."""
    model = source.model()
    q, angles = np.array(pin.neutral(model)), {}
    for joint in range(2, model.njoints):
        if model.joints[joint].nq == 1:
            angles[str(model.names[joint])] = q[model.joints[joint].idx_q] = rng.uniform(-1, 1)
    try:
        facts = strict_facts(source.text, angles)
    except (ValueError, KeyError, AttributeError) as error:
        return [f"the text is no URDF to the letter: {type(error).__name__}: {error}"]
    return [*_places(model, q, facts), *_bodies(model, facts), *_joints(source, model, facts)]


def _places(model, q, facts):
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    links = {}
    for index, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.BODY:
            links[frame.name] = data.oMf[index].homogeneous
    if set(links) != set(facts.places):
        return [f"links: {sorted(set(links) ^ set(facts.places))}"]
    return [
        f"place of {name!r}"
        for name, place in facts.places.items()
        if not np.abs(links[name] - place).max() < ROUNDING * (1.0 + np.abs(place).max())
    ]


def _bodies(model, facts):
    bodies = {"": model.inertias[1]}
    bodies |= {str(model.names[j]): model.inertias[j] for j in range(2, model.njoints)}
    if set(bodies) != set(facts.bodies):
        return [f"joints: {sorted(set(bodies) ^ set(facts.bodies))}"]
    found = []
    for name, body in facts.bodies.items():
        own = bodies[name]
        if not math.isclose(own.mass, body.mass, rel_tol=ROUNDING, abs_tol=1e-300):
            found.append(f"mass moved by {name!r}: {own.mass} for {body.mass}")
        if not np.allclose(own.mass * own.lever, body.first, rtol=1e-9, atol=1e-9):
            found.append(f"centre of mass of {name!r}")
        about = pin.SE3(np.eye(3), np.zeros(3)).act(own).matrix()[3:, 3:]
        scale = np.abs(body.second).max()
        if not np.allclose(about, body.second, rtol=0, atol=REPAIRED * scale + 1e-12):
            found.append(f"inertia moved by {name!r}")
    return found


def _joints(source, model, facts):
    found = []
    fields = ("effortLimit", "velocityLimit", "lowerPositionLimit", "upperPositionLimit")
    for name, limits in facts.limits.items():
        joint = model.joints[model.getJointId(name)]
        rows = (joint.idx_v, joint.idx_v, joint.idx_q, joint.idx_q)
        own = tuple(getattr(model, f)[r] for f, r in zip(fields, rows, strict=True))
        if own != limits:
            found.append(f"limits of {name!r}: {own} for {limits}")
        passive = source.physics.joints.get(name)
        resistance = (sum(passive.damping), passive.friction) if passive else (0.0, 0.0)
        if resistance != facts.passive[name]:
            found.append(f"damping or friction of {name!r}")
    return found


def mujoco_of_urdf(text: str):
    """Return MuJoCo's model of a URDF with a floating root and every link a body of its own.

    Shapes are left out, since masses are to come from <inertial> alone.

    Raises:
        ValueError: MuJoCo refuses it.
    """
    import mujoco

    root = ET.fromstring(text)
    for link in root.findall("link"):
        for shape in [e for e in link if e.tag in _SHAPES]:
            link.remove(shape)
    spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
    spec.compiler.fusestatic = 0
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    base = spec.worldbody.first_body()
    if base is None:
        raise ValueError("no body")
    base.add_freejoint()
    return spec.compile()


def differences_from_mujoco(source: Source, m, rng: np.random.Generator) -> list[str]:
    """Return in what the model differs from MuJoCo's, at a random posture, in both directions.

    Compared are total mass, mass matrix, gravity and velocity terms, places of all links, ranges
    and force limits where both readers have one.
    """
    import mujoco

    model, d = source.model(), mujoco.MjData(m)
    model.armature = np.zeros(model.nv)  # of transmissions, which MuJoCo passes over
    joints = [m.joint(j) for j in range(1, m.njnt)]
    if {j.name for j in joints} != {str(name) for name in model.names[2:]}:
        return ["names of joints (it makes three of a planar one)"]
    if model.nv != m.nv or model.nq != m.nq or m.jnt_type[0] != mujoco.mjtJoint.mjJNT_FREE:
        return ["kinds of joints"]
    pairs = [(j, model.joints[model.getJointId(j.name)]) for j in joints]
    if any(own.nq != 1 for _, own in pairs):
        return ["kinds of joints"]
    d.qpos[:3], turn = rng.normal(size=3), rng.normal(size=4)
    d.qpos[3:7] = turn / np.linalg.norm(turn)
    for joint, _ in pairs:
        d.qpos[joint.qposadr[0]] = rng.uniform(-1, 1)
    d.qvel[:] = rng.normal(size=m.nv)
    mujoco.mj_forward(m, d)
    q, v = np.array(pin.neutral(model)), np.zeros(model.nv)
    q[:3], q[3:7] = d.qpos[:3], d.qpos[[4, 5, 6, 3]]
    rotation = d.xmat[1].reshape(3, 3)
    v[:3], v[3:6] = rotation.T @ d.qvel[:3], d.qvel[3:6]
    rows, dofs = list(range(6)), list(range(6))
    for joint, own in pairs:
        q[own.idx_q], v[own.idx_v] = d.qpos[joint.qposadr[0]], d.qvel[joint.dofadr[0]]
        rows.append(own.idx_v)
        dofs.append(joint.dofadr[0])
    return [
        *_same_motion(model, m, d, (q, v), rotation, rows, dofs),
        *_same_limits(model, m, pairs),
    ]


def _same_motion(model, m, d, state, rotation, rows, dofs):
    import mujoco

    q, v = state
    found, data = [], model.createData()
    pin.framesForwardKinematics(model, data, q)
    for index, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.BODY:
            body = mujoco.mj_name2id(m, mujoco.mjtObj.mjOBJ_BODY, frame.name)
            place = data.oMf[index]
            if body < 0 or not (
                _near(place.translation, d.xpos[body])
                and _near(place.rotation, d.xmat[body].reshape(3, 3))
            ):
                found.append("placements")
                break
    if not _near(pin.computeTotalMass(model), m.body_mass.sum()):
        found.append("total mass")
    M = np.zeros((m.nv, m.nv))
    try:
        mujoco.mj_fullM(m, d, M)
    except TypeError:  # before version 4
        mujoco.mj_fullM(m, M, d.qM)
    turned = np.eye(model.nv)
    turned[:3, :3] = rotation.T
    own = turned.T @ pin.crba(model, data, q) @ turned
    if not _near(own[np.ix_(rows, rows)], M[np.ix_(dofs, dofs)], REPAIRED):
        found.append("mass matrix")
    weighed = model.copy()
    weighed.gravity.linear = m.opt.gravity.copy()
    a = np.zeros(model.nv)
    a[:3] = -np.cross(v[3:6], v[:3])
    bias = turned.T @ pin.rnea(weighed, weighed.createData(), q, v, a)
    if not _near(bias[rows], d.qfrc_bias[dofs], REPAIRED):
        found.append("bias forces")
    return found


def _same_limits(model, m, pairs):
    found = set()
    for joint, own in pairs:
        low, high = model.lowerPositionLimit[own.idx_q], model.upperPositionLimit[own.idx_q]
        limited = bool(joint.limited[0])
        told = limited or bool(np.isfinite([low, high]).all() and low < high)
        if told and not (limited and _near((low, high), joint.range)):
            found.add("ranges")
        effort = model.effortLimit[own.idx_v]
        told = bool(m.jnt_actfrclimited[joint.id] or (np.isfinite(effort) and effort > 0.0))
        if told and not _near((-effort, effort), m.jnt_actfrcrange[joint.id]):
            found.add("force limits")
    return sorted(found)


def _near(found, expected, tolerance: float = ROUNDING) -> bool:
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    same = found == expected  # infinite ones too
    size = np.abs(expected[np.isfinite(expected)]).max(initial=0.0)
    gap = np.abs(found[~same] - expected[~same]).max(initial=0.0)
    return bool(gap <= tolerance * (1.0 + size))
