"""The MuJoCo model of a gait as a file: robot, soles, motors, ground, and the walk as keyframes."""

from __future__ import annotations

from gaitopt.bounds import at_most
from gaitopt.errors import InputError
from gaitopt.gait.result import Gait
from gaitopt.simulate.mujoco_model import ContactOptions, robot_spec, simulated_robot

RATE = 50.0
"""Of the keyframes by default [Hz]."""
START = "start"
"""Name of the keyframe on the cycle at which the walk starts; the others are `reference N`."""
_KEYFRAMES = 20_000


def mjcf_text(
    gait: Gait,
    rate: float = RATE,
    strides: float = 1.0,
    contact: ContactOptions | None = None,
) -> str:
    """Return the robot of a gait as MJCF, in the form in which `simulate` walks it.

    Joints that the walk does not move are welded. Each foot has a ground of its own, a mocap body.
    Keyframes hold `qpos`, `qvel`, the torques of the design as `ctrl`, and the time.

    Args:
        gait: whose robot and walk.
        rate: keyframes a second [Hz].
        strides: number of periods that they last.
        contact: ground and integrator.

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
    robot = simulated_robot(body, limit, contact)
    spec = robot_spec(body, limit, contact)
    samples = trajectory.at(times)
    for row, time in enumerate(times):
        q, v = samples.configuration[row], samples.velocity[row]
        qpos, qvel = robot.position(q), robot.velocity(q, v)
        torque = samples.torque[row, body.moving]
        names = (START, f"reference {row}") if row == 0 else (f"reference {row}",)
        for name in names:
            spec.add_key(name=name, time=float(time), qpos=qpos, qvel=qvel, ctrl=torque)
    spec.compile()
    return str(spec.to_xml())
