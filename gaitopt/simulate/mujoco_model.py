"""The MuJoCo model of the robot of a gait: bodies, joints, motors, soles, the ground; as a file.

Joints that the walk does not move are welded at the angle at which they stand; those that follow
others are held to them by an equality. The world is that of `gaitopt.gait.trajectory`: the ground
is the plane z = 0, gravity is that of the gait.
"""

from __future__ import annotations

from functools import cached_property

import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from gaitopt.bounds import at_most
from gaitopt.dataclass import dataclass
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.importers.pinocchio_model import rigid_body
from gaitopt.model.multibody import BASE, Multibody
from gaitopt.nlp import Array

_SOLE_THICKNESS = 0.02  # m, of the boxes that touch the ground
_LEAST_MASS = 1e-12  # kg and kg·m²: MuJoCo refuses moving bodies without any
_STIFF = [0.999, 0.9999, 1e-4, 0.5, 2.0]  # MuJoCo's `solimp`: ties of joints hardly give way
FRICTION = 0.8  # sliding coefficient of soles on the ground, where none is given
CONTACT_TIME = 0.004  # s, time constant of the contact, MuJoCo's `solref`
TIMESTEP = 0.001  # s, of the integrator
RATE = 50.0
"""Of the keyframes by default [Hz]."""
START = "start"
"""Name of the keyframe on the cycle at which the walk starts; the others are `reference N`."""
_KEYFRAMES = 20_000
_FEET_BITS, _GROUND_BITS = (1, 4), (2, 8)  # each foot touches the ground under it, nothing else


@dataclass(frozen=True, eq=False)
class SimulatedRobot:
    """A compiled model and where the gait's joints and soles are in it.

    Attributes:
        model: MuJoCo's; treat it as read-only.
        body: the robot that it was made of.
        qpos: addresses of the moving joints in `qpos`, in the order of `body.moving`, shape (n,).
        dof: their addresses in `qvel`, shape (n,).
        tied: addresses of the joints that follow others in `qpos` and in `qvel`, in the order of
            `body.tied`, shape (2, t).
        site: sole frames, in the order of `body.sole_names`.
        geom: boxes of the soles, likewise.
        ground: mocap bodies of the planes under the soles, likewise; each foot has its own.
        base: number of the base's body.
    """

    model: mujoco.MjModel
    body: Multibody
    qpos: NDArray[np.int64]
    dof: NDArray[np.int64]
    tied: NDArray[np.int64]
    site: tuple[int, int]
    geom: tuple[int, int]
    ground: tuple[int, int]
    base: int

    @cached_property
    def mass(self) -> float:
        """Mass of the robot [kg]."""
        return float(self.model.body_mass.sum())

    @cached_property
    def weight(self) -> float:
        """Weight of the robot [N]."""
        return self.mass * float(np.linalg.norm(self.body.gravity))

    @cached_property
    def motors(self) -> NDArray[np.int64]:
        """Numbers of the moving joints' actuators, in the order of `body.moving`, shape (n,)."""
        return np.argsort(np.argsort(self.body.moving))

    @cached_property
    def driven(self) -> NDArray[np.int64]:
        """Addresses in `qvel` of all joints, in the order of `body.driven`, shape (n + t,)."""
        return np.concatenate([self.dof, self.tied[1]])

    def place(self, data: mujoco.MjData, configuration: Array, velocity: Array) -> None:
        """Put data into a state of `Multibody.model`, velocity (6 + M,) in [m/s, rad/s]."""
        data.qpos[:] = self.position(configuration)
        data.qvel[:] = self.velocity(configuration, velocity)

    def sole(self, data: mujoco.MjData, foot: int) -> pin.SE3:
        """Return where a sole frame is in the world."""
        return pin.SE3(self.sole_axes(data, foot).copy(), data.site_xpos[self.site[foot]].copy())

    def sole_axes(self, data: mujoco.MjData, foot: int) -> Array:
        """Return the axes of a sole frame in the world, columns (3, 3)."""
        return np.asarray(data.site_xmat[self.site[foot]].reshape(3, 3))

    def sole_jacobian(self, data: mujoco.MjData, foot: int) -> Array:
        """Return the Jacobian of a sole frame, linear rows first, in the world's axes, (6, nv)."""
        J = np.zeros((6, self.model.nv))
        mujoco.mj_jacSite(self.model, data, J[:3], J[3:], self.site[foot])
        return J

    def free(self, qpos: Array) -> Array:
        """Return velocities `qvel` per velocity of base and motors, shape (nv, 6 + n)."""
        return self._free_at(qpos) if self.body.bends else self._constant_free

    def mass_matrix(self, data: mujoco.MjData) -> Array:
        """Return the mass matrix at a state, shape (nv, nv)."""
        found = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, data, found)
        return found

    @cached_property
    def _constant_free(self) -> Array:
        return self._free_at(np.zeros(self.model.nq))

    def _free_at(self, qpos: Array) -> Array:
        found = np.zeros((self.model.nv, 6 + len(self.dof)))
        found[:6, :6], found[self.driven, 6:] = np.eye(6), self.body.coupling(qpos[self.qpos])
        return found

    def drift(self, qpos: Array, qvel: Array) -> Array:
        """Return the accelerations of joints that follow others evenly turning, shape (nv,)."""
        found = np.zeros(self.model.nv)
        if self.body.bends:
            _, _, second = self.body.followers(qpos[self.qpos[self.body.led]])
            found[self.tied[1]] = second * qvel[self.dof[self.body.led]] ** 2
        return found

    def follow(self, qpos: Array, qvel: Array) -> None:
        """Write into a state (nq,), (nv,) where joints that follow others are, and their rates."""
        value, slope, _ = self.body.followers(qpos[self.qpos[self.body.led]])
        qpos[self.tied[0]] = value
        qvel[self.tied[1]] = slope * qvel[self.dof[self.body.led]]

    def position(self, configuration: Array) -> Array:
        """Return `qpos` of a configuration of `Multibody.model`, shape (7 + n,)."""
        q = np.empty(self.model.nq)
        q[:3], q[3], q[4:7] = configuration[:3], configuration[6], configuration[3:6]
        q[self.qpos] = configuration[7 + self.body.moving]
        q[self.tied[0]] = configuration[7 + self.body.tied]
        return q

    def configuration(self, qpos: Array) -> Array:
        """Return configurations (N, 7 + M) of `Multibody.model` of rows `qpos` (N, 7 + n)."""
        body = self.body
        found = np.empty((len(qpos), 7 + len(body.joint_names)))
        found[:, :3], found[:, 3:6], found[:, 6] = qpos[:, :3], qpos[:, 4:7], qpos[:, 3]
        found[:, 7:] = body.posture
        found[:, 7 + body.moving] = qpos[:, self.qpos]
        found[:, 7 + body.tied] = qpos[:, self.tied[0]]
        return found

    def velocity(self, configuration: Array, velocity: Array) -> Array:
        """Return `qvel` (6 + n,) [m/s, rad/s] of configuration and velocity of `Multibody.model`.

        MuJoCo has the linear velocity of the base in the world, the angular one in its own axes.
        """
        v = np.empty(self.model.nv)
        v[:3] = _rotation(configuration) @ velocity[:3]
        v[3:6] = velocity[3:6]
        v[self.driven] = velocity[6 + self.body.driven]
        return v

    def acceleration(self, configuration: Array, velocity: Array, acceleration: Array) -> Array:
        """Return `qacc` of a motion of `Multibody.model`, shape (6 + n,) [m/s², rad/s²]."""
        change = acceleration.copy()
        change[:3] += np.cross(velocity[3:6], velocity[:3])  # the axes of the base turn
        return self.velocity(configuration, change)


