"""The referee's impact against Pinocchio's KKT system, momentum balance and the reference file."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from paper_chain import chain_of_spec
from places import REFERENCE
from random_chains import (
    EXACT,
    pin_model,
    posture,
    random_cloud_chain,
    random_spec,
    relative,
    seeded,
)

from gaitopt.catalogue.biped_spec import biped13
from gaitopt.catalogue.urdf_writer import urdf_text
from gaitopt.errors import InputError
from gaitopt.mechanics.chain_build import chain_of_robot
from gaitopt.mechanics.newton_euler import (
    at_rest,
    base_in_sole_axes,
    impact,
    impulse_on_foot,
    inertia_matrix,
    momentum,
    sole_placement,
    swing_jacobian,
)
from gaitopt.model.robot import Robot

SOLVED = 1e-9  # relative: two linear solves with an inertia matrix of condition 1e5


def kkt(model, frame, q, v):
    """Velocity after the impact and impulse of the ground on the frame, in its own axes."""
    data = model.createData()
    D = pin.crba(model, data, posture(q)).copy()
    J = pin.computeFrameJacobian(model, data, posture(q), model.getFrameId(frame), pin.LOCAL)
    matrix = np.block([[D, -J.T], [J, np.zeros((6, 6))]])
    solution = np.linalg.solve(matrix, np.concatenate([D @ v, np.zeros(6)]))
    return solution[: model.nv], solution[model.nv :], J


def sole_jacobian(chain, q):
    """`swing_jacobian` taken to the sole frame by Pinocchio's transform of twists."""
    sole = pin.SE3(chain.tool_rotation, chain.tool_position)
    return sole.inverse().action @ swing_jacobian(chain, q)


@seeded
def test_jacobians_are_pinocchios(rng):
    chain, _ = random_cloud_chain(rng)
    q = rng.uniform(-2.0, 2.0, chain.dof)
    model = pin_model(chain, 9.81)
    data = model.createData()
    pin.computeJointJacobians(model, data, posture(q))
    last_link = pin.getJointJacobian(model, data, model.njoints - 1, pin.LOCAL).copy()
    sole = pin.computeFrameJacobian(model, data, posture(q), model.getFrameId("swing"), pin.LOCAL)
    assert relative(swing_jacobian(chain, q), last_link) < EXACT
    assert relative(sole_jacobian(chain, q), sole) < EXACT


@seeded
def test_impact_of_any_chain_solves_the_kkt_system(rng):
    chain, _ = random_cloud_chain(rng, n=8)
    chain = replace(chain, armature=rng.uniform(0.1, 1.0, chain.dof))
    q = rng.uniform(-2.0, 2.0, chain.dof)
    before = rng.uniform(-2.0, 2.0, 6 + chain.dof)
    after, impulse, J = kkt(pin_model(chain, 9.81), "swing", q, before)
    V_plus, I13 = impact(chain, q, before)
    assert relative(V_plus, after) < SOLVED
    assert relative(impulse_on_foot(chain, I13), impulse) < SOLVED
    # I13 itself, in R_n at O_n: the foot pushes the ground, Eq. (16).
    momenta = inertia_matrix(chain, q) @ (V_plus - before)
    assert relative(-swing_jacobian(chain, q).T @ I13, momenta) < SOLVED
    assert np.abs(J @ V_plus).max() < SOLVED * np.abs(J @ before).max()


@seeded
def test_spec_urdf_and_robot_agree_on_the_impact(rng):
    spec = random_spec(rng)
    robot = Robot.from_urdf(urdf_text(spec))
    q, rate = rng.uniform(-0.6, 0.6, (2, 12)) * np.array([[1.0], [3.0]])
    after, impulse, J = kkt(robot.model, robot.swing_sole, q, np.concatenate([np.zeros(6), rate]))
    D = pin.crba(robot.model, robot.model.createData(), posture(q))
    for chain in (chain_of_spec(spec), chain_of_robot(robot)):
        V_plus, I13 = impact(chain, q, at_rest(rate))
        assert relative(base_in_sole_axes(V_plus), after) < SOLVED
        assert relative(impulse_on_foot(chain, I13), impulse) < SOLVED
        turn = base_in_sole_axes(np.eye(18))  # same rows as columns: it is its own inverse
        assert relative(turn @ inertia_matrix(chain, q) @ turn, D) < EXACT
        assert relative(sole_jacobian(chain, q) @ turn, J) < EXACT


