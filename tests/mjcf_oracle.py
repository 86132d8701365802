"""What MuJoCo computes from an MJCF file, beside what gaitopt's reading of it gives.

Every difference is relative: to the largest entry of MuJoCo's, or to 1 where that is smaller.
"""

import contextlib
import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin

from gaitopt.importers.physics import STANDARD_GRAVITY
from gaitopt.importers.reader import read_source
from gaitopt.importers.source import Source

_GREAT = 1e7  # a control beyond all ranges; forces as large are without limit
_MOST_FORCE = 1e5  # N·m or N
_POSTURES = 20
SINGLE = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
DIRECT = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


@dataclass
class Comparison:
    """Largest relative differences, by quantity."""

    worst: dict[str, float] = field(default_factory=dict)

    def add(self, quantity: str, found: object, expected: object, terms: float = 1.0) -> None:
        """Add a quantity; `terms` is the largest number that MuJoCo adds up for it."""
        found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
        assert found.shape == expected.shape, (quantity, found.shape, expected.shape)
        if not found.size:
            return
        scale = max(terms, float(np.abs(expected[np.isfinite(expected)]).max(initial=0.0)))
        same = (found == expected) | (np.isnan(found) & np.isnan(expected))
        gap = np.where(same, 0.0, found - np.where(same, 0.0, expected)) / scale
        value = float(np.nan_to_num(np.abs(gap), nan=math.inf).max())
        self.worst[quantity] = max(self.worst.get(quantity, 0.0), value)

    @property
    def largest(self) -> float:
        return max(self.worst.values())


def compare(path: Path, seed: int = 0, postures: int = _POSTURES) -> Comparison:
    """Compare a file as gaitopt reads it with what MuJoCo makes of it."""
    source, model = read_source(path), silently_compiled(path)
    with silent():
        result = compare_models(source, model, seed, postures)
    again = read_source(source.text)
    assert again.compiled == source.compiled
    assert again.model() == source.model()
    assert again.physics == source.physics
    return result


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep MuJoCo's warnings off the screen and out of its log file."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mujoco.set_mju_user_warning(before)


def silently_compiled(path: Path) -> mujoco.MjModel:
    """Compile a file, without the memory that simulations of it ask for."""
    with silent():
        spec = mujoco.MjSpec.from_file(str(path.resolve()))
        spec.memory = -1  # else a file may ask for gigabytes, for each MjData
        return spec.compile()


def compare_models(source: Source, m: mujoco.MjModel, seed: int, postures: int) -> Comparison:
    rng, result = np.random.default_rng(seed), Comparison()
    model, mapping = source.model(), Mapping(source, m)
    _limits(mapping, model, result)
    for _ in range(postures):
        _motion(mapping, model, rng, result)
        _passive(mapping, source, rng, result)
    _shapes(mapping, source, rng, result)
    return result


class Mapping:
    """Which body, joint and coordinate of MuJoCo's is which of Pinocchio's."""

    def __init__(self, source: Source, m: mujoco.MjModel) -> None:
        self.m, self.d = m, mujoco.MjData(m)
        robot, self.model = source.compiled, source.model()
        self.compiled = robot
        # Unnamed bodies and joints are called by their number.
        self.bodies = {b.name: self._id(b.name, m.body, m.nbody, "body") for b in robot.bodies}
        self.joints = {j.name: self._id(j.name, m.joint, m.njnt, "joint") for j in robot.joints}
        self.base = self.bodies[robot.bodies[0].name]
        first = m.body_jntadr[self.base]
        self.free = bool(m.body_jntnum[self.base]) and m.jnt_type[first] == 0
        self.free_joint = int(first)
        self.dofs, self.rows = [], []
        for joint in robot.joints:
            at, own = self.joints[joint.name], self.model.joints[self.model.getJointId(joint.name)]
            self.dofs += range(m.jnt_dofadr[at], m.jnt_dofadr[at] + own.nv)
            self.rows += range(own.idx_v, own.idx_v + own.nv)

    @staticmethod
    def _id(name, named, count, kind):
        found = [i for i in range(count) if named(i).name == name]
        return found[0] if found else int(name.rstrip("_").removeprefix(f"{kind}_"))

    def randomise(self, rng) -> tuple[np.ndarray, np.ndarray]:
        """Put MuJoCo into a random state; return Pinocchio's of it."""
        m, d = self.m, self.d
        mujoco.mj_resetData(m, d)
        for j in range(m.njnt):
            at = m.jnt_qposadr[j]
            if m.jnt_type[j] in SINGLE:
                ends = m.jnt_range[j] if m.jnt_limited[j] else (-1.5, 1.5)
                ends = np.clip(ends, -1e3, 1e3)
                d.qpos[at] = rng.uniform(*ends)
            else:
                turn = at + (3 if m.jnt_type[j] == 0 else 0)
                d.qpos[turn : turn + 4] = _turn(rng)
        inside = set(self.dofs)
        if self.free:
            d.qpos[m.jnt_qposadr[self.free_joint] :][:3] = rng.normal(size=3)
            first = m.jnt_dofadr[self.free_joint]
            inside |= set(range(first, first + 6))
        d.qvel[sorted(inside)] = rng.normal(size=len(inside))
        mujoco.mj_kinematics(m, d)
        mujoco.mj_comPos(m, d)
        mujoco.mj_tendon(m, d)
        mujoco.mj_makeM(m, d)
        mujoco.mj_transmission(m, d)
        mujoco.mj_fwdVelocity(m, d)
        q, v = np.array(pin.neutral(self.model)), np.zeros(self.model.nv)
        q[:3], q[3:7] = d.xpos[self.base], d.xquat[self.base][[1, 2, 3, 0]]
        for name, j in self.joints.items():
            own, at = self.model.joints[self.model.getJointId(name)], m.jnt_qposadr[j]
            if own.nq == 1:
                q[own.idx_q] = d.qpos[at]
            else:
                q[own.idx_q : own.idx_q + 4] = d.qpos[at : at + 4][[1, 2, 3, 0]]
        v[self.rows] = d.qvel[self.dofs]
        if self.free:
            first = m.jnt_dofadr[self.free_joint]
            v[:3] = self.rotation.T @ d.qvel[first : first + 3]
            v[3:6] = d.qvel[first + 3 : first + 6]
        return q, v

    @property
    def rotation(self) -> np.ndarray:
        return self.d.xmat[self.base].reshape(3, 3)