def simulated_robot(
    body: Multibody, torque_limit: Array | None = None, friction: float = FRICTION
) -> SimulatedRobot:
    """Return the compiled MuJoCo model of a robot; arguments as in `robot_spec`.

    Raises:
        InputError: it cannot be simulated, or MuJoCo refuses the model.
    """
    spec = robot_spec(body, torque_limit, friction)
    try:
        model = spec.compile()
    except ValueError as error:
        raise InputError(f"MuJoCo refuses the robot of the gait: {error}") from error
    places = [model.joint(body.joint_names[joint]) for joint in body.driven]
    qpos, dof = (
        np.array([int(getattr(place, name)[0]) for place in places], dtype=np.int64)
        for name in ("qposadr", "dofadr")
    )
    count = len(body.moving)
    return SimulatedRobot(
        model=model,
        body=body,
        qpos=qpos[:count],
        dof=dof[:count],
        tied=np.stack([qpos[count:], dof[count:]]),
        site=(model.site("sole 0").id, model.site("sole 1").id),
        geom=(model.geom("sole 0").id, model.geom("sole 1").id),
        ground=(_mocap(model, "ground 0"), _mocap(model, "ground 1")),
        base=int(model.jnt_bodyid[0]),
    )


def robot_spec(
    body: Multibody, torque_limit: Array | None = None, friction: float = FRICTION
) -> mujoco.MjSpec:
    """Return the MuJoCo model of a robot before it is compiled.

    Args:
        torque_limit: of the motors of the moving joints [N·m], shape (n,); NaN or None: unlimited.
        friction: sliding coefficient of soles on the ground.

    Raises:
        InputError: it cannot be simulated: part of its weight is carried from outside, a passive
            joint torque has no form in MuJoCo.
    """
    if body.carried is not None:
        raise InputError(
            "part of the robot's weight is carried from outside (gravity compensation); such a "
            "robot cannot be simulated yet"
        )
    limit = np.full(len(body.moving), np.nan) if torque_limit is None else torque_limit
    spec = _empty_world(body, friction)
    parents, inertias = _welded(body)
    bodies = {BASE: spec.worldbody.add_body(name=f"base {body.base}")}
    bodies[BASE].add_freejoint()
    for joint in range(len(body.joint_names)):
        if joint not in body.driven:
            continue
        parent, inside = parents[joint]
        place = inside * pin.SE3(body.placement[joint])
        bodies[joint] = bodies[parent].add_body(
            name=f"body {body.joint_names[joint]}", pos=place.translation, quat=_wxyz(place)
        )
        _add_joint(bodies[joint], body, joint)
    for joint, inertia in inertias.items():
        _set_inertia(bodies[joint], inertia)
    for joint, most in sorted(zip(body.moving, limit, strict=True)):  # as MuJoCo has the joints
        name = body.joint_names[joint]
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        if np.isfinite(most):
            motor.forcelimited, motor.forcerange = True, [-most, most]
    for joint, master, (multiplier, offset), bend in zip(
        body.tied, body.tied_to, body.tie, body.tie_bend, strict=True
    ):
        tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, objtype=mujoco.mjtObj.mjOBJ_JOINT)
        tie.name1, tie.name2 = body.joint_names[joint], body.joint_names[master]
        tie.data[:5] = offset, multiplier, *bend
        tie.solref, tie.solimp = [2.0 * TIMESTEP, 1.0], _STIFF
    for foot in (0, 1):
        _add_sole(bodies, parents, body, foot, friction)
    return spec


