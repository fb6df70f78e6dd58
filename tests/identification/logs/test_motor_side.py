"""Logs of motors through a coupled transmission."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import lwr_dyn
from lwr_dyn.foundation.errors import LogError, MissingDataError, OptionError, ShapeError
from lwr_dyn.identification.logs.joint_log import JointLog, write_log
from lwr_dyn.identification.logs.motor_side import MotorMap, log_at_joints, motor_map
from lwr_dyn.identification.regression.information import information_of
from lwr_dyn.identification.regression.samples import SampleRule, samples_of
from lwr_dyn.identification.regression.torque_columns import TorqueColumns
from tests.identification.plants import Plant, random_motion, torques

ARM = lwr_dyn.load("wam7")
T = ARM.transmission.matrix
CONSTANT = np.array([0.05, 0.05, 0.05, 0.05, 0.012, 0.012, 0.02])
HOME = np.array([3.0, -1.0, 2.0, 0.5, 0.0, 1.0, -4.0])
MOTORS = motor_map(ARM, CONSTANT, HOME)


RULE = SampleRule(slowest=0.05 * np.linalg.norm(T, axis=1), transmission=ARM.transmission)


def motor_plant():
    """The WAM with friction and rotors at its motors, shared by the joints of a differential."""
    columns = TorqueColumns(ARM.chain, transmission=ARM.transmission)
    parameters = columns.own(ARM)
    rng = np.random.default_rng(4)
    for j, gear in enumerate(np.abs(T).max(axis=1)):
        sizes = np.array([ARM.armature[j] / gear**2, 1.0 / gear, 0.5 / gear**2, 0.1 / gear])
        parameters[columns.of_joint(j)] = sizes * np.exp(0.3 * rng.normal(size=4))
    return Plant(columns, parameters)


@pytest.fixture(scope="module")
def plant():
    return motor_plant()


def motor_log(plant, motion, noise, encoder, rng):
    """Encoders and currents of the motors: [rad] at the motors, noise of the shafts' torques [N m]."""
    tau = torques(plant.columns, plant.parameters, motion)
    shaft = np.linalg.solve(T.T, tau.T).T
    shaft += rng.normal(size=tau.shape) * noise
    turned = motion.q @ T.T + HOME + rng.normal(size=tau.shape) * encoder
    blank = np.full_like(tau, np.nan)
    return JointLog("motors", tuple(range(1, 8)), motion.t, blank, blank, motor_q=turned, current=shaft / CONSTANT)


def test_base_parameters_through_the_coupling_are_recovered(plant):
    """Recovery figure: bodies, rotors and friction of coupled motors, every z within 4.5 and their mean square 1."""
    rng = np.random.default_rng(5)
    motion = random_motion(ARM, 20.0, rng, rate=1000.0)
    log = log_at_joints(motor_log(plant, motion, 0.002 * np.ones(7), 1e-4, rng), MOTORS)
    found = information_of(samples_of([log], RULE), plant.columns)
    z = (found.values - plant.base) / found.sigma
    assert found.determined.all()
    assert np.abs(z).max() < 4.5
    assert 0.6 < np.mean(z**2) < 1.5


def test_columns_of_the_joints_alone_do_not_explain_friction_of_coupled_motors(plant):
    """What the transmission in the columns is for: without it the residual is many times the noise."""
    rng = np.random.default_rng(6)
    log = log_at_joints(motor_log(plant, random_motion(ARM, 10.0, rng, rate=1000.0), 0.0, 0.0, rng), MOTORS)
    samples = samples_of([log])
    coupled, apart = (information_of(samples, c).noise for c in (plant.columns, TorqueColumns(ARM.chain)))
    assert coupled[1:3].max() < 1e-3 * apart[1:3].min()