def far_arms(m: mujoco.MjModel, d: mujoco.MjData) -> np.ndarray:
    """Arms of the bodies' weights about the points about which MuJoCo takes moments.

    These are the centres of mass of all below a body of the world. If one is far away, moments are
    large and nearly cancel: their rounding is MuJoCo's (`test_far_masses_round_in_mujoco`).
    """
    return np.linalg.norm(d.xipos - d.subtree_com[m.body_rootid], axis=1)


def mass_matrix(m: mujoco.MjModel, d: mujoco.MjData) -> np.ndarray:
    M = np.zeros((m.nv, m.nv))
    try:
        mujoco.mj_fullM(m, d, M)
    except TypeError:  # before version 4
        mujoco.mj_fullM(m, M, d.qM)
    return M


def _turn(rng) -> np.ndarray:
    quat = rng.normal(size=4)
    return quat / np.linalg.norm(quat)


def _motion(mapping: Mapping, model: pin.Model, rng, result: Comparison) -> None:
    m, d = mapping.m, mapping.d
    q, v = mapping.randomise(rng)
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for name, body in mapping.bodies.items():
        if body < mapping.base:
            continue  # carries the root in the file, and hangs on it here
        place = data.oMf[model.getFrameId(name, pin.FrameType.BODY)]
        result.add("placement", place.translation, d.xpos[body])
        result.add("placement", place.rotation, d.xmat[body].reshape(3, 3))
    M = mass_matrix(m, d)
    weighed = model.copy()
    gravity = np.zeros(3) if m.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else None
    weighed.gravity.linear = m.opt.gravity.copy() if gravity is None else gravity
    a, turned = np.zeros(model.nv), np.eye(model.nv)
    rows, dofs = list(mapping.rows), list(mapping.dofs)
    if mapping.free:
        # MuJoCo's velocity of a free joint is linear in the world, angular in the body.
        a[:3] = -np.cross(v[3:6], v[:3])
        turned[:3, :3] = mapping.rotation.T
        first = m.jnt_dofadr[mapping.free_joint]
        rows, dofs = [*range(6), *rows], [*range(first, first + 6), *dofs]
        M[first : first + 6, first : first + 6] -= np.diag(m.dof_armature[first : first + 6])
    found = turned.T @ pin.crba(model, data, q) @ turned
    # In world coordinates, places far from the origin round by as much.
    arms, away = far_arms(m, d), np.linalg.norm(d.xipos, axis=1)
    moments = max(1.0, float((m.body_mass * arms * (arms + away)).max()))
    result.add("mass matrix", found[np.ix_(rows, rows)], M[np.ix_(dofs, dofs)], moments)
    bias = turned.T @ pin.rnea(weighed, weighed.createData(), q, v, a)
    rates = max(1.0, float(v @ v))
    result.add("bias", bias[rows], d.qfrc_bias[dofs], moments * rates)