def mjcf_text(
    gait: Gait,
    rate: float = RATE,
    strides: float = 1.0,
) -> str:
    """Return the robot of a gait as MJCF, in the form in which `simulate` walks it.

    Joints that the walk does not move are welded. Each foot has a ground of its own, a mocap body.
    Keyframes hold `qpos`, `qvel`, the torques of the design as `ctrl`, and the time.

    Args:
        rate: keyframes a second [Hz].
        strides: number of periods that they last.

    Raises:
        InputError: the robot cannot be simulated, or the rate or the number is out of range.
        RobotError: the gait has no robot of its own, and its URDF is not its robot.
    """
    trajectory, limit = gait.trajectory, gait.joint_limit("torque")
    body = trajectory.body
    times = trajectory.times(rate, strides)
    at_most(len(times), _KEYFRAMES, "keyframes", "lower the rate or the strides")
    if not len(times):
        raise InputError(f"{rate:g} Hz and {strides:g} strides give no keyframe; raise them")
    robot = simulated_robot(body, limit)
    spec = robot_spec(body, limit)
    samples = trajectory.at(times)
    for row, time in enumerate(times):
        q, v = samples.configuration[row], samples.velocity[row]
        qpos, qvel = robot.position(q), robot.velocity(q, v)
        torque = samples.torque[row, np.sort(body.moving)]
        names = (START, f"reference {row}") if row == 0 else (f"reference {row}",)
        for name in names:
            spec.add_key(name=name, time=float(time), qpos=qpos, qvel=qvel, ctrl=torque)
    spec.compile()
    return str(spec.to_xml())


def _empty_world(body: Multibody, friction: float) -> mujoco.MjSpec:
    spec = mujoco.MjSpec()
    spec.modelname = body.name
    spec.compiler.degree = False
    option = spec.option
    option.gravity = body.gravity
    option.timestep = TIMESTEP
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC  # with pyramids a box slides at 0.7 of friction
    option.impratio = 10.0  # a box below its friction limit creeps 20 times less than with 1
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # the sparse factorisation of 4.0.0 is wrong
    option.iterations = 50
    for foot in (0, 1):
        ground = spec.worldbody.add_body(name=f"ground {foot}", mocap=True)
        ground.add_geom(
            name=f"ground {foot}",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            contype=_GROUND_BITS[foot],
            conaffinity=_FEET_BITS[foot],
            **_surface(friction),
        )
    return spec


def _mocap(model: mujoco.MjModel, name: str) -> int:
    return int(model.body(name).mocapid[0])


def _surface(friction: float) -> dict[str, object]:
    return {
        "friction": [friction, 0.005, 1e-4],
        "solref": [CONTACT_TIME, 1.0],
        "condim": 3,
    }


