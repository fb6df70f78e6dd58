"""Columns times the arm's own parameters are its torques, on both roads; base parameters are as many as theory says."""

from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.dynamics.regressor import Regressor
from lwr_dyn.foundation.errors import MissingPackageError, OptionError, ShapeError
from lwr_dyn.identification.regression import torque_columns
from lwr_dyn.identification.regression.least_squares import base_parameters
from lwr_dyn.identification.regression.torque_columns import JointColumns, TorqueColumns
from lwr_dyn.model.chain import JointKind
from lwr_dyn.model.friction import Direction, JointFriction, friction_torque
from lwr_dyn.model.transmission import Transmission

STATES = 40


def states(n, seed=0):
    return np.random.default_rng(seed).uniform(-2.0, 2.0, (3, STATES, n))


@pytest.mark.parametrize("robot", ["lwr4plus", "wam7"])
@pytest.mark.parametrize("engine", ["newton-euler", "pinocchio"])
def test_own_parameters_give_the_arms_torques_and_friction(robot, engine):
    arm = lwr_dyn.load(robot)
    q, dq, ddq = states(arm.n)
    columns = TorqueColumns(arm.chain, "directions")
    wanted = lwr_dyn.dynamics_of(arm, engine).inverse_dynamics(q, dq, ddq) + friction_torque(arm.friction_models(), dq)
    assert columns(q, dq, ddq) @ columns.own(arm) == pytest.approx(wanted, abs=1e-11 * np.abs(wanted).max())


def test_without_a_compiler_the_columns_are_the_same(monkeypatch):
    arm = lwr_dyn.load("lwr4plus")
    fast = TorqueColumns(arm.chain)

    def missing():
        raise MissingPackageError("llvmlite", "batch")

    monkeypatch.setattr(torque_columns, "require_packages", missing)
    slow, x = TorqueColumns(arm.chain), states(arm.n)
    assert fast.kernel is not None
    assert slow.kernel is None
    assert np.abs(fast(*x) - slow(*x)).max() < 1e-12
    assert slow.base().statements() == fast.base().statements()
    assert (slow.body_columns(*x) == Regressor(arm.chain)(*x)[:, :, :70]).all()


@pytest.mark.parametrize(
    ("form", "stribeck", "columns", "base"),
    [("symmetric", None, 98, 69), ("directions", None, 105, 76), ("symmetric", 0.05, 105, 76)],
)
def test_a_seven_joint_arm_has_as_many_base_parameters_as_is_known(form, stribeck, columns, base):
    """43 of bodies; the rotors of joints 1 and 2 merge with Izz and so 5 more; the rest is friction."""
    arm = lwr_dyn.load("lwr4plus")
    found = TorqueColumns(arm.chain, form, None if stribeck is None else np.full(7, stribeck))
    assert (found.count, found.base().count) == (columns, base)
    inertial = np.append(np.arange(found.bodies), found.rotor_indices)
    assert np.count_nonzero(np.isin(found.base().kept, inertial)) == 48


@pytest.mark.slow
def test_a_sliding_joint_has_columns_too():
    chain, x = lwr_dyn.load("lwr4plus").chain, states(7)
    links = [replace(link, kind=JointKind.PRISMATIC) if i == 2 else link for i, link in enumerate(chain.links)]
    sliding = replace(chain, links=tuple(links))
    assert np.abs(TorqueColumns(sliding).body_columns(*x) - Regressor(sliding)(*x)[:, :, :70]).max() < 1e-12


def test_masses_of_the_chain_play_no_part():
    arm, x = lwr_dyn.load("lwr4plus"), states(7)
    bare = replace(arm.chain, links=tuple(replace(link, body=None, rotor=None) for link in arm.chain.links))
    assert (TorqueColumns(bare)(*x) == TorqueColumns(arm.chain)(*x)).all()


def test_base_parameters_carry_all_the_torque_and_are_named_in_full(wam):
    """A set with the same base gives the same torques."""
    columns, x = TorqueColumns(wam.chain, "directions"), states(7)
    base, full, Y = columns.base(), columns.own(wam), columns(*states(7))
    assert np.abs(Y[:, :, base.kept] @ base.of(full) - Y @ full).max() < 1e-11
    other = full + np.linalg.svd(base.grouping)[2][base.count :].T @ np.ones(full.size - base.count)
    assert np.abs(other - full).max() > 0.1
    assert np.abs(Y @ other - Y @ full).max() < 1e-11
    bodies = Regressor(lwr_dyn.load("lwr4plus").chain)
    rows = bodies(*x)[:, :, :70].reshape(-1, 70)
    assert base_parameters(rows, bodies.names[:70]).count == 43  # known for this structure, friction and rotors apart
    names = TorqueColumns(lwr_dyn.load("lwr4plus").chain).base().statements()
    assert names[1] == "mz_2 + 0.4 m_3 - my_3 + 0.4 m_4 + 0.4 m_5 + 0.4 m_6 + 0.4 m_7"  # d_3 is 0.4 m
    assert {"mx_2", *(f"coulomb_{j}" for j in range(1, 8))} <= set(names)


