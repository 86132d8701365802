"""URDFs damaged at random: read to the last digit, or refused; never another robot."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from urdf_mutations import mutate_urdf, strict_facts

from gaitopt import biped13, urdf_text
from gaitopt.errors import RobotError
from gaitopt.robot.files.source import read_source

CASES = Path(__file__).parents[1] / "data" / "cases"
MUTATIONS = 45  # of each: 180 in all; a fuzzer takes `mutate_urdf` for more
TEXTS = {
    "biped13": urdf_text(biped13()),
    "base_mini": (CASES / "base_mini.urdf").read_text(encoding="utf-8"),
    "damped": (CASES / "urdf_damping_friction.urdf").read_text(encoding="utf-8"),
    "turned": (CASES / "unnamed_material.urdf").read_text(encoding="utf-8"),
}
ROUNDING = 1e-9  # relative
REPAIRED = 2e-6  # of an inertia that lay outside of what a body can have by less than this


def assert_as_in_the_file(source, rng):
    """The model has the masses, limits and kinematics that a second reader finds in the text."""
    model = source.model()
    q = np.array(pin.neutral(model))
    angles = {}
    for joint in range(2, model.njoints):
        if model.joints[joint].nq == 1:
            angles[str(model.names[joint])] = q[model.joints[joint].idx_q] = rng.uniform(-1, 1)
    facts = strict_facts(source.text, angles)
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    for index, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.BODY:
            place = facts.places[frame.name]
            size = 1.0 + np.abs(place).max()
            gap = np.abs(data.oMf[index].homogeneous - place).max()
            assert gap < ROUNDING * size, frame.name
    links = {f.name for f in model.frames if f.type == pin.FrameType.BODY}
    assert links == set(facts.places)
    bodies = {"": model.inertias[1]}
    bodies |= {str(model.names[j]): model.inertias[j] for j in range(2, model.njoints)}
    assert set(bodies) == set(facts.bodies)
    for name, body in facts.bodies.items():
        found = bodies[name]
        assert found.mass == pytest.approx(body.mass, rel=ROUNDING, abs=1e-300)
        np.testing.assert_allclose(found.mass * found.lever, body.first, rtol=1e-9, atol=1e-9)
        about = pin.SE3(np.eye(3), np.zeros(3)).act(found).matrix()[3:, 3:]
        scale = np.abs(body.second).max()
        np.testing.assert_allclose(about, body.second, rtol=0, atol=REPAIRED * scale + 1e-12)
    for name, limits in facts.limits.items():
        joint = model.joints[model.getJointId(name)]
        fields = ("effortLimit", "velocityLimit", "lowerPositionLimit", "upperPositionLimit")
        rows = (joint.idx_v, joint.idx_v, joint.idx_q, joint.idx_q)
        found = tuple(getattr(model, f)[r] for f, r in zip(fields, rows, strict=True))
        assert found == limits, name
        passive = source.physics.joints.get(name)
        damping, friction = facts.passive[name]
        assert (sum(passive.damping) if passive else 0.0) == damping
        assert (passive.friction if passive else 0.0) == friction


def read_or_none(text):
    """The description if it can be read, None if it is refused."""
    try:
        source = read_source(text)
        source.model()
    except RobotError:
        return None
    return source


@pytest.mark.parametrize("name", TEXTS)
def test_a_sound_file_is_read_to_the_last_digit(name, rng):
    assert_as_in_the_file(read_source(TEXTS[name]), rng)


@pytest.mark.parametrize("name", TEXTS)
def test_a_damaged_file_is_read_as_it_is_or_refused(name, capfd):
    read, refused = 0, 0
    for seed in range(MUTATIONS):
        rng = np.random.default_rng([seed, len(TEXTS[name])])
        text = mutate_urdf(TEXTS[name], rng, times=1 + seed % 3)
        source = read_or_none(text)
        if source is None:
            refused += 1
            continue
        read += 1
        source.geometry(pin.GeometryType.VISUAL)
        source.geometry(pin.GeometryType.COLLISION)
        source.mesh_problems()
        source.findings()
        assert_as_in_the_file(source, rng)
    assert min(read, refused) >= 5
    assert capfd.readouterr() == ("", "")