def _welded(
    body: Multibody,
) -> tuple[dict[int, tuple[int, pin.SE3]], dict[int, pin.Inertia]]:
    """Return where the bodies sit once the joints that stand still are welded.

    Returns:
        For each joint the moving joint, or the base, to which its placement refers, with the frame
        in that body; the whole inertia of each moving body and of the base in its own frame.
    """
    carrier = {BASE: (BASE, pin.SE3.Identity())}
    parents: dict[int, tuple[int, pin.SE3]] = {}
    inertias = {BASE: _inertia(body, BASE)}
    moving = set(body.driven.tolist())
    for joint in range(len(body.joint_names)):
        on, inside = parents[joint] = carrier[int(body.parent[joint])]
        if joint in moving:
            carrier[joint] = joint, pin.SE3.Identity()
            inertias[joint] = _inertia(body, joint)
            continue
        twist = np.zeros(6)
        twist[3 * int(body.revolute[joint]) :][:3] = body.axis[joint] * body.posture[joint]
        place = inside * pin.SE3(body.placement[joint]) * pin.exp6(pin.Motion(twist))
        carrier[joint] = on, place
        inertias[on] += place.act(_inertia(body, joint))
    parents |= {-2 - foot: carrier[int(joint)] for foot, joint in enumerate(body.sole_joint)}
    return parents, inertias


def _inertia(body: Multibody, joint: int) -> pin.Inertia:
    row = joint + 1
    return rigid_body(float(body.mass[row]), body.centre[row], body.inertia[row])


def _add_joint(owner: mujoco.MjsBody, body: Multibody, joint: int) -> None:
    """Add a joint with its rotor, friction, damping and spring."""
    kind = mujoco.mjtJoint.mjJNT_HINGE if body.revolute[joint] else mujoco.mjtJoint.mjJNT_SLIDE
    made = owner.add_joint(name=body.joint_names[joint], type=kind, axis=body.axis[joint])
    made.armature, made.frictionloss = float(body.armature[joint]), float(body.friction[joint])
    made.damping = _coefficients(made.damping, body.damping[joint], "damping")
    made.stiffness = _coefficients(made.stiffness, body.stiffness[joint], "a spring")
    made.springref = float(body.rest[joint])


def _coefficients(old: float | Array, values: Array, what: str) -> float | Array:
    """Return the coefficients of a polynomial in the form of this MuJoCo: 1 before 4.0, then 3."""
    form = np.atleast_1d(np.asarray(old, dtype=np.float64))
    if values[len(form) :].any():
        raise InputError(
            f"the robot has {what} of degree {len(values)}; MuJoCo {mujoco.__version__} has "
            f"{len(form)} at most"
        )
    form[: len(values)] = values[: len(form)]
    return form if np.ndim(old) else float(form[0])


def _set_inertia(made: mujoco.MjsBody, inertia: pin.Inertia) -> None:
    """Give a body its mass and its principal moments of inertia."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    made.mass = max(float(inertia.mass), _LEAST_MASS)
    made.ipos = inertia.lever if inertia.mass else np.zeros(3)
    made.iquat = _wxyz(pin.SE3(axes, np.zeros(3)))
    made.inertia = np.maximum(moments, _LEAST_MASS)
    made.explicitinertial = True


def _add_sole(
    bodies: dict[int, mujoco.MjsBody],
    parents: dict[int, tuple[int, pin.SE3]],
    body: Multibody,
    foot: int,
    friction: float,
) -> None:
    """Add the frame of a sole and the box that touches the ground."""
    on, inside = parents[-2 - foot]
    place = inside * pin.SE3(body.sole_placement[foot])
    toe, heel, left, right = body.sole_rectangle[foot]
    centre = np.array([(toe + heel) / 2.0, (left + right) / 2.0, _SOLE_THICKNESS / 2.0])
    bodies[on].add_site(name=f"sole {foot}", pos=place.translation, quat=_wxyz(place))
    bodies[on].add_geom(
        name=f"sole {foot}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[(toe - heel) / 2.0, (left - right) / 2.0, _SOLE_THICKNESS / 2.0],
        pos=place.act(centre),
        quat=_wxyz(place),
        mass=0.0,
        contype=_FEET_BITS[foot],
        conaffinity=_GROUND_BITS[foot],
        **_surface(friction),
    )


def _rotation(configuration: Array) -> Array:
    x, y, z, w = configuration[3:7]
    return np.asarray(pin.Quaternion(w, x, y, z).matrix())


def _wxyz(place: pin.SE3) -> Array:
    """Return the rotation of a placement as MuJoCo's quaternion."""
    x, y, z, w = pin.Quaternion(place.rotation).coeffs()
    return np.array([w, x, y, z])