def _passive(mapping: Mapping, source: Source, rng, result: Comparison) -> None:
    m, d, physics = mapping.m, mapping.d, source.physics
    q, _ = mapping.randomise(rng)
    single = [(j.name, mapping.joints[j.name]) for j in mapping.compiled.joints if j.kind != "ball"]
    damping, spring = [], []
    for name, j in single:
        passive = physics.joints.get(name)
        rate, angle = d.qvel[m.jnt_dofadr[j]], d.qpos[m.jnt_qposadr[j]]
        terms = () if passive is None else passive.damping
        damping.append(-sum(b * abs(rate) ** k * rate for k, b in enumerate(terms)))
        terms = () if passive is None else passive.stiffness
        away = 0.0 if passive is None else angle - passive.rest
        spring.append(-sum(k * away ** (n + 1) for n, k in enumerate(terms)))
    dofs = [m.jnt_dofadr[j] for _, j in single]
    friction = [physics.joints[n].friction if n in physics.joints else 0.0 for n, _ in single]
    result.add("friction", friction, _friction_loss(m, d)[dofs])
    result.add("damping", damping, d.qfrc_damper[dofs])
    result.add("spring", spring, d.qfrc_spring[dofs])
    model, data = mapping.model, mapping.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    lifted = np.zeros(model.nv)
    gravity = np.array(mapping.compiled.gravity)  # the root stands otherwise than it is drawn
    upright = pin.Quaternion(*mapping.compiled.bodies[0].place.quat).toRotationMatrix()
    if physics.gravity is not None:
        result.add("gravity", upright @ physics.gravity, gravity)
    else:
        result.add("gravity", gravity, (0.0, 0.0, -STANDARD_GRAVITY))
    for name, mass in physics.compensated.items():
        frame = model.getFrameId(name, pin.FrameType.BODY)
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        arm = data.oMf[frame].rotation @ np.array(mass.centre)
        force = -mass.mass * gravity
        lifted += J.T @ np.r_[force, np.cross(arm, force)]
    weights = m.body_mass * np.abs(m.body_gravcomp) * np.linalg.norm(m.opt.gravity)
    terms = max(1.0, float((far_arms(m, d) * weights).max()))
    expected = _carried_from_outside(m, d)[mapping.dofs]
    result.add("gravity compensation", lifted[mapping.rows], expected, terms)


def _friction_loss(m: mujoco.MjModel, d: mujoco.MjData) -> np.ndarray:
    """Friction that MuJoCo's constraints give the joints, of those that move one joint alone."""
    mujoco.mj_makeConstraint(m, d)
    J = np.zeros((d.nefc, m.nv))
    if mujoco.mj_isSparse(m):
        mujoco.mju_sparse2dense(J, d.efc_J, d.efc_J_rownnz, d.efc_J_rowadr, d.efc_J_colind)
    else:
        J[:] = d.efc_J.reshape(J.shape)
    kinds = mujoco.mjtConstraint
    rubs = (int(kinds.mjCNSTR_FRICTION_DOF), int(kinds.mjCNSTR_FRICTION_TENDON))
    alone = np.isin(d.efc_type, rubs) & (np.count_nonzero(J, axis=1) == 1)
    return np.abs(J[alone]).T @ d.efc_frictionloss[alone]


def _carried_from_outside(m: mujoco.MjModel, d: mujoco.MjData) -> np.ndarray:
    """Gravity compensation without that of bodies whose motors bear it (actuatorgravcomp)."""
    whole = m.body_gravcomp.copy()
    for body in range(m.nbody):
        above = body
        while above > 0:
            first, count = m.body_jntadr[above], m.body_jntnum[above]
            if m.jnt_actgravcomp[first : first + count].any():
                m.body_gravcomp[body] = 0.0
            above = m.body_parentid[above]
    mujoco.mj_passive(m, d)
    m.body_gravcomp[:] = whole
    return d.qfrc_gravcomp.copy()


def _limits(mapping: Mapping, model: pin.Model, result: Comparison) -> None:
    m = mapping.m
    for joint in mapping.compiled.joints:
        if joint.kind == "ball":
            continue
        own, j = model.joints[model.getJointId(joint.name)], mapping.joints[joint.name]
        ends = (-np.inf, np.inf)
        if m.jnt_limited[j]:
            ends = m.jnt_range[j]
        found = model.lowerPositionLimit[own.idx_q], model.upperPositionLimit[own.idx_q]
        result.add("range", found, ends)
        least, most = force_range(m, j)
        result.add("force", _limitless((joint.least, joint.most)), (least, most))
        effort = max(min(-least, most), 0.0)
        result.add("force", _limitless(model.effortLimit[own.idx_v]), effort)


def _limitless(forces: object) -> np.ndarray:
    """Forces as `force_range` tells them: as good as infinite beyond what it tries."""
    forces = np.asarray(forces, dtype=float)
    return np.where(np.abs(forces) > _MOST_FORCE, np.copysign(np.inf, forces), forces)


