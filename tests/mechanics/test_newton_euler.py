"""The referee's dynamics against Newton's law for particles, Pinocchio, and the reference file."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from paper_chain import chain_of_spec, zero_moment_point
from places import REFERENCE
from random_chains import (
    EXACT,
    UP,
    centre_of_mass,
    pin_model,
    posture,
    random_cloud_chain,
    random_spec,
    relative,
    seeded,
    slope,
)

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import EvaluationError, InputError
from gaitopt.mechanics import newton_euler
from gaitopt.mechanics.chain_build import chain_of_robot
from gaitopt.mechanics.newton_euler import (
    at_rest,
    impact,
    inertia_matrix,
    inverse_dynamics,
    joint_values,
    momentum,
    sole_axes,
)
from gaitopt.model.robot import Robot

DIFFERENCED = 1e-8  # relative: differences of fourth order at a step of 1 ms


def paper_signs(chain):
    return replace(chain, sign=np.ones(chain.dof))


@seeded
def test_wrench_and_torques_obey_newtons_law_for_particles(rng):
    chain, cloud = random_cloud_chain(rng)
    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, chain.dof))
    gravity = rng.uniform(1.0, 20.0)
    R0, torque = inverse_dynamics(chain, q, dq, ddq, gravity=gravity)

    def speed(t):
        return cloud.velocities(chain, q + t * dq + 0.5 * t * t * ddq, dq + t * ddq)

    force = cloud.mass()[:, None] * (slope(speed) + gravity * UP)
    x = cloud.positions(chain, q)
    assert relative(R0[:3], force.sum(axis=0)) < DIFFERENCED
    assert relative(R0[3:], np.cross(x, force).sum(axis=0)) < DIFFERENCED
    # D'Alembert: each torque does the work of all forces in its own virtual displacement.
    work = [np.sum(force * cloud.velocities(chain, q, e)) for e in np.eye(chain.dof)]
    assert relative(torque, np.array(work)) < DIFFERENCED


@seeded
def test_power_of_the_torques_is_the_rate_of_change_of_energy(rng):
    chain, cloud = random_cloud_chain(rng)
    chain = replace(chain, armature=rng.uniform(0.1, 1.0, chain.dof))
    q, dq, ddq = rng.uniform(-1.5, 1.5, (3, chain.dof))
    gravity = 9.81

    def energy(t):
        rate = dq + t * ddq
        links = cloud.energy(chain, q + t * dq + 0.5 * t * t * ddq, rate, gravity)
        return links + 0.5 * chain.armature @ rate**2

    power = slope(energy)
    torque = inverse_dynamics(chain, q, dq, ddq, gravity=gravity)[1]
    # Relative to the sum of the joints' powers: they may nearly cancel.
    assert abs(torque @ dq - power) < DIFFERENCED * np.abs(torque * dq).sum()


@seeded
def test_a_moving_base_and_an_end_wrench_agree_with_pinocchio(rng):
    chain, _ = random_cloud_chain(rng)
    chain = replace(chain, armature=rng.uniform(0.1, 1.0, chain.dof))
    q, dq, ddq = rng.uniform(-2.0, 2.0, (3, chain.dof))
    twist, acceleration, end = rng.uniform(-3.0, 3.0, (3, 6))
    R0, torque = inverse_dynamics(
        chain, q, dq, ddq, gravity=9.7,
        base_velocity=twist, base_acceleration=acceleration, end_wrench=end,
    )  # fmt: skip

    model = pin_model(chain, 9.7)
    data = model.createData()
    # Pinocchio's base acceleration is spatial: the origin's own, less omega x V.
    spatial = acceleration - np.concatenate([np.cross(twist[3:], twist[:3]), np.zeros(3)])
    forces = [pin.Force.Zero() for _ in range(model.njoints)]
    forces[-1] = pin.Force(-end)
    expected = pin.rnea(
        model, data, posture(q), np.concatenate([twist, dq]), np.concatenate([spatial, ddq]), forces
    )
    assert relative(np.concatenate([R0, torque]), expected) < EXACT


@seeded
def test_walkers_inertia_matrix_is_pinocchios(rng):
    chain, _ = random_cloud_chain(rng)
    chain = replace(chain, armature=rng.uniform(0.1, 1.0, chain.dof))
    q = rng.uniform(-2.0, 2.0, chain.dof)
    model = pin_model(chain, 9.81)
    expected = pin.crba(model, model.createData(), posture(q))
    D = inertia_matrix(chain, q)
    assert relative(D, expected) < EXACT
    assert relative(D, D.T) < EXACT


@seeded
def test_momentum_is_pinocchios(rng):
    chain, _ = random_cloud_chain(rng)
    q, dq = rng.uniform(-2.0, 2.0, (2, chain.dof))
    twist = rng.uniform(-3.0, 3.0, 6)
    model = pin_model(chain, 9.81)
    data = model.createData()
    h = pin.computeCentroidalMomentum(model, data, posture(q), np.concatenate([twist, dq]))
    com = np.array(data.com[0])
    expected = np.concatenate([h.linear, h.angular + np.cross(com, h.linear)])
    assert relative(sole_axes(momentum(chain, q, dq, twist)), expected) < EXACT


@seeded
def test_the_ground_wrench_changes_the_momentum(rng):
    chain = chain_of_spec(random_spec(rng))
    q, dq, ddq = rng.uniform(-0.6, 0.6, (3, 12)) * np.array([[1.0], [3.0], [20.0]])

    def moved(t):
        return momentum(chain, q + t * dq + 0.5 * t * t * ddq, dq + t * ddq)

    weight = np.array([0.0, 0.0, -9.81 * chain.mass])
    wrench = inverse_dynamics(chain, q, dq, ddq)[0]
    com = centre_of_mass(chain, q)
    expected = slope(moved) - np.concatenate([weight, np.cross(com, weight)])
    assert relative(sole_axes(wrench), expected) < DIFFERENCED


@seeded
def test_spec_urdf_and_robot_agree_on_torques_wrench_and_zmp(rng):
    spec = random_spec(rng)
    robot = Robot.from_urdf(urdf_text(spec))
    q, dq, ddq = rng.uniform(-0.6, 0.6, (3, 12)) * np.array([[1.0], [3.0], [10.0]])
    model = robot.model
    still = np.zeros(6)
    expected = pin.rnea(
        model, model.createData(), posture(q),
        np.concatenate([still, dq]), np.concatenate([still, ddq]),
    )  # fmt: skip
    fz, mx, my = expected[2], expected[3], expected[4]
    for chain in (chain_of_spec(spec), chain_of_robot(robot)):
        R0, torque = inverse_dynamics(chain, q, dq, ddq)
        assert relative(torque, expected[6:]) < EXACT
        assert relative(sole_axes(R0), expected[:6]) < EXACT
        assert relative(sole_axes(inverse_dynamics(chain, q, dq, ddq)[0]), expected[:6]) < EXACT
        assert relative(zero_moment_point(R0)[1], np.array([-my / fz, mx / fz])) < EXACT


@seeded
def test_no_moment_remains_at_the_zmp_along_the_sole(rng):
    force, moment = rng.uniform(-1.0, 1.0, (2, 3))
    force[0] = rng.uniform(0.1, 2.0)
    (y, z), (forward, left) = zero_moment_point(np.concatenate([force, moment]))
    point = np.array([0.0, y, z])
    remaining = moment - np.cross(point, force)
    # Eqs. (12) and (13) leave only the moment about the vertical x0 of forces in the sole.
    assert np.abs(remaining[1:]).max() < 1e-12 * np.abs(moment).max() / force[0]
    assert (forward, left) == (z, -y)


@pytest.mark.parametrize("case", ["p43_v1.0_optimum", "p43_v1.0_infeasible"])
@pytest.mark.skipif(not REFERENCE.exists(), reason="needs the reference gaits")
def test_reference_torques_wrench_and_centre_of_pressure(case):
    data = np.load(REFERENCE)
    q, dq, ddq = (data[f"{case}/{name}"] for name in ("q", "dq", "ddq"))
    chain = paper_signs(chain_of_spec(biped13()))
    R0, torque = inverse_dynamics(chain, q, dq, ddq)
    assert relative(torque, data[f"{case}/torque"]) < 1e-8
    assert relative(sole_axes(R0), data[f"{case}/ground_wrench"]) < 1e-8
    assert relative(zero_moment_point(R0)[1], data[f"{case}/cop"]) < 1e-8


def test_many_states_at_once_equal_one_at_a_time():
    rng = np.random.default_rng(8)
    chain, _ = random_cloud_chain(rng)
    q, dq, ddq = rng.normal(size=(3, 2, 5, chain.dof))
    R0, torque = inverse_dynamics(chain, q, dq, ddq)
    D = inertia_matrix(chain, q)
    one = inverse_dynamics(chain, q[1, 3], dq[1, 3], ddq[1, 3])
    assert R0.shape == (2, 5, 6)
    assert torque.shape == (2, 5, chain.dof)
    assert relative(R0[1, 3], one[0]) < EXACT
    assert relative(torque[1, 3], one[1]) < EXACT
    assert relative(D[1, 3], inertia_matrix(chain, q[1, 3])) < EXACT


def test_the_joint_values_change_sign_with_the_chain():
    rng = np.random.default_rng(9)
    chain, _ = random_cloud_chain(rng)
    q, dq, ddq = rng.normal(size=(3, chain.dof))
    R0, torque = inverse_dynamics(chain, q, dq, ddq)
    s = chain.sign
    R0_paper, torque_paper = inverse_dynamics(paper_signs(chain), s * q, s * dq, s * ddq)
    assert relative(R0_paper, R0) < EXACT
    assert relative(torque_paper, s * torque) < EXACT


def test_the_referee_shares_no_code_with_what_it_judges():
    text = Path(newton_euler.__file__).read_text(encoding="utf-8")
    imported = set(re.findall(r"^\s*(?:from|import) (\S+)", text, flags=re.MULTILINE))
    own = {f"gaitopt.{name}" for name in ("bounds", "dataclass", "errors", "nlp")}
    assert "numpy" in imported
    assert imported <= own | {
        "__future__",
        "math",
        "dataclasses",
        "numpy",
        "numpy.typing",
        "collections.abc",
    }


def test_bad_arguments_say_what_is_allowed():
    chain = chain_of_spec(biped13())
    good = np.zeros(12)
    with pytest.raises(InputError, match=r"ddq has shape \(11,\)"):
        inverse_dynamics(chain, good, good, np.zeros(11))
    with pytest.raises(InputError, match="q has an entry that is not finite"):
        inverse_dynamics(chain, np.full(12, np.nan), good, good)
    with pytest.raises(InputError, match="end_wrench has shape"):
        inverse_dynamics(chain, good, good, good, end_wrench=np.zeros(3))
    with pytest.raises(InputError, match=r"shapes of different leading axes: q \(2, 12\)"):
        inverse_dynamics(chain, np.zeros((2, 12)), np.zeros((3, 12)), good)
    with pytest.raises(InputError, match=r"leading axes.*v_minus \(3, 18\)"):
        impact(chain, np.zeros((2, 12)), np.zeros((3, 18)))
    for gravity, told in (("moon", "gravity is 'moon'"), ([1.0, 2.0], r"gravity has shape \(2,\)")):
        with pytest.raises(InputError, match=told):
            inverse_dynamics(chain, good, good, good, gravity=gravity)
    for given in ("fast", [[1.0], [1.0, 2.0]], {}, 1j):
        for asked in (
            lambda one: joint_values(chain, "q", one),
            lambda one: impact(chain, good, one),
            lambda one: impact(chain, good, np.zeros(18), ties=one),
            lambda one: impact(chain, good, np.zeros(18), free=one),
            at_rest,
        ):
            with pytest.raises(InputError, match=r"is .*; give an array of numbers"):
                asked(given)
    with pytest.raises(EvaluationError, match="0 N"):
        zero_moment_point(np.zeros(6))


def test_tables_that_are_none_say_what_is_allowed():
    chain = chain_of_spec(biped13())
    for one, name, given, told in (
        (
            chain.joints,
            "alpha",
            "twelve texts",
            "alpha is 'twelve texts'; give an array of numbers",
        ),
        (chain.joints, "alpha", 1.0, r"alpha has shape \(\); give one number each"),
        (chain.joints, "d", ["0.1"] * 12, r"d is \['0.1', .*; give an array of numbers"),
        (chain.joints, "theta", None, "theta is None; give an array of numbers"),
        (chain.joints, "r", [[0.0], [0.0, 1.0]], "r is .*; give an array of numbers"),
        (chain.joints, "beta", "none", "beta is 'none'; give an array of numbers"),
        (chain.joints, "beta", [0.0, 0.0], r"beta has shape \(2,\); give shape \(12,\)"),
        (chain.joints, "antecedent", "abc", "antecedent is 'abc'; give an array of numbers"),
        (chain.joints, "antecedent", np.ones(12), "a link before it"),
        (chain.links, "mass", 3.0, r"mass has shape \(\); give one number each"),
        (chain.links, "inertia", "heavy", "inertia is 'heavy'; give an array of numbers"),
        (chain, "sign", "+" * 12, "sign is .*; give an array of numbers"),
        (chain, "joints", np.zeros(12), "joints of the chain is .*; give a JointTable"),
        (chain, "links", None, "links of the chain is None; give a LinkTable"),
        (chain, "end", 13, "end = 13 is not allowed; the last link is 12"),
        (chain, "end", "last", "end of the chain is 'last'; give the number of a link"),
    ):
        with pytest.raises(InputError, match=told):
            replace(one, **{name: given})