def test_motors_behind_a_transmission_rub_at_their_own_speeds():
    """tau = T^T tau_m, with tau_m the friction and rotor of every motor at dq_m = T dq."""
    arm = lwr_dyn.load("wam7")
    T = Transmission(
        np.eye(7) + np.diag([0.0, 0.5, 0.0, 0.0, -0.7, 0.0], 1) - np.diag([0.0, 0.5, 0.0, 0.0, 0.2, 0.0], -1)
    )
    columns = TorqueColumns(arm.chain, transmission=T)
    q, dq, ddq = states(7)
    pi = np.zeros(columns.count)
    pi[columns.bodies :] = np.random.default_rng(1).uniform(0.1, 1.0, columns.count - columns.bodies)
    speed, rate = T.motor_velocity(dq), T.motor_velocity(ddq)
    rotors = pi[columns.rotor_indices] * rate
    wanted = T.joint_torque(rotors + friction_torque(columns.friction_of(pi), speed))
    assert np.abs(columns(q, dq, ddq) @ pi - wanted).max() < 1e-12 * np.abs(wanted).max()
    assert columns.base().count == 43 + 6 + 21  # only the first motor's rotor merges with a link


@pytest.mark.slow
@pytest.mark.parametrize("transmission", [False, True])
def test_torques_without_the_columns_are_the_same(monkeypatch, transmission):
    arm, x = lwr_dyn.load("wam7"), states(7)
    columns = TorqueColumns(arm.chain, transmission=arm.transmission if transmission else None)
    pi = np.random.default_rng(2).normal(size=columns.count)  # no bodies: any numbers
    base = columns.base()
    wanted = columns(*x) @ pi
    assert columns.torques(*x, pi) == pytest.approx(wanted, abs=1e-11 * np.abs(wanted).max())
    monkeypatch.setattr(torque_columns, "MANY", 10)
    monkeypatch.setattr(torque_columns, "BLOCK", 16)
    assert columns.torques(*x, pi) == pytest.approx(wanted, abs=1e-11 * np.abs(wanted).max())
    assert columns.torques(*x, base.of(pi)) == pytest.approx(wanted, abs=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("form", ["symmetric", "directions"])
def test_friction_goes_there_and_back(form):
    model = JointFriction(Direction(3.0, 0.5, 4.0, 0.07), Direction(3.0, 0.5, 4.0, 0.07), 0.25)
    joint, dq = JointColumns(form, (0.07,)), np.linspace(-1.0, 1.0, 30)
    values = np.array(joint.values_of(model, 0.4))
    assert joint.friction_of(values).torque(dq) == pytest.approx(model.torque(dq), abs=1e-14)
    assert joint(dq, np.zeros(30)) @ values == pytest.approx(model.torque(dq), abs=1e-14)
    assert (values[0], values.size) == (0.4, len(joint.names))


def test_unequal_directions_are_a_mean_and_an_offset_and_levels_below_zero_are_zero():
    """Coulomb 4 up and 2 down is 3 both ways about an offset of 1: exact where the slopes are equal."""
    model, dq = JointFriction(Direction(4.0, 0.5), Direction(2.0, 0.5), 0.25), np.array([-0.7, 0.3])
    joint = JointColumns("symmetric")
    assert joint.values_of(model, 0.0) == [0.0, 3.0, 0.5, 1.25]
    assert joint(dq, 0 * dq) @ joint.values_of(model, 0.0) == pytest.approx(model.torque(dq))
    noisy = JointColumns("symmetric", (0.1,)).friction_of(np.array([0.0, -0.1, 0.5, 0.2, -0.3]))
    assert noisy == JointFriction(Direction(0.0, 0.5), Direction(0.0, 0.5), 0.2)
    two = JointColumns("directions").friction_of(np.array([0.0, 0.5, 1.0, -0.1, 1.0]))
    assert two.torque([-1.0, 1.0]) == pytest.approx([-0.9, 1.5])


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"friction": "dry"}, OptionError, "friction: 'dry'; allowed: symmetric, directions"),
        ({"stribeck_velocity": np.r_[np.zeros(1), np.ones(6)]}, OptionError, "0 of joint 1; allowed: above 0, or NaN"),
        ({"stribeck_velocity": [0.1, 0.1]}, ShapeError, "stribeck velocity: 2 numbers; allowed: 7 numbers"),
        ({"transmission": Transmission(np.eye(2))}, OptionError, "transmission: of 2 motors; allowed: 7"),
    ],
)
def test_columns_that_cannot_be(options, error, message):
    with pytest.raises(error, match=message):
        TorqueColumns(lwr_dyn.load("lwr4plus").chain, **options)


def test_torques_behind_the_gears_have_no_rotors():
    dq, ddq = np.linspace(-1.0, 1.0, 30), np.linspace(3.0, -2.0, 30)
    for form in ("symmetric", "directions"):
        behind, before = JointColumns(form, link_side=True)(dq, ddq), JointColumns(form)(dq, ddq)
        assert not behind[:, 0].any()
        np.testing.assert_array_equal(behind[:, 1:], before[:, 1:])
    arm = lwr_dyn.load("lwr4plus", "physical")
    columns = TorqueColumns(arm.chain, link_side=True)
    assert not np.isin(columns.rotor_indices, columns.base().kept).any()
    assert not columns.base().grouping[:, columns.rotor_indices].any()