def force_range(m: mujoco.MjModel, joint: int) -> tuple[float, float]:
    """Return the force of all actuators on a joint, as found by trying controls at rest.

    The control of a servo is no force: what it can give at one posture is not what it can give.
    """
    d, dof = mujoco.MjData(m), m.jnt_dofadr[joint]
    gravity, limited = m.opt.gravity.copy(), m.actuator_ctrllimited.copy()
    servos = (m.actuator_biastype == 1) & m.actuator_biasprm[:, 1:3].any(axis=1)
    m.actuator_ctrllimited[servos] = 0
    m.opt.gravity[:] = 0.0
    mujoco.mj_fwdPosition(m, d)
    mujoco.mj_fwdVelocity(m, d)

    def force(controls: np.ndarray) -> float:
        d.ctrl[:] = controls
        for i in range(m.na and len(m.actuator_dyntype)):
            at = m.actuator_actadr[i]
            if at >= 0:  # what the control leads to in the end
                limits = m.actuator_ctrlrange[i] if m.actuator_ctrllimited[i] else (-_GREAT, _GREAT)
                d.act[at] = np.clip(controls[i], *limits)
        mujoco.mj_fwdActuation(m, d)
        return float(d.qfrc_actuator[dof])

    rest, clamped = np.zeros(m.nu), m.jnt_actfrclimited[joint]
    ends = []
    for sign in (-1.0, 1.0):
        m.jnt_actfrclimited[joint] = 0  # what is best for one actuator shows without the others
        best = np.zeros(m.nu)
        for u in range(m.nu):
            tried = []
            for value in (0.0, _GREAT, -_GREAT):
                controls = rest.copy()
                controls[u] = value
                tried.append((sign * force(controls), value))
            best[u] = max(tried)[1]
        m.jnt_actfrclimited[joint] = clamped
        value = force(best)
        ends.append(sign * np.inf if abs(value) > _MOST_FORCE else value)
    m.opt.gravity[:], m.actuator_ctrllimited[:] = gravity, limited
    acts = bool(m.jnt_actfrclimited[joint]) or _driven(m, joint)
    if not acts:
        return -np.inf, np.inf
    if m.jnt_actfrclimited[joint] and not _driven(m, joint):
        return tuple(m.jnt_actfrcrange[joint])
    return ends[0], ends[1]


def _driven(m: mujoco.MjModel, joint: int) -> bool:
    kinds = mujoco.mjtTrn
    for a in range(len(m.actuator_trntype)):
        kind, target = m.actuator_trntype[a], m.actuator_trnid[a, 0]
        if kind in DIRECT and target == joint:
            return True
        if kind == kinds.mjTRN_TENDON:
            wraps = slice(m.tendon_adr[target], m.tendon_adr[target] + m.tendon_num[target])
            if joint in m.wrap_objid[wraps]:
                return True
    return False


def _shapes(mapping: Mapping, source: Source, rng, result: Comparison) -> None:
    """Compare the corners, or the box around, of every shape that can touch or is drawn."""
    m, d, model = mapping.m, mapping.d, mapping.model
    q, _ = mapping.randomise(rng)
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    for kind in (pin.GeometryType.COLLISION, pin.GeometryType.VISUAL):
        shapes = source.geometry(kind)
        if shapes is None:
            continue
        placed = shapes.createData()
        pin.updateGeometryPlacements(model, data, shapes, placed)
        counted: dict[str, int] = {}
        for item, place in zip(shapes.geometryObjects, placed.oMg, strict=True):
            body, _, number = item.name.rpartition("_")
            counted[body] = counted.get(body, 0) + 1
            geom = _terrainless(m, mapping.bodies[body])[int(number)]
            if item.meshPath or m.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
                mesh = m.geom_dataid[geom]
                first = m.mesh_vertadr[mesh]
                corners = m.mesh_vert[first : first + m.mesh_vertnum[mesh]].astype(float)
                expected = corners @ d.geom_xmat[geom].reshape(3, 3).T + d.geom_xpos[geom]
                found = np.array(item.geometry.vertices()) @ place.rotation.T + place.translation
                ends = [np.r_[p.min(axis=0), p.max(axis=0)] for p in (found, expected)]
                result.add("mesh (single precision)", ends[0] * 1e-3, ends[1] * 1e-3)
            else:
                result.add("shape", place.translation, d.geom_xpos[geom])
                result.add("shape", place.rotation, d.geom_xmat[geom].reshape(3, 3))


def _terrainless(m: mujoco.MjModel, body: int) -> list[int]:
    first = m.body_geomadr[body]
    terrain = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    geoms = range(first, first + m.body_geomnum[body])
    return [g for g in geoms if m.geom_type[g] not in terrain]
