"""The MuJoCo model of a gait as a file, read back by MuJoCo."""

import mujoco
import numpy as np
import pytest
from sample_gait import sample_gait

from gaitopt.errors import InputError
from gaitopt.motions.export import export
from gaitopt.simulate.mujoco_model import START, mjcf_text, simulated_robot

READ = 1e-5  # MuJoCo writes numbers with so many digits


@pytest.fixture(scope="module")
def gait():
    return sample_gait()


@pytest.fixture(scope="module")
def model(gait):
    return mujoco.MjModel.from_xml_string(mjcf_text(gait, rate=40.0))


def test_the_robot_is_that_of_the_simulation(gait, model):
    own = simulated_robot(gait.trajectory.body, gait.joint_limit("torque")).model
    assert (model.nq, model.nv, model.nu) == (own.nq, own.nv, own.nu)
    for name in ("body_mass", "body_inertia", "body_ipos", "actuator_forcerange", "geom_size"):
        assert getattr(model, name) == pytest.approx(getattr(own, name), rel=READ, abs=1e-9)
    for name in ("timestep", "cone", "impratio", "integrator", "jacobian"):
        assert getattr(model.opt, name) == pytest.approx(getattr(own.opt, name), rel=READ)


def test_keyframes_are_the_walk(gait, model):
    times = gait.trajectory.times(40.0)
    assert model.nkey == 1 + len(times)
    row = len(times) // 2 + 1  # in the second step
    key = model.key(f"reference {row}")
    samples = gait.trajectory.at(times[row])
    robot = simulated_robot(gait.trajectory.body)
    q, v = samples.configuration[0], samples.velocity[0]
    assert key.time[0] == pytest.approx(times[row], rel=READ)
    assert key.qpos == pytest.approx(robot.position(q), rel=READ, abs=READ)
    assert key.qvel == pytest.approx(robot.velocity(q, v), rel=READ, abs=READ)
    torque = samples.torque[0, gait.trajectory.body.moving]
    assert key.ctrl[robot.motors] == pytest.approx(torque, rel=READ, abs=READ)


def test_arrays_in_its_order_are_its_keyframes(gait, model, tmp_path):
    """Joints, rates and motors: a tracker need not sort anything."""
    hinges = [model.joint(k).name for k in range(1, model.njnt)]
    assert [model.actuator(k).name for k in range(model.nu)] == hinges
    path = export(gait, tmp_path / "m.npz", format="mujoco", rate=40.0, joints="mjcf")
    with np.load(path) as arrays:
        assert arrays["joint_names"].tolist() == hinges != list(gait.joint_names)
        for name, frames in (("qpos", "qpos"), ("qvel", "qvel"), ("torque", "ctrl")):
            found = getattr(model, f"key_{frames}")[1:]
            assert found == pytest.approx(arrays[name], rel=READ, abs=READ)


def test_the_start_stands_on_the_ground(gait, model):
    """With the designed torques the robot neither sinks nor jumps at once."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(START).id)
    mujoco.mj_forward(model, data)
    soles = [data.site(f"sole {foot}") for foot in (0, 1)]
    assert [sole.xpos[2] for sole in soles] == pytest.approx([0.0, 0.0], abs=1e-5)
    before = soles[0].xpos.copy()
    for _ in range(5):  # later the foot of this gait twists, which has no limit of that
        mujoco.mj_step(model, data)
    assert np.abs(soles[0].xpos - before).max() < 2e-3  # stands
    after = gait.trajectory.at(data.time).q[0, gait.trajectory.body.moving]
    robot = simulated_robot(gait.trajectory.body)
    assert data.qpos[robot.qpos] == pytest.approx(after, abs=0.05)  # and walks


def test_what_gives_no_keyframes_is_refused(gait):
    with pytest.raises(InputError, match="both must be finite numbers above 0"):
        mjcf_text(gait, rate=-1.0)
    with pytest.raises(InputError, match="keyframes are too many"):
        mjcf_text(gait, rate=50_000.0)