@seeded
def test_the_impulse_is_the_change_of_momentum_and_takes_energy(rng):
    chain = chain_of_spec(random_spec(rng))
    q, rate = rng.uniform(-0.6, 0.6, (2, 12))
    before = at_rest(3.0 * rate)
    after, I13 = impact(chain, q, before)
    gained = momentum(chain, q, after[6:], after[:6]) - momentum(chain, q, before[6:])
    rotation, origin = sole_placement(chain, q)
    on_foot = impulse_on_foot(chain, I13)
    force, moment = rotation @ on_foot[:3], rotation @ on_foot[3:]
    assert relative(np.concatenate([force, moment + np.cross(origin, force)]), gained) < SOLVED
    D = inertia_matrix(chain, q)
    assert after @ D @ after < before @ D @ before


def test_a_biped_dropped_flat_is_pushed_up():
    chain = chain_of_spec(biped13())
    q = np.zeros(12)
    falling = np.zeros(18)
    falling[0] = -0.7  # along x0, up [m/s]
    impulse = impulse_on_foot(chain, impact(chain, q, falling)[1])
    locked = 0.7 * chain.mass  # were the biped one rigid body it would be all of m v
    assert 0.1 * locked < impulse[2] < locked


def test_a_foot_that_lands_at_rest_changes_nothing():
    rng = np.random.default_rng(4)
    chain = chain_of_spec(biped13())
    q, before = rng.uniform(-0.5, 0.5, 12), rng.normal(size=18)
    settled, _ = impact(chain, q, before)
    again, I13 = impact(chain, q, settled)
    assert relative(again, settled) < SOLVED
    assert np.abs(I13).max() < SOLVED * np.abs(before).max() * chain.mass


@pytest.mark.parametrize("case", ["p43_v1.0_optimum", "p43_v1.0_infeasible"])
@pytest.mark.skipif(not REFERENCE.exists(), reason="needs the reference gaits")
def test_reference_impulse_and_velocity_after(case):
    data = np.load(REFERENCE)
    chain = replace(chain_of_spec(biped13()), sign=np.ones(12))
    q, rate = data[f"{case}/q_end"], data[f"{case}/rate_before"]
    after, I13 = impact(chain, q, at_rest(rate))
    assert relative(impulse_on_foot(chain, I13), data[f"{case}/impulse"]) < 1e-8
    assert relative(base_in_sole_axes(after), data[f"{case}/velocity_after"]) < 1e-8


def test_many_impacts_at_once_equal_one_at_a_time():
    rng = np.random.default_rng(5)
    chain = chain_of_spec(biped13())
    q, before = rng.uniform(-0.5, 0.5, (4, 12)), rng.normal(size=(4, 18))
    after, I13 = impact(chain, q, before)
    one = impact(chain, q[2], before[2])
    assert relative(after[2], one[0]) < SOLVED
    assert relative(I13[2], one[1]) < SOLVED
    assert relative(impulse_on_foot(chain, I13)[2], impulse_on_foot(chain, one[1])) < SOLVED


def test_bad_arguments_say_what_is_allowed():
    chain = chain_of_spec(biped13())
    with pytest.raises(InputError, match="give 18 finite velocities"):
        impact(chain, np.zeros(12), np.zeros(12))
    massless = replace(
        chain.links, mass=np.zeros(13), first_moment=np.zeros((13, 3)), inertia=np.zeros((13, 3, 3))
    )
    with pytest.raises(InputError, match="a joint moves no mass"):
        impact(replace(chain, links=massless), np.zeros(12), np.ones(18))