def test_what_goes_to_the_motors_and_back_is_the_joints():
    rng = np.random.default_rng(0)
    q, tau = rng.normal(size=(2, 5, 7))
    shaft = np.linalg.solve(T.T, tau.T).T
    log = JointLog("x", tuple(range(1, 8)), np.arange(5.0), q * np.nan, tau * np.nan, motor_q=q @ T.T + HOME,
                   current=shaft / CONSTANT)  # fmt: skip
    back = log_at_joints(log, MOTORS)
    assert back.q == pytest.approx(q, abs=1e-13)
    assert back.tau == pytest.approx(tau, abs=1e-13)
    torque = replace(log, tau=shaft, current=None)
    assert log_at_joints(torque, motor_map(ARM, home=HOME)).tau == pytest.approx(tau, abs=1e-13)


def test_power_is_equal_on_both_sides():
    rng = np.random.default_rng(1)
    motor_q, current = rng.normal(size=(2, 4, 7))
    log = JointLog("x", tuple(range(1, 8)), np.arange(4.0), np.zeros((4, 7)), np.zeros((4, 7)), motor_q=motor_q,
                   current=current)  # fmt: skip
    joints = log_at_joints(log, motor_map(ARM, CONSTANT))
    assert (joints.tau * joints.q).sum(axis=1) == pytest.approx((current * CONSTANT * motor_q).sum(axis=1))


def test_gears_stand_in_for_a_transmission_where_no_motors_are_coupled():
    arm = lwr_dyn.load("lwr4plus", "physical")
    ratios = [link.rotor.gear_ratio for link in arm.chain.links]
    assert np.array_equal(motor_map(arm).transmission.matrix, np.diag(ratios))


def test_bad_input_is_refused_with_what_is_needed():
    log = JointLog("m.csv", tuple(range(1, 8)), np.arange(3.0), np.zeros((3, 7)), np.zeros((3, 7)))
    with pytest.raises(LogError, match=r"m\.csv.*qm1\.\.qm7"):
        log_at_joints(log, MOTORS)
    turned = replace(log, motor_q=np.zeros((3, 7)))
    with pytest.raises(LogError, match="currents, for the torque constants"):
        log_at_joints(turned, MOTORS)
    with pytest.raises(LogError, match="torque constants"):
        log_at_joints(replace(turned, tau=log.tau * np.nan, current=np.ones((3, 7))), motor_map(ARM))
    with pytest.raises(OptionError, match="motor 2"):
        motor_map(ARM, [1.0, -1.0, 1, 1, 1, 1, 1])
    with pytest.raises(ShapeError):
        MotorMap(ARM.transmission, np.ones(3))
    bare = replace(ARM, transmission=None)
    with pytest.raises(MissingDataError, match="gear ratio"):
        motor_map(bare)


@pytest.mark.slow
def test_the_command_takes_logs_of_motors(plant, tmp_path, lwr_dyn_command):
    """`identify motion --motor-side`: base parameters as simulated, and what is missing is named in one line."""
    rng = np.random.default_rng(7)
    log = motor_log(plant, random_motion(ARM, 10.0, rng, rate=500.0), 0.002 * np.ones(7), 1e-4, rng)
    path = tmp_path / "motors.csv"
    write_log(path, log)
    numbers = (f"--torque-constant={','.join(map(str, CONSTANT))}", f"--motor-home={','.join(map(str, HOME))}")
    fit = ("identify", "motion", "wam7", str(path), "--fit-friction", "symmetric")
    code, out, _ = lwr_dyn_command(*fit, "--motor-side", *numbers, "--json")
    rows = json.loads(out)["parameters"]
    z = [(row["value"] - true) / row["standard_error"] for row, true in zip(rows, plant.base, strict=True)]
    assert code == 0
    assert np.abs(z).max() < 4.5
    code, out, err = lwr_dyn_command(*fit, "--motor-side", numbers[1])
    assert (code, out) == (2, "")
    assert "tau1" in err
    code, out, err = lwr_dyn_command(*fit, numbers[0])
    assert (code, out, "with --motor-side" in err) == (2, "", True)
